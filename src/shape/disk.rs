//! The disk · metres, object space · (u, v) = the point's place in the square around the disk.

use std::f64::consts::PI;

use super::error::{ShapeError, direction, finite_point, positive};
use super::{AreaSample, LocalSurface, Parametrisation, plane_hit};
use crate::differential::ShapeOperator;
use crate::math::{Bounds3, Frame, Normal3, Point3, Ray, Vec2, Vec3};
use crate::sampling::warp::{ConcentricDisk, Warp};

/// A flat round disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    centre: Point3,
    radius: f64,
    frame: Frame,
}

impl Disk {
    /// # Errors
    /// A centre or normal that is not finite, a normal without length, a radius that is not positive and finite.
    pub fn new(centre: Point3, normal: Vec3, radius: f64) -> Result<Disk, ShapeError> {
        let centre = finite_point("centre", centre)?;
        let (n, _) = direction("normal", normal)?;
        Ok(Disk { centre, radius: positive("radius", radius)?, frame: Frame::from_unit(n) })
    }
    pub fn centre(&self) -> Point3 {
        self.centre
    }
    pub fn radius(&self) -> f64 {
        self.radius
    }
    pub fn normal(&self) -> Normal3 {
        Normal3::from_unit(self.frame.n)
    }

    pub(super) fn intersect(&self, ray: &Ray) -> Option<f64> {
        let t = plane_hit(ray, self.centre, self.frame.n)?;
        let local = self.frame.project(ray.at(t) - self.centre);
        (local.length_squared() <= self.radius * self.radius).then_some(t)
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        let rim = super::disc_half_extent(self.frame.n, self.radius);
        Bounds3 { min: self.centre - rim, max: self.centre + rim }
    }

    pub(super) fn surface_at(&self, p: Point3) -> LocalSurface {
        let local = self.frame.project(p - self.centre);
        LocalSurface {
            p: self.centre + self.frame.to_world(local.extend(0.0)),
            n: self.normal(),
            shape: ShapeOperator::FLAT,
        }
    }

    pub(super) fn parametrisation_at(&self, p: Point3) -> Parametrisation {
        Parametrisation {
            uv: (self.frame.project(p - self.centre) / self.radius + Vec2::ONE) * 0.5,
            dpdu: self.frame.t * (2.0 * self.radius),
            dpdv: self.frame.b * (2.0 * self.radius),
        }
    }

    pub(super) fn area(&self) -> f64 {
        PI * self.radius * self.radius
    }

    pub(super) fn sample_area(&self, u: [f64; 2]) -> AreaSample {
        let in_plane = |v: Vec2| self.frame.to_world(v.extend(0.0)) * self.radius;
        let (p, [du, dv]) = ConcentricDisk.sample_with_jacobian(u);
        AreaSample { p: self.centre + in_plane(p), n: self.normal(), dpdu: in_plane(du), dpdv: in_plane(dv) }
    }

    pub(super) fn inverse_area(&self, p: Point3) -> Option<[f64; 2]> {
        ConcentricDisk.inverse(self.frame.project(p - self.centre) / self.radius)
    }
}
