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

/// Nodes and weights of Gauss's rule of four points for the weight 2μ on [0, 1].
const GAUSS: [(f64, f64); 4] = [
    (0.13975986434378, 0.062361941900016),
    (0.4164095676310819, 0.2596950952164646),
    (0.7231569863618741, 0.406929136020543),
    (0.9428958038854797, 0.2710138268629765),
];

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
    /// F̄ = 2∫ F(μ) μ dμ.
    pub fn mean_reflectance(&self) -> Spectrum {
        GAUSS.iter().fold(Spectrum::BLACK, |sum, &(cos, weight)| sum + self.reflectance(cos) * weight)
    }
    pub fn deltas(&self, arrival: &Arrival) -> LocalDeltas {
        [Some(LocalDelta { wi: mirrored(arrival.wo), weight: self.albedo(arrival), eta: None }), None]
    }
    pub fn albedo(&self, arrival: &Arrival) -> Spectrum {
        self.reflectance(arrival.wo.z.min(1.0))
    }
}
