//! The photon map, path tracing and light tracing are three estimates of one picture: L S⁺ D from photons, from eye
//! paths that run into the light through the glass, and from light paths connected to the camera.
//!
//! Each method renders a small picture several times with different seeds; block by block the means are compared by
//! Welch's test, all blocks together at one level. The kernel's bias is not hidden by a tolerance: the scenes' lights
//! are wide enough for the caustic to be smooth over a footprint, and the tests would fail if it were not.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock};

use pdembree::film::Image;
use pdembree::import;
use pdembree::render::{self, emission, progress::Silent};
use pdembree::world::World;

use crate::support::statistics::{LEVEL, Moments, assert_plausible, welch};

/// Pixels along the side of a picture and of the blocks compared.
const SIDE: usize = 16;
const BLOCK: usize = 4;
const RUNS: u64 = 8;

/// A glass ball over a matte floor under a ball-shaped lamp. The orthographic camera looks under the ball: what it sees
/// through glass, light paths could not connect to.
pub const BALL: &str = r#"
format = 1
[camera]
type = "orthographic"
position = [4, 2, 0]
target = [0, 0, 0]
width = 1.6
resolution = [16, 16]
[render]
max_bounces = 1
layers = ["caustic", "direct", "indirect"]
[materials.glass]
type = "dielectric"
ior = 1.5
[materials.floor]
type = "lambert"
albedo = [0.7, 0.5, 0.3]
[materials.black]
type = "lambert"
albedo = 0
[[objects]]
shape = "sphere"
centre = [0, 1.5, 0]
radius = 0.5
material = "glass"
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [3, 0, 0]
b = [0, 0, -3]
material = "floor"
[[objects]]
shape = "sphere"
centre = [0, 5, 0]
radius = 1
material = "black"
emission = 10
"#;

/// A mirror cylinder on a matte floor beside a slanted lamp; the camera sees the floor before the mirror only.
const MIRROR: &str = r#"
format = 1
[camera]
type = "perspective"
position = [0, 5, 4]
target = [0, 0, 2.2]
fov_degrees = 12
resolution = [16, 16]
[render]
max_bounces = 0
layers = ["caustic", "direct", "indirect"]
[materials.mirror]
type = "mirror"
reflectance = [0.9, 0.8, 0.6]
[materials.floor]
type = "lambert"
albedo = 0.6
[materials.black]
type = "lambert"
albedo = 0
[[objects]]
shape = "cylinder"
base = [0, 0.001, 0]
top = [0, 1, 0]
radius = 0.8
material = "mirror"
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [4, 0, 0]
b = [0, 0, -4]
material = "floor"
[[objects]]
shape = "rectangle"
centre = [0, 2, 4]
a = [0.8, 0, 0]
b = [0, -0.5, -0.5]
material = "black"
emission = 8
two_sided = true
"#;

/// Three matte walls at right angles under a lamp: light over one bounce.
const CORNER: &str = r#"
format = 1
[camera]
type = "perspective"
position = [3, 3, 3]
target = [0, 0.4, 0]
fov_degrees = 20
resolution = [16, 16]
[render]
max_bounces = 2
layers = ["caustic", "direct", "indirect"]
[materials.red]
type = "lambert"
albedo = [0.8, 0.2, 0.2]
[materials.white]
type = "lambert"
albedo = 0.8
[[objects]]
shape = "rectangle"
centre = [1, 0, 1]
a = [0, 0, 1]
b = [1, 0, 0]
material = "white"
[[objects]]
shape = "rectangle"
centre = [0, 1, 1]
a = [0, 1, 0]
b = [0, 0, 1]
material = "red"
[[objects]]
shape = "rectangle"
centre = [1, 1, 0]
a = [1, 0, 0]
b = [0, 1, 0]
material = "white"
[[objects]]
shape = "disk"
centre = [1, 1.9, 1]
normal = [0, -1, 0]
radius = 0.4
material = "white"
emission = 5
"#;

