//! Jobs handed to processes of this machine and to a stand-in for Slurm, with a stand-in for the renderer.

use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use pdembree::distribute::slurm::Slurm;
use pdembree::distribute::{Job, SubmitError, local, slurm};

fn stand_in(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/support/farm").join(name)
}

/// A job in a folder whose name is hard to quote.
fn job(folder: &Path, settings: &[&str]) -> Job {
    let folder = folder.join("it's a \"job\" $1");
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join("scene.toml"), "spheres = 1\n").expect("a scene");
    Job {
        program: stand_in("pdembree"),
        scene: folder.join("scene.toml"),
        settings: settings.iter().map(|&setting| setting.to_owned()).collect(),
        merge_settings: vec!["--no-timestamps".to_owned()],
        passes: 8,
        parts: 3,
        tiles: 2,
        output: folder.join("out.exr"),
        folder: folder.join("parts"),
        threads: None,
    }
}

fn run(job: &Job, at_once: usize) -> Result<(), SubmitError> {
    let at_once = NonZeroUsize::new(at_once).expect("above 0");
    local::run(job, at_once, &AtomicBool::new(false), &mut |_, _| ())
}

/// The picture that one process makes.
fn plain_picture(job: &Job) -> String {
    let path = job.output.with_extension("plain.exr");
    let mut command = Command::new(&job.program);
    command.arg("render").arg(&job.scene).args(&job.settings).arg("-o").arg(&path);
    assert!(command.output().expect("the stand-in").status.success());
    fs::read_to_string(path).expect("a picture")
}

#[test]
fn local_tasks_make_the_picture_of_one_process() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = job(folder.path(), &["--seed", "7"]);
    let expected = plain_picture(&job);
    for at_once in [1, 2] {
        let mut heard = Vec::new();
        let at_once = NonZeroUsize::new(at_once).expect("above 0");
        local::run(&job, at_once, &AtomicBool::new(false), &mut |done, of| heard.push((done, of))).expect("a picture");
        assert_eq!(fs::read_to_string(&job.output).expect("a picture"), expected);
        assert_eq!((heard.first(), heard.last()), (Some(&(0, 7)), Some(&(7, 7))));
        fs::remove_file(&job.output).expect("removable");
    }
    let log = fs::read_to_string(job.folder.join("render_5.log")).expect("a log");
    assert!(log.contains("there already"), "{log}");
}

/// The range 2..5 fails; what comes before it stays, what comes after it is not begun, and there is no picture.
#[test]
fn the_first_failure_ends_a_local_job() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut job = job(folder.path(), &["--fail-at", "2"]);
    let error = run(&job, 1).expect_err("fails");
    let SubmitError::TaskFailed { code, log, .. } = &error else { panic!("{error}") };
    assert_eq!((*code, log), (65, &job.folder.join("render_2.log")));
    assert!(error.to_string().starts_with("rendering passes 2..5 of tile 0/2 ended with exit status: 65"), "{error}");
    assert!(fs::read_to_string(log).expect("a log").contains("this range fails"));
    let parts: Vec<_> = job.tasks().iter().map(|task| task.part.exists()).collect();
    assert_eq!(parts, [true, true, false, false, false, false]);
    assert!(!job.output.exists());

    job.settings.clear();
    run(&job, 1).expect("goes on");
    assert_eq!(fs::read_to_string(&job.output).expect("a picture"), plain_picture(&job));
}

/// Tasks that would take an hour, together with one that fails at once: they are asked to end, and tidy up.
#[test]
fn running_tasks_end_with_a_local_job() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = Job { tiles: 1, ..job(folder.path(), &["--pause", "3600", "--fail-at", "5"]) };
    let begin = Instant::now();
    let error = run(&job, 3).expect_err("fails");
    assert!(matches!(error, SubmitError::TaskFailed { code: 65, .. }), "{error}");
    assert!(begin.elapsed() < Duration::from_secs(9), "killed instead of asked to end");
    let left = fs::read_dir(&job.folder).expect("a folder").filter_map(Result::ok);
    let names: Vec<_> = left.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    assert!(names.iter().all(|name| name.ends_with(".log")), "{names:?}");
}

#[test]
fn a_local_job_can_be_stopped() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = job(folder.path(), &[]);
    let error = local::run(&job, NonZeroUsize::MIN, &AtomicBool::new(true), &mut |_, _| ()).expect_err("stopped");
    assert!(matches!(error, SubmitError::Interrupted), "{error}");
    assert!(!job.output.exists());
}

#[test]
fn a_program_that_is_missing_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = Job { program: "/no/pdembree".into(), ..job(folder.path(), &[]) };
    assert!(run(&job, 1).expect_err("fails").to_string().starts_with("/no/pdembree: cannot be started"));
    let slurm = Slurm { sbatch: "no-such-sbatch".into(), ..Slurm::default() };
    let message = slurm.submit(&job).expect_err("fails").to_string();
    let expected = "no-such-sbatch: no such program; install Slurm (on Debian slurm-client) or add its folder to PATH";
    assert_eq!(message, expected);
}

fn asked(job: &Job, script: &str) -> Vec<String> {
    let text = fs::read_to_string(job.folder.join(format!("{script}.asked"))).expect("was asked");
    text.lines().map(str::to_owned).collect()
}

#[test]
fn slurm_gets_the_renders_and_a_merge_after_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = job(folder.path(), &[]);
    let slurm = Slurm { sbatch: stand_in("sbatch"), options: vec!["--partition=long".to_owned()] };
    let queued = slurm.submit(&job).expect("queued");
    assert_eq!((queued.render.as_str(), queued.merge.as_str()), ("17", "18"));
    let here = job.folder.to_string_lossy();
    assert_eq!(asked(&job, slurm::RENDER_SCRIPT), [&here, "--parsable", "--partition=long", "render.sbatch"]);
    let merge = ["--dependency=afterok:17", "--kill-on-invalid-dep=yes", "--clusters=north", "merge.sbatch"];
    let expected = [&[here.as_ref(), "--parsable", "--partition=long"], &merge[..]].concat();
    assert_eq!(asked(&job, slurm::MERGE_SCRIPT), expected);
}

#[test]
fn what_slurm_refuses_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = job(folder.path(), &[]);
    let slurm = Slurm { sbatch: stand_in("sbatch"), ..Slurm::default() };
    let refusal = |script: &str| {
        fs::create_dir_all(&job.folder).expect("a folder");
        fs::write(job.folder.join("refuse"), script).expect("a file");
        slurm.submit(&job).expect_err("refused").to_string()
    };
    let reason = "sbatch: error: invalid partition specified: nowhere";
    assert_eq!(refusal("render.sbatch"), format!("sbatch refused render.sbatch: {reason}"));
    let merge = refusal("merge.sbatch");
    assert!(merge.contains(&format!("job 17, but nothing that merges them: sbatch refused merge.sbatch: {reason}")));
    assert!(merge.contains("`scancel 17`"), "{merge}");
}
