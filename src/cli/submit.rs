//! `pdembree submit SCENE -o out.exr --engine slurm`

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use pdembree::distribute::slurm::{self, Slurm};
use pdembree::distribute::{Job, SubmitError, command_line, local, openjd};

use super::console::{Verbosity, note, print};
use super::failure::{Failure, code};
use super::number::small_count;
use super::outputs::{OutputArgs, Outputs};
use super::scene::SceneArgs;
use super::signals::Signals;

/// Hand a render to a farm: many renders of some passes each, and a merge when all are done
///
/// The picture is the one that `pdembree render` makes of the same scene and settings, bit for bit. A job that broke off
/// is submitted again as it was: parts that are there are not rendered again.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    output: OutputArgs,
    /// Who does the work
    #[arg(long, value_enum)]
    engine: Engine,
    /// Ranges that the passes are split into [default: one for each pass, 64 at most]
    #[arg(long, value_name = "N", value_parser = small_count)]
    parts: Option<u32>,
    /// Tiles that each range is split into
    #[arg(long, value_name = "M", default_value = "1", value_parser = small_count)]
    tiles: u32,
    /// Folder of the parts, logs and job files, seen by all machines [default: OUTPUT.parts]
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
    /// Threads of a task [default: the engine's]
    #[arg(short = 't', long = "nthreads", value_name = "N", value_parser = small_count)]
    threads: Option<u32>,
    /// Tasks at once, for --engine local
    #[arg(long, value_name = "N", default_value = "1")]
    jobs: NonZeroUsize,
    /// Another option of sbatch, for example --slurm-option=--partition=long (repeatable)
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    slurm_option: Vec<String>,
    /// Write the job's files and queue nothing
    #[arg(long)]
    dry_run: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Engine {
    /// A job array and a merge that depends on it
    Slurm,
    /// A template of Open Job Description; prints the command that runs it here
    Openjd,
    /// Processes of this machine
    Local,
}

/// Ranges that passes are split into where nothing is said.
const DEFAULT_PARTS: u32 = 64;

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    Outputs::check_names(&args.output)?;
    // What is wrong with the scene is told here, and not by every task.
    let passes = args.scene.load(verbosity)?.scene.settings.passes;
    Outputs::check(&args.output, false)?;
    let job = job(args, passes)?;
    match args.engine {
        Engine::Slurm if args.dry_run => {
            slurm::write(&job)?;
            note(
                verbosity,
                "done",
                &format!("{} and {} in {}", slurm::RENDER_SCRIPT, slurm::MERGE_SCRIPT, job.folder.display()),
            );
        }
        Engine::Slurm => {
            let queued = Slurm { options: args.slurm_option.clone(), ..Slurm::default() }.submit(&job)?;
            print(&format!("render {}\nmerge {}\n", queued.render, queued.merge))?;
        }
        Engine::Openjd => {
            openjd::write(&job)?;
            print(&(command_line(&openjd::command(&job)) + "\n"))?;
        }
        Engine::Local if args.dry_run => job.check()?,
        Engine::Local => run_here(args, &job, verbosity)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn run_here(args: &Args, job: &Job, verbosity: Verbosity) -> Result<(), Failure> {
    let signals = Signals::watch()?;
    let mut told = |done, of| note(verbosity, "local", &format!("{done} of {of} tasks are done"));
    local::run(job, args.jobs, signals.stop_flag(), &mut told).map_err(|error| match error {
        SubmitError::Interrupted => Failure::new(signals.exit_code().unwrap_or(code::FAILED), error.to_string()),
        other => other.into(),
    })?;
    note(verbosity, "done", &job.output.display().to_string());
    Ok(())
}

fn job(args: &Args, passes: u32) -> Result<Job, Failure> {
    let absolute = |path: &Path| {
        std::path::absolute(path).map_err(|error| Failure::new(code::NO_INPUT, format!("{}: {error}", path.display())))
    };
    let program = std::env::current_exe()
        .map_err(|error| Failure::new(code::FAILED, format!("cannot find this program's own file: {error}")))?;
    let output = absolute(&args.output.output)?;
    let folder = match &args.folder {
        Some(folder) => absolute(folder)?,
        None => {
            let mut name = output.clone().into_os_string();
            name.push(".parts");
            name.into()
        }
    };
    Ok(Job {
        program,
        scene: absolute(&args.scene.scene)?,
        // The environment of a task may be another one: what it says here is said to each task.
        settings: [
            args.scene.overrides().iter().flat_map(|o| ["-D".to_owned(), o.to_string()]).collect(),
            args.scene.working_arguments(),
        ]
        .concat(),
        merge_settings: args.output.merge_arguments(absolute)?,
        passes,
        parts: args.parts.unwrap_or_else(|| passes.min(DEFAULT_PARTS)),
        tiles: args.tiles,
        output,
        folder,
        threads: args.threads,
    })
}
