//! The eye's path through participating media: volumetric path tracing.
//!
//! On every edge a place of scattering is drawn in proportion to what is left there (`medium::homogeneous`); it is a vertex
//! of class D like one on a matte surface. A light is looked for from a place of its own on the same edge, half of these spread
//! over the angles under which the light sees the edge; both are weighed by the power heuristic, with the densities of the
//! place and of the direction [Veach97 9.2.4]. Where nothing that is scattered would be the eye's, light is only attenuated.

use std::ops::ControlFlow;

use super::{Aside, EyePathTracer, Scattered, Seen, Walk, survives_roulette};
use crate::estimate::beams::{EyeSegment, Place};
use crate::film::{EyeSample, LightKind, Part};
use crate::light::Receiver;
use crate::light::select::LightChoice;
use crate::math::Ray;
use crate::medium::{Chances, HenyeyGreenstein, Regions, Stretch, Way};
use crate::radiometry::measure::power_heuristic;
use crate::render::partition::EyeFinds;
use crate::sampling::Stream;
use crate::world::{Flown, MediumPoint};

/// How many of the edges behind a bounce ask for beams, for all of them: each crosses hundreds, and a pixel averages many.
const ASKING_BEHIND_A_BOUNCE: f64 = 0.25;

/// Light is scattered towards the eye's path at a place, which may have been drawn in two ways.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    pub(super) at: MediumPoint,
    chances: Chances,
}

impl Seen {
    /// Light is scattered at a place in a medium on edge `edge`: the layers that show what the eye sees first.
    pub(super) fn medium(&mut self, regions: &Regions, at: &MediumPoint, edge: u32) {
        if edge == 1 && self.sample.depth.is_none() {
            self.sample.depth = Some(at.t);
            self.sample.position = at.p.to_vec();
        }
        if !self.scatters {
            self.sample.albedo = regions.get(at.medium).albedo();
        }
        self.scatters = true;
    }
}

