//! The eye's path through participating media: volumetric path tracing.
//!
//! On every edge a place of scattering is drawn in proportion to what is left there (`medium::homogeneous`); it is a vertex
//! of class D like one on a matte surface. From it a light is looked for, weighted by the power heuristic against the
//! direction that the phase function draws [Veach97 9.2.4]. Where nothing that is scattered would be the eye's, light is
//! only attenuated.

use std::ops::ControlFlow;

use super::{Aside, EyePathTracer, Seen, Walk, survives_roulette};
use crate::estimate::beams::{EyeSegment, Place};
use crate::film::{EyeSample, LightKind, Part};
use crate::light::Receiver;
use crate::light::select::LightChoice;
use crate::math::Ray;
use crate::medium::{HenyeyGreenstein, Regions, Stretch, Way};
use crate::radiometry::measure::power_heuristic;
use crate::render::partition::EyeFinds;
use crate::sampling::Stream;
use crate::world::{Flown, MediumPoint};

/// How many of the edges behind a bounce ask for beams, for all of them: each crosses hundreds, and a pixel averages many.
const ASKING_BEHIND_A_BOUNCE: f64 = 0.25;

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
    ) -> Flown<MediumPoint> {
        let may_scatter =
            self.task.finds != EyeFinds::Emitters && !walk.looks_for_lights_only && walk.bounces <= self.max_bounces;
        let asked = self.beams.filter(|_| may_scatter && self.task.finds.leaves_focused() && !walk.shared);
        let asking = if walk.bounces == 0 { 1.0 } else { ASKING_BEHIND_A_BOUNCE };
        let (scattered, straight) = (self.task.finds.leaves_scattered(walk.bounces), walk.walked.straight_at(false));
        let eye = walk.differential.columns().map(|c| (c.dx * self.sample_radius, c.dw * self.sample_radius));
        let bounces = if walk.bounces == 0 { u32::MAX } else { self.max_bounces.saturating_sub(walk.bounces) };
        let parts = walk.scattered.is_none();
        let start = parts.then(|| walk.clone());
        let (ray, w, beta) = (walk.ray, walk.w, &mut walk.beta);
        let along_rays = asked.is_none_or(|beams| beams.asks_along_rays());
        self.world.fly(regions, &ray, &mut walk.inside, |stretch, inside| {
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
            if let Some(start) = &start {
                let walk = Walk { beta: before, inside, ..start.clone() };
                self.add_direct_light_along(regions, &walk, stretch, stream, &mut seen.sample);
            }
            let (event, weight) = way.draw(before, stream.uniform2());
            *beta = before * if parts { way.transmittance() } else { weight };
            let Some(t) = event else { return ControlFlow::Continue(()) };
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
            let Some(start) = &start else { return ControlFlow::Break(at) };
            seen.medium(regions, &at, edge);
            let mut walk = Walk { beta: before * weight, inside, ..start.clone() };
            if self.scatter_in_medium(regions, &mut walk, &at, edge, stream, &mut seen.sample) {
                aside.push(Aside { walk, edge: edge + 1 });
            }
            ControlFlow::Continue(())
        })
    }

    /// Light from lights at a place in a medium, and the way on; false where the path ends.
    pub(super) fn scatter_in_medium(
        &self,
        regions: &Regions,
        walk: &mut Walk,
        at: &MediumPoint,
        edge: u32,
        stream: &mut Stream,
        sample: &mut EyeSample,
    ) -> bool {
        let phase = HenyeyGreenstein::new(regions.get(at.medium).asymmetry);
        if walk.beta.is_black() {
            return false;
        }
        // What the eye's own ray scatters has been looked for along all of it.
        if walk.scattered.is_some() {
            self.add_direct_light_in_medium(regions, walk, at, stream, sample);
        }
        let u = walk.first_bounce.take().map_or_else(|| stream.uniform2(), |(_, u)| u);
        let (wi, pdf) = phase.turn(walk.w, u);
        walk.walked = walk.walked.scattered(false);
        walk.looks_for_lights_only = self.task.finds.leaves_scattered(walk.bounces);
        walk.bounces += 1;
        walk.chain = 0;
        walk.scattered = Some((Receiver { p: at.p, n: None }, pdf));
        walk.differential = self.gathered_over(wi, pdf);
        if !survives_roulette(walk, edge, stream) {
            return false;
        }
        walk.w = wi;
        walk.ray = Ray::new(at.p, wi).at_time(walk.ray.time);
        true
    }

    fn add_direct_light_in_medium(
        &self,
        regions: &Regions,
        walk: &mut Walk,
        at: &MediumPoint,
        stream: &mut Stream,
        sample: &mut EyeSample,
    ) {
        let (choice, u) = walk.first_light.take().unwrap_or_else(|| (stream.uniform(), stream.uniform2()));
        let Some(choice) = self.world.lights.pick(&Receiver { p: at.p, n: None }, choice) else { return };
        self.add_light_at(regions, walk, at, (choice, u), sample);
    }

    /// Light from a light that a stretch of the eye's own ray scatters once: at a place drawn for that light, on every such
    /// stretch. `walk` is how it came to the stretch.
    fn add_direct_light_along(
        &self,
        regions: &Regions,
        walk: &Walk,
        stretch: &Stretch,
        stream: &mut Stream,
        sample: &mut EyeSample,
    ) {
        let (choice, u) = walk.first_light.unwrap_or_else(|| (stream.uniform(), stream.uniform2()));
        let [side, channel, place] = [stream.uniform(), stream.uniform(), stream.uniform()];
        let (ray, time) = (&walk.ray, walk.ray.time);
        // The light's own numbers say which point of it is meant: with each of them the mean over the places is the light there.
        let middle = ray.at(0.5 * (stretch.from + stretch.to));
        let Some(choice) = self.world.lights.pick(&Receiver { p: middle, n: None }, choice) else { return };
        let point = self.world.lights.sample_li(choice.light, middle, u, time);
        let point = point.filter(|found| found.distance.is_finite()).map(|found| middle + found.wi * found.distance);
        let way = regions.way(stretch, ray.origin, walk.w);
        let Some((t, weight)) = way.draw_towards(point, walk.beta, [side, channel, place]) else { return };
        let lit = Walk { beta: walk.beta * weight, ..walk.clone() };
        let at = MediumPoint { p: ray.at(t), t, time, medium: stretch.medium };
        self.add_light_at(regions, &lit, &at, (choice, u), sample);
    }

    fn add_light_at(
        &self,
        regions: &Regions,
        walk: &Walk,
        at: &MediumPoint,
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
                power_heuristic((pdf * chance).get(), value)
            }
        };
        let weight = weight * self.part_of(walk, choice.light);
        let light = walk.beta * found.weight.0 * left * (value * weight / choice.pmf.0);
        let part = if walk.order() == 0 { Part::Direct } else { Part::Indirect };
        let group = self.world.scene.light_groups.of(choice.light);
        sample.add(LightKind { part, arrival: walk.walked.straight_at(false), group }, light);
    }
}
