//! A metal of GGX microfacets · `[Walter07]`, `[Heitz14]`.
//!
//! One bounce among the facets, and a lobe of the light that meets more of them, which gets more of the metal's colour.

use super::Arrival;
use super::conductor::Conductor;
use super::multiple::{self, Multiple};
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::sampling::warp::Warp;
use crate::surface::microfacet::Ggx;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductor {
    pub metal: Conductor,
    pub facets: Ggx,
}

impl RoughConductor {
    /// F D G₂ / (4 cos cos) [Walter07 (20)], and what more bounces add.
    pub fn f(&self, arrival: &Arrival, wi: Vec3) -> Spectrum {
        let wo = arrival.wo;
        if wi.z <= 0.0 {
            return Spectrum::BLACK;
        }
        let m = (wo + wi).normalize();
        let shape = self.facets.d(m) * self.facets.g2_reflection(wo, wi) / (4.0 * wo.z * wi.z);
        let single = self.metal.reflectance(wo.dot(m).clamp(0.0, 1.0)) * shape;
        match self.multiple() {
            Some(multiple) => single + multiple.coloured(self.metal.mean_reflectance()) * multiple.f(wo, wi),
            None => single,
        }
    }
    pub fn pdf(&self, arrival: &Arrival, wi: Vec3) -> f64 {
        self.parts(arrival, wi).iter().sum()
    }
    /// The density's parts, of one bounce and of more: the half vector's density over its Jacobian 4 (wo·m)
    /// [Walter07 (13), (14)], and that of a wide lobe.
    pub fn parts(&self, arrival: &Arrival, wi: Vec3) -> [f64; 2] {
        let wo = arrival.wo;
        if wi.z <= 0.0 {
            return [0.0; 2];
        }
        let m = (wo + wi).normalize();
        let single = self.facets.visible_pdf(wo, m) / (4.0 * wo.dot(m));
        multiple::mixed(self.multiple().as_ref(), single, wo, wi)
    }
    pub fn sample(&self, arrival: &Arrival, uc: f64, u: [f64; 2]) -> Option<Vec3> {
        if let Err(wi) = multiple::choose(self.multiple().as_ref(), arrival.wo, uc, u) {
            return wi;
        }
        let m = self.facets.visible(arrival.wo).sample(u).to_vec();
        let wi = reflected(arrival.wo, m);
        (wi.z > 0.0).then_some(wi)
    }
    fn multiple(&self) -> Option<Multiple> {
        Multiple::among_mirrors(self.facets)
    }
    /// Fresnel's reflectance of the mean facet: an estimate, above what light leaves that meets more facets.
    pub fn albedo(&self, arrival: &Arrival) -> Spectrum {
        self.metal.albedo(arrival)
    }
}

/// The mirror image of `w` about the facet normal `m`.
pub(super) fn reflected(w: Vec3, m: Vec3) -> Vec3 {
    2.0 * w.dot(m) * m - w
}
