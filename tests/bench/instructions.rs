//! Instructions that each phase of a pass takes, counted by callgrind: `.ci/instructions`.
//!
//! The same from run to run, unlike times, so that they can be held against a table: beside the counts of today stand
//! their differences from `instructions.json`, and more than three per cent in any fail. `.ci/instructions --write` renews
//! the table. `cargo bench --bench instructions` counts a release's, which are shown beside the table and not judged.
//!
//! The program runs itself under valgrind, once for each scene and on one thread, and callgrind begins a new file
//! wherever [`a_phase_ends_here`] is called.

#[path = "../support/mod.rs"]
mod support;

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use pdembree::output::exr;
use pdembree::photon::PhotonHarvest;
use pdembree::render::emission;
use pdembree::render::partition::EyeFinds;
use support::data::root;
use support::instructions::{Count, Environment, Row, Table, judge, read_callgrind};
use support::pass::{SCENES, Small, alone};

/// Each ends where callgrind's next file begins; those without a name are not looked at.
const PHASES: [Option<&str>; 10] = [
    None,
    Some("scene"),
    Some("pilots"),
    Some("photons"),
    Some("map"),
    Some("eye paths"),
    Some(ESTIMATE),
    None,
    Some("film"),
    Some("output"),
];
/// The conductor traces eye paths with it: the table has what is more than eye paths alone.
const ESTIMATE: &str = "estimate";

#[inline(never)]
fn a_phase_ends_here() {
    black_box(());
}

/// What valgrind runs. Everything is kept until the end, so that no phase pays for what another one leaves behind.
fn run(scene: &str, folder: &Path) {
    a_phase_ends_here();
    let small = Small::of(scene);
    a_phase_ends_here();
    let plans = emission::plan(&small.world);
    a_phase_ends_here();
    let harvest = small.harvest(&plans);
    a_phase_ends_here();
    let maps = harvest.map(PhotonHarvest::into_map);
    a_phase_ends_here();
    let without = small.expose(EyeFinds::AllButFocused, None);
    a_phase_ends_here();
    let with = small.expose(EyeFinds::AllButFocused, Some(&small.light(&maps)));
    a_phase_ends_here();
    let seen = small.seen();
    a_phase_ends_here();
    let mut film = small.developed(&seen);
    film.add_passes(&film.clone());
    let image = film.resolve();
    a_phase_ends_here();
    exr::write(&folder.join("picture.exr"), &image, &[]).expect("a picture written");
    a_phase_ends_here();
    let vectors = format!("{:?}", pulp::Arch::new());
    println!("{}\n{}", small.world.backend.describe(), vectors.split('(').next().unwrap_or_default());
    drop((without, with));
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["--run", scene, folder] => {
            alone(|| run(scene, folder.as_ref()));
            ExitCode::SUCCESS
        }
        // `cargo bench` says --bench; `cargo test --benches`, which only tries them, does not.
        _ if !arguments.contains(&"--bench") => ExitCode::SUCCESS,
        _ if cfg!(debug_assertions) => fail("counts of a build that is not optimised say nothing: cargo bench"),
        _ => count(arguments.contains(&"--write")).unwrap_or_else(|problem| fail(&problem)),
    }
}

fn fail(problem: &str) -> ExitCode {
    eprintln!("instructions: {problem}");
    ExitCode::FAILURE
}

