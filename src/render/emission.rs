//! What every pass sends: how many photons of which kind from which light, learnt once for a render.

use std::sync::Arc;

use super::progress::Silent;
use super::unit::collect_units;
use super::watch::{Stopped, Unattended};
use super::{mis, partition};
use crate::estimate::bandwidth;
use crate::light::{Aim, Light, select};
use crate::photon::footprint::Spread;
use crate::photon::guide::{self, Found};
use crate::photon::survey::Survey;
use crate::photon::{
    Bounces, EmissionPlan, EmissionUnit, FirstEvent, Kinds, PathLimits, PhotonTracer, Population, Share,
};
use crate::scene::LightId;
use crate::scene::settings::{BounceFootprint, Estimator, FootprintRule, Guiding};
use crate::world::World;

/// Units that say how many of a population's photons are of use, and photons in each.
const PILOT_UNITS: usize = 64;
const PHOTONS_PER_PILOT_UNIT: u64 = 64;
/// As if no less of them were.
const LEAST_USEFUL: f64 = 1.0 / 16.0;

/// Of pilots, whose footprints are compared with each other or not looked at.
const UNIT_SPREAD: Spread = Spread::Columns { rule: FootprintRule::Quadratic, scale: 1.0 };

/// Photons that are scattered first, for each one that is to make a caustic, and which part of those goes on from there;
/// where photons bring all light between surfaces that scatter, there are as many of both.
const BOUNCED_SHARE: f64 = 0.25;

/// What every pass sends.
pub fn plan(world: &World) -> Kinds<Population> {
    let others = Kinds::<()>::default().map(|()| Population::NONE);
    Kinds { caustic: caustics(world), bounced: bounced(world, world.scene.settings.photons as f64, false), ..others }
}

/// What every pass sends as beams into media that scatter, beside `photons` to surfaces: the eye brings the same part of
/// both. Where their light would be of use on surfaces is not asked.
pub fn beam_plan(world: &World, photons: &Kinds<Population>) -> Kinds<Population> {
    let (others, n) = (Kinds::<()>::default().map(|()| Population::NONE), world.scene.settings.beams);
    let mut caustic = caustics_of(world, n, true);
    for plan in &mut caustic.plans {
        let same = photons.caustic.plans.iter().find(|other| other.light == plan.light);
        plan.eyes_part = same.map_or(0.0, |same| same.eyes_part);
    }
    let kinds = Kinds { caustic, bounced: bounced(world, n as f64, true), ..others };
    // A cell that is only known where a photon lands is none of a beam's.
    let shared = |bounces: Bounces| match bounces.footprint {
        BounceFootprint::Coverage => Bounces { footprint: BounceFootprint::Shared, ..bounces },
        _ => bounces,
    };
    kinds.map(|kind| Population { bounces: kind.bounces.map(shared), ..kind })
}

/// Photons to the specular objects.
pub(super) fn caustics(world: &World) -> Population {
    let mut population = caustics_of(world, world.scene.settings.photons, false);
    for plan in &mut population.plans {
        plan.eyes_part = mis::eyes_part(world, &population.aim, plan);
    }
    population
}

fn caustics_of(world: &World, n: u64, makes_beams: bool) -> Population {
    let Some(aim) = world.aim else { return Population::NONE };
    let stores_scattered = partition::photons_bring_scattered(&world.scene.settings);
    let kind = Population { aim, sharing: sharing(world, n as f64), stores_scattered, makes_beams, ..Population::NONE };
    let plans = plans(world, n, &kind, |light, n| share_of(world, light, &aim, n));
    Population { plans, bounces: bounces(world, n as f64, BOUNCED_SHARE), ..kind }
}

/// Photons to everything else: as many as it takes for a number that goes on. Those that leave the scene cost little.
fn bounced(world: &World, photons: f64, makes_beams: bool) -> Population {
    let settings = &world.scene.settings;
    let stores_scattered = partition::photons_bring_scattered(settings);
    let n = (photons * if stores_scattered { 1.0 } else { BOUNCED_SHARE }).ceil();
    let Some(bounces) = bounces(world, n, 1.0) else { return Population::NONE };
    let kind = Population {
        first_event: FirstEvent::Scatter,
        bounces: Some(bounces),
        sharing: sharing(world, n),
        stores_scattered,
        makes_beams,
        ..Population::NONE
    };
    let share = |light, n| {
        let source = world.lights.get(light);
        if source.is_delta() { Share::leading(n, source.is_collimated()) } else { Share::same(n) }
    };
    let mut population = Population { plans: plans(world, n as u64, &kind, share), ..kind };
    let useful = useful_part(world, &population).max(LEAST_USEFUL);
    for plan in &mut population.plans {
        plan.points = (plan.points as f64 / useful).ceil() as u64;
        plan.share = share(plan.light, plan.points);
    }
    population
}

