//! What a pass's photons will take, known before they are traced, and passes that fit into what there is.

use super::emission;
use super::photon_map::stored_about;
use crate::medium::Regions;
use crate::photon::Beam;
use crate::photon::beam_map::BeamMap;
use crate::photon::collision_map::CollisionMap;
use crate::scene::RenderSettings;
use crate::world::World;

/// Bytes that a stored photon takes while its map is built, when it takes most: 64 for itself, 27 for the tree over the
/// footprints. Measured as the growth of a process: 94 where every photon is stored (10⁷ in `scenes/refraction`), 115
/// where one in thirteen is (`scenes/ring`), whose units hold room for more.
pub const BYTES_PER_PHOTON: u64 = 120;

/// What a pass will take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PhotonMemory {
    /// Photons stored on surfaces.
    pub stored: u64,
    /// Photons' ways through media that become beams, or carry points.
    pub beams: u64,
    /// What each of those takes, bytes.
    pub bytes_per_beam: u64,
}

impl PhotonMemory {
    pub fn bytes(&self) -> u64 {
        let beams = self.beams.saturating_mul(self.bytes_per_beam);
        self.stored.saturating_mul(BYTES_PER_PHOTON).saturating_add(beams)
    }
}

/// Units of work that are traced to know how many photons are stored.
const PILOT_UNITS: usize = 16;

/// Estimates by tracing a few units of the first pass, spread over all lights: a pure function of the world.
pub fn estimate(world: &World) -> PhotonMemory {
    let plans = emission::plan(world);
    let stored = stored_about(world, &plans, 0, PILOT_UNITS);
    if !world.regions.as_ref().is_some_and(Regions::scatter) {
        return PhotonMemory { stored, ..PhotonMemory::default() };
    }
    let settings = &world.scene.settings;
    let bytes_per_beam = if settings.media_estimator.asks_beams() {
        BeamMap::BYTES_PER_BEAM
    } else {
        2 * size_of::<Beam>() as u64 + u64::from(settings.beam_points) * CollisionMap::BYTES_PER_COLLISION
    };
    let beams = stored_about(world, &emission::beam_plan(world, &plans), 0, PILOT_UNITS);
    PhotonMemory { stored, beams, bytes_per_beam }
}

/// Settings that spread the work of each pass over as many passes as its photons need to fit into `limit` bytes; none if
/// they fit as they are. Eye samples are shared out too, so the whole costs about the same.
pub fn split(settings: &RenderSettings, estimate: &PhotonMemory, limit: u64) -> Option<RenderSettings> {
    let parts = estimate.bytes().div_ceil(limit.max(BYTES_PER_PHOTON));
    let parts = u32::try_from(parts).unwrap_or(u32::MAX);
    (parts > 1).then(|| RenderSettings {
        photons: settings.photons.div_ceil(u64::from(parts)),
        beams: if estimate.beams > 0 { settings.beams.div_ceil(u64::from(parts)) } else { settings.beams },
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
        let estimate = PhotonMemory { stored: 400_000, ..PhotonMemory::default() };
        assert_eq!(split(&settings, &estimate, estimate.bytes()), None);
        let halves = split(&settings, &estimate, estimate.bytes() - 1).expect("it does not fit");
        assert_eq!((halves.photons, halves.spp, halves.passes), (500_000, 8, 4));
        let many = split(&settings, &estimate, 0).expect("it does not fit");
        assert_eq!((many.photons, many.spp, many.passes), (3, 1, 800_000));
        assert_eq!(many.beams, settings.beams);
    }

    /// Beams count as well as photons on surfaces, and are shared out with them.
    #[test]
    fn beams_are_counted() {
        let settings = RenderSettings { photons: 1_000, beams: 100_000, ..RenderSettings::default() };
        let photons = PhotonMemory { stored: 1_000, ..PhotonMemory::default() };
        let both = PhotonMemory { beams: 80_000, bytes_per_beam: BeamMap::BYTES_PER_BEAM, ..photons };
        assert_eq!(split(&settings, &photons, photons.bytes()), None);
        let parts = split(&settings, &both, both.bytes() / 4).expect("beams do not fit");
        assert_eq!((parts.photons, parts.beams, parts.passes), (250, 25_000, 4 * settings.passes));
    }
}
