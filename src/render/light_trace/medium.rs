//! Light paths through participating media: what is left of them, and where media scatter them.

use std::ops::ControlFlow;

use super::{LightTracer, Walk, kind_at, note_scattering, survives_roulette};
use crate::math::Ray;
use crate::medium::{HenyeyGreenstein, Regions};
use crate::photon::FirstEvent;
use crate::sampling::Stream;
use crate::sampling::warp::{ConcentricDisk, Warp};
use crate::world::{Flown, MediumPoint};

impl LightTracer<'_> {
    /// To the next surface, or to where a medium scatters. A first event in a medium belongs to the paths that set out
    /// everywhere.
    pub(super) fn fly(&self, regions: &Regions, walk: &mut Walk, edge: u32, stream: &mut Stream) -> Flown<MediumPoint> {
        let bounces = self.world.scene.settings.max_bounces;
        let may_scatter = (edge > 1 || self.first_event == FirstEvent::Scatter) && walk.scatter_events <= bounces;
        let (ray, w, flux) = (walk.ray, walk.w, &mut walk.flux);
        self.world.fly(regions, &ray, &mut walk.inside, |stretch, _| {
            let way = regions.way(stretch, ray.origin, w);
            if !may_scatter || !way.medium.scatters() {
                *flux *= way.transmittance();
                return ControlFlow::Continue(());
            }
            let (event, weight) = way.draw(*flux, stream.uniform2());
            *flux *= weight;
            match event {
                None => ControlFlow::Continue(()),
                Some(t) => ControlFlow::Break(MediumPoint { p: ray.at(t), t, time: ray.time, medium: stretch.medium }),
            }
        })
    }

    /// Connects the place to the camera, and goes on; false where the path ends.
    pub(super) fn scatter_in_medium(
        &mut self,
        regions: &Regions,
        walk: &mut Walk,
        at: &MediumPoint,
        edge: u32,
        stream: &mut Stream,
    ) -> bool {
        if walk.flux.is_black() {
            return false;
        }
        let phase = HenyeyGreenstein::new(regions.get(at.medium).asymmetry);
        self.connect_medium(regions, walk, at, &phase, stream);
        let before = walk.flux.max_component() / regions.get(at.medium).albedo().max_component();
        note_scattering(walk);
        if !survives_roulette(walk, before, edge, stream) {
            return false;
        }
        (walk.w, _) = phase.turn(walk.w, stream.uniform2());
        walk.ray = Ray::new(at.p, walk.w).at_time(at.time);
        true
    }

    fn connect_medium(
        &mut self,
        regions: &Regions,
        walk: &Walk,
        at: &MediumPoint,
        phase: &HenyeyGreenstein,
        stream: &mut Stream,
    ) {
        let lens = ConcentricDisk.sample(stream.uniform2());
        let Some(seen) = self.camera.at(at.time).connect(at.p, lens).filter(|seen| self.is_near_film(seen)) else {
            return;
        };
        let value = walk.flux * (phase.between(walk.w, seen.w) * seen.importance);
        let ray = at.shadow_ray(seen.w, seen.origin.distance(at.p));
        if let Some(left) = self.world.transmittance(regions, &ray, walk.inside) {
            self.splats.add_splat(seen.raster.x, seen.raster.y, kind_at(walk, false), value * left);
        }
    }
}
