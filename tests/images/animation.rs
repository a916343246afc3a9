//! Frames of an animation: what stands still does not flicker, and what moves goes its way from frame to frame.

use std::path::Path;

use pdembree::film::Image;
use pdembree::import::{Override, load};
use pdembree::output::png;
use pdembree::render::{self, progress::Silent};
use pdembree::world::World;

use crate::support::data::root;

/// A scene of the folder scenes/blur.
fn frame(scene: &str, settings: &[String]) -> Image {
    let overrides: Vec<Override> = settings
        .iter()
        .map(|setting| setting.split_once('=').expect("key=value"))
        .map(|(key, value)| Override::new(key, value))
        .collect();
    let loaded =
        load(&root().join("scenes/blur").join(scene), &overrides).unwrap_or_else(|problems| panic!("{problems}"));
    let world = World::new(loaded.scene).expect("a sound world");
    render::render(&world, &Silent).expect("a frame").film.resolve()
}

/// A frame's caustic.
fn caustic(scene: &str, settings: &[String]) -> Vec<f64> {
    let image = frame(scene, settings);
    image.rgb("caustic").expect("the layer")[0].iter().map(|&x| f64::from(x)).collect()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0u32, 0.0), |(count, sum), x| (count + 1, sum + x * x));
    (sum / f64::from(count)).sqrt()
}

/// A still rod under a camera that goes three pixels a frame: each point of the floor keeps its light over ten frames.
///
/// Photons know nothing of the camera, so that all that may change is where in its pixel the eye looks: the change from
/// frame to frame is the noise of that, which falls with the number of samples in a pixel, by half at least from 16 to 64
/// (as n^−½ for independent ones; stratified ones are better), and at 64 is below one per cent of the caustic.
#[test]
fn a_still_caustic_does_not_flicker_under_a_moving_camera() {
    const FRAMES: usize = 10;
    const STEP: usize = 3;
    let (width, height) = (104, 64);
    let pixel = 1.3 / width as f64;
    let flicker = |spp: u32| {
        let frames: Vec<Vec<f64>> = (0..FRAMES)
            .map(|k| {
                let x = 0.55 + (k * STEP) as f64 * pixel;
                let settings = [
                    format!("camera.resolution=[{width}, {height}]"),
                    format!("camera.position=[{x}, 0.16, 0]"),
                    format!("camera.target=[{x}, 0, 0]"),
                    "camera.shutter=[0.5, 0.5]".to_owned(),
                    format!("render.spp={spp}"),
                ];
                caustic("rod.toml", &settings)
            })
            .collect();
        // Of a point that is `column` pixels from the left in the last frame.
        let at = |k: usize, column: usize, row: usize| frames[k][row * width + column + (FRAMES - 1 - k) * STEP];
        let common = width - (FRAMES - 1) * STEP;
        let points: Vec<(usize, usize)> =
            (0..height).flat_map(|row| (0..common).map(move |column| (column, row))).collect();
        let changes = (1..FRAMES).flat_map(|k| points.iter().map(move |&(c, r)| (k, c, r)));
        let change = rms(changes.map(|(k, c, r)| at(k, c, r) - at(k - 1, c, r)));
        change / rms(points.iter().map(|&(c, r)| at(0, c, r)))
    };
    let [few, many] = [16, 64].map(flicker);
    println!("change from frame to frame: {few:.5} with 16 samples, {many:.5} with 64");
    assert!(many < 0.5 * few && many < 0.01, "{few}, {many}");
}

/// The rod turns through 24 frames, each open for half of its time. All frames side by side are written beside the test's
/// binary to be looked at.
///
/// The farther apart two frames are the more they differ, up to where their caustics do not overlap any more; and all have
/// the same light, but for what leaves the picture.
#[test]
fn a_turning_rod_goes_its_way_through_24_frames() {
    const FRAMES: usize = 24;
    const COLUMNS: usize = 6;
    let (width, height) = (104usize, 64usize);
    let frames: Vec<Vec<f64>> = (0..FRAMES)
        .map(|k| {
            let (open, close) = (k as f64 / FRAMES as f64, (k as f64 + 0.5) / FRAMES as f64);
            let shutter = format!("camera.shutter=[{open}, {close}]");
            caustic("rod.toml", &[format!("camera.resolution=[{width}, {height}]"), shutter])
        })
        .collect();
    let sheet: Vec<[f32; 3]> = (0..FRAMES / COLUMNS * height)
        .flat_map(|y| (0..COLUMNS * width).map(move |x| (x, y)))
        .map(|(x, y)| [frames[y / height * COLUMNS + x / width][y % height * width + x % width] as f32; 3])
        .collect();
    let sheet = Image::from_rgb((COLUMNS * width) as u32, (FRAMES / COLUMNS * height) as u32, &sheet);
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("turning_rod.png");
    png::write(&path, &sheet, 0.0).expect("written");
    println!("{}", path.display());

    let difference = |apart: usize| {
        let pairs = (apart..FRAMES).map(|k| rms(frames[k].iter().zip(&frames[k - apart]).map(|(a, b)| a - b)));
        pairs.sum::<f64>() / (FRAMES - apart) as f64
    };
    let differences = [1, 2, 4].map(difference);
    println!("one, two, four frames apart: {differences:.3?}");
    assert!(differences.is_sorted(), "{differences:?}");
    let light: Vec<f64> = frames.iter().map(|frame| frame.iter().sum()).collect();
    let mean = light.iter().sum::<f64>() / FRAMES as f64;
    let spread = light.iter().map(|light| (light / mean - 1.0).abs()).fold(0.0, f64::max);
    println!("light: within {spread:.4} of the mean");
    // The camera is 0.8 m high and the rod's end goes out to 0.26 m: nearly all stays in.
    assert!(spread < 0.02, "{light:?}");
}
