//! One path from the eye: next-event estimation with multiple importance sampling at every vertex that scatters,
//! specular chains followed, and the points where the photon map is asked.
//!
//! Where photons own a class of light ([`super::partition`]), the path ends instead of going on to it: at the first delta
//! event behind a scattering vertex, or at the next surface that scatters; over delta events and glossy surfaces it looks on
//! for lights whose caustics are partly its own. It drops nothing else: E S* L stays its own, and shadow rays never cross a
//! delta lobe. Light that an object would focus which is to cast no caustics is nobody's.

mod medium;

use super::beam_light::BeamLight;
use super::partition::{EyeFinds, EyeTask, Walked};
use crate::camera::CameraRay;
use crate::differential::{Column, Differential, Refraction, reflect, refract, transfer};
use crate::estimate::{Asks, GatherPoint, Turn};
use crate::film::{Arrival, EyeSample, LightKind, Met, Part};
use crate::light::Receiver;
use crate::math::{Dir3, Frame, Point3, Ray, Vec3};
use crate::medium::{Chances, Inside};
use crate::radiometry::{Pdf, SolidAngle, Spectrum, measure::power_heuristic};
use crate::sampling::{PixelSample, Stream};
use crate::scene::LightId;
use crate::surface::{Bsdf, BsdfSample, Event, Interaction, TransportMode};
use crate::world::{Flown, World};

/// A vertex whose light from photons is still to be added: radiance there times `beta` belongs to the sample.
pub struct Query {
    pub point: GatherPoint,
    pub beta: Spectrum,
    /// The vertex that fills the sample's `albedo`, `N` and `photons.density` layers.
    pub first: bool,
    /// Whether photons straight from surfaces that scatter are asked, too.
    pub scattered: bool,
    /// What light that comes straight to the vertex is to the eye.
    straight: Arrival,
}

impl Query {
    /// What light that reaches the vertex in this way is to the eye.
    pub fn arrival(&self, here: Arrival) -> Arrival {
        if self.straight == Arrival::Straight { here } else { self.straight }
    }
}

/// The fixed part of eye-path tracing.
pub struct EyePathTracer<'a> {
    pub world: &'a World,
    pub task: &'a EyeTask,
    /// What photons bring in media that scatter.
    pub beams: Option<&'a BeamLight>,
    pub max_depth: u32,
    pub max_bounces: u32,
    /// Semi-axes of an eye sample's footprint, in pixels.
    pub sample_radius: f64,
}

/// Paths longer than this play roulette on what they still carry.
const ROULETTE_FROM: u32 = 5;

/// What is taken of such a footprint's width: in a room of mirrors and glass a quarter takes six tenths of the noise of the
/// photons' lookups away and adds 0.1 % to what edges lose, the whole takes seven tenths and adds 2.5 %.
const GATHER_WIDTH: f64 = 0.25;

/// Side of a pixel's whole cell of directions at most, radians: a hemisphere's.
const WIDEST_GATHER: f64 = 2.5;

/// A path under way.
#[derive(Clone)]
struct Walk {
    ray: Ray,
    turn: Turn,
    /// What is drawn first at a vertex that scatters: which light and where on it, which lobe and whither.
    first_light: Option<(f64, [f64; 2])>,
    first_bounce: Option<(f64, [f64; 2])>,
    w: Dir3,
    differential: Differential<2>,
    beta: Spectrum,
    /// Events of class D so far.
    bounces: u32,
    /// Delta events since the last event that was none, or since the eye.
    chain: u32,
    /// What light that the edge under way runs into is to the eye.
    walked: Walked,
    /// Whether there was a delta event behind one that was none.
    sent_back: bool,
    scattered: Option<Scattered>,
    /// Whether all other light of the edge under way is the photons'.
    looks_for_lights_only: bool,
    /// Whether photons bring their part of that of lights, too.
    shared: bool,
    /// What the ray is inside of; not kept where there are no media.
    inside: Inside,
}

/// The last event that was no delta one.
#[derive(Clone, Copy)]
struct Scattered {
    from: Receiver,
    /// Of the direction that was drawn there.
    pdf: Pdf<SolidAngle>,
    /// How likely its place was drawn, in a medium.
    place: Option<Chances>,
}

impl Walk {
    fn new(camera_ray: &CameraRay, start: &PixelSample, turn: Turn) -> Walk {
        Walk {
            ray: camera_ray.ray,
            turn,
            first_light: Some((start.choices[0], start.light)),
            first_bounce: Some((start.choices[1], start.bounce)),
            w: camera_ray.direction,
            differential: camera_ray.differential,
            beta: Spectrum::ONE,
            bounces: 0,
            chain: 0,
            walked: Walked::START,
            sent_back: false,
            scattered: None,
            looks_for_lights_only: false,
            shared: false,
            inside: Inside::NOTHING,
        }
    }

