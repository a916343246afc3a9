//! Light between surfaces that scatter, by photons: its energy in a furnace, a closed form, and what happens between a
//! mirror and a diffuser.

use std::f64::consts::TAU;

use pdembree::film::Image;
use pdembree::import;
use pdembree::render::{self, progress::Silent};
use pdembree::scene::settings::BounceFootprint;
use pdembree::world::World;

use super::agreement::BALL;
use crate::support::statistics::{Moments, assert_plausible, t_test};

/// Rendered with each of `seeds` and settings laid over it.
fn pictures(scene: &str, settings: &[(&str, &str)], seeds: u64) -> Vec<Image> {
    let picture = |seed: u64| {
        let over = |&(key, value): &(&str, &str)| import::Override::new(key, value);
        let mut overrides: Vec<_> = settings.iter().map(over).collect();
        overrides.push(import::Override::new("render.seed", seed.to_string()));
        let loaded = import::load_text("interreflection.toml".as_ref(), scene, &overrides).expect("a sound scene");
        let world = World::new(loaded.scene).expect("a sound world");
        render::render(&world, &Silent).expect("a sound camera").film.resolve()
    };
    (0..seeds).map(picture).collect()
}

/// The six walls of a box about the origin, half a side of 1 m; each shines.
fn furnace() -> String {
    let walls = [
        "centre = [0, 0, -1]\na = [1, 0, 0]\nb = [0, 1, 0]",
        "centre = [0, 0, 1]\na = [1, 0, 0]\nb = [0, -1, 0]",
        "centre = [0, 1, 0]\na = [1, 0, 0]\nb = [0, 0, 1]",
        "centre = [0, -1, 0]\na = [1, 0, 0]\nb = [0, 0, -1]",
        "centre = [-1, 0, 0]\na = [0, 1, 0]\nb = [0, 0, 1]",
        "centre = [1, 0, 0]\na = [0, -1, 0]\nb = [0, 0, 1]",
    ];
    let head = r#"
format = 1
[camera]
type = "perspective"
position = [-0.3, -0.8, 0.2]
target = [0.2, 0, -0.25]
fov_degrees = 90
resolution = [16, 16]
[render]
max_bounces = 40
max_depth = 64
spp = 16
photons = 50000
[materials.wall]
type = "lambert"
albedo = 0.5
"#;
    let wall = |w: &str| format!("[[objects]]\nshape = \"rectangle\"\n{w}\nmaterial = \"wall\"\nemission = 1\n");
    head.to_owned() + &walls.map(wall).concat()
}

/// Root mean squares over the pixels of how far their expected value is from `exact`, and of their standard deviation.
fn bias_and_noise(pictures: &[Image], exact: f64) -> [f64; 2] {
    let reds: Vec<&[f32]> = pictures.iter().map(|picture| picture.rgb("").expect("a picture")[0]).collect();
    let pixels = reds[0].len();
    let [mut squares, mut variances] = [0.0; 2];
    for pixel in 0..pixels {
        let moments: Moments = reds.iter().map(|red| f64::from(red[pixel])).collect();
        let error = moments.standard_error();
        // The mean of so many pictures has noise of its own.
        squares += (moments.mean - exact).powi(2) - error * error;
        variances += error * error * pictures.len() as f64;
    }
    [squares, variances].map(|sum| (sum.max(0.0) / pixels as f64).sqrt())
}

/// In a closed box whose walls shine with L and reflect ρ, everything shines with L/(1 − ρ): within half a per cent, edges
/// and corners in the picture, for every policy of the footprints, whether the eye sees photons straight or over a bounce.
/// The mean is known to a sixth of that.
#[test]
fn a_furnace_is_as_bright_as_it_must_be_with_every_policy() {
    let furnace = furnace();
    for indirect in ["\"global\"", "\"final_gather\""] {
        for policy in BounceFootprint::NAMES {
            let policy = format!("{policy:?}");
            let settings = [("render.indirect", indirect), ("render.bounce_footprint", &policy)];
            let mean = |picture: &Image| {
                let [red, _, _] = picture.rgb("").expect("a picture");
                red.iter().copied().map(f64::from).sum::<f64>() / red.len() as f64
            };
            let pictures = pictures(&furnace, &settings, 12);
            let all: Moments = pictures.iter().map(mean).collect();
            let [bias, noise] = bias_and_noise(&pictures, 2.0);
            println!(
                "{indirect}, {policy}: {:.4} ± {:.4}, exactly 2; of pixels: bias {:.2} %, standard deviation {:.2} %",
                all.mean,
                all.standard_error(),
                50.0 * bias,
                50.0 * noise
            );
            assert!(all.standard_error() < 0.0015, "{policy}: {all}");
            assert!((all.mean / 2.0 - 1.0).abs() < 0.005, "{indirect}, {policy}: {all}, not 2");
        }
    }
}

/// A red wall, x and y in ±1 at z = 0, under slanting parallel light of 2 W/m², and a grey one over it at z = 1 that only
/// sees what the red one sends; the camera looks at its middle.
const FACING: &str = r#"
format = 1
[camera]
type = "orthographic"
position = [0, 0, 0.5]
target = [0, 0, 1]
up = [0, 1, 0]
width = 1
resolution = [8, 8]
[render]
max_bounces = 1
spp = 16
photons = 100000
[materials.red]
type = "lambert"
albedo = [0.8, 0.2, 0.1]
[materials.grey]
type = "lambert"
albedo = 0.6
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [1, 0, 0]
b = [0, 1, 0]
material = "red"
[[objects]]
shape = "rectangle"
centre = [0, 0, 1]
a = [2, 0, 0]
b = [0, -2, 0]
material = "grey"
[[lights]]
type = "directional"
direction = [6, 0, -1]
irradiance = 2
"#;

