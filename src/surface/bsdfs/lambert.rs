//! Ideal diffuse reflection, f = ρ/π, drawn in proportion to the cosine.

use std::f64::consts::FRAC_1_PI;

use super::Arrival;
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::sampling::warp::{CosineHemisphere, Warp};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// ρ.
    pub albedo: Spectrum,
}

impl Lambert {
    pub fn f(&self, wi: Vec3) -> Spectrum {
        if wi.z > 0.0 { self.albedo * FRAC_1_PI } else { Spectrum::BLACK }
    }
    pub fn pdf(&self, wi: Vec3) -> f64 {
        cosine_pdf(wi)
    }
    pub fn sample(&self, u: [f64; 2]) -> Option<Vec3> {
        Some(sample_cosine(u))
    }
    pub fn albedo(&self, _arrival: &Arrival) -> Spectrum {
        self.albedo
    }
}

/// Density of [`sample_cosine`], 1/sr.
pub(super) fn cosine_pdf(wi: Vec3) -> f64 {
    wi.z.max(0.0) * FRAC_1_PI
}

/// A direction of the upper hemisphere with density cos θ/π.
pub(super) fn sample_cosine(u: [f64; 2]) -> Vec3 {
    CosineHemisphere.sample(u).to_vec()
}
