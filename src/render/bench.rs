//! How fast the phases of a pass are, on one thread and on all; how fast the ray library alone is on the same rays, and the
//! other one; and what the standard photon map takes for the same photons.

use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Instant;

use serde::Serialize;

use super::partition::EyeTask;
use super::photon_light::PhotonLight;
use super::progress::Silent;
use super::unit::{NoThread, on_one_thread, threads};
use super::watch::{Stopped, Unattended};
use super::{BadCamera, Job, RenderState, emission, exposure, photon_map};
use crate::backend::{self, Backend, Query, Recorded, RecordingBackend};
use crate::camera::Camera;
use crate::film::PixelBounds;
use crate::photon::{Kinds, PhotonHarvest, PhotonMap, Population};
use crate::scene::Scene;
use crate::scene::settings::{BackendKind, Estimator};
use crate::world::{World, WorldError};

/// Rays of each kind that a phase is replayed with at most; more are counted, and cost in proportion.
const KEPT_RAYS: usize = 4_000_000;

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    #[error(transparent)]
    World(#[from] WorldError),
    #[error(transparent)]
    Camera(#[from] BadCamera),
    #[error("cannot start a thread: {0}")]
    Thread(#[from] NoThread),
}

/// One phase of a pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Phase {
    pub name: &'static str,
    /// On one thread and on all.
    pub seconds: [f64; 2],
    /// Queries for a first hit and for occlusion.
    pub rays: [u64; 2],
    /// What the ray library alone takes for them on one thread.
    pub bare_seconds: f64,
    /// What the other one takes for them, if this binary has it.
    pub other_seconds: Option<f64>,
}

/// The same photons without columns, and the nearest of them instead of footprints; seconds on one thread.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standard {
    /// Tracing them with columns and without, one right after the other.
    pub photons: [f64; 2],
    /// Their tree.
    pub map: f64,
    /// What the picture takes longer than without them.
    pub estimate: f64,
    pub neighbours: u32,
}

/// A pass of a scene, measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    pub backend: String,
    /// The ray library that it is compared with.
    pub other: Option<String>,
    pub threads: usize,
    /// In the order they are run in; `estimate` is what the picture takes with the photon map longer than without.
    pub phases: Vec<Phase>,
    pub photons_emitted: u64,
    pub photons_stored: u64,
    /// Photons and the trees over them.
    pub bytes_per_photon: f64,
    /// Pairs of a photon and a point that were weighed.
    pub kernel_evaluations: u64,
    pub standard: Standard,
}

impl Phase {
    /// How many times longer it takes than its rays alone, on one thread; `None` without rays.
    pub fn over_bare(&self) -> Option<f64> {
        (self.bare_seconds > 0.0).then(|| self.seconds[0] / self.bare_seconds)
    }
    pub fn speed_up(&self) -> f64 {
        self.seconds[0] / self.seconds[1]
    }
}

const PHASES: [&str; 5] = ["pilots", "photons", "map", "eye paths", "estimate"];

/// Runs pass 0 of `scene` on one thread, on all, and once more while its rays are recorded; then the rays alone.
pub fn measure(scene: Scene) -> Result<Measured, BenchError> {
    let threads = threads();
    let mut world = World::new(scene)?;
    let camera = Camera::new(&world.scene.camera).ok_or(BadCamera)?;
    let one = on_one_thread(|| Run::of(&world, &camera, |_| ()))?;
    let all = Run::of(&world, &camera, |_| ());
    let build = |kind| backend::build(kind, &world.scene).map_err(WorldError::Backend);
    let inner = build(world.scene.settings.backend)?;
    let other = other_than(world.scene.settings.backend).map(build).transpose()?;
    let (recording, recorded) = RecordingBackend::new(inner, KEPT_RAYS);
    let bare = std::mem::replace(&mut world.backend, Box::new(recording));
    let mut alone = [([0; 2], 0.0, None); PHASES.len()];
    on_one_thread(|| {
        Run::of(&world, &camera, |phase| {
            let rays = recorded.lock().unwrap_or_else(PoisonError::into_inner).take();
            // The picture is taken twice, with and without photons; its rays are the same.
            if PHASES[phase] != "estimate" {
                let others = other.as_ref().map(|other| time_alone(other.as_ref(), &rays));
                alone[phase] = (rays.counts(), time_alone(bare.as_ref(), &rays), others);
            }
        })
    })?;
    let phase = |i: usize| {
        let (rays, bare_seconds, other_seconds) = alone[i];
        Phase { name: PHASES[i], seconds: [one.seconds[i], all.seconds[i]], rays, bare_seconds, other_seconds }
    };
    world.backend = bare;
    let standard = on_one_thread(|| Standard::of(&mut world, &camera))?;
    Ok(Measured {
        backend: world.backend.describe(),
        other: other.map(|other| other.describe()),
        threads,
        phases: (0..PHASES.len()).map(phase).collect(),
        photons_emitted: one.photons_emitted,
        photons_stored: one.photons_stored,
        bytes_per_photon: one.bytes_per_photon,
        kernel_evaluations: one.weighed,
        standard,
    })
}

