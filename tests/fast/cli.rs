//! The program as a user runs it: exit codes, where words go, what is left behind.

use std::path::Path;

use assert_cmd::Command;
use pdembree::film::Image;
use pdembree::output::exr;
use serde_json::Value;
use tempfile::TempDir;

use crate::metric::pictures;

fn pdembree() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pdembree"));
    // What a developer has set must not change what is tested.
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("PDEMBREE_")) {
        command.env_remove(name);
    }
    command
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("temporary folder")
}

/// Exit code, stdout and stderr.
fn run(arguments: &[&str], folder: &Path) -> (i32, String, String) {
    let output = pdembree().args(arguments).current_dir(folder).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("folder");
    let mut names: Vec<_> = entries.map(|e| e.expect("entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

const COMMANDS: [&str; 12] = [
    "render",
    "merge",
    "submit",
    "study",
    "crosscheck",
    "photons",
    "check",
    "compare",
    "convert",
    "info",
    "completions",
    "man",
];

#[test]
fn help_lists_every_command_and_goes_to_stdout() {
    let folder = folder();
    let (code, out, err) = run(&["--help"], folder.path());
    assert_eq!((code, err.as_str()), (0, ""));
    for command in COMMANDS {
        assert!(out.lines().any(|line| line.trim_start().starts_with(command)), "{command} in\n{out}");
        let (code, help, _) = run(&[command, "--help"], folder.path());
        assert!(code == 0 && help.contains("Usage:"), "{command}: {help}");
    }
    assert!(run(&["--version"], folder.path()).1.starts_with("pdembree "));
}

#[test]
fn wrong_usage_is_2_and_says_so_on_stderr() {
    let folder = folder();
    let wrong: [&[&str]; 6] = [
        &[],
        &["no-such-command"],
        &["compare", "a.exr"],
        &["compare", "a.exr", "b.exr", "--fail", "psnr=3"],
        &["compare", "a.exr", "b.exr", "--fail", "rmse=nan"],
        &["completions", "tcsh-of-old"],
    ];
    for arguments in wrong {
        let (code, out, err) = run(arguments, folder.path());
        assert_eq!((code, out.as_str()), (2, ""), "{arguments:?}");
        assert!(!err.is_empty(), "{arguments:?}");
    }
}

#[test]
fn completions_and_man_pages_name_every_command() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish"] {
        let (code, out, _) = run(&["completions", shell], folder.path());
        assert!(code == 0 && COMMANDS.iter().all(|command| out.contains(command)), "{shell}");
    }
    let (code, out, _) = run(&["man"], folder.path());
    assert!(code == 0 && out.starts_with(".ie") && COMMANDS.iter().all(|c| out.contains(c)), "{out}");
    let (code, out, _) = run(&["man", "compare"], folder.path());
    assert!(code == 0 && out.contains("pdembree\\-compare"), "{out}");
    assert_eq!(run(&["man", "nothing"], folder.path()).0, 2);
    assert_eq!(run(&["man", "--all", "."], folder.path()).0, 0);
    let pages = names(folder.path());
    assert!(pages.contains(&"pdembree.1".to_owned()) && pages.contains(&"pdembree-compare.1".to_owned()), "{pages:?}");
    assert_eq!(run(&["man", "--all", "no/folder"], folder.path()).0, 73);
}

/// The harness itself: pictures of known differences through EXR, the program and its JSON.
#[test]
fn compare_prints_the_known_numbers() {
    let folder = folder();
    let (test, reference) = pictures();
    exr::write(&folder.path().join("a.exr"), &test, &[]).expect("written");
    exr::write(&folder.path().join("b.exr"), &reference, &[]).expect("written");
    let (code, out, err) = run(&["compare", "a.exr", "b.exr", "--json"], folder.path());
    assert_eq!((code, err.as_str()), (1, ""), "they differ");
    let json: Value = serde_json::from_str(&out).expect("JSON");
    // Numbers of tests/support/metric_reference.py; a picture goes through a file without loss.
    let known = [("rmse", 0.041074082891479874), ("rel_mse", 0.025835945411106814), ("ssim", 0.9293082273816212)];
    for (name, value) in known {
        assert!((json[name].as_f64().expect(name) - value).abs() < 1e-9, "{name}: {}", json[name]);
    }
    if cfg!(feature = "flip") {
        assert!((json["flip"].as_f64().expect("flip") / 0.08230885118246078 - 1.0).abs() < 2e-4, "{}", json["flip"]);
    }
    let (code, out, _) = run(&["compare", "a.exr", "b.exr"], folder.path());
    assert!(code == 1 && out.contains("rmse            4.107408e-2"), "{out}");
}

#[test]
fn compare_exits_like_cmp_and_holds_bounds() {
    let folder = folder();
    let (test, reference) = pictures();
    for (name, picture) in [("a.exr", &test), ("b.exr", &reference), ("same.exr", &test)] {
        exr::write(&folder.path().join(name), picture, &[]).expect("written");
    }
    let mut bad = test.clone();
    bad.channels[0].samples[7] = f32::NAN;
    exr::write(&folder.path().join("nan.exr"), &bad, &[]).expect("written");
    let small = Image::from_rgb(1, 1, &[[0.0; 3]]);
    exr::write(&folder.path().join("small.exr"), &small, &[]).expect("written");
    let code = |arguments: &[&str]| run(&[&["compare"], arguments].concat(), folder.path()).0;
    assert_eq!(code(&["a.exr", "same.exr"]), 0);
    assert_eq!(code(&["a.exr", "b.exr"]), 1);
    assert_eq!(code(&["a.exr", "b.exr", "--fail", "rmse=0.0411", "--fail", "ssim=0.92"]), 0);
    assert_eq!(code(&["a.exr", "b.exr", "--fail", "rmse=0.0410"]), 1);
    assert_eq!(code(&["a.exr", "b.exr", "--fail", "ssim=0.93"]), 1);
    assert_eq!(code(&["a.exr", "b.exr", "--fail", "bias=0.0001", "--fail", "flip=0.08"]), 1);
    for other in ["none.exr", "nan.exr", "small.exr"] {
        let (code, out, err) = run(&["compare", "a.exr", other], folder.path());
        assert_eq!((code, out.as_str()), (2, ""), "{other}");
        assert!(err.contains(other) && err.lines().count() == 1, "{err}");
    }
    assert_eq!(code(&["a.exr", "b.exr", "--layer", "caustic"]), 2);
}

#[test]
fn info_describes_a_picture() {
    let folder = folder();
    exr::write(&folder.path().join("a.exr"), &pictures().1, &[("seed".to_owned(), "5".to_owned())]).expect("written");
    let (code, out, err) = run(&["info", "a.exr", "--json"], folder.path());
    assert_eq!((code, err.as_str()), (0, ""));
    let json: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!((&json["width"], &json["attributes"]["pdembree/seed"]), (&Value::from(61), &Value::from("5")));
    assert_eq!(json["channels"].as_array().expect("a list").len(), 3);
    assert_eq!(json["channels"][0]["maximum"], 1.0);
    assert!(run(&["info", "a.exr"], folder.path()).1.contains("61 x 43 pixels"));
    assert_eq!(run(&["info", "none.exr"], folder.path()).0, 66);
    std::fs::write(folder.path().join("text.exr"), "no EXR").expect("written");
    assert_eq!(run(&["info", "text.exr"], folder.path()).0, 65);
}

/// A glass ball over a floor, lit by a point.
const SCENE: &str = r#"format = 1
[camera]
type = "perspective"
position = [0, 1, 5]
target = [0, 0.5, 0]
fov_degrees = 40
resolution = [32, 18]
[render]
spp = 1
photons = 2000
[materials.floor]
type = "lambert"
albedo = 0.5
[materials.glass]
type = "dielectric"
ior = 1.5
[[objects]]
shape = "sphere"
centre = [0, 1, 0]
radius = 0.5
material = "glass"
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [2, 0, 0]
b = [0, 0, -2]
material = "floor"
[[lights]]
type = "point"
position = [0, 3, 0]
intensity = 10
"#;

/// A folder with a good scene, scene.toml, and a bad one, bad.toml.
fn scenes() -> TempDir {
    let folder = folder();
    std::fs::write(folder.path().join("scene.toml"), SCENE).expect("written");
    let bad = SCENE.replace("radius = 0.5", "radius = -1").replace("albedo", "albdo");
    std::fs::write(folder.path().join("bad.toml"), bad).expect("written");
    folder
}

#[test]
fn check_reports_all_problems_with_their_places() {
    let folder = scenes();
    let (code, out, err) = run(&["check", "scene.toml"], folder.path());
    assert_eq!((code, err.as_str()), (0, ""));
    assert!(out.starts_with("scene.toml: ok, 2 objects"), "{out}");
    let (code, out, err) = run(&["check", "bad.toml"], folder.path());
    assert_eq!((code, out.as_str()), (65, ""));
    let places: Vec<&str> = err.lines().map(|line| line.split(": error: ").next().expect("a place")).collect();
    assert_eq!(places, ["bad.toml:11:1", "bad.toml:13:1", "bad.toml:20:10"], "{err}");
    let (code, out, err) = run(&["check", "none.toml"], folder.path());
    assert_eq!((code, out.as_str()), (66, ""));
    assert!(err.contains("none.toml"), "{err}");
}

#[test]
fn settings_are_checked_wherever_they_come_from() {
    let folder = scenes();
    let check = |arguments: &[&str]| run(&[&["check", "scene.toml"], arguments].concat(), folder.path());
    let good =
        ["--photons", "2.5M", "--bandwidth", "scale:3", "--kernel", "silverman", "--layers", "N,Z", "--seed", "7"];
    assert_eq!(check(&good).0, 0);
    for usage in [["--photons", "0"], ["--spp", "-3"], ["--kernel", "box"], ["--bandwidth", "0"], ["-D", "spp"]] {
        assert_eq!(check(&usage).0, 2, "{usage:?}");
    }
    let (code, _, err) = check(&["--photons", "1000G"]);
    assert!(code == 65 && err.contains("render.photons=1000000000000") && err.contains("passes"), "{err}");
    let (code, _, err) = check(&["-D", "lights.0.intensity=-1", "-D", "camera.fov=3"]);
    assert!(code == 65 && err.lines().count() == 2, "{err}");
    let mut command = pdembree();
    let from_environment =
        command.args(["check", "scene.toml"]).env("PDEMBREE_KERNEL", "box").current_dir(folder.path());
    assert_eq!(from_environment.output().expect("starts").status.code(), Some(2));
}

#[test]
fn render_writes_a_picture_its_certificate_and_a_png() {
    let folder = scenes();
    let options = ["--png", "b.png", "--layers", "caustic,Z", "--seed", "9", "-t", "1"];
    let (code, out, err) = run(&[&["render", "scene.toml", "-o", "a.exr"], &options[..]].concat(), folder.path());
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    assert!(err.lines().last().expect("a line").starts_with("pdembree: done: a.exr in "), "{err}");
    assert_eq!(names(folder.path()), ["a.exr", "a.exr.json", "b.png", "bad.toml", "scene.toml"]);
    let read = exr::read_file(&folder.path().join("a.exr")).expect("an EXR");
    let names: Vec<&str> = read.image.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["A", "B", "G", "R", "Z", "caustic.B", "caustic.G", "caustic.R"]);
    assert!(read.image.channel("R").expect("R").iter().any(|&v| v > 0.0), "the floor is lit");
    let text = std::fs::read_to_string(folder.path().join("a.exr.json")).expect("a certificate");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((&json["settings"]["seed"], &json["threads"]), (&Value::from(9), &Value::from(1)));
    assert!(json["photons_stored"].as_u64().expect("a count") > 0 && json["photons_emitted"] == 2000);
    assert_eq!(json["scene"]["hash"].as_str().map(str::len), Some(64));
    let phases: Vec<&str> =
        json["phases"].as_array().expect("a list").iter().filter_map(|p| p["name"].as_str()).collect();
    assert_eq!(phases, ["scene", "photons", "picture"]);
}

