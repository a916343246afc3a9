//! A photon's way through participating media.
//!
//! Of a photon that reaches the next surface what the media left of it goes on there, so that a lattice of photons stays
//! one. What they scatter goes on from one place, drawn on the way, as from a surface of class D: decided by roulette, so
//! that flux stays what it was. Where it is a beam's, its way is stored (PHOTON_DIFFERENTIALS 8).

use std::ops::ControlFlow;

use super::{Branch, PhotonTracer};
use crate::differential::{Differential, SurfaceMotion};
use crate::math::{Frame, Normal3, Ray};
use crate::medium::{HenyeyGreenstein, Inside, Regions, Stretch, Way};
use crate::photon::beam::{Beam, BeamWidth};
use crate::photon::columns::Columns;
use crate::photon::kinds::Kinds;
use crate::photon::path::{FirstEvent, survive};
use crate::radiometry::Spectrum;
use crate::sampling::Stream;
use crate::surface::Interaction;
use crate::world::Flown;

/// One of the kinds' lists of beams.
type Kind = fn(&mut Kinds<Vec<Beam>>) -> &mut Vec<Beam>;

impl<const N: usize, const T: usize> PhotonTracer<'_, N, T> {
    /// To the next surface, with what is left; `None` where nothing gets there.
    pub(super) fn cross(
        &mut self,
        regions: &Regions,
        branch: &mut Branch<N, T>,
        stream: &mut Stream,
    ) -> Option<Interaction> {
        let world = self.world;
        let ray = Ray::new(branch.origin, branch.w).at_time(self.time);
        let (mut inside, mut left) = (branch.inside, Spectrum::ONE);
        let flown = world.fly(regions, &ray, &mut inside, |stretch, inside| {
            let way = regions.way(stretch, branch.origin, branch.w);
            if way.medium.scatters() {
                let there = Left { stretch, way, left, inside };
                self.store_beam(branch, &there);
                self.scatter_in_medium(branch, &there, stream);
            }
            left *= way.transmittance();
            ControlFlow::<()>::Continue(())
        });
        let Flown::Surface(si) = flown else {
            self.counts.escaped += 1;
            return None;
        };
        branch.inside = inside;
        branch.flux = branch.flux * left;
        branch.share *= left.max_component();
        if branch.flux.is_zero() {
            self.counts.absorbed += 1;
            return None;
        }
        Some(si)
    }

    /// Which beams a photon that has come this way is one of; as [`PhotonTracer::kind_of`].
    fn beam_kind(&self, branch: &Branch<N, T>) -> Option<Kind> {
        match (branch.chain, branch.bounces, self.first_event) {
            (0, 0, _) => None,
            (0, _, _) if !self.stores_scattered => None,
            (0, _, FirstEvent::Delta) => Some(|beams| &mut beams.onward_scattered),
            (0, _, FirstEvent::Scatter) => Some(|beams| &mut beams.scattered),
            (_, _, FirstEvent::Scatter) => Some(|beams| &mut beams.bounced),
            (_, 0, FirstEvent::Delta) => Some(|beams| &mut beams.caustic),
            (_, _, FirstEvent::Delta) => Some(|beams| &mut beams.onward),
        }
    }

    fn store_beam(&mut self, branch: &Branch<N, T>, there: &Left) {
        let Some(kind) = self.beam_kind(branch).filter(|_| self.beams.is_some()) else { return };
        let part = if branch.bounces == 0 { self.part } else { 1.0 };
        let flux = branch.flux * there.left * part;
        if !flux.0.is_finite() {
            self.counts.broken_flux += 1;
            return;
        }
        let columns = moved(&branch.columns, there.stretch.from);
        if !columns.is_finite() {
            self.counts.broken_columns += 1;
            return;
        }
        let mut origin = branch.origin + branch.w * there.stretch.from;
        for sweep in columns.time.dx.to_array() {
            origin += sweep * self.time_cells.to_middle(self.time);
        }
        let beam = Beam {
            origin,
            w: branch.w,
            length: there.stretch.length(),
            flux,
            medium: there.stretch.medium,
            bounces: branch.bounces,
            width: BeamWidth::of(&columns, self.spread, &self.time_cells, &Frame::from_unit(branch.w)),
        };
        if let Some(beams) = &mut self.beams {
            kind(beams).push(beam);
            self.counts.photons_stored += 1;
        }
    }

    /// Goes on from one place of the stretch.
    fn scatter_in_medium(&mut self, branch: &Branch<N, T>, there: &Left, stream: &mut Stream) {
        let may = branch.edge > 1 || self.first_event == FirstEvent::Scatter;
        let Some(bounces) = self.bounces.filter(|bounces| may && branch.bounces < bounces.max) else { return };
        if branch.edge + 1 > self.limits.max_depth {
            self.counts.max_depth += 1;
            return;
        }
        let flux = branch.flux.0 * there.left;
        let Some((t, event)) = there.way.draw_within(flux, stream.uniform2()) else { return };
        let p = branch.origin + branch.w * t;
        let phase = HenyeyGreenstein::new(there.way.medium.asymmetry);
        let next = bounces.sample_in_medium(p, branch.w, &phase, stream);
        let weight = there.left * event * next.weight;
        let share = weight.max_component();
        let below = if next.aimed { self.limits.roulette_below } else { 1.0 };
        let Some(q) = survive(bounces.share * share.min(1.0), below, stream) else {
            self.counts.roulette += 1;
            return;
        };
        let there_columns = moved(&branch.columns, t);
        // Along the way into which it goes on its place does not matter.
        let across = Normal3::from_unit(next.wi.to_vec());
        let cell = bounces.columns(&there_columns.cell, across, &next, branch.bounces + 1);
        let mut columns = there_columns.scattered(cell, &SurfaceMotion::STILL);
        columns.survive(q);
        self.pending.push(Branch {
            origin: p,
            w: next.wi,
            columns,
            flux: branch.flux * (weight / q),
            share: branch.share * share / q,
            edge: branch.edge + 1,
            chain: 0,
            deltas: 0,
            bounces: branch.bounces + 1,
            inside: there.inside,
        });
        self.counts.bounced += 1;
    }
}

/// What has got to a stretch of medium.
struct Left<'a> {
    stretch: &'a Stretch,
    way: Way<'a>,
    left: Spectrum,
    inside: Inside,
}

/// The columns `t` metres on, not put onto any surface.
fn moved<const N: usize, const T: usize>(columns: &Columns<N, T>, t: f64) -> Columns<N, T> {
    fn on<const K: usize>(d: &Differential<K>, t: f64) -> Differential<K> {
        Differential { dx: d.dx + d.dw * t, dw: d.dw }
    }
    Columns { cell: on(&columns.cell, t), time: on(&columns.time, t) }
}
