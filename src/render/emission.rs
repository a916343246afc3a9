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
    Bounces, EmissionPlan, EmissionUnit, FirstEvent, Kinds, PathLimits, PhotonTracer, Population, Share, Target,
};
use crate::scene::settings::{BounceFootprint, Estimator, FootprintRule, Guiding};
use crate::scene::{LightId, PhotonChoice};
use crate::world::{Casters, World};

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
    // An eye path that runs into a light does not say over which group: the least part of a light's is that of all.
    let mut least = vec![f64::INFINITY; world.lights.len()];
    for plan in &population.plans {
        let least = &mut least[plan.light.index()];
        *least = least.min(mis::eyes_part(world, plan));
    }
    for plan in &mut population.plans {
        plan.eyes_part = least[plan.light.index()];
    }
    population
}

fn caustics_of(world: &World, n: u64, makes_beams: bool) -> Population {
    let Some(casters) = &world.casters else { return Population::NONE };
    let stores_scattered = partition::photons_bring_scattered(&world.scene.settings);
    let kind = Population { sharing: sharing(world, n as f64), stores_scattered, makes_beams, ..Population::NONE };
    let plans = plans(world, n, &kind, &targets(world, casters), |light, target, n| share_of(world, light, target, n));
    Population { plans, bounces: bounces(world, n as f64, BOUNCED_SHARE), ..kind }
}

/// What photons for caustics are aimed at: each group for itself where they are guided.
fn targets(world: &World, casters: &Casters) -> Vec<Target> {
    if casters.groups.len() < 2 || !is_guided(world) || world.regions.is_some() {
        return vec![Target::all(casters.whole)];
    }
    casters.groups.iter().zip(0..).map(|(&aim, group)| Target { aim, group: Some(group) }).collect()
}

/// Whether photons go where they are of use. Only footprints can do with photons of unequal light, wider where there are few;
/// discs of the standard estimates would show each of the bright ones as a spot.
fn is_guided(world: &World) -> bool {
    let settings = &world.scene.settings;
    settings.guiding == Guiding::On && settings.estimator == Estimator::Differentials
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
    let share = |light, _: &Target, n| {
        let source = world.lights.get(light);
        if source.is_delta() { Share::leading(n, source.is_collimated()) } else { Share::same(n) }
    };
    let everywhere = [Target::all(Aim::Everywhere)];
    let mut population = Population { plans: plans(world, n as u64, &kind, &everywhere, share), ..kind };
    let useful = useful_part(world, &population).max(LEAST_USEFUL);
    for plan in &mut population.plans {
        plan.points = (plan.points as f64 / useful).ceil() as u64;
        plan.share = share(plan.light, &plan.target, plan.points);
    }
    population
}

/// Which part of a population's photons is of use.
fn useful_part(world: &World, population: &Population) -> f64 {
    let units = EmissionUnit::all(&population.plans, world, 0, PHOTONS_PER_PILOT_UNIT, &[]);
    let mut tracer = PhotonTracer::<0, 0>::new(world, limits(world), UNIT_SPREAD).of(population);
    let (mut emitted, mut useful) = (0, 0);
    for unit in units.iter().step_by(units.len().div_ceil(PILOT_UNITS).max(1)) {
        emitted += unit.emit(&world.lights, |emission, time, stream| {
            useful += u64::from(tracer.is_useful(emission, time, stream));
        });
    }
    useful as f64 / emitted.max(1) as f64
}

/// `n` photons of one kind, in proportion to what each light can send to each of the targets, of which pilots learn where
/// they are of use. `share` gives the cell of each of so many photons of a light to a target.
fn plans(
    world: &World,
    n: u64,
    kind: &Population,
    targets: &[Target],
    share: impl Fn(LightId, &Target, u64) -> Share,
) -> Vec<EmissionPlan> {
    let towards = |target| world.lights.iter().map(move |(light, source)| (light, source, target));
    let all: Vec<(LightId, &dyn Light, &Target)> = targets.iter().flat_map(towards).collect();
    let sent: Vec<f64> = all.iter().map(|(_, source, to)| source.emitted_flux(&to.aim).0.luminance()).collect();
    let due = share_out(world, n, kind, &all, &sent);
    let found: Vec<Found> =
        all.iter().zip(&due).map(|(&(light, _, target), &n)| learn(world, light, kind, target, n)).collect();
    let worth: Vec<f64> = found.iter().zip(&due).map(|(found, &n)| found.worth() * n as f64).collect();
    let mut plans = Vec::new();
    for ((&(light, _, target), found), n) in all.iter().zip(found).zip(share_out(world, n, kind, &all, &worth)) {
        if n > 0 {
            let (points, guide) = found.fill(n);
            let (share, guide) = (share(light, target, points), guide.map(Arc::new));
            plans.push(EmissionPlan { light, target: *target, points, share, guide, eyes_part: 0.0 });
        }
    }
    plans
}

