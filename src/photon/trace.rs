//! One photon's way: fly, hit, transport the columns, store, scatter, roulette.
//!
//! L S⁺ D paths: the photon is stored at every vertex with a non-delta lobe that it reached over at least one delta
//! event, and goes on only through delta lobes. Where an interface both reflects and refracts, both branches are
//! followed while they are strong, so that a lattice of photons stays a lattice behind the glass.

use super::footprint::Spread;
use super::path::{PathLimits, PhotonCounts, survive};
use super::record::Photon;
use crate::differential::health::MAX_SPREAD;
use crate::differential::{Differential, Refraction, narrowed, reflect, refract, transfer};
use crate::light::Emission;
use crate::math::{Dir3, Point3, Ray};
use crate::radiometry::Flux;
use crate::sampling::Stream;
use crate::surface::{Bsdf, DeltaBranch, Interaction};
use crate::world::World;

/// Traces photons into a list; one for each unit of work. N = 4 columns go with each of them, or none for the estimates that
/// have a width of their own.
pub struct PhotonTracer<'a, const N: usize> {
    world: &'a World,
    limits: PathLimits,
    spread: Spread,
    pending: Vec<Branch<N>>,
    pub photons: Vec<Photon>,
    pub counts: PhotonCounts,
}

/// A ray of light on its way.
struct Branch<const N: usize> {
    origin: Point3,
    w: Dir3,
    columns: Differential<N>,
    flux: Flux,
    /// Share of the photon's flux, before roulette.
    share: f64,
    /// Delta events so far.
    events: u32,
}

impl<'a, const N: usize> PhotonTracer<'a, N> {
    pub fn new(world: &'a World, limits: PathLimits, spread: Spread) -> Self {
        let (pending, photons, counts) = (Vec::new(), Vec::new(), PhotonCounts::default());
        PhotonTracer { world, limits, spread, pending, photons, counts }
    }

    /// Follows one emitted photon to the end of all its branches.
    pub fn trace(&mut self, emission: &Emission, stream: &mut Stream) {
        let (origin, w) = (emission.ray_origin(), emission.direction);
        let (columns, flux) = (emission.jacobian.first(), emission.flux);
        self.pending.push(Branch { origin, w, columns, flux, share: 1.0, events: 0 });
        while let Some(branch) = self.pending.pop() {
            self.fly(branch, stream);
        }
    }

    fn fly(&mut self, branch: Branch<N>, stream: &mut Stream) {
        let Some(si) = self.world.intersect(&Ray::new(branch.origin, branch.w)) else {
            self.counts.escaped += 1;
            return;
        };
        let columns = transfer(&branch.columns, branch.w, si.t, si.ng);
        if !columns.is_finite() {
            self.counts.broken_columns += 1;
            return;
        }
        let bsdf = self.world.bsdf_unfiltered(&si);
        if bsdf.has_scatter() && branch.events > 0 {
            self.store(&si, &branch, &columns);
        }
        if bsdf.has_delta() {
            self.scatter(&si, &bsdf, &branch, &columns, stream);
        } else if branch.events > 0 {
            self.counts.absorbed += 1;
        } else {
            self.counts.direct += 1;
        }
    }

    fn store(&mut self, si: &Interaction, branch: &Branch<N>, columns: &Differential<N>) {
        if !branch.flux.0.is_finite() {
            self.counts.broken_flux += 1;
            return;
        }
        let form = self.spread.footprint(columns, &Photon::frame_of(si.ng));
        self.photons.push(Photon::new(si.p, -branch.w, si.ng, branch.flux, form, si.object));
        self.counts.photons_stored += 1;
    }

    fn scatter(
        &mut self,
        si: &Interaction,
        bsdf: &Bsdf,
        branch: &Branch<N>,
        columns: &Differential<N>,
        stream: &mut Stream,
    ) {
        // The edge after event number `events + 1` is edge `events + 2` of the path.
        if branch.events + 2 > self.limits.max_depth {
            self.counts.max_depth += 1;
            return;
        }
        let mut followed = 0;
        let branches = bsdf.delta_branches(si.wo);
        self.counts.normals_disagree += branches.refused();
        for delta in branches {
            let share = branch.share * delta.weight.max_component();
            let Some(q) = survive(share, self.limits.roulette_below, stream) else {
                self.counts.roulette += 1;
                continue;
            };
            let (w, columns) = redirected(si, branch.w, columns, &delta);
            let (columns, narrow) = narrowed(&columns, MAX_SPREAD);
            self.counts.narrowed_columns += u64::from(narrow);
            self.pending.push(Branch {
                origin: si.ray_origin(w),
                w,
                columns: columns.scaled(q.sqrt().recip()),
                flux: branch.flux * (delta.weight / q),
                share: share / q,
                events: branch.events + 1,
            });
            followed += 1;
        }
        self.counts.split += u64::from(followed > 1);
    }
}

/// The direction and columns after a delta event.
fn redirected<const N: usize>(
    si: &Interaction,
    w: Dir3,
    columns: &Differential<N>,
    delta: &DeltaBranch,
) -> (Dir3, Differential<N>) {
    match delta.eta {
        None => reflect(columns, w, si.ns, &si.shape),
        Some(eta) => match refract(columns, w, si.ns, &si.shape, eta) {
            Refraction::Transmitted(w, columns) | Refraction::TotalReflection(w, columns) => (w, columns),
        },
    }
}
