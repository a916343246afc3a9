//! The conductors: which technique makes which part of a picture, pass by pass.
//!
//! A render is a set of numbered passes. Pass i is a pure function of (scene, settings, i); the film is their mean.

pub mod crosscheck;
pub mod exposure;
pub mod eye_path;
pub mod light_trace;
pub mod photon_map;
pub mod progress;
pub mod unit;

use std::time::{Duration, Instant};

use serde::Serialize;

use crate::camera::Camera;
use crate::film::Film;
use crate::photon::PhotonCounts;
use crate::scene::settings::Method;
use crate::world::World;
use eye_path::EyeFinds;
use progress::Progress;

/// What a render did, for the birth certificate.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RenderReport {
    pub passes: u32,
    /// All photons of all passes; zero for the methods without a map.
    pub photons: PhotonCounts,
    /// The same for each light, in the order of the scene's lights.
    pub photons_by_light: Vec<PhotonCounts>,
    /// Rays that the backend refused.
    pub invalid_rays: u64,
    /// Hits within rounding of a triangle's plane, or on a degenerate one, shaded where the backend put them.
    pub inexact_hits: u64,
    pub seconds: f64,
}

/// A finished render.
pub struct Rendered {
    pub film: Film,
    pub report: RenderReport,
}

/// A camera that does not span a frame; assembly refuses such scenes.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("the camera's position, target and up do not span a frame")]
pub struct BadCamera;

/// Renders all passes of the world's scene with its own settings.
pub fn render(world: &World, progress: &dyn Progress) -> Result<Rendered, BadCamera> {
    render_while(world, progress, |passes| passes < world.scene.settings.passes)
}

/// Renders passes 0, 1, … as long as `more`, told how many are done, asks for one; the first one always.
pub fn render_while(world: &World, progress: &dyn Progress, more: impl Fn(u32) -> bool) -> Result<Rendered, BadCamera> {
    let start = Instant::now();
    let settings = &world.scene.settings;
    let camera = Camera::new(&world.scene.camera).ok_or(BadCamera)?;
    let [width, height] = world.scene.camera.resolution;
    let mut film = Film::new(width, height, &settings.layers);
    let mut report = RenderReport::default();
    loop {
        render_pass(world, &camera, report.passes, &mut film, &mut report, progress);
        film.end_pass();
        report.passes += 1;
        if !more(report.passes) {
            break;
        }
    }
    report.invalid_rays = world.backend.invalid_rays();
    report.inexact_hits = world.inexact_hits();
    report.seconds = Duration::as_secs_f64(&start.elapsed());
    Ok(Rendered { film, report })
}

/// Adds pass `pass` to the film: a pure function of the scene, its settings and the pass's number.
pub fn render_pass(
    world: &World,
    camera: &Camera,
    pass: u32,
    film: &mut Film,
    report: &mut RenderReport,
    progress: &dyn Progress,
) {
    match world.scene.settings.method {
        Method::PhotonMap => {
            let map = photon_map::render_pass(world, camera, pass, film, progress);
            report.add_photons(&map.counts, &map.by_light);
        }
        Method::Path => exposure::expose(world, camera, pass, EyeFinds::Everything, None, film, progress),
        Method::LightTrace => light_trace::render_pass(world, camera, pass, film, progress),
    }
}

impl RenderReport {
    fn add_photons(&mut self, counts: &PhotonCounts, by_light: &[PhotonCounts]) {
        self.photons.merge(counts);
        self.photons_by_light.resize(by_light.len(), PhotonCounts::default());
        for (sum, light) in self.photons_by_light.iter_mut().zip(by_light) {
            sum.merge(light);
        }
    }
}
