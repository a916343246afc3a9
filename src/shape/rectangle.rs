//! The rectangle · metres, object space · u along the half axis a, v along b.

use super::error::{ShapeError, direction, finite_point};
use super::{AreaSample, LocalSurface, Parametrisation, plane_hit};
use crate::differential::ShapeOperator;
use crate::math::{Bounds3, Normal3, Point3, Ray, Vec2, Vec3};

/// Largest |cos| between the half axes of a rectangle: what rounding in a scene file's decimals may leave.
const PERPENDICULAR: f64 = 1e-6;

/// The points centre + x a + y b, |x|, |y| ≤ 1; its normal is a × b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    centre: Point3,
    a: Vec3,
    b: Vec3,
    normal: Normal3,
}

impl Rectangle {
    /// # Errors
    /// Vectors that are not finite, half axes without length or more than 1e-6 off the perpendicular (what is less
    /// is taken out of `b`).
    pub fn new(centre: Point3, a: Vec3, b: Vec3) -> Result<Rectangle, ShapeError> {
        let centre = finite_point("centre", centre)?;
        let (x, _) = direction("half axis a", a)?;
        let (y, b_length) = direction("half axis b", b)?;
        let cosine = x.dot(y);
        if cosine.abs() > PERPENDICULAR {
            return Err(ShapeError::NotPerpendicular { first: "half axis a", second: "half axis b", cosine });
        }
        let y = (y - x * cosine).normalize();
        Ok(Rectangle { centre, a, b: y * b_length, normal: Normal3::from_unit(x.cross(y).normalize()) })
    }
    pub fn centre(&self) -> Point3 {
        self.centre
    }
    pub fn half_axes(&self) -> [Vec3; 2] {
        [self.a, self.b]
    }
    pub fn normal(&self) -> Normal3 {
        self.normal
    }

    /// Coordinates along the half axes, in [−1, 1] inside.
    fn local(&self, p: Point3) -> Vec2 {
        let d = p - self.centre;
        Vec2::new(d.dot(self.a) / self.a.length_squared(), d.dot(self.b) / self.b.length_squared())
    }

    pub(super) fn intersect(&self, ray: &Ray) -> Option<f64> {
        let t = plane_hit(ray, self.centre, self.normal.to_vec())?;
        let local = self.local(ray.at(t));
        (local.abs().max_element() <= 1.0).then_some(t)
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        let half = self.a.abs() + self.b.abs();
        Bounds3 { min: self.centre - half, max: self.centre + half }
    }

    pub(super) fn surface_at(&self, p: Point3) -> LocalSurface {
        let local = self.local(p);
        LocalSurface {
            p: self.centre + self.a * local.x + self.b * local.y,
            n: self.normal,
            shape: ShapeOperator::FLAT,
        }
    }

    pub(super) fn parametrisation_at(&self, p: Point3) -> Parametrisation {
        Parametrisation { uv: uv(self.local(p)), dpdu: 2.0 * self.a, dpdv: 2.0 * self.b }
    }

    pub(super) fn area(&self) -> f64 {
        4.0 * self.a.length() * self.b.length()
    }

    pub(super) fn sample_area(&self, [u, v]: [f64; 2]) -> AreaSample {
        AreaSample {
            p: self.centre + self.a * (2.0 * u - 1.0) + self.b * (2.0 * v - 1.0),
            n: self.normal,
            dpdu: 2.0 * self.a,
            dpdv: 2.0 * self.b,
        }
    }

    pub(super) fn inverse_area(&self, p: Point3) -> [f64; 2] {
        uv(self.local(p)).to_array()
    }
}

fn uv(local: Vec2) -> Vec2 {
    (local + Vec2::ONE) * 0.5
}
