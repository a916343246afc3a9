//! Scene files: what is read from them, and what is said about wrong ones.

use std::path::{Path, PathBuf};

use pdembree::import::{Loaded, Override, load_text};
use pdembree::scene::error::Problems;
use pdembree::scene::settings::{Bandwidth, Estimator, KernelShape, Layer, Method};
use pdembree::scene::{CameraModel, LightSource, Material, ObjectGeometry};

use crate::support::data::root;

/// The least scene: a glass ball over a floor under a lamp.
const BALL: &str = r#"format = 1

[camera]
type = "perspective"
position = [0, 1, 5]
target = [0, 0, 0]
fov_degrees = 40
resolution = [64, 36]

[materials.floor]
type = "lambert"
albedo = 0.5
[materials.glass]
type = "dielectric"
ior = 1.5

[[objects]]
name = "ball"
shape = "sphere"
centre = [0, 1, 0]
radius = 0.5
material = "glass"

[[objects]]
name = "floor"
shape = "rectangle"
centre = [0, 0, 0]
a = [0, 0, 5]
b = [5, 0, 0]
material = "floor"

[[lights]]
type = "point"
position = [0, 3, 0]
intensity = [1, 2, 3]
"#;

fn load(text: &str, overrides: &[&str]) -> Result<Loaded, Problems> {
    let overrides: Vec<Override> = overrides.iter().map(|o| o.parse().expect("key=value")).collect();
    load_text(Path::new("ball.toml"), text, &overrides)
}

fn messages(text: &str, overrides: &[&str]) -> Vec<String> {
    load(text, overrides).expect_err("the scene is wrong").iter().map(ToString::to_string).collect()
}

#[test]
fn the_least_scene_becomes_what_it_says() {
    let Loaded { scene, warnings } = load(BALL, &[]).expect("a sound scene");
    assert_eq!(warnings, []);
    assert_eq!(scene.objects.len(), 2);
    assert_eq!(scene.objects[0].name, "ball");
    assert!(matches!(scene.objects[0].geometry, ObjectGeometry::Shape { .. }));
    let glass = &scene.materials[scene.objects[0].material.index()];
    assert_eq!(*glass, Material::Dielectric { ior: 1.5, exterior: 1.0, fresnel: true });
    let [LightSource::Point { position, intensity }] = scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!((position.to_array(), intensity.to_array()), ([0.0, 3.0, 0.0], [1.0, 2.0, 3.0]));
    let CameraModel::Perspective { fov_x } = scene.camera.model else { panic!("{:?}", scene.camera) };
    assert_eq!(fov_x, 40.0_f64.to_radians());
    assert_eq!(scene.bounds.min.to_array(), [-5.0, 0.0, -5.0]);
    assert_eq!(scene.bounds.max.to_array(), [5.0, 1.5, 5.0]);
    assert_eq!(scene.hash.len(), 64);
}

#[test]
fn overrides_win_over_the_file_and_fill_missing_tables() {
    let overrides = [
        "render.photons=1000",
        "render.estimator=knn",
        "render.kernel=silverman",
        "render.bandwidth=1.5",
        "render.layers=[\"N\", \"caustic\"]",
        "render.method = path",
        "materials.glass.ior=1.7",
        "lights.0.intensity=[4, 5, 6]",
        "render.photons=2000",
    ];
    let scene = load(BALL, &overrides).expect("a sound scene").scene;
    assert_eq!(scene.settings.photons, 2000);
    assert_eq!(scene.settings.estimator, Estimator::NearestNeighbours);
    assert_eq!(scene.settings.kernel, KernelShape::Biweight);
    assert_eq!(scene.settings.bandwidth, Bandwidth::Scale(1.5));
    assert_eq!(scene.settings.layers, [Layer::Normal, Layer::Caustic]);
    assert_eq!(scene.settings.method, Method::Path);
    assert!(scene.materials.contains(&Material::Dielectric { ior: 1.7, exterior: 1.0, fresnel: true }));
    let [LightSource::Point { intensity, .. }] = scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!(intensity.to_array(), [4.0, 5.0, 6.0]);
}

#[test]
fn wrong_overrides_name_the_option() {
    let wrong = |option| messages(BALL, &[option]).join("\n");
    assert_eq!(
        wrong("render.photns=1"),
        "-D render.photns=1: unknown key `photns` in `render` (did you mean `photons`?)"
    );
    assert!(wrong("render.photons=0").starts_with("-D render.photons=0: `photons` must be an integer from 1 to"));
    assert!(wrong("lights.7.intensity=1").contains("`lights` has no element `7` (it has 1, counted from 0)"));
    assert!(wrong("a b=1").starts_with("-D a b=1: override `-D a b=1` cannot be read"));
    assert!("photons".parse::<Override>().is_err());
    assert!("=3".parse::<Override>().is_err());
}

#[test]
fn all_problems_are_reported_at_once_with_their_places() {
    let text = BALL
        .replace("ior = 1.5", "ior = -1.5")
        .replace("albedo = 0.5", "albedoo = 0.5")
        .replace("radius = 0.5", "radius = \"wide\"")
        .replace("material = \"floor\"", "material = \"flor\"")
        .replace("type = \"point\"", "type = \"lamp\"")
        .replace("target = [0, 0, 0]", "target = [0, 1, 5]");
    let found = messages(&text, &[]);
    let expected = [
        "ball.toml:3:1: the camera's position and target are the same point (move one of them)",
        "ball.toml:10:1: material `floor` needs the key `albedo` (give a number or [r, g, b], each a finite number from 0 to 1, or { image = \"file\" })",
        "ball.toml:12:1: unknown key `albedoo` in material `floor` (did you mean `albedo`?)",
        "ball.toml:15:7: `ior` must be a finite number > 0, got -1.5",
        "ball.toml:21:10: `radius` must be a finite number > 0, got the text \"wide\"",
        "ball.toml:30:12: there is no material `flor` (did you mean `floor`?)",
        "ball.toml:33:8: `type` must be one of \"point\", \"spot\", \"directional\", \"environment\", got \"lamp\"",
    ];
    assert_eq!(found, expected);
}

