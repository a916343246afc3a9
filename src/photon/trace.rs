//! One photon's way: fly, hit, transport the columns, store, scatter, roulette.
//!
//! Events are of class S, focusing: delta lobes and those of microfacets; or D, scattering. A photon is stored at every
//! surface of class D that it reached over at least one S, or, where photons bring all light between surfaces that scatter,
//! straight from one of these; and goes on through S. Where an interface both reflects and refracts, both branches are
//! followed while they are strong, so that a lattice of photons stays a lattice behind the glass.
//!
//! Two kinds of photons share the light out by the first event: S for caustics, L S⁺ D, and what they send on,
//! L S⁺ D … S⁺ D; scattering for all other light that was scattered before, L D … S⁺ D.

mod medium;

use super::beam::Beam;
use super::bounce::Bounces;
use super::columns::Columns;
use super::edge;
use super::footprint::Spread;
use super::kinds::Kinds;
use super::path::{FirstEvent, PathLimits, PhotonCounts, survive};
use super::plan::{Population, Target};
use super::record::Photon;
use super::time_cells::TimeCells;
use crate::differential::{SurfaceMotion, blurred, bounced};
use crate::light::Emission;
use crate::math::{Dir3, Frame, Point3, Ray, Vec3};
use crate::medium::Inside;
use crate::radiometry::{Flux, Spectrum};
use crate::sampling::Stream;
use crate::surface::adjoint::shading_normal_factor;
use crate::surface::{Bsdf, Interaction, Passage, TransportMode};
use crate::world::World;

/// Traces photons into a list; one for each unit of work. N = 4 columns go with each of them, or none for the estimates that
/// have a width of their own; T = 1 of time where surfaces move, or none.
pub struct PhotonTracer<'a, const N: usize, const T: usize = 0> {
    world: &'a World,
    limits: PathLimits,
    spread: Spread,
    /// Semi-axis of a scattered photon's footprint at most, m.
    widest: f64,
    first_event: FirstEvent,
    /// The objects that count as their first, if not all do.
    group: Option<u32>,
    bounces: Option<Bounces>,
    sharing: f64,
    /// The photons' part of caustics.
    part: f64,
    /// Whether photons straight from a surface that scatters are stored, too.
    stores_scattered: bool,
    /// When the photon under way flies, s.
    time: f64,
    /// What of the shutter's interval photons stand for.
    time_cells: TimeCells,
    pending: Vec<Branch<N, T>>,
    pub stored: Kinds<Vec<Photon>>,
    /// Where photons are to become beams in media, which are then stored instead.
    pub beams: Option<Kinds<Vec<Beam>>>,
    pub counts: PhotonCounts,
}

/// Semi-axis of a scattered photon's footprint at most, in radii of the scene's bounding sphere: what is as wide as a room is even in it.
const WIDEST: f64 = 0.5;

/// One of the kinds' lists.
type Kind = fn(&mut Kinds<Vec<Photon>>) -> &mut Vec<Photon>;

/// A ray of light on its way.
#[derive(Clone, Copy)]
struct Branch<const N: usize, const T: usize> {
    origin: Point3,
    w: Dir3,
    columns: Columns<N, T>,
    flux: Flux,
    /// Share of the photon's flux, before roulette.
    share: f64,
    /// Number of the edge that it flies along, counted from 1.
    edge: u32,
    /// Events at mirrors, glasses and narrow lobes, S, since it was last scattered, or since the light.
    chain: u32,
    /// Those at the end of them that were delta events.
    deltas: u32,
    /// How often it was scattered by a wide lobe, D.
    bounces: u32,
    /// What it is inside of; not kept where there are no media.
    inside: Inside,
}

impl<const N: usize, const T: usize> Branch<N, T> {
    /// Goes on from `si` into `w` with `weight` of the flux and that `share` of the photon's, having survived roulette with
    /// the probability `q`; the caller sees to the columns of the event, and counts it.
    fn leave(&mut self, si: &Interaction, w: Dir3, weight: Spectrum, share: f64, q: f64) {
        self.origin = si.ray_origin(w);
        self.w = w;
        self.columns.survive(q);
        self.flux = self.flux * (weight / q);
        self.share = share / q;
        self.edge += 1;
        (self.chain, self.deltas) = (0, 0);
    }
}

impl<'a, const N: usize, const T: usize> PhotonTracer<'a, N, T> {
    /// For caustics, which end where they are stored.
    pub fn new(world: &'a World, limits: PathLimits, spread: Spread) -> Self {
        PhotonTracer {
            world,
            limits,
            spread,
            widest: WIDEST * world.scene.bounds.bounding_sphere().1,
            first_event: FirstEvent::Delta,
            group: None,
            bounces: None,
            sharing: f64::INFINITY,
            part: 1.0,
            stores_scattered: false,
            time: world.scene.shutter.open,
            time_cells: TimeCells::one(world.scene.shutter),
            pending: Vec::new(),
            stored: Kinds::default(),
            beams: None,
            counts: PhotonCounts::default(),
        }
    }

