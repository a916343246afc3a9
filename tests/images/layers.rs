//! Layers of a picture: shares of groups of lights add up, mattes say what is in a pixel, other programs read all of it.

use std::path::Path;
use std::process::Command;

use pdembree::film::{Image, matte};
use pdembree::import::{Override, load_text};
use pdembree::output::{ChannelNames, cryptomatte, exr};
use pdembree::render::progress::Silent;
use pdembree::render::{RenderState, render, store};
use pdembree::world::World;

/// Glass and a mirror over a floor, lit by a lamp, a lamp that is a disc, and a sky.
const SCENE: &str = r#"
format = 1
[camera]
type = "perspective"
position = [0, 1.2, 3]
target = [0, 0.2, 0]
fov_degrees = 40
resolution = [48, 36]
[render]
spp = 8
photons = 20000
passes = 2
[materials.floor]
type = "lambert"
albedo = [0.7, 0.6, 0.5]
[materials.glass]
type = "dielectric"
ior = 1.5
[materials.mirror]
type = "mirror"
reflectance = 0.9
[[objects]]
name = "floor"
shape = "rectangle"
centre = [0, 0, 0]
a = [3, 0, 0]
b = [0, 0, -3]
material = "floor"
[[objects]]
name = "ball"
shape = "sphere"
centre = [-0.3, 0.35, 0]
radius = 0.3
material = "glass"
[[objects]]
name = "Spiegel für 水"
shape = "cylinder"
base = [0.6, 0, 0]
top = [0.6, 0.5, 0]
radius = 0.25
material = "mirror"
[[objects]]
name = "disc"
shape = "disk"
centre = [0, 2.5, 0]
normal = [0, -1, 0]
radius = 0.2
material = "floor"
emission = 20
group = "top"
[[lights]]
type = "point"
position = [-1.5, 2, 0.5]
intensity = [6, 3, 2]
group = "warm"
[[lights]]
type = "point"
position = [1.5, 2, 0.5]
intensity = [1, 2, 4]
"#;

fn rendered(settings: &[(&str, &str)]) -> RenderState {
    let overrides: Vec<Override> = settings.iter().map(|(key, value)| Override::new(*key, *value)).collect();
    let loaded = load_text(Path::new("s.toml"), SCENE, &overrides).unwrap_or_else(|all| panic!("{all}"));
    render(&World::new(loaded.scene).expect("a world"), &Silent).expect("a picture")
}

/// Whether the sum of `layers` is `whole` in every pixel and colour, to 10⁻⁵ of it.
fn assert_sum(image: &Image, whole: &str, layers: &[&str]) {
    let layer = |name: &str| image.rgb(name).unwrap_or_else(|| panic!("no layer {name:?}"));
    let whole = layer(whole);
    let layers: Vec<_> = layers.iter().map(|name| layer(name)).collect();
    for c in 0..3 {
        for (p, &all) in whole[c].iter().enumerate() {
            let sum: f64 = layers.iter().map(|layer| f64::from(layer[c][p])).sum();
            assert!((sum - f64::from(all)).abs() <= 1e-5 * f64::from(all), "pixel {p}: {sum}, not {all}");
        }
    }
}

