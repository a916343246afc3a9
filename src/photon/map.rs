//! All photons of a pass.

use super::index::{BoxTree, OuterBox};
use super::path::PhotonCounts;
use super::record::Photon;
use crate::scene::LightId;

/// The photons of a pass in emission order, and the tree over their footprints.
pub struct PhotonMap {
    pub photons: Vec<Photon>,
    pub counts: PhotonCounts,
    /// What became of each light's photons, in the order of the scene's lights.
    pub by_light: Vec<PhotonCounts>,
    tree: BoxTree,
}

impl PhotonMap {
    /// The map of a scene that cannot make caustics.
    pub fn empty(lights: usize) -> PhotonMap {
        PhotonMap::from_units(lights, [])
    }

    /// Gathers the units of a pass, given in unit order as (light, photons, counts).
    pub fn from_units(
        lights: usize,
        units: impl IntoIterator<Item = (LightId, Vec<Photon>, PhotonCounts)>,
    ) -> PhotonMap {
        let mut by_light = vec![PhotonCounts::default(); lights];
        let mut counts = PhotonCounts::default();
        let mut photons = Vec::new();
        for (light, stored, unit_counts) in units {
            photons.extend(stored);
            by_light[light.index()].merge(&unit_counts);
            counts.merge(&unit_counts);
        }
        let boxes: Vec<OuterBox> = photons.iter().map(footprint_box).collect();
        PhotonMap { photons, counts, by_light, tree: BoxTree::build(&boxes, 1) }
    }

    pub fn tree(&self) -> &BoxTree {
        &self.tree
    }
}

/// Around every point that the footprint may light: the ellipse, and what slides into it from both sides.
fn footprint_box(photon: &Photon) -> OuterBox {
    let ellipse = photon.form().world_half_extents(&photon.frame());
    OuterBox::new(photon.position(), ellipse + photon.slide().abs() * photon.thickness())
}