/// The part of a point's cosine-weighted hemisphere that a rectangle fills, which lies parallel to it at distance 1 with a
/// corner over the point and sides a and b.
fn corner_form_factor(a: f64, b: f64) -> f64 {
    let part = |x: f64, y: f64| {
        let h = x.hypot(1.0);
        x / h * (y / h).atan()
    };
    (part(a, b) + part(b, a)) / TAU
}

/// First bounce between facing walls: L(x, y) = ρ ρ' E cos/π times the form factor of the red wall, in every pixel, for eye
/// paths and for photons.
#[test]
fn light_of_a_red_wall_on_a_grey_one_is_the_closed_form_s() {
    let exact = |x: f64, y: f64, albedo: f64| {
        let corners = [1.0 - x, 1.0 + x].map(|a| [1.0 - y, 1.0 + y].map(|b| corner_form_factor(a, b)));
        let form_factor: f64 = corners.as_flattened().iter().sum();
        0.6 * albedo * 2.0 / 37f64.sqrt() / std::f64::consts::PI * form_factor
    };
    // A pixel's mean, Simpson's rule in both directions; the image's rows run down, its columns along −x or x.
    let mean = |i: usize, j: usize, albedo: f64| {
        let at = |k: usize, t: f64| (k as f64 + t) / 8.0 - 0.5;
        let weights = [(0.0, 1.0), (0.5, 4.0), (1.0, 1.0)];
        let sum: f64 =
            weights.iter().flat_map(|&(s, u)| weights.map(|(t, v)| u * v * exact(at(i, s), at(j, t), albedo))).sum();
        sum / 36.0
    };
    for (indirect, method) in
        [("path", "path"), ("path", "photon_map"), ("global", "photon_map"), ("final_gather", "photon_map")]
    {
        let [indirect, method] = [indirect, method].map(|name| format!("{name:?}"));
        let settings = [("render.indirect", indirect.as_str()), ("render.method", method.as_str())];
        let pictures = pictures(FACING, &settings, 8);
        for (channel, albedo) in [0.8, 0.2, 0.1].into_iter().enumerate() {
            for pixel in 0..64 {
                let value = |picture: &Image| f64::from(picture.rgb("").expect("a picture")[channel][pixel]);
                let sample: Moments = pictures.iter().map(value).collect();
                let expected = mean(pixel % 8, pixel / 8, albedo);
                let what = format!("{method} {indirect}, pixel {pixel}, channel {channel}: {sample}, not {expected}");
                assert_plausible(t_test(&sample, expected), 64 * 3, what);
            }
        }
    }
}

/// The ball over a floor, of glass as rough as that, under a small lamp.
fn ball(roughness: &str) -> String {
    let glass = match roughness {
        "0" => "\"dielectric\"".to_owned(),
        _ => format!("\"rough_dielectric\"\nroughness = {roughness}"),
    };
    [
        ("\"dielectric\"", glass.as_str()),
        ("max_bounces = 1", "max_bounces = 3"),
        ("radius = 1\n", "radius = 0.3\n"),
        ("emission = 10", "emission = 100"),
    ]
    .iter()
    .fold(BALL.to_owned(), |scene, (from, to)| scene.replace(from, to))
}

/// From a clear ball to the roughest nothing changes suddenly: the error of 16 samples and 40 000 photons against
/// light paths stays within a factor of 1.3 from one roughness to the next, and below the eye paths' own at four times the
/// samples. The clear end is the delta lobe itself.
#[test]
fn there_is_no_edge_between_smooth_and_rough_glass() {
    let mut before: Option<f64> = None;
    for roughness in ["0", "0.005", "0.05", "0.15", "0.3", "0.45", "0.55", "0.7", "0.85", "1"] {
        // Two references: the mean of (x − a)(x − b) is the mean square error without the references' own noise.
        let references =
            pictures(&ball(roughness), &[("render.method", "\"light\""), ("render.photons", "2000000")], 2);
        let green =
            |picture: &Image| picture.rgb("").expect("a picture")[1].iter().map(|&y| f64::from(y)).collect::<Vec<_>>();
        let [a, b] = [0, 1].map(|i| green(&references[i]));
        let mean = a.iter().chain(&b).copied().collect::<Moments>().mean;
        let rmse = |pictures: &[Image]| {
            let product = |picture| {
                let errors = green(picture).into_iter().zip(a.iter().zip(&b));
                errors.map(|(x, (a, b))| (x - a) * (x - b)).collect::<Moments>().mean
            };
            pictures.iter().map(product).collect::<Moments>().mean.max(0.0).sqrt() / mean
        };
        let photons = rmse(&pictures(&ball(roughness), &[("render.photons", "40000"), ("render.spp", "16")], 4));
        let paths = rmse(&pictures(&ball(roughness), &[("render.method", "\"path\""), ("render.spp", "64")], 4));
        println!("roughness {roughness}: relative RMSE {photons:.4}, eye paths with four times the samples {paths:.4}");
        if let Some(before) = before {
            assert!((photons / before).max(before / photons) < 1.3, "{roughness}: {photons} after {before}");
        }
        assert!(photons < paths, "{roughness}: {photons} against {paths}");
        before = Some(photons);
    }
}
