//! Many passes: what the error estimate claims, how fast the error falls, and where the mean goes.

use pdembree::estimate::bandwidth;
use pdembree::film::{MeanError, PixelBounds};
use pdembree::import::{Override, load};
use pdembree::render::progress::Silent;
use pdembree::render::watch::Unattended;
use pdembree::render::{RenderState, go_on};
use pdembree::scene::settings::EmissionPattern;
use pdembree::study::exact::{self, ClosedForm, ExactPicture};
use pdembree::study::fit::power_law;
use pdembree::world::World;

use crate::support::data::root;
use crate::support::statistics::Moments;

const WAVE: &str = "scenes/tests/wave.toml";

const SEEDS: std::ops::RangeInclusive<u64> = 1..=4;
const PASSES: u32 = 16;

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

/// Share of the lit pixels whose exact value lies in their 95 % interval.
fn coverage(form: ClosedForm, file: &str, size: &str, settings: &[(&str, String)], passes: u32) -> f64 {
    let size = [("camera.resolution", size.to_owned())];
    let exact = exact::picture(form, &world(file, &size).scene).expect("the closed form");
    let world = world(file, &[&size[..], settings].concat());
    let state = rendered(&world, 0, passes);
    let known = state.film.mean_errors().expect("several passes");
    let lit = known.iter().zip(&exact.radiance).zip(&exact.error).filter(|((known, _), _)| known.standard_error > 0.0);
    let inside = |((known, exact), error): &((&MeanError, &[f64; 3]), &[f64; 3])| {
        (known.mean - exact[1]).abs() <= known.half_width() + error[1]
    };
    let (count, held) = (lit.clone().count(), lit.filter(inside).count());
    assert!(count > 100, "{count} lit pixels");
    held as f64 / count as f64
}

/// Claimed 95 %: the mean share over seeds lies between 93 and 97 %, for every emission and for light paths.
#[test]
fn intervals_hold_as_often_as_they_claim() {
    let wave = (ClosedForm::Wave, WAVE, "[120, 6]", 2);
    let ball = (ClosedForm::BallLens, "scenes/tests/ball_lens.toml", "[16, 16]", 3);
    let photons = ("photon_map", 20_000);
    let paths = ("light", 50_000);
    for ((form, file, size, depth), (method, photons), emission) in [
        (wave, photons, "lattice"),
        (wave, photons, "jittered"),
        (wave, photons, "random"),
        (wave, paths, "random"),
        (ball, photons, "lattice"),
        (ball, paths, "random"),
    ] {
        let of_seed = |seed: u64| {
            let settings = [
                ("render.method", method.to_owned()),
                ("render.emission", emission.to_owned()),
                ("render.photons", photons.to_string()),
                // Light paths count the edge to the camera too.
                ("render.max_depth", (depth + i32::from(method == "light")).to_string()),
                ("render.spp", "4".to_owned()),
                ("render.seed", seed.to_string()),
            ];
            coverage(form, file, size, &settings, PASSES)
        };
        let shares: Moments = SEEDS.map(of_seed).collect();
        println!("{form:?}, {method}, {emission}: {shares} of the pixels are in their interval");
        assert!((0.93..=0.97).contains(&shares.mean), "{form:?}, {method}, {emission}: {shares}");
    }
}

/// Passes at which the error is looked at.
const LADDER: [u32; 6] = [1, 4, 16, 64, 256, 1000];
/// Renders whose errors are looked at together: those of the first passes alone are noisy.
const RUNS: u64 = 3;
/// Renders of the first pass, to know its bias.
const FIRST_PASSES: u64 = 300;

/// Root of the mean square over pixels of the bias alone: what is left of (mean − exact)² when the mean's own variance is
/// taken off.
fn bias(state: &RenderState, exact: &ExactPicture) -> f64 {
    let known = state.film.mean_errors().expect("several passes");
    let square =
        |(pixel, exact): (&MeanError, &[f64; 3])| (pixel.mean - exact[1]).powi(2) - pixel.standard_error.powi(2);
    let mean = known.iter().zip(&exact.radiance).map(square).sum::<f64>() / known.len() as f64;
    mean.max(0.0).sqrt()
}

/// Few photons of wide footprints, and two folds in the picture: the first pass is badly biased, the mean of a thousand
/// is not. Without narrowing its error would stay at the first pass's bias.
#[test]
fn the_mean_of_a_thousand_passes_goes_to_the_exact_picture() {
    let size = [("camera.resolution", "[60, 2]".to_owned())];
    let exact = exact::picture(ClosedForm::Wave, &world(WAVE, &size).scene).expect("the closed form");
    for (pattern, photons) in [(EmissionPattern::Lattice, 500), (EmissionPattern::Random, 2000)] {
        let with = |seed: u64| {
            let settings = [
                ("render.emission", pattern.name().to_owned()),
                ("render.photons", photons.to_string()),
                ("render.spp", "1".to_owned()),
                ("render.seed", seed.to_string()),
            ];
            world(WAVE, &[&size[..], &settings].concat())
        };
        let worlds: Vec<World> = (0..RUNS).map(|run| with(FIRST_PASSES + run)).collect();
        let mut states: Vec<RenderState> = worlds.iter().map(|world| rendered(world, 0, 0)).collect();
        let mut errors = Vec::new();
        for passes in LADDER {
            let mut mean = 0.0;
            for (world, state) in worlds.iter().zip(&mut states) {
                go_on(world, state, &Unattended(&Silent), |state| state.film.passes() < passes).expect("a render");
                let image = state.film.resolve();
                let green = image.channel("G").expect("beauty");
                let square = |(&v, exact): (&f32, &[f64; 3])| (f64::from(v) - exact[1]).powi(2);
                mean += green.iter().zip(&exact.radiance).map(square).sum::<f64>() / (green.len() as f64 * RUNS as f64);
            }
            errors.push((f64::from(passes), mean.sqrt()));
        }
        let law = power_law(&errors).expect("a line");
        let narrowing = |pass| bandwidth::narrowing(pattern, pass);
        // The exponent of bias and noise alike, −2γ = ln c²(1000)/ln 1000.
        let predicted = 2.0 * narrowing(999).ln() / 1000f64.ln();

        let mut first = rendered(&with(0), 0, 1);
        (1..FIRST_PASSES).for_each(|seed| first.add_passes(&rendered(&with(seed), 0, 1)));
        let (before, after) = (bias(&first, &exact), bias(&states[0], &exact));
        // A smooth irradiance's bias goes like c², one that is cut off like c at most.
        let slowest = (0..1000).map(narrowing).sum::<f64>() / 1000.0;
        println!("{}: errors {errors:.4?}, slope {law:?}, predicted {predicted:.3}", pattern.name());
        println!("bias {before:.5} of one pass, {after:.5} of a thousand: {:.3}, at most {slowest:.3}", after / before);
        assert!(law.slope <= predicted + law.half_width.expect("six points"), "{}: {law:?}", pattern.name());
        assert!(after < slowest * before, "{}: {before} and {after}", pattern.name());
    }
}
