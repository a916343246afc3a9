//! Participating media as the scene file names them: what fills the inside of objects, and the whole scene. 1/m.

use std::sync::Arc;

use super::density::DensityGrid;
use super::ids::{MaterialId, MediumId};
use crate::radiometry::Spectrum;

/// A medium; its coefficients are those where its density is one.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// σ_a, 1/m.
    pub absorption: Spectrum,
    /// σ_s, 1/m.
    pub scattering: Spectrum,
    /// g of Henyey and Greenstein's phase function, the mean cosine between the ways before and after an event, in
    /// (−1, 1).
    pub asymmetry: f64,
    /// `None`: the same everywhere, of density one.
    pub density: Option<Arc<DensityGrid>>,
}

/// What is inside of the objects of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interior {
    /// `None`: nothing that absorbs or scatters.
    pub medium: Option<MediumId>,
    /// Where objects overlap it is the inside of the highest one that counts.
    pub priority: u32,
}

/// All media of a scene, and where they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Media {
    pub media: Vec<Medium>,
    /// Of each material; `None` for those that light does not go into.
    pub interiors: Vec<Option<Interior>>,
    /// What fills the sphere around the scene's objects, outside of all that have an inside.
    pub atmosphere: Option<MediumId>,
    /// Whether some objects are nothing but the boundary of a medium.
    pub has_interfaces: bool,
}

impl Media {
    /// Whether light goes through the scene as through nothing.
    pub fn is_empty(&self) -> bool {
        let filled = |interior: &Option<Interior>| interior.is_some_and(|interior| interior.medium.is_some());
        self.atmosphere.is_none() && !self.has_interfaces && !self.interiors.iter().any(filled)
    }

    pub fn get(&self, id: MediumId) -> &Medium {
        &self.media[id.index()]
    }

    pub fn interior(&self, material: MaterialId) -> Option<Interior> {
        self.interiors.get(material.index()).copied().flatten()
    }
}
