//! Henyey and Greenstein's phase function · 1/sr · the frame's z is the way that light flew before the event ·
//! p(μ) = (1 − g²)/(4π (1 + g² − 2gμ)^(3/2)), μ the cosine of the turn `[Henyey41]`.
//!
//! The sampler is a warp of the concentric disk, whose r² is spread over the cumulative distribution: a quartet of low
//! distortion, smooth about the forward direction and about g = 0. With s = 1 − 2r², which is uniform in (−1, 1),
//! 1 − μ = (1 − g)² (1 − s)(2 + g + gs)/(2 (1 + gs)²), and 1 + μ likewise.

use std::f64::consts::PI;

use crate::math::{Dir3, Frame, Vec2, Vec3};
use crate::radiometry::{Pdf, SolidAngle};
use crate::sampling::warp::{ConcentricDisk, Warp};

/// Smallest 1 − r² of a disk point: straight back is never reached, so that Jacobians stay finite.
const RIM: f64 = 2.0 * f64::EPSILON;

/// A phase function with the mean cosine g in (−1, 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    g: f64,
}

impl HenyeyGreenstein {
    /// `g` in (−1, 1); the scene's assembly refuses others.
    pub fn new(g: f64) -> HenyeyGreenstein {
        HenyeyGreenstein { g }
    }

    /// p(μ), which is also the density of the sampler.
    pub fn value(&self, cos: f64) -> f64 {
        let g = self.g;
        // (1 + g² − 2gμ) without cancellation where it is small.
        let squared = if g > 0.0 {
            (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos)
        } else {
            (1.0 + g) * (1.0 + g) - 2.0 * g * (1.0 + cos)
        };
        (1.0 - g * g) / (4.0 * PI * squared * squared.sqrt())
    }

    /// The same for light that flew along `w` and goes on along `wi`.
    pub fn between(&self, w: Dir3, wi: Dir3) -> f64 {
        self.value(w.dot(wi).clamp(-1.0, 1.0))
    }

    /// Whither light goes on that flew along `w`, and the density, which is the value, too.
    pub fn turn(&self, w: Dir3, u: [f64; 2]) -> (Dir3, Pdf<SolidAngle>) {
        let local = self.sample(u);
        let wi = Frame::from_unit(w).to_world(local.to_vec());
        let wi = Dir3::from_unit(wi * (1.5 - 0.5 * wi.length_squared()));
        (wi, Pdf::new(self.value(local.z)))
    }
}

impl Warp for HenyeyGreenstein {
    type Out = Dir3;
    type Tangent = Vec3;
    type Measure = SolidAngle;

    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        let g = self.g;
        let (disk, columns) = ConcentricDisk.sample_with_jacobian(u);
        let r = disk.length();
        let half = ((1.0 - r) * (1.0 + r)).max(RIM);
        let s = 2.0 * half - 1.0;
        let (stretch, a) = (1.0 + g * s, 2.0 + g * s);
        // From the pole that is the nearer one for most directions.
        let cos = if g >= 0.0 {
            1.0 - (1.0 - g) * (1.0 - g) * r * r * (a + g) / (stretch * stretch)
        } else {
            (1.0 + g) * (1.0 + g) * half * (a - g) / (stretch * stretch) - 1.0
        };
        // sin = r q(s), q = (1 − g²) √A/(1 + gs)², A = (1 + s)/2 ((2 + gs)² − g²).
        let b = (a - g) * (a + g);
        let root = (half * b).sqrt();
        let narrow = 1.0 - g * g;
        let q = narrow * root / (stretch * stretch);
        let root_ds = (0.5 * b + 2.0 * half * g * a) / (2.0 * root);
        let q_ds = narrow * (root_ds - 2.0 * g * root / stretch) / (stretch * stretch);
        let cos_ds = narrow * narrow / (stretch * stretch * stretch);
        let column = |d: Vec2| {
            let ds = -4.0 * disk.dot(d);
            (d * q + disk * (q_ds * ds)).extend(cos_ds * ds)
        };
        (Dir3::from_unit((disk * q).extend(cos)), columns.map(column))
    }

    fn pdf(&self, w: Dir3) -> Pdf<SolidAngle> {
        Pdf::new(self.value(w.z))
    }

    fn inverse(&self, w: Dir3) -> Option<[f64; 2]> {
        let g = self.g;
        let across = w.truncate();
        // 1 − μ without cancellation near the pole.
        let m = if w.z > 0.0 { across.length_squared() / (1.0 + w.z) } else { 1.0 - w.z };
        let t = ((1.0 - g) * (1.0 - g) + 2.0 * g * m).sqrt();
        let squared = m * (1.0 + g) * (1.0 + g * (1.0 - g) / (t + 1.0 - g)) / (t * (1.0 - g * g + t));
        let r = squared.sqrt().min(1.0);
        let length = across.length();
        let towards = if length > 0.0 { across / length } else { Vec2::X };
        ConcentricDisk.inverse(towards * r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ p dω = 1 and ∫ p μ dω = g by the midpoint rule in s, in which p dω is uniform.
    #[test]
    fn the_mean_cosine_is_g() {
        for g in [-0.95, -0.5, -1e-9, 0.0, 0.3, 0.9] {
            let phase = HenyeyGreenstein::new(g);
            let n = 100_000;
            // Straight over μ: independent of the sampler.
            let (mut one, mut mean) = (0.0, 0.0);
            for i in 0..n {
                // Denser near the ends, where the function is steep.
                let x = (f64::from(i) + 0.5) / f64::from(n) * PI;
                let (cos, weight) = (x.cos(), 2.0 * PI * x.sin() * PI / f64::from(n));
                one += phase.value(cos) * weight;
                mean += phase.value(cos) * cos * weight;
            }
            // The rule's error is h²/24 times the range of the integrand's slope, at most 4 (1 + |g|)/(1 − |g|)³ here.
            let bound = (PI / f64::from(n)).powi(2) * 4.0 / (1.0 - g.abs()).powi(4);
            assert!((one - 1.0).abs() < bound && (mean - g).abs() < bound, "{g}: {one} {mean}");
        }
    }
}
