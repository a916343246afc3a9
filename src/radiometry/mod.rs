//! Colours, radiometric quantities and densities as types.

pub mod measure;
pub mod quantity;
pub mod spectrum;

pub use measure::{Area, Pdf, Pmf, SolidAngle};
pub use quantity::{Flux, Intensity, Irradiance, Radiance};
pub use spectrum::Spectrum;