/// Splits `n` photons in proportion to what lights are worth towards their targets; of those for caustics some lights may
/// have none, or a number of their own, to be split among their own targets.
fn share_out(
    world: &World,
    n: u64,
    kind: &Population,
    all: &[(LightId, &dyn Light, &Target)],
    worth: &[f64],
) -> Vec<u64> {
    let choices = &world.scene.light_photons;
    if choices.all_auto() || kind.first_event != FirstEvent::Delta {
        return select::allot(n, worth);
    }
    // What of a pass's photons is asked for, of its beams; one at least, or the light's would be lost.
    let scaled = |count: u64| (count as f64 * n as f64 / world.scene.settings.photons as f64).ceil() as u64;
    let worth_of = |chosen: &dyn Fn(LightId) -> bool| -> Vec<f64> {
        all.iter().zip(worth).map(|(&(light, ..), &worth)| if chosen(light) { worth } else { 0.0 }).collect()
    };
    let rest = n.saturating_sub(scaled(choices.asked()));
    let mut due = select::allot(rest, &worth_of(&|light| choices.of(light) == PhotonChoice::Auto));
    for (light, _) in world.lights.iter() {
        if let PhotonChoice::Count(count) = choices.of(light) {
            let own = select::allot(scaled(count), &worth_of(&|other| other == light));
            due.iter_mut().zip(own).for_each(|(due, own)| *due += own);
        }
    }
    due
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

/// Where on its emission map photons of a light that is due `n` of them to a target are of use.
fn learn(world: &World, light: LightId, kind: &Population, target: &Target, n: u64) -> Found {
    let guided = is_guided(world) && !kind.makes_beams;
    let Some(survey) = Survey::new(n).filter(|_| guided) else { return Found::Everywhere };
    let is_delta = world.lights.get(light).is_delta();
    // Nobody stops it: it takes less than a pass's photons.
    explored(world, light, kind, target, survey).map_or(Found::Everywhere, |survey| guide::found(&survey, is_delta))
}

/// Pilots fill the survey, more and more finely.
fn explored(
    world: &World,
    light: LightId,
    kind: &Population,
    target: &Target,
    mut survey: Survey,
) -> Result<Survey, Stopped> {
    loop {
        let row = |row: usize| {
            let mut tracer = PhotonTracer::new(world, limits(world), UNIT_SPREAD).of(kind).towards(target);
            survey.explore(&world.lights, light, &target.aim, row, &mut tracer)
        };
        let rows = collect_units(survey.side, &Unattended(&Silent), row)?;
        survey.learn(rows);
        if !survey.refine() {
            return Ok(survey);
        }
    }
}

/// The cells of a light's photons. The parallelogram belongs to the slides' method, and so do the slides' cells.
fn share_of(world: &World, light: LightId, target: &Target, n: u64) -> Share {
    let settings = &world.scene.settings;
    let source = world.lights.get(light);
    if settings.footprint == FootprintRule::Parallelogram {
        return Share::same(n);
    }
    if source.is_delta() {
        return Share::leading(n, source.is_collimated());
    }
    let mut pilot = PhotonTracer::new(world, limits(world), UNIT_SPREAD).towards(target);
    Share::balanced(&world.lights, light, &target.aim, n, &mut pilot)
}

/// Of every photon's path.
pub(super) fn limits(world: &World) -> PathLimits {
    PathLimits { max_depth: world.scene.settings.max_depth, roulette_below: PathLimits::ROULETTE_BELOW }
}
