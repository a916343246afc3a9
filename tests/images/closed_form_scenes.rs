//! Every scene of scenes/tests against its own [expect] table: region means over seeds as t-tests.

use std::path::Path;

use pdembree::film::Image;
use pdembree::import::{Override, load};
use pdembree::render::progress::Silent;
use pdembree::render::render;
use pdembree::world::World;

use crate::support::data::root;
use crate::support::source::files;
use crate::support::statistics::{Moments, sidak, t_test};

/// Renders of each scene and method.
const SEEDS: u64 = 6;

/// One rectangle of pixels and what its mean is.
struct Region {
    layer: String,
    /// x0, y0, x1, y1; the last column and row are not in it.
    pixels: [usize; 4],
    mean: f64,
    /// Relative error that the estimate's kernel may bring.
    bias: f64,
}

struct Expectation {
    methods: Vec<String>,
    /// `max_depth` of light tracing, which counts the edge to the camera.
    light_depth: Option<i64>,
    scale: f64,
    regions: Vec<Region>,
}

fn number(value: &toml::Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64)).expect("a number")
}

impl Expectation {
    /// The [expect] table of a scene file; a scene without one is a mistake.
    fn read(path: &Path) -> Expectation {
        let text = std::fs::read_to_string(path).expect("a readable scene");
        let file: toml::Table = text.parse().expect("TOML");
        let expect = file.get("expect").unwrap_or_else(|| panic!("{}: no [expect]", path.display()));
        let methods = expect["methods"].as_array().expect("methods").iter();
        let region = |r: &toml::Value| {
            let pixels: Vec<usize> =
                r["pixels"].as_array().expect("pixels").iter().map(|p| number(p) as usize).collect();
            Region {
                layer: r["layer"].as_str().expect("layer").into(),
                pixels: pixels.try_into().expect("four numbers"),
                mean: number(&r["mean"]),
                bias: number(&r["bias"]),
            }
        };
        Expectation {
            methods: methods.map(|m| m.as_str().expect("a method").into()).collect(),
            light_depth: expect.get("light_depth").and_then(toml::Value::as_integer),
            scale: number(&expect["scale"]),
            regions: expect["regions"].as_array().expect("regions").iter().map(region).collect(),
        }
    }
}

fn picture(path: &Path, method: &str, light_depth: Option<i64>, seed: u64) -> Image {
    let mut overrides = vec![Override::new("render.method", method), Override::new("render.seed", seed.to_string())];
    if let ("light", Some(depth)) = (method, light_depth) {
        overrides.push(Override::new("render.max_depth", depth.to_string()));
    }
    let loaded = load(path, &overrides).unwrap_or_else(|problems| panic!("{}: {problems}", path.display()));
    let world = World::new(loaded.scene).expect("a world");
    render(&world, &Silent).expect("a render").film.resolve()
}

/// Mean of the green channel over the region (the scenes are grey).
fn region_mean(image: &Image, region: &Region) -> f64 {
    let [_, green, _] = image.rgb(&region.layer).unwrap_or_else(|| panic!("no layer `{}`", region.layer));
    let [x0, y0, x1, y1] = region.pixels;
    assert!(x0 < x1 && y0 < y1 && x1 <= image.width as usize && y1 <= image.height as usize, "{:?}", region.pixels);
    let rows = (y0..y1).flat_map(|y| &green[y * image.width as usize..][x0..x1]);
    rows.map(|&v| f64::from(v)).sum::<f64>() / ((x1 - x0) * (y1 - y0)) as f64
}

/// p-value of "the mean is within `bias` of the expected one".
fn plausibility(sample: &Moments, region: &Region) -> f64 {
    // The picture's samples are f32.
    let slack = (region.bias + f64::from(f32::EPSILON)) * region.mean.abs();
    t_test(sample, sample.mean.clamp(region.mean - slack, region.mean + slack))
}

fn check(path: &Path) -> Vec<String> {
    let expectation = Expectation::read(path);
    let level = sidak(expectation.methods.len() * expectation.regions.len());
    let mut wrong = Vec::new();
    for method in &expectation.methods {
        let images: Vec<Image> = (1..=SEEDS).map(|seed| picture(path, method, expectation.light_depth, seed)).collect();
        for region in &expectation.regions {
            let sample: Moments = images.iter().map(|image| expectation.scale * region_mean(image, region)).collect();
            let p = plausibility(&sample, region);
            let name = path.file_name().expect("a name").to_string_lossy();
            let line = format!(
                "{name}, {method}, seeds 1 to {SEEDS}, `{}` {:?}: {sample}, expected {} (bias {}), p = {p:.2e}",
                region.layer, region.pixels, region.mean, region.bias
            );
            println!("{line}");
            if p < level {
                wrong.push(line);
            }
        }
    }
    wrong
}

#[test]
fn closed_form_scenes_render_what_they_expect() {
    let scenes = files(&root().join("scenes/tests"), "toml");
    assert!(scenes.len() >= 9, "only {} scenes", scenes.len());
    let wrong: Vec<String> = scenes.iter().flat_map(|path| check(path)).collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
