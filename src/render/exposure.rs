//! gather → film: eye paths over all tiles, and the photons' light at their vertices.

use super::eye_path::{EyeFinds, EyePathTracer, Query};
use super::progress::Progress;
use super::unit::run_in_order;
use crate::camera::{Camera, filter_offset};
use crate::estimate::{Estimate, GatherPoint};
use crate::film::{EyeSample, Film, PixelBounds, Tile};
use crate::math::Vec2;
use crate::sampling::warp::{ConcentricDisk, Warp};
use crate::sampling::{Purpose, Stream, qmc};
use crate::scene::RenderSettings;
use crate::scene::settings::Estimator;
use crate::world::World;

/// Pixels along the side of a unit of work.
const TILE_SIZE: u32 = 16;

/// Semi-axis of an eye sample's footprint in sample spacings, PHOTON_DIFFERENTIALS 3.4: enough to hide folds between
/// samples, half of what would blur them.
const EYE_RADIUS: f64 = 0.75;

/// Semi-axis of an eye sample's footprint, in pixels. The standard estimates look at points.
fn eye_radius(settings: &RenderSettings) -> f64 {
    match settings.estimator {
        Estimator::Differentials => EYE_RADIUS / f64::from(settings.spp).sqrt(),
        Estimator::NearestNeighbours | Estimator::Progressive => 0.0,
    }
}

/// Adds one pass of eye paths to the film; `estimate` answers the queries that `finds` leaves to the photon map.
pub fn expose(
    world: &World,
    camera: &Camera,
    pass: u32,
    finds: EyeFinds,
    estimate: Option<&Estimate>,
    film: &mut Film,
    progress: &dyn Progress,
) {
    let settings = &world.scene.settings;
    let exposure = Exposure {
        camera,
        pass,
        settings,
        tracer: EyePathTracer {
            world,
            finds,
            max_depth: settings.max_depth,
            max_bounces: settings.max_bounces,
            sample_radius: eye_radius(settings),
        },
        estimate,
    };
    let tiles = PixelBounds::tiles(film.width(), film.height(), TILE_SIZE);
    let layout = film.layout().clone();
    progress.phase("picture", tiles.len() as u64);
    run_in_order(
        tiles.len(),
        progress,
        |i| exposure.tile(Tile::new(&layout, tiles[i], pass)),
        |tile| film.add_tile(&tile),
    );
    progress.finish();
}

struct Exposure<'a> {
    camera: &'a Camera,
    pass: u32,
    settings: &'a RenderSettings,
    tracer: EyePathTracer<'a>,
    estimate: Option<&'a Estimate<'a>>,
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
                for s in 0..self.settings.spp {
                    samples.push((x, y, self.eye_sample(x, y, s, &mut queries)));
                    owners.resize(queries.len(), samples.len() - 1);
                }
            }
        }
        if let Some(estimate) = self.estimate {
            add_photons(estimate, &queries, &owners, &mut samples);
        }
        for (x, y, sample) in &samples {
            tile.add(*x, *y, sample);
        }
        tile
    }

    fn eye_sample(&self, x: u32, y: u32, s: u32, queries: &mut Vec<Query>) -> EyeSample {
        let world = self.tracer.world;
        let resolution = world.scene.camera.resolution;
        let pixel = u64::from(y) * u64::from(resolution[0]) + u64::from(x);
        // Sample 0 of the pixel's own index range is its lattice shift.
        let stream_of =
            |s: u32| Stream::new(self.settings.seed, Purpose::Camera, self.pass, pixel << 24 | u64::from(s));
        let shift = stream_of(0).uniform2();
        let mut stream = stream_of(s + 1);
        let u = qmc::shifted(qmc::golden_lattice(s.into(), self.settings.spp.into()), shift);
        let centre = Vec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let lens = ConcentricDisk.sample(stream.uniform2());
        let ray = self.camera.ray(centre + filter_offset(world.scene.camera.filter, u), lens);
        let mut sample = self.tracer.trace(&ray, &mut stream, queries);
        // The path knows distances; the layer is depth along the view axis.
        sample.depth = sample.depth.map(|t| self.camera.depth(ray.ray.at(t)));
        sample
    }
}

/// Adds the photons' light at all queries of a tile.
fn add_photons(estimate: &Estimate, queries: &[Query], owners: &[usize], samples: &mut [(u32, u32, EyeSample)]) {
    let points: Vec<GatherPoint> = queries.iter().map(|q| q.point).collect();
    for ((query, owner), gathered) in queries.iter().zip(owners).zip(estimate.gather(&points)) {
        let sample = &mut samples[*owner].2;
        sample.caustic += query.beta * gathered.radiance.0;
        if query.first {
            sample.photon_density = gathered.density;
        }
    }
}
