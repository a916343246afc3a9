//! gather → film: eye paths over all tiles, and the photons' light at their vertices.

use super::eye_path::{EyePathTracer, Query};
use super::partition::EyeTask;
use super::photon_light::PhotonLight;
use super::unit::{run_units, scattered};
use super::watch::Stopped;
use super::{Job, RenderState};
use crate::camera::{Camera, filter_offset};
use crate::estimate::{Turn, bandwidth};
use crate::film::{self, EyeSample, PixelBounds, Tile};
use crate::math::Vec2;
use crate::sampling::warp::{ConcentricDisk, Warp};
use crate::sampling::{PixelPattern, PixelSamples};
use crate::scene::RenderSettings;
use crate::scene::settings::Estimator;

/// Pixels along the side of a unit of work, counted from the picture's corner also where only a part is rendered.
pub const TILE_SIZE: u32 = 16;

/// Semi-axis of an eye sample's footprint in sample spacings, PHOTON_DIFFERENTIALS 3.4: enough to hide folds between
/// samples, half of what would blur them.
const EYE_RADIUS: f64 = 0.75;

/// Semi-axis of an eye sample's footprint in pass `pass`, in pixels. The standard estimates look at points.
fn eye_radius(settings: &RenderSettings, pass: u32) -> f64 {
    match settings.estimator {
        Estimator::Differentials => {
            EYE_RADIUS / f64::from(settings.spp).sqrt() * bandwidth::narrowing(settings.emission, pass)
        }
        Estimator::NearestNeighbours | Estimator::Progressive => 0.0,
    }
}

/// Adds the tiles of the pass under way that its film does not have yet; `photons` answer the queries that `task` leaves
/// to them.
pub fn expose(
    job: &Job,
    task: &EyeTask,
    photons: Option<&PhotonLight>,
    state: &mut RenderState,
) -> Result<(), Stopped> {
    let (world, pass) = (job.world, state.film.pass());
    let settings = &world.scene.settings;
    let exposure = Exposure {
        camera: &job.camera,
        pass,
        settings,
        pattern: PixelPattern::new(settings.spp),
        tracer: EyePathTracer {
            world,
            task,
            beams: photons.and_then(PhotonLight::beams),
            max_depth: settings.max_depth,
            max_bounces: settings.max_bounces,
            sample_radius: eye_radius(settings, pass),
        },
        photons,
    };
    let tiles = units_of(&state.film.bounds());
    let layout = state.film.layout().clone();
    let added = state.film.added(film::Exposure::Eye);
    let missing: Vec<usize> = scattered(tiles.len()).into_iter().filter(|&i| !added.contains(i)).collect();
    job.watch.phase("picture", missing.len() as u64);
    let unit = |i: usize| exposure.tile(Tile::new(&layout, tiles[i], pass));
    run_units(&missing, job.watch, unit, |i, tile| {
        state.film.add_tile(i, &tile);
        job.watch.look(state);
    })?;
    job.watch.finish();
    Ok(())
}

/// The units of a part of a picture. Its corner lies on one of the picture's units, so that its units are some of those:
/// what is computed for a pixel then never depends on the part.
fn units_of(part: &PixelBounds) -> Vec<PixelBounds> {
    let place = |tile: PixelBounds| PixelBounds {
        x0: tile.x0 + part.x0,
        y0: tile.y0 + part.y0,
        x1: tile.x1 + part.x0,
        y1: tile.y1 + part.y0,
    };
    debug_assert!(part.x0.is_multiple_of(TILE_SIZE) && part.y0.is_multiple_of(TILE_SIZE), "{part:?}");
    PixelBounds::tiles(part.width(), part.height(), TILE_SIZE).into_iter().map(place).collect()
}

struct Exposure<'a> {
    camera: &'a Camera,
    pass: u32,
    settings: &'a RenderSettings,
    pattern: PixelPattern,
    tracer: EyePathTracer<'a>,
    photons: Option<&'a PhotonLight<'a>>,
}

impl Exposure<'_> {
    fn tile(&self, mut tile: Tile) -> Tile {
        let bounds = tile.bounds();
        let mut samples = Vec::with_capacity(bounds.pixels() * self.settings.spp as usize);
        let mut queries = Vec::new();
        // Which sample each query belongs to.
        let mut owners = Vec::new();
        for y in bounds.y0..bounds.y1 {
            for x in bounds.x0..bounds.x1 {
                let pixel = self.pattern.of(self.settings.seed, self.pass, self.number(x, y));
                for s in 0..self.settings.spp {
                    samples.push((x, y, self.eye_sample(x, y, s, &pixel, &mut queries)));
                    owners.resize(queries.len(), samples.len() - 1);
                }
            }
        }
        if let Some(photons) = self.photons {
            photons.add(&queries, &owners, &mut samples);
        }
        for (x, y, sample) in &samples {
            tile.add(*x, *y, sample);
        }
        tile
    }

    /// The pixel's number in the whole picture.
    fn number(&self, x: u32, y: u32) -> u64 {
        u64::from(y) * u64::from(self.tracer.world.scene.camera.resolution[0]) + u64::from(x)
    }

    /// When sample `s` of a pixel is taken.
    fn time(&self, s: u32, samples: &PixelSamples) -> f64 {
        let shutter = self.tracer.world.scene.shutter;
        if shutter.is_instant() { shutter.open } else { shutter.time(samples.time(s)) }
    }

    fn eye_sample(&self, x: u32, y: u32, s: u32, samples: &PixelSamples, queries: &mut Vec<Query>) -> EyeSample {
        let world = self.tracer.world;
        let settings = self.settings;
        let (start, stream) = samples.get(s);
        let centre = Vec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let offset = filter_offset(world.scene.camera.filter, start.raster);
        let time = self.time(s, samples);
        let camera = self.camera.at(time);
        let mut ray = camera.ray(centre + offset, ConcentricDisk.sample(start.lens));
        ray.ray.time = time;
        let turn = Turn { index: s, of: settings.spp };
        let mut sample = self.tracer.trace(&ray, &start, turn, stream, queries);
        // The path knows distances; the layer is depth along the view axis.
        sample.depth = sample.depth.map(|t| camera.depth(ray.ray.at(t)));
        sample
    }
}
