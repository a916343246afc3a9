//! The equal-area octahedral map of the square onto the sphere and the hemisphere · local frame, axis z ·
//! `[Clarberg08]`.

use std::f64::consts::{FRAC_PI_4, PI};

use super::Warp;
use crate::math::{Dir3, Vec3};
use crate::radiometry::{Pdf, SolidAngle};

/// Signed square coordinates (a, b) in [−1, 1]² of one octahedral point, sorted out.
struct Octahedral {
    signs: [f64; 2],
    /// 1 on the upper hemisphere, −1 on the lower.
    side: f64,
    /// √(1 − |z|).
    r: f64,
    /// (|b| − |a|)/r in [−1, 1]; the angle within its quadrant is (π/4)(t + 1).
    t: f64,
}

impl Octahedral {
    fn new(a: f64, b: f64) -> Octahedral {
        let d = 1.0 - a.abs() - b.abs();
        let r = 1.0 - d.abs();
        let t = if r > 0.0 { ((b.abs() - a.abs()) / r).clamp(-1.0, 1.0) } else { 0.0 };
        let signs = [1.0f64.copysign(a), 1.0f64.copysign(b)];
        Octahedral { signs, side: if d < 0.0 { -1.0 } else { 1.0 }, r, t }
    }

    /// The direction with ∂direction/∂a and ∂direction/∂b.
    fn direction_with_derivatives(&self) -> (Vec3, [Vec3; 2]) {
        let (sin, cos) = (FRAC_PI_4 * (self.t + 1.0)).sin_cos();
        // sin θ = √(1 − z²) with |z| = 1 − r².
        let root = (2.0 - self.r * self.r).sqrt();
        let q = self.r * root;
        let direction =
            Vec3::new(self.signs[0] * q * cos, self.signs[1] * q * sin, self.side * (1.0 - self.r * self.r));
        // dr = ±(d|a| + d|b|), d sin θ = (2 − 2r²)/√(2 − r²) dr, sin θ dφ = (π/4) √(2 − r²) r dt.
        let radial = self.side * (2.0 - 2.0 * self.r * self.r) / root;
        let column = |own: f64| {
            let turning = FRAC_PI_4 * root * (own - self.t * self.side);
            Vec3::new(
                self.signs[0] * (radial * cos - turning * sin),
                self.signs[1] * (radial * sin + turning * cos),
                -2.0 * self.r,
            )
        };
        (direction, [column(-1.0) * self.signs[0], column(1.0) * self.signs[1]])
    }

    /// (a, b) of a unit vector.
    fn inverse(w: Vec3) -> [f64; 2] {
        // 1 − |z| without cancellation near the poles.
        let r = ((w.x * w.x + w.y * w.y) / (1.0 + w.z.abs())).sqrt().min(1.0);
        let t = if r > 0.0 { w.y.abs().atan2(w.x.abs()) / FRAC_PI_4 - 1.0 } else { 0.0 };
        let [a, b] = [0.5 * r * (1.0 - t), 0.5 * r * (1.0 + t)];
        let [a, b] = if w.z < 0.0 { [1.0 - b, 1.0 - a] } else { [a, b] };
        [a.copysign(w.x), b.copysign(w.y)]
    }
}

/// Uniform over the sphere of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformSphere;

impl Warp for UniformSphere {
    type Out = Dir3;
    type Tangent = Vec3;
    type Measure = SolidAngle;

    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        let [a, b] = u.map(|x| 2.0 * x - 1.0);
        let (direction, derivatives) = Octahedral::new(a, b).direction_with_derivatives();
        (Dir3::from_unit(direction), derivatives.map(|d| 2.0 * d))
    }
    fn pdf(&self, _: Dir3) -> Pdf<SolidAngle> {
        Pdf::new(0.25 / PI)
    }
    fn inverse(&self, w: Dir3) -> Option<[f64; 2]> {
        Some(Octahedral::inverse(w.to_vec()).map(|a| 0.5 * (a + 1.0)))
    }
}

/// Uniform over the upper hemisphere: the square, turned by 45° and shrunk, is the octahedron's upper half.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformHemisphere;

impl UniformHemisphere {
    fn octahedral(u: [f64; 2]) -> Octahedral {
        let mut point = Octahedral::new(u[0] - u[1], u[0] + u[1] - 1.0);
        // On the horizon rounding must not choose the lower side.
        point.side = 1.0;
        point
    }
}

impl Warp for UniformHemisphere {
    type Out = Dir3;
    type Tangent = Vec3;
    type Measure = SolidAngle;

    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        let (direction, [da, db]) = Self::octahedral(u).direction_with_derivatives();
        (Dir3::from_unit(direction), [da + db, db - da])
    }
    fn pdf(&self, w: Dir3) -> Pdf<SolidAngle> {
        Pdf::new(if w.z >= 0.0 { 0.5 / PI } else { 0.0 })
    }
    fn inverse(&self, w: Dir3) -> Option<[f64; 2]> {
        if w.z < 0.0 {
            return None;
        }
        let [a, b] = Octahedral::inverse(w.to_vec());
        Some([0.5 * (1.0 + a + b), 0.5 * (1.0 + b - a)].map(|u| u.clamp(0.0, 1.0)))
    }
}
