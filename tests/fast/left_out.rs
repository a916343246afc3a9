//! What an artist leaves out: the caustics that an object casts or receives, the photons of a light. The rest of the picture
//! keeps its bits.

use pdembree::film::Image;
use pdembree::import::{Override, load_text};
use pdembree::render::photon_map::shoot_all;
use pdembree::render::{self, emission, progress::Silent};
use pdembree::scene::LightId;
use pdembree::world::World;

use crate::support::statistics::{Moments, assert_plausible, welch};

/// Two glass balls, one partly in the other's light, over a floor in two halves that meet at x = 0; the camera looks down from
/// under the balls. A small lamp and a point light shine from above.
const BALLS: &str = r#"
format = 1
[camera]
type = "orthographic"
position = [0, 0.3, 0]
target = [0, 0, 0]
up = [0, 0, -1]
width = 3
filter = "box"
resolution = [24, 16]
[render]
spp = 4
photons = 5000
max_bounces = 1
layers = ["caustic", "direct", "indirect"]
[materials.glass]
type = "dielectric"
ior = 1.5
[materials.floor]
type = "lambert"
albedo = 0.6
[materials.black]
type = "lambert"
albedo = 0
[[objects]]
name = "left"
shape = "rectangle"
centre = [-2, 0, 0]
a = [2, 0, 0]
b = [0, 0, -3]
material = "floor"
[[objects]]
name = "right"
shape = "rectangle"
centre = [2, 0, 0]
a = [2, 0, 0]
b = [0, 0, -3]
material = "floor"
[[objects]]
name = "upper"
shape = "sphere"
centre = [-0.3, 1.5, 0]
radius = 0.3
material = "glass"
[[objects]]
name = "lower"
shape = "sphere"
centre = [0.3, 0.8, 0]
radius = 0.3
material = "glass"
[[objects]]
name = "lamp"
shape = "sphere"
centre = [-0.6, 4, 0.2]
radius = 0.1
material = "black"
emission = 300
[[lights]]
type = "point"
position = [0.2, 4, 0]
intensity = 10
"#;

/// The scene with `addition` behind a line of it, and settings of its own.
fn world(line: &str, addition: &str, settings: &[(&str, &str)]) -> World {
    world_of(BALLS, line, addition, settings)
}

fn world_of(scene: &str, line: &str, addition: &str, settings: &[(&str, &str)]) -> World {
    assert!(scene.contains(line));
    let text = if line.is_empty() { scene.to_owned() } else { scene.replace(line, &format!("{line}\n{addition}")) };
    let overrides: Vec<Override> = settings.iter().map(|(key, value)| Override::new(*key, *value)).collect();
    let loaded = load_text("balls.toml".as_ref(), &text, &overrides).unwrap_or_else(|problems| panic!("{problems}"));
    World::new(loaded.scene).expect("a world")
}

/// The same under a lamp that eye paths find.
fn wide(line: &str, addition: &str, settings: &[(&str, &str)]) -> World {
    world_of(&BALLS.replace("radius = 0.1", "radius = 1"), line, addition, settings)
}

fn picture(world: &World) -> Image {
    render::render(world, &Silent).expect("a frame").film.resolve()
}

fn sum(picture: &Image, layer: &str) -> f64 {
    picture.rgb(layer).expect("the layer").iter().flat_map(|channel| channel.iter()).map(|&x| f64::from(x)).sum()
}

fn assert_adds_up(picture: &Image) {
    for channel in 0..3 {
        let layer = |name: &str| picture.rgb(name).expect("a layer")[channel].to_vec();
        let [whole, caustic, direct, indirect] = ["", "caustic", "direct", "indirect"].map(layer);
        for (i, &whole) in whole.iter().enumerate() {
            let sum = caustic[i] + direct[i] + indirect[i];
            assert!((sum - whole).abs() <= 1e-5 * (1.0 + whole), "pixel {i}: {sum}, not {whole}");
        }
    }
}

const LEFT: &str = "name = \"left\"";
const UPPER: &str = "name = \"upper\"";
const LAMP: &str = "emission = 300";
const POINT: &str = "intensity = 10";

/// Its pixels have no caustic; theirs and all others keep every other bit, with photons and with eye paths.
#[test]
fn what_receives_none_shows_none() {
    for method in ["\"photon_map\"", "\"path\""] {
        let settings = [("render.method", method), ("render.spp", "64")];
        let all = picture(&wide("", "", &settings));
        let some = picture(&wide(LEFT, "caustics = { receive = false }", &settings));
        assert_adds_up(&some);
        for layer in ["direct", "indirect"] {
            assert!(some.rgb(layer) == all.rgb(layer), "{layer}");
        }
        let [all, some] = [&all, &some].map(|picture| picture.rgb("caustic").expect("the layer"));
        let mut lit = [false; 2];
        for (i, (&was, &is)) in all[1].iter().zip(some[1]).enumerate() {
            let on_left = i % 24 < 12;
            assert_eq!(is, if on_left { 0.0 } else { was }, "{method}, pixel {i}");
            lit[usize::from(on_left)] |= was > 0.0;
        }
        assert_eq!(lit, [true; 2], "{method}: a caustic on both halves");
    }
}

