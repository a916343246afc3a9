//! Handing a render to an engine that distributes work: Slurm, Open Job Description, or processes of this machine.
//!
//! All engines do the same two things with the same program: `render --pass-range A..B [--tile J/M]` for every [`Task`]
//! of a [`Job`], in any order and on any machine that sees the folder, and one `merge` when all parts are there. A part
//! depends on the scene and its range only, and is skipped when it is there already. So the picture does not depend on
//! the engine, and a job that broke off is handed over again as it is: what is missing is rendered.
//!
//! Nothing here prints or reads the scene.

mod error;
mod job;
pub mod local;
#[cfg(feature = "mpi")]
pub mod mpi;
pub mod openjd;
mod shell;
pub mod slurm;

pub use error::SubmitError;
pub use job::{Job, Task};
pub use shell::command_line;
