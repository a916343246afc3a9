//! `pdembree man`

use std::path::PathBuf;
use std::process::ExitCode;

use pdembree::output::{WriteError, atomic};

use super::console::print;
use super::definition;
use super::failure::{Failure, code};

/// Print the man page (roff), or write one page for every command into a folder
///
/// For example: pdembree man | man -l -
#[derive(clap::Args)]
pub struct Args {
    /// The command whose page is printed, for example `render`
    command: Option<String>,
    /// Write all pages, pdembree.1, pdembree-render.1 and so on, into this folder
    #[arg(long, value_name = "FOLDER", conflicts_with = "command")]
    all: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut whole = definition();
    // Fills in what the parent gives its commands: their full names and the global options.
    whole.build();
    match (&args.all, &args.command) {
        (Some(folder), _) => {
            for command in std::iter::once(&whole).chain(whole.get_subcommands()) {
                let name = command.get_display_name().unwrap_or_else(|| command.get_name());
                atomic::write(&folder.join(format!("{name}.1")), &page(command)?)?;
            }
        }
        (None, None) => print(&String::from_utf8_lossy(&page(&whole)?))?,
        (None, Some(name)) => {
            let unknown = || Failure::new(code::USAGE, format!("there is no command {name}; see pdembree --help"));
            let command = whole.find_subcommand(name).ok_or_else(unknown)?;
            print(&String::from_utf8_lossy(&page(command)?))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn page(command: &clap::Command) -> Result<Vec<u8>, WriteError> {
    let mut page = Vec::new();
    let failed = |source| WriteError::Failed { path: PathBuf::from("the man page"), source };
    clap_mangen::Man::new(command.clone()).render(&mut page).map_err(failed)?;
    Ok(page)
}
