//! The main conductor: one pass reads emit → trace → map → gather → film.

use super::beam_light::BeamLight;
use super::emission::{self, limits};
use super::exposure::expose;
use super::partition::EyeTask;
use super::photon_light::PhotonLight;
use super::progress::Progress;
use super::unit::{run_units, scattered};
use super::watch::{Stopped, Unattended, Watch};
use super::{Job, RenderState};
use crate::estimate::{bandwidth, kernel};
use crate::photon::footprint::Spread;
use crate::photon::{
    Beam, EmissionUnit, FirstEvent, Kinds, Photon, PhotonCounts, PhotonHarvest, PhotonMap, PhotonTracer, Population,
    TimeCells,
};
use crate::sampling::qmc;
use crate::scene::settings::{EmissionPattern, Estimator, TimeResolution};
use crate::scene::{GroupId, LightGroups, LightId};
use crate::world::World;

/// Time cells of the first pass for each cube root of its photons, unless settings say how many: between the bend of sweeps and
/// too few photons for each instant, for sweeps short and long (`src/doc/motion.md`).
const TIME_CELLS: f64 = 1.0 / 3.0;

/// Photons in a unit of work.
const PHOTONS_PER_UNIT: u64 = 4096;

/// The rest of the pass under way of the photon-map renderer, added to the film.
pub fn render_pass(job: &Job, state: &mut RenderState) -> Result<(), Stopped> {
    let (world, pass) = (job.world, state.film.pass());
    let plans = job.plans();
    let beams = BeamLight::shoot(job, state)?;
    let maps = shoot_by_group(world, plans, pass, job.watch, || job.watch.look(state))?;
    let photons = PhotonLight::of_groups(&maps, &world.scene.settings, pass).with_beams(beams.as_ref());
    expose(job, &EyeTask::beside(world, plans), Some(&photons), state)?;
    maps.iter().for_each(|maps| state.report.add_maps(maps));
    if let Some(beams) = &beams {
        state.report.beam_photons.merge(&beams.counts);
    }
    Ok(())
}

/// emit → trace → map: the photons of pass `pass`. `between` is called after every unit.
pub fn shoot(
    world: &World,
    plans: &Kinds<Population>,
    pass: u32,
    watch: &dyn Watch,
    between: impl Fn(),
) -> Result<Kinds<PhotonMap>, Stopped> {
    Ok(harvest(world, plans, pass, watch, between)?.map(PhotonHarvest::into_map))
}

/// The same, those of each group of lights apart, in the order of the groups' ids.
fn shoot_by_group(
    world: &World,
    plans: &Kinds<Population>,
    pass: u32,
    watch: &dyn Watch,
    between: impl Fn(),
) -> Result<Vec<Kinds<PhotonMap>>, Stopped> {
    let by_group = harvest_by_group(world, plans, pass, watch, &world.scene.light_groups, between)?;
    Ok(by_group.into_iter().map(|kinds| kinds.map(PhotonHarvest::into_map)).collect())
}

/// emit → trace: what [`shoot`] makes maps of.
pub fn harvest(
    world: &World,
    plans: &Kinds<Population>,
    pass: u32,
    watch: &dyn Watch,
    between: impl Fn(),
) -> Result<Kinds<PhotonHarvest>, Stopped> {
    let mut together = harvest_by_group(world, plans, pass, watch, &LightGroups::default(), between)?;
    Ok(together.remove(0))
}

fn harvest_by_group(
    world: &World,
    plans: &Kinds<Population>,
    pass: u32,
    watch: &dyn Watch,
    groups: &LightGroups,
    between: impl Fn(),
) -> Result<Vec<Kinds<PhotonHarvest>>, Stopped> {
    let empty = |group: GroupId| {
        plans.as_ref().map(|population| {
            let lights = || population.plans.iter().map(|plan| plan.light).filter(|&light| groups.of(light) == group);
            PhotonHarvest::new(world.lights.len()).whole(is_one_sheet(world, population, lights()))
        })
    };
    let mut harvests: Vec<Kinds<PhotonHarvest>> = GroupId::all().take(groups.ids()).map(empty).collect();
    let units = units(world, plans, pass);
    let (spread, cells) = (spread(world, pass), time_cells(world, pass));
    watch.phase("photons", units.len() as u64);
    let trace = |i: usize| trace_unit(world, &units[i], spread, cells);
    run_units(&scattered(units.len()), watch, trace, |i, Traced { stored, counts, .. }| {
        let light = units[i].light();
        let harvest = &mut harvests[groups.of(light).index()];
        let none = PhotonCounts::default();
        // What became of all of a unit's photons stands with the kind that they were sent out as.
        let [caustic, bounced] = match units[i].population.first_event {
            FirstEvent::Delta => [&counts, &none],
            FirstEvent::Scatter => [&none, &counts],
        };
        harvest.caustic.add(light, stored.caustic, caustic);
        harvest.onward.add(light, stored.onward, &none);
        harvest.bounced.add(light, stored.bounced, bounced);
        harvest.onward_scattered.add(light, stored.onward_scattered, &none);
        harvest.scattered.add(light, stored.scattered, &none);
        between();
    })?;
    watch.finish();
    Ok(harvests)
}

/// Whether photons leave every one of the `lights` from one point, or into one direction, so that they lie on what they light
/// as evenly as they set out.
fn is_one_sheet(world: &World, population: &Population, lights: impl Iterator<Item = LightId>) -> bool {
    let mut lights = lights.peekable();
    population.first_event == FirstEvent::Delta
        && lights.peek().is_some()
        && lights.all(|light| world.lights.get(light).is_delta())
}

