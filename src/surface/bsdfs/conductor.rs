//! A smooth metal: a mirror with Fresnel's reflectance, each colour with its own complex index.

use super::{Arrival, LocalDelta, LocalDeltas, mirrored};
use crate::radiometry::Spectrum;
use crate::surface::fresnel;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// Real and imaginary part of the index, relative to the medium outside.
    pub eta: Spectrum,
    pub k: Spectrum,
}

impl Conductor {
    /// Reflectance of a facet that light meets with `cos_i`.
    pub fn reflectance(&self, cos_i: f64) -> Spectrum {
        let ([er, eg, eb], [kr, kg, kb]) = (self.eta.to_array(), self.k.to_array());
        Spectrum::rgb(
            fresnel::conductor(cos_i, er, kr),
            fresnel::conductor(cos_i, eg, kg),
            fresnel::conductor(cos_i, eb, kb),
        )
    }
    pub fn deltas(&self, arrival: &Arrival) -> LocalDeltas {
        [Some(LocalDelta { wi: mirrored(arrival.wo), weight: self.albedo(arrival), eta: None }), None]
    }
    pub fn albedo(&self, arrival: &Arrival) -> Spectrum {
        self.reflectance(arrival.wo.z.min(1.0))
    }
}
