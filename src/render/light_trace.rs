//! The unbiased reference from the other side: light paths, every scattering vertex connected to the camera.
//!
//! Finds L … D E. What lies behind a specular chain from the eye (D S⁺ E) cannot be connected and is missing; emitters
//! seen by the eye, E S* L, are added by eye paths.
//!
//! Half of the paths set out towards the objects that make caustics and go on only where their first event is a delta
//! one; the other half sets out everywhere and stops there. The two halves share the light out between them, and most
//! paths of a small lens' caustic are not lost beside the lens.

mod medium;

use super::exposure::expose;
use super::partition::{EyeFinds, EyeTask};
use super::unit::{run_units, scattered};
use super::watch::Stopped;
use super::{Job, RenderState};
use crate::camera::{Camera, Connection};
use crate::film::{Arrival, Exposure, LightKind, Part, SplatBuffer};
use crate::light::{Aim, Emission};
use crate::math::{Dir3, Ray};
use crate::medium::Inside;
use crate::photon::{EmissionPlan, EmissionUnit, FirstEvent, Share, Target};
use crate::radiometry::Spectrum;
use crate::sampling::Stream;
use crate::sampling::warp::{ConcentricDisk, Warp};
use crate::scene::GroupId;
use crate::surface::adjoint::shading_normal_factor;
use crate::surface::{Bsdf, Event, Interaction, TransportMode};
use crate::world::{Flown, World};

/// Light paths in a unit of work.
const PATHS_PER_UNIT: u64 = 16384;

/// Light paths of one kind in a pass.
struct Kind {
    exposure: Exposure,
    first_event: FirstEvent,
    units: Vec<EmissionUnit>,
}

impl Kind {
    fn new(world: &World, pass: u32, exposure: Exposure, (aim, first_event): (&Aim, FirstEvent), paths: u64) -> Kind {
        let due = world.lights.allot(paths, aim);
        let plans = EmissionPlan::even(&world.lights, Target::all(*aim), &due, |light, n| {
            let source = world.lights.get(light);
            if source.is_delta() { Share::leading(n, source.is_collimated()) } else { Share::same(n) }
        });
        let units = EmissionUnit::all(&plans, world, pass, PATHS_PER_UNIT, &[]);
        Kind { exposure, first_event, units }
    }

    /// The kinds of pass `pass`: `settings.photons` light paths over all lights.
    fn all(world: &World, pass: u32) -> Vec<Kind> {
        let all = world.scene.settings.photons;
        let to_all = (&Aim::Everywhere, FirstEvent::Scatter);
        match &world.aim {
            // Nothing focuses.
            None => vec![Kind::new(world, pass, Exposure::LightToAll, to_all, all)],
            Some(aim) => {
                let caustics = all.div_ceil(2);
                let to_casters = (aim, FirstEvent::Delta);
                vec![
                    Kind::new(world, pass, Exposure::LightToCasters, to_casters, caustics),
                    Kind::new(world, pass, Exposure::LightToAll, to_all, all - caustics),
                ]
            }
        }
    }
}

/// The rest of the pass under way of the light tracer, added to the film.
pub fn render_pass(job: &Job, state: &mut RenderState) -> Result<(), Stopped> {
    expose(job, &EyeTask::alone(EyeFinds::Emitters), None, state)?;
    let (world, camera, pass) = (job.world, &job.camera, state.film.pass());
    let kinds = Kind::all(world, pass);
    let units: Vec<(&Kind, usize)> =
        kinds.iter().flat_map(|kind| (0..kind.units.len()).map(move |i| (kind, i))).collect();
    let is_missing = |&i: &usize| !state.film.added(units[i].0.exposure).contains(units[i].1);
    let missing: Vec<usize> = scattered(units.len()).into_iter().filter(is_missing).collect();
    job.watch.phase("light paths", missing.len() as u64);
    let (bounds, filter) = (state.film.bounds(), world.scene.camera.filter);
    let trace = |i: usize| {
        let (kind, unit) = units[i];
        let splats = SplatBuffer::new(bounds, pass, filter);
        let group = world.scene.light_groups.of(kind.units[unit].light);
        let mut tracer = LightTracer { world, camera, first_event: kind.first_event, group, splats };
        kind.units[unit].emit(&world.lights, |emission, time, stream| tracer.trace(emission, time, stream));
        tracer.splats
    };
    run_units(&missing, job.watch, trace, |i, splats| {
        let (kind, unit) = units[i];
        state.film.add_splats(kind.exposure, unit, &splats);
        job.watch.look(state);
    })?;
    job.watch.finish();
    Ok(())
}