/// A closed room with a ball of glass, one of mirror and one of rough gold under a lamp: light that walls send through
/// glass, over mirrors and back. The lamp's half axis is filled in.
const ROOM: &str = r#"
format = 1
[camera]
type = "perspective"
position = [0, -0.95, 0.1]
target = [0, 0, -0.25]
fov_degrees = 70
resolution = [16, 16]
[render]
max_bounces = 8
layers = ["caustic", "direct", "indirect"]
[materials.white]
type = "lambert"
albedo = 0.6
[materials.red]
type = "lambert"
albedo = [0.6, 0.1, 0.1]
[materials.black]
type = "lambert"
albedo = 0
[materials.glass]
type = "dielectric"
ior = 1.5
[materials.mirror]
type = "mirror"
reflectance = 0.9
[materials.gold]
type = "rough_conductor"
preset = "gold"
roughness = 0.55
[[objects]]
shape = "rectangle"
centre = [0, 0, -1]
a = [1, 0, 0]
b = [0, 1, 0]
material = "white"
[[objects]]
shape = "rectangle"
centre = [0, 0, 1]
a = [1, 0, 0]
b = [0, -1, 0]
material = "white"
[[objects]]
shape = "rectangle"
centre = [0, 1, 0]
a = [1, 0, 0]
b = [0, 0, 1]
material = "white"
[[objects]]
shape = "rectangle"
centre = [0, -1, 0]
a = [1, 0, 0]
b = [0, 0, -1]
material = "white"
[[objects]]
shape = "rectangle"
centre = [-1, 0, 0]
a = [0, 1, 0]
b = [0, 0, 1]
material = "red"
[[objects]]
shape = "rectangle"
centre = [1, 0, 0]
a = [0, -1, 0]
b = [0, 0, 1]
material = "white"
[[objects]]
shape = "sphere"
centre = [-0.45, 0.3, -0.6]
radius = 0.35
material = "mirror"
[[objects]]
shape = "sphere"
centre = [0.45, 0.1, -0.6]
radius = 0.35
material = "glass"
[[objects]]
shape = "sphere"
centre = [0, 0.6, 0.2]
radius = 0.3
material = "gold"
[[objects]]
shape = "rectangle"
centre = [0, 0, 0.99]
a = [HALF, 0, 0]
b = [0, -HALF, 0]
material = "black"
emission = 5
"#;

/// A closed box under a pane of glass, in it a ball of rough gold and one of mirror, and a sky outside; the camera is in it.
const PANE: &str = r#"
format = 1
[camera]
type = "perspective"
position = [0, 0.6, 0.95]
target = [0, 0.2, 0]
fov_degrees = 60
resolution = [16, 16]
[render]
max_bounces = 3
bandwidth = 0.25
[materials.glass]
type = "dielectric"
ior = 1.5
[materials.wall]
type = "lambert"
albedo = [0.6, 0.4, 0.3]
[materials.gold]
type = "rough_conductor"
preset = "gold"
roughness = 0.4
[materials.mirror]
type = "mirror"
reflectance = 0.9
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [1, 0, 0]
b = [0, 0, -1]
material = "wall"
[[objects]]
shape = "rectangle"
centre = [-1, 0.5, 0]
a = [0, 0.5, 0]
b = [0, 0, 1]
material = "wall"
[[objects]]
shape = "rectangle"
centre = [1, 0.5, 0]
a = [0, 0.5, 0]
b = [0, 0, 1]
material = "wall"
[[objects]]
shape = "rectangle"
centre = [0, 0.5, -1]
a = [1, 0, 0]
b = [0, 0.5, 0]
material = "wall"
[[objects]]
shape = "rectangle"
centre = [0, 0.5, 1]
a = [1, 0, 0]
b = [0, 0.5, 0]
material = "wall"
[[objects]]
shape = "rectangle"
centre = [0, 1, 0]
a = [1, 0, 0]
b = [0, 0, -1]
material = "glass"
[[objects]]
shape = "rectangle"
centre = [0, 1.05, 0]
a = [1, 0, 0]
b = [0, 0, 1]
material = "glass"
[[objects]]
shape = "sphere"
centre = [0.4, 0.3, -0.3]
radius = 0.3
material = "gold"
[[objects]]
shape = "sphere"
centre = [-0.4, 0.3, -0.3]
radius = 0.3
material = "mirror"
[[lights]]
type = "environment"
radiance = [0.2, 0.4, 1.0]
[[lights]]
type = "environment"
radiance = [0.5, 0.3, 0.1]
"#;

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Settings {
    pub method: &'static str,
    pub caustics: &'static str,
    pub indirect: &'static str,
    pub spp: u32,
    pub photons: u64,
}

