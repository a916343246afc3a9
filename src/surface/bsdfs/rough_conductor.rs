//! A metal of GGX microfacets, one bounce among them · `[Walter07]`, `[Heitz14]`.
//!
//! Light that would meet a second facet is lost, so a furnace shows less than Fresnel's reflectance on wide
//! distributions, never more.

use super::Arrival;
use super::conductor::Conductor;
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
    /// F D G₂ / (4 cos cos) [Walter07 (20)].
    pub fn f(&self, arrival: &Arrival, wi: Vec3) -> Spectrum {
        let wo = arrival.wo;
        if wi.z <= 0.0 {
            return Spectrum::BLACK;
        }
        let m = (wo + wi).normalize();
        let shape = self.facets.d(m) * self.facets.g2_reflection(wo, wi) / (4.0 * wo.z * wi.z);
        self.metal.reflectance(wo.dot(m).clamp(0.0, 1.0)) * shape
    }
    /// The half vector's density over its Jacobian 4 (wo·m) [Walter07 (13), (14)].
    pub fn pdf(&self, arrival: &Arrival, wi: Vec3) -> f64 {
        let wo = arrival.wo;
        if wi.z <= 0.0 {
            return 0.0;
        }
        let m = (wo + wi).normalize();
        self.facets.visible_pdf(wo, m) / (4.0 * wo.dot(m))
    }
    pub fn sample(&self, arrival: &Arrival, u: [f64; 2]) -> Option<Vec3> {
        let m = self.facets.visible(arrival.wo).sample(u).to_vec();
        let wi = reflected(arrival.wo, m);
        (wi.z > 0.0).then_some(wi)
    }
    /// Fresnel's reflectance of the mean facet: an estimate, above the single bounce's.
    pub fn albedo(&self, arrival: &Arrival) -> Spectrum {
        self.metal.albedo(arrival)
    }
}

/// The mirror image of `w` about the facet normal `m`.
pub(super) fn reflected(w: Vec3, m: Vec3) -> Vec3 {
    2.0 * w.dot(m) * m - w
}
