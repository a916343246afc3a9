//! `pdembree completions SHELL`

use std::process::ExitCode;

use clap_complete::Shell;

use super::console::print;
use super::definition;
use super::failure::Failure;

/// Print a completion script for a shell
///
/// For example: pdembree completions bash > ~/.local/share/bash-completion/completions/pdembree
#[derive(clap::Args)]
pub struct Args {
    shell: Shell,
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut definition(), "pdembree", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(ExitCode::SUCCESS)
}