pub const PHOTON_MAP: Settings =
    Settings { method: "photon_map", caustics: "photons", indirect: "path", spp: 16, photons: 40_000 };
/// Photons and eye paths both find caustics of wide lamps.
const SHARED: Settings = Settings { caustics: "shared", ..PHOTON_MAP };
/// With footprints half as wide: all light is blurred by them.
const GLOBAL: Settings = Settings { indirect: "global", photons: 160_000, ..SHARED };
const FINAL_GATHER: Settings = Settings { indirect: "final_gather", ..SHARED };
pub const PATH: Settings = Settings { method: "path", spp: 256, photons: 1, ..PHOTON_MAP };
const PATHS: Settings = Settings { spp: 1024, ..PATH };
pub const LIGHT: Settings = Settings { method: "light", spp: 1, photons: 800_000, ..PHOTON_MAP };

/// The light's parts, and the classes of paths: each adds up to the beauty.
const PARTS: [&str; 3] = ["direct", "caustic", "indirect"];
const CLASSES: [&str; 5] = ["emission", "straight", "focused", "sent_back", "scattered"];

fn world(scene: &str, settings: &Settings, seed: u64) -> World {
    world_of("agreement.toml".as_ref(), scene, settings, seed)
}

/// Of a scene that is read as if it were the file `path`.
pub fn world_of(path: &Path, scene: &str, settings: &Settings, seed: u64) -> World {
    let overrides = [
        ("render.method", format!("\"{}\"", settings.method)),
        ("render.caustics", format!("\"{}\"", settings.caustics)),
        ("render.indirect", format!("\"{}\"", settings.indirect)),
        ("render.layers", format!("{:?}", [PARTS.as_slice(), &CLASSES].concat())),
        ("render.spp", settings.spp.to_string()),
        ("render.photons", settings.photons.to_string()),
        ("render.seed", seed.to_string()),
    ]
    .map(|(key, value)| import::Override::new(key, value));
    let loaded = import::load_text(path, scene, &overrides).expect("a sound scene");
    World::new(loaded.scene).expect("a sound world")
}

fn picture(scene: &str, settings: &Settings, seed: u64) -> Image {
    let picture = render::render(&world(scene, settings, seed), &Silent).expect("a sound camera").film.resolve();
    assert_adds_up(&picture);
    picture
}

/// No light is lost, and none counted twice, between the classes of paths, nor between the parts.
fn assert_adds_up(picture: &Image) {
    let beauty = picture.rgb("").expect("the beauty");
    for layers in [PARTS.as_slice(), &CLASSES] {
        let layers: Vec<_> = layers.iter().map(|layer| picture.rgb(layer).expect("the layer")).collect();
        for (channel, whole) in beauty.iter().enumerate() {
            for (pixel, &whole) in whole.iter().enumerate() {
                let sum: f64 = layers.iter().map(|layer| f64::from(layer[channel][pixel])).sum();
                let whole = f64::from(whole);
                assert!((sum - whole).abs() <= 1e-5 * (1.0 + whole), "pixel {pixel}: {sum}, not {whole}");
            }
        }
    }
}

/// One for each seed; what several tests compare with is rendered once.
pub fn pictures(scene: &str, settings: &Settings) -> Vec<Image> {
    type Rendered = Arc<OnceLock<Vec<Image>>>;
    static RENDERED: Mutex<BTreeMap<(String, Settings), Rendered>> = Mutex::new(BTreeMap::new());
    let key = (scene.to_owned(), *settings);
    // A test that waits for another's pictures does not hold up those that want none of them.
    let pictures = RENDERED.lock().expect("no test panics in here").entry(key).or_default().clone();
    pictures.get_or_init(|| (0..RUNS).map(|seed| picture(scene, settings, seed)).collect()).clone()
}