/// Some photons of one kind.
pub(super) struct Unit<'a> {
    population: &'a Population,
    emission: EmissionUnit,
}

impl Unit<'_> {
    /// Where they come from.
    pub fn light(&self) -> LightId {
        self.emission.light
    }
}

pub(super) fn units<'a>(world: &World, plans: &'a Kinds<Population>, pass: u32) -> Vec<Unit<'a>> {
    let instants = instants(world, pass);
    let of = |population: &'a Population| {
        let all = EmissionUnit::all(&population.plans, world, pass, PHOTONS_PER_UNIT, &instants);
        all.into_iter().map(move |emission| Unit { population, emission })
    };
    plans.as_ref().into_array().into_iter().flat_map(of).collect()
}

/// What a unit stored.
pub(super) struct Traced {
    stored: Kinds<Vec<Photon>>,
    pub beams: Option<Kinds<Vec<Beam>>>,
    pub counts: PhotonCounts,
}

/// Only footprints need the photons' columns, and that of time only where something moves.
pub(super) fn trace_unit(world: &World, unit: &Unit, spread: Spread, cells: TimeCells) -> Traced {
    match (world.scene.settings.estimator, world.scene.shutter.is_instant()) {
        (Estimator::Differentials, true) => trace_with::<4, 0>(world, unit, spread, cells),
        (Estimator::Differentials, false) => trace_with::<4, 1>(world, unit, spread, cells),
        (Estimator::Progressive | Estimator::NearestNeighbours, _) => trace_with::<0, 0>(world, unit, spread, cells),
    }
}

fn trace_with<const N: usize, const T: usize>(world: &World, unit: &Unit, spread: Spread, cells: TimeCells) -> Traced {
    let mut tracer = PhotonTracer::<N, T>::new(world, limits(world), spread)
        .of(unit.population)
        .towards(&unit.emission.target)
        .beside_eyes(unit.emission.eyes_part)
        .over(cells);
    let emitted = unit.emission.emit(&world.lights, |emission, time, stream| tracer.trace(emission, time, stream));
    tracer.counts.photons_emitted = emitted;
    let PhotonTracer { stored, beams, counts, .. } = tracer;
    Traced { stored, beams, counts }
}

/// How many photons, or beams, pass `pass` stores of what is sent by plan, from about `some` units of it, spread over all.
pub fn stored_about(world: &World, plans: &Kinds<Population>, pass: u32, some: usize) -> u64 {
    let units = units(world, plans, pass);
    let step = units.len().div_ceil(some.max(1)).max(1);
    let (spread, cells) = (spread(world, pass), time_cells(world, pass));
    let stored = |unit: &Unit| trace_unit(world, unit, spread, cells).counts.photons_stored;
    let tried = units.len().div_ceil(step).max(1);
    let sum: u64 = units.iter().step_by(step).map(stored).sum();
    (sum as f64 * units.len() as f64 / tried as f64).ceil() as u64
}

/// The caustics' photons of pass `pass`, by someone who does not stop.
pub fn shoot_all(world: &World, pass: u32, progress: &dyn Progress) -> PhotonMap {
    let none = Kinds::<()>::default().map(|()| Population::NONE);
    let plans = Kinds { caustic: Population { bounces: None, ..emission::caustics(world) }, ..none };
    shoot(world, &plans, pass, &Unattended(progress), || ())
        .map_or_else(|Stopped| PhotonMap::empty(world.lights.len()), |maps| maps.caustic)
}

/// What of the shutter's interval the photons of pass `pass` stand for: parts that get shorter as footprints get narrower,
/// so that their blur vanishes as well.
pub fn time_cells(world: &World, pass: u32) -> TimeCells {
    let (settings, shutter) = (&world.scene.settings, world.scene.shutter);
    if shutter.is_instant() {
        return TimeCells::one(shutter);
    }
    let first = match settings.time_cells {
        TimeResolution::Auto => (TIME_CELLS * (settings.photons as f64).cbrt()).round().max(1.0),
        TimeResolution::Cells(count) => f64::from(count),
    };
    let count = first / bandwidth::narrowing(settings.emission, pass);
    TimeCells::new(shutter, count.floor() as u32, kernel::variance(settings.kernel)).with(settings.time_kernel)
}

/// The instants, s, at which photons of pass `pass` set out whose time columns say the rest: the middles of the time cells,
/// and places beside them in later passes, so that what the columns leave out differs from pass to pass. None for photons
/// that have no columns, or are drawn.
fn instants(world: &World, pass: u32) -> Vec<f64> {
    let (settings, shutter) = (&world.scene.settings, world.scene.shutter);
    let has_columns = settings.estimator == Estimator::Differentials && settings.emission != EmissionPattern::Random;
    if shutter.is_instant() || !has_columns {
        return Vec::new();
    }
    let (count, place) = (time_cells(world, pass).count(), qmc::van_der_corput(pass.saturating_add(1)));
    (0..count).map(|cell| shutter.time((cell as f64 + place) / count as f64)).collect()
}

/// How wide the photons of pass `pass` spread their light; the k nearest ones are found without that.
pub(super) fn spread(world: &World, pass: u32) -> Spread {
    let settings = &world.scene.settings;
    match settings.estimator {
        Estimator::Progressive => {
            Spread::Disc { radius: bandwidth::progressive_radius(settings.radius, &world.scene.bounds, pass) }
        }
        Estimator::Differentials | Estimator::NearestNeighbours => Spread::Columns {
            rule: settings.footprint,
            scale: bandwidth::scale(settings.bandwidth, settings.emission, settings.kernel)
                * bandwidth::narrowing(settings.emission, pass),
        },
    }
}
