//! Flies the rays of a render through two backends at once: camera, shadow and photon rays of random paths.
//!
//! The paths follow the first backend's hits, and change direction by the scene's own BSDFs, so the rays are those that
//! renders trace. What the answers mean is judged by [`crate::backend::crosscheck`].

use std::sync::Arc;

use super::BadCamera;
use super::progress::Progress;
use super::unit::collect_units;
use super::watch::Unattended;
use crate::backend::crosscheck::{Crosscheck, Query, RayKind, Report};
use crate::backend::{Backend, Geometry, build_over};
use crate::camera::Camera;
use crate::light::{Aim, Emission, Receiver};
use crate::math::{Point2, Ray};
use crate::sampling::warp::{ConcentricDisk, Warp};
use crate::sampling::{Purpose, Stream};
use crate::scene::Scene;
use crate::scene::settings::BackendKind;
use crate::surface::{Interaction, TransportMode};
use crate::world::{World, WorldError};

/// Rays in a unit of work.
const RAYS_PER_UNIT: u64 = 16384;

/// Edges of a path at most: enough for glass in glass, few enough that most rays come from the camera and the lights.
const MAX_EDGES: usize = 8;

/// Why nothing could be compared.
#[derive(Debug, thiserror::Error)]
pub enum CrosscheckError {
    #[error(transparent)]
    World(#[from] WorldError),
    #[error(transparent)]
    Camera(#[from] BadCamera),
}

/// A finished comparison.
pub struct Crosschecked {
    pub report: Report,
    /// What the two backends say they are.
    pub backends: [String; 2],
}

/// Traces `rays` rays through the backends `a` and `b`.
pub fn crosscheck(
    mut scene: Scene,
    [a, b]: [BackendKind; 2],
    rays: u64,
    progress: &dyn Progress,
) -> Result<Crosschecked, CrosscheckError> {
    scene.settings.backend = a;
    let world = World::new(scene)?;
    let camera = Camera::new(&world.scene.camera).ok_or(BadCamera)?;
    let geometry = Arc::new(Geometry::new(&world.scene).map_err(WorldError::Backend)?);
    let other: Box<dyn Backend> = build_over(b, geometry.clone()).map_err(WorldError::Backend)?;
    let pair = Crosscheck { geometry: &geometry, a: world.backend.as_ref(), b: other.as_ref() };
    let units = rays.div_ceil(RAYS_PER_UNIT);
    let unit = |i: usize| {
        let first = i as u64 * RAYS_PER_UNIT;
        let queries = queries(&world, &camera, i as u64, RAYS_PER_UNIT.min(rays - first) as usize);
        pair.compare(first, &queries)
    };
    let mut report = Report::default();
    progress.phase("rays", units);
    let reports = collect_units(units as usize, &Unattended(progress), unit).unwrap_or_default();
    reports.into_iter().for_each(|found| report.merge(found));
    progress.finish();
    Ok(Crosschecked { report, backends: [pair.a.describe(), pair.b.describe()] })
}

/// `count` rays of alternating eye and light paths, a pure function of the scene's seed and the unit's number.
fn queries(world: &World, camera: &Camera, unit: u64, count: usize) -> Vec<Query> {
    let stream = Stream::new(world.scene.settings.seed, Purpose::Crosscheck, 0, unit);
    let mut paths = Paths { world, stream, queries: Vec::with_capacity(count) };
    while paths.queries.len() < count {
        paths.eye_path(camera);
        paths.light_path();
    }
    paths.queries.truncate(count);
    paths.queries
}

struct Paths<'a> {
    world: &'a World,
    stream: Stream,
    queries: Vec<Query>,
}

impl Paths<'_> {
    fn eye_path(&mut self, camera: &Camera) {
        let [width, height] = self.world.scene.camera.resolution.map(f64::from);
        let [x, y] = self.stream.uniform2();
        let lens = ConcentricDisk.sample(self.stream.uniform2());
        let time = self.world.draw_time(&mut self.stream);
        let ray = camera.at(time).ray(Point2::new(x * width, y * height), lens).ray.at_time(time);
        self.follow(ray, RayKind::Camera, TransportMode::Radiance);
    }

    fn light_path(&mut self) {
        let Some(choice) = self.world.lights.pick_anywhere(self.stream.uniform()) else { return };
        let ([u, v], [theta, phi]) = (self.stream.uniform2(), self.stream.uniform2());
        let time = self.world.draw_time(&mut self.stream);
        let emission = self.world.lights.emit(choice.light, [u, v, theta, phi], &Aim::Everywhere, time);
        if let Some(ray) = emission.map(|e: Emission| Ray::new(e.ray_origin(), e.direction).at_time(time)) {
            self.follow(ray, RayKind::Photon, TransportMode::Importance);
        }
    }

    /// Records the path's rays; an eye path looks at a light from each vertex.
    fn follow(&mut self, mut ray: Ray, kind: RayKind, mode: TransportMode) {
        for _ in 0..MAX_EDGES {
            self.queries.push(Query { ray, kind });
            let Some(si) = self.world.intersect(&ray) else { return };
            if kind == RayKind::Camera {
                self.look_at_a_light(&si);
            }
            let (uc, u) = (self.stream.uniform(), self.stream.uniform2());
            let Some(next) = self.world.bsdf_unfiltered(&si).sample(si.wo, uc, u, mode) else { return };
            ray = si.ray(next.wi);
        }
    }

    fn look_at_a_light(&mut self, si: &Interaction) {
        let at = Receiver { p: si.p, n: Some(si.ns) };
        let Some(choice) = self.world.lights.pick(&at, self.stream.uniform()) else { return };
        let u = self.stream.uniform2();
        let Some(sample) = self.world.lights.sample_li(choice.light, si.p, u, si.time) else { return };
        let ray = World::shadow_ray(si, sample.wi, sample.distance);
        self.queries.push(Query { ray, kind: RayKind::Shadow });
    }
}
