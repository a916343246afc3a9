//! A small study of a mirror's light on a matt floor, and its run from the command line.

use std::path::Path;
use std::process::Command;

use pdembree::study::results::Results;
use tempfile::TempDir;

pub const SCENE: &str = r#"
format = 1
[camera]
type = "orthographic"
position = [0, 1, 0]
target = [0, 0, 0]
up = [0, 0, -1]
width = 1
resolution = [24, 16]
[render]
photons = 2000
spp = 4
max_bounces = 0
layers = ["caustic"]
[materials.white]
type = "lambert"
albedo = 0.5
[materials.mirror]
type = "mirror"
reflectance = 1
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [2, 0, 0]
b = [0, 0, -2]
material = "white"
[[objects]]
shape = "rectangle"
centre = [-0.5, 0.3, 0]
a = [0, 0.3, 0]
b = [0, 0, 0.3]
material = "mirror"
[[lights]]
type = "directional"
direction = [-1, -1, 0]
irradiance = 2
"#;

pub const STUDY: &str = r#"
format = 1
title = "A mirror's light"
about = "A small study."
[[scenes]]
name = "mirror"
file = "mirror.toml"
layer = "caustic"
white = 0.4
[[scenes.reference]]
layer = "caustic"
set = ["render.method=light", "render.photons=4000"]
passes = 4
[[experiments]]
name = "bandwidth"
methods = ["knn", "pd-lattice"]
photons = [500]
seeds = [1, 2]
baseline = { method = "knn" }
crop = [2, 2, 20, 14]
[experiments.bandwidth]
knn = { from = 5, to = 40 }
pd-lattice = [1.5, 4]
[[experiments.published]]
method = "knn"
rmse = 0.07
ssim = 0.8
[[experiments.published]]
method = "pd-lattice"
rmse = 0.05
[[experiments]]
name = "convergence"
methods = ["pd-random", "light"]
photons = [200, 800, 3200]
region = [4, 2, 20, 14]
[experiments.bandwidth]
pd-random = { value = 3, at = 200, exponent = 0.333 }
"#;

/// A folder with both.
pub fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("temporary folder");
    std::fs::write(folder.path().join("mirror.toml"), SCENE).expect("scene");
    std::fs::write(folder.path().join("study.toml"), STUDY).expect("study");
    folder
}

/// Runs the study of `folder` into `report` there: exit code and what went to stderr.
pub fn run(folder: &Path) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pdembree"));
    let arguments = ["study", "study.toml", "-o", "report", "--progress", "none", "-t", "2"];
    let output = command.args(arguments).current_dir(folder).output().expect("the program starts");
    (output.status.code().expect("no signal"), String::from_utf8_lossy(&output.stderr).into_owned())
}

pub fn results(folder: &Path) -> Results {
    let text = std::fs::read_to_string(folder.join("report/results.json")).expect("results");
    serde_json::from_str(&text).expect("results as they are defined")
}
