//! Radiometric quantities: a [`Spectrum`] with a unit. Scaling keeps the unit; changing it takes a named step.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul};

use super::Spectrum;

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Default)]
        pub struct $name(pub Spectrum);

        impl $name {
            pub const ZERO: $name = $name(Spectrum::BLACK);
            pub fn spectrum(self) -> Spectrum {
                self.0
            }
            pub fn is_zero(self) -> bool {
                self.0.is_black()
            }
        }
        impl Add for $name {
            type Output = $name;
            fn add(self, rhs: $name) -> $name {
                $name(self.0 + rhs.0)
            }
        }
        impl AddAssign for $name {
            fn add_assign(&mut self, rhs: $name) {
                self.0 += rhs.0;
            }
        }
        impl Mul<f64> for $name {
            type Output = $name;
            fn mul(self, s: f64) -> $name {
                $name(self.0 * s)
            }
        }
        impl Div<f64> for $name {
            type Output = $name;
            fn div(self, s: f64) -> $name {
                $name(self.0 / s)
            }
        }
        /// Attenuation or tinting by a dimensionless factor.
        impl Mul<Spectrum> for $name {
            type Output = $name;
            fn mul(self, s: Spectrum) -> $name {
                $name(self.0 * s)
            }
        }
        impl Sum for $name {
            fn sum<I: Iterator<Item = $name>>(iter: I) -> $name {
                iter.fold($name::ZERO, Add::add)
            }
        }
    };
}

quantity!(
    /// W
    Flux
);
quantity!(
    /// W/m²
    Irradiance
);
quantity!(
    /// W/(m²·sr)
    Radiance
);
quantity!(
    /// W/sr
    Intensity
);

impl Flux {
    /// Flux spread evenly over `area` m².
    pub fn over_area(self, area: f64) -> Irradiance {
        Irradiance(self.0 / area)
    }
}

impl Irradiance {
    /// Flux through `area` m².
    pub fn through(self, area: f64) -> Flux {
        Flux(self.0 * area)
    }
    /// Radiance scattered by a BSDF value `f` in 1/sr.
    pub fn scattered(self, f: Spectrum) -> Radiance {
        Radiance(self.0 * f)
    }
}
