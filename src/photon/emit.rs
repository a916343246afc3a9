//! Photons leave a light, a run of them at a time: sample point → ray, flux, columns.

use std::ops::Range;
use std::sync::Arc;

use super::emission_points::EmissionPoints;
use super::guide::Guide;
use super::plan::{EmissionPlan, Target};
use crate::light::{Emission, Lights};
use crate::sampling::Stream;
use crate::scene::LightId;
use crate::world::World;

/// A run of consecutive points of one light: a unit of work.
#[derive(Clone, Debug)]
pub struct EmissionUnit {
    pub light: LightId,
    /// As its plan's, and the next one.
    pub target: Target,
    pub eyes_part: f64,
    guide: Option<Arc<Guide>>,
    points: EmissionPoints,
    range: Range<u64>,
}

impl EmissionUnit {
    /// Cuts a pass's photons into units of about `size`, for each of the `instants` at which they set out, s; without these
    /// each has its own time.
    pub fn all(plans: &[EmissionPlan], world: &World, pass: u32, size: u64, instants: &[f64]) -> Vec<EmissionUnit> {
        plans.iter().flat_map(|plan| Self::parts(plan, world, pass, instants)).flat_map(|unit| unit.cut(size)).collect()
    }

    /// A plan's photons, those of an instant together.
    fn parts(plan: &EmissionPlan, world: &World, pass: u32, instants: &[f64]) -> Vec<EmissionUnit> {
        let EmissionPlan { light, target, points: n, share, ref guide, eyes_part } = *plan;
        let unit = |points: EmissionPoints| {
            let range = 0..points.count();
            EmissionUnit { light, target, eyes_part, guide: guide.clone(), points, range }
        };
        if instants.is_empty() {
            return vec![unit(EmissionPoints::new(world, light, &target, share, n, pass))];
        }
        // A single photon cannot set out at several times.
        let count = (instants.len() as u64).min(n);
        let points = EmissionPoints::in_parts(world, light, &target, share, (n / count * count, count), pass);
        let time = |k: u64| instants[k as usize * instants.len() / count as usize];
        (0..count).map(|k| unit(points.clone().at_once(k, count, time(k)))).collect()
    }

    /// In units of about `size` photons.
    fn cut(self, size: u64) -> Vec<EmissionUnit> {
        let n = self.range.end;
        let kept = self.guide.as_ref().map_or(1.0, |guide| guide.kept());
        let step = ((size as f64 / kept).ceil() as u64).max(1);
        (0..n)
            .step_by(step as usize)
            .map(|start| EmissionUnit { range: start..(start + step).min(n), ..self.clone() })
            .collect()
    }

    /// Emits the unit's photons in order, each at its time and with its own stream, and returns how many; samples that
    /// carry no flux count, but `photon` does not get them.
    pub fn emit(&self, lights: &Lights, mut photon: impl FnMut(&Emission, f64, &mut Stream)) -> u64 {
        let mut emitted = 0;
        for i in self.range.clone() {
            let mut stream = self.points.stream(i);
            let u = self.points.point(i, &mut stream);
            let keep = self.guide.as_ref().map_or(1.0, |guide| guide.keep(self.points.leading(u)));
            if keep < 1.0 && stream.uniform() >= keep {
                continue;
            }
            emitted += 1;
            let time = self.points.time(i, &mut stream);
            let Some(mut emission) = lights.emit(self.light, u, &self.target.aim, time) else { continue };
            if !emission.flux.is_zero() {
                self.points.share(&mut emission, keep);
                photon(&emission, time, &mut stream);
            }
        }
        emitted
    }
}