impl EyePathTracer<'_> {
    /// To the next surface, or to where a medium scatters; `walk.beta` is what is left. Straight from the eye the path goes on
    /// to the surface in any case, with what the media leave of it, and what they scatter is a path aside: a bright surface
    /// behind fog would else be seen by some samples and not by others.
    pub(super) fn fly(
        &self,
        regions: &Regions,
        walk: &mut Walk,
        edge: u32,
        stream: &mut Stream,
        seen: &mut Seen,
        aside: &mut Vec<Aside>,
    ) -> Flown<Event> {
        let may_scatter =
            self.task.finds != EyeFinds::Emitters && !walk.looks_for_lights_only && walk.bounces <= self.max_bounces;
        let asked = self.beams.filter(|_| may_scatter && self.task.finds.leaves_focused() && !walk.shared);
        let asking = if walk.bounces == 0 { 1.0 } else { ASKING_BEHIND_A_BOUNCE };
        let (scattered, straight) = (self.task.finds.leaves_scattered(walk.bounces), walk.walked.straight_at(false));
        let eye = walk.differential.columns().map(|c| (c.dx * self.sample_radius, c.dw * self.sample_radius));
        let bounces = if walk.bounces == 0 { u32::MAX } else { self.max_bounces.saturating_sub(walk.bounces) };
        let parts = walk.scattered.is_none();
        let mut start = walk.clone();
        let (ray, w, beta) = (walk.ray, walk.w, &mut walk.beta);
        let along_rays = asked.is_none_or(|beams| beams.asks_along_rays());
        let flown = self.world.fly(regions, &ray, &mut walk.inside, |stretch, inside| {
            let (medium, way) = (regions.get(stretch.medium), regions.way(stretch, ray.origin, w));
            if !may_scatter || !medium.scatters() {
                *beta *= way.transmittance();
                return ControlFlow::Continue(());
            }
            if let Some(beams) = asked.filter(|_| along_rays)
                && (asking == 1.0 || stream.uniform() < asking)
            {
                let from = stretch.from;
                let segment = EyeSegment {
                    origin: ray.at(from),
                    w,
                    length: stretch.length(),
                    id: stretch.medium,
                    medium,
                    profile: Way { origin: ray.at(from), from: 0.0, to: stretch.length(), ..way }.profile(),
                    eye: eye.map(|(dx, dw)| (dx + dw * from, dw)),
                    bounces,
                };
                beams.along(&segment, scattered, straight, |kind, light| {
                    seen.sample.add(kind, *beta * light * (1.0 / asking))
                });
            }
            let before = *beta;
            start.beta = before;
            start.inside = inside;
            self.add_direct_light_along(regions, &mut start, stretch, stream, &mut seen.sample);
            let (place, weight) = way.draw(before, stream.uniform2());
            *beta = before * if parts { way.transmittance() } else { weight };
            let Some(t) = place else { return ControlFlow::Continue(()) };
            let at = MediumPoint { p: ray.at(t), t, time: ray.time, medium: stretch.medium };
            if let Some(beams) = asked.filter(|_| !along_rays)
                && (asking == 1.0 || stream.uniform() < asking)
            {
                let eye = eye.map(|(dx, dw)| dx + dw * t);
                let place = Place { p: at.p, w, id: stretch.medium, medium, eye, bounces };
                beams.at(&place, scattered, straight, |kind, light| {
                    seen.sample.add(kind, before * weight * light * (1.0 / asking))
                });
            }
            let event = Event { at, chances: way.chances(before, t) };
            if !parts {
                return ControlFlow::Break(event);
            }
            seen.medium(regions, &at, edge);
            let mut walk = Walk { beta: before * weight, ..start.clone() };
            if self.scatter_in_medium(regions, &mut walk, &event, edge, stream) {
                aside.push(Aside { walk, edge: edge + 1 });
            }
            ControlFlow::Continue(())
        });
        walk.first_light = start.first_light;
        flown
    }

    /// The way on from a place in a medium, whose light from lights has been looked for along the whole stretch; false where
    /// the path ends.
    pub(super) fn scatter_in_medium(
        &self,
        regions: &Regions,
        walk: &mut Walk,
        Event { at, chances }: &Event,
        edge: u32,
        stream: &mut Stream,
    ) -> bool {
        let phase = HenyeyGreenstein::new(regions.get(at.medium).asymmetry);
        if walk.beta.is_black() {
            return false;
        }
        let u = walk.first_bounce.take().map_or_else(|| stream.uniform2(), |(_, u)| u);
        let (wi, pdf) = phase.turn(walk.w, u);
        walk.walked = walk.walked.scattered(false);
        walk.looks_for_lights_only = self.task.finds.leaves_scattered(walk.bounces);
        walk.bounces += 1;
        walk.chain = 0;
        walk.scattered = Some(Scattered { from: Receiver { p: at.p, n: None }, pdf, place: Some(*chances) });
        walk.differential = self.gathered_over(wi, pdf);
        if !survives_roulette(walk, edge, stream) {
            return false;
        }
        walk.w = wi;
        walk.ray = Ray::new(at.p, wi).at_time(walk.ray.time);
        true
    }

    /// Light from a light that a stretch scatters once towards the path: at a place drawn for that light, whether the path goes
    /// on from the stretch or past it. Left to the places that paths go on from, it would be seldom and bright close to lamps.
    /// `walk` is how it came to the stretch.
    fn add_direct_light_along(
        &self,
        regions: &Regions,
        walk: &mut Walk,
        stretch: &Stretch,
        stream: &mut Stream,
        sample: &mut EyeSample,
    ) {
        // The eye's own ray and the first vertex behind it may each be the first that looks for a light.
        let first = if walk.scattered.is_none() { walk.first_light } else { walk.first_light.take() };
        let (choice, u) = first.unwrap_or_else(|| (stream.uniform(), stream.uniform2()));
        let [side, channel, place] = [stream.uniform(), stream.uniform(), stream.uniform()];
        let (ray, time) = (&walk.ray, walk.ray.time);
        // The light's own numbers say which point of it is meant: with each of them the mean over the places is the light there.
        let middle = ray.at(0.5 * (stretch.from + stretch.to));
        let Some(choice) = self.world.lights.pick(&Receiver { p: middle, n: None }, choice) else { return };
        let point = self.world.lights.sample_li(choice.light, middle, u, time);
        let point = point.filter(|found| found.distance.is_finite()).map(|found| middle + found.wi * found.distance);
        let way = regions.way(stretch, ray.origin, walk.w);
        let Some((chances, weight)) = way.draw_towards(point, walk.beta, [side, channel, place]) else { return };
        let lit = Walk { beta: walk.beta * weight, ..walk.clone() };
        let at = MediumPoint { p: ray.at(chances.t), t: chances.t, time, medium: stretch.medium };
        self.add_light_at(regions, &lit, &Event { at, chances }, (choice, u), sample);
    }

    fn add_light_at(
        &self,
        regions: &Regions,
        walk: &Walk,
        Event { at, chances }: &Event,
        (choice, u): (LightChoice, [f64; 2]),
        sample: &mut EyeSample,
    ) {
        let Some(found) = self.world.lights.sample_li(choice.light, at.p, u, at.time) else { return };
        if found.weight.is_zero() {
            return;
        }
        let value = HenyeyGreenstein::new(regions.get(at.medium).asymmetry).between(walk.w, found.wi);
        let ray = at.shadow_ray(found.wi, found.distance);
        let Some(left) = self.world.transmittance(regions, &ray, walk.inside) else { return };
        let weight = match found.pdf {
            None => 1.0,
            Some(pdf) => {
                // As the phase function's own paths count it, wherever the light was chosen.
                let chance = self.world.lights.pick_pmf(&Receiver { p: at.p, n: None }, choice.light);
                let point = found.distance.is_finite().then(|| at.p + found.wi * found.distance);
                power_heuristic((pdf * chance).get() * chances.odds(point), value)
            }
        };
        let weight = weight * self.part_of(walk, choice.light);
        let light = walk.beta * found.weight.0 * left * (value * weight / choice.pmf.0);
        let part = if walk.order() == 0 { Part::Direct } else { Part::Indirect };
        let group = self.world.scene.light_groups.of(choice.light);
        sample.add(LightKind { part, arrival: walk.walked.straight_at(false), group }, light);
    }
}
