//! The open cylinder band · metres, object space · u = φ/2π about the axis, v from base (0) to top (1).

use std::f64::consts::PI;

use super::error::{ShapeError, direction, finite_point, positive};
use super::roots::{first_within, quadratic};
use super::{AreaSample, LocalSurface, Parametrisation, outer};
use crate::differential::ShapeOperator;
use crate::math::{Bounds3, Frame, Normal3, Point3, Ray, Vec2, Vec3};

/// The side of a circular cylinder, without caps; its normal points away from the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    base: Point3,
    radius: f64,
    length: f64,
    /// `n` is the axis, from base to top.
    frame: Frame,
}

impl Cylinder {
    /// # Errors
    /// Ends that are not finite or coincide, a radius that is not positive and finite.
    pub fn new(base: Point3, top: Point3, radius: f64) -> Result<Cylinder, ShapeError> {
        let base = finite_point("base", base)?;
        let top = finite_point("top", top)?;
        let (axis, length) = direction("axis from base to top", top - base)?;
        Ok(Cylinder { base, radius: positive("radius", radius)?, length, frame: Frame::from_unit(axis) })
    }
    pub fn base(&self) -> Point3 {
        self.base
    }
    pub fn top(&self) -> Point3 {
        self.base + self.frame.n * self.length
    }
    pub fn radius(&self) -> f64 {
        self.radius
    }

    fn height(&self, p: Point3) -> f64 {
        (p - self.base).dot(self.frame.n)
    }

    pub(super) fn intersect(&self, ray: &Ray) -> Option<f64> {
        let o = self.frame.project(ray.origin - self.base);
        let d = self.frame.project(ray.direction);
        let a = d.length_squared();
        // A ray along the axis meets the band nowhere or everywhere; neither is a hit.
        if a == 0.0 {
            return None;
        }
        let b = o.dot(d);
        let distance = o.length();
        let c = (distance - self.radius) * (distance + self.radius);
        let apart = (o - d * (b / a)).length();
        let disc = (self.radius - apart) * (self.radius + apart);
        let on_band = |t: f64| (0.0..=self.length).contains(&self.height(ray.at(t)));
        first_within(quadratic(a, b, c, disc)?, ray.t_min, ray.t_max, on_band)
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        let rim = super::disc_half_extent(self.frame.n, self.radius);
        let ends = [self.base, self.top()];
        Bounds3::from_points(ends.into_iter().flat_map(|p| [p - rim, p + rim]))
    }

    /// Unit vector from the axis to `p`.
    fn outward(&self, p: Point3) -> Vec3 {
        let across = self.frame.project(p - self.base);
        self.frame.to_world(across.extend(0.0)).try_normalize().unwrap_or(self.frame.t)
    }

    fn uv(&self, p: Point3) -> Vec2 {
        let across = self.frame.project(p - self.base);
        Vec2::new(super::turn(across.y, across.x), (self.height(p) / self.length).clamp(0.0, 1.0))
    }

    pub(super) fn surface_at(&self, p: Point3) -> LocalSurface {
        let axis = self.frame.n;
        let n = self.outward(p);
        LocalSurface {
            p: self.base + axis * self.height(p) + n * self.radius,
            n: Normal3::from_unit(n),
            shape: ShapeOperator::from_matrix(
                (glam::DMat3::IDENTITY - outer(axis, axis) - outer(n, n)) * (1.0 / self.radius),
            ),
        }
    }

    pub(super) fn parametrisation_at(&self, p: Point3) -> Parametrisation {
        Parametrisation {
            uv: self.uv(p),
            dpdu: 2.0 * PI * self.radius * self.frame.n.cross(self.outward(p)),
            dpdv: self.frame.n * self.length,
        }
    }

    pub(super) fn area(&self) -> f64 {
        2.0 * PI * self.radius * self.length
    }

    /// (u, v) of the surface itself keep area.
    pub(super) fn sample_area(&self, [u, v]: [f64; 2]) -> AreaSample {
        let (sin, cos) = (2.0 * PI * u).sin_cos();
        let n = self.frame.t * cos + self.frame.b * sin;
        let axis = self.frame.n;
        AreaSample {
            p: self.base + axis * (v * self.length) + n * self.radius,
            n: Normal3::from_unit(n),
            dpdu: 2.0 * PI * self.radius * axis.cross(n),
            dpdv: axis * self.length,
        }
    }

    pub(super) fn inverse_area(&self, p: Point3) -> [f64; 2] {
        self.uv(p).to_array()
    }
}