/// Moments of each block's mean of a layer's channel over the runs; blocks have `side` × `side` pixels.
fn blocks(pictures: &[Image], layer: &str, side: usize) -> Vec<Moments> {
    let across = SIDE / side;
    let mut moments = vec![Moments::default(); across * across * 3];
    for image in pictures {
        let rgb = image.rgb(layer).expect("the layer was asked for");
        for (i, m) in moments.iter_mut().enumerate() {
            let (channel, block) = (i % 3, i / 3);
            let (x0, y0) = (block % across * side, block / across * side);
            let pixels = (0..side * side).map(|p| (y0 + p / side) * SIDE + x0 + p % side);
            let sum: f64 = pixels.map(|p| f64::from(rgb[channel][p])).sum();
            m.push(sum / (side * side) as f64);
        }
    }
    moments
}

/// Whether two methods agree on a layer. Returns how much light the layer holds.
fn assert_agree(scene: &str, a: &Settings, b: &Settings, layer: &str) -> f64 {
    assert_blocks_agree(&[pictures(scene, a), pictures(scene, b)], layer, BLOCK)
}

/// The mean of a layer with each of two methods.
pub fn means(pictures: &[Vec<Image>; 2], layer: &str) -> String {
    let [a, b] = pictures.each_ref().map(|pictures| blocks(pictures, layer, SIDE)[1]);
    format!("{a} against {b}")
}

/// The same of their pictures.
pub fn assert_blocks_agree(pictures: &[Vec<Image>; 2], layer: &str, side: usize) -> f64 {
    let [first, second] = pictures.each_ref().map(|pictures| blocks(pictures, layer, side));
    let lit: Vec<_> = first.iter().zip(&second).filter(|(x, y)| x.mean > 0.0 || y.mean > 0.0).collect();
    for (i, (x, y)) in lit.iter().enumerate() {
        let what = format!("{layer}, block {i}: {x} against {y} (seeds 0..{RUNS}, level {LEVEL})");
        assert_plausible(welch(x, y), lit.len(), what);
    }
    lit.iter().map(|(x, _)| x.mean).sum::<f64>() / lit.len().max(1) as f64
}

#[test]
fn photons_and_eye_paths_agree_on_the_caustic_of_a_ball() {
    assert!(assert_agree(BALL, &PHOTON_MAP, &PATH, "caustic") > 0.01);
}

/// With footprints of their usual width a block at the edge of the caustic has 1.5 % too much light, with sixteen times as many
/// photons 0.8 %, with narrow footprints none: the even samples of a pixel tell that from light paths.
#[test]
fn photons_and_light_paths_agree_on_the_caustic_of_a_ball() {
    let narrow = BALL.replace("[render]", "[render]\nbandwidth = 1");
    assert!(assert_blocks_agree(&[pictures(&narrow, &PHOTON_MAP), pictures(BALL, &LIGHT)], "caustic", BLOCK) > 0.01);
}

#[test]
fn eye_paths_and_light_paths_agree_on_direct_and_indirect_light() {
    assert!(assert_agree(CORNER, &PATH, &LIGHT, "direct") > 0.01);
    assert!(assert_agree(CORNER, &PATH, &LIGHT, "indirect") > 0.01);
}

#[test]
fn all_three_agree_on_the_caustic_of_a_mirror() {
    assert!(assert_agree(MIRROR, &PHOTON_MAP, &PATH, "caustic") > 0.001);
    assert_agree(MIRROR, &PATH, &LIGHT, "caustic");
}

/// Light that was scattered before it went through glass or over a mirror comes from photons that bounce.
#[test]
fn photons_and_eye_paths_agree_on_light_that_is_sent_back() {
    let sent_back = BALL.replace("max_bounces = 1", "max_bounces = 8");
    assert!(assert_agree(&sent_back, &PHOTON_MAP, &PATH, "indirect") > 1e-4);
}

