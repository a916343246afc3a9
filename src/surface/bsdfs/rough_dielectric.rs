//! An interface of GGX microfacets between two dielectrics · `[Walter07]`, `[Heitz14]`.
//!
//! One event among the facets, and a lobe of the light that meets more of them. Values are those of flux carried from wo
//! to wi (importance); radiance is scaled by [`super::super::Bsdf`], for all models in one place.

use super::Arrival;
use super::dielectric::Dielectric;
use super::multiple::{self, Multiple};
use super::rough_conductor::reflected;
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::sampling::warp::Warp;
use crate::surface::fresnel;
use crate::surface::microfacet::Ggx;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    pub interface: Dielectric,
    pub facets: Ggx,
}

/// The facet that takes wo to wi.
struct Facet {
    m: Vec3,
    /// Fresnel's part of the light that goes to wi's side there.
    share: f64,
    /// dm/dwi.
    jacobian: f64,
}

impl RoughDielectric {
    pub fn f(&self, arrival: &Arrival, wi: Vec3) -> Spectrum {
        let more = self.multiple(arrival).map_or(0.0, |multiple| multiple.f(arrival.wo, wi));
        Spectrum::splat(self.single_f(arrival, wi) + more)
    }
    fn single_f(&self, arrival: &Arrival, wi: Vec3) -> f64 {
        let wo = arrival.wo;
        let Some(facet) = self.facet(arrival, wi) else { return 0.0 };
        // [Walter07 (20), (21)] with the Jacobian kept apart: what the facets seen from both sides send on, over the macroscopic cosines.
        let masking = if wi.z > 0.0 { self.facets.g2_reflection(wo, wi) } else { self.facets.g2_transmission(wo, wi) };
        let shape = self.facets.d(facet.m) * masking * facet.jacobian * wo.dot(facet.m) / (wo.z * wi.z).abs();
        facet.share * shape
    }

    pub fn pdf(&self, arrival: &Arrival, wi: Vec3) -> f64 {
        self.parts(arrival, wi).iter().sum()
    }
    /// The density's parts, of one event and of more.
    pub fn parts(&self, arrival: &Arrival, wi: Vec3) -> [f64; 2] {
        let single = self
            .facet(arrival, wi)
            .map_or(0.0, |facet| facet.share * self.facets.visible_pdf(arrival.wo, facet.m) * facet.jacobian);
        multiple::mixed(self.multiple(arrival).as_ref(), single, arrival.wo, wi)
    }
    fn multiple(&self, arrival: &Arrival) -> Option<Multiple> {
        Multiple::of_interface(self.facets, self.interface.eta(arrival))
    }

    /// A visible facet, then reflection or refraction there by Fresnel's share, chosen with `uc`.
    pub fn sample(&self, arrival: &Arrival, uc: f64, u: [f64; 2]) -> Option<Vec3> {
        let wo = arrival.wo;
        let uc = match multiple::choose(self.multiple(arrival).as_ref(), wo, uc, u) {
            Ok(left) => left,
            Err(wi) => return wi,
        };
        let m = self.facets.visible(wo).sample(u).to_vec();
        let eta = self.interface.eta(arrival);
        let cos = wo.dot(m).clamp(0.0, 1.0);
        let interface = fresnel::dielectric(cos, eta);
        match interface.cos_t {
            Some(cos_t) if uc >= interface.reflectance => {
                let wi = -eta * wo + (eta * cos - cos_t) * m;
                (wi.z < 0.0).then_some(wi)
            }
            _ => {
                let wi = reflected(wo, m);
                (wi.z > 0.0).then_some(wi)
            }
        }
    }

    pub fn albedo(&self, _arrival: &Arrival) -> Spectrum {
        Spectrum::ONE
    }

    /// `None` where no facet with an upward normal does it.
    fn facet(&self, arrival: &Arrival, wi: Vec3) -> Option<Facet> {
        let wo = arrival.wo;
        let eta = self.interface.eta(arrival);
        if wi.z > 0.0 {
            let m = (wo + wi).normalize();
            let cos = wo.dot(m);
            let share = fresnel::dielectric(cos.clamp(0.0, 1.0), eta).reflectance;
            // [Walter07 (14)]
            return Some(Facet { m, share, jacobian: 1.0 / (4.0 * cos) });
        }
        // [Walter07 (16)]: the generalised half vector n_i wo + n_t wi points to the less dense side.
        let h = eta * wo + wi;
        let m = h.try_normalize()?;
        let m = if m.z < 0.0 { -m } else { m };
        let (cos_o, cos_i) = (wo.dot(m), wi.dot(m));
        if m.z == 0.0 || cos_o <= 0.0 || cos_i >= 0.0 {
            return None;
        }
        let share = fresnel::dielectric_transmittance(cos_o, -cos_i, eta);
        // [Walter07 (17)] with both indices divided by that of wi's side.
        Some(Facet { m, share, jacobian: -cos_i / h.length_squared() })
    }
}
