//! Photons leave a light: sample point → ray, flux, columns.
//!
//! The columns of photon i are the Jacobian of the light's emission map times 2/√π of the sides of its cell in the
//! sample squares: the ellipse inscribed in a pair of columns then covers 1/(n p) for a cell of 1/n, the photon's share
//! of the light (`[Frisvad-slides]` for uniform p, PHOTON_DIFFERENTIALS 2.2 for any p).

use std::f64::consts::FRAC_2_SQRT_PI;
use std::ops::Range;
use std::sync::Arc;

use super::bounce::Bounces;
use super::guide::Guide;
use super::path::FirstEvent;
use super::share::Share;
use crate::light::{Aim, Emission, Lights};
use crate::sampling::lattice::Rank1Lattice;
use crate::sampling::{Purpose, Stream, qmc};
use crate::scene::settings::EmissionPattern;
use crate::scene::{LightId, Shutter};
use crate::world::World;

/// When photons set out.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Times {
    /// All at once, s.
    Instant(f64),
    /// Any time while the shutter is open, drawn for each.
    Drawn(Shutter),
    /// The same by a sequence that fills every run of photons evenly, shifted by so much of the interval.
    Even(Shutter, f64),
}

/// The points in the sample square (u, v; θ, φ) at which one light emits in one part of a pass; point i is a pure function
/// of (seed, pass, part, light, i).
///
/// The pair that decides where a photon lands leads, positions for collimated beams and directions for everything else:
/// its aspect shapes strata and cells, and it comes first in the lattice.
#[derive(Clone, Debug)]
pub struct EmissionPoints {
    pattern: EmissionPattern,
    collimated: bool,
    /// Width over height of what the leading pair is mapped to.
    aspect: f64,
    lattice: Rank1Lattice,
    /// Sides of a photon's cell in the order (u, v; θ, φ).
    cell: [f64; 4],
    shift: [[f64; 2]; 2],
    times: Times,
    seed: u64,
    pass: u32,
    /// Of a light and a group that it is aimed at.
    number: u64,
    part: Part,
}

/// Which of a pass's photons of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    number: u32,
    /// The first of its photons among all.
    first: u64,
    /// How much of the light it stands for.
    size: f64,
}

impl Part {
    const WHOLE: Part = Part { number: 0, first: 0, size: 1.0 };

    /// `count` > 0 equal parts of `n` ≥ `count` photons, each with how many they are.
    fn all(n: u64, count: u32) -> impl Iterator<Item = (Part, u64)> {
        let first = move |number: u32| n * u64::from(number) / u64::from(count);
        let size = 1.0 / f64::from(count);
        (0..count).map(move |number| (Part { number, first: first(number), size }, first(number + 1) - first(number)))
    }

    /// A number that is another for each of `number` and part.
    fn of_light(&self, number: u64) -> u64 {
        number | u64::from(self.number) << 32
    }
}

/// Whither a light's photons set out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    pub aim: Aim,
    /// Only where one of this group is met first do they go on, if a group is meant.
    pub group: Option<u32>,
}

impl Target {
    /// All that is within reach.
    pub fn all(aim: Aim) -> Target {
        Target { aim, group: None }
    }
}

impl EmissionPoints {
    /// `n` > 0 points for `light`.
    pub fn new(world: &World, light: LightId, target: &Target, share: Share, n: u64, pass: u32) -> Self {
        let (settings, source, aim) = (&world.scene.settings, world.lights.get(light), &target.aim);
        let number = u64::from(light.0) + u64::from(target.group.unwrap_or(0)) * world.lights.len() as u64;
        let mut stream = Stream::new(settings.seed, Purpose::Lattice, pass, number);
        let shift = [stream.uniform2(), stream.uniform2()];
        let shutter = world.scene.shutter;
        let times = match settings.emission {
            _ if shutter.is_instant() => Times::Instant(shutter.open),
            EmissionPattern::Random => Times::Drawn(shutter),
            EmissionPattern::Jittered | EmissionPattern::Lattice => Times::Even(shutter, stream.uniform()),
        };
        let aspect = source.emission_aspect(aim);
        let (pattern, collimated, seed) = (settings.emission, source.is_collimated(), settings.seed);
        let cell = share.sides(if collimated { [aspect, 1.0] } else { [1.0, aspect] });
        EmissionPoints {
            pattern,
            collimated,
            aspect,
            lattice: Rank1Lattice::new(n, leading(collimated, cell)),
            cell,
            shift,
            times,
            seed,
            pass,
            number,
            part: Part::WHOLE,
        }
    }

    /// As `part` of several, all of whose photons set out at `time`, s: a pattern of its own, so that each moment's light is
    /// as even as that of a scene which stands still.
    fn at_once(self, part: Part, time: f64) -> Self {
        let mut stream = Stream::new(self.seed, Purpose::Lattice, self.pass, part.of_light(self.number));
        let shift = [stream.uniform2(), stream.uniform2()];
        EmissionPoints { times: Times::Instant(time), shift, part, ..self }
    }

    /// The random numbers of photon `i`'s own path.
    pub fn stream(&self, i: u64) -> Stream {
        // The number sits above any photon index.
        Stream::new(self.seed, Purpose::Photon, self.pass, (self.part.first + i) | self.number << 44)
    }

