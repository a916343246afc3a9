//! The conductors: which technique makes which part of a picture, pass by pass.
//!
//! A render is a set of numbered passes. Pass i is a pure function of (scene, settings, i); the film is their mean. Its
//! sums are exact, so passes, tiles and units may be rendered in any order, anywhere, and added up later.

pub mod beam_light;
pub mod bench;
pub mod budget;
pub mod crosscheck;
pub mod emission;
pub mod exposure;
pub mod eye_path;
pub mod first_pass;
pub mod light_trace;
pub mod memory;
pub mod mis;
pub mod partition;
pub mod photon_light;
pub mod photon_map;
pub mod progress;
pub mod store;
pub mod tiling;
pub mod unit;
pub mod watch;

use std::cell::OnceCell;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::camera::Camera;
use crate::film::{Film, Layout, PixelBounds};
use crate::medium::LostCount;
use crate::photon::{Kinds, PhotonCounts, PhotonMap, Population};
use crate::scene::settings::Method;
use crate::scene::texture::TextureError;
use crate::world::World;
use partition::{EyeFinds, EyeTask};
use progress::Progress;
use watch::{Stopped, Unattended, Watch, WhileTexturesAreRead};

/// What a render did, for the birth certificate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RenderReport {
    /// The caustics' photons of all passes; zero for the methods without a map.
    pub photons: PhotonCounts,
    /// The same for each light, in the order of the scene's lights.
    pub photons_by_light: Vec<PhotonCounts>,
    /// Photons that are scattered first, of all passes.
    pub bounced_photons: PhotonCounts,
    /// Photons whose ways through media become beams, of all passes; a beam counts as stored.
    #[serde(default)]
    pub beam_photons: PhotonCounts,
    /// Rays that the backend refused.
    pub invalid_rays: u64,
    /// Hits within rounding of a triangle's plane, or on a degenerate one, shaded where the backend put them.
    pub inexact_hits: u64,
    /// What rays through media lost count of.
    #[serde(default)]
    pub lost_count: LostCount,
    /// Time spent rendering, by all who had a share in it.
    pub seconds: f64,
}

/// A render at any moment: all that is needed to go on with it.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderState {
    pub film: Film,
    pub report: RenderReport,
}

impl RenderState {
    /// Nothing rendered yet of the pixels `part`, from pass `first_pass` on.
    pub fn new(world: &World, part: PixelBounds, first_pass: u32) -> RenderState {
        let film = Film::new(part, first_pass, Layout::of_scene(&world.scene));
        RenderState { film, report: RenderReport::default() }
    }

    /// Adds other passes of the same pixels.
    pub fn add_passes(&mut self, other: &RenderState) {
        self.film.add_passes(&other.film);
        self.report.add_passes(&other.report);
    }
}

/// What the conductors of a pass need.
pub struct Job<'a> {
    pub world: &'a World,
    pub camera: Camera,
    pub watch: &'a dyn Watch,
    /// What every pass sends, once one with photons has asked.
    plans: OnceCell<Kinds<Population>>,
    /// What every pass sends as beams into media that scatter.
    beam_plans: OnceCell<Kinds<Population>>,
}

impl<'a> Job<'a> {
    pub fn new(world: &'a World, camera: Camera, watch: &'a dyn Watch) -> Job<'a> {
        Job { world, camera, watch, plans: OnceCell::new(), beam_plans: OnceCell::new() }
    }

    /// What every pass sends to surfaces.
    fn plans(&self) -> &Kinds<Population> {
        self.plans.get_or_init(|| emission::plan(self.world))
    }
}

/// A camera that does not span a frame; assembly refuses such scenes.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("the camera's position, target and up do not span a frame")]
pub struct BadCamera;

/// Why a pass cannot be rendered.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RenderError {
    #[error(transparent)]
    Camera(#[from] BadCamera),
    #[error(transparent)]
    Textures(#[from] TextureError),
}

/// How a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// No further pass was wanted.
    Done,
    /// It was stopped, perhaps within a pass.
    Stopped,
}

/// Renders all passes of the world's scene with its own settings.
pub fn render(world: &World, progress: &dyn Progress) -> Result<RenderState, RenderError> {
    render_while(world, progress, |state| state.film.passes() < world.scene.settings.passes)
}

/// Renders passes 0, 1, … of the whole picture as long as `more` asks for one; the first one always.
pub fn render_while(
    world: &World,
    progress: &dyn Progress,
    more: impl Fn(&RenderState) -> bool,
) -> Result<RenderState, RenderError> {
    let mut state = RenderState::new(world, PixelBounds::whole(world.scene.camera.resolution), 0);
    let more = |state: &RenderState| state.film.passes() == 0 || more(state);
    go_on(world, &mut state, &Unattended(progress), more)?;
    Ok(state)
}

