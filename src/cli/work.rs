//! Options and steps that every command shares that traces rays.

use std::num::NonZeroUsize;

use pdembree::backend::BackendError;
use pdembree::render::{RenderError, unit};
use pdembree::scene::Scene;
use pdembree::world::{World, WorldError};

use super::console::Verbosity;
use super::failure::{Failure, code};
use super::progress::{Mode, Reporter};

#[derive(clap::Args)]
pub struct WorkArgs {
    /// Threads [default: one for each processor]
    #[arg(short = 't', long = "nthreads", env = "PDEMBREE_NTHREADS", value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// How progress is told: on stderr, for alf and openjd on stdout
    #[arg(long, env = "PDEMBREE_PROGRESS", value_name = "HOW", value_enum, default_value = "auto")]
    progress: Mode,
}

impl WorkArgs {
    /// Starts the threads, before a scene is read, which has work for them; returns how many there are.
    pub fn start_threads(&self) -> Result<usize, Failure> {
        let wanted = self.threads.map_or(0, NonZeroUsize::get);
        unit::start_threads(wanted)
            .map_err(|error| Failure::new(code::FAILED, format!("cannot start threads: {error}")))
    }

    /// For work whose phases differ much: `steps` are those of all phases together.
    pub fn step_reporter(&self, verbosity: Verbosity, steps: u64) -> Reporter {
        Reporter::of_steps(self.progress, verbosity, steps)
    }

    pub fn reporter(&self, verbosity: Verbosity) -> Reporter {
        Reporter::new(self.progress, verbosity)
    }

    /// How progress is told.
    pub fn progress(&self) -> Mode {
        self.progress
    }
}

/// The scene in the backend that its settings name, with its lights.
pub fn world(scene: Scene) -> Result<World, Failure> {
    World::new(scene).map_err(|error| world_failure(&error))
}

pub fn render_failure(error: &RenderError) -> Failure {
    let code = match error {
        RenderError::Camera(_) => code::BAD_DATA,
        RenderError::Textures(_) => code::FAILED,
    };
    Failure::new(code, error.to_string())
}

pub fn world_failure(error: &WorldError) -> Failure {
    let code = match error {
        WorldError::Backend(BackendError::EmbreeNotCompiledIn) => code::USAGE,
        WorldError::Backend(BackendError::Embree { .. }) | WorldError::Textures(_) => code::FAILED,
        WorldError::Backend(BackendError::OutOfBounds { .. }) | WorldError::Lights(_) => code::BAD_DATA,
    };
    Failure::new(code, error.to_string())
}