/// Need 7 of the users: the same seed gives the same file, whatever the thread count.
#[test]
fn equal_renders_are_equal_files_on_any_number_of_threads() {
    let folder = scenes();
    let picture = |method: &str, threads: &str| {
        let arguments =
            ["render", "scene.toml", "-q", "--no-timestamps", "-o", "a.exr", "--passes", "2", "--layers", "direct"];
        let (code, _, err) = run(&[&arguments[..], &["-t", threads, "--method", method]].concat(), folder.path());
        assert_eq!((code, err.as_str()), (0, ""));
        std::fs::read(folder.path().join("a.exr")).expect("a picture")
    };
    for method in ["photon_map", "path", "light"] {
        let one = picture(method, "1");
        for threads in ["2", "7"] {
            assert!(picture(method, threads) == one, "{method} on {threads} threads");
        }
    }
}

#[test]
fn outputs_that_cannot_be_written_are_told_before_the_work() {
    let folder = scenes();
    let render = |output: &str| {
        run(&["render", "scene.toml", "-o", output, "--photons", "900M", "--spp", "9999"], folder.path())
    };
    for (output, expected) in
        [("no/folder/a.exr", 73), ("/proc/a.exr", 73), (".", 2), ("a.jpeg", 2), ("bad.toml/a.exr", 73)]
    {
        let (code, out, err) = render(output);
        assert_eq!((code, out.as_str()), (expected, ""), "{output}: {err}");
        assert!(err.lines().count() == 1 && err.contains(output), "{err}");
    }
    let photons = |output: &str| run(&["photons", "scene.toml", "-o", output], folder.path()).0;
    assert_eq!((photons("map.obj"), photons("no/map.ply")), (2, 73));
    let (code, _, err) = run(&["render", "scene.toml", "-o", "a.exr", "--png", "a.exr"], folder.path());
    assert!(code == 2 && err.contains("--png"), "{err}");
    assert_eq!(names(folder.path()), ["bad.toml", "scene.toml"], "nothing is left");
    assert_eq!(run(&["render", "scene.toml", "-q", "-o", "new/a.exr", "--make-path"], folder.path()).0, 0);
}

