//! The wave against its closed form, pixel by pixel.
//!
//! As published comparisons do: 480×80 pixels shown as clamp(E/4), E in units of the beam's irradiance. The reference is
//! the average over each pixel, and the picture takes 36 samples a pixel: with nine, stratified but random, two columns
//! at each fold hold four fifths of the squared error.

use std::f64::consts::PI;
use std::path::PathBuf;

use pdembree::film::Image;
use pdembree::import::{Override, load};
use pdembree::render::progress::Silent;
use pdembree::render::render;
use pdembree::world::World;

use crate::support::closed_form::wave;
use crate::support::data::root;

fn picture(scene: PathBuf, overrides: &[(&str, &str)]) -> Image {
    let overrides: Vec<Override> = overrides.iter().map(|&(key, value)| Override::new(key, value)).collect();
    let scene = load(&scene, &overrides).unwrap_or_else(|problems| panic!("{problems}")).scene;
    let world = World::new(scene).expect("a world");
    render(&world, &Silent).expect("a render").film.resolve()
}

/// Root mean square difference of clamp(E/4) between the caustic layer and the exact row.
fn rmse(image: &Image, fresnel: bool) -> f64 {
    let width = image.width as usize;
    let exact = wave::averaged_row(width, fresnel);
    let shown = |e: f64| (e / 4.0).clamp(0.0, 1.0);
    let [_, green, _] = image.rgb("caustic").expect("the caustic layer");
    let square = |(i, &v): (usize, &f32)| (shown(PI * f64::from(v)) - shown(exact[i % width])).powi(2);
    (green.iter().enumerate().map(square).sum::<f64>() / green.len() as f64).sqrt()
}

/// Flux in the picture over the flux that the closed form sends through the same part of the receiver.
fn energy(image: &Image, fresnel: bool) -> f64 {
    let exact = wave::averaged_row(image.width as usize, fresnel);
    let [_, green, _] = image.rgb("caustic").expect("the caustic layer");
    let film = PI * green.iter().map(|&v| f64::from(v)).sum::<f64>() / f64::from(image.height);
    film / exact.iter().sum::<f64>()
}

/// 20 000 photons reach 0.003 with lattice emission (published for random emission: 0.0361), and no flux is lost on the
/// way from the photons to the picture.
#[test]
fn lattice_emission_meets_the_closed_form() {
    for (file, fresnel) in [("scenes/tests/wave.toml", false), ("scenes/refraction/refraction.toml", true)] {
        for seed in ["1", "2", "3"] {
            let image = picture(root().join(file), &[("render.seed", seed)]);
            let (error, energy) = (rmse(&image, fresnel), energy(&image, fresnel));
            println!("{file}, seed {seed}: RMSE {error:.5}, energy {energy:.5}");
            assert!(error <= 0.003, "{file}, seed {seed}: RMSE {error}");
            assert!((energy - 1.0).abs() < 0.005, "{file}, seed {seed}: energy {energy}");
        }
    }
}

/// The method as first published: random emission, the parallelogram's ellipse, Epanechnikov's kernel.
#[test]
fn random_emission_is_as_noisy_as_published() {
    let published = [
        ("render.emission", "random"),
        ("render.footprint", "parallelogram"),
        ("render.kernel", "epanechnikov"),
        ("render.bandwidth", "6"),
        ("render.spp", "9"),
    ];
    let error = rmse(&picture(root().join("scenes/tests/wave.toml"), &published), false);
    println!("random emission, s = 6: RMSE {error:.4}");
    assert!((0.030..=0.045).contains(&error), "RMSE {error}");
}

/// Jensen's estimate at its best k.
#[test]
fn nearest_neighbours_are_as_noisy_as_published() {
    let overrides =
        |k| [("render.emission", "random"), ("render.estimator", "knn"), ("render.k", k), ("render.spp", "9")];
    let scene = || root().join("scenes/tests/wave.toml");
    let errors = ["140", "280", "560"].map(|k| rmse(&picture(scene(), &overrides(k)), false));
    println!("k = 140, 280, 560: RMSE {errors:.4?}");
    let best = errors.into_iter().fold(f64::INFINITY, f64::min);
    assert!((0.065..=0.085).contains(&best), "RMSE {best}");
}