/// Every class of paths is counted once: with mirrors, glass and rough metal in a closed room, under a lamp that eye paths
/// find and one that they hardly do. Over the whole picture, since light that an eye path finds once in 10⁵ times has no
/// normal distribution in a few pixels.
#[test]
fn photons_and_eye_paths_share_a_room_s_light_out() {
    for half in ["0.5", "0.1"] {
        let room = ROOM.replace("HALF", half);
        let reference = pictures(&room, &PATHS);
        for settings in [&SHARED, &GLOBAL, &FINAL_GATHER] {
            let pictures = [pictures(&room, settings), reference.clone()];
            for layer in PARTS.into_iter().chain(CLASSES) {
                let Settings { caustics, indirect, .. } = settings;
                println!("lamp {half}, {caustics}, {indirect}: {layer} {}", means(&pictures, layer));
                assert!(assert_blocks_agree(&pictures, layer, SIDE) > 0.0);
            }
        }
    }
}

/// The eye's part p of a lamp's caustics: p/(1 − p) is in proportion to the eye's samples and against the area of the
/// footprints, whatever the lamp's brightness; of lamps that are not wide it is none. Over flat receivers: on bent ones a
/// footprint that is made wider stays within the bend.
#[test]
fn the_eye_s_part_follows_samples_and_footprints() {
    let odds = |scene: &str, spp| {
        let settings = Settings { spp, photons: 100_000, ..SHARED };
        let plans = emission::plan(&world(scene, &settings, 0)).caustic.plans;
        plans.iter().map(|plan| plan.eyes_part / (1.0 - plan.eyes_part)).collect::<Vec<f64>>()
    };
    let flat = PANE.replace("material = \"gold\"", "material = \"mirror\"");
    let sky = odds(&flat, 64);
    let wider = odds(&flat.replace("bandwidth = 0.25", "bandwidth = 0.5"), 256);
    let brighter =
        odds(&flat.replace("[0.2, 0.4, 1.0]", "[2.0, 4.0, 10.0]").replace("[0.5, 0.3, 0.1]", "[5, 3, 1]"), 64);
    let more = odds(&flat, 128);
    assert_eq!(sky.len(), 2);
    for (k, &sky) in sky.iter().enumerate() {
        for (found, expected) in [(wider[k], sky), (brighter[k], sky), (more[k], 2.0 * sky)] {
            assert!((found / expected - 1.0).abs() < 1e-5, "{found}, not {expected}");
        }
    }
    assert_eq!(odds(BALL, 64), [0.0]);
}

/// Two skies of different colour over a pane of glass, which eye paths run into through the pane and over rough gold: both
/// photons and eye paths bring such light, each to its part.
#[test]
fn photons_and_eye_paths_share_the_light_of_a_sky_out() {
    let reference = pictures(PANE, &PATH);
    for settings in [&SHARED, &GLOBAL] {
        let settings = Settings { photons: 100_000, ..*settings };
        let plans = emission::plan(&world(PANE, &settings, 0)).caustic.plans;
        let parts: Vec<f64> = plans.iter().map(|plan| plan.eyes_part).collect();
        assert!(parts.len() == 2 && parts.iter().all(|&part| part > 0.1 && part < 0.9), "{parts:?}");
        let pictures = [pictures(PANE, &settings), reference.clone()];
        for layer in PARTS.into_iter().chain(CLASSES) {
            println!("{}: {layer} {}", settings.indirect, means(&pictures, layer));
            assert_blocks_agree(&pictures, layer, SIDE);
        }
    }
}

/// A glossy lobe focuses like a mirror: photons bring what it sends on to surfaces that scatter, over one such lobe and over
/// several, through rough glass as off rough metal; at full roughness more than half of it has met several facets.
#[test]
fn all_three_agree_on_the_caustic_of_rough_glass() {
    for roughness in ["0.15", "0.45", "1"] {
        let rough = format!("type = \"rough_dielectric\"\nroughness = {roughness}");
        let ball = BALL.replace("type = \"dielectric\"", &rough);
        assert!(assert_agree(&ball, &PHOTON_MAP, &PATHS, "caustic") > 0.01);
        assert!(assert_agree(&ball, &PHOTON_MAP, &LIGHT, "caustic") > 0.01);
    }
}