struct LightTracer<'a> {
    world: &'a World,
    camera: &'a Camera,
    first_event: FirstEvent,
    /// Of the light that the paths come from.
    group: GroupId,
    splats: SplatBuffer,
}

/// A light path under way.
struct Walk {
    ray: Ray,
    w: Dir3,
    /// What the ray is inside of; not kept where there are no media.
    inside: Inside,
    /// W, times what the path's events left of it.
    flux: Spectrum,
    scatter_events: u32,
    /// Whether all events so far were of class S, and how many.
    leading_events: Option<u32>,
    /// The part that it belongs to where the eye looks past glossy surfaces at the last vertex of class D, or at the light;
    /// none once there was a delta event behind.
    past_glossy: Option<LightKind>,
    group: GroupId,
    /// The part of the picture that the path's light belongs to, decided at its first scattering vertex.
    part: Option<Part>,
    /// Events of class S since the last one of class D, or since the light.
    chain: u32,
}

impl LightTracer<'_> {
    fn trace(&mut self, emission: &Emission, time: f64, stream: &mut Stream) {
        let settings = &self.world.scene.settings;
        let origin = emission.ray_origin();
        let mut walk = Walk {
            ray: Ray::new(origin, emission.direction).at_time(time),
            w: emission.direction,
            inside: self.world.inside(origin, time),
            flux: emission.flux.0,
            scatter_events: 0,
            leading_events: Some(0),
            past_glossy: Some(LightKind { part: Part::Direct, arrival: Arrival::Straight, group: self.group }),
            group: self.group,
            part: None,
            chain: 0,
        };
        for edge in 1..settings.max_depth {
            let met = match &self.world.regions {
                None => self.world.intersect(&walk.ray),
                Some(regions) => match self.fly(regions, &mut walk, edge, stream) {
                    Flown::Surface(si) => Some(si),
                    Flown::Escaped => None,
                    Flown::Stopped(at) if self.scatter_in_medium(regions, &mut walk, &at, edge, stream) => continue,
                    Flown::Stopped(_) => None,
                },
            };
            let Some(si) = met else { return };
            let bsdf = self.world.bsdf_unfiltered(&si);
            // Light at the first vertex itself, L D E, belongs to the paths that may come from everywhere.
            if bsdf.has_scatter() && (edge > 1 || self.first_event == FirstEvent::Scatter) {
                if !bsdf.is_glossy() && walk.scatter_events > settings.max_bounces {
                    return;
                }
                self.connect(&walk, &si, &bsdf, stream);
            }
            if !advance(&mut walk, &si, &bsdf, edge, stream) {
                return;
            }
            if let Some(regions) = &self.world.regions {
                walk.inside = regions.beyond(walk.inside, &si, walk.w);
            }
            let is_delta = walk.leading_events.is_some();
            if edge == 1 && is_delta != (self.first_event == FirstEvent::Delta) {
                return;
            }
        }
    }

    /// A filter may carry a splat in from a pixel or two outside.
    fn is_near_film(&self, seen: &Connection) -> bool {
        let film = self.world.scene.camera.resolution.map(f64::from);
        let near = |x: f64, size: f64| x > -2.0 && x < size + 2.0;
        near(seen.raster.x, film[0]) && near(seen.raster.y, film[1])
    }

    fn connect(&mut self, walk: &Walk, si: &Interaction, bsdf: &Bsdf, stream: &mut Stream) {
        let lens = ConcentricDisk.sample(stream.uniform2());
        let Some(seen) = self.camera.at(si.time).connect(si.p, lens).filter(|seen| self.is_near_film(seen)) else {
            return;
        };
        let f = bsdf.f(si.wo, seen.w, TransportMode::Importance) * cosine(si, seen.w);
        let value = walk.flux * f * seen.importance;
        if value.is_black() {
            return;
        }
        if let Some(left) = self.world.seen(si, seen.w, seen.origin.distance(si.p), walk.inside) {
            self.splats.add_splat(seen.raster.x, seen.raster.y, kind_at(walk, bsdf.is_glossy()), value * left);
        }
    }
}

