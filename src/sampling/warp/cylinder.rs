//! The equal-area map of the square onto the sphere by Archimedes' cylinder, that of a lat-long image · local frame, axis z.

use std::f64::consts::PI;

use super::Warp;
use crate::math::{Dir3, Vec3};
use crate::radiometry::{Pdf, SolidAngle};

/// Uniform over the sphere of directions: the square's first coordinate goes once around the axis, clockwise seen from +z,
/// from −x over +y, +x and −y back to −x; the second from +z to −z, evenly in z. Its columns are a stretched pair: π sin²θ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderSphere;

/// The poles have no columns; so much of the square on either side is theirs.
const POLE: f64 = 1e-16;

impl Warp for CylinderSphere {
    type Out = Dir3;
    type Tangent = Vec3;
    type Measure = SolidAngle;

    fn sample_with_jacobian(&self, [s, t]: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        let t = t.clamp(POLE, 1.0 - POLE);
        let (sin, cos) = (PI * (1.0 - 2.0 * s)).sin_cos();
        let (r, z) = (2.0 * (t * (1.0 - t)).sqrt(), 1.0 - 2.0 * t);
        // dφ/ds = −2π; dz/dt = −2 and dr/dt = 2z/r, from r² + z² = 1.
        let around = Vec3::new(sin, -cos, 0.0) * (2.0 * PI * r);
        let down = Vec3::new(cos * z / r, sin * z / r, -1.0) * 2.0;
        (Dir3::from_unit(Vec3::new(r * cos, r * sin, z)), [around, down])
    }
    fn pdf(&self, _: Dir3) -> Pdf<SolidAngle> {
        Pdf::new(0.25 / PI)
    }
    fn inverse(&self, w: Dir3) -> Option<[f64; 2]> {
        let s = 0.5 * (1.0 - w.y.atan2(w.x) / PI);
        // (1 − |z|)/2 without cancellation near the poles.
        let t = 0.5 * (w.x * w.x + w.y * w.y) / (1.0 + w.z.abs());
        Some([s, if w.z < 0.0 { 1.0 - t } else { t }])
    }
}
