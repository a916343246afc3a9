//! Where in the sample squares of a light, and when, the photons of a pass set out.
//!
//! The columns of photon i are the Jacobian of the light's emission map times 2/√π of the sides of its cell in the
//! sample squares: the ellipse inscribed in a pair of columns then covers 1/(n p) for a cell of 1/n, the photon's share
//! of the light (`[Frisvad-slides]` for uniform p, PHOTON_DIFFERENTIALS 2.2 for any p).

use std::f64::consts::FRAC_2_SQRT_PI;

use super::plan::Target;
use super::share::Share;
use crate::light::Emission;
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

/// Every `step`-th of a pass's points of a light, from number `first` on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    first: u64,
    step: u64,
}

impl EmissionPoints {
    /// `n` > 0 points for `light`.
    pub fn new(world: &World, light: LightId, target: &Target, share: Share, n: u64, pass: u32) -> Self {
        EmissionPoints::in_parts(world, light, target, share, (n, 1), pass)
    }

    /// `n` points that set out in `parts` parts, each of which is to be as even as all, `share` being one point's of all.
    pub(super) fn in_parts(
        world: &World,
        light: LightId,
        target: &Target,
        share: Share,
        (n, parts): (u64, u64),
        pass: u32,
    ) -> Self {
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
        // Of all points, of what one stands for, of a part's.
        let [whole, cell, part] = [1, parts, parts * parts]
            .map(|count| share.parted(count).sides(if collimated { [aspect, 1.0] } else { [1.0, aspect] }));
        let [whole, part] = [whole, part].map(|cell| leading(collimated, cell));
        EmissionPoints {
            pattern,
            collimated,
            aspect,
            lattice: Rank1Lattice::in_parts(n, parts, whole, part),
            cell,
            shift,
            times,
            seed,
            pass,
            number,
            part: Part { first: 0, step: 1 },
        }
    }

    /// The `k`th of `count` parts of the points, whose number is a multiple of that: all of its photons set out at `time`, s.
    /// Every part of a lattice is a lattice, and where light hardly moves from one part's time to the next they make up the
    /// whole again.
    pub(super) fn at_once(self, k: u64, count: u64, time: f64) -> Self {
        EmissionPoints { times: Times::Instant(time), part: Part { first: k, step: count }, ..self }
    }

    /// How many there are.
    pub(super) fn count(&self) -> u64 {
        self.lattice.len() / self.part.step
    }

    /// The random numbers of photon `i`'s own path.
    pub fn stream(&self, i: u64) -> Stream {
        // The number sits above any photon index.
        Stream::new(self.seed, Purpose::Photon, self.pass, self.place(i) | self.number << 44)
    }

    /// Its number among the points of all parts.
    fn place(&self, i: u64) -> u64 {
        self.part.first + self.part.step * i
    }

    /// Point `i` as (u, v, θ, φ) in [0, 1)⁴; `stream` is the photon's own.
    pub fn point(&self, i: u64, stream: &mut Stream) -> [f64; 4] {
        let n = self.count();
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
                let [a, b, c, d] = self.lattice.point(self.place(i));
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
    pub fn share(&self, emission: &mut Emission, keep: f64) {
        emission.flux = emission.flux / (keep * self.lattice.len() as f64);
        let inscribed = FRAC_2_SQRT_PI / keep.sqrt();
        emission.jacobian = emission.jacobian.scaled_each(self.cell.map(|side| inscribed * side));
    }
}

/// (u, v; θ, φ) with the pair in front that leads; its own inverse.
pub(super) fn leading(collimated: bool, [u, v, theta, phi]: [f64; 4]) -> [f64; 4] {
    if collimated { [u, v, theta, phi] } else { [theta, phi, u, v] }
}