#[test]
fn a_bad_scene_leaves_no_output() {
    let folder = scenes();
    assert_eq!(run(&["render", "bad.toml", "-o", "new/a.exr", "--make-path"], folder.path()).0, 65);
    assert_eq!(run(&["render", "none.toml", "-o", "a.exr"], folder.path()).0, 66);
    assert_eq!(names(folder.path()), ["bad.toml", "scene.toml"]);
}

/// A render that is killed at any moment leaves no picture under its name, or the whole one.
#[test]
fn a_killed_render_leaves_no_part() {
    let folder = scenes();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_pdembree"))
        .args(["render", "scene.toml", "-q", "-o", "a.exr", "--spp", "100K"])
        .current_dir(folder.path())
        .spawn()
        .expect("starts");
    std::thread::sleep(std::time::Duration::from_millis(300));
    child.kill().expect("running");
    child.wait().expect("killed");
    assert!(!folder.path().join("a.exr").exists() && !folder.path().join("a.exr.json").exists());
}

#[test]
fn progress_as_json_lines_goes_to_stderr() {
    let folder = scenes();
    let (code, out, err) = run(&["render", "scene.toml", "-o", "a.exr", "--progress", "json", "-q"], folder.path());
    assert_eq!((code, out.as_str()), (0, ""));
    let events: Vec<Value> = err.lines().map(|line| serde_json::from_str(line).expect("a JSON line")).collect();
    assert!(events.len() >= 8, "a start and an end of each phase: {err}");
    let percent: Vec<f64> = events.iter().map(|e| e["percent"].as_f64().expect("percent")).collect();
    assert!(percent.is_sorted() && percent[0] == 0.0 && *percent.last().expect("events") == 100.0, "{percent:?}");
}

