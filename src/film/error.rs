//! How well the mean of the passes is known, from how much they differ: standard errors, intervals, one number for all.
//!
//! Passes are independent and alike but for the slow narrowing of footprints, so the standard error of a pixel's mean of
//! n passes is √(s²/n) with s² their sample variance, and Student's distribution with n − 1 degrees of freedom gives the
//! interval. It says how the mean scatters, not how far the estimate is biased.

use super::exact::{ExactSquares, ExactSum};
use crate::math::student;

/// Sums of a pixel's luminance over passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moments {
    pub(super) sum: ExactSum,
    pub(super) squares: ExactSquares,
}

impl Moments {
    pub(super) fn add(&mut self, luminance: f64) {
        self.sum.add(luminance);
        self.squares.add_square_of(luminance);
    }
    pub(super) fn merge(&mut self, other: &Moments) {
        self.sum.merge(other.sum);
        self.squares.merge(other.squares);
    }
    /// Of `passes` passes; none of fewer than two.
    pub(super) fn mean_error(&self, passes: u32) -> Option<MeanError> {
        let n = f64::from(passes);
        let mean = self.sum.value() / n;
        // Both sums are exact, so what cancels here is the rounding of two numbers: variances below 10⁻¹⁵ of the mean's
        // square are noise.
        let variance = ((self.squares.value() - n * mean * mean) / (n - 1.0)).max(0.0);
        (passes > 1).then(|| MeanError { mean, standard_error: (variance / n).sqrt(), passes })
    }
}

/// A pixel's mean luminance and its standard error, W/(m²·sr).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanError {
    pub mean: f64,
    pub standard_error: f64,
    pub passes: u32,
}

impl MeanError {
    /// Half the width of the interval around the mean that holds the estimate's expectation in 95 % of cases.
    pub fn half_width(&self) -> f64 {
        student::quantile(self.passes as usize - 1) * self.standard_error
    }
}

/// How noisy a picture is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// √ of the mean over all pixels of (standard error / (luminance + a tenth of the picture's mean luminance))².
    pub relative: f64,
    pub passes: u32,
}

/// What keeps dark pixels from counting more than one sees of them, in mean luminances.
const FLOOR: f64 = 0.1;

impl Noise {
    /// None of fewer than two passes or without light.
    pub(super) fn of(pixels: &[Moments], passes: u32) -> Option<Noise> {
        let known = || pixels.iter().filter_map(|pixel| pixel.mean_error(passes));
        let n = pixels.len() as f64;
        let floor = FLOOR * known().map(|pixel| pixel.mean).sum::<f64>() / n;
        let square = |pixel: MeanError| (pixel.standard_error / (pixel.mean + floor)).powi(2);
        (passes > 1 && floor > 0.0).then(|| Noise { relative: (known().map(square).sum::<f64>() / n).sqrt(), passes })
    }
}
