//! Environments of images, and casters far apart: photons bring the light that eye paths find, and each group of casters its
//! own, once.

use pdembree::film::Image;
use pdembree::import::{Override, load_text};
use pdembree::photon::PhotonMap;
use pdembree::render::photon_map::shoot_all;
use pdembree::render::progress::Silent;
use pdembree::render::render;
use pdembree::world::World;

use crate::agreement::{PATH, PHOTON_MAP, Settings, assert_blocks_agree, means, world_of};
use crate::support::data::root;
use crate::support::statistics::{Moments, assert_plausible, welch};

/// Pixels of an image of 16 × 8 texels: a dim sky of two colours over a dark ground, and two lamps near the zenith.
fn sky() -> image::Rgb32FImage {
    image::Rgb32FImage::from_fn(16, 8, |x, y| match (x, y) {
        (3 | 4, 1) => image::Rgb([90.0, 70.0, 40.0]),
        (_, 0..4) if x < 8 => image::Rgb([0.5, 0.8, 1.5]),
        (_, 0..4) => image::Rgb([1.0, 0.6, 0.3]),
        _ => image::Rgb([0.02; 3]),
    })
}

/// A glass ball over a matte floor under that sky.
const BALL: &str = r#"
format = 1
[camera]
type = "orthographic"
position = [4, 2, 0]
target = [0, 0, 0]
width = 1.6
resolution = [16, 16]
[render]
max_bounces = 1
[materials.glass]
type = "dielectric"
ior = 1.5
[materials.floor]
type = "lambert"
albedo = [0.7, 0.5, 0.3]
[[objects]]
shape = "sphere"
centre = [0, 0.9, 0]
radius = 0.5
material = "glass"
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [3, 0, 0]
b = [0, 0, -3]
material = "floor"
[[lights]]
type = "environment"
radiance = { image = "sky.hdr", factor = 2 }
rotation_degrees = 35
"#;

const RUNS: u64 = 8;

fn pictures(settings: &Settings) -> Vec<Image> {
    let folder = tempfile::tempdir().expect("a folder");
    sky().save(folder.path().join("sky.hdr")).expect("written");
    let picture = |seed| {
        let world = world_of(&folder.path().join("scene.toml"), BALL, settings, seed);
        render(&world, &Silent).expect("a sound camera").film.resolve()
    };
    (0..RUNS).map(picture).collect()
}

/// Photons alone, both by their parts, and the path tracer, part by part of the light.
#[test]
fn photons_from_an_image_agree_with_paths_into_it() {
    let paths = pictures(&Settings { spp: 1024, ..PATH });
    for caustics in ["photons", "shared"] {
        let pair = [pictures(&Settings { caustics, ..PHOTON_MAP }), paths.clone()];
        for layer in ["caustic", "direct", "indirect"] {
            let light = assert_blocks_agree(&pair, layer, 4);
            assert!(light > 0.0, "{layer}: {}", means(&pair, layer));
        }
    }
}

/// Two glass balls in a row along the sun's rays, so that one stands in the other's light, and a third aside, over a floor.
const ROW: &str = r#"
format = 1
[camera]
type = "orthographic"
position = [0, 5, 0]
target = [0, 0, 0]
up = [0, 0, 1]
width = 20
resolution = [8, 8]
[materials.glass]
type = "dielectric"
ior = 1.5
[materials.floor]
type = "lambert"
albedo = 0.5
[[objects]]
shape = "sphere"
centre = [-5, 1.6, 0]
radius = 0.5
material = "glass"
[[objects]]
shape = "sphere"
centre = [5, 0.6, 0.3]
radius = 0.5
material = "glass"
[[objects]]
shape = "sphere"
centre = [0, 0.6, 8]
radius = 0.4
material = "glass"
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [12, 0, 0]
b = [0, 0, -12]
material = "floor"
[[lights]]
type = "directional"
direction = [10, -1, 0.2]
irradiance = 10
[[lights]]
type = "environment"
radiance = 1
"#;

fn row(guiding: &str, photons: u64, seed: u64) -> PhotonMap {
    let overrides = [
        Override::new("render.photons", photons.to_string()),
        Override::new("render.seed", seed.to_string()),
        Override::new("render.emission", "\"random\"".to_owned()),
        Override::new("render.caustics", "\"photons\"".to_owned()),
        Override::new("render.guiding", format!("{guiding:?}")),
    ];
    let scene = load_text("row.toml".as_ref(), ROW, &overrides).unwrap_or_else(|problems| panic!("{problems}")).scene;
    let world = World::new(scene).expect("a world");
    assert_eq!(world.casters.as_ref().expect("casters").groups.len(), 3);
    shoot_all(&world, 0, &Silent)
}

