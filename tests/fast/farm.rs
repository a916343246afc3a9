//! The program as farms and impatient people run it: parts, checkpoints, signals, full disks, who listens.

use std::io::Read;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use pdembree::output::exr;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::data::root;

const BALL: &str = "scenes/tests/ball_lens.toml";
/// A second and a half on two cores without optimisation, in many units and passes.
const SLOW: &str = "--passes=12 --spp=6 --photons=20000 -Dcamera.resolution=[96,64] -Dcamera.width=0.6";
const QUICK: &str = "--passes=3 --spp=1 --photons=3000 -Dcamera.resolution=[40,24]";

fn folder() -> TempDir {
    tempfile::tempdir().expect("temporary folder")
}

fn ball() -> String {
    root().join(BALL).to_string_lossy().into_owned()
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pdembree"));
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("PDEMBREE_")) {
        command.env_remove(name);
    }
    command
        .current_dir(folder)
        .args(arguments.iter().flat_map(|words| words.split(' ')).filter(|word| !word.is_empty()));
    command
}

/// Exit code, stdout and stderr; arguments are words between spaces.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = command(folder, arguments).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().unwrap_or(-1), text(output.stdout), text(output.stderr))
}

fn succeed(folder: &Path, arguments: &[&str]) -> (String, String) {
    let (code, out, err) = run(folder, arguments);
    assert_eq!(code, 0, "{arguments:?}: {err}");
    (out, err)
}

