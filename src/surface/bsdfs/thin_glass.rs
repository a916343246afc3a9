//! A sheet of glass without thickness, of GGX facets on both sides alike: what goes through is the mirror image, below the
//! surface, of what a reflection would be · values in 1/sr without the cosine · Schlick's reflectance.
//!
//! Nothing is bent on the way: straight through in the mean, and as wide as the reflection. Light that meets more than one
//! facet leaves on both sides in the parts that perfectly diffuse light does.

use super::Arrival;
use super::multiple::{self, Multiple};
use super::rough_conductor::reflected;
use crate::math::Vec3;
use crate::sampling::warp::Warp;
use crate::surface::facet_albedo::{schlick, smooth_diffuse_albedo};
use crate::surface::microfacet::Ggx;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinGlass {
    /// Reflectance at normal incidence.
    pub f0: f64,
    pub facets: Ggx,
}

impl ThinGlass {
    pub fn f(&self, arrival: &Arrival, wi: Vec3) -> f64 {
        let wo = arrival.wo;
        let above = Vec3::new(wi.x, wi.y, wi.z.abs());
        let m = (wo + above).normalize();
        let shape = self.facets.d(m) * self.facets.g2_reflection(wo, above) / (4.0 * wo.z * above.z);
        self.share(wo.dot(m), wi) * shape + self.multiple().map_or(0.0, |multiple| multiple.f(wo, wi))
    }
    /// The density's parts, of one event and of more.
    pub fn parts(&self, arrival: &Arrival, wi: Vec3) -> [f64; 2] {
        let wo = arrival.wo;
        let m = (wo + Vec3::new(wi.x, wi.y, wi.z.abs())).normalize();
        let single = self.share(wo.dot(m), wi) * self.facets.visible_pdf(wo, m) / (4.0 * wo.dot(m));
        multiple::mixed(self.multiple().as_ref(), single, wo, wi)
    }
    fn multiple(&self) -> Option<Multiple> {
        Multiple::of_sheet(self.facets, 1.0 - smooth_diffuse_albedo(self.f0))
    }
    /// A visible facet, then one of the sides by its share, chosen with `uc`.
    pub fn sample(&self, arrival: &Arrival, uc: f64, u: [f64; 2]) -> Option<Vec3> {
        let wo = arrival.wo;
        let uc = match multiple::choose(self.multiple().as_ref(), wo, uc, u) {
            Ok(left) => left,
            Err(wi) => return wi,
        };
        let m = self.facets.visible(wo).sample(u).to_vec();
        let wi = reflected(wo, m);
        let through = uc >= schlick(self.f0, wo.dot(m));
        (wi.z > 0.0).then(|| if through { Vec3::new(wi.x, wi.y, -wi.z) } else { wi })
    }
    /// Of the light on a facet, the part that goes to the side of `wi`.
    fn share(&self, cos: f64, wi: Vec3) -> f64 {
        let reflectance = schlick(self.f0, cos);
        if wi.z > 0.0 { reflectance } else { 1.0 - reflectance }
    }
}
