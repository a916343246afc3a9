//! A pass of a small scene in its steps, for benches: what the conductors of `render` do, on one thread.

use pdembree::camera::{Camera, filter_offset};
use pdembree::estimate::Turn;
use pdembree::film::{EyeSample, Film, Layout, PixelBounds, Tile};
use pdembree::import::{Override, load};
use pdembree::math::Vec2;
use pdembree::photon::{Kinds, PhotonHarvest, PhotonMap, Population};
use pdembree::render::exposure::{TILE_SIZE, expose};
use pdembree::render::eye_path::{EyePathTracer, Query};
use pdembree::render::partition::{EyeFinds, EyeTask};
use pdembree::render::photon_light::PhotonLight;
use pdembree::render::progress::Silent;
use pdembree::render::unit::on_one_thread;
use pdembree::render::watch::Unattended;
use pdembree::render::{Job, RenderState, emission, photon_map};
use pdembree::sampling::PixelPattern;
use pdembree::sampling::warp::{ConcentricDisk, Warp};
use pdembree::world::World;

use super::data::root;

/// Every bench's scenes: shapes and a lamp of some size with light in corners; a mesh of glass that splits photons.
pub const SCENES: [&str; 2] = ["cornell", "glass"];

/// A scene of `scenes/` with few pixels and photons.
pub struct Small {
    pub world: World,
    pub camera: Camera,
}

/// What the eye finds in the pixels of a tile, but for the light of photons.
pub struct Seen {
    pub bounds: PixelBounds,
    pub samples: Vec<(u32, u32, EyeSample)>,
    /// Where photons are asked.
    pub queries: Vec<Query>,
    /// Which sample each query belongs to.
    pub owners: Vec<usize>,
}

impl Small {
    /// The scene with `settings` over its own.
    pub fn with(scene: &str, settings: &[(&str, &str)]) -> Small {
        let small = [
            ("camera.resolution", "[64, 48]"),
            ("render.photons", "20000"),
            ("render.spp", "4"),
            ("render.passes", "1"),
            ("render.layers", "[\"caustic\", \"direct\", \"N\", \"Z\"]"),
        ];
        let overrides: Vec<Override> =
            small.iter().chain(settings).map(|(key, value)| Override::new(*key, *value)).collect();
        let path = root().join("scenes").join(scene).join(scene).with_extension("toml");
        let loaded = load(&path, &overrides).unwrap_or_else(|problems| panic!("{problems}"));
        let camera = Camera::new(&loaded.scene.camera).expect("a frame");
        Small { world: World::new(loaded.scene).expect("a world"), camera }
    }

    pub fn of(scene: &str) -> Small {
        Small::with(scene, &[])
    }

    pub fn pixels(&self) -> PixelBounds {
        PixelBounds::whole(self.world.scene.camera.resolution)
    }

    pub fn samples(&self) -> usize {
        self.pixels().pixels() * self.world.scene.settings.spp as usize
    }

    pub fn harvest(&self, plans: &Kinds<Population>) -> Kinds<PhotonHarvest> {
        photon_map::harvest(&self.world, plans, 0, &Unattended(&Silent), || ()).expect("nobody stops it")
    }

    pub fn maps(&self) -> Kinds<PhotonMap> {
        self.harvest(&emission::plan(&self.world)).map(PhotonHarvest::into_map)
    }

    pub fn light<'a>(&'a self, maps: &'a Kinds<PhotonMap>) -> PhotonLight<'a> {
        PhotonLight::of_pass(maps, &self.world.scene.settings, 0)
    }

    /// The whole picture; photons' light is in it where there is an estimate.
    pub fn expose(&self, finds: EyeFinds, photons: Option<&PhotonLight>) -> RenderState {
        let watch = Unattended(&Silent);
        let job = Job::new(&self.world, self.camera.clone(), &watch);
        let mut state = RenderState::new(&self.world, self.pixels(), 0);
        expose(&job, &EyeTask::alone(finds), photons, &mut state).expect("nobody stops it");
        state
    }

    /// Tile by tile, what is there before photons are asked and before the film gets it.
    pub fn seen(&self) -> Vec<Seen> {
        let PixelBounds { x1, y1, .. } = self.pixels();
        PixelBounds::tiles(x1, y1, TILE_SIZE).into_iter().map(|bounds| self.look(bounds)).collect()
    }

    fn look(&self, bounds: PixelBounds) -> Seen {
        let settings = &self.world.scene.settings;
        let tracer = EyePathTracer {
            beams: None,
            world: &self.world,
            task: &EyeTask::alone(EyeFinds::AllButFocused),
            max_depth: settings.max_depth,
            max_bounces: settings.max_bounces,
            sample_radius: 0.75 / f64::from(settings.spp).sqrt(),
        };
        let pattern = PixelPattern::new(settings.spp);
        let (mut samples, mut queries, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        for y in bounds.y0..bounds.y1 {
            for x in bounds.x0..bounds.x1 {
                let number = u64::from(y * self.pixels().width() + x);
                let pixel = pattern.of(settings.seed, 0, number);
                for index in 0..settings.spp {
                    let (start, stream) = pixel.get(index);
                    let centre = Vec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    let raster = centre + filter_offset(self.world.scene.camera.filter, start.raster);
                    let ray = self.camera.ray(raster, ConcentricDisk.sample(start.lens));
                    let turn = Turn { index, of: settings.spp };
                    samples.push((x, y, tracer.trace(&ray, &start, turn, stream, &mut queries)));
                    owners.resize(queries.len(), samples.len() - 1);
                }
            }
        }
        Seen { bounds, samples, queries, owners }
    }

    /// An empty film.
    pub fn film(&self) -> Film {
        Film::new(self.pixels(), 0, Layout::of_scene(&self.world.scene))
    }

    /// A tile of `film` with the samples in it.
    pub fn tile(&self, film: &Film, seen: &Seen) -> Tile {
        let mut tile = Tile::new(film.layout(), seen.bounds, 0);
        seen.samples.iter().for_each(|(x, y, sample)| tile.add(*x, *y, sample));
        tile
    }

    /// A film of one pass.
    pub fn developed(&self, seen: &[Seen]) -> Film {
        let mut film = self.film();
        for (unit, seen) in seen.iter().enumerate() {
            let tile = self.tile(&film, seen);
            film.add_tile(unit, &tile);
        }
        film.end_pass();
        film
    }
}

/// As [`on_one_thread`], with a thread for sure.
pub fn alone<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    on_one_thread(work).expect("a thread")
}
