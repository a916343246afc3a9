//! Vector types that differ in how they transform.
//!
//! | type | what | transforms by |
//! | --- | --- | --- |
//! | [`Vec3`] | a displacement or derivative, any length | linear part M |
//! | [`Point3`] | a position, metres | M and the translation |
//! | [`Dir3`] | a unit direction | M, renormalised |
//! | [`Normal3`] | a unit surface normal | M⁻ᵀ, renormalised |
//!
//! `Dir3` and `Normal3` are unit by construction; their derivatives are plain `Vec3`.

use std::ops::{Add, AddAssign, Deref, Mul, Neg, Sub};

/// A displacement or a derivative; any length.
pub type Vec3 = glam::DVec3;
/// A pair of numbers: texture coordinates, tangent-plane coordinates, sample-space coordinates.
pub type Vec2 = glam::DVec2;
/// A point of a two-dimensional domain (raster, texture or sample space).
pub type Point2 = glam::DVec2;

/// A position in metres.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Point3(Vec3);

impl Point3 {
    pub const ORIGIN: Point3 = Point3(Vec3::ZERO);

    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Point3(Vec3::new(x, y, z))
    }
    pub const fn from_vec(v: Vec3) -> Self {
        Point3(v)
    }
    /// The displacement from the origin.
    pub const fn to_vec(self) -> Vec3 {
        self.0
    }
    pub fn from_f32(p: [f32; 3]) -> Self {
        Point3(Vec3::new(p[0].into(), p[1].into(), p[2].into()))
    }
    pub fn distance_squared(self, other: Point3) -> f64 {
        self.0.distance_squared(other.0)
    }
    pub fn distance(self, other: Point3) -> f64 {
        self.0.distance(other.0)
    }
    pub fn to_array(self) -> [f64; 3] {
        self.0.to_array()
    }
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }
}

impl Deref for Point3 {
    type Target = Vec3;
    fn deref(&self) -> &Vec3 {
        &self.0
    }
}
impl From<[f64; 3]> for Point3 {
    fn from(a: [f64; 3]) -> Self {
        Point3(Vec3::from_array(a))
    }
}
impl Sub for Point3 {
    type Output = Vec3;
    fn sub(self, rhs: Point3) -> Vec3 {
        self.0 - rhs.0
    }
}
impl Add<Vec3> for Point3 {
    type Output = Point3;
    fn add(self, rhs: Vec3) -> Point3 {
        Point3(self.0 + rhs)
    }
}
impl AddAssign<Vec3> for Point3 {
    fn add_assign(&mut self, rhs: Vec3) {
        self.0 += rhs;
    }
}
impl Sub<Vec3> for Point3 {
    type Output = Point3;
    fn sub(self, rhs: Vec3) -> Point3 {
        Point3(self.0 - rhs)
    }
}

/// The operations that unit directions and unit normals share.
macro_rules! unit_vector {
    ($name:ident) => {
        impl $name {
            pub const X: $name = $name(Vec3::X);
            pub const Y: $name = $name(Vec3::Y);
            pub const Z: $name = $name(Vec3::Z);

            /// `v` scaled to unit length, or `None` for a zero or non-finite vector.
            pub fn new(v: Vec3) -> Option<Self> {
                let length = v.length();
                (length > 0.0 && length.is_finite()).then(|| $name(v / length))
            }
            /// Takes a vector that the caller knows to be of unit length; checked in debug builds.
            pub fn from_unit(v: Vec3) -> Self {
                debug_assert!((v.length_squared() - 1.0).abs() < 1e-6, "not a unit vector: {v}");
                $name(v)
            }
            pub fn to_vec(self) -> Vec3 {
                self.0
            }
            pub fn dot(self, other: impl Into<Vec3>) -> f64 {
                self.0.dot(other.into())
            }
            pub fn cross(self, other: impl Into<Vec3>) -> Vec3 {
                self.0.cross(other.into())
            }
            pub fn to_array(self) -> [f64; 3] {
                self.0.to_array()
            }
        }
        impl Deref for $name {
            type Target = Vec3;
            fn deref(&self) -> &Vec3 {
                &self.0
            }
        }
        impl From<$name> for Vec3 {
            fn from(v: $name) -> Vec3 {
                v.0
            }
        }
        impl Neg for $name {
            type Output = $name;
            fn neg(self) -> $name {
                $name(-self.0)
            }
        }
        impl Mul<f64> for $name {
            type Output = Vec3;
            fn mul(self, s: f64) -> Vec3 {
                self.0 * s
            }
        }
        impl Mul<$name> for f64 {
            type Output = Vec3;
            fn mul(self, v: $name) -> Vec3 {
                v.0 * self
            }
        }
    };
}

/// A direction of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dir3(Vec3);
unit_vector!(Dir3);

/// A surface normal of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal3(Vec3);
unit_vector!(Normal3);

impl Normal3 {
    /// This normal or its opposite, whichever lies in the half space of `v`.
    pub fn face_forward(self, v: impl Into<Vec3>) -> Normal3 {
        if self.dot(v) < 0.0 { -self } else { self }
    }
    pub fn as_dir(self) -> Dir3 {
        Dir3(self.0)
    }
}