/// Goes on with a render: ends the pass under way, then adds pass after pass as long as `more` asks for one.
///
/// # Errors
/// The camera spans no frame; or textures could not be read, and the state is good for nothing: `watch` last saw a good one.
pub fn go_on(
    world: &World,
    state: &mut RenderState,
    watch: &dyn Watch,
    more: impl Fn(&RenderState) -> bool,
) -> Result<Ended, RenderError> {
    let camera = Camera::new(&world.scene.camera).ok_or(BadCamera)?;
    let watch = &WhileTexturesAreRead { watch, textures: &world.textures };
    let job = Job::new(world, camera, watch);
    let (start, before) = (Instant::now(), state.report.seconds);
    let [invalid_rays, inexact_hits] = [world.backend.invalid_rays(), world.inexact_hits()];
    let lost_count = world.lost_count();
    let mut ended = Ended::Done;
    while !state.film.is_between_passes() || more(state) {
        let pass = render_pass(&job, state);
        world.textures.check()?;
        if pass.is_err() {
            ended = Ended::Stopped;
            break;
        }
        state.film.end_pass();
        state.report.seconds = before + start.elapsed().as_secs_f64();
        watch.look(state);
    }
    state.report.invalid_rays += world.backend.invalid_rays() - invalid_rays;
    state.report.inexact_hits += world.inexact_hits() - inexact_hits;
    state.report.lost_count = state.report.lost_count.plus(world.lost_count().since(lost_count));
    state.report.seconds = before + Duration::as_secs_f64(&start.elapsed());
    Ok(ended)
}

/// Adds to the film what is missing of the pass under way: a pure function of the scene, its settings and the pass's
/// number.
fn render_pass(job: &Job, state: &mut RenderState) -> Result<(), Stopped> {
    match job.world.scene.settings.method {
        Method::PhotonMap => photon_map::render_pass(job, state),
        Method::Path => exposure::expose(job, &EyeTask::alone(EyeFinds::Everything), None, state),
        Method::LightTrace => light_trace::render_pass(job, state),
    }
}

impl RenderReport {
    /// Counts a pass's photons.
    fn add_maps(&mut self, maps: &Kinds<PhotonMap>) {
        self.add_photons(&maps.caustic.counts, &maps.caustic.by_light, &maps.bounced.counts);
    }

    fn add_photons(&mut self, counts: &PhotonCounts, by_light: &[PhotonCounts], bounced: &PhotonCounts) {
        self.photons.merge(counts);
        self.photons_by_light.resize(by_light.len(), PhotonCounts::default());
        for (sum, light) in self.photons_by_light.iter_mut().zip(by_light) {
            sum.merge(light);
        }
        self.bounced_photons.merge(bounced);
    }

    /// Adds what was done for other passes.
    fn add_passes(&mut self, other: &RenderReport) {
        self.beam_photons.merge(&other.beam_photons);
        self.add_photons(&other.photons, &other.photons_by_light, &other.bounced_photons);
        self.add_work(other);
    }

    /// Adds what was done for other pixels of the same passes; every tile traces the same photons.
    fn paste(&mut self, other: &RenderReport, first: bool) {
        if first {
            self.beam_photons.merge(&other.beam_photons);
            self.add_photons(&other.photons, &other.photons_by_light, &other.bounced_photons);
        }
        self.add_work(other);
    }

    fn add_work(&mut self, other: &RenderReport) {
        self.invalid_rays += other.invalid_rays;
        self.inexact_hits += other.inexact_hits;
        self.lost_count = self.lost_count.plus(other.lost_count);
        self.seconds += other.seconds;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import;
    use crate::scene::TextureMemory;
    use progress::Silent;

    /// A white wall before a lamp, its image in the file.
    const WALL: &str = r#"
        format = 1
        camera = { type = "perspective", position = [0, 0, 3], target = [0, 0, 0], up = [0, 1, 0], fov_degrees = 4, resolution = [8, 8] }
        render = { method = "path", passes = 2, spp = 1 }
        materials.wall = { type = "lambert", albedo = { image = "wall.png" } }
        objects = [{ shape = "rectangle", centre = [0, 0, 0], a = [2, 0, 0], b = [0, 2, 0], material = "wall" }]
        lights = [{ type = "point", position = [0, 0, 2], intensity = [1, 1, 1] }]
    "#;

    /// A disk that fails while it is read ends the render with an error, not with a black wall.
    #[test]
    fn textures_that_cannot_be_read_any_more_end_the_render() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let white = ::image::RgbImage::from_pixel(256, 256, ::image::Rgb([255; 3]));
        white.save(folder.path().join("wall.png")).expect("written");
        let scene = folder.path().join("wall.toml");
        std::fs::write(&scene, WALL).expect("written");
        let memory = TextureMemory::new(30_000);
        let loaded = import::load_within(&scene, &[], &memory).expect("a sound scene");
        let world = World::new(loaded.scene).expect("a world");
        let good = render(&world, &Silent).expect("a good disk");
        memory.break_file();
        let failure = render(&world, &Silent).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(failure.starts_with("cannot read the temporary file of textures in"), "{failure}");
        assert!(good.film.passes() == 2 && world.textures.failure().is_some());
    }
}