/// The cosine at a scattering vertex with the particle's correction for shading normals.
fn cosine(si: &Interaction, wi: Dir3) -> f64 {
    si.ns.dot(wi).abs() * shading_normal_factor(si.wo, wi, si.ns, si.ng)
}

/// Direct: L D E; caustic: L S⁺ D …; indirect: L D … as in the eye path's parts, which look on past glossy surfaces.
fn kind_at(walk: &Walk, glossy: bool) -> LightKind {
    if let Some(past_glossy) = walk.past_glossy.filter(|_| glossy) {
        return past_glossy;
    }
    let part = walk.part.unwrap_or(match walk.leading_events {
        Some(0) => Part::Direct,
        Some(_) => Part::Caustic,
        None => Part::Indirect,
    });
    let arrival = match (walk.scatter_events > 0, walk.chain > 0) {
        (false, false) => Arrival::Straight,
        (false, true) => Arrival::Focused,
        (true, true) => Arrival::SentBack,
        (true, false) => Arrival::Scattered,
    };
    LightKind { part, arrival, group: walk.group }
}

/// Samples the next direction; false where the path ends.
fn advance(walk: &mut Walk, si: &Interaction, bsdf: &Bsdf, edge: u32, stream: &mut Stream) -> bool {
    let (uc, u) = (stream.uniform(), stream.uniform2());
    let Some(next) = bsdf.sample(si.wo, uc, u, TransportMode::Importance) else { return false };
    let before = walk.flux.max_component();
    walk.flux *= next.weight;
    match next.event {
        Event::Scatter { .. } => {
            walk.flux *= shading_normal_factor(si.wo, next.wi, si.ns, si.ng);
            if bsdf.is_glossy() {
                walk.leading_events = walk.leading_events.map(|n| n + 1);
                walk.chain += 1;
            } else {
                note_scattering(walk);
            }
        }
        Event::DeltaReflection { .. } | Event::DeltaTransmission { .. } => {
            walk.leading_events = walk.leading_events.map(|n| n + 1);
            walk.chain += 1;
            walk.past_glossy = None;
        }
    }
    if walk.flux.is_black() || !survives_roulette(walk, before, edge, stream) {
        return false;
    }
    walk.w = next.wi;
    walk.ray = si.ray(next.wi);
    true
}

/// Roulette on what the event left of `before`, so that flux stays near the photon's own.
fn survives_roulette(walk: &mut Walk, before: f64, edge: u32, stream: &mut Stream) -> bool {
    let q = (walk.flux.max_component() / before).min(1.0);
    if edge > 2 && q < 1.0 {
        if stream.uniform() >= q {
            return false;
        }
        walk.flux *= 1.0 / q;
    }
    true
}

/// Notes an event of class D.
fn note_scattering(walk: &mut Walk) {
    let here = kind_at(walk, false);
    walk.part.get_or_insert(if here.part == Part::Caustic { here.part } else { Part::Indirect });
    (walk.past_glossy, walk.leading_events, walk.chain) = (Some(here), None, 0);
    walk.scatter_events += 1;
}
