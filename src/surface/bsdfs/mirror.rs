//! An ideal mirror of constant reflectance.

use super::{Arrival, LocalDelta, LocalDeltas, mirrored};
use crate::radiometry::Spectrum;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    pub reflectance: Spectrum,
}

impl Mirror {
    pub fn deltas(&self, arrival: &Arrival) -> LocalDeltas {
        [Some(LocalDelta { wi: mirrored(arrival.wo), weight: self.reflectance, eta: None }), None]
    }
    pub fn albedo(&self, _arrival: &Arrival) -> Spectrum {
        self.reflectance
    }
}
