//! Where the program's words go.

use std::io::{self, IsTerminal, Write};

use super::failure::{Failure, code};

/// How much is said on stderr.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct Verbosity {
    /// Say more on stderr
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Say nothing but errors
    #[arg(short, long, global = true)]
    pub quiet: bool,
}

/// Whether stderr is a terminal that can move its cursor.
pub fn stderr_is_terminal() -> bool {
    io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Whether stderr takes colours: `NO_COLOR` set to anything but nothing says no (no-color.org).
pub fn stderr_has_colour() -> bool {
    stderr_is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// A line on stderr; `-q` leaves only errors.
pub fn note(verbosity: Verbosity, kind: &str, message: &str) {
    if !verbosity.quiet || kind == "error" {
        // Nobody is left to be told when stderr is closed.
        let _ = writeln!(io::stderr().lock(), "pdembree: {kind}: {message}");
    }
}

/// Prints what was asked for. A reader that has gone (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(code::WRITE_FAILED, format!("stdout: writing failed: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a value as JSON, one document.
pub fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Failure::new(code::WRITE_FAILED, format!("stdout: no JSON for this: {error}")))?;
    print(&(text + "\n"))
}
