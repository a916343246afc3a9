//! N numbers or N vectors side by side, one for each column, so that the same instructions act on all of them.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

use crate::math::Vec3;

/// One number a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const N: usize>(pub [f64; N]);

impl<const N: usize> Lanes<N> {
    pub fn sqrt(self) -> Lanes<N> {
        Lanes(self.0.map(f64::sqrt))
    }
    /// Whether no lane is infinite or NaN.
    pub fn is_finite(self) -> bool {
        // A sum of zeros unless a lane is not finite: one test instead of N.
        self.0.iter().map(|x| x * 0.0).sum::<f64>() == 0.0
    }
}

impl<const N: usize> Add for Lanes<N> {
    type Output = Lanes<N>;
    fn add(self, other: Lanes<N>) -> Lanes<N> {
        Lanes(from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl<const N: usize> Sub for Lanes<N> {
    type Output = Lanes<N>;
    fn sub(self, other: Lanes<N>) -> Lanes<N> {
        Lanes(from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl<const N: usize> Mul for Lanes<N> {
    type Output = Lanes<N>;
    fn mul(self, other: Lanes<N>) -> Lanes<N> {
        Lanes(from_fn(|k| self.0[k] * other.0[k]))
    }
}

impl<const N: usize> Mul<f64> for Lanes<N> {
    type Output = Lanes<N>;
    fn mul(self, s: f64) -> Lanes<N> {
        Lanes(self.0.map(|x| x * s))
    }
}

impl<const N: usize> Div<f64> for Lanes<N> {
    type Output = Lanes<N>;
    fn div(self, s: f64) -> Lanes<N> {
        Lanes(self.0.map(|x| x / s))
    }
}

/// One vector a column, component by component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vectors<const N: usize> {
    pub x: Lanes<N>,
    pub y: Lanes<N>,
    pub z: Lanes<N>,
}

impl<const N: usize> Vectors<N> {
    pub const ZERO: Vectors<N> = Vectors { x: Lanes([0.0; N]), y: Lanes([0.0; N]), z: Lanes([0.0; N]) };

    pub fn new(vectors: [Vec3; N]) -> Vectors<N> {
        Vectors { x: Lanes(vectors.map(|v| v.x)), y: Lanes(vectors.map(|v| v.y)), z: Lanes(vectors.map(|v| v.z)) }
    }
    /// The multiples `s` of one vector.
    pub fn multiples(v: Vec3, s: Lanes<N>) -> Vectors<N> {
        Vectors { x: s * v.x, y: s * v.y, z: s * v.z }
    }
    pub fn get(&self, k: usize) -> Vec3 {
        Vec3::new(self.x.0[k], self.y.0[k], self.z.0[k])
    }
    /// The first M ≤ N of them.
    pub fn first<const M: usize>(&self) -> Vectors<M> {
        let lanes = |of: Lanes<N>| Lanes(from_fn(|k| of.0[k]));
        Vectors { x: lanes(self.x), y: lanes(self.y), z: lanes(self.z) }
    }
    pub fn to_array(&self) -> [Vec3; N] {
        from_fn(|k| self.get(k))
    }
    pub fn dot(&self, v: Vec3) -> Lanes<N> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
    pub fn length_squared(&self) -> Lanes<N> {
        self.x * self.x + self.y * self.y + self.z * self.z
    }
    /// M v of each.
    pub fn transformed(&self, m: &glam::DMat3) -> Vectors<N> {
        let row = |x: f64, y: f64, z: f64| self.x * x + self.y * y + self.z * z;
        let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
        Vectors { x: row(a.x, b.x, c.x), y: row(a.y, b.y, c.y), z: row(a.z, b.z, c.z) }
    }
    /// Each vector times its own number.
    pub fn scaled_each(&self, s: Lanes<N>) -> Vectors<N> {
        Vectors { x: self.x * s, y: self.y * s, z: self.z * s }
    }
    pub fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }
}

impl<const N: usize> Add for Vectors<N> {
    type Output = Vectors<N>;
    fn add(self, other: Vectors<N>) -> Vectors<N> {
        Vectors { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<const N: usize> Sub for Vectors<N> {
    type Output = Vectors<N>;
    fn sub(self, other: Vectors<N>) -> Vectors<N> {
        Vectors { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<const N: usize> Mul<f64> for Vectors<N> {
    type Output = Vectors<N>;
    fn mul(self, s: f64) -> Vectors<N> {
        Vectors { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}