    /// How often light that is found now was scattered before it came into the eye's sight; the eye looks on past mirrors,
    /// glasses and glossy surfaces.
    fn order(&self) -> u32 {
        self.bounces + u32::from(self.sent_back)
    }

    /// From here on photons own what surfaces that scatter send, and their part of what lights do.
    fn share(&mut self) {
        self.looks_for_lights_only = true;
        self.shared = true;
    }
}

/// What the eye has seen on the way so far.
struct Seen {
    sample: EyeSample,
    /// Whether something that scatters was among it.
    scatters: bool,
}

/// A way that is still to be followed from an edge on.
struct Aside {
    walk: Walk,
    edge: u32,
}

impl EyePathTracer<'_> {
    /// Traces one path, the sample of its pixel that `turn` says: it begins with the numbers of `start` and goes on with
    /// those of `stream`. Vertices for the photon map are appended to `queries`.
    pub fn trace(
        &self,
        camera_ray: &CameraRay,
        start: &PixelSample,
        turn: Turn,
        mut stream: Stream,
        queries: &mut Vec<Query>,
    ) -> EyeSample {
        let mut walk = Walk::new(camera_ray, start, turn);
        if self.world.regions.is_some() {
            walk.inside = self.world.inside(walk.ray.origin, walk.ray.time);
        }
        let mut seen = Seen { sample: EyeSample::of(&self.world.scene.light_groups), scatters: false };
        let mut aside = Vec::new();
        self.follow(walk, 1, &mut stream, &mut seen, queries, &mut aside);
        while let Some(Aside { walk, edge }) = aside.pop() {
            self.follow(walk, edge, &mut stream, &mut seen, queries, &mut aside);
        }
        seen.sample
    }

    /// Follows a path from edge `edge` on to its end. What media scatter beside the way that goes on is left to `aside`.
    fn follow(
        &self,
        mut walk: Walk,
        edge: u32,
        stream: &mut Stream,
        seen: &mut Seen,
        queries: &mut Vec<Query>,
        aside: &mut Vec<Aside>,
    ) {
        let walk = &mut walk;
        for edge in edge..=self.max_depth {
            let met = match &self.world.regions {
                None => self.world.intersect(&walk.ray),
                Some(regions) => match self.fly(regions, walk, edge, stream, seen, aside) {
                    Flown::Surface(si) => Some(si),
                    Flown::Escaped => None,
                    Flown::Stopped(event) => {
                        seen.medium(regions, &event.at, edge);
                        if self.scatter_in_medium(regions, walk, &event, edge, stream) {
                            continue;
                        }
                        return;
                    }
                },
            };
            let sample = &mut seen.sample;
            let Some(si) = met else {
                self.add_environment(walk, sample);
                return;
            };
            if edge == 1 && sample.depth.is_none() {
                sample.depth = Some(si.t);
                sample.position = si.p.to_vec();
                sample.met = Some(Met { object: si.object, material: si.material });
            }
            walk.differential = transfer(&walk.differential, walk.w, si.t, si.ng);
            self.add_emission(walk, &si, sample);
            let bsdf = self.world.bsdf(&si, &walk.differential);
            let caustics = self.world.scene.objects[si.object.index()].caustics;
            // What a glossy surface sends on to one that scatters is focused.
            if bsdf.is_glossy() && walk.bounces > 0 && !caustics.cast {
                return;
            }
            if bsdf.is_glossy() && walk.bounces > 0 && self.task.finds.leaves_focused() {
                if self.task.part.is_none() {
                    return;
                }
                walk.share();
            }
            if bsdf.is_glossy() || bsdf.has_scatter() && walk.bounces <= self.max_bounces {
                if walk.looks_for_lights_only && !(walk.shared && bsdf.is_glossy()) {
                    return;
                }
                if !seen.scatters {
                    sample.normal = si.ns.to_vec();
                    sample.albedo = bsdf.albedo(si.wo);
                    sample.without_caustics = !caustics.receive;
                }
                if self.task.finds != EyeFinds::Emitters {
                    self.add_direct_light(walk, &si, &bsdf, stream, sample);
                }
                if self.task.finds.leaves_focused() && !walk.shared {
                    queries.push(self.query(walk, &si, bsdf, !seen.scatters, stream));
                }
                seen.scatters = true;
            }
            if !self.advance(walk, &si, &bsdf, edge, stream) {
                return;
            }
        }
    }

    /// Samples the next direction; false where the path ends.
    fn advance(&self, walk: &mut Walk, si: &Interaction, bsdf: &Bsdf, edge: u32, stream: &mut Stream) -> bool {
        let first = if bsdf.has_scatter() { walk.first_bounce.take() } else { None };
        let (uc, u) = first.unwrap_or_else(|| (stream.uniform(), stream.uniform2()));
        let Some(next) = bsdf.sample(si.wo, uc, u, TransportMode::Radiance) else { return false };
        walk.beta *= next.weight;
        match next.event {
            Event::Scatter { pdf } => {
                let ends = !bsdf.is_glossy() && walk.bounces > self.max_bounces;
                if ends || self.task.finds == EyeFinds::Emitters {
                    return false;
                }
                walk.walked = walk.walked.scattered(bsdf.is_glossy());
                if !bsdf.is_glossy() {
                    walk.looks_for_lights_only = self.task.finds.leaves_scattered(walk.bounces);
                    walk.bounces += 1;
                }
                walk.chain = 0;
                walk.scattered = Some(Scattered { from: receiver(si), pdf, place: None });
                walk.differential = self.gathered_over(next.wi, pdf);
            }
            Event::DeltaReflection { .. } | Event::DeltaTransmission { .. } => {
                let casts = self.world.scene.objects[si.object.index()].caustics.cast;
                if walk.scattered.is_some() && !casts {
                    return false;
                }
                if walk.scattered.is_some() && self.task.finds.leaves_focused() {
                    if self.task.part.is_none() {
                        return false;
                    }
                    walk.share();
                }
                walk.walked = walk.walked.over_delta();
                walk.chain += 1;
                walk.sent_back |= walk.scattered.is_some();
                walk.differential = redirected(&walk.differential, walk.w, si, &next);
            }
        }
        if walk.beta.is_black() || !survives_roulette(walk, edge, stream) {
            return false;
        }
        walk.w = next.wi;
        walk.ray = si.ray(next.wi);
        if let Some(regions) = &self.world.regions {
            walk.inside = regions.beyond(walk.inside, si, next.wi);
        }
        true
    }

    fn add_emission(&self, walk: &mut Walk, si: &Interaction, sample: &mut EyeSample) {
        let Some(id) = self.world.scene.objects[si.object.index()].light else { return };
        let lights = &self.world.lights;
        let light = lights.get(id);
        let radiance = light.radiance(si.ng, si.wo).0;
        if !radiance.is_black() {
            let w = walk.w;
            let next_event =
                |from: &Receiver| lights.pdf_li(id, from.p, w, (si.p, si.ng), si.time) * lights.pick_pmf(from, id);
            self.add_found(walk, (id, radiance), sample, Some(si.p), next_event);
        }
    }

    fn add_environment(&self, walk: &mut Walk, sample: &mut EyeSample) {
        let lights = &self.world.lights;
        for (id, light) in lights.environments() {
            let (w, radiance) = (walk.w, light.environment_radiance(walk.w).0);
            if !radiance.is_black() {
                let next_event = |from: &Receiver| light.environment_pdf(w) * lights.pick_pmf(from, id);
                self.add_found(walk, (id, radiance), sample, None, next_event);
            }
        }
    }

    /// Adds light that the path ran into, at a point or infinitely far away, weighted against next-event estimation from the last scattering vertex.
    fn add_found(
        &self,
        walk: &mut Walk,
        (light, radiance): (LightId, Spectrum),
        sample: &mut EyeSample,
        point: Option<Point3>,
        next_event: impl Fn(&Receiver) -> Pdf<SolidAngle>,
    ) {
        let (part, weight) = match walk.scattered {
            None => (Part::Direct, 1.0),
            Some(_) if walk.chain > 0 => (Part::Caustic, 1.0),
            Some(Scattered { from, pdf, place }) => {
                let odds = place.map_or(1.0, |place| place.odds(point));
                let weight = power_heuristic(pdf.get(), next_event(&from).get() * odds);
                // The edge just flown belongs to the bounce before it.
                let part = match walk.order() {
                    1.. if walk.walked.from_glossy => Part::Caustic,
                    0 | 1 => Part::Direct,
                    _ => Part::Indirect,
                };
                (part, weight)
            }
        };
        let weight = weight * self.part_of(walk, light);
        let group = self.world.scene.light_groups.of(light);
        sample.add(LightKind { part, arrival: walk.walked.arrival, group }, walk.beta * radiance * weight);
    }

    /// What of a light's focused light eye paths bring.
    fn part_of(&self, walk: &Walk, light: LightId) -> f64 {
        if walk.shared { self.task.part.of(light) } else { 1.0 }
    }

    fn add_direct_light(
        &self,
        walk: &mut Walk,
        si: &Interaction,
        bsdf: &Bsdf,
        stream: &mut Stream,
        sample: &mut EyeSample,
    ) {
        let (choice, u) = walk.first_light.take().unwrap_or_else(|| (stream.uniform(), stream.uniform2()));
        let Some(choice) = self.world.lights.pick(&receiver(si), choice) else { return };
        let Some(found) = self.world.lights.sample_li(choice.light, si.p, u, si.time) else { return };
        let f = bsdf.f(si.wo, found.wi, TransportMode::Radiance) * si.ns.dot(found.wi).abs();
        if f.is_black() || found.weight.is_zero() {
            return;
        }
        let Some(left) = self.world.seen(si, found.wi, found.distance, walk.inside) else { return };
        let weight = match found.pdf {
            // Nothing else can find a delta light.
            None => 1.0,
            Some(pdf) => {
                let scatter = bsdf.pdf(si.wo, found.wi, TransportMode::Radiance);
                power_heuristic((pdf * choice.pmf).get(), scatter.get())
            }
        };
        let weight = weight * self.part_of(walk, choice.light);
        let light = walk.beta * f * found.weight.0 * (weight / choice.pmf.0) * left;
        let part = match walk.order() {
            0 => Part::Direct,
            _ if bsdf.is_glossy() => Part::Caustic,
            _ => Part::Indirect,
        };
        let arrival = walk.walked.straight_at(bsdf.is_glossy());
        sample.add(LightKind { part, arrival, group: self.world.scene.light_groups.of(choice.light) }, light);
    }

    fn query(&self, walk: &Walk, si: &Interaction, bsdf: Bsdf, first: bool, stream: &mut Stream) -> Query {
        if si.is_carried(&self.world.scene) {
            let to_rest = si.to_rest(&self.world.scene);
            let (si, columns) = (to_rest.interaction(si), to_rest.columns(&walk.differential));
            let bsdf = self.world.bsdf(&si, &columns);
            let mut query = self.query_at(walk, &si, bsdf, &columns, first, stream);
            query.point.moment = Some(self.world.scene.shutter.share(walk.ray.time) - 0.5);
            return query;
        }
        self.query_at(walk, si, bsdf, &walk.differential, first, stream)
    }

    fn query_at(
        &self,
        walk: &Walk,
        si: &Interaction,
        bsdf: Bsdf,
        columns: &Differential<2>,
        first: bool,
        stream: &mut Stream,
    ) -> Query {
        let eye: [Vec3; 2] = columns.dx.to_array().map(|dx| dx * self.sample_radius);
        let bounces_left = self.max_bounces.saturating_sub(walk.bounces);
        let asks = match walk.bounces {
            0 => Asks::All(walk.turn),
            _ => Asks::Drawn { u: stream.uniform(), bounces_left },
        };
        let scattered = bsdf.is_diffuse() && self.task.finds.leaves_scattered(walk.bounces);
        let point = GatherPoint { p: si.p, ng: si.ng, ns: si.ns, wo: si.wo, bsdf, eye, asks, moment: None };
        Query { point, beta: walk.beta, first, scattered, straight: walk.walked.straight_at(bsdf.is_glossy()) }
    }

    /// The columns of an edge that gathers light of photons: a pixel's samples share the directions out between them, so
    /// that such a cell is the edge's footprint as the share of the pixel is a camera ray's. Other edges have none.
    fn gathered_over(&self, w: Dir3, pdf: Pdf<SolidAngle>) -> Differential<2> {
        if !matches!(self.task.finds, EyeFinds::NothingScattered { from: 1.. }) {
            return Differential::ZERO;
        }
        let (frame, side) = (Frame::from_unit(w), GATHER_WIDTH * pdf.get().sqrt().recip().min(WIDEST_GATHER));
        Differential::new([Column::direction(frame.t * side), Column::direction(frame.b * side)])
    }
}

/// A surface that looks for light.
fn receiver(si: &Interaction) -> Receiver {
    Receiver { p: si.p, n: Some(si.ns) }
}

fn redirected(columns: &Differential<2>, w: Dir3, si: &Interaction, next: &BsdfSample) -> Differential<2> {
    match next.event {
        Event::DeltaTransmission { eta, .. } => match refract(columns, w, si.ns, &si.shape, eta) {
            Refraction::Transmitted(_, columns) | Refraction::TotalReflection(_, columns) => columns,
        },
        _ => reflect(columns, w, si.ns, &si.shape).1,
    }
}

fn survives_roulette(walk: &mut Walk, edge: u32, stream: &mut Stream) -> bool {
    if edge < ROULETTE_FROM {
        return true;
    }
    let q = walk.beta.max_component().min(0.95);
    if stream.uniform() >= q {
        return false;
    }
    walk.beta *= 1.0 / q;
    true
}
