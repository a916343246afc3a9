//! The main conductor: one pass reads emit → trace → map → gather → film.

use std::sync::Arc;

use super::exposure::expose;
use super::eye_path::EyeFinds;
use super::progress::{Progress, Silent};
use super::unit::{collect_units, run_units, scattered};
use super::watch::{Stopped, Unattended, Watch};
use super::{Job, RenderState};
use crate::estimate::{Estimate, bandwidth};
use crate::light::{Aim, Light, select};
use crate::photon::footprint::Spread;
use crate::photon::guide::{self, Found};
use crate::photon::survey::Survey;
use crate::photon::{
    EmissionPlan, EmissionUnit, PathLimits, Photon, PhotonCounts, PhotonHarvest, PhotonMap, PhotonTracer, Share,
};
use crate::scene::LightId;
use crate::scene::settings::{Estimator, FootprintRule, Guiding};
use crate::world::World;

/// Photons in a unit of work.
const PHOTONS_PER_UNIT: u64 = 4096;

/// Of pilots, whose footprints are compared with each other or not looked at.
const UNIT_SPREAD: Spread = Spread::Columns { rule: FootprintRule::Quadratic, scale: 1.0 };

/// The rest of the pass under way of the photon-map renderer, added to the film.
pub fn render_pass(job: &Job, state: &mut RenderState) -> Result<(), Stopped> {
    let (world, pass) = (job.world, state.film.pass());
    let plans = job.plans.get_or_init(|| plan(world));
    let map = shoot(world, plans, pass, job.watch, || job.watch.look(state))?;
    let estimate = Estimate::new(&map, &world.scene.settings, pass);
    expose(job, EyeFinds::AllButCaustics, Some(&estimate), state)?;
    state.report.add_photons(&map.counts, &map.by_light);
    Ok(())
}

/// What each light sends in every pass: photons in proportion to what it can send to specular objects, of which pilots
/// learn where on them it is of use.
pub fn plan(world: &World) -> Vec<EmissionPlan> {
    let (Some(aim), settings) = (&world.aim, &world.scene.settings) else { return Vec::new() };
    let due = world.lights.allot(settings.photons, aim);
    let found: Vec<Found> = world.lights.iter().zip(&due).map(|((light, _), &n)| learn(world, light, aim, n)).collect();
    let worth: Vec<f64> = found.iter().zip(&due).map(|(found, &n)| found.worth() * n as f64).collect();
    let plan = |(((light, _), found), n): (((LightId, &dyn Light), Found), u64)| {
        let (points, guide) = found.fill(n);
        EmissionPlan { light, points, share: share_of(world, light, aim, points), guide: guide.map(Arc::new) }
    };
    let lights = world.lights.iter().zip(found).zip(select::allot(settings.photons, &worth));
    lights.filter(|&(_, n)| n > 0).map(plan).collect()
}

/// Where on its emission map a light that is due `n` photons is of use. Only footprints can do with photons of unequal
/// light, wider where there are few; discs of the standard estimates would show each of the bright ones as a spot.
fn learn(world: &World, light: LightId, aim: &Aim, n: u64) -> Found {
    let (settings, source) = (&world.scene.settings, world.lights.get(light));
    let guided = settings.guiding == Guiding::On && settings.estimator == Estimator::Differentials;
    let Some(survey) = Survey::new(n).filter(|_| guided) else { return Found::Everywhere };
    // Nobody stops it: it takes less than a pass's photons.
    explored(world, light, aim, survey).map_or(Found::Everywhere, |survey| guide::found(&survey, source.is_delta()))
}

/// Pilots fill the survey, more and more finely.
fn explored(world: &World, light: LightId, aim: &Aim, mut survey: Survey) -> Result<Survey, Stopped> {
    let source = world.lights.get(light);
    loop {
        let row = |row: usize| {
            let mut tracer = PhotonTracer::new(world, limits(world), UNIT_SPREAD);
            survey.explore(source, light, aim, row, &mut tracer)
        };
        let rows = collect_units(survey.side, &Unattended(&Silent), row)?;
        survey.learn(rows);
        if !survey.refine() {
            return Ok(survey);
        }
    }
}

