//! Directions from a point towards where light is wanted · world frame, radians.

use super::Aim;
use crate::differential::Column;
use crate::math::{Dir3, Frame, Point3, Vec3};
use crate::radiometry::{Pdf, SolidAngle};
use crate::sampling::warp::{UniformCone, UniformSphere, Warp};

/// A cone of directions about an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    pub frame: Frame,
    pub warp: UniformCone,
}

/// The cone under which a sphere is seen from a point outside, and what it takes to move that point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SphereCone {
    pub cone: Cone,
    /// To the sphere's centre, m.
    distance: f64,
    sin_squared: f64,
}

impl SphereCone {
    /// `None` from inside the sphere.
    pub fn new(x: Point3, centre: Point3, radius: f64) -> Option<SphereCone> {
        let distance = x.distance(centre);
        let sin = radius / distance;
        if sin.is_nan() || sin >= 1.0 {
            return None;
        }
        let axis = Dir3::new(centre - x)?;
        let warp = UniformCone::from_sin_squared(sin * sin);
        Some(SphereCone { cone: Cone { frame: Frame::from_unit(axis), warp }, distance, sin_squared: sin * sin })
    }

    pub fn cos_half_angle(&self) -> f64 {
        (1.0 - self.sin_squared).sqrt()
    }

    /// The change of the direction `local`, in the cone's frame, over a fixed `u` when the point moves by `dx`: the axis
    /// turns, and the cone opens as the sphere comes nearer.
    pub fn turning(&self, local: Dir3, dx: Vec3) -> Vec3 {
        let axis = self.cone.frame.n;
        let approach = axis.dot(dx);
        let daxis = (axis * approach - dx) / self.distance;
        let axes = Frame::from_unit_derivative(axis, daxis);
        // sin² = r²/d², h = 1 − cos: dh = d(sin²)/(2 cos).
        let dheight = self.sin_squared * approach / (self.distance * self.cos_half_angle());
        let opening = self.cone.frame.to_world(self.cone.warp.height_derivative(local)) * dheight;
        axes[0] * local.x + axes[1] * local.y + axes[2] * local.z + opening
    }
}

/// How the direction over the sample `u` from `x` into the aim's cone changes as the aim's sphere goes by `step`: as if
/// `x` went the other way, but for `x` itself. Zero from inside the sphere.
pub(super) fn following(x: Point3, aim: &Aim, u: [f64; 2], step: Vec3) -> Column {
    let Aim::Sphere { centre, radius } = *aim else { return Column::ZERO };
    let turned = |towards: SphereCone| Column::direction(towards.turning(towards.cone.warp.sample(u), -step));
    SphereCone::new(x, centre, radius).map_or(Column::ZERO, turned)
}

impl Cone {
    pub fn sample(&self, u: [f64; 2]) -> Dir3 {
        self.frame.to_world_dir(self.warp.sample(u).to_vec())
    }
    pub fn inverse(&self, w: Dir3) -> Option<[f64; 2]> {
        self.warp.inverse(Dir3::from_unit(self.frame.to_local(w)))
    }
    pub fn contains(&self, w: Dir3) -> bool {
        self.inverse(w).is_some()
    }
    pub fn pdf(&self) -> Pdf<SolidAngle> {
        Pdf::new(1.0 / self.warp.solid_angle())
    }
    pub fn sample_with_jacobian(&self, u: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        let (local, columns) = self.warp.sample_with_jacobian(u);
        (self.frame.to_world_dir(local.to_vec()), columns.map(|d| self.frame.to_world(d)))
    }
}

/// All directions that can matter from a point, uniformly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Directions {
    Sphere,
    Cone(Cone),
}

impl Directions {
    /// From `x` to what `aim` wants; every direction from inside the aim's sphere.
    pub fn towards(x: Point3, aim: &Aim) -> Directions {
        match *aim {
            Aim::Everywhere => Directions::Sphere,
            Aim::Sphere { centre, radius } => {
                SphereCone::new(x, centre, radius).map_or(Directions::Sphere, |c| Directions::Cone(c.cone))
            }
        }
    }

    pub fn solid_angle(&self) -> f64 {
        match self {
            Directions::Sphere => 4.0 * std::f64::consts::PI,
            Directions::Cone(cone) => cone.warp.solid_angle(),
        }
    }
    pub fn contains(&self, w: Dir3) -> bool {
        self.inverse(w).is_some()
    }
    pub fn sample(&self, u: [f64; 2]) -> Dir3 {
        match self {
            Directions::Sphere => UniformSphere.sample(u),
            Directions::Cone(cone) => cone.sample(u),
        }
    }
    pub fn pdf(&self) -> Pdf<SolidAngle> {
        Pdf::new(1.0 / self.solid_angle())
    }
    pub fn inverse(&self, w: Dir3) -> Option<[f64; 2]> {
        match self {
            Directions::Sphere => UniformSphere.inverse(w),
            Directions::Cone(cone) => cone.inverse(w),
        }
    }
    pub fn sample_with_jacobian(&self, u: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        match self {
            Directions::Sphere => UniformSphere.sample_with_jacobian(u),
            Directions::Cone(cone) => cone.sample_with_jacobian(u),
        }
    }
}
