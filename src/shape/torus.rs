//! The torus · metres, object space · u = φ/2π about the axis, v = ϑ/2π about the ring, from the outer equator.

use std::f64::consts::PI;

use super::error::{ShapeError, direction, finite_point, positive};
use super::roots::{Bracket, bernstein4, first_bracket, polish};
use super::{AreaSample, LocalSurface, Parametrisation, outer};
use crate::differential::ShapeOperator;
use crate::math::{Bounds3, Frame, Normal3, Point3, Ray, Vec2, Vec3};

/// The points at distance `minor` from a circle of radius `major`; its normal points away from that circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    centre: Point3,
    major: f64,
    minor: f64,
    /// `n` is the axis.
    frame: Frame,
}

/// Unit vectors at a point: along the ring, along the tube's circle, outward, from the axis to the ring's circle.
struct Tangents {
    along: Vec3,
    up: Vec3,
    n: Vec3,
    out: Vec3,
    /// Distance from the axis.
    around: f64,
}

impl Torus {
    /// # Errors
    /// A centre or axis that is not finite, an axis without length, radii that are not positive and finite, or a minor
    /// radius that is not less than the major one.
    pub fn new(centre: Point3, axis: Vec3, major: f64, minor: f64) -> Result<Torus, ShapeError> {
        let centre = finite_point("centre", centre)?;
        let (axis, _) = direction("axis", axis)?;
        let major = positive("major radius", major)?;
        let minor = positive("minor radius", minor)?;
        if minor >= major {
            return Err(ShapeError::SelfIntersecting { major, minor });
        }
        Ok(Torus { centre, major, minor, frame: Frame::from_unit(axis) })
    }
    pub fn centre(&self) -> Point3 {
        self.centre
    }
    pub fn axis(&self) -> Normal3 {
        Normal3::from_unit(self.frame.n)
    }
    pub fn major_radius(&self) -> f64 {
        self.major
    }
    pub fn minor_radius(&self) -> f64 {
        self.minor
    }

    pub(super) fn intersect(&self, ray: &Ray) -> Option<f64> {
        let origin = self.frame.to_local(ray.origin - self.centre);
        let direction = self.frame.to_local(ray.direction);
        let (near, far) = self.clip(origin, direction, ray.t_min, ray.t_max)?;
        // The quartic in s ∈ [0, 1] over the clipped piece, lengths in major radii: all numbers of order one.
        let p = (origin + direction * near) / self.major;
        let d = direction * ((far - near) / self.major);
        let mut quartic = self.quartic(p, d);
        let (start, start_slope) = self.signed_distance(p, d);
        // A ray that starts on the surface, as far as rounding can tell, has left it: that root is divided out.
        let leaves = near == ray.t_min && start.abs() < 8.0 * f64::EPSILON * (1.0 + p.length());
        if leaves {
            quartic = [quartic[1], quartic[2], quartic[3], quartic[4], 0.0];
        }
        let distance = |s: f64| if leaves && s == 0.0 { start_slope } else { self.signed_distance(p + d * s, d).0 };
        let s = first_bracket(bernstein4(quartic), &mut |Bracket { lo, hi }| {
            // Coefficients lose digits that the distance itself still has.
            let ends = [distance(lo), distance(hi)];
            let s = if ends[0] * ends[1] < 0.0 {
                polish(lo, hi, |s| self.signed_distance(p + d * s, d))
            } else if ends[0].abs() < ends[1].abs() {
                lo
            } else {
                hi
            };
            let t = near + (far - near) * s;
            (t > ray.t_min && t < ray.t_max).then_some(s)
        })?;
        Some(near + (far - near) * s)
    }

    /// The part of (t_min, t_max) inside the slab and the cylinder around the torus.
    fn clip(&self, o: Vec3, d: Vec3, t_min: f64, t_max: f64) -> Option<(f64, f64)> {
        // A little more than the bounds, so that a tangent at the border stays inside.
        const SLACK: f64 = 1.0 + 1e-9;
        let (mut near, mut far) = (t_min, t_max);
        let half = self.minor * SLACK;
        if d.z != 0.0 {
            let (a, b) = ((-half - o.z) / d.z, (half - o.z) / d.z);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        } else if o.z.abs() > half {
            return None;
        }
        let reach = (self.major + self.minor) * SLACK;
        let (o, d) = (o.truncate(), d.truncate());
        let a = d.length_squared();
        if a > 0.0 {
            let middle = -o.dot(d) / a;
            let apart = (o + d * middle).length();
            let half_chord = ((reach - apart) * (reach + apart) / a).max(0.0).sqrt();
            near = near.max(middle - half_chord);
            far = far.min(middle + half_chord);
        } else if o.length() > reach {
            return None;
        }
        (near < far && near.is_finite() && far.is_finite()).then_some((near, far))
    }