fn start(folder: &Path, arguments: &[&str]) -> Child {
    command(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts")
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args(["-s", name, &child.id().to_string()]).status().expect("kill");
    assert!(sent.success(), "signal {name}");
}

/// Exit code and stderr.
fn end(child: Child) -> (Option<i32>, String) {
    let output = child.wait_with_output().expect("it ends");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn wait_for(path: &Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "{} does not appear", path.display());
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("folder");
    let mut names: Vec<_> = entries.map(|e| e.expect("entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn render<'a>(scene: &'a str, settings: &'a str, more: &'a str) -> [&'a str; 5] {
    ["render", scene, settings, "--no-timestamps --progress=none", more]
}

#[test]
fn threads_do_not_change_a_bit() {
    let (folder, scene) = (folder(), ball());
    for method in ["photon_map", "path", "light"] {
        for threads in ["1", "2", "7"] {
            let more = format!("--method={method} -t{threads} -o{threads}.exr");
            succeed(folder.path(), &render(&scene, QUICK, &more));
        }
        let one = bytes(&folder.path().join("1.exr"));
        assert!(["2.exr", "7.exr"].iter().all(|name| bytes(&folder.path().join(name)) == one), "{method}");
    }
}

#[test]
fn parts_are_merged_to_the_file_of_one_machine_and_not_made_twice() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    succeed(here, &render(&scene, QUICK, "-o whole.exr"));
    succeed(here, &render(&scene, QUICK, "-o a.exr --pass-range=0..1"));
    succeed(here, &render(&scene, QUICK, "-o b.pdpart --pass-range=1..3 -t1"));
    let (_, err) = succeed(here, &["merge a.pdpart b.pdpart -o merged.exr --no-timestamps"]);
    assert!(err.contains("2 parts, 3 passes"), "{err}");
    assert_eq!(bytes(&here.join("merged.exr")), bytes(&here.join("whole.exr")));

    let made = |name: &str| here.join(name).metadata().expect("there").modified().expect("a time");
    let before = [made("a.pdpart"), made("b.pdpart"), made("merged.exr")];
    let told = [
        succeed(here, &render(&scene, QUICK, "-o a.exr --pass-range=0..1")).1,
        succeed(here, &render(&scene, QUICK, "-o b.pdpart --pass-range=1..3")).1,
        succeed(here, &["merge b.pdpart a.pdpart -o merged.exr --no-timestamps"]).1,
    ];
    assert!(told.iter().all(|err| err.contains("was there already")), "{told:?}");
    assert_eq!([made("a.pdpart"), made("b.pdpart"), made("merged.exr")], before);

    // What is there is not what is wanted, or is not whole: it is made anew.
    succeed(here, &render(&scene, QUICK, "-o a.exr --pass-range=0..1 --seed=5"));
    assert_ne!(made("a.pdpart"), before[0]);
    let (code, _, err) = run(here, &["merge a.pdpart b.pdpart -o merged.exr"]);
    assert!(code == 65 && err.contains("b.pdpart: belongs to another render than a.pdpart: seed: 0 and 5"), "{err}");
    assert_eq!(bytes(&here.join("merged.exr")), bytes(&here.join("whole.exr")), "the last good file stays");
    let cut = bytes(&here.join("b.pdpart"));
    std::fs::write(here.join("b.pdpart"), &cut[..cut.len() / 2]).expect("a file");
    succeed(here, &render(&scene, QUICK, "-o b.pdpart --pass-range=1..3"));
    let (_, err) = succeed(here, &render(&scene, QUICK, "-o b.pdpart --pass-range=1..3"));
    assert!(err.contains("was there already"), "it is whole again: {err}");
}

#[test]
fn a_tile_is_a_crop_that_knows_its_place() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    succeed(here, &render(&scene, QUICK, "-o whole.exr"));
    for j in 0..3 {
        succeed(here, &render(&scene, QUICK, &format!("-o tile{j}.exr --tile={j}/3")));
    }
    succeed(here, &["merge tile0.pdpart tile1.pdpart tile2.pdpart -o merged.exr --no-timestamps"]);
    assert_eq!(bytes(&here.join("merged.exr")), bytes(&here.join("whole.exr")));
    // OpenImageIO puts data windows where they belong.
    let mut oiiotool = Command::new("oiiotool");
    oiiotool.current_dir(here).args(["tile0.exr", "tile1.exr", "--over", "tile2.exr", "--over", "--fullpixels"]);
    if let Ok(output) = oiiotool.args(["whole.exr", "--diff"]).output() {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    }
    let (code, _, err) = run(here, &render(&scene, QUICK, "-o x.exr --tile=0/999"));
    assert!(code == 2 && err.contains("40 x 24 pixels can be cut into 6 at most"), "{err}");
}

#[test]
fn a_stopped_render_goes_on_to_the_same_file() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    succeed(here, &render(&scene, SLOW, "-o whole.exr"));
    for (name, code) in [("INT", 130), ("TERM", 143)] {
        let arguments = render(&scene, SLOW, "-o out.exr --checkpoint=c.pdpart --every=0.05s --resume");
        let child = start(here, &arguments);
        wait_for(&here.join("c.pdpart"));
        signal(&child, name);
        let (ended, err) = end(child);
        assert_eq!(ended, Some(code), "{name}: {err}");
        assert!(err.contains("--resume goes on with c.pdpart") && !here.join("out.exr").exists(), "{err}");
        let (_, err) = succeed(here, &arguments);
        assert!(err.contains("resume: c.pdpart: "), "{err}");
        assert_eq!(bytes(&here.join("out.exr")), bytes(&here.join("whole.exr")));
        assert!(names(here).iter().all(|name| !name.contains("tmp") && !name.contains("lock")), "{:?}", names(here));
        // More passes of what is finished.
        let more = "-o more.exr --checkpoint=c.pdpart --resume --passes=13";
        let settings = SLOW.replace("--passes=12", "");
        succeed(here, &render(&scene, &settings, more));
        for file in ["c.pdpart", "out.exr", "more.exr"] {
            std::fs::remove_file(here.join(file)).expect("there");
        }
    }
}

#[test]
fn a_second_signal_ends_at_once_and_usr1_shows_the_picture_so_far() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    let arguments = render(&scene, SLOW, "-o out.exr --checkpoint=c.pdpart --every=0.05s");
    let child = start(here, &arguments);
    wait_for(&here.join("c.pdpart"));
    // The first one may come before the first tile.
    loop {
        let snapshot = here.join("out.snapshot.exr");
        signal(&child, "USR1");
        wait_for(&snapshot);
        let image = exr::read_file(&snapshot).expect("a whole picture").image;
        assert_eq!((image.width, image.height), (96, 64));
        std::fs::remove_file(&snapshot).expect("there");
        if image.channel("R").expect("beauty").iter().any(|&v| v > 0.0) {
            break;
        }
    }
    // Stopped by the system it cannot finish its units: the second signal must not wait for them.
    signal(&child, "STOP");
    signal(&child, "INT");
    signal(&child, "TERM");
    signal(&child, "CONT");
    let (ended, err) = end(child);
    assert!(matches!(ended, Some(130 | 143)), "{ended:?}: {err}");
    assert!(!here.join("out.exr").exists());
}

