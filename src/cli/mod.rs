//! The program `pdembree`: one sub-command a file. The only place that prints.
//!
//! stdout carries what was asked for and nothing else; progress, warnings and errors go to stderr.

mod bench;
mod certificate;
mod check;
mod compare;
mod completions;
mod console;
mod convert;
mod crew;
mod crosscheck;
mod eta;
mod failure;
mod fit;
mod info;
mod keeper;
mod man;
mod memory;
mod merge;
mod number;
mod outputs;
mod photons;
mod problems;
mod progress;
mod render;
mod scene;
mod signals;
mod study;
mod submit;
mod work;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use self::console::Verbosity;

#[derive(Parser)]
#[command(name = "pdembree", version, about = "A renderer for caustics: photon differentials on Embree")]
#[command(
    after_help = "Exit codes: 0 done, 1 failed (or pictures differ), 2 wrong usage, 3 not as good as asked for, 65 bad scene, \
    picture or part, 66 input missing, 73 output cannot be created, 74 writing failed, 75 try again later, 130 or 143 \
    stopped by a signal.\n\
    Most options can also be set by PDEMBREE_<OPTION> in the environment; the command line wins, then the \
    environment, then the scene file."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    verbosity: Verbosity,
}

#[derive(Subcommand)]
enum Command {
    Render(render::Args),
    Merge(merge::Args),
    Submit(submit::Args),
    Photons(photons::Args),
    Crosscheck(crosscheck::Args),
    Bench(bench::Args),
    Check(check::Args),
    Compare(compare::Args),
    Study(study::Args),
    Convert(convert::Args),
    Info(info::Args),
    Completions(completions::Args),
    Man(man::Args),
}

/// What the program does; errors of usage end in clap with code 2.
pub fn run() -> ExitCode {
    let Cli { command, verbosity } = Cli::parse();
    let listener = if let Command::Render(args) = &command { Some(args.progress()) } else { None };
    let result = match command {
        Command::Render(args) => render::run(&args, verbosity),
        Command::Merge(args) => merge::run(&args, verbosity),
        Command::Submit(args) => submit::run(&args, verbosity),
        Command::Crosscheck(args) => crosscheck::run(&args, verbosity),
        Command::Bench(args) => bench::run(&args, verbosity),
        Command::Photons(args) => photons::run(&args, verbosity),
        Command::Check(args) => check::run(&args, verbosity),
        Command::Compare(args) => compare::run(&args),
        Command::Study(args) => study::run(&args, verbosity),
        Command::Convert(args) => convert::run(&args, verbosity),
        Command::Info(args) => info::run(&args, verbosity),
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => man::run(&args),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            // A farm that listens on stdout is told there too.
            let told = listener.and_then(|mode| mode.failure(&failure.message));
            let _ = told.map(|line| console::print(&line));
            failure.report(verbosity)
        }
    }
}

/// The definition of the whole command line, for completions and man pages.
fn definition() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}
