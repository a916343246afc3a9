//! Cryptomatte: which objects or materials the eye's samples met first in each pixel, and how many of them `[Friedman15]`.
//!
//! A thing's id is the MurmurHash3 of its name, kept from being an `f32` that is none; a pixel's channels hold pairs of an id's
//! bits and its share of the samples, the largest share first. Samples are counted, so that any split of the work adds up to
//! the same numbers. A share is that of the samples of the pixel, which are drawn from the pixel's filter.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::layer::EyeSample;
use crate::scene::settings::Layer;

/// Pairs that a pixel's channels hold; of more things the smallest shares are left out.
pub const LEVELS: usize = 6;

/// What a matte tells apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    Object,
    Material,
}

impl Subject {
    pub(super) fn of(layer: Layer) -> Option<Subject> {
        match layer {
            Layer::CryptoObject => Some(Subject::Object),
            Layer::CryptoMaterial => Some(Subject::Material),
            _ => None,
        }
    }

    /// As other programs call such a layer.
    pub const fn name(self) -> &'static str {
        match self {
            Subject::Object => "CryptoObject",
            Subject::Material => "CryptoMaterial",
        }
    }
}

/// A matte and the names of the things that it tells apart, in the order of the scene's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Matte {
    pub subject: Subject,
    pub names: Arc<[String]>,
}

impl Matte {
    /// The number of what the sample met.
    pub(super) fn met(&self, sample: &EyeSample) -> Option<u32> {
        let met = sample.met?;
        Some(match self.subject {
            Subject::Object => met.object.0,
            Subject::Material => met.material.0,
        })
    }

    /// The channels of a matte, each with the value of every pixel. `taken` are the pixels' samples.
    pub(super) fn channels(&self, counts: &[Counts], taken: &[u64]) -> Vec<(String, Vec<f32>)> {
        let ids: Vec<u32> = self.names.iter().map(|name| id(name)).collect();
        let ranked: Vec<[(f32, f32); LEVELS]> =
            counts.iter().zip(taken).map(|(counts, &taken)| counts.ranked(&ids, taken)).collect();
        let channel = |i: usize| {
            let name = format!("{}{:02}.{}", self.subject.name(), i / 4, ["R", "G", "B", "A"][i % 4]);
            let value =
                |pairs: &[(f32, f32); LEVELS]| if i.is_multiple_of(2) { pairs[i / 2].0 } else { pairs[i / 2].1 };
            (name, ranked.iter().map(value).collect())
        };
        (0..2 * LEVELS).map(channel).collect()
    }
}

/// How many samples of a pixel met each thing first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts(pub(super) BTreeMap<u32, u64>);

impl Counts {
    pub(super) fn add(&mut self, thing: u32) {
        *self.0.entry(thing).or_default() += 1;
    }

    pub(super) fn merge(&mut self, other: &Counts) {
        other.0.iter().for_each(|(&thing, count)| *self.0.entry(thing).or_default() += count);
    }

    /// The greatest shares of `taken` samples, with the ids' bits; things of one name count together.
    fn ranked(&self, ids: &[u32], taken: u64) -> [(f32, f32); LEVELS] {
        let mut by_id: BTreeMap<u32, u64> = BTreeMap::new();
        for (&thing, count) in &self.0 {
            *by_id.entry(ids.get(thing as usize).copied().unwrap_or(0)).or_default() += count;
        }
        let mut pairs: Vec<(u32, u64)> = by_id.into_iter().collect();
        pairs.sort_by_key(|&(id, count)| (std::cmp::Reverse(count), id));
        let share = |count: u64| (count as f64 / taken.max(1) as f64) as f32;
        std::array::from_fn(|i| pairs.get(i).map_or((0.0, 0.0), |&(id, count)| (f32::from_bits(id), share(count))))
    }
}

/// A name's id: its hash, whose bits make a finite normal `f32`. Names of the same id are one thing.
pub fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    match hash >> 23 & 255 {
        0 | 255 => hash ^ 1 << 23,
        _ => hash,
    }
}

/// MurmurHash3, x86, 32 bits, seed 0 `[Appleby11]`.
pub fn murmur3(bytes: &[u8]) -> u32 {
    let mixed = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, tail) = bytes.as_chunks::<4>();
    let mut h = blocks.iter().fold(0u32, |h, block| {
        let h = (h ^ mixed(u32::from_le_bytes(*block))).rotate_left(13);
        h.wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let rest = tail.iter().rev().fold(0, |k, &byte| k << 8 | u32::from(byte));
    h ^= mixed(rest);
    h ^= bytes.len() as u32;
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As another implementation has it (mmh3 of the Python Package Index), for every length of the tail.
    #[test]
    fn the_hash_is_that_of_others() {
        for (text, hash) in [
            ("", 0),
            ("a", 0x3c25_69b2),
            ("aa", 0x3710_91a9),
            ("aaa", 0xb4d0_5fb7),
            ("aaaa", 0x7eee_d987),
            ("hello, world", 0x149b_bb7f),
            ("Hello, world!", 0xc036_3e43),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text:?}: {:#x}", murmur3(text.as_bytes()));
        }
    }

    #[test]
    fn ids_are_numbers() {
        for i in 0..100_000 {
            let id = f32::from_bits(id(&format!("object {i}")));
            assert!(id.is_normal(), "object {i}: {id}");
        }
    }
}
