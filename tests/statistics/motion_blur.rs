//! Blurred caustics: no light is lost or gained, and many instants make the same picture.

use pdembree::film::Image;
use pdembree::import::{Override, load_text};
use pdembree::render::{self, progress::Silent};
use pdembree::world::World;

use crate::support::data::root;

/// A glass ball in a wide parallel beam goes 0.4 m over the floor, turns (which changes nothing) and sinks a little. The
/// camera looks under it and sees all of its caustic.
const BALL: &str = r#"
format = 1
[camera]
type = "orthographic"
position = [8, 4, 0]
target = [0, 0, 0]
width = 3
resolution = [48, 48]
shutter = [0, 1]
[render]
spp = 16
photons = 50000
max_bounces = 0
layers = ["caustic"]
[materials.glass]
type = "dielectric"
ior = 1.5
[materials.floor]
type = "lambert"
albedo = 0.5
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [4, 0, 0]
b = [0, 0, -4]
material = "floor"
[[objects]]
shape = "sphere"
centre = [0, 1.2, -0.2]
radius = 0.4
material = "glass"
motion = [
  { time = 0, transform = [] },
  { time = 1, transform = [{ translate = [0.1, -0.1, 0.4] }, { rotate = { axis = [0, 1, 0], degrees = 40 } }] },
]
[[lights]]
type = "directional"
direction = [0, -1, 0]
irradiance = 1
"#;

/// A square beam falls through a wave of glass that goes 0.3 m across its crests, so that all of it always gets through. The
/// camera looks under the wave at all of the caustic. With 16 samples of a pixel the sum of all of them has a standard error of
/// 0.3 %, most of it at the folds.
const WAVE: &str = r#"
format = 1
[camera]
type = "orthographic"
position = [8, 0, 3]
target = [0, 0, -1]
up = [0, 0, 1]
width = 2.4
resolution = [64, 26]
shutter = [0, 1]
[render]
spp = 64
photons = 20000
max_bounces = 0
layers = ["caustic"]
[materials.glass]
type = "dielectric"
ior = 1.5
fresnel = false
[materials.floor]
type = "lambert"
albedo = 0.5
[[objects]]
shape = "rectangle"
centre = [0, 0, -1]
a = [4, 0, 0]
b = [0, 4, 0]
material = "floor"
[[objects]]
shape = "height_field"
centre = [0, 0, 0]
half_size = [0.7, 0.7]
waves = [{ amplitude = 0.03, wave_vector = [15, 4] }]
material = "glass"
motion = [{ time = 0, transform = [{ translate = [-0.15, 0, 0] }] }, { time = 1, transform = [{ translate = [0.15, 0, 0] }] }]
[[lights]]
type = "directional"
direction = [0, 0, -1]
irradiance = 1
extent = { centre = [0, 0, 1], a = [0.4, 0, 0], b = [0, 0.4, 0] }
"#;

/// The sum of all pixels: ρ/π of the beam's 0.64 W over the floor that a pixel sees, 0.0375² m² over the sine of its view.
const WAVE_ENERGY: f64 = 0.5 * std::f64::consts::FRAC_1_PI * 0.64 / (0.0375 * 0.0375 * 2.236_067_977_5);

/// The red channel of the caustic, with settings over the scene's own.
fn caustic(scene: &str, settings: &[(&str, &str)]) -> Vec<f64> {
    let overrides: Vec<Override> = settings.iter().map(|(key, value)| Override::new(*key, *value)).collect();
    let loaded = load_text(&root().join("tests/corpus/valid/blur.toml"), scene, &overrides)
        .unwrap_or_else(|problems| panic!("{problems}"));
    let world = World::new(loaded.scene).expect("a sound world");
    let image: Image = render::render(&world, &Silent).expect("a frame").film.resolve();
    image.rgb("caustic").expect("the layer")[0].iter().map(|&x| f64::from(x)).collect()
}

