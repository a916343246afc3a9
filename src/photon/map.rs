//! All photons of a pass.

use super::index::{BoxTree, OuterBox};
use super::path::PhotonCounts;
use super::record::Photon;
use crate::scene::LightId;

/// Footprints over a point that a stratum keeps: their mean is then known to some ten per cent.
const STRATUM_COVERAGE: f64 = 64.0;
/// At most so many strata.
const MAX_STRATA: usize = 32;
/// Photons at which coverage is measured.
const COVERAGE_PROBES: usize = 256;

/// The photons of a pass in emission order, and trees over their footprints.
///
/// Where many footprints lie over every point they are dealt out to strata, each a map of its own with every m-th photon.
pub struct PhotonMap {
    pub photons: Vec<Photon>,
    pub counts: PhotonCounts,
    /// What became of each light's photons, in the order of the scene's lights.
    pub by_light: Vec<PhotonCounts>,
    strata: Vec<BoxTree>,
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
        PhotonMap { photons, counts, by_light, strata: stratify(&boxes) }
    }

    /// Trees over the footprints, none of which is in two; photons are named by their index.
    pub fn strata(&self) -> &[BoxTree] {
        &self.strata
    }
}

fn stratify(boxes: &[OuterBox]) -> Vec<BoxTree> {
    let all = BoxTree::build(boxes, 1);
    let m = ((coverage(&all, boxes) / STRATUM_COVERAGE) as usize).clamp(1, MAX_STRATA);
    if m == 1 {
        return vec![all];
    }
    (0..m).map(|k| BoxTree::build_every(boxes, k, m)).collect()
}

/// The mean number of footprint boxes over a photon.
fn coverage(tree: &BoxTree, boxes: &[OuterBox]) -> f64 {
    let step = boxes.len().div_ceil(COVERAGE_PROBES).max(1);
    let probes = boxes.iter().step_by(step);
    let mut found = 0usize;
    for probe in probes.clone() {
        tree.visit(&probe.at_centre(), |leaf| {
            found += leaf.len();
            true
        });
    }
    found as f64 / probes.len().max(1) as f64
}

/// Around every point that the footprint may light: the ellipse, and what slides into it from both sides.
fn footprint_box(photon: &Photon) -> OuterBox {
    let ellipse = photon.form().world_half_extents(&photon.frame());
    OuterBox::new(photon.position(), ellipse + photon.slide().abs() * photon.thickness())
}
