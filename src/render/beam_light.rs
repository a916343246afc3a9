//! Light that photons bring to the eye's paths in media that scatter: emit → trace → map, and what rays and places ask.
//!
//! These are photons of their own, fewer than those on surfaces: a ray crosses thousands of their beams where a point lies
//! under a hundred footprints. The kinds, and who finds them, are those of surfaces ([`super::partition`]).

use super::emission;
use super::photon_light::LIGHT;
use super::photon_map::{self, Traced};
use super::unit::{run_units, scattered};
use super::watch::Stopped;
use super::{Job, RenderState};
use crate::estimate::beams::{self, EyeSegment, Place};
use crate::estimate::{bandwidth, collisions};
use crate::film::{Arrival, LightKind};
use crate::photon::beam_map::BeamMap;
use crate::photon::collision_map::CollisionMap;
use crate::photon::footprint::Spread;
use crate::photon::{Beam, EmissionPlan, Kinds, PhotonCounts, Population};
use crate::radiometry::{Radiance, Spectrum};
use crate::sampling::{Purpose, Stream};
use crate::scene::settings::{KernelShape, MediaEstimator};
use crate::scene::{GroupId, Medium};
use crate::world::World;

/// The beams of a pass, or points on them.
pub struct BeamLight {
    /// Of each group of lights, in the order of their ids.
    maps: Vec<Kinds<Option<MediaMap>>>,
    kernel: KernelShape,
    estimator: MediaEstimator,
    /// What became of their photons; a beam counts as stored.
    pub counts: PhotonCounts,
}

/// What is asked of one kind.
enum MediaMap {
    Beams(BeamMap),
    Points(CollisionMap),
}

impl BeamLight {
    /// Those of the pass under way; `None` where no medium scatters, or nothing focuses light into one.
    pub fn shoot(job: &Job, state: &RenderState) -> Result<Option<BeamLight>, Stopped> {
        let (world, pass) = (job.world, state.film.pass());
        let Some(regions) = world.regions.as_ref().filter(|regions| regions.scatter()) else { return Ok(None) };
        let plans = job.beam_plans.get_or_init(|| emission::beam_plan(world, job.plans()));
        let units = photon_map::units(world, plans, pass);
        let (spread, cells) = (spread(world, plans, pass), photon_map::time_cells(world, pass));
        job.watch.phase("beams", units.len() as u64);
        let groups = &world.scene.light_groups;
        let mut all: Vec<Kinds<Vec<Beam>>> = vec![Kinds::default(); groups.ids()];
        let mut counts = PhotonCounts::default();
        let trace = |i: usize| photon_map::trace_unit(world, &units[i], spread, cells);
        run_units(&scattered(units.len()), job.watch, trace, |i, Traced { beams, counts: unit, .. }| {
            counts.merge(&unit);
            all[groups.of(units[i].light()).index()].append(beams.unwrap_or_default());
            job.watch.look(state);
        })?;
        job.watch.finish();
        let mut number = 0;
        let mut map = |beams: Vec<Beam>| {
            number += 1;
            (!beams.is_empty()).then(|| MediaMap::new(world, pass, beams, regions.media(), number))
        };
        let maps = all.into_iter().map(|kinds| kinds.map(&mut map)).collect();
        let settings = &world.scene.settings;
        Ok(Some(BeamLight { maps, kernel: settings.kernel, estimator: settings.media_estimator, counts }))
    }

    /// Whether rays ask, [`BeamLight::along`], and not places, [`BeamLight::at`].
    pub fn asks_along_rays(&self) -> bool {
        self.estimator.asks_along_rays()
    }

    /// What photons of each kind bring to the start of a segment; those that were scattered last only where they are asked
    /// for. `straight` is what light straight from a lamp would be to the eye there.
    pub fn along(
        &self,
        segment: &EyeSegment,
        asks_scattered: bool,
        straight: Arrival,
        add: impl FnMut(LightKind, Spectrum),
    ) {
        self.ask(asks_scattered, straight, add, |map| match map {
            MediaMap::Beams(map) => beams::radiance(map, self.kernel, segment),
            MediaMap::Points(map) => collisions::radiance(map, self.kernel, segment),
        });
    }

    /// The same of what comes in at a place.
    pub fn at(&self, place: &Place, asks_scattered: bool, straight: Arrival, add: impl FnMut(LightKind, Spectrum)) {
        self.ask(asks_scattered, straight, add, |map| match map {
            MediaMap::Beams(map) => beams::radiance_at(map, self.kernel, place),
            MediaMap::Points(map) => collisions::radiance_at(map, self.kernel, place),
        });
    }

    fn ask(
        &self,
        asks_scattered: bool,
        straight: Arrival,
        mut add: impl FnMut(LightKind, Spectrum),
        radiance: impl Fn(&MediaMap) -> Radiance,
    ) {
        let maps =
            GroupId::all().zip(&self.maps).flat_map(|(group, maps)| maps.as_ref().map(|map| (group, map)).into_array());
        for ((group, map), (part, arrival)) in maps.zip(LIGHT.into_array().into_iter().cycle()) {
            let Some(map) = map.as_ref().filter(|_| arrival != Arrival::Scattered || asks_scattered) else { continue };
            let arrival = if straight == Arrival::Straight { arrival } else { straight };
            add(LightKind { part, arrival, group }, radiance(map).0);
        }
    }
}

/// How wide the beams of pass `pass` spread their light: as narrow as a blur along one line allows, where that is what is asked for.
fn spread(world: &World, plans: &Kinds<Population>, pass: u32) -> Spread {
    let settings = &world.scene.settings;
    let spread = photon_map::spread(world, pass);
    let Spread::Columns { rule, .. } = spread else { return spread };
    let points: f64 = plans.caustic.plans.iter().map(|plan| plan.points as f64).sum();
    if settings.media_estimator != MediaEstimator::RayBeams || points == 0.0 {
        return spread;
    }
    let scale = bandwidth::scale(settings.bandwidth, settings.emission, settings.kernel);
    let of_plan = |plan: &EmissionPlan| {
        let overlap = plan.share.overlap(plan.points);
        plan.points as f64 / points * bandwidth::beam_scale(scale, overlap, plan.points)
    };
    let scale: f64 = plans.caustic.plans.iter().map(of_plan).sum();
    Spread::Columns { rule, scale: scale * bandwidth::beam_narrowing(pass) }
}

/// Ways of one kind of photons in a pass that have numbers of their own.
const WAYS: u64 = 1 << 48;

impl MediaMap {
    /// Of the beams of pass `pass`, those of the `kind`th kind over all groups of lights.
    fn new(world: &World, pass: u32, beams: Vec<Beam>, media: &[Medium], kind: u64) -> MediaMap {
        let settings = &world.scene.settings;
        if settings.media_estimator.asks_beams() {
            return MediaMap::Beams(BeamMap::new(beams, media));
        }
        let spread = photon_map::spread(world, pass);
        let stream = |way: u64| Stream::new(settings.seed, Purpose::Collision, pass, kind * WAYS + way);
        MediaMap::Points(CollisionMap::new(beams, media, settings.beam_points, spread, stream))
    }
}