/// Which backend to compare with: the other fast one.
fn other_than(kind: BackendKind) -> Option<BackendKind> {
    match kind {
        BackendKind::Embree => Some(BackendKind::Obvhs),
        BackendKind::Obvhs | BackendKind::Brute => cfg!(feature = "embree").then_some(BackendKind::Embree),
    }
}

impl Standard {
    /// Leaves `world` set to the standard estimate.
    fn of(world: &mut World, camera: &Camera) -> Standard {
        let plans = emission::plan(world);
        let (_, with_columns) = timed(|| harvest(world, &plans));
        world.scene.settings.estimator = Estimator::NearestNeighbours;
        let (plain, without) = timed(|| harvest(world, &plans));
        let photons = plain.map(PhotonHarvest::into_map);
        let settings = &world.scene.settings;
        let ((), picture) = timed(|| expose(world, camera, &plans, None));
        let (trees, map) = timed(|| PhotonLight::of_pass(&photons, settings, 0));
        let ((), estimate) = timed(|| expose(world, camera, &plans, Some(&trees)));
        Standard {
            photons: [with_columns, without],
            map,
            estimate: (estimate - picture).max(0.0),
            neighbours: settings.k,
        }
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// The photons of pass 0. Nobody stops it.
fn harvest(world: &World, plans: &Kinds<Population>) -> Kinds<PhotonHarvest> {
    photon_map::harvest(world, plans, 0, &Unattended(&Silent), || ())
        .unwrap_or_else(|Stopped| Kinds::<()>::default().map(|()| PhotonHarvest::new(world.lights.len())))
}

/// The picture of pass 0, thrown away.
fn expose(world: &World, camera: &Camera, plans: &Kinds<Population>, photons: Option<&PhotonLight>) {
    let unattended = Unattended(&Silent);
    let job = Job::new(world, camera.clone(), &unattended);
    let mut state = RenderState::new(world, PixelBounds::whole(world.scene.camera.resolution), 0);
    // Nobody stops it.
    let _ = exposure::expose(&job, &EyeTask::beside(world, plans), photons, &mut state);
}

/// Seconds that the library takes for all the rays, of which some were kept.
fn time_alone(bare: &dyn Backend, rays: &Recorded) -> f64 {
    let of = |query| {
        let (count, kept) = rays.of(query);
        if kept.is_empty() { 0.0 } else { bare.time(query, kept).as_secs_f64() * count as f64 / kept.len() as f64 }
    };
    of(Query::Intersect) + of(Query::Occluded)
}

/// A pass: seconds of each phase, and what became of the photons.
struct Run {
    seconds: [f64; PHASES.len()],
    photons_emitted: u64,
    photons_stored: u64,
    bytes_per_photon: f64,
    weighed: u64,
}

impl Run {
    /// Calls `after` with the number of each phase that has ended.
    fn of(world: &World, camera: &Camera, mut after: impl FnMut(usize)) -> Run {
        let mut seconds = [0.0; PHASES.len()];
        let mut start = Instant::now();
        let mut end = |phase: usize| {
            seconds[phase] = start.elapsed().as_secs_f64();
            after(phase);
            start = Instant::now();
        };
        let plans = emission::plan(world);
        end(0);
        let harvest = harvest(world, &plans);
        end(1);
        let maps = harvest.map(PhotonHarvest::into_map);
        end(2);
        expose(world, camera, &plans, None);
        end(3);
        let photons = PhotonLight::of_pass(&maps, &world.scene.settings, 0);
        expose(world, camera, &plans, Some(&photons));
        end(4);
        seconds[4] = (seconds[4] - seconds[3]).max(0.0);
        let of_both = |of: &dyn Fn(&PhotonMap) -> u64| maps.as_ref().into_array().into_iter().map(of).sum();
        let stored: u64 = of_both(&|map| map.counts.photons_stored);
        let bytes: u64 = of_both(&|map| map.bytes() as u64);
        Run {
            seconds,
            photons_emitted: of_both(&|map| map.counts.photons_emitted),
            photons_stored: stored,
            bytes_per_photon: bytes as f64 / stored.max(1) as f64,
            weighed: of_both(&|map| map.weighed.load(Ordering::Relaxed)),
        }
    }
}