#[test]
fn a_checkpoint_has_one_user_and_is_not_overwritten() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    let first = start(here, &render(&scene, SLOW, "-o a.exr --checkpoint=c.pdpart --every=0.05s"));
    wait_for(&here.join("c.pdpart"));
    let (code, _, err) = run(here, &render(&scene, SLOW, "-o b.exr --checkpoint=c.pdpart --resume"));
    assert!(code == 75 && err.contains(&format!("in use by process {}", first.id())), "{code} {err}");
    signal(&first, "KILL");
    end(first);
    let (code, _, err) = run(here, &render(&scene, SLOW, "-o b.exr --checkpoint=c.pdpart"));
    assert!(code == 73 && err.contains("add --resume"), "{code} {err}");
    let (code, _, err) = run(here, &render(&scene, SLOW, "-o b.exr --checkpoint=c.pdpart --resume --k=7"));
    assert!(code == 65 && err.contains("k: 70 and 7"), "{code} {err}");
    // What the killed process left half-written is swept away.
    std::fs::write(here.join(".c.pdpart.tmp-abc"), "half").expect("a file");
    succeed(here, &render(&scene, SLOW, "-o b.exr --checkpoint=c.pdpart --resume"));
    assert!(names(here).iter().all(|name| !name.contains("tmp")), "{:?}", names(here));
    std::fs::write(here.join("c.pdpart"), "pdembree part 1\nnonsense").expect("a file");
    let (code, _, err) = run(here, &render(&scene, SLOW, "-o c.exr --checkpoint=c.pdpart --resume"));
    assert!(code == 65 && err.contains("damaged"), "{code} {err}");
}

/// Runs the program with files of `blocks` · 1 KiB at most; writing more fails as on a full disk.
fn on_a_full_disk(folder: &Path, kib: u32, arguments: &[&str]) -> (i32, String) {
    let program = command(folder, arguments);
    let mut bash = Command::new("bash");
    bash.current_dir(folder).env("TMPDIR", folder).arg("-c");
    bash.arg(format!("trap '' XFSZ; ulimit -f {kib}; exec \"$0\" \"$@\"")).arg(program.get_program());
    let output = bash.args(program.get_args()).output().expect("bash");
    (output.status.code().unwrap_or(-1), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_full_disk_is_an_error_and_the_last_good_files_stay() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    let arguments = render(&scene, QUICK, "-o out.exr --checkpoint=c.pdpart --resume");
    succeed(here, &arguments);
    let good = [bytes(&here.join("out.exr")), bytes(&here.join("c.pdpart"))];
    let settings = QUICK.replace("--passes=3", "--passes=30");
    let more = render(&scene, &settings, "-o out.exr --checkpoint=c.pdpart --resume --every=0.01s");
    let (code, err) = on_a_full_disk(here, 8, &more);
    assert!(code == 74 && err.contains("writing failed"), "{code} {err}");
    assert_eq!([bytes(&here.join("out.exr")), bytes(&here.join("c.pdpart"))], good);
    assert!(names(here).iter().all(|name| !name.contains("tmp") && !name.contains("rescued")), "{:?}", names(here));
}

#[test]
fn a_folder_that_vanishes_costs_the_place_and_not_the_work() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    succeed(here, &render(&scene, SLOW, "-o whole.exr"));
    std::fs::create_dir(here.join("out")).expect("a folder");
    let mut program = command(here, &render(&scene, SLOW, "-o out/a.exr"));
    let child = program.env("TMPDIR", here).stderr(Stdio::piped()).spawn().expect("the program starts");
    std::thread::sleep(Duration::from_millis(200));
    std::fs::remove_dir_all(here.join("out")).expect("the folder");
    let (ended, err) = end(child);
    assert!(matches!(ended, Some(73 | 74)), "{ended:?} {err}");
    let rescued: Vec<String> = names(here).into_iter().filter(|name| name.contains("rescued")).collect();
    assert!(rescued.len() == 1 && err.contains(&rescued[0]), "{rescued:?} {err}");
    succeed(here, &[&format!("merge {} -o saved.exr --no-timestamps", rescued[0])]);
    assert_eq!(bytes(&here.join("saved.exr")), bytes(&here.join("whole.exr")));
}