/// All light and its moments: near each ball, and over all.
fn light(map: &PhotonMap) -> [f64; 6] {
    let mut light = [0.0; 6];
    for photon in &map.photons {
        let (flux, p) = (photon.flux().0.luminance(), photon.position());
        for (sum, weight) in light.iter_mut().zip([1.0, p.x, p.z, p.x * p.x, p.z * p.z, p.x * p.z]) {
            *sum += flux * weight;
        }
    }
    light
}

#[test]
fn groups_of_casters_share_the_light_out() {
    let mut moments = [[Moments::default(); 6]; 2];
    let mut stored = [0u64; 2];
    for (k, (guiding, photons)) in [("off", 200_000), ("on", 10_000)].into_iter().enumerate() {
        for run in 0..24 {
            let map = row(guiding, photons, 2 * run + k as u64);
            light(&map).into_iter().zip(&mut moments[k]).for_each(|(x, of)| of.push(x));
            stored[k] += map.counts.photons_stored;
            assert!(k == 0 || map.counts.other_group > 0, "no photon met another group first");
        }
    }
    let [off, on] = moments;
    for (i, (off, on)) in off.iter().zip(&on).enumerate() {
        assert_plausible(welch(off, on), 6, format!("moment {i}: {off} in one sphere, {on} in groups"));
    }
    println!("stored: {} of 200000 in one sphere, {} of 10000 in groups", stored[0] / 24, stored[1] / 24);
    assert!(stored[1] > stored[0], "{stored:?}");
}

/// The table beside the glass in `scenes/far`, from above, where its caustic is.
const BESIDE_THE_GLASS: [(&str, &str); 7] = [
    ("camera.position", "[0.14, 1, 0.045]"),
    ("camera.target", "[0.14, 0, 0.045]"),
    ("camera.up", "[0, 0, -1]"),
    ("camera.fov_degrees", "9"),
    ("camera.resolution", "[24, 18]"),
    ("render.spp", "32"),
    ("render.photons", "200000"),
];

/// The caustic in `scenes/far`, pixel by pixel and channel by channel; without the glass far away if it is `near` alone.
fn caustic(near: bool, guiding: &str, seed: u64) -> Vec<f64> {
    let path = root().join("scenes/far/far.toml");
    let text = std::fs::read_to_string(&path).expect("the scene");
    let (before, rest) = text.split_once("[[objects]]\nname = \"far table\"").expect("the far table");
    let (_, after) = rest.split_once("[[lights]]").expect("the lights");
    let text = if near { format!("{before}[[lights]]{after}") } else { text.clone() };
    let own =
        [("render.seed", seed.to_string()), ("render.passes", "1".into()), ("render.guiding", format!("{guiding:?}"))];
    let all = BESIDE_THE_GLASS.map(|(key, value)| (key, value.to_owned())).into_iter().chain(own);
    let overrides: Vec<Override> = all.map(|(key, value)| Override::new(key, value)).collect();
    let scene = load_text(&path, &text, &overrides).unwrap_or_else(|problems| panic!("{problems}")).scene;
    let picture = render(&World::new(scene).expect("a world"), &Silent).expect("a sound camera").film.resolve();
    picture
        .rgb("caustic")
        .expect("the layer")
        .iter()
        .flat_map(|channel| channel.iter().map(|&x| f64::from(x)))
        .collect()
}

/// The sun and the sky over a square kilometre: at equal photons the error of guided emission is less than a thirtieth of that
/// of emission towards all that is specular, which misses the glass. The reference is of other photons, six times as many,
/// and knows of no glass far away, so that it needs no guide.
#[test]
fn guided_photons_find_a_glass_in_a_square_kilometre() {
    let references: Vec<Vec<f64>> = (0..6).map(|run| caustic(true, "off", 100 + run)).collect();
    let pixels = references[0].len();
    let truth: Vec<Moments> = (0..pixels).map(|i| references.iter().map(|picture| picture[i]).collect()).collect();
    let root_mean = |squares: f64| (squares / pixels as f64).sqrt();
    let own: f64 = root_mean(truth.iter().map(|m| m.standard_error().powi(2)).sum());
    let error = |picture: &[f64]| root_mean(picture.iter().zip(&truth).map(|(x, m)| (x - m.mean).powi(2)).sum());
    let [on, off] = ["on", "off"].map(|guiding| error(&caustic(false, guiding, 7)));
    println!("RMSE {on:.5} guided, {off:.5} unguided: 1/{:.0}; standard error of the reference {own:.5}", off / on);
    assert!(own < on, "the reference is no better than what it judges: {own}, {on}");
    assert!(30.0 * on < off, "{on} guided, {off} unguided");
}