/// Which part of a population's photons is of use.
fn useful_part(world: &World, population: &Population) -> f64 {
    let units = EmissionUnit::all(&population.plans, world, &population.aim, 0, PHOTONS_PER_PILOT_UNIT, &[]);
    let mut tracer = PhotonTracer::<0, 0>::new(world, limits(world), UNIT_SPREAD).of(population);
    let (mut emitted, mut useful) = (0, 0);
    for unit in units.iter().step_by(units.len().div_ceil(PILOT_UNITS).max(1)) {
        emitted += unit.emit(&world.lights, &population.aim, |emission, time, stream| {
            useful += u64::from(tracer.is_useful(emission, time, stream));
        });
    }
    useful as f64 / emitted.max(1) as f64
}

/// `n` photons of one kind, in proportion to what each light can send to where they are aimed, of which pilots learn where
/// they are of use. `share` gives the cell of each of a light's so many photons.
fn plans(world: &World, n: u64, kind: &Population, share: impl Fn(LightId, u64) -> Share) -> Vec<EmissionPlan> {
    let due = world.lights.allot(n, &kind.aim);
    let found: Vec<Found> =
        world.lights.iter().zip(&due).map(|((light, _), &n)| learn(world, light, kind, n)).collect();
    let worth: Vec<f64> = found.iter().zip(&due).map(|(found, &n)| found.worth() * n as f64).collect();
    let plan = |(((light, _), found), n): (((LightId, &dyn Light), Found), u64)| {
        let (points, guide) = found.fill(n);
        EmissionPlan { light, points, share: share(light, points), guide: guide.map(Arc::new), eyes_part: 0.0 }
    };
    let lights = world.lights.iter().zip(found).zip(select::allot(n, &worth));
    lights.filter(|&(_, n)| n > 0).map(plan).collect()
}

/// How many of `n` photons share the directions out that were drawn for each at random.
fn sharing(world: &World, n: f64) -> f64 {
    n / bandwidth::random_overlap(world.scene.settings.emission)
}

/// How `share` of `n` photons goes on from surfaces that scatter; `None` if none does. Where photons only bring what goes
/// over a mirror or a glass, there has to be one.
fn bounces(world: &World, n: f64, share: f64) -> Option<Bounces> {
    let settings = &world.scene.settings;
    let aim = match world.aim {
        None if partition::photons_bring_scattered(settings) => Aim::Everywhere,
        aim => aim?,
    };
    let objects = || world.scene.objects.iter().map(|object| object.area(&world.scene.meshes));
    let bounces = Bounces {
        aim,
        footprint: settings.bounce_footprint,
        photons: n,
        overlap: bandwidth::random_overlap(settings.emission),
        // Adding up millions of triangles is for those who ask.
        area: if settings.bounce_footprint == BounceFootprint::Coverage { objects().sum() } else { 0.0 },
        share,
        max: settings.max_bounces,
    };
    (settings.max_bounces > 0).then_some(bounces)
}

/// Where on its emission map photons of a light that is due `n` of them are of use. Only footprints can do with photons of
/// unequal light, wider where there are few; discs of the standard estimates would show each of the bright ones as a spot.
fn learn(world: &World, light: LightId, kind: &Population, n: u64) -> Found {
    let (settings, source) = (&world.scene.settings, world.lights.get(light));
    let guided = settings.guiding == Guiding::On && settings.estimator == Estimator::Differentials && !kind.makes_beams;
    let Some(survey) = Survey::new(n).filter(|_| guided) else { return Found::Everywhere };
    // Nobody stops it: it takes less than a pass's photons.
    explored(world, light, kind, survey).map_or(Found::Everywhere, |survey| guide::found(&survey, source.is_delta()))
}

/// Pilots fill the survey, more and more finely.
fn explored(world: &World, light: LightId, kind: &Population, mut survey: Survey) -> Result<Survey, Stopped> {
    loop {
        let row = |row: usize| {
            let mut tracer = PhotonTracer::new(world, limits(world), UNIT_SPREAD).of(kind);
            survey.explore(&world.lights, light, &kind.aim, row, &mut tracer)
        };
        let rows = collect_units(survey.side, &Unattended(&Silent), row)?;
        survey.learn(rows);
        if !survey.refine() {
            return Ok(survey);
        }
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
    Share::balanced(&world.lights, light, aim, n, &mut pilot)
}

/// Of every photon's path.
pub(super) fn limits(world: &World) -> PathLimits {
    PathLimits { max_depth: world.scene.settings.max_depth, roulette_below: PathLimits::ROULETTE_BELOW }
}
