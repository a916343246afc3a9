//! Many passes: what the error estimate claims, how fast the error falls, and where the mean goes.

use pdembree::import::{Override, load};
use pdembree::render::progress::Silent;
use pdembree::render::watch::Unattended;
use pdembree::render::{RenderState, go_on};
use pdembree::film::PixelBounds;
use pdembree::study::exact::{self, ClosedForm};
use pdembree::world::World;

use crate::support::data::root;

const WAVE: &str = "scenes/tests/wave.toml";

fn world(file: &str, settings: &[(&str, String)]) -> World {
    let overrides: Vec<Override> = settings.iter().map(|(key, value)| Override::new(*key, value.clone())).collect();
    let scene = load(&root().join(file), &overrides).unwrap_or_else(|problems| panic!("{problems}")).scene;
    World::new(scene).expect("a world")
}

fn rendered(world: &World, first: u32, passes: u32) -> RenderState {
    let mut state = RenderState::new(world, PixelBounds::whole(world.scene.camera.resolution), first);
    go_on(world, &mut state, &Unattended(&Silent), |state| state.film.passes() < passes).expect("a render");
    state
}

/// Share of the lit pixels whose exact value lies in their 95 % interval, and their number.
fn coverage(form: ClosedForm, file: &str, settings: &[(&str, String)], passes: u32) -> (f64, usize) {
    let world = world(file, settings);
    let exact = exact::picture(form, &world.scene).expect("the closed form");
    let state = rendered(&world, 0, passes);
    let known = state.film.mean_errors().expect("several passes");
    let lit = known.iter().zip(&exact.radiance).zip(&exact.error).filter(|((known, _), _)| known.standard_error > 0.0);
    let inside = |((known, exact), error): &((&pdembree::film::MeanError, &[f64; 3]), &[f64; 3])| {
        (known.mean - exact[1]).abs() <= known.half_width() + error[1]
    };
    let (count, held) = (lit.clone().count(), lit.filter(inside).count());
    (held as f64 / count as f64, count)
}

#[test]
fn explore() {
    for (method, emission, photons, bandwidth, passes) in [
        ("photon_map", "lattice", 2000, "auto", 16),
        ("photon_map", "lattice", 20000, "auto", 16),
        ("photon_map", "random", 2000, "auto", 16),
        ("photon_map", "random", 2000, "1.5", 16),
        ("photon_map", "jittered", 2000, "auto", 16),
        ("light", "random", 200_000, "auto", 16),
        ("light", "random", 200_000, "auto", 64),
        ("light", "lattice", 200_000, "auto", 16),
    ] {
        let bandwidth = if bandwidth == "auto" { "\"auto\"".to_owned() } else { bandwidth.to_owned() };
        let settings = [
            ("camera.resolution", "[120, 20]".to_owned()),
            ("render.method", method.to_owned()),
            ("render.emission", emission.to_owned()),
            ("render.photons", photons.to_string()),
            ("render.bandwidth", bandwidth.clone()),
            ("render.max_depth", if method == "light" { "3" } else { "2" }.to_owned()),
            ("render.spp", "4".to_owned()),
        ];
        println!("{method} {emission} {photons} {bandwidth} {passes}: {:?}", coverage(ClosedForm::Wave, WAVE, &settings, passes));
    }
}