    /// For photons of this kind.
    pub fn of(self, population: &Population) -> Self {
        let &Population { first_event, bounces, sharing, stores_scattered, makes_beams, .. } = population;
        let beams = makes_beams.then(Kinds::default);
        PhotonTracer { first_event, bounces, sharing, stores_scattered, beams, ..self }
    }

    /// For photons towards a group of objects.
    pub fn towards(self, target: &Target) -> Self {
        PhotonTracer { group: target.group, ..self }
    }

    /// For photons of a light of whose caustics eye paths bring that part.
    pub fn beside_eyes(self, eyes_part: f64) -> Self {
        PhotonTracer { part: 1.0 - eyes_part, ..self }
    }

    /// For photons that stand for these parts of the shutter's interval.
    pub fn over(self, time_cells: TimeCells) -> Self {
        PhotonTracer { time_cells, ..self }
    }

    /// Follows one photon that was emitted at `time` to the end of all its branches.
    pub fn trace(&mut self, emission: &Emission, time: f64, stream: &mut Stream) {
        let (origin, w) = (emission.ray_origin(), emission.direction);
        let (columns, flux) = (Columns::emitted(emission, self.time_cells.length()), emission.flux);
        self.time = time;
        let inside = self.world.inside(origin, time);
        let mut branch =
            Branch { origin, w, columns, flux, share: 1.0, edge: 1, chain: 0, deltas: 0, bounces: 0, inside };
        loop {
            self.fly(&mut branch, stream);
            // Copied but once: it is large.
            let Some(next) = self.pending.last() else { break };
            branch = *next;
            self.pending.pop();
        }
    }

    /// A time for a photon, drawn from `stream` if anything moves.
    pub fn draw_time(&self, stream: &mut Stream) -> f64 {
        self.world.draw_time(stream)
    }

    /// Whether such a photon is of use: it makes a caustic; or, if it is to be scattered first, it goes on.
    pub fn is_useful(&mut self, pilot: &Emission, time: f64, stream: &mut Stream) -> bool {
        self.stored.caustic.clear();
        let bounced = self.counts.bounced;
        self.trace(pilot, time, stream);
        match self.first_event {
            FirstEvent::Delta => !self.stored.caustic.is_empty(),
            FirstEvent::Scatter => self.counts.bounced > bounced,
        }
    }

    fn fly(&mut self, branch: &mut Branch<N, T>, stream: &mut Stream) {
        let world = self.world;
        let met = match &world.regions {
            None => {
                let si = world.intersect(&Ray::new(branch.origin, branch.w).at_time(self.time));
                self.counts.escaped += u64::from(si.is_none());
                si
            }
            Some(regions) => self.cross(regions, branch, stream),
        };
        let Some(si) = met else { return };
        if branch.edge == 1 && self.is_of_another_group(&si) {
            self.counts.other_group += 1;
            return;
        }
        let straight_from_bounce = branch.chain == 0 && branch.bounces > 0;
        let motion = self.motion(&si);
        if let Some(bounces) = self.bounces.filter(|_| straight_from_bounce) {
            branch.columns.cell = bounces.landing(&branch.columns.cell, &si);
        }
        branch.columns.transfer(branch.w, &si, &motion);
        if !branch.columns.is_finite() {
            self.counts.broken_columns += 1;
            return;
        }
        let bsdf = self.world.bsdf_unfiltered(&si);
        if bsdf.has_scatter()
            && self.beams.is_none()
            && let Some(kind) = self.kind_of(branch, bsdf.is_glossy())
        {
            self.store(&si, branch, kind);
        }
        let may = |event| branch.edge > 1 || self.first_event == event;
        let focuses = [bsdf.has_delta(), bsdf.is_glossy()].map(|has_lobe| has_lobe && may(FirstEvent::Delta));
        let casts = world.scene.objects[si.object.index()].caustics.cast;
        self.counts.not_cast += u64::from(!casts && focuses != [false; 2]);
        let [scatters, glances] = focuses.map(|focuses| focuses && casts);
        let bounces = self
            .bounces
            .filter(|bounces| bsdf.is_diffuse() && may(FirstEvent::Scatter) && branch.bounces < bounces.max);
        if !scatters && !glances && bounces.is_none() {
            let ends = if branch.edge == 1 { &mut self.counts.direct } else { &mut self.counts.absorbed };
            *ends += 1;
            return;
        }
        if branch.edge + 1 > self.limits.max_depth {
            self.counts.max_depth += 1;
            return;
        }
        if scatters {
            self.scatter(&si, &bsdf, branch, stream);
        }
        if glances {
            self.glance(&si, &bsdf, branch, stream);
        }
        if let Some(bounces) = &bounces {
            self.bounce(bounces, &si, &bsdf, branch, stream);
        }
    }

