//! Samples that the film did not take, with the place they came from: nothing is clamped or dropped in silence.

use serde::{Deserialize, Serialize};

use super::exact::LARGEST;
use super::layer::EyeSample;
use crate::radiometry::Spectrum;

/// Why a sample was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Cause {
    NotANumber,
    /// Infinite, or larger than [`LARGEST`].
    TooLarge,
    /// A radiometric value below zero.
    Negative,
}

/// One refused sample; they are ordered by pass, then row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct RefusedSample {
    pub pass: u32,
    pub y: u32,
    pub x: u32,
    pub cause: Cause,
}

/// How many samples were refused, and the first of them in the order of passes and pixels.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refused {
    pub not_a_number: u64,
    pub too_large: u64,
    pub negative: u64,
    pub first: Vec<RefusedSample>,
}

/// Places that are remembered: enough to replay one, few enough for a report.
const REMEMBERED: usize = 16;

impl Refused {
    pub fn total(&self) -> u64 {
        self.not_a_number + self.too_large + self.negative
    }

    pub(super) fn record(&mut self, sample: RefusedSample) {
        match sample.cause {
            Cause::NotANumber => self.not_a_number += 1,
            Cause::TooLarge => self.too_large += 1,
            Cause::Negative => self.negative += 1,
        }
        self.remember(&[sample]);
    }

    pub(super) fn merge(&mut self, other: &Refused) {
        self.not_a_number += other.not_a_number;
        self.too_large += other.too_large;
        self.negative += other.negative;
        self.remember(&other.first);
    }

    /// The first of a sum of lists are the first of the lists' first ones, in whatever order they come.
    fn remember(&mut self, samples: &[RefusedSample]) {
        self.first.extend(samples);
        self.first.sort_unstable();
        self.first.truncate(REMEMBERED);
    }
}

/// `Err` names what is wrong with a number that must be finite, and not negative if `signed` is false.
fn check(value: f64, signed: bool) -> Result<(), Cause> {
    if value.is_nan() {
        Err(Cause::NotANumber)
    } else if value.abs() > LARGEST {
        Err(Cause::TooLarge)
    } else if value < 0.0 && !signed {
        Err(Cause::Negative)
    } else {
        Ok(())
    }
}

pub(super) fn check_spectrum(value: Spectrum) -> Result<(), Cause> {
    value.to_array().into_iter().try_for_each(|v| check(v, false))
}

pub(super) fn check_sample(sample: &EyeSample) -> Result<(), Cause> {
    for part in [sample.direct, sample.caustic, sample.indirect, sample.albedo] {
        check_spectrum(part)?;
    }
    check_spectrum(sample.radiance())?;
    check(sample.photon_density, false)?;
    check(sample.depth.unwrap_or(0.0), true)?;
    sample.normal.to_array().into_iter().try_for_each(|v| check(v, true))
}
