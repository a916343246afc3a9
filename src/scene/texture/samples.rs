//! Texels as they are kept: the bytes of the file with what they stand for, or numbers · linear Rec.709.

use std::borrow::Cow;
use std::ops::Range;

/// What each byte stands for in each of the three components.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve([[f32; 256]; 3]);

impl Curve {
    /// The value of a byte in a component.
    pub fn new(value: impl Fn(usize, u8) -> f32) -> Curve {
        Curve(std::array::from_fn(|c| std::array::from_fn(|byte| value(c, byte as u8))))
    }

    /// `f` of the component's number and what a byte stands for there.
    pub fn mapped(&self, f: impl Fn(usize, f32) -> f32) -> Curve {
        Curve(std::array::from_fn(|c| self.0[c].map(|x| f(c, x))))
    }

    /// That of one component, in all.
    pub fn of_component(&self, c: usize) -> Curve {
        Curve([self.0[c]; 3])
    }
}

/// Texels in their order. Grey ones hold one component for all three.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    GreyBytes(Vec<u8>),
    Bytes(Vec<[u8; 3]>),
    Grey(Vec<f32>),
    Colours(Vec<[f32; 3]>),
}

/// Which of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    GreyBytes,
    Bytes,
    Grey,
    Colours,
}

impl Kind {
    /// Bytes of a texel.
    pub fn size(self) -> usize {
        match self {
            Kind::GreyBytes => 1,
            Kind::Bytes => 3,
            Kind::Grey => 4,
            Kind::Colours => 12,
        }
    }

    /// Bytes of a texel of coarser levels, which are means.
    pub fn coarser_size(self) -> usize {
        match self {
            Kind::GreyBytes | Kind::Grey => Kind::Grey.size(),
            Kind::Bytes | Kind::Colours => Kind::Colours.size(),
        }
    }
}

impl Samples {
    /// Grey ones if all are grey.
    pub fn of_colours(colours: Vec<[f32; 3]>) -> Samples {
        let is_grey = |[r, g, b]: &[f32; 3]| r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits();
        if colours.iter().all(is_grey) {
            Samples::Grey(colours.iter().map(|texel| texel[0]).collect())
        } else {
            Samples::Colours(colours)
        }
    }

    pub(super) fn kind(&self) -> Kind {
        match self {
            Samples::GreyBytes(_) => Kind::GreyBytes,
            Samples::Bytes(_) => Kind::Bytes,
            Samples::Grey(_) => Kind::Grey,
            Samples::Colours(_) => Kind::Colours,
        }
    }

    /// Texels.
    pub fn len(&self) -> usize {
        match self {
            Samples::GreyBytes(all) => all.len(),
            Samples::Bytes(all) => all.len(),
            Samples::Grey(all) => all.len(),
            Samples::Colours(all) => all.len(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes that they take.
    pub(super) fn size(&self) -> u64 {
        (self.len() * self.kind().size()) as u64
    }

    /// The `k`th texel; of numbers the curve says nothing.
    pub(super) fn texel(&self, k: usize, Curve(curve): &Curve) -> [f32; 3] {
        match self {
            Samples::GreyBytes(all) => {
                let byte = usize::from(all[k]);
                [curve[0][byte], curve[1][byte], curve[2][byte]]
            }
            Samples::Bytes(all) => {
                let [r, g, b] = all[k].map(usize::from);
                [curve[0][r], curve[1][g], curve[2][b]]
            }
            Samples::Grey(all) => [all[k]; 3],
            Samples::Colours(all) => all[k],
        }
    }

    /// Some of them as they are written to a file, [`Kind::size`] bytes a texel.
    pub(super) fn to_bytes(&self, range: Range<usize>) -> Cow<'_, [u8]> {
        let of_numbers = |all: &[f32]| Cow::Owned(all.iter().flat_map(|x| x.to_le_bytes()).collect());
        match self {
            Samples::GreyBytes(all) => Cow::Borrowed(&all[range]),
            Samples::Bytes(all) => Cow::Borrowed(all[range].as_flattened()),
            Samples::Grey(all) => of_numbers(&all[range]),
            Samples::Colours(all) => of_numbers(all[range].as_flattened()),
        }
    }

    /// What was written by [`Samples::to_bytes`]; bytes of a texel that is not whole are left out.
    pub(super) fn from_bytes(kind: Kind, bytes: &[u8]) -> Samples {
        let number = |bytes: &[u8; 4]| f32::from_le_bytes(*bytes);
        match kind {
            Kind::GreyBytes => Samples::GreyBytes(bytes.to_vec()),
            Kind::Bytes => Samples::Bytes(bytes.as_chunks().0.to_vec()),
            Kind::Grey => Samples::Grey(bytes.as_chunks().0.iter().map(number).collect()),
            Kind::Colours => {
                let colour = |bytes: &[[u8; 4]; 3]| bytes.each_ref().map(number);
                Samples::Colours(bytes.as_chunks().0.as_chunks().0.iter().map(colour).collect())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_comes_back_bit_for_bit() {
        let numbers: Vec<f32> = (0..30).map(|i| (i as f32 * 0.37).exp() - 3.0).collect();
        let bytes: Vec<u8> = (0..30).map(|i| i * 8).collect();
        for samples in [
            Samples::GreyBytes(bytes.clone()),
            Samples::Bytes(bytes.as_chunks().0.to_vec()),
            Samples::Grey(numbers.clone()),
            Samples::Colours(numbers.as_chunks().0.to_vec()),
        ] {
            let written = samples.to_bytes(0..samples.len());
            assert_eq!(written.len() as u64, samples.size());
            assert_eq!(Samples::from_bytes(samples.kind(), &written), samples);
        }
    }

    #[test]
    fn only_what_is_grey_all_over_is_kept_as_grey() {
        let grey = vec![[0.25; 3], [0.5; 3]];
        assert_eq!(Samples::of_colours(grey.clone()), Samples::Grey(vec![0.25, 0.5]));
        // Zeros of both signs are equal, but not the same bits.
        for odd in [[0.5, 0.5, 0.25], [0.0, -0.0, 0.0]] {
            let mixed = [grey.clone(), vec![odd]].concat();
            assert_eq!(Samples::of_colours(mixed.clone()), Samples::Colours(mixed));
        }
    }
}
