//! Small renders to cut into parts: a glass ball over a floor, all layers.

use std::sync::atomic::{AtomicUsize, Ordering};

use pdembree::film::PixelBounds;
use pdembree::import::{Override, load};
use pdembree::output::PartInfo;
use pdembree::render::progress::{Progress, Silent};
use pdembree::render::watch::{Unattended, Watch};
use pdembree::render::{Ended, RenderState, go_on, store};
use pdembree::world::World;

use super::data::root;

/// A ball lens in 40 × 24 pixels, with these settings over its own.
pub fn ball(settings: &[(&str, &str)]) -> World {
    let own = [
        ("camera.resolution", "[40, 24]"),
        ("camera.width", "0.6"),
        ("render.photons", "20000"),
        ("render.spp", "2"),
        ("render.layers", "[\"caustic\", \"direct\", \"N\", \"Z\", \"photons\", \"variance\"]"),
    ];
    let overrides: Vec<Override> =
        own.iter().chain(settings).map(|(key, value)| Override::new(*key, (*value).to_owned())).collect();
    let loaded = load(&root().join("scenes/tests/ball_lens.toml"), &overrides).unwrap_or_else(|all| panic!("{all}"));
    World::new(loaded.scene).expect("a world")
}

pub fn whole(world: &World) -> PixelBounds {
    PixelBounds::whole(world.scene.camera.resolution)
}

pub fn info(world: &World, passes: u32) -> PartInfo {
    store::identify(world, "ball.toml".as_ref(), passes)
}

/// Passes `first` to `end` of `pixels`, in one go.
pub fn passes(world: &World, pixels: PixelBounds, first: u32, end: u32) -> RenderState {
    let mut state = RenderState::new(world, pixels, first);
    go_on(world, &mut state, &Unattended(&Silent), |state| state.film.pass() < end).expect("a render");
    state
}

/// Stops after some units.
pub struct Impatient {
    pub units: usize,
    done: AtomicUsize,
}

impl Impatient {
    pub fn after(units: usize) -> Impatient {
        Impatient { units, done: AtomicUsize::new(0) }
    }
}

impl Progress for Impatient {
    fn phase(&self, _name: &str, _total: u64) {}
    fn advance(&self, n: u64) {
        self.done.fetch_add(n as usize, Ordering::Relaxed);
    }
    fn finish(&self) {}
    fn skip(&self, _n: u64) {}
}

impl Watch for Impatient {
    fn stop(&self) -> bool {
        self.done.load(Ordering::Relaxed) >= self.units
    }
}

/// Goes on until `end`, or until so many units are done.
pub fn go_on_for(world: &World, state: &mut RenderState, end: u32, units: usize) -> Ended {
    go_on(world, state, &Impatient::after(units), |state| state.film.pass() < end).expect("a render")
}