#[test]
fn progress_is_told_in_the_dialect_that_was_asked_for() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    let with = |how: &str| {
        let arguments = ["render", &scene, QUICK, "-o out.exr", &format!("--progress={how}")];
        succeed(here, &arguments)
    };
    let (out, err) = with("json");
    let lines: Vec<Value> = err
        .lines()
        .filter(|line| line.starts_with('{'))
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let percents: Vec<f64> = lines.iter().map(|line| line["percent"].as_f64().expect("a number")).collect();
    assert!(out.is_empty() && percents.windows(2).all(|w| w[0] <= w[1]), "{percents:?}");
    assert_eq!(percents.last(), Some(&100.0));
    for key in ["event", "phase", "done", "total", "pass", "passes", "percent", "elapsed_s", "eta_s", "rss_bytes"] {
        assert!(lines.iter().all(|line| line.get(key).is_some()), "{key}");
    }
    for (how, start) in [("alf", "ALF_PROGRESS "), ("openjd", "openjd_")] {
        let (out, _) = with(how);
        assert!(out.lines().count() > 0 && out.lines().all(|line| line.starts_with(start)), "{out}");
        assert!(out.contains("100"), "{out}");
    }
    let (code, out, err) = run(here, &["render missing.toml -o out.exr --progress=openjd"]);
    assert!(code == 66 && out.contains("openjd_fail: ") && err.contains("missing.toml"), "{out} {err}");
    let (out, err) = with("none");
    assert!(out.is_empty() && err.lines().count() == 1, "{err}");
}

#[test]
fn statistics_say_what_happened() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    succeed(here, &render(&scene, QUICK, "-o out.exr --stats=stats.json"));
    let stats: Value = serde_json::from_slice(&bytes(&here.join("stats.json"))).expect("JSON");
    assert_eq!(stats["schema"], 1);
    assert_eq!((&stats["passes"], &stats["first_pass"]), (&Value::from(3), &Value::from(0)));
    assert_eq!(stats["photons_emitted"], 9000);
    assert_eq!(stats["lights"].as_array().map(Vec::len), Some(1));
    assert_eq!(stats["lights"][0]["photons_emitted"], 9000);
    let phases: Vec<&str> =
        stats["phases"].as_array().expect("phases").iter().filter_map(|phase| phase["name"].as_str()).collect();
    assert_eq!(phases, ["scene", "photons", "picture"]);
    assert!(stats["noise"].as_f64().is_some_and(|noise| noise > 0.0));
    for key in ["counters", "refused_samples", "pixels", "peak_memory_bytes", "render_seconds"] {
        assert!(!stats[key].is_null(), "{key} in {stats:#}");
    }
    assert_eq!(stats["scene"]["hash"].as_str().map(str::len), Some(64));
}

#[test]
fn time_error_and_memory_bound_a_render() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    let settings =
        "--spp=1 --photons=3000 -Dcamera.resolution=[40,24] -Dcamera.width=0.6 --progress=none --stats=s.json";
    let stats = || serde_json::from_slice::<Value>(&bytes(&here.join("s.json"))).expect("JSON");
    succeed(here, &["render", &scene, settings, "-o a.exr --target-error=0.2"]);
    let (passes, noise) = (stats()["passes"].as_u64().expect("passes"), stats()["noise"].as_f64().expect("noise"));
    assert!(passes >= 8 && noise <= 0.2, "{passes} passes, {noise}");
    succeed(here, &["render", &scene, settings, &format!("-o b.exr --no-timestamps --passes={passes}")]);
    succeed(here, &["render", &scene, settings, "-o a.exr --no-timestamps --target-error=0.2"]);
    assert_eq!(bytes(&here.join("a.exr")), bytes(&here.join("b.exr")), "the number of passes is all that matters");

    let arguments = ["render", &scene, settings, "-o c.exr --time-limit=0.3s --target-error=1e-9"];
    let (_, err) = succeed(here, &arguments);
    assert!(err.contains("the error of 0.000000001 was not reached"), "{err}");
    let strict: Vec<&str> = arguments.iter().copied().chain(["--strict"]).collect();
    assert_eq!(run(here, &strict).0, 3);

    let (_, err) = succeed(here, &["render", &scene, settings, "-o d.exr --passes=2 --photon-memory=200K"]);
    assert!(err.contains("of 3000 photons are stored in a pass") && err.contains("; split into "), "{err}");
    let split = stats();
    assert!(split["passes"].as_u64() > Some(2), "{split:#}");
    let emitted = split["photons_emitted"].as_u64().expect("a count");
    assert!((6000..6100).contains(&emitted), "{emitted}");
}

