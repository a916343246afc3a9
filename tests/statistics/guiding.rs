//! Guided photons carry the light that unguided ones do, to the same places, and more of them arrive.
//!
//! Of the scenes that people start from: the light stored and its moments over the floor, guided and not, over many
//! random sets of photons, by Welch's test.

use std::path::Path;

use pdembree::import::{Override, load};
use pdembree::photon::PhotonMap;
use pdembree::render::photon_map::shoot_all;
use pdembree::render::progress::Silent;
use pdembree::world::World;

use crate::support::statistics::{Moments, assert_plausible, welch};

const RUNS: u64 = 24;
const PHOTONS: u64 = 10_000;

/// Area, point, spot and directional lights between them.
const SCENES: [&str; 5] = ["ring/ring", "ball/ball", "glass/glass", "reflection/reflection", "tests/plane_mirror"];

fn map(scene: &str, guiding: &str, seed: u64) -> PhotonMap {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene).with_extension("toml");
    let overrides = [
        Override::new("render.photons", PHOTONS.to_string()),
        Override::new("render.seed", seed.to_string()),
        Override::new("render.emission", "\"random\"".to_owned()),
        Override::new("render.guiding", format!("{guiding:?}")),
    ];
    let scene = load(&path, &overrides).unwrap_or_else(|error| panic!("{scene}: {error}")).scene;
    shoot_all(&World::new(scene).expect("a world"), 0, &Silent)
}

/// All light, W, and its moments about the origin, W m.
fn light(map: &PhotonMap) -> [f64; 4] {
    let mut light = [0.0; 4];
    for photon in &map.photons {
        let (flux, p) = (photon.flux().0.luminance(), photon.position());
        for (sum, weight) in light.iter_mut().zip([1.0, p.x, p.y, p.z]) {
            *sum += flux * weight;
        }
    }
    light
}

#[test]
fn guided_photons_carry_the_same_light_to_the_same_places() {
    for scene in SCENES {
        let mut moments = [[Moments::default(); 4]; 2];
        let mut stored = [0u64; 2];
        for (k, guiding) in ["off", "on"].into_iter().enumerate() {
            for run in 0..RUNS {
                let map = map(scene, guiding, 2 * run + k as u64);
                light(&map).into_iter().zip(&mut moments[k]).for_each(|(x, of)| of.push(x));
                stored[k] += map.counts.photons_stored;
            }
        }
        let [off, on] = moments;
        for (off, on) in off.into_iter().zip(on) {
            // Photons on a plane through the origin have no moment across it.
            if off.variance() > 0.0 || on.variance() > 0.0 {
                let what = format!("{scene}: {off} unguided, {on} guided");
                assert_plausible(welch(&off, &on), 4 * SCENES.len(), what);
            }
        }
        println!("{scene}: {} stored unguided, {} guided, of {} each", stored[0], stored[1], RUNS * PHOTONS);
        assert!(stored[1] as f64 > 0.97 * stored[0] as f64, "{scene}: guiding lost photons: {stored:?}");
    }
}
