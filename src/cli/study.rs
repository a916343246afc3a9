//! `pdembree study STUDY -o FOLDER`

use std::path::PathBuf;
use std::process::ExitCode;

use pdembree::study::place::Place;
use pdembree::study::plan::Experiment;
use pdembree::study::reference::Shelf;
use pdembree::study::run::{Studied, expected_steps, run as run_study};
use pdembree::study::{StudyError, file};

use super::console::{Verbosity, note};
use super::failure::{Failure, code};
use super::problems;
use super::work::{WorkArgs, world_failure};

/// Compare methods with each other and with a reference: tables, curves and pictures on one page
///
/// A study file names scenes, methods, numbers of photons, bandwidths and seeds. The folder gets results.json,
/// results.csv, all pictures and index.html. Every finished render is kept there: a study that was stopped goes on where
/// it was.
#[derive(clap::Args)]
pub struct Args {
    /// Study file (TOML)
    study: PathBuf,
    /// Folder of the report; it is made if it is not there
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Folder for rendered references [default: FOLDER/references; those beside the study file are read, too]
    #[arg(long, value_name = "FOLDER")]
    references: Option<PathBuf>,
    /// Only the experiment of this name; can be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    #[command(flatten)]
    work: WorkArgs,
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    let study = file::read(&args.study).map_err(|all| problems::failure(&all))?;
    if let Some(unknown) = args.only.iter().find(|name| study.experiments.iter().all(|e| e.name != **name)) {
        let known: Vec<&str> = study.experiments.iter().map(|e| e.name.as_str()).collect();
        let message = format!("--only: there is no experiment \"{unknown}\"; the study has {}", known.join(", "));
        return Err(Failure::new(code::USAGE, message));
    }
    let wanted = |e: &Experiment| args.only.is_empty() || args.only.contains(&e.name);
    let threads = args.work.start_threads()?;
    let reporter = args.work.step_reporter(verbosity, expected_steps(&study, wanted));
    let own = args.references.clone().unwrap_or_else(|| args.output.join("references"));
    let published = study.folder.join("references");
    let references = Shelf { published: &published, own: &own };
    let place = Place { folder: &args.output, references, threads, progress: &reporter };
    let studied = run_study(&study, &place, wanted);
    reporter.end();
    let Studied { results, notes } = studied.map_err(failure)?;
    notes.iter().for_each(|text| note(verbosity, "warning", text));
    pdembree::report::write(&args.output, &results)
        .map_err(|error| Failure::new(code::WRITE_FAILED, error.to_string()))?;
    let rows: usize = results.experiments.iter().map(|e| e.rows.len()).sum();
    note(verbosity, "done", &format!("{} with {rows} rows", args.output.join("index.html").display()));
    Ok(ExitCode::SUCCESS)
}

fn failure(error: StudyError) -> Failure {
    match error {
        StudyError::Problems(all) => problems::failure(&all),
        StudyError::World(error) => world_failure(&error),
        StudyError::Write(error) => error.into(),
        StudyError::Read(error) => Failure::new(code::NO_INPUT, error.to_string()),
        error => Failure::new(code::BAD_DATA, error.to_string()),
    }
}