/// Principled glass focuses as glass does, thin glass lets light straight through, and a floor under a coat receives what a
/// matte one does, the coat being one class with it or a mirror beside it.
#[test]
fn photons_and_eye_paths_agree_on_principled_surfaces() {
    let glass = "type = \"principled\"\nbase_colour = [0.9, 0.7, 0.5]\ntransmission = 1";
    for finish in ["roughness = 0", "roughness = 0.4", "roughness = 0.4\nthin = true"] {
        let ball = BALL.replace("type = \"dielectric\"", &format!("{glass}\n{finish}"));
        assert!(assert_agree(&ball, &PHOTON_MAP, &PATHS, "caustic") > 0.01);
    }
    // A coat that is rough over smooth glass sends its part to where the glass does not.
    let coat = format!("{glass}\nroughness = 0\ncoat = 1\ncoat_roughness = 0.4");
    let ball = BALL.replace("type = \"dielectric\"", &coat);
    assert!(assert_agree(&ball, &PHOTON_MAP, &PATHS, "caustic") > 0.01);
    let narrow = ball.replace("[render]", "[render]\nbandwidth = 1");
    assert!(assert_agree(&narrow, &PHOTON_MAP, &LIGHT, "caustic") > 0.01);
    for roughness in ["0.5", "0", "0.5\ncoat = 0.8", "0.5\ncoat = 0.8\ncoat_roughness = 0.3"] {
        let floor = format!("type = \"principled\"\nbase_colour = [0.7, 0.5, 0.3]\nroughness = {roughness}");
        let ball = BALL.replace("type = \"lambert\"\nalbedo = [0.7, 0.5, 0.3]", &floor);
        assert_ne!(ball, BALL);
        let pictures = [&PHOTON_MAP, &PATHS].map(|settings| pictures(&ball, settings));
        for layer in PARTS {
            assert_blocks_agree(&pictures, layer, BLOCK);
        }
    }
}

/// The same light belongs to the same layer with every method, seen past a glossy ball too.
#[test]
fn all_three_share_a_room_with_a_glossy_ball_out() {
    let room = ROOM.replace("HALF", "0.5").replace("roughness = 0.55", "roughness = 0.4");
    let both = [&SHARED, &PATHS].map(|settings| pictures(&room, settings));
    for layer in PARTS.into_iter().chain(CLASSES) {
        assert!(assert_blocks_agree(&both, layer, SIDE) > 0.0);
    }
    // Light paths cannot be connected to what the eye sees over mirrors and through glass.
    let opaque = ["dielectric\"\nior = 1.5", "mirror\"\nreflectance = 0.9"];
    let rough = "rough_conductor\"\npreset = \"silver\"\nroughness = 0.4";
    let room = opaque.iter().fold(room, |room, kind| room.replace(kind, rough));
    let both = [&PATHS, &LIGHT].map(|settings| pictures(&room, settings));
    for layer in PARTS.into_iter().chain(CLASSES) {
        let is_dark = layer == "emission";
        assert!((assert_blocks_agree(&both, layer, SIDE) > 0.0) != is_dark);
    }
}

/// `max_bounces` limits the bounces of the eye and of the photon together. What the eye gathers behind its own one bounce
/// has had none: so often scattered as the photons are here, other light would be some eight hundredths too much.
#[test]
fn photons_and_eye_paths_count_their_bounces_together() {
    let room = ROOM.replace("HALF", "0.5").replace("max_bounces = 8", "max_bounces = 1");
    let reference = pictures(&room, &PATH);
    for settings in [&SHARED, &FINAL_GATHER] {
        let pictures = [pictures(&room, settings), reference.clone()];
        for layer in ["indirect", "scattered"] {
            println!("{}: {layer} {}", settings.indirect, means(&pictures, layer));
            assert_blocks_agree(&pictures, layer, SIDE);
        }
    }
}