    /// Whether photons towards another group than this tracer's bring the light that meets `si` first.
    fn is_of_another_group(&self, si: &Interaction) -> bool {
        let of = |object| self.world.casters.as_ref().and_then(|casters| casters.group_of(object));
        self.group.is_some_and(|group| of(si.object).is_some_and(|other| other != group))
    }

    /// How the surface moves in a time cell.
    fn motion(&self, si: &Interaction) -> SurfaceMotion {
        if T == 0 { SurfaceMotion::STILL } else { si.motion(&self.world.scene).per(self.time_cells.length()) }
    }

    /// Where a photon that has come this way is stored; `None`: it is none of the photons' light. The eye looks on past a
    /// glossy surface, so that only what comes over delta events is the photons' there.
    fn kind_of(&self, branch: &Branch<N, T>, on_glossy: bool) -> Option<Kind> {
        let chain = if on_glossy { branch.deltas } else { branch.chain };
        if on_glossy && chain == 0 {
            return None;
        }
        match (chain, branch.bounces, self.first_event) {
            (0, 0, _) => None,
            (0, _, _) if !self.stores_scattered => None,
            (0, _, FirstEvent::Delta) => Some(|stored| &mut stored.onward_scattered),
            (0, _, FirstEvent::Scatter) => Some(|stored| &mut stored.scattered),
            (_, _, FirstEvent::Scatter) => Some(|stored| &mut stored.bounced),
            (_, 0, FirstEvent::Delta) => Some(|stored| &mut stored.caustic),
            (_, _, FirstEvent::Delta) => Some(|stored| &mut stored.onward),
        }
    }

    fn store(&mut self, si: &Interaction, branch: &Branch<N, T>, kind: Kind) {
        let columns = &branch.columns;
        if !branch.flux.0.is_finite() {
            self.counts.broken_flux += 1;
            return;
        }
        let flux = if branch.bounces == 0 { branch.flux * self.part } else { branch.flux };
        if si.is_carried(&self.world.scene) {
            // Along with the object to where light of all times meets; the flux stands for the same irradiance if the
            // object is stretched on the way.
            let to_rest = si.to_rest(&self.world.scene);
            let columns = Columns { cell: to_rest.columns(&columns.cell), time: to_rest.columns(&columns.time) };
            let (wi, flux) = (to_rest.direction(-branch.w), flux * to_rest.area(si.ng));
            let cells = self.time_cells.together();
            return self.store_at(&to_rest.interaction(si), wi, (flux, branch.bounces), &columns, (cells, true), kind);
        }
        let (cells, goes) = (self.time_cells, self.time_cells.sweeps());
        self.store_at(si, -branch.w, (flux, branch.bounces), columns, (cells, goes), kind);
    }

    /// Stores a photon that stands for its cell of `cells`: with the way that its light goes in it, if it `goes`, or else
    /// widened by that.
    fn store_at(
        &mut self,
        si: &Interaction,
        wi: Dir3,
        (flux, bounces): (Flux, u32),
        columns: &Columns<N, T>,
        (cells, goes): (TimeCells, bool),
        kind: Kind,
    ) {
        let (mut p, frame) = (si.p, Photon::frame_of(si.ng));
        let mut form = self.spread.footprint(&columns.cell, &frame);
        // A column is the way in a cell of the tracer's.
        let ways = columns.time.dx.to_array().map(|way| way * (self.time_cells.count() as f64 / cells.count() as f64));
        for way in ways {
            if !goes {
                form = form.plus(cells.swept(way, &frame));
            }
            p += way * cells.to_middle(self.time);
        }
        let has_columns = matches!(self.spread, Spread::Columns { .. });
        if has_columns {
            form = form.on_curved(&frame, &si.shape);
        }
        let is_scattered = bounces > 0 && has_columns;
        if is_scattered {
            form = form.at_most(self.widest);
        }
        let mut photon = Photon::new(p, wi, si.ng, flux, form, bounces);
        for way in ways.into_iter().filter(|_| goes) {
            photon = going(photon, way, &frame, &cells);
        }
        let list = kind(&mut self.stored);
        list.push(photon);
        self.counts.photons_stored += 1;
        // Photons that come from a light directly are narrow, and may end in a shadow at a wall.
        if is_scattered && form.trace() > 0.0 {
            let images = edge::images(self.world, &photon, si.time);
            self.counts.edge_images += images.len() as u64;
            list.extend(images);
        }
    }

