//! What a pass's photons will take, known before they are traced, and passes that fit into what there is.

use super::photon_map::stored_about;
use crate::scene::RenderSettings;
use crate::world::World;

/// Bytes that a stored photon takes while its map is built, when it takes most: 64 for itself, 27 for the tree over the
/// footprints. Measured as the growth of a process: 94 where every photon is stored (10⁷ in `scenes/refraction`), 115
/// where one in thirteen is (`scenes/ring`), whose units hold room for more.
pub const BYTES_PER_PHOTON: u64 = 120;

/// What a pass will take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhotonMemory {
    /// Photons stored.
    pub stored: u64,
}

impl PhotonMemory {
    pub fn bytes(&self) -> u64 {
        self.stored.saturating_mul(BYTES_PER_PHOTON)
    }
}

/// Units of work that are traced to know how many photons are stored.
const PILOT_UNITS: usize = 16;

/// Estimates by tracing a few units of the first pass, spread over all lights: a pure function of the world.
pub fn estimate(world: &World) -> PhotonMemory {
    PhotonMemory { stored: stored_about(world, 0, PILOT_UNITS) }
}

/// Settings that spread the work of each pass over as many passes as its photons need to fit into `limit` bytes; none if
/// they fit as they are. Eye samples are shared out too, so the whole costs about the same.
pub fn split(settings: &RenderSettings, estimate: &PhotonMemory, limit: u64) -> Option<RenderSettings> {
    let parts = estimate.bytes().div_ceil(limit.max(BYTES_PER_PHOTON));
    let parts = u32::try_from(parts).unwrap_or(u32::MAX);
    (parts > 1).then(|| RenderSettings {
        photons: settings.photons.div_ceil(u64::from(parts)),
        spp: settings.spp.div_ceil(parts),
        passes: settings.passes.saturating_mul(parts),
        ..settings.clone()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_split_as_far_as_needed() {
        let settings = RenderSettings { photons: 1_000_000, spp: 16, passes: 2, ..RenderSettings::default() };
        let estimate = PhotonMemory { stored: 400_000 };
        assert_eq!(split(&settings, &estimate, estimate.bytes()), None);
        let halves = split(&settings, &estimate, estimate.bytes() - 1).expect("it does not fit");
        assert_eq!((halves.photons, halves.spp, halves.passes), (500_000, 8, 4));
        let many = split(&settings, &estimate, 0).expect("it does not fit");
        assert_eq!((many.photons, many.spp, many.passes), (3, 1, 800_000));
    }
}
