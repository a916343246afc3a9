//! How far the pass under way has come: which units were added, and what they say of each pixel so far.

use super::exact::ExactSum;

/// Kinds of work that add to a film. Within a pass each has units numbered from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exposure {
    /// Tiles of eye samples.
    Eye,
    /// Splats of light paths that set out towards what makes caustics.
    LightToCasters,
    /// Splats of light paths that set out everywhere.
    LightToAll,
}

impl Exposure {
    pub const ALL: [Exposure; 3] = [Exposure::Eye, Exposure::LightToCasters, Exposure::LightToAll];
}

/// A set of unit numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UnitSet {
    words: Vec<u64>,
}

impl UnitSet {
    pub fn insert(&mut self, unit: usize) {
        if unit / 64 >= self.words.len() {
            self.words.resize(unit / 64 + 1, 0);
        }
        self.words[unit / 64] |= 1 << (unit % 64);
    }
    pub fn contains(&self, unit: usize) -> bool {
        self.words.get(unit / 64).is_some_and(|word| word >> (unit % 64) & 1 == 1)
    }
    pub fn len(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }
    /// 64 units a word, the lowest bit first.
    pub fn words(&self) -> &[u64] {
        &self.words
    }
    pub fn from_words(words: Vec<u64>) -> UnitSet {
        UnitSet { words }
    }
}

/// The pass under way.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UnderWay {
    /// The luminance of each pixel in this pass.
    pub(super) luminance: Vec<ExactSum>,
    /// In the order of [`Exposure::ALL`].
    pub(super) added: [UnitSet; 3],
}

impl UnderWay {
    pub(super) fn new(pixels: usize) -> UnderWay {
        UnderWay { luminance: vec![ExactSum::default(); pixels], added: Default::default() }
    }
    pub(super) fn is_empty(&self) -> bool {
        self.added.iter().all(UnitSet::is_empty)
    }
}
