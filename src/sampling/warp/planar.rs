//! Uniform points on parallelograms and triangles · metres · `[Heitz19]`.

use super::Warp;
use crate::math::{Point3, Vec3};
use crate::radiometry::{Area, Pdf};

/// How far outside its range, relative to its size, a point may be by rounding and still count as inside.
const ROUNDING: f64 = 1e-9;

/// Coordinates of `d` along `a` and `b`, by least squares; the part of `d` off their plane is dropped.
fn coordinates(a: Vec3, b: Vec3, d: Vec3) -> [f64; 2] {
    let n = a.cross(b);
    let scale = 1.0 / n.length_squared();
    [d.cross(b).dot(n) * scale, a.cross(d).dot(n) * scale]
}

/// `c` if it is in [0, 1] but for rounding, clamped.
fn within_unit(c: [f64; 2]) -> Option<[f64; 2]> {
    c.iter().all(|&x| (-ROUNDING..=1.0 + ROUNDING).contains(&x)).then(|| c.map(|x| x.clamp(0.0, 1.0)))
}

/// Uniform over centre ± a ± b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallelogram {
    pub centre: Point3,
    /// Half axes, not parallel.
    pub a: Vec3,
    pub b: Vec3,
}

impl Parallelogram {
    /// m².
    pub fn area(&self) -> f64 {
        4.0 * self.a.cross(self.b).length()
    }
}

impl Warp for Parallelogram {
    type Out = Point3;
    type Tangent = Vec3;
    type Measure = Area;

    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Point3, [Vec3; 2]) {
        let point = self.centre + self.a * (2.0 * u[0] - 1.0) + self.b * (2.0 * u[1] - 1.0);
        (point, [2.0 * self.a, 2.0 * self.b])
    }
    fn pdf(&self, x: Point3) -> Pdf<Area> {
        Pdf::new(if self.inverse(x).is_some() { 1.0 / self.area() } else { 0.0 })
    }
    fn inverse(&self, x: Point3) -> Option<[f64; 2]> {
        within_unit(coordinates(self.a, self.b, x - self.centre).map(|c| 0.5 * (c + 1.0)))
    }
}

/// Uniform over a triangle. Piecewise linear and nearly undistorted, unlike the usual map by a square root, whose
/// derivative is infinite at a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    pub corners: [Point3; 3],
}

impl Triangle {
    fn edges(&self) -> [Vec3; 2] {
        [self.corners[1] - self.corners[0], self.corners[2] - self.corners[0]]
    }
    /// m².
    pub fn area(&self) -> f64 {
        let [e1, e2] = self.edges();
        0.5 * e1.cross(e2).length()
    }
}

impl Warp for Triangle {
    type Out = Point3;
    type Tangent = Vec3;
    type Measure = Area;

    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Point3, [Vec3; 2]) {
        let [e1, e2] = self.edges();
        // The smaller coordinate is shared out between both edges.
        let half = 0.5 * u[0].min(u[1]);
        let point = self.corners[0] + e1 * (u[0] - half) + e2 * (u[1] - half);
        (point, if u[0] < u[1] { [0.5 * (e1 - e2), e2] } else { [e1, 0.5 * (e2 - e1)] })
    }
    fn pdf(&self, x: Point3) -> Pdf<Area> {
        Pdf::new(if self.inverse(x).is_some() { 1.0 / self.area() } else { 0.0 })
    }
    fn inverse(&self, x: Point3) -> Option<[f64; 2]> {
        let [e1, e2] = self.edges();
        let [b1, b2] = coordinates(e1, e2, x - self.corners[0]);
        if b1 < -ROUNDING || b2 < -ROUNDING {
            return None;
        }
        let half = b1.min(b2);
        within_unit([b1 + half, b2 + half])
    }
}
