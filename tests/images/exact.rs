//! The exact pictures of closed forms against light tracing of the same scene files: block by block a t-test of the mean
//! over seeds, all blocks together at one level.

use pdembree::film::Image;
use pdembree::import::{Override, load};
use pdembree::render::progress::Silent;
use pdembree::render::render;
use pdembree::scene::Scene;
use pdembree::study::exact::{self, ClosedForm};
use pdembree::world::World;

use crate::support::data::root;
use crate::support::statistics::{Moments, assert_plausible, t_test};

const SEEDS: u64 = 8;
/// Blocks along a side of the picture.
const BLOCKS: usize = 8;
/// Blocks that expect less than this part of the light are taken together: few paths, far from normally distributed.
const DARK: f64 = 1e-3;

fn scene(file: &str, changes: &[Override]) -> Scene {
    load(&root().join(file), changes).unwrap_or_else(|problems| panic!("{file}: {problems}")).scene
}

fn light_traced(file: &str, changes: &[Override], photons: u64, seed: u64) -> Image {
    let depth = scene(file, changes).settings.max_depth + 1;
    let own = [
        ("render.method", "light".to_owned()),
        ("render.emission", "random".to_owned()),
        // The edge to the camera is counted, too.
        ("render.max_depth", depth.to_string()),
        ("render.photons", photons.to_string()),
        ("render.seed", seed.to_string()),
    ];
    let all: Vec<Override> =
        changes.iter().cloned().chain(own.into_iter().map(|(key, value)| Override::new(key, value))).collect();
    let world = World::new(scene(file, &all)).expect("a world");
    render(&world, &Silent).expect("a render").film.resolve()
}

/// Sums over the blocks of a picture; the dark ones in one.
fn blocks(values: &[f64], side: usize, dark: &[bool]) -> Vec<f64> {
    let mut sums = vec![0.0; BLOCKS * BLOCKS];
    for (i, value) in values.iter().enumerate() {
        sums[i / side * BLOCKS / side * BLOCKS + i % side * BLOCKS / side] += value;
    }
    let rest = sums.iter().zip(dark).filter(|&(_, &dark)| dark).map(|(sum, _)| sum).sum();
    sums.iter().zip(dark).filter(|&(_, &dark)| !dark).map(|(&sum, _)| sum).chain([rest]).collect()
}

fn agree(form: ClosedForm, file: &str, changes: &[&str], photons: u64) {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().expect("an override")).collect();
    let picture = exact::picture(form, &scene(file, &changes)).expect("the closed form");
    let side = picture.width as usize;
    let traced: Vec<Image> = (1..=SEEDS).map(|seed| light_traced(file, &changes, photons, seed)).collect();
    for channel in [0, 2] {
        let expected: Vec<f64> = picture.radiance.iter().map(|rgb| rgb[channel]).collect();
        let all: f64 = expected.iter().sum();
        let dark: Vec<bool> =
            blocks(&expected, side, &[false; BLOCKS * BLOCKS]).iter().map(|sum| *sum < DARK * all).collect();
        let expected = blocks(&expected, side, &dark[..BLOCKS * BLOCKS]);
        let runs: Vec<Vec<f64>> = traced
            .iter()
            .map(|image| {
                let values: Vec<f64> =
                    image.rgb("caustic").expect("a caustic")[channel].iter().map(|&v| f64::from(v)).collect();
                blocks(&values, side, &dark[..BLOCKS * BLOCKS])
            })
            .collect();
        assert!(expected.len() > BLOCKS * BLOCKS / 3, "only {} blocks", expected.len());
        // The blocks, and all of them together.
        for (i, &mean) in expected.iter().enumerate() {
            let sample: Moments = runs.iter().map(|run| run[i]).collect();
            let what = format!("{file}, channel {channel}, seeds 1 to {SEEDS}, block {i}: {sample}, expected {mean}");
            assert_plausible(t_test(&sample, mean), 2 * (expected.len() + 1), what);
        }
        let sample: Moments = runs.iter().map(|run| run.iter().sum::<f64>()).collect();
        println!("{file}, channel {channel}: {sample}, expected {all}");
        let what = format!("{file}, channel {channel}, seeds 1 to {SEEDS}, all: {sample}, expected {all}");
        assert_plausible(t_test(&sample, all), 2 * (expected.len() + 1), what);
    }
}

/// A golden ring: every bounce has its own colour, and the wall's outside mirrors light into the corners.
#[test]
fn light_tracing_finds_the_exact_ring() {
    let gold = ["materials.gold.type=conductor", "materials.gold.preset=gold", "objects.1.material=gold"];
    let changes = [&gold[..], &["camera.width=2.4"]].concat();
    agree(ClosedForm::Ring, "scenes/tests/ring_floor.toml", &changes, 80_000);
}

/// A beam wider than the ball: light that the outside mirrors and light that is reflected inside are in the picture.
#[test]
fn light_tracing_finds_the_exact_ball_lens() {
    let changes = ["render.max_depth=5", "camera.width=4", "lights.0.extent.radius=1.2"];
    agree(ClosedForm::BallLens, "scenes/tests/ball_flux.toml", &changes, 80_000);
    // The same with folds, before the focus.
    let near = [
        "objects.1.centre=[0, -1.1, 0]",
        "camera.target=[0, -1.1, 0]",
        "camera.position=[0, -1.05, 0]",
        "camera.width=0.4",
    ];
    agree(ClosedForm::BallLens, "scenes/tests/ball_flux.toml", &near, 80_000);
}