/// Counts all phases and holds them against the table, or writes it.
fn count(write: bool) -> Result<ExitCode, String> {
    let valgrind = Command::new("valgrind").arg("--version").stdout(Stdio::null()).status();
    valgrind.map_err(|e| format!("valgrind: {e}; apt-get install valgrind"))?;
    let path = root().join("tests/bench/instructions.json");
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for scene in SCENES {
        let folder = tempfile::tempdir().map_err(|e| format!("no folder for callgrind's files: {e}"))?;
        found = under_callgrind(scene, folder.path())?;
        rows.extend(rows_of(scene, folder.path())?);
    }
    let [rays, vectors] = &found[..] else { return Err(format!("the program said {found:?}")) };
    let now = Table { environment: environment(rays, vectors)?, rows };
    let table = std::fs::read_to_string(&path).ok().map(|text| serde_json::from_str::<Table>(&text));
    let verdict = match table {
        Some(Ok(table)) => Some(judge(&table, &now)),
        Some(Err(e)) if !write => return Err(format!("{}: {e}", path.display())),
        None if !write => return Err(format!("{} is not there: -- --write makes it", path.display())),
        _ => None,
    };
    verdict.iter().for_each(|verdict| println!("{}", verdict.text));
    if write {
        if now.environment.build != "debug" {
            return Err("the table is of the build that .ci/instructions makes: .ci/instructions --write".to_owned());
        }
        let text = serde_json::to_string_pretty(&now).map_err(|e| e.to_string())?;
        std::fs::write(&path, text + "\n").map_err(|e| format!("{}: {e}", path.display()))?;
        println!("written: {}", path.display());
        return Ok(ExitCode::SUCCESS);
    }
    Ok(ExitCode::from(u8::from(verdict.is_some_and(|verdict| !verdict.passed))))
}

/// Runs this program with one scene, callgrind's files going to `folder`. Returns the lines that it printed.
fn under_callgrind(scene: &str, folder: &Path) -> Result<Vec<String>, String> {
    let output = Command::new("taskset")
        .args([
            "--cpu-list",
            &processor()?,
            "valgrind",
            "--tool=callgrind",
            "--quiet",
            "--dump-before=*a_phase_ends_here*",
        ])
        .arg(format!("--callgrind-out-file={}", folder.join("phase").display()))
        .arg(program()?)
        .args(["--run", scene])
        .arg(folder)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("taskset: {e}"))?;
    if !output.status.success() {
        return Err(format!("{scene} under valgrind: {}", output.status));
    }
    Ok(String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect())
}

/// The first processor that this program may run on. On one of them Embree builds its trees with one thread, the same every
/// time.
fn processor() -> Result<String, String> {
    let status = std::fs::read_to_string("/proc/self/status").map_err(|e| format!("/proc/self/status: {e}"))?;
    let allowed = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
    let first = allowed.and_then(|list| list.trim().split([',', '-']).next());
    first.map(str::to_owned).ok_or_else(|| "/proc/self/status names no processor".to_owned())
}

fn program() -> Result<PathBuf, String> {
    std::env::current_exe().map_err(|e| format!("where is this program? {e}"))
}

/// What callgrind's files say of the phases.
fn rows_of(scene: &str, folder: &Path) -> Result<Vec<Row>, String> {
    let program = program()?.display().to_string();
    let count = |number: u32| {
        let path = folder.join(format!("phase.{number}"));
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        read_callgrind(&text, &program).map_err(|e| format!("{}: {}", path.display(), e.0))
    };
    let mut rows: Vec<Row> = Vec::new();
    for (number, phase) in (1..).zip(PHASES) {
        let Some(phase) = phase else { continue };
        let mut row = Row { scene: scene.to_owned(), phase: phase.to_owned(), count: count(number)? };
        if phase == ESTIMATE {
            let Count { own, all } = rows.last().map_or(Count::default(), |eye_paths| eye_paths.count);
            row.count = Count { own: row.count.own.saturating_sub(own), all: row.count.all.saturating_sub(all) };
        }
        rows.push(row);
    }
    Ok(rows)
}

fn environment(rays: &str, vectors: &str) -> Result<Environment, String> {
    let rustc = Command::new("rustc").arg("-vV").current_dir(root()).output().map_err(|e| format!("rustc: {e}"))?;
    let said = String::from_utf8_lossy(&rustc.stdout).into_owned();
    let system = std::fs::read_to_string("/etc/os-release").unwrap_or_default();
    let value = |text: &str, key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key));
        line.map_or("unknown".to_owned(), |value| value.trim_matches('"').to_owned())
    };
    let program = program()?;
    let build = program.ancestors().nth(2).and_then(Path::file_name).unwrap_or_default();
    Ok(Environment {
        build: build.to_string_lossy().into_owned(),
        rustc: value(&said, "release: "),
        target: value(&said, "host: "),
        vectors: vectors.to_owned(),
        rays: rays.to_owned(),
        system: format!("{} {}", value(&system, "ID="), value(&system, "VERSION_ID=")),
    })
}
