//! Why a render could not be handed over, or did not come back; every message says what to do.

use std::path::PathBuf;

use crate::output::WriteError;

/// A job that was refused, or that failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SubmitError {
    #[error("0 {what}: there must be at least one")]
    Zero { what: &'static str },
    #[error("{parts} parts of {passes} passes: a part holds at least one pass; ask for {passes} parts at most")]
    MorePartsThanPasses { parts: u32, passes: u32 },
    #[error("{tasks} tasks (parts times tiles) are too many; ask for {most} at most")]
    TooManyTasks { tasks: u64, most: u64 },
    #[error("{}: a path of a job must be absolute", path.display())]
    NotAbsolute { path: PathBuf },
    #[error("{}: the path is not Unicode, which job files must be; rename it", path.display())]
    NotUnicode { path: PathBuf },
    #[error("{text:?} holds a line break or another control character, which job files cannot hold; change it")]
    ControlCharacter { text: String },
    #[error("setting {text:?}: `{{{{` begins a parameter of an Open Job Description; change it")]
    Braces { text: String },
    #[error("{}: `%` and `\\` mean something to Slurm; choose another folder", folder.display())]
    NotForSlurm { folder: PathBuf },
    #[error("{}: cannot be made: {source}; choose another folder or change its permissions", folder.display())]
    Folder { folder: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("{}: no such program; install {package} or add its folder to PATH", program.display())]
    EngineMissing { program: PathBuf, package: &'static str },
    #[error("{}: cannot be started: {source}", program.display())]
    CannotStart { program: PathBuf, source: std::io::Error },
    #[error("sbatch refused {script}: {reason}")]
    SbatchFailed { script: &'static str, reason: String },
    #[error("sbatch answered {answer:?} instead of a job's number; does it know --parsable?")]
    SbatchAnswer { answer: String },
    #[error(
        "the renders are queued as Slurm job {render}, but nothing that merges them: {source}; \
         cancel them with `scancel {render}`, or hand the job over again when they are done"
    )]
    MergeNotQueued { render: String, source: Box<SubmitError> },
    #[error("{what} ended with {status}; its messages are in {}", log.display())]
    TaskFailed {
        what: String,
        /// As a shell tells it: 128 and the signal's number when a signal ended the process.
        code: u8,
        status: String,
        log: PathBuf,
    },
    #[error("interrupted; parts that are done were kept, the same command goes on from there")]
    Interrupted,
}
