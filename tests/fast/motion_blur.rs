//! Blurred pictures against closed forms: every estimate sees things where they are at its own time.

use std::path::Path;

use pdembree::film::Image;
use pdembree::import::load_text;
use pdembree::render::{self, progress::Silent};
use pdembree::world::World;

/// A matte floor under a parallel beam at 45°, and a card that goes 1 m to the right within a second: its shadow, 1 m beside
/// it, sweeps over the floor from x = 0 to x = 1, and the point x is lit for the part x of the time. The camera sees x from
/// 0 to 1 in 16 columns.
const SHADOW: &str = r#"
format = 1
[camera]
type = "orthographic"
position = [0.5, 5, 0]
target = [0.5, 0, 0]
up = [0, 0, -1]
width = 1
resolution = [16, 4]
shutter = [2, 3]
[render]
spp = 64
max_bounces = 0
photons = 400000
[materials.floor]
type = "lambert"
albedo = 0.5
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [3, 0, 0]
b = [0, 0, -3]
material = "floor"
[[objects]]
shape = "rectangle"
centre = [-2, 1, 0]
a = [1, 0, 0]
b = [0, 0, -2]
material = "floor"
motion = [{ time = 2, transform = [] }, { time = 3, transform = [{ translate = [1, 0, 0] }] }]
[[lights]]
type = "directional"
direction = [1, -1, 0]
irradiance = 1
"#;

fn picture(text: &str) -> Image {
    let scene = load_text(Path::new("blur.toml"), text, &[]).unwrap_or_else(|problems| panic!("{problems}")).scene;
    let world = World::new(scene).expect("a sound world");
    render::render(&world, &Silent).expect("a frame").film.resolve()
}

/// Means of the columns of pixels.
fn columns(image: &Image) -> Vec<f64> {
    let [red, ..] = image.rgb("").expect("the beauty");
    let (width, height) = (image.width as usize, image.height as usize);
    (0..width).map(|x| (0..height).map(|y| f64::from(red[y * width + x])).sum::<f64>() / height as f64).collect()
}

/// Lit for the part x of the time: radiance ρ/π · cos 45° · x.
#[test]
fn a_moving_shadow_leaves_a_ramp() {
    let full = 0.5 / std::f64::consts::PI * std::f64::consts::FRAC_1_SQRT_2;
    // Stratified times err by at most one of 64 strata in a sample's sum; light paths by chance: 400 000 over 36 m².
    for (method, bound) in [("path", 1.0 / 64.0), ("light", 0.1), ("photon_map", 1.0 / 64.0)] {
        let text = SHADOW.replace("[render]", &format!("[render]\nmethod = \"{method}\""));
        for (i, value) in columns(&picture(&text)).into_iter().enumerate() {
            let expected = (i as f64 + 0.5) / 16.0;
            let found = value / full;
            assert!((found - expected).abs() < bound, "{method}, column {i}: {found}, not {expected}");
        }
    }
}

/// A camera that moves over the edge of a floor sees it for part of the time, too, in every method.
#[test]
fn a_moving_camera_blurs_an_edge() {
    let moving = SHADOW
        .replace("centre = [-2, 1, 0]", "centre = [-9, 1, 0]")
        .replace("centre = [0, 0, 0]", "centre = [-2, 0, 0]")
        .replace(
            "shutter",
            "motion = [{ time = 2, position = [0.5, 5, 0], target = [0.5, 0, 0] }, \
                             { time = 3, position = [1.5, 5, 0], target = [1.5, 0, 0] }]\nshutter",
        );
    let full = 0.5 / std::f64::consts::PI * std::f64::consts::FRAC_1_SQRT_2;
    for (method, bound) in [("path", 1.0 / 64.0), ("light", 0.1)] {
        let text = moving.replace("[render]", &format!("[render]\nmethod = \"{method}\""));
        for (i, value) in columns(&picture(&text)).into_iter().enumerate() {
            // Column x sees the floor, up to x = 1, until the camera has moved on by 1 − x.
            let expected = 1.0 - (i as f64 + 0.5) / 16.0;
            let found = value / full;
            assert!((found - expected).abs() < bound, "{method}, column {i}: {found}, not {expected}");
        }
    }
}
