//! The dielectric layer of a coated surface by itself, of GGX facets or smooth · local frame, 1/sr without the cosine.

use super::rough_conductor::reflected;
use crate::math::Vec3;
use crate::sampling::warp::Warp;
use crate::surface::facet_albedo::{self, LEAST_REFLECTANCE, schlick};
use crate::surface::fresnel::normal_reflectance;
use crate::surface::microfacet::Ggx;

/// The layer alone, in short numbers: a BSDF goes from hand to hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coat {
    /// k.
    weight: f32,
    ior: f32,
    /// GGX width; 0 is smooth.
    alpha: f32,
}

impl Coat {
    /// `weight` is the covered part, from 0 to 1; `ior` the index of the layer against what is outside.
    pub fn new(weight: f64, ior: f64, facets: Option<Ggx>) -> Coat {
        let alpha = facets.map_or(0.0, |facets| facets.alpha());
        Coat { weight: weight.clamp(0.0, 1.0) as f32, ior: ior as f32, alpha: alpha as f32 }
    }

    pub fn weight(&self) -> f64 {
        self.weight.into()
    }
    pub fn f0(&self) -> f64 {
        normal_reflectance(self.ior.into())
    }
    pub fn facets(&self) -> Option<Ggx> {
        // Rounded, it may lie just below.
        (self.alpha > 0.0).then(|| Ggx::new(f64::from(self.alpha).max(Ggx::SMOOTH_BELOW)))
    }

    /// T, never above what the coat leaves.
    pub fn through(&self, cos: f64) -> f64 {
        let returned = match self.facets() {
            Some(facets) => (facet_albedo::albedo(self.f0(), cos, facets.alpha()) + facet_albedo::ERROR).min(1.0),
            None => schlick(self.f0(), cos),
        };
        1.0 - self.weight() * returned
    }
    /// What it returns as far as the mean facet tells, and never nothing where others return something.
    pub fn estimate(&self, cos: f64) -> f64 {
        self.weight() * schlick(self.f0(), cos).max(LEAST_REFLECTANCE)
    }
    pub fn f(&self, wo: Vec3, wi: Vec3) -> f64 {
        let Some(facets) = self.facets().filter(|_| wi.z > 0.0) else { return 0.0 };
        let m = (wo + wi).normalize();
        let shape = facets.d(m) * facets.g2_reflection(wo, wi) / (4.0 * wo.z * wi.z);
        self.weight() * schlick(self.f0(), wo.dot(m)) * shape
    }
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f64 {
        let Some(facets) = self.facets().filter(|_| wi.z > 0.0) else { return 0.0 };
        let m = (wo + wi).normalize();
        facets.visible_pdf(wo, m) / (4.0 * wo.dot(m))
    }
    pub fn sample(&self, wo: Vec3, u: [f64; 2]) -> Option<Vec3> {
        let wi = reflected(wo, self.facets()?.visible(wo).sample(u).to_vec());
        (wi.z > 0.0).then_some(wi)
    }
}
