//! The concentric map of the square onto the unit disk and what is lifted from it: the cosine-weighted hemisphere and
//! the uniform cone · local frame, axis z · `[Shirley97]`, `[Malley88]`.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_4, PI};

use super::Warp;
use crate::math::{Dir3, Vec2, Vec3};
use crate::radiometry::{Area, Pdf, SolidAngle};

/// How far outside its range, relative to its size, a point may be by rounding and still count as inside.
const ROUNDING: f64 = 1e-9;

/// Smallest 1 − r² of a lifted disk point: the horizon is never reached, so that Jacobians stay finite.
const HORIZON: f64 = 2.0 * f64::EPSILON;

/// Uniform over the unit disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConcentricDisk;

impl Warp for ConcentricDisk {
    type Out = Vec2;
    type Tangent = Vec2;
    type Measure = Area;

    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Vec2, [Vec2; 2]) {
        let [a, b] = u.map(|x| 2.0 * x - 1.0);
        // Squares become circles: the larger coordinate is the signed radius r, the ratio the angle φ = (π/4) b/a. Then
        // ∂r/∂a = 1, r ∂φ/∂a = −φ, r ∂φ/∂b = π/4; a factor 2 from the square's size.
        let steep = a.abs() <= b.abs();
        let swapped = |v: Vec2| Vec2::new(v.y, v.x);
        let (r, other) = if steep { (b, a) } else { (a, b) };
        let phi = if r == 0.0 { 0.0 } else { FRAC_PI_4 * (other / r) };
        let (sin, cos) = phi.sin_cos();
        let out = Vec2::new(r * cos, r * sin);
        let along = 2.0 * Vec2::new(cos + phi * sin, sin - phi * cos);
        let across = 2.0 * FRAC_PI_4 * Vec2::new(-sin, cos);
        if steep { (swapped(out), [swapped(across), swapped(along)]) } else { (out, [along, across]) }
    }

    fn pdf(&self, x: Vec2) -> Pdf<Area> {
        Pdf::new(if x.length_squared() <= 1.0 + ROUNDING { FRAC_1_PI } else { 0.0 })
    }

    fn inverse(&self, x: Vec2) -> Option<[f64; 2]> {
        let r = x.length();
        if r == 0.0 {
            return Some([0.5; 2]);
        }
        let square = if x.x.abs() > x.y.abs() {
            let a = r.copysign(x.x);
            [a, a * (x.y / x.x).atan() / FRAC_PI_4]
        } else {
            let b = r.copysign(x.y);
            [b * (x.x / x.y).atan() / FRAC_PI_4, b]
        };
        (r <= 1.0 + ROUNDING).then(|| square.map(|a| (0.5 * (a + 1.0)).clamp(0.0, 1.0)))
    }
}

/// Density cos θ/π over the upper hemisphere: the concentric disk lifted straight up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CosineHemisphere;

/// Height of the hemisphere over a disk point.
fn lifted(disk: Vec2) -> f64 {
    let r = disk.length();
    ((1.0 - r) * (1.0 + r)).max(HORIZON).sqrt()
}

impl Warp for CosineHemisphere {
    type Out = Dir3;
    type Tangent = Vec3;
    type Measure = SolidAngle;

    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        let (disk, columns) = ConcentricDisk.sample_with_jacobian(u);
        let z = lifted(disk);
        (Dir3::from_unit(disk.extend(z)), columns.map(|d| d.extend(-disk.dot(d) / z)))
    }

    fn pdf(&self, w: Dir3) -> Pdf<SolidAngle> {
        Pdf::new(w.z.max(0.0) * FRAC_1_PI)
    }

    fn inverse(&self, w: Dir3) -> Option<[f64; 2]> {
        if w.z > 0.0 { ConcentricDisk.inverse(w.truncate()) } else { None }
    }
}

/// Uniform over the directions within an angle of z: the disk's r² becomes the cap's height, which keeps areas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformCone {
    /// 1 − cos of the half angle, in (0, 2).
    height: f64,
}

impl UniformCone {
    /// `cos_half_angle` in (−1, 1).
    pub fn from_cos(cos_half_angle: f64) -> UniformCone {
        UniformCone { height: 1.0 - cos_half_angle }
    }

    /// A cone narrower than the hemisphere from sin² of its half angle, exact for narrow cones too.
    pub fn from_sin_squared(sin_squared: f64) -> UniformCone {
        UniformCone { height: sin_squared / (1.0 + (1.0 - sin_squared).max(0.0).sqrt()) }
    }

    /// 1 − cos of the half angle.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Solid angle, sr.
    pub fn solid_angle(&self) -> f64 {
        2.0 * PI * self.height
    }

    /// ∂ω/∂h at fixed `u`, h = [`UniformCone::height`]: how the direction `w`, one of [`UniformCone::sample`]'s, moves when
    /// the cone opens. With w = (s x, s y, 1 − h r²) over the disk point (x, y) and s² = h (1 + w_z).
    pub fn height_derivative(&self, w: Dir3) -> Vec3 {
        let outward = w.z / (self.height * (1.0 + w.z).max(HORIZON));
        Vec3::new(w.x * outward, w.y * outward, (w.z - 1.0) / self.height)
    }
}

impl Warp for UniformCone {
    type Out = Dir3;
    type Tangent = Vec3;
    type Measure = SolidAngle;

    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        let (disk, columns) = ConcentricDisk.sample_with_jacobian(u);
        let r2 = disk.length_squared();
        // sin²θ = (1 − z)(1 + z) = h r² (2 − h r²) = r² s².
        let s = (self.height * (2.0 - self.height * r2).max(HORIZON)).sqrt();
        let column = |d: Vec2| {
            let dr2 = 2.0 * disk.dot(d);
            let ds = -0.5 * self.height * self.height / s * dr2;
            (s * d + ds * disk).extend(-self.height * dr2)
        };
        (Dir3::from_unit((s * disk).extend(1.0 - self.height * r2)), columns.map(column))
    }

    fn pdf(&self, w: Dir3) -> Pdf<SolidAngle> {
        Pdf::new(if self.inverse(w).is_some() { 1.0 / self.solid_angle() } else { 0.0 })
    }

    fn inverse(&self, w: Dir3) -> Option<[f64; 2]> {
        let s = (self.height * (1.0 + w.z)).sqrt();
        if s > 0.0 { ConcentricDisk.inverse(w.truncate() / s) } else { None }
    }
}