fn rmse(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

/// Within half a per cent for every kernel, whether the photons' columns make all of the blur or none.
#[test]
fn a_blurred_caustic_has_the_energy_of_a_still_one() {
    for kernel in ["uniform", "cone", "epanechnikov", "biweight", "triweight", "gaussian"] {
        let energy = |shutter, cells| -> f64 {
            caustic(WAVE, &[("camera.shutter", shutter), ("render.time_cells", cells), ("render.kernel", kernel)])
                .iter()
                .sum()
        };
        let still = energy("[0.5, 0.5]", "auto");
        println!("{kernel}, still, of what the beam brings: {:.5}", still / WAVE_ENERGY);
        assert!((still / WAVE_ENERGY - 1.0).abs() < 0.005, "{kernel}: {still}");
        for (cells, over_time) in
            [("1", "variance"), ("4", "variance"), ("16", "variance"), ("1", "swept"), ("4", "swept")]
        {
            let settings = [("render.kernel", kernel), ("render.time_cells", cells), ("render.time_kernel", over_time)];
            let ratio = caustic(WAVE, &settings).iter().sum::<f64>() / still;
            println!("{kernel}, {cells} cells, {over_time}: {ratio:.5}");
            assert!((ratio - 1.0).abs() < 0.005, "{kernel}, {cells} cells, {over_time}: {ratio}");
        }
    }
}

/// The mean of the pictures of many instants is what the photons' time columns make of one.
#[test]
fn time_columns_blur_as_many_instants_do() {
    const INSTANTS: u32 = 24;
    let mut mean = vec![0.0; 48 * 48];
    for i in 0..INSTANTS {
        let time = (f64::from(i) + 0.5) / f64::from(INSTANTS);
        let at = caustic(BALL, &[("camera.shutter", &format!("[{time}, {time}]")), ("render.photons", "20000")]);
        mean.iter_mut().zip(at).for_each(|(sum, x)| *sum += x / f64::from(INSTANTS));
    }
    let scale = rmse(&mean, &vec![0.0; mean.len()]);
    let error = |settings: &[(&str, &str)]| rmse(&caustic(BALL, settings), &mean) / scale;
    let blurred = |photons, cells| error(&[("render.photons", photons), ("render.time_cells", cells)]);
    let still = error(&[("camera.shutter", "[0.5, 0.5]")]);
    let [one, four, many] = ["1", "4", "16"].map(|cells| blurred("20000", cells));
    let [few_four, few_many] = ["4", "32"].map(|cells| blurred("2000", cells));
    println!("still {still:.4}; 20 000 photons: {one:.4} {four:.4} {many:.4}; 2 000: {few_four:.4} {few_many:.4}");
    // The sweep is bent: one straight column for all of it does half of the work, four do it but for noise.
    assert!(one < 0.6 * still && four < 0.3 * still, "{one} and {four} of {still}");
    // Where photons are few, their columns tell more than their times.
    assert!(few_four < 0.7 * few_many && few_four < still, "{few_four}, not {few_many}");
}

/// The ball at rest, and what lights it moves instead.
fn ball_under(light: &str) -> String {
    let still = BALL.split("motion = [").next().expect("the ball").to_owned();
    still + light
}

/// A lamp that goes 0.8 m to the side and a little down, a spot that also turns, a disk that does, and a beam that tilts.
const LAMPS: [(&str, &str); 4] = [
    (
        "point",
        r#"
[[lights]]
type = "point"
position = [0, 4, -0.6]
intensity = 10
motion = [{ time = 0, transform = [] }, { time = 1, transform = [{ translate = [0.1, -0.2, 0.8] }] }]
"#,
    ),
    (
        "spot",
        r#"
[[lights]]
type = "spot"
position = [0, 4, -0.6]
target = [0, 1, -0.2]
angle_degrees = 20
penumbra_degrees = 4
intensity = 10
motion = [
  { time = 0, transform = [] },
  { time = 1, transform = [{ translate = [0.1, -0.2, 0.8] }, { rotate = { axis = [1, 0, 0], degrees = 10 } }] },
]
"#,
    ),
    (
        "disk",
        r#"
[[objects]]
shape = "disk"
centre = [0, 4, -0.6]
normal = [0, -1, 0]
radius = 0.05
material = "floor"
emission = 1000
motion = [
  { time = 0, transform = [] },
  { time = 1, transform = [{ translate = [0.1, -0.2, 0.8] }, { rotate = { axis = [1, 0, 0], degrees = 10 } }] },
]
"#,
    ),
    (
        "beam",
        r#"
[[lights]]
type = "directional"
direction = [0, -1, 0.1]
irradiance = 1
motion = [{ time = 0, transform = [] }, { time = 1, transform = [{ rotate = { axis = [1, 0, 0], degrees = 15 } }] }]
"#,
    ),
];

/// A glass block whose top leans over while the shutter is open.
const BLOCK: &str = r#"
[[objects]]
shape = "mesh"
file = ["cube.obj", "wide_cube.obj"]
times = [0, 1]
material = "glass"
transform = [{ translate = [-0.3, 0.6, 0.4] }, { rotate = { axis = [1, 0, 0.2], degrees = -80 } }, { scale = 0.8 }]
[[lights]]
type = "directional"
direction = [0, -1, 0]
irradiance = 1
"#;

/// The still picture's, the blurred one's and the many cells' differences from the mean of many instants, over the size of
/// that mean; and the energies of the last two over that of the mean.
fn against_instants(scene: &str) -> ([f64; 3], [f64; 2]) {
    const INSTANTS: u32 = 24;
    let mut mean = vec![0.0; 48 * 48];
    for i in 0..INSTANTS {
        let time = (f64::from(i) + 0.5) / f64::from(INSTANTS);
        let at = caustic(scene, &[("camera.shutter", &format!("[{time}, {time}]")), ("render.photons", "20000")]);
        mean.iter_mut().zip(at).for_each(|(sum, x)| *sum += x / f64::from(INSTANTS));
    }
    let scale = rmse(&mean, &vec![0.0; mean.len()]);
    let [still, few, many] = [("[0.5, 0.5]", "1"), ("[0, 1]", "auto"), ("[0, 1]", "64")].map(|(shutter, cells)| {
        caustic(scene, &[("camera.shutter", shutter), ("render.photons", "100000"), ("render.time_cells", cells)])
    });
    let energy = |picture: &[f64]| picture.iter().sum::<f64>() / mean.iter().sum::<f64>();
    let energies = [&few, &many].map(|picture| energy(picture));
    ([still, few, many].map(|picture| rmse(&picture, &mean) / scale), energies)
}

/// Lights that move, and a mesh that changes its shape, blur the caustic as many instants do.
#[test]
fn moving_lights_and_meshes_that_change_blur_as_many_instants_do() {
    let lamps = LAMPS.iter().map(|(name, light)| (*name, ball_under(light)));
    let block = BALL.split("[[objects]]\nshape = \"sphere\"").next().expect("the floor").to_owned() + BLOCK;
    for (name, scene) in lamps.chain([("block", block)]) {
        let ([still, few, many], [of_few, of_many]) = against_instants(&scene);
        println!(
            "{name}: still {still:.4}, {few:.4} by default, 64 cells {many:.4}; energies {of_few:.5}, {of_many:.5}"
        );
        assert!(few < 0.35 * still && few < 0.1, "{name}: {few} of {still}");
        // Of the blurred ones' 100 000 and the instants' 20 000 photons each. The block hides some of the floor that it lights,
        // and where long steps put light is not always in sight.
        let in_few = if name == "block" { 0.03 } else { 0.005 };
        assert!((of_many - 1.0).abs() < 0.005 && (of_few - 1.0).abs() < in_few, "{name}: {of_few}, {of_many}");
    }
}

/// A belt that goes 0.8 m under the ball, which stands still, and with it the caustic; and one that also rises.
const BELTS: [(&str, &str); 2] = [
    ("belt", "motion = [{ time = 0, transform = [] }, { time = 1, transform = [{ translate = [0.1, 0, 0.8] }] }]"),
    (
        "rising belt",
        "motion = [{ time = 0, transform = [] }, { time = 1, transform = [{ translate = [0.1, 0.2, 0.5] }] }]",
    ),
];

/// On what goes through a caustic the light of the eye's own moment is seen, and is not smeared along it.
#[test]
fn a_caustic_on_a_moving_receiver_is_that_of_many_instants() {
    let beam = "[[lights]]\ntype = \"directional\"\ndirection = [0.2, -1, 0.1]\nirradiance = 1\n";
    let (still, _) = BALL.split_once("motion = [").expect("the ball");
    for (name, motion) in BELTS {
        let scene = still.replace("b = [0, 0, -4]", &format!("b = [0, 0, -4]\n{motion}")) + beam;
        let ([still, few, _], energies) = against_instants(&scene);
        println!("{name}: still {still:.4}, moving {few:.4}; energies {energies:.5?}");
        // Where the belt rises towards the ball, its light narrows, too, which one straight way does not say.
        let most = if name == "belt" { 0.01 } else { 0.35 * still };
        assert!(few < most, "{name}: {few} of {still}");
        assert!(energies.iter().all(|energy| (energy - 1.0).abs() < 0.005), "{name}: {energies:?}");
    }
}