/// In every method and with every estimator, with light that photons find behind a bounce and without; each light's layers
/// have its light and not the others'.
#[test]
fn the_shares_of_groups_add_up_to_each_layer_and_these_to_the_beauty() {
    let layers = r#"["direct", "caustic", "indirect", "emission", "straight", "focused", "sent_back", "scattered", "direct_*", "caustic_*", "indirect_*"]"#;
    for (method, estimator, indirect) in [
        ("photon_map", "pd", "path"),
        ("photon_map", "pd", "final_gather"),
        ("photon_map", "sppm", "global"),
        ("photon_map", "knn", "path"),
        ("path", "pd", "path"),
        ("light", "pd", "path"),
    ] {
        let settings = [("render.method", method), ("render.estimator", estimator), ("render.indirect", indirect)];
        let image = rendered(&[&settings[..], &[("render.layers", layers)]].concat()).film.resolve();
        assert_sum(&image, "", &["direct", "caustic", "indirect"]);
        assert_sum(&image, "", &["emission", "straight", "focused", "sent_back", "scattered"]);
        for part in ["direct", "caustic", "indirect"] {
            let of_groups = ["default", "top", "warm"].map(|group| format!("{part}_{group}"));
            assert_sum(&image, part, &of_groups.each_ref().map(String::as_str));
            // What a point sends through glass no eye path finds.
            for name in of_groups.iter().filter(|_| (method, part) != ("path", "caustic")) {
                let sums = image.rgb(name).expect("the layer").map(|c| c.iter().map(|v| f64::from(*v)).sum::<f64>());
                assert!(sums.iter().all(|sum| *sum > 0.0), "{method} {estimator}: {name}: {sums:?}");
            }
        }
    }
}