#[test]
fn photons_writes_points_and_footprints() {
    let folder = scenes();
    let (code, out, err) =
        run(&["photons", "scene.toml", "-o", "map.ply", "--every", "2", "--segments", "6"], folder.path());
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    let ply = std::fs::read(folder.path().join("map.ply")).expect("a PLY");
    let header = String::from_utf8_lossy(&ply[..200]).into_owned();
    let count = |element: &str| -> usize {
        let rest = header.split(&format!("element {element} ")).nth(1).expect("the element");
        rest.split_whitespace().next().and_then(|n| n.parse().ok()).expect("a count")
    };
    let photons = (count("vertex") / 7, count("vertex") % 7);
    assert!(photons.0 > 0 && photons.1 == 0, "{header}");
    assert!(err.contains(&format!("with {} of ", photons.0)), "{err}");
}

#[test]
fn crosscheck_finds_the_backends_in_agreement() {
    let folder = scenes();
    let arguments = ["crosscheck", "scene.toml", "--rays", "20K", "--backend", "obvhs", "--against", "brute", "-q"];
    let (code, out, err) = run(&[&arguments[..], &["--json"]].concat(), folder.path());
    assert_eq!((code, err.as_str()), (0, ""));
    let json: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!((&json["rays"], &json["not_explained"]), (&Value::from(20_000), &Value::from(0)));
    for kind in ["camera", "shadow", "photon"] {
        assert!(json["report"][kind]["hits"].as_u64().expect("a count") > 100, "{kind}: {out}");
    }
    let (code, again, _) = run(&[&arguments[..], &["--json", "-t", "3"]].concat(), folder.path());
    assert!(code == 0 && again == out, "any number of threads asks the same questions");
    let (code, out, _) = run(&arguments, folder.path());
    assert!(code == 0 && out.contains("20000 rays disagree"), "{out}");
}