    /// Power coefficients of (|x|² + R² − r²)² − 4R²(x² + y²) along p + s d, in units R = 1.
    fn quartic(&self, p: Vec3, d: Vec3) -> [f64; 5] {
        let ratio = self.minor / self.major;
        let (dd, pd) = (d.length_squared(), p.dot(d));
        let k = p.length_squared() + (1.0 - ratio) * (1.0 + ratio);
        let (p, d) = (p.truncate(), d.truncate());
        [
            k * k - 4.0 * p.length_squared(),
            4.0 * pd * k - 8.0 * p.dot(d),
            2.0 * dd * k + 4.0 * pd * pd - 4.0 * d.length_squared(),
            4.0 * dd * pd,
            dd * dd,
        ]
    }

    /// Signed distance from the surface and its derivative along d, at a local point in units R = 1.
    fn signed_distance(&self, p: Vec3, d: Vec3) -> (f64, f64) {
        let around = p.truncate().length();
        let from_ring = Vec2::new(around - 1.0, p.z);
        let distance = from_ring.length();
        let d_around = if around > 0.0 { p.truncate().dot(d.truncate()) / around } else { 0.0 };
        (distance - self.minor / self.major, (from_ring.x * d_around + from_ring.y * d.z) / distance)
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        let half = super::disc_half_extent(self.frame.n, self.major) + Vec3::splat(self.minor);
        Bounds3 { min: self.centre - half, max: self.centre + half }
    }

    /// (u, v) of a point given in the torus's frame.
    fn uv(&self, local: Vec3) -> Vec2 {
        let around = local.truncate().length();
        Vec2::new(super::turn(local.y, local.x), super::turn(local.z, around - self.major))
    }

    pub(super) fn surface_at(&self, p: Point3) -> LocalSurface {
        let [spoke, meridian] = self.angles(self.frame.to_local(p - self.centre));
        let Tangents { along, up, n, out, around } = self.tangents(spoke, meridian);
        LocalSurface {
            p: self.centre + out * self.major + n * self.minor,
            n: Normal3::from_unit(n),
            // Principal curvatures of a surface of revolution: 1/r along the meridian, cos ϑ/(R + r cos ϑ) across.
            shape: ShapeOperator::from_matrix(
                outer(along, along) * (meridian.x / around) + outer(up, up) * (1.0 / self.minor),
            ),
        }
    }

    pub(super) fn parametrisation_at(&self, p: Point3) -> Parametrisation {
        let local = self.frame.to_local(p - self.centre);
        let [spoke, meridian] = self.angles(local);
        let Tangents { along, up, around, .. } = self.tangents(spoke, meridian);
        Parametrisation { uv: self.uv(local), dpdu: 2.0 * PI * around * along, dpdv: 2.0 * PI * self.minor * up }
    }

    /// Cosine and sine of the ring's and of the tube's angle at a point given in the torus's frame.
    fn angles(&self, local: Vec3) -> [Vec2; 2] {
        let spoke = local.truncate().try_normalize().unwrap_or(Vec2::X);
        let around = local.truncate().length();
        [spoke, Vec2::new(around - self.major, local.z).try_normalize().unwrap_or(Vec2::X)]
    }

    /// Where the ring's angle has the cosine and sine `spoke`, the tube's angle `meridian`.
    fn tangents(&self, spoke: Vec2, meridian: Vec2) -> Tangents {
        let out = self.frame.to_world(spoke.extend(0.0));
        Tangents {
            along: self.frame.n.cross(out),
            up: self.frame.n * meridian.x - out * meridian.y,
            n: out * meridian.x + self.frame.n * meridian.y,
            out,
            around: self.major + self.minor * meridian.x,
        }
    }

    pub(super) fn area(&self) -> f64 {
        4.0 * PI * PI * self.major * self.minor
    }

    /// u is the ring's angle; v is Kepler's mean anomaly of the tube's angle ϑ, 2πv = ϑ + (r/R) sin ϑ, which keeps area.
    pub(super) fn sample_area(&self, [u, v]: [f64; 2]) -> AreaSample {
        let ratio = self.minor / self.major;
        let mean = 2.0 * PI * v;
        let theta = polish(mean - ratio - 1e-9, mean + ratio + 1e-9, |t| {
            let (sin, cos) = t.sin_cos();
            (t + ratio * sin - mean, 1.0 + ratio * cos)
        });
        let (sin, cos) = (2.0 * PI * u).sin_cos();
        let meridian = Vec2::from_angle(theta);
        let Tangents { along, up, n, out, around } = self.tangents(Vec2::new(cos, sin), meridian);
        AreaSample {
            p: self.centre + out * self.major + n * self.minor,
            n: Normal3::from_unit(n),
            dpdu: 2.0 * PI * around * along,
            dpdv: 2.0 * PI * self.minor * up * (1.0 / (1.0 + ratio * meridian.x)),
        }
    }

    pub(super) fn inverse_area(&self, p: Point3) -> [f64; 2] {
        let uv = self.uv(self.frame.to_local(p - self.centre));
        let theta = 2.0 * PI * uv.y;
        [uv.x, (theta + self.minor / self.major * theta.sin()) / (2.0 * PI)]
    }
}