#[test]
fn the_hash_follows_content_and_not_names() {
    let hash = |text: &str| load(text, &[]).expect("a sound scene").scene.hash;
    let original = hash(BALL);
    assert_eq!(original, hash(&BALL.replace("glass", "crystal").replace("\"ball\"", "\"sphere\"")));
    assert_eq!(original, hash(&format!("# a comment\n{BALL}")));
    for (from, to) in [("ior = 1.5", "ior = 1.51"), ("radius = 0.5", "radius = 0.6"), ("[1, 2, 3]", "[1, 2, 4]")] {
        assert_ne!(original, hash(&BALL.replace(from, to)), "{to}");
    }
    let seeded = load(BALL, &["render.seed=7"]).expect("a sound scene").scene.hash;
    assert_ne!(original, seeded);
}

#[test]
fn transforms_are_applied_last_to_first() {
    let text = BALL.replace(
        "radius = 0.5\n",
        "radius = 0.5\ntransform = [{ translate = [0, 0, 10] }, { rotate = { axis = [0, 0, 1], degrees = 90 } }, \
         { scale = 2 }]\n",
    );
    let scene = load(&text, &[]).expect("a sound scene").scene;
    let ObjectGeometry::Shape { to_world, .. } = &scene.objects[0].geometry else { panic!("a shape") };
    let p = to_world.point(pdembree::math::Point3::new(1.0, 0.0, 0.0));
    assert!(p.distance(pdembree::math::Point3::new(0.0, 2.0, 10.0)) < 1e-15, "{p:?}");
}

/// Scene files below a folder.
/// Studies lie beside the scenes that they are about.
fn is_study(path: &Path) -> bool {
    path.file_stem().is_some_and(|stem| stem.to_string_lossy().ends_with("study"))
}

fn scene_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            scene_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "toml") && !is_study(&path) {
            found.push(path);
        }
    }
}

#[test]
fn the_projects_own_scenes_load_without_a_warning() {
    let mut files = Vec::new();
    scene_files(&root().join("scenes"), &mut files);
    files.sort();
    assert!(!files.is_empty());
    let complaints = files.iter().flat_map(|path| match pdembree::import::load(path, &[]) {
        Ok(loaded) => loaded.warnings,
        Err(problems) => problems.0,
    });
    // Closed-form scenes of direct light have no caustic on purpose.
    let meant =
        |complaint: &String| complaint.contains("scenes/tests/") && complaint.contains("there can be no caustic");
    let complaints: Vec<String> = complaints.map(|p| p.to_string()).filter(|c| !meant(c)).collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn the_hash_covers_the_contents_of_meshes_and_images() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let scene = |file: &str| {
        let object = format!("[[objects]]\nshape = \"mesh\"\nfile = \"{file}\"\nmaterial = \"floor\"\n\n[[lights]]");
        let text = BALL.replace("[[lights]]", &object);
        load_text(&folder.path().join("s.toml"), &text, &[]).unwrap_or_else(|p| panic!("{p}")).scene.hash
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    write("a.obj", triangle);
    write("b.obj", &format!("# the same elsewhere\n{triangle}"));
    write("c.obj", &triangle.replace("v 1 0 0", "v 1.001 0 0"));
    assert_eq!(scene("a.obj"), scene("b.obj"));
    assert_ne!(scene("a.obj"), scene("c.obj"));

    let textured = |grey: u8| {
        let image = image::RgbImage::from_pixel(2, 2, image::Rgb([grey; 3]));
        image.save(folder.path().join("t.png")).expect("written");
        let text = BALL.replace("albedo = 0.5", "albedo = { image = \"t.png\" }");
        load_text(&folder.path().join("s.toml"), &text, &[]).unwrap_or_else(|p| panic!("{p}")).scene.hash
    };
    assert_eq!(textured(100), textured(100));
    assert_ne!(textured(100), textured(101));
}

#[test]
fn the_hash_tells_which_instances_share_what() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
    let hash = |files: &[&str]| {
        let object = |(i, file): (usize, &&str)| {
            format!(
                "[[objects]]\nshape = \"mesh\"\nfile = \"{file}\"\nmaterial = \"floor\"\n\
                 transform = [{{ translate = [{i}, 0, 0] }}]\n\n"
            )
        };
        let objects: String = files.iter().enumerate().map(object).collect();
        let text = BALL.replace("[[lights]]", &format!("{objects}[[lights]]"));
        load_text(&folder.path().join("s.toml"), &text, &[]).unwrap_or_else(|p| panic!("{p}")).scene.hash
    };
    let scenes: [&[&str]; 5] = [
        &["a.obj", "b.obj", "a.obj"],
        &["a.obj", "b.obj", "b.obj"],
        &["a.obj", "a.obj", "b.obj"],
        &["b.obj", "a.obj", "b.obj"],
        &["a.obj", "a.obj", "a.obj"],
    ];
    let hashes: std::collections::HashSet<String> = scenes.iter().map(|files| hash(files)).collect();
    assert_eq!(hashes.len(), scenes.len());
}
