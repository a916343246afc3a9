//! How the program ends when it could not do what it was asked: one message, one exit code.

use std::process::ExitCode;

use pdembree::distribute::SubmitError;
use pdembree::output::lock::LockError;
use pdembree::output::{PartError, ReadError, WriteError};
use pdembree::render::store::StoreError;

use super::console::{Verbosity, note};

/// Exit codes; 65 to 75 are those of sysexits.h.
pub mod code {
    /// The work failed, or pictures differ.
    pub const FAILED: u8 = 1;
    pub const USAGE: u8 = 2;
    /// Finished, but not as good as was asked for.
    pub const INCOMPLETE: u8 = 3;
    /// EX_DATAERR: a scene or picture is wrong.
    pub const BAD_DATA: u8 = 65;
    /// EX_NOINPUT: an input is missing or cannot be read.
    pub const NO_INPUT: u8 = 66;
    /// EX_CANTCREAT: an output cannot be created; known before the work starts.
    pub const CANNOT_CREATE: u8 = 73;
    /// EX_IOERR: writing failed.
    pub const WRITE_FAILED: u8 = 74;
    /// EX_TEMPFAIL: worth another try later.
    pub const TEMPORARY: u8 = 75;
}

/// An exit code and why. The message names the place and what to do; an empty one was printed already.
#[derive(Debug)]
pub struct Failure {
    pub code: u8,
    pub message: String,
}

impl Failure {
    pub fn new(code: u8, message: impl Into<String>) -> Failure {
        Failure { code, message: message.into() }
    }

    /// Prints the message and makes the exit code.
    pub fn report(&self, verbosity: Verbosity) -> ExitCode {
        if !self.message.is_empty() {
            note(verbosity, "error", &self.message);
        }
        ExitCode::from(self.code)
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Failure {
        let code = match error {
            WriteError::UnknownExtension { .. } => code::USAGE,
            WriteError::FolderMissing { .. } | WriteError::IsFolder { .. } | WriteError::CannotCreate { .. } => {
                code::CANNOT_CREATE
            }
            _ => code::WRITE_FAILED,
        };
        Failure::new(code, error.to_string())
    }
}

impl From<LockError> for Failure {
    fn from(error: LockError) -> Failure {
        let code = if matches!(error, LockError::Held { .. }) { code::TEMPORARY } else { code::CANNOT_CREATE };
        Failure::new(code, error.to_string())
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Failure {
        let code = match error {
            StoreError::Part(PartError::Missing { .. } | PartError::Io { .. }) => code::NO_INPUT,
            _ => code::BAD_DATA,
        };
        Failure::new(code, error.to_string())
    }
}

impl From<SubmitError> for Failure {
    fn from(error: SubmitError) -> Failure {
        let code = match error {
            SubmitError::Write(error) => return error.into(),
            SubmitError::Folder { .. } => code::CANNOT_CREATE,
            SubmitError::TaskFailed { code, .. } => code,
            SubmitError::EngineMissing { .. }
            | SubmitError::CannotStart { .. }
            | SubmitError::SbatchFailed { .. }
            | SubmitError::SbatchAnswer { .. }
            | SubmitError::MergeNotQueued { .. }
            | SubmitError::Interrupted => code::FAILED,
            _ => code::USAGE,
        };
        Failure::new(code, error.to_string())
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Failure {
        let code = match error {
            ReadError::Missing { .. } | ReadError::Io { .. } => code::NO_INPUT,
            _ => code::BAD_DATA,
        };
        Failure::new(code, error.to_string())
    }
}