/// Whatever the clock says, a microsecond is too short for every pass and an hour for none of these.
#[test]
fn passes_longer_than_the_time_limit_are_made_smaller() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    let settings = "--spp=8 --photons=4000 --passes=1 -Dcamera.resolution=[40,24] -Dcamera.width=0.6 --progress=none";
    let render = |more: &str| {
        let (_, err) = succeed(here, &["render", &scene, settings, "--stats=s.json", more]);
        let stats: Value = serde_json::from_slice(&bytes(&here.join("s.json"))).expect("JSON");
        let emitted = stats["photons_emitted"].as_u64().expect("a count");
        (err, stats["passes"].as_u64().expect("passes"), emitted)
    };
    let (err, passes, emitted) = render("-o short.exr --time-limit=0.000001s");
    assert!(err.contains("; passes with photons = 500 and spp = 1 instead"), "{err}");
    assert!(passes == 1 && (500..600).contains(&emitted), "{passes}, {emitted}");
    for whole in ["-o long.exr --time-limit=1h", "-o saved.exr --time-limit=0.000001s --checkpoint=saved.pdpart"] {
        let (err, passes, emitted) = render(whole);
        assert!(!err.contains("instead"), "{err}");
        assert!(passes == 1 && (4000..4100).contains(&emitted), "{passes}, {emitted}");
    }
}

#[test]
fn a_viewer_gets_the_picture_and_its_absence_does_no_harm() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    let viewer = std::thread::spawn(move || {
        let mut all = Vec::new();
        listener.accept().expect("a client").0.read_to_end(&mut all).expect("bytes");
        all
    });
    succeed(here, &render(&scene, QUICK, &format!("-o out.exr --display-server=127.0.0.1:{port}")));
    let got = viewer.join().expect("the viewer");
    let red = exr::read_file(&here.join("out.exr")).expect("a picture").image;
    let red: Vec<u8> = red.channel("R").expect("beauty")[..40].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert!(
        got.windows(red.len()).any(|window| window == red),
        "the last picture's first row is among {} bytes",
        got.len()
    );
    let (_, err) = succeed(here, &render(&scene, QUICK, "-o out.exr --display-server=127.0.0.1:1"));
    assert!(err.contains("warning: live view"), "{err}");
    assert_eq!(run(here, &render(&scene, QUICK, "-o out.exr --display-server=host:99999")).0, 2);
}

#[test]
fn submit_local_makes_the_file_of_one_process() {
    let (folder, scene) = (folder(), ball());
    let here = folder.path();
    succeed(here, &render(&scene, QUICK, "-o whole.exr"));
    let job = ["submit", &scene, QUICK, "-o out.exr --no-timestamps --engine=local --parts=2 --tiles=2 --jobs=2"];
    succeed(here, &job);
    assert_eq!(bytes(&here.join("out.exr")), bytes(&here.join("whole.exr")));
    let (_, err) = succeed(here, &job);
    assert!(err.contains("5 of 5"), "{err}");
    let (out, _) = succeed(here, &["submit", &scene, QUICK, "-o out.exr --engine=openjd --parts=3"]);
    assert!(out.starts_with("openjd run ") && here.join("out.exr.parts/job.json").exists(), "{out}");
    succeed(here, &["submit", &scene, QUICK, "-o out.exr --engine=slurm --dry-run"]);
    assert!(here.join("out.exr.parts/render.sbatch").exists());
    let (code, _, err) = run(here, &["submit", &scene, QUICK, "-o out.exr --engine=local --parts=4"]);
    assert!(code == 2 && err.contains("ask for 3 parts at most"), "{err}");
}