/// emit → trace → map: the photons of pass `pass`. `between` is called after every unit.
pub fn shoot(
    world: &World,
    plans: &[EmissionPlan],
    pass: u32,
    watch: &dyn Watch,
    between: impl Fn(),
) -> Result<PhotonMap, Stopped> {
    Ok(harvest(world, plans, pass, watch, between)?.into_map())
}

/// emit → trace: what [`shoot`] makes a map of.
pub fn harvest(
    world: &World,
    plans: &[EmissionPlan],
    pass: u32,
    watch: &dyn Watch,
    between: impl Fn(),
) -> Result<PhotonHarvest, Stopped> {
    let mut harvest = PhotonHarvest::new(world.lights.len());
    let Some(aim) = &world.aim else { return Ok(harvest) };
    let units = units(world, plans, aim, pass);
    let spread = spread(world, pass);
    watch.phase("photons", units.len() as u64);
    let trace = |i: usize| trace_unit(world, aim, &units[i], spread);
    run_units(&scattered(units.len()), watch, trace, |_, (light, photons, counts)| {
        harvest.add(light, photons, &counts);
        between();
    })?;
    watch.finish();
    Ok(harvest)
}

fn units(world: &World, plans: &[EmissionPlan], aim: &Aim, pass: u32) -> Vec<EmissionUnit> {
    EmissionUnit::all(plans, &world.lights, &world.scene.settings, aim, pass, PHOTONS_PER_UNIT)
}

fn limits(world: &World) -> PathLimits {
    PathLimits { max_depth: world.scene.settings.max_depth, roulette_below: PathLimits::ROULETTE_BELOW }
}

type Stored = (LightId, Vec<Photon>, PhotonCounts);

/// Only footprints need the photons' columns.
fn trace_unit(world: &World, aim: &Aim, unit: &EmissionUnit, spread: Spread) -> Stored {
    match world.scene.settings.estimator {
        Estimator::Differentials => trace_with::<4>(world, aim, unit, spread),
        Estimator::Progressive | Estimator::NearestNeighbours => trace_with::<0>(world, aim, unit, spread),
    }
}

fn trace_with<const N: usize>(world: &World, aim: &Aim, unit: &EmissionUnit, spread: Spread) -> Stored {
    let mut tracer = PhotonTracer::<N>::new(world, limits(world), spread);
    let emitted = unit.emit(&world.lights, aim, |emission, stream| tracer.trace(emission, stream));
    tracer.counts.photons_emitted = emitted;
    (unit.light, tracer.photons, tracer.counts)
}

/// What became of the photons of about `some` units of pass `pass`, spread over all of them.
pub fn shoot_some(world: &World, pass: u32, some: usize) -> PhotonCounts {
    let mut counts = PhotonCounts::default();
    let Some(aim) = &world.aim else { return counts };
    let plans = plan(world);
    let units = units(world, &plans, aim, pass);
    let step = units.len().div_ceil(some.max(1)).max(1);
    let spread = spread(world, pass);
    units.iter().step_by(step).for_each(|unit| counts.merge(&trace_unit(world, aim, unit, spread).2));
    counts
}

/// The photons of pass `pass`, by someone who does not stop.
pub fn shoot_all(world: &World, pass: u32, progress: &dyn Progress) -> PhotonMap {
    shoot(world, &plan(world), pass, &Unattended(progress), || ())
        .unwrap_or_else(|Stopped| PhotonMap::empty(world.lights.len()))
}

/// How wide the photons of pass `pass` spread their light; the k nearest ones are found without that.
fn spread(world: &World, pass: u32) -> Spread {
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

/// The cells of a light's photons. The parallelogram belongs to the slides' method, and so do the slides' cells.
fn share_of(world: &World, light: LightId, aim: &Aim, n: u64) -> Share {
    let settings = &world.scene.settings;
    let source = world.lights.get(light);
    if settings.footprint == FootprintRule::Parallelogram {
        return Share::same(n);
    }
    if source.is_delta() {
        return Share::leading(n, source.is_collimated());
    }
    let mut pilot = PhotonTracer::new(world, limits(world), UNIT_SPREAD);
    Share::balanced(source, light, aim, n, &mut pilot)
}
