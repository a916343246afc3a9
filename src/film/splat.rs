//! Contributions of light paths that land anywhere on the film.
//!
//! A splat's value is what it adds to the pass's estimate of the mean radiance of a pixel, W/(m²·sr): the renderer
//! has divided by the number of light paths of the pass already. The film divides by the number of passes.

use super::PixelBounds;
use super::light::LightKind;
use super::refused::{Cause, Refused, RefusedSample, check_spectrum};
use crate::radiometry::Spectrum;
use crate::scene::camera::PixelFilter;

/// One light path's contribution to one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// Row by row within the part.
    pub(super) pixel: u32,
    pub(super) kind: LightKind,
    pub(super) value: Spectrum,
}

/// The splats of one work unit, in the order they were made.
#[derive(Clone, Debug)]
pub struct SplatBuffer {
    bounds: PixelBounds,
    pass: u32,
    filter: PixelFilter,
    pub(super) splats: Vec<Splat>,
    pub(super) refused: Refused,
}

/// Standard deviation and cut of [`PixelFilter::Gaussian`], pixels.
const GAUSSIAN_SIGMA: f64 = 0.5;
const GAUSSIAN_CUT: f64 = 1.5;
/// ∫ of the normal density from −3σ to 3σ: erf(3/√2).
const GAUSSIAN_INSIDE: f64 = 0.997_300_203_936_739_8;

/// The Gaussian pixel filter along one axis at `d` pixels from the pixel's centre; its integral is 1.
fn gaussian(d: f64) -> f64 {
    if d.abs() > GAUSSIAN_CUT {
        return 0.0;
    }
    let norm = GAUSSIAN_INSIDE * GAUSSIAN_SIGMA * std::f64::consts::TAU.sqrt();
    (-0.5 * (d / GAUSSIAN_SIGMA).powi(2)).exp() / norm
}

impl SplatBuffer {
    /// For the part `bounds` of a picture.
    pub fn new(bounds: PixelBounds, pass: u32, filter: PixelFilter) -> SplatBuffer {
        SplatBuffer { bounds, pass, filter, splats: Vec::new(), refused: Refused::default() }
    }

    /// Adds `value` at the film position (x, y), in pixels from the picture's top left corner; positions outside of the
    /// part add nothing.
    pub fn add_splat(&mut self, x: f64, y: f64, kind: LightKind, value: Spectrum) {
        let position = if x.is_nan() || y.is_nan() { Err(Cause::NotANumber) } else { Ok(()) };
        if let Err(cause) = position.and(check_spectrum(value)) {
            // A cast saturates and makes 0 of NaN, so every record names a pixel.
            self.refused.record(RefusedSample { x: x as u32, y: y as u32, pass: self.pass, cause });
            return;
        }
        match self.filter {
            PixelFilter::Box => self.push(x.floor(), y.floor(), kind, value),
            PixelFilter::Gaussian => {
                let first = |v: f64| (v - 0.5 - GAUSSIAN_CUT).ceil();
                for j in 0..4 {
                    for i in 0..4 {
                        let (px, py) = (first(x) + f64::from(i), first(y) + f64::from(j));
                        let weight = gaussian(x - px - 0.5) * gaussian(y - py - 0.5);
                        if weight > 0.0 {
                            self.push(px, py, kind, value * weight);
                        }
                    }
                }
            }
        }
    }

    fn push(&mut self, px: f64, py: f64, kind: LightKind, value: Spectrum) {
        let PixelBounds { x0, y0, x1, y1 } = self.bounds;
        let inside = (f64::from(x0)..f64::from(x1)).contains(&px) && (f64::from(y0)..f64::from(y1)).contains(&py);
        if inside {
            let pixel = (py as u32 - y0) * self.bounds.width() + (px as u32 - x0);
            self.splats.push(Splat { pixel, kind, value });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Arrival, Part};
    use crate::scene::GroupId;

    const DIRECT: LightKind = LightKind { part: Part::Direct, arrival: Arrival::Straight, group: GroupId::REST };

    /// Whatever the position, the pixels' weights are samples of a density whose integral over positions is 1: its
    /// mean over a fine grid of positions inside one pixel, summed over the pixels hit, is 1.
    #[test]
    fn gaussian_splats_keep_the_light() {
        let n = 64;
        let mut buffer = SplatBuffer::new(PixelBounds::whole([9, 9]), 0, PixelFilter::Gaussian);
        for j in 0..n {
            for i in 0..n {
                let at = |k: i32| 4.0 + (f64::from(k) + 0.5) / f64::from(n);
                buffer.add_splat(at(i), at(j), DIRECT, Spectrum::ONE);
            }
        }
        let total: f64 = buffer.splats.iter().map(|s| s.value.r()).sum::<f64>() / f64::from(n * n);
        // Midpoint rule over a density with a jump of g(1.5) = 0.009 at its two ends: error below 4·0.009/n.
        assert!((total - 1.0).abs() < 4.0 * gaussian(GAUSSIAN_CUT) / f64::from(n), "{total}");
    }

    #[test]
    fn splats_outside_add_nothing_and_bad_ones_are_counted() {
        let mut buffer = SplatBuffer::new(PixelBounds::whole([2, 2]), 3, PixelFilter::Box);
        for (x, y) in [(-0.1, 0.5), (0.5, 2.0), (1e300, 0.0)] {
            buffer.add_splat(x, y, DIRECT, Spectrum::ONE);
        }
        assert!(buffer.splats.is_empty());
        assert_eq!(buffer.refused.total(), 0);
        buffer.add_splat(1.5, f64::NAN, DIRECT, Spectrum::ONE);
        buffer.add_splat(1.5, 0.5, DIRECT, Spectrum::rgb(0.0, f64::NAN, 0.0));
        assert_eq!(buffer.refused.not_a_number, 2);
        assert_eq!((buffer.refused.first[0].x, buffer.refused.first[0].pass), (1, 3));
    }
}
