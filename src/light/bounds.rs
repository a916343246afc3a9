//! Where a light is, whither it sends and how much, in a few numbers [ContyKulla18]; for one light or for many together.
//!
//! World frame, metres, W. The light leaves the box from points whose normals lie within `spread` of the axis, into
//! directions within `reach` of these normals. Every bound is conservative: [`LightBounds::importance`] is zero only where no
//! light arrives.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::math::{Bounds3, Dir3, Normal3, Point3, Transform};

/// Where light is looked for from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    pub p: Point3,
    /// Shading normal of a surface; light from both of its sides counts. `None` in a medium.
    pub n: Option<Normal3>,
}

/// Directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalCone {
    pub axis: Dir3,
    /// Half angle, radians; π for all directions.
    pub spread: f64,
}

/// Bounds of a light, or of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    pub bounds: Bounds3,
    pub normals: NormalCone,
    /// How far from its normal a point sends, radians.
    pub reach: f64,
    /// Luminance of all that is sent, W.
    pub power: f64,
    /// Whether it sends to the normals' other side as well.
    pub two_sided: bool,
}

/// Cosines towards light and from it count as this at least: where a box is seen edge-on its middle says little.
const LEAST_COSINE: f64 = 0.05;
/// What rounding of angles may hide, radians.
const ROUNDING: f64 = 1e-6;

impl NormalCone {
    pub const SPHERE: NormalCone = NormalCone { axis: Dir3::Z, spread: PI };

    /// The cone around one direction.
    pub fn of(axis: Normal3) -> NormalCone {
        NormalCone { axis: axis.as_dir(), spread: 0.0 }
    }

    /// The narrowest cone around two.
    pub fn union(self, other: NormalCone) -> NormalCone {
        let between = self.axis.cross(other.axis).length().atan2(self.axis.dot(other.axis));
        if between + other.spread <= self.spread {
            return self;
        }
        if between + self.spread <= other.spread {
            return other;
        }
        let spread = 0.5 * (self.spread + between + other.spread);
        let Some(about) = Dir3::new(self.axis.cross(other.axis)) else { return NormalCone::SPHERE };
        let turned = Transform::rotate(about, spread - self.spread).vector(self.axis.to_vec());
        match Dir3::new(turned) {
            Some(axis) if spread < PI => NormalCone { axis, spread: spread + ROUNDING },
            _ => NormalCone::SPHERE,
        }
    }
}

impl LightBounds {
    pub fn union(self, other: LightBounds) -> LightBounds {
        LightBounds {
            bounds: self.bounds.union(other.bounds),
            normals: self.normals.union(other.normals),
            reach: self.reach.max(other.reach),
            power: self.power + other.power,
            two_sided: self.two_sided || other.two_sided,
        }
    }

    /// About what arrives from all of it, up to a factor that is the same for all bounds: the power over the squared
    /// distance, times the largest cosines at both ends that the bounds allow [ContyKulla18 (3)].
    pub fn importance(&self, at: &Receiver) -> f64 {
        let (centre, radius) = self.bounds.bounding_sphere();
        let away = at.p - centre;
        let distance = away.length();
        let Some(w) = Dir3::new(away).filter(|_| distance > radius) else {
            return self.power / (radius * radius).max(f64::MIN_POSITIVE.sqrt());
        };
        let seen = (radius / distance).min(1.0).asin() + ROUNDING;
        let mut cos_axis = self.normals.axis.dot(w);
        if self.two_sided {
            cos_axis = cos_axis.abs();
        }
        let leaving = (cos_axis.clamp(-1.0, 1.0).acos() - self.normals.spread - seen).max(0.0);
        if leaving > self.reach {
            return 0.0;
        }
        let arriving = at.n.map_or(0.0, |n| (n.dot(w).abs().min(1.0).acos() - seen).max(0.0));
        let [leaving, arriving] = [leaving, arriving].map(|angle| angle.cos().max(LEAST_COSINE));
        self.power * leaving * arriving / (distance * distance)
    }

    /// What it costs to have it for one: its power, its solid angle and its size [ContyKulla18 (1)]. The size is the squared
    /// diagonal and not the surface, which lamps in a row have none of.
    pub fn cost(&self) -> f64 {
        let (spread, width) = (self.normals.spread, (self.normals.spread + self.reach).min(PI));
        let (sin, cos) = spread.sin_cos();
        let rim = 2.0 * width * sin - (spread - 2.0 * width).cos() - 2.0 * spread * sin + cos;
        let solid_angle = 2.0 * PI * (1.0 - cos) + FRAC_PI_2 * rim;
        self.power * solid_angle * self.bounds.diagonal().length_squared()
    }
}
