//! `pdembree convert IN OUT.toml`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use pdembree::import::{self, Converted};
use pdembree::output::atomic;
use pdembree::output::target::probe;

use super::console::{Verbosity, note};
use super::failure::{Failure, code};
use super::problems;

/// Write a scene file that takes a glTF or pbrt file in
///
/// It includes the file and repeats its camera, settings, materials and lights, to be changed there; meshes and images stay
/// where they are. As it is written it renders the same bits as the file.
#[derive(clap::Args)]
pub struct Args {
    /// glTF or pbrt file
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// Scene file to write
    #[arg(value_name = "OUT.toml")]
    output: PathBuf,
    /// Of a pbrt file leave out what cannot be rendered, with a warning
    #[arg(long)]
    lenient: bool,
    /// Write over a file that is there
    #[arg(long)]
    force: bool,
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    let usage = |what: &str, path: &Path| Failure::new(code::USAGE, format!("{}: {what}", path.display()));
    if !import::is_foreign(&args.input) {
        return Err(usage("glTF and pbrt files are converted, whose names end in .gltf, .glb or .pbrt", &args.input));
    }
    if args.output.extension().is_none_or(|ending| ending != "toml") {
        return Err(usage("scene files end in .toml", &args.output));
    }
    if args.output.exists() && !args.force {
        let message = format!("{}: there is such a file; --force writes over it", args.output.display());
        return Err(Failure::new(code::CANNOT_CREATE, message));
    }
    probe(&args.output, false)?;
    let Converted { text, warnings } =
        import::convert(&args.input, &args.output, args.lenient).map_err(|all| problems::failure(&all))?;
    if !verbosity.quiet {
        problems::print(&warnings, miette::Severity::Warning);
    }
    atomic::write(&args.output, text.as_bytes())?;
    note(verbosity, "done", &args.output.display().to_string());
    Ok(ExitCode::SUCCESS)
}
