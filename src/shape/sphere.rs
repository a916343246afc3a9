//! The sphere · metres, object space · u = φ/2π about z, v = θ/π from the pole at −z.

use std::f64::consts::PI;

use super::error::{ShapeError, finite_point, positive};
use super::roots::{first_within, quadratic};
use super::{AreaSample, LocalSurface, Parametrisation, outer};
use crate::differential::ShapeOperator;
use crate::math::{Bounds3, Dir3, Normal3, Point3, Ray, Vec2, Vec3};
use crate::sampling::warp::{UniformSphere, Warp};

/// A sphere; its normal points away from the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    centre: Point3,
    radius: f64,
}

impl Sphere {
    /// # Errors
    /// A centre that is not finite, a radius that is not positive and finite.
    pub fn new(centre: Point3, radius: f64) -> Result<Sphere, ShapeError> {
        Ok(Sphere { centre: finite_point("centre", centre)?, radius: positive("radius", radius)? })
    }
    pub fn centre(&self) -> Point3 {
        self.centre
    }
    pub fn radius(&self) -> f64 {
        self.radius
    }

    pub(super) fn intersect(&self, ray: &Ray) -> Option<f64> {
        let to_origin = ray.origin - self.centre;
        let a = ray.direction.length_squared();
        let b = to_origin.dot(ray.direction);
        let distance = to_origin.length();
        let c = (distance - self.radius) * (distance + self.radius);
        // R² − (distance of the ray from the centre)², which keeps its digits when the origin is far away
        // [Haines19].
        let nearest = to_origin - ray.direction * (b / a);
        let apart = nearest.length();
        let disc = (self.radius - apart) * (self.radius + apart);
        first_within(quadratic(a, b, c, disc)?, ray.t_min, ray.t_max, |_| true)
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        Bounds3::EMPTY.including(self.centre).expanded(self.radius)
    }

    /// Unit vector from the centre to `p`; +z for the centre itself.
    fn outward(&self, p: Point3) -> Vec3 {
        (p - self.centre).try_normalize().unwrap_or(Vec3::Z)
    }

    pub(super) fn surface_at(&self, p: Point3) -> LocalSurface {
        let n = self.outward(p);
        LocalSurface {
            p: self.centre + n * self.radius,
            n: Normal3::from_unit(n),
            shape: ShapeOperator::from_matrix((glam::DMat3::IDENTITY - outer(n, n)) * (1.0 / self.radius)),
        }
    }

    pub(super) fn parametrisation_at(&self, p: Point3) -> Parametrisation {
        let n = self.outward(p);
        let around = n.truncate().length();
        // At the poles, where φ means nothing, the meridian φ = 0 is taken.
        let (cos, sin) = if around > 0.0 { (n.x / around, n.y / around) } else { (1.0, 0.0) };
        Parametrisation {
            uv: Vec2::new(super::turn(n.y, n.x), around.atan2(-n.z) / PI),
            dpdu: 2.0 * PI * self.radius * Vec3::new(-n.y, n.x, 0.0),
            dpdv: PI * self.radius * Vec3::new(-n.z * cos, -n.z * sin, around),
        }
    }

    pub(super) fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }

    pub(super) fn sample_area(&self, u: [f64; 2]) -> AreaSample {
        let (n, [du, dv]) = UniformSphere.sample_with_jacobian(u);
        let n = n.normalize();
        AreaSample {
            p: self.centre + n * self.radius,
            n: Normal3::from_unit(n),
            dpdu: du * self.radius,
            dpdv: dv * self.radius,
        }
    }

    pub(super) fn inverse_area(&self, p: Point3) -> Option<[f64; 2]> {
        UniformSphere.inverse(Dir3::from_unit(self.outward(p)))
    }
}
