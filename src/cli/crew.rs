//! Who renders beside this process: nobody, or the other ranks of an `mpirun`.

use std::ops::Range;

use pdembree::output::PartInfo;
use pdembree::render::RenderState;

use super::failure::Failure;

/// Shares passes out and brings their renders together.
pub trait Crew {
    /// This process's run of the passes.
    fn share(&self, passes: Range<u32>) -> Range<u32>;
    /// The whole, for the one that writes it; nothing for the others.
    fn gather(&self, info: &PartInfo, state: RenderState) -> Result<Option<RenderState>, Failure>;
}

/// One process does it all.
pub struct Alone;

impl Crew for Alone {
    fn share(&self, passes: Range<u32>) -> Range<u32> {
        passes
    }
    fn gather(&self, _info: &PartInfo, state: RenderState) -> Result<Option<RenderState>, Failure> {
        Ok(Some(state))
    }
}

#[cfg(feature = "mpi")]
mod over_mpi {
    use std::ops::Range;
    use std::process::ExitCode;

    use pdembree::distribute::mpi::Ranks;
    use pdembree::output::PartInfo;
    use pdembree::render::RenderState;

    use super::Crew;
    use crate::cli::console::{Verbosity, note};
    use crate::cli::failure::{Failure, code};

    impl Crew for Ranks {
        fn share(&self, passes: Range<u32>) -> Range<u32> {
            Ranks::share(self, &passes)
        }
        fn gather(&self, info: &PartInfo, state: RenderState) -> Result<Option<RenderState>, Failure> {
            Ok(self.reduce(info, state)?)
        }
    }

    /// Runs `work` on every rank, of which only the first one speaks. A rank that cannot go on ends all.
    pub fn over_ranks(
        verbosity: Verbosity,
        work: impl FnOnce(&Ranks, Verbosity) -> Result<ExitCode, Failure>,
    ) -> Result<ExitCode, Failure> {
        let ranks = Ranks::join().ok_or_else(|| Failure::new(code::FAILED, "MPI cannot be started twice"))?;
        let own = if ranks.is_first() { verbosity } else { Verbosity { quiet: true, verbose: false } };
        match work(&ranks, own) {
            Ok(done) if done == ExitCode::SUCCESS => Ok(done),
            Ok(_) => ranks.end_all(code::FAILED),
            Err(failure) => {
                // A scene's problems were printed where they were found.
                let colon = if failure.message.is_empty() { "" } else { ": " };
                let what = format!("rank {} failed{colon}{}", ranks.rank(), failure.message);
                note(verbosity, "error", &format!("{what}; all ranks end, nothing was written"));
                ranks.end_all(failure.code)
            }
        }
    }
}

#[cfg(feature = "mpi")]
pub use over_mpi::over_ranks;