/// Without bounces all light has come over grey glass and grey mirrors to a floor of one colour: the colour of a group's layers
/// is that of its light times the floor's, in every pixel.
#[test]
fn a_groups_layers_have_the_colour_of_its_lights() {
    for (method, estimator) in [("photon_map", "pd"), ("photon_map", "knn"), ("path", "pd"), ("light", "pd")] {
        let settings = [
            ("render.method", method),
            ("render.estimator", estimator),
            ("render.max_bounces", "0"),
            ("render.layers", r#"["direct_*", "caustic_*"]"#),
        ];
        let image = rendered(&settings).film.resolve();
        for (group, light) in [("warm", [6.0, 3.0, 2.0]), ("default", [1.0, 2.0, 4.0])] {
            for part in ["direct", "caustic"] {
                let rgb = image.rgb(&format!("{part}_{group}")).expect("the layer");
                let expected = [0.7 * light[0], 0.6 * light[1], 0.5 * light[2]];
                for p in 0..image.pixels() {
                    let seen = rgb.map(|c| f64::from(c[p]));
                    let scale = seen[0] / expected[0];
                    let off = (0..3).map(|c| (seen[c] - scale * expected[c]).abs()).fold(0.0, f64::max);
                    assert!(
                        off <= 1e-5 * seen[0].max(seen[2]),
                        "{method} {estimator} {part}_{group}, pixel {p}: {seen:?}"
                    );
                }
            }
        }
    }
}

/// Shares of a pixel's samples, and ids that are those of the names.
#[test]
fn mattes_name_what_is_in_a_pixel() {
    let state = rendered(&[("render.layers", r#"["crypto_object", "crypto_material", "P", "Z", "N"]"#)]);
    let image = state.film.resolve();
    let channel = |name: &str| image.channel(name).unwrap_or_else(|| panic!("no channel {name}"));
    let pairs = |layer: &str, p: usize| {
        let names = [
            ["00.R", "00.G"],
            ["00.B", "00.A"],
            ["01.R", "01.G"],
            ["01.B", "01.A"],
            ["02.R", "02.G"],
            ["02.B", "02.A"],
        ];
        names.map(|pair| pair.map(|c| channel(&format!("{layer}{c}"))[p]))
    };
    let alpha = channel("A");
    let mut edges = 0;
    for (p, &alpha) in alpha.iter().enumerate() {
        for layer in ["CryptoObject", "CryptoMaterial"] {
            let pairs = pairs(layer, p);
            let sum: f32 = pairs.iter().map(|[_, share]| share).sum();
            assert!((sum - alpha).abs() < 1e-6, "pixel {p} of {layer}: {sum}, not {alpha}");
            assert!(pairs.windows(2).all(|w| w[0][1] >= w[1][1]), "pixel {p}: {pairs:?}");
            edges += usize::from(pairs[1][1] > 0.0);
        }
    }
    assert!(edges > 20, "{edges} pixels with two things");
    // The ball's middle, and the place of its front there.
    let p = centre_of(&image, [-0.3, 0.35, 0.0]);
    assert_eq!(pairs("CryptoObject", p)[0], [f32::from_bits(matte::id("ball")), 1.0]);
    assert_eq!(pairs("CryptoMaterial", p)[0], [f32::from_bits(matte::id("glass")), 1.0]);
    let at = ["P.X", "P.Y", "P.Z"].map(|c| f64::from(channel(c)[p]));
    let distance = at.iter().zip([-0.3, 0.35, 0.0]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    // The mean over a pixel of points of a sphere lies a little within: the pixel's width, 0.05 m, squared over 4 radii.
    assert!((distance - 0.3).abs() < 0.003, "{at:?}: {distance}");
}

/// The pixel that sees a point; the scene's camera is 40 degrees wide.
fn centre_of(image: &Image, point: [f64; 3]) -> usize {
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let eye = [0.0, 1.2, 3.0];
    let length = (1.0f64 + 9.0).sqrt();
    let (forward, up) = ([0.0, -1.0 / length, -3.0 / length], [0.0, 3.0 / length, -1.0 / length]);
    let d = sub(point, eye);
    let scale = f64::from(image.width) / 2.0 / 20f64.to_radians().tan();
    let x = f64::from(image.width) / 2.0 + scale * d[0] / dot(d, forward);
    let y = f64::from(image.height) / 2.0 - scale * dot(d, up) / dot(d, forward);
    y as usize * image.width as usize + x as usize
}

/// A pass stopped, saved and read again keeps its groups and mattes.
#[test]
fn parts_keep_groups_and_mattes() {
    let layers = ("render.layers", r#"["caustic_warm", "crypto_object"]"#);
    let state = rendered(&[layers, ("camera.resolution", "[24, 18]")]);
    let overrides = [Override::new(layers.0, layers.1), Override::new("camera.resolution", "[24, 18]")];
    let loaded = load_text(Path::new("s.toml"), SCENE, &overrides).unwrap_or_else(|all| panic!("{all}"));
    let world = World::new(loaded.scene).expect("a world");
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.pdpart");
    store::save(&path, &store::identify(&world, "s.toml".as_ref(), 2), &state).expect("saved");
    let merged = store::merge(&[path], false).expect("the whole");
    assert_eq!(merged.state.film, state.film);
    assert_eq!(merged.state.film.resolve(), state.film.resolve());
}

/// OpenImageIO's Python package reads the names, the ids' bits and the manifest. Skipped where it is not installed
/// (`pip install OpenImageIO`); with `PDEMBREE_REQUIRE_OIIO=1` that is a failure only for the tools.
#[test]
fn the_python_package_of_openimageio_reads_mattes_by_their_names() {
    let state = rendered(&[("render.layers", r#"["crypto_object", "caustic_warm", "albedo"]"#)]);
    let image = state.film.resolve();
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.exr");
    let window = exr::Window { origin: [0, 0], whole: [image.width, image.height] };
    let mattes = cryptomatte::attributes(state.film.layout(), ChannelNames::Own);
    exr::write_named(&path, &image, window, &[], (ChannelNames::Own, &mattes)).expect("written");
    let script = include_str!("../support/read_mattes.py");
    let output = Command::new("python3").args(["-c", script]).arg(&path).output();
    let Ok(output) = output else { return eprintln!("skipped: there is no python3") };
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    if told.trim() == "no OpenImageIO" {
        return eprintln!("skipped: the Python package OpenImageIO is not installed");
    }
    assert!(output.status.success(), "{told}{}", String::from_utf8_lossy(&output.stderr));
    let seen: std::collections::BTreeMap<String, f64> = serde_json::from_str(&told).expect("JSON");
    let names: Vec<&str> = seen.keys().map(String::as_str).collect();
    // The lamp is above the picture.
    assert_eq!(names, ["Spiegel für 水", "ball", "floor"], "{told}");
    let share: f64 = seen.values().sum();
    let alpha: f64 = image.channel("A").expect("A").iter().map(|a| f64::from(*a)).sum();
    assert!((share - alpha).abs() < 1e-3, "{share}, not {alpha}");
}