/// It is to caustics as if it were black, while the eye and shadow rays find the same as before.
#[test]
fn what_casts_none_is_black_to_photons() {
    // With bounces a black surface draws numbers where the other photon has ended, and cells of a lamp's photons go by the
    // footprints of pilots, those on a black ball, too: without both there is the same picture, bit by bit.
    let settings = [("render.max_bounces", "0")];
    let scene = BALLS.replace("emission = 300\n", "");
    let all = picture(&world_of(&scene, "", "", &settings));
    let without = world_of(&scene, UPPER, "caustics = { cast = false }", &settings);
    let map = shoot_all(&without, 0, &Silent);
    assert!(map.counts.not_cast > 0, "{:?}", map.counts);
    let some = picture(&without);
    assert_adds_up(&some);
    let upper = "radius = 0.3\nmaterial = \"";
    let text = scene.replacen(&format!("{upper}glass"), &format!("{upper}black"), 1);
    let black = picture(&world_of(&text, "", "", &settings));
    assert!(some.rgb("caustic") == black.rgb("caustic"));
    assert!(some.rgb("direct") == all.rgb("direct"), "direct");
    assert!(0.0 < sum(&some, "caustic") && sum(&some, "caustic") < 0.9 * sum(&all, "caustic"));
}

/// Eye paths do not bring back what photons leave out.
#[test]
fn eye_paths_leave_out_what_photons_do() {
    let settings = [("render.method", "\"path\""), ("render.spp", "64")];
    let glass = "material = \"glass\"";
    let [all, none] = ["", "caustics = { cast = false }"].map(|addition| picture(&wide(glass, addition, &settings)));
    assert!(sum(&all, "caustic") > 0.0);
    assert_eq!(sum(&none, "caustic"), 0.0);
    assert!(none.rgb("direct") == all.rgb("direct"), "direct");
    let photons = picture(&wide(glass, "caustics = { cast = false }", &[("render.caustics", "\"shared\"")]));
    assert_eq!(sum(&photons, "caustic"), 0.0);
}

/// The caustics of a light without photons are dropped, the others' get all photons, as if it were not there.
#[test]
fn a_light_without_photons_makes_no_caustic() {
    let off = picture(&world(LAMP, "photons = \"off\"", &[]));
    let all = picture(&world("", "", &[]));
    assert_adds_up(&off);
    assert!(off.rgb("direct") == all.rgb("direct"), "direct");
    let alone = BALLS.replace("emission = 300\n", "");
    assert!(off.rgb("caustic") == picture(&world_of(&alone, "", "", &[])).rgb("caustic"));
    let none =
        BALLS.replace(LAMP, "emission = 300\nphotons = \"off\"").replace(POINT, "intensity = 10\nphotons = \"off\"");
    assert_eq!(sum(&picture(&world_of(&none, "", "", &[])), "caustic"), 0.0);
}

/// A light has as many photons as it asks for, the others the rest, and the light that they carry is the same.
#[test]
fn a_light_has_the_photons_that_it_asks_for() {
    let even = [("render.guiding", "\"off\"")];
    let world = world(POINT, "photons = 1234", &even);
    let plans = emission::plan(&world).caustic.plans;
    let points: Vec<(LightId, u64)> = plans.iter().map(|plan| (plan.light, plan.points)).collect();
    assert_eq!(points, [(LightId(0), 1234), (LightId(1), 5000 - 1234)]);
    let carried = |addition: &str| -> Moments {
        let of_seed = |seed: u64| {
            let settings = [("render.seed", seed.to_string()), ("render.emission", "\"random\"".to_owned())];
            let settings: Vec<(&str, &str)> = settings.iter().map(|(key, value)| (*key, value.as_str())).collect();
            let map = shoot_all(&self::world(POINT, addition, &settings), 0, &Silent);
            map.photons.iter().map(|photon| photon.flux().0.luminance()).sum::<f64>()
        };
        (0..16).map(|seed| of_seed(seed + 100 * addition.len() as u64)).collect()
    };
    let [auto, asked] = ["", "photons = 500"].map(carried);
    assert_plausible(welch(&auto, &asked), 1, format!("{auto} W by default, {asked} W"));
}

/// What is left out is told, and changes the scene's hash.
#[test]
fn what_is_left_out_is_told() {
    for (line, addition, words) in [
        (UPPER, "caustics = { cast = false }", "`upper` casts no caustics"),
        (LEFT, "caustics = { receive = false }", "`left` receives no caustics"),
        (LAMP, "photons = \"off\"", "sends no photons"),
    ] {
        let load = |text: &str| load_text("balls.toml".as_ref(), text, &[]).expect("a sound scene");
        let (plain, changed) = (load(BALLS), load(&BALLS.replace(line, &format!("{line}\n{addition}"))));
        let told =
            |warnings: &[pdembree::scene::error::Problem]| warnings.iter().any(|w| w.to_string().contains(words));
        assert!(told(&changed.warnings) && !told(&plain.warnings), "{addition}: {:?}", changed.warnings);
        assert_ne!(plain.scene.contents, changed.scene.contents, "{addition}");
    }
}
