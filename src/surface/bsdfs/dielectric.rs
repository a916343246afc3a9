//! A smooth interface between two dielectrics: one mirrored and one refracted lobe.

use super::{Arrival, LocalDelta, LocalDeltas, mirrored};
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::surface::fresnel;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index on the side of the outward normal over the index inside.
    pub eta_outside: f64,
    /// Unpolarised Fresnel reflectance; otherwise all that can be transmitted is.
    pub fresnel: bool,
}

impl Dielectric {
    pub fn new(ior: f64, exterior: f64, fresnel: bool) -> Dielectric {
        Dielectric { eta_outside: exterior / ior, fresnel }
    }
    /// n_i/n_t for a ray that arrives along −wo.
    pub fn eta(&self, arrival: &Arrival) -> f64 {
        if arrival.outside { self.eta_outside } else { 1.0 / self.eta_outside }
    }
    pub fn deltas(&self, arrival: &Arrival) -> LocalDeltas {
        let wo = arrival.wo;
        let eta = self.eta(arrival);
        let interface = fresnel::dielectric(wo.z, eta);
        let (reflected, transmitted) = match interface.cos_t {
            Some(_) if !self.fresnel => (0.0, 1.0),
            _ => (interface.reflectance, interface.transmittance),
        };
        let reflection = LocalDelta { wi: mirrored(wo), weight: Spectrum::splat(reflected), eta: None };
        let transmission = interface.cos_t.map(|cos_t| LocalDelta {
            wi: Vec3::new(-eta * wo.x, -eta * wo.y, -cos_t),
            weight: Spectrum::splat(transmitted),
            eta: Some(eta),
        });
        [(reflected > 0.0).then_some(reflection), transmission]
    }
    pub fn albedo(&self, _arrival: &Arrival) -> Spectrum {
        Spectrum::ONE
    }
}