    /// What leaves `si` is to be followed, too.
    fn go_on(&mut self, si: &Interaction, branch: &mut Branch<N, T>) {
        if let Some(regions) = &self.world.regions {
            branch.inside = regions.beyond(branch.inside, si, branch.w);
        }
        self.pending.push(*branch);
    }

    /// Goes on through all delta lobes that are strong enough.
    fn scatter(&mut self, si: &Interaction, bsdf: &Bsdf, branch: &Branch<N, T>, stream: &mut Stream) {
        let mut followed = 0;
        let branches = bsdf.delta_branches(si.wo);
        self.counts.normals_disagree += branches.refused();
        for delta in branches {
            let share = branch.share * delta.weight.max_component();
            let Some(q) = survive(share, self.limits.roulette_below, stream) else {
                self.counts.roulette += 1;
                continue;
            };
            let mut next = *branch;
            let w = next.columns.turn(si, branch.w, (si.ns, delta.eta), &self.motion(si));
            self.counts.narrowed_columns += u64::from(next.columns.narrow());
            next.leave(si, w, delta.weight, share, q);
            (next.chain, next.deltas) = (branch.chain + 1, branch.deltas + 1);
            self.go_on(si, &mut next);
            followed += 1;
        }
        self.counts.split += u64::from(followed > 1);
    }

    /// Goes on over a facet of a glossy surface, or several, drawn at random.
    fn glance(&mut self, si: &Interaction, bsdf: &Bsdf, branch: &Branch<N, T>, stream: &mut Stream) {
        let (uc, u, mode) = (stream.uniform(), stream.uniform2(), TransportMode::Importance);
        let sample = bsdf.sample_scatter(si.wo, uc, u, mode);
        let Some((sample, passage)) = sample.and_then(|sample| Some((sample, bsdf.passage(si.wo, sample.wi)?))) else {
            self.counts.absorbed += 1;
            return;
        };
        let weight = sample.weight * shading_normal_factor(si.wo, sample.wi, si.ns, si.ng);
        let share = branch.share * weight.max_component();
        let Some(q) = survive(share, self.limits.roulette_below, stream) else {
            self.counts.roulette += 1;
            return;
        };
        let mut next = *branch;
        let cell = 1.0 / (self.sharing * bsdf.pdf_scatter(si.wo, sample.wi, mode).get());
        match passage {
            Passage::Facet { normal, eta } => {
                let normal = if normal.dot(si.ns.as_dir()) < 0.0 { -normal } else { normal };
                next.columns.turn(si, branch.w, (normal, eta), &self.motion(si));
                self.counts.narrowed_columns += u64::from(next.columns.narrow());
                next.columns.cell = blurred(&next.columns.cell, si.ng, sample.wi, cell);
            }
            Passage::Many => {
                let cell = bounced(&next.columns.cell, si.ng, sample.wi, cell);
                next.columns = next.columns.scattered(cell, &self.motion(si));
            }
        }
        next.leave(si, sample.wi, weight, share, q);
        next.chain = branch.chain + 1;
        self.go_on(si, &mut next);
    }

    /// Goes on through the lobes that are not deltas. What is lost in the mean is lost at roulette, so that flux stays what
    /// it was, but not of photons on their way to where they are wanted: there are few of them.
    fn bounce(&mut self, bounces: &Bounces, si: &Interaction, bsdf: &Bsdf, branch: &Branch<N, T>, stream: &mut Stream) {
        let Some(sample) = bounces.sample(si, bsdf, stream) else {
            self.counts.absorbed += 1;
            return;
        };
        let weight = sample.weight.max_component();
        let below = if sample.aimed { self.limits.roulette_below } else { 1.0 };
        let Some(q) = survive(bounces.share * weight.min(1.0), below, stream) else {
            self.counts.roulette += 1;
            return;
        };
        let mut next = *branch;
        let cell = bounces.columns(&branch.columns.cell, si.ng, &sample, branch.bounces + 1);
        next.columns = branch.columns.scattered(cell, &self.motion(si));
        next.leave(si, sample.wi, sample.weight, branch.share * weight, q);
        next.bounces += 1;
        self.go_on(si, &mut next);
        self.counts.bounced += 1;
    }
}

/// The photon with the way that its light goes in its cell; what a record has no room for is widened by it.
fn going(photon: Photon, way: Vec3, frame: &Frame, cells: &TimeCells) -> Photon {
    photon.over(frame.project(way)).unwrap_or_else(|| {
        let form = photon.form().plus(cells.swept(way, frame));
        photon.moved(photon.position(), photon.flux(), form)
    })
}
