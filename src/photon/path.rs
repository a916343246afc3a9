//! Which photon paths are stored, how long they live, and what became of all others.

use serde::{Deserialize, Serialize};

use crate::sampling::Stream;

/// Limits of a photon's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathLimits {
    /// Edges from the light at most.
    pub max_depth: u32,
    /// A branch that carries less than this share of its photon plays roulette; see [`survive`].
    pub roulette_below: f64,
}

impl PathLimits {
    /// A clear glass passes 96 % and reflects 4 % at a face. Following every branch above 1/16 keeps the strong sheet
    /// of a lattice whole; weaker ones are thinned to photons of equal weight.
    pub const ROULETTE_BELOW: f64 = 1.0 / 16.0;
}

/// What the first event of a path of light must be for the path to go on: two kinds of paths share the light out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstEvent {
    /// At a mirror, a glass or a coat.
    Delta,
    /// At a surface that scatters.
    Scatter,
}

/// What became of the emitted photons. Every photon or branch that ends without being stored shows here once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PhotonCounts {
    /// Photons that left the lights. Guided ones are drawn, so that their number is not exactly what was asked for.
    pub photons_emitted: u64,
    /// Records made: vertices with a lobe that is not a delta, reached over at least one delta event.
    pub photons_stored: u64,
    /// Images of photons whose footprints reach behind a wall.
    #[serde(default)]
    pub edge_images: u64,
    /// Met no lobe at their first surface that their kind goes on through: direct light, which the eye path gathers itself.
    pub direct: u64,
    /// Met an object of another group than they were aimed at first: light that the other group's photons bring.
    #[serde(default)]
    pub other_group: u64,
    /// Met a mirror, a glass or a glossy surface of an object that is to cast no caustics; what would go on is left out.
    #[serde(default)]
    pub not_cast: u64,
    /// Went on from a surface that scatters.
    pub bounced: u64,
    /// Left the scene.
    pub escaped: u64,
    /// Ended at a stored vertex without a delta lobe: the ordinary end of a caustic path.
    pub absorbed: u64,
    /// Lost at roulette.
    pub roulette: u64,
    /// Cut at the longest path allowed.
    pub max_depth: u64,
    /// Branches that changed more than one way at an interface and were all followed.
    pub split: u64,
    /// Lobes at vertices of smoothed meshes that the shading and the geometric normal put on different sides; what would
    /// have gone there is lost.
    pub normals_disagree: u64,
    /// Columns that a curved surface spread too far to be followed whole; see `differential::health`.
    pub narrowed_columns: u64,
    /// Columns that overflowed or became NaN; the photon is dropped.
    pub broken_columns: u64,
    /// A NaN or infinite flux; the photon is dropped.
    pub broken_flux: u64,
}

impl PhotonCounts {
    /// Adds another unit's counts.
    pub fn merge(&mut self, other: &PhotonCounts) {
        self.photons_emitted += other.photons_emitted;
        self.photons_stored += other.photons_stored;
        self.edge_images += other.edge_images;
        self.direct += other.direct;
        self.other_group += other.other_group;
        self.not_cast += other.not_cast;
        self.bounced += other.bounced;
        self.escaped += other.escaped;
        self.absorbed += other.absorbed;
        self.roulette += other.roulette;
        self.max_depth += other.max_depth;
        self.split += other.split;
        self.normals_disagree += other.normals_disagree;
        self.narrowed_columns += other.narrowed_columns;
        self.broken_columns += other.broken_columns;
        self.broken_flux += other.broken_flux;
    }
}

/// Russian roulette on a branch that carries `share` of its photon: the probability it survived with, or `None`.
/// A survivor's flux is divided by that probability, and so is the area of its cell, since fewer now share the light.
pub fn survive(share: f64, below: f64, stream: &mut Stream) -> Option<f64> {
    if share >= below {
        return Some(1.0);
    }
    let q = share / below;
    (stream.uniform() < q).then_some(q)
}
