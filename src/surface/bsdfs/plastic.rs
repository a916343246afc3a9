//! A diffuse base under a smooth dielectric coat · opaque, both sides alike · f = T(wo) T(wi) ρ / (π n² (1 − ρ F̄ᵢ)).
//!
//! T = 1 − F is what the coat lets through on the way in and out, 1/n² spreads radiance that leaves the denser medium,
//! and the series 1 + ρF̄ᵢ + … of light that the coat throws back onto the base sums to 1/(1 − ρF̄ᵢ), F̄ᵢ being the coat's
//! diffuse reflectance from within. With T̄ₑ = n²(1 − F̄ᵢ) a white base returns all.

use std::f64::consts::FRAC_1_PI;

use super::lambert::{cosine_pdf, sample_cosine};
use super::{Arrival, LocalDelta, LocalDeltas, mirrored};
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::surface::fresnel;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    /// 1/n of the coat.
    eta: f64,
    /// ρ / (n² (1 − ρ F̄ᵢ)).
    base: Spectrum,
    /// 1 − F̄ₑ, the part of diffuse light from outside that enters.
    entering: f64,
}

impl Plastic {
    pub fn new(albedo: Spectrum, ior: f64) -> Plastic {
        let internal = fresnel::dielectric_diffuse(1.0 / ior);
        let entering = 1.0 - fresnel::dielectric_diffuse(ior);
        let base = albedo.map(|a| a / (ior * ior * (1.0 - a * internal)));
        Plastic { eta: 1.0 / ior, base, entering }
    }
    fn coat(&self, cos: f64) -> fresnel::Interface {
        fresnel::dielectric(cos.min(1.0), self.eta)
    }
    pub fn deltas(&self, arrival: &Arrival) -> LocalDeltas {
        let weight = Spectrum::splat(self.coat(arrival.wo.z).reflectance);
        [Some(LocalDelta { wi: mirrored(arrival.wo), weight, eta: None }), None]
    }
    pub fn f(&self, arrival: &Arrival, wi: Vec3) -> Spectrum {
        if wi.z <= 0.0 {
            return Spectrum::BLACK;
        }
        self.base * (self.coat(arrival.wo.z).transmittance * self.coat(wi.z).transmittance * FRAC_1_PI)
    }
    pub fn pdf(&self, wi: Vec3) -> f64 {
        cosine_pdf(wi)
    }
    pub fn sample(&self, u: [f64; 2]) -> Option<Vec3> {
        Some(sample_cosine(u))
    }
    /// What the base returns of light from `wo`: ∫ f cos dwi.
    pub fn scatter_albedo(&self, arrival: &Arrival) -> Spectrum {
        self.base * (self.coat(arrival.wo.z).transmittance * self.entering)
    }
    pub fn albedo(&self, arrival: &Arrival) -> Spectrum {
        self.scatter_albedo(arrival) + Spectrum::splat(self.coat(arrival.wo.z).reflectance)
    }
}