    /// Point `i` as (u, v, θ, φ) in [0, 1)⁴; `stream` is the photon's own.
    pub fn point(&self, i: u64, stream: &mut Stream) -> [f64; 4] {
        let n = self.lattice.len();
        let (lead, other) = match self.pattern {
            EmissionPattern::Random => (stream.uniform2(), stream.uniform2()),
            EmissionPattern::Jittered => {
                // The second pair visits its strata in another order, so that the pairs are independent.
                let rotation = (self.shift[1][0] * n as f64) as u64;
                let second = qmc::permuted(i, n, rotation);
                let lead = qmc::stratum(i, n, self.aspect, stream.uniform2());
                (lead, qmc::stratum(second, n, 1.0, stream.uniform2()))
            }
            EmissionPattern::Lattice => {
                let [a, b, c, d] = self.lattice.point(i);
                (qmc::shifted([a, b], self.shift[0]), qmc::shifted([c, d], self.shift[1]))
            }
        };
        leading(self.collimated, [lead[0], lead[1], other[0], other[1]])
    }

    /// When photon `i` sets out, s; `stream` is the photon's own.
    pub fn time(&self, i: u64, stream: &mut Stream) -> f64 {
        match self.times {
            Times::Instant(time) => time,
            Times::Drawn(shutter) => shutter.time(stream.uniform()),
            Times::Even(shutter, shift) => shutter.time(qmc::shifted(qmc::r2(i), [shift; 2])[0]),
        }
    }

    /// A point of [`EmissionPoints::point`] with the pair in front that leads.
    pub fn leading(&self, u: [f64; 4]) -> [f64; 4] {
        leading(self.collimated, u)
    }

    /// Turns a sample of the light into a photon's share of it: flux divided, columns scaled to the photon's cell. Of
    /// points that are kept with the probability `keep` each stands for 1/keep of them.
    pub fn share(&self, mut emission: Emission, keep: f64) -> Emission {
        emission.flux = emission.flux * self.part.size / (keep * self.lattice.len() as f64);
        let inscribed = FRAC_2_SQRT_PI / keep.sqrt();
        emission.jacobian = emission.jacobian.scaled_each(self.cell.map(|side| inscribed * side));
        emission
    }
}

/// (u, v; θ, φ) with the pair in front that leads; its own inverse.
pub(super) fn leading(collimated: bool, [u, v, theta, phi]: [f64; 4]) -> [f64; 4] {
    if collimated { [u, v, theta, phi] } else { [theta, phi, u, v] }
}

/// What one light sends in every pass.
#[derive(Clone, Debug)]
pub struct EmissionPlan {
    pub light: LightId,
    pub target: Target,
    /// Points that fill its emission map.
    pub points: u64,
    /// The cell that each stands for.
    pub share: Share,
    /// Which of them are kept; all of them if there is none.
    pub guide: Option<Arc<Guide>>,
    /// Which part of the light's caustics eye paths bring; photons bring the rest.
    pub eyes_part: f64,
}

impl EmissionPlan {
    /// `n` photons for each light, evenly over its map; lights that are due none are left out. `share` gives the cell of
    /// each of a light's n photons.
    pub fn even(
        lights: &Lights,
        target: Target,
        due: &[u64],
        share: impl Fn(LightId, u64) -> Share,
    ) -> Vec<EmissionPlan> {
        let lights = lights.iter().zip(due).filter(|&(_, &n)| n > 0);
        lights
            .map(|((light, _), &points)| EmissionPlan {
                light,
                target,
                points,
                share: share(light, points),
                guide: None,
                eyes_part: 0.0,
            })
            .collect()
    }

    /// About how many photons are emitted.
    pub fn photons(&self) -> f64 {
        self.points as f64 * self.guide.as_ref().map_or(1.0, |guide| guide.kept())
    }
}

/// What all lights send of one kind of photons in every pass.
#[derive(Clone, Debug)]
pub struct Population {
    pub plans: Vec<EmissionPlan>,
    pub first_event: FirstEvent,
    /// How they go on from surfaces that scatter, if they do.
    pub bounces: Option<Bounces>,
    /// So many of them share the directions of a glossy lobe out between them: the cell of each is 1/(sharing p), sr.
    pub sharing: f64,
    /// Whether they bring the light that comes straight from surfaces that scatter, too.
    pub stores_scattered: bool,
    /// Whether they become beams in media, instead of photons on surfaces.
    pub makes_beams: bool,
}

impl Population {
    pub const NONE: Population = Population {
        plans: Vec::new(),
        first_event: FirstEvent::Delta,
        bounces: None,
        sharing: f64::INFINITY,
        stores_scattered: false,
        makes_beams: false,
    };
}

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
        let unit = |points: EmissionPoints, n: u64| EmissionUnit {
            light,
            target,
            eyes_part,
            guide: guide.clone(),
            points,
            range: 0..n,
        };
        if instants.is_empty() {
            return vec![unit(EmissionPoints::new(world, light, &target, share, n, pass), n)];
        }
        // A single photon cannot set out at several times.
        let count = (instants.len() as u64).min(n) as u32;
        let share = share.parted(count);
        Part::all(n, count)
            .map(|(part, n)| {
                let time = instants[part.number as usize * instants.len() / count as usize];
                unit(EmissionPoints::new(world, light, &target, share, n, pass).at_once(part, time), n)
            })
            .collect()
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
            if let Some(emission) = lights.emit(self.light, u, &self.target.aim, time).filter(|e| !e.flux.is_zero()) {
                photon(&self.points.share(emission, keep), time, &mut stream);
            }
        }
        emitted
    }
}
