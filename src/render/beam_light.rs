//! Light that photon beams bring to the eye's rays in media that scatter: emit → trace → map, and what a ray asks.
//!
//! Beams are photons of their own, fewer than those on surfaces: a ray crosses thousands of them where a point lies under a
//! hundred footprints. The kinds, and who finds them, are those of surfaces ([`super::partition`]).

use super::emission;
use super::photon_light::LIGHT;
use super::photon_map::{self, Traced};
use super::unit::{run_units, scattered};
use super::watch::Stopped;
use super::{Job, RenderState};
use crate::estimate::beams::{self, EyeSegment};
use crate::film::{Arrival, LightKind};
use crate::photon::beam_map::BeamMap;
use crate::photon::{Beam, Kinds};
use crate::radiometry::Spectrum;
use crate::scene::GroupId;
use crate::scene::settings::KernelShape;

/// The beams of a pass.
pub struct BeamLight {
    /// Of each group of lights, in the order of their ids.
    maps: Vec<Kinds<BeamMap>>,
    kernel: KernelShape,
}

impl BeamLight {
    /// Those of the pass under way; `None` where no medium scatters, or nothing focuses light into one.
    pub fn shoot(job: &Job, state: &RenderState) -> Result<Option<BeamLight>, Stopped> {
        let (world, pass) = (job.world, state.film.pass());
        let scatters = world.regions.as_ref().is_some_and(|regions| regions.scatter());
        if !scatters {
            return Ok(None);
        }
        let plans = job.beam_plans.get_or_init(|| emission::beam_plan(world, job.plans()));
        let units = photon_map::units(world, plans, pass);
        let (spread, cells) = (photon_map::spread(world, pass), photon_map::time_cells(world, pass));
        job.watch.phase("beams", units.len() as u64);
        let groups = &world.scene.light_groups;
        let mut all: Vec<Kinds<Vec<Beam>>> = vec![Kinds::default(); groups.ids()];
        let trace = |i: usize| photon_map::trace_unit(world, &units[i], spread, cells);
        run_units(&scattered(units.len()), job.watch, trace, |i, Traced { beams, .. }| {
            all[groups.of(units[i].light()).index()].append(beams.unwrap_or_default());
            job.watch.look(state);
        })?;
        job.watch.finish();
        Ok(Some(BeamLight {
            maps: all.into_iter().map(|kinds| kinds.map(BeamMap::new)).collect(),
            kernel: world.scene.settings.kernel,
        }))
    }

    /// What the beams of each kind bring to the start of a segment; those that were scattered last only where they are asked
    /// for. `straight` is what light straight from a lamp would be to the eye there.
    pub fn along(
        &self,
        segment: &EyeSegment,
        asks_scattered: bool,
        straight: Arrival,
        mut add: impl FnMut(LightKind, Spectrum),
    ) {
        let maps =
            GroupId::all().zip(&self.maps).flat_map(|(group, maps)| maps.as_ref().map(|map| (group, map)).into_array());
        for ((group, map), (part, arrival)) in maps.zip(LIGHT.into_array().into_iter().cycle()) {
            if map.beams.is_empty() || arrival == Arrival::Scattered && !asks_scattered {
                continue;
            }
            let arrival = if straight == Arrival::Straight { arrival } else { straight };
            add(LightKind { part, arrival, group }, beams::radiance(map, self.kernel, segment).0);
        }
    }
}
