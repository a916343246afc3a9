//! Three linear Rec.709 components, D65 white.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

use crate::math::Vec3;

/// A spectral weight, reflectance or the number inside a radiometric quantity: linear Rec.709 (r, g, b).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Spectrum(Vec3);

impl Spectrum {
    pub const BLACK: Spectrum = Spectrum(Vec3::ZERO);
    pub const ONE: Spectrum = Spectrum(Vec3::ONE);

    pub const fn rgb(r: f64, g: f64, b: f64) -> Self {
        Spectrum(Vec3::new(r, g, b))
    }
    pub const fn splat(v: f64) -> Self {
        Spectrum(Vec3::splat(v))
    }
    pub fn r(self) -> f64 {
        self.0.x
    }
    pub fn g(self) -> f64 {
        self.0.y
    }
    pub fn b(self) -> f64 {
        self.0.z
    }
    pub fn to_array(self) -> [f64; 3] {
        self.0.to_array()
    }
    /// Relative luminance Y of the Rec.709 primaries `[BT709]`.
    pub fn luminance(self) -> f64 {
        self.0.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }
    pub fn max_component(self) -> f64 {
        self.0.max_element()
    }
    pub fn min_component(self) -> f64 {
        self.0.min_element()
    }
    pub fn mean(self) -> f64 {
        self.0.element_sum() / 3.0
    }
    pub fn is_black(self) -> bool {
        self.0 == Vec3::ZERO
    }
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }
    /// Applies `f` to each component.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Spectrum {
        Spectrum(Vec3::new(f(self.0.x), f(self.0.y), f(self.0.z)))
    }
}

impl From<[f64; 3]> for Spectrum {
    fn from(a: [f64; 3]) -> Self {
        Spectrum(Vec3::from_array(a))
    }
}
impl Add for Spectrum {
    type Output = Spectrum;
    fn add(self, rhs: Spectrum) -> Spectrum {
        Spectrum(self.0 + rhs.0)
    }
}
impl AddAssign for Spectrum {
    fn add_assign(&mut self, rhs: Spectrum) {
        self.0 += rhs.0;
    }
}
impl Sub for Spectrum {
    type Output = Spectrum;
    fn sub(self, rhs: Spectrum) -> Spectrum {
        Spectrum(self.0 - rhs.0)
    }
}
impl Mul for Spectrum {
    type Output = Spectrum;
    fn mul(self, rhs: Spectrum) -> Spectrum {
        Spectrum(self.0 * rhs.0)
    }
}
impl MulAssign for Spectrum {
    fn mul_assign(&mut self, rhs: Spectrum) {
        self.0 *= rhs.0;
    }
}
impl Mul<f64> for Spectrum {
    type Output = Spectrum;
    fn mul(self, s: f64) -> Spectrum {
        Spectrum(self.0 * s)
    }
}
impl MulAssign<f64> for Spectrum {
    fn mul_assign(&mut self, s: f64) {
        self.0 *= s;
    }
}
impl Mul<Spectrum> for f64 {
    type Output = Spectrum;
    fn mul(self, s: Spectrum) -> Spectrum {
        s * self
    }
}
impl Div<f64> for Spectrum {
    type Output = Spectrum;
    fn div(self, s: f64) -> Spectrum {
        Spectrum(self.0 / s)
    }
}
impl Sum for Spectrum {
    fn sum<I: Iterator<Item = Spectrum>>(iter: I) -> Spectrum {
        iter.fold(Spectrum::BLACK, Add::add)
    }
}