/// Every phase is timed, the rays of those that trace are counted and replayed, and photons are those of the render.
#[test]
fn bench_measures_every_phase() {
    let folder = scenes();
    let (code, out, err) = run(&["bench", "scene.toml", "--json", "-t", "2"], folder.path());
    assert_eq!((code, err.as_str()), (0, ""));
    let json: Value = serde_json::from_str(&out).expect("JSON");
    let phases = json["phases"].as_array().expect("phases");
    let names: Vec<&str> = phases.iter().filter_map(|phase| phase["name"].as_str()).collect();
    assert_eq!(names, ["pilots", "photons", "map", "eye paths", "estimate"]);
    for phase in [&phases[1], &phases[3]] {
        assert!(phase["rays"][0].as_u64() > Some(500), "{phase}");
        assert!(phase["bare_seconds"].as_f64() > Some(0.0) && phase["seconds"][1].as_f64() > Some(0.0), "{phase}");
    }
    let other = phases[1]["other_seconds"].as_f64();
    assert!(other.is_none_or(|seconds| seconds > 0.0) && other.is_some() == json["other"].is_string(), "{out}");
    let standard = &json["standard"];
    for seconds in [&standard["photons"][0], &standard["photons"][1], &standard["map"], &standard["estimate"]] {
        assert!(seconds.as_f64().is_some_and(|seconds| seconds >= 0.0), "{standard}");
    }
    assert!(json["kernel_evaluations"].as_u64() > Some(0));
    assert!(json["bytes_per_photon"].as_f64().is_some_and(|bytes| (64.0..96.0).contains(&bytes)), "{out}");
    let rendered =
        run(&["render", "scene.toml", "-o", "x.exr", "--passes", "1", "--stats", "x.json", "-q"], folder.path());
    assert_eq!(rendered.0, 0, "{}", rendered.2);
    let stats = std::fs::read(folder.path().join("x.json")).expect("the stats");
    let stats: Value = serde_json::from_slice(&stats).expect("JSON");
    let stored = |of: &Value| of["photons_stored"].as_u64().expect("a count");
    assert_eq!(stored(&json), stored(&stats) + stored(&stats["bounced_photons"]));
    assert!(run(&["bench", "scene.toml"], folder.path()).1.contains("kernel evaluations"));
}

#[test]
fn info_describes_a_scene_with_the_settings_in_force() {
    let folder = scenes();
    let (code, out, err) = run(&["info", "scene.toml", "--json", "--spp", "5"], folder.path());
    assert_eq!((code, err.as_str()), (0, ""));
    let json: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!((&json["settings"]["spp"], &json["settings"]["photons"]), (&Value::from(5), &Value::from(2000)));
    assert_eq!((&json["objects"], &json["bounds"][1][1]), (&Value::from(2), &Value::from(1.5)));
    assert_eq!(run(&["info", "bad.toml"], folder.path()).0, 65);
    assert!(run(&["info", "scene.toml"], folder.path()).1.contains("estimator: \"pd\""));
}
