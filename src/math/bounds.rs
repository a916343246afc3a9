//! Axis-aligned boxes.

use super::transform::Transform;
use super::vector::{Point3, Vec3};

/// A box [min, max]; empty while `min > max` in some axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds3 {
    pub min: Point3,
    pub max: Point3,
}

impl Bounds3 {
    pub const EMPTY: Bounds3 = Bounds3 {
        min: Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        max: Point3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    pub fn from_points(points: impl IntoIterator<Item = Point3>) -> Bounds3 {
        points.into_iter().fold(Bounds3::EMPTY, Bounds3::including)
    }
    pub fn including(self, p: Point3) -> Bounds3 {
        Bounds3 { min: Point3::from_vec(self.min.min(*p)), max: Point3::from_vec(self.max.max(*p)) }
    }
    pub fn union(self, other: Bounds3) -> Bounds3 {
        Bounds3 { min: Point3::from_vec(self.min.min(*other.min)), max: Point3::from_vec(self.max.max(*other.max)) }
    }
    pub fn expanded(self, margin: f64) -> Bounds3 {
        Bounds3 { min: self.min - Vec3::splat(margin), max: self.max + Vec3::splat(margin) }
    }
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(*self.max).any()
    }
    pub fn diagonal(&self) -> Vec3 {
        self.max - self.min
    }
    /// Of its six faces, m².
    pub fn area(&self) -> f64 {
        let d = self.diagonal();
        2.0 * (d.x * d.y + d.y * d.z + d.z * d.x)
    }
    pub fn centre(&self) -> Point3 {
        Point3::from_vec((self.min.to_vec() + self.max.to_vec()) * 0.5)
    }
    pub fn corners(&self) -> [Point3; 8] {
        std::array::from_fn(|i| {
            let pick = |axis: usize, lo: f64, hi: f64| if i >> axis & 1 == 0 { lo } else { hi };
            Point3::new(
                pick(0, self.min.x, self.max.x),
                pick(1, self.min.y, self.max.y),
                pick(2, self.min.z, self.max.z),
            )
        })
    }
    /// The box around the eight transformed corners.
    pub fn transformed(&self, t: &Transform) -> Bounds3 {
        if self.is_empty() { *self } else { Bounds3::from_points(self.corners().map(|p| t.point(p))) }
    }
    /// Centre and radius of a sphere around the box.
    pub fn bounding_sphere(&self) -> (Point3, f64) {
        (self.centre(), 0.5 * self.diagonal().length())
    }
    /// Largest |coordinate| of each axis.
    pub fn farthest(&self) -> Point3 {
        Point3::from_vec(self.min.abs().max(self.max.abs()))
    }
    /// Largest |coordinate|, the scale of `f32` rounding inside the box.
    pub fn max_abs(&self) -> f64 {
        if self.is_empty() { 0.0 } else { self.min.abs().max(self.max.abs()).max_element() }
    }
}
