//! The ranks of an `mpirun`: each renders its run of the passes, the first one adds them up in the order of the passes.
//!
//! What a rank sends is a part as it would stand in a file, with its digest; sums are exact, so any number of ranks gives
//! the same picture. MPI has no way to go on without a rank: when one fails, all end, and say so.

use std::ops::Range;
use std::path::PathBuf;

use mpi::environment::Universe;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, Destination, Source};

use crate::output::part::{decode, encode};
use crate::output::{PartError, PartInfo};
use crate::render::RenderState;
use crate::render::store::{self, state_of};

/// This process among those of its `mpirun`.
pub struct Ranks {
    world: SimpleCommunicator,
    // Ends MPI when it is dropped.
    _universe: Universe,
}

/// Bytes in a message: MPI counts them in 31 bits.
const MESSAGE: usize = 1 << 30;

impl Ranks {
    /// Joins the others; `None` where MPI was started before.
    pub fn join() -> Option<Ranks> {
        let universe = mpi::initialize()?;
        Some(Ranks { world: universe.world(), _universe: universe })
    }

    /// Whether this is the rank that adds up, tells and writes.
    pub fn is_first(&self) -> bool {
        self.world.rank() == 0
    }

    pub fn size(&self) -> u32 {
        self.world.size().unsigned_abs()
    }

    pub fn rank(&self) -> u32 {
        self.world.rank().unsigned_abs()
    }

    /// This rank's run of `passes`; empty where there are more ranks than passes.
    pub fn share(&self, passes: &Range<u32>) -> Range<u32> {
        let cut = |k: u32| passes.start + (passes.len() as u64 * u64::from(k) / u64::from(self.size())) as u32;
        cut(self.rank())..cut(self.rank() + 1)
    }

    /// Ends all ranks: without this one nothing is whole.
    pub fn end_all(&self, code: u8) -> ! {
        self.world.abort(code.into())
    }

    /// Brings the ranks' renders together. The first one gets the whole, the others nothing.
    ///
    /// # Errors
    /// What came over the wire is no part, or is one of another render.
    pub fn reduce(&self, info: &PartInfo, state: RenderState) -> Result<Option<RenderState>, store::StoreError> {
        if !self.is_first() {
            self.send(info, &state)?;
            return Ok(None);
        }
        let mut all = state;
        for rank in 1..self.size() {
            let bytes = self.receive(rank);
            let (found, state) = state_of(decode(&bytes, &PathBuf::from(format!("rank {rank}")))?);
            let differences = found.identity.differences(&info.identity);
            if !differences.is_empty() {
                let path = PathBuf::from(format!("rank {rank}"));
                return Err(store::StoreError::OtherRender { path, other: "rank 0".to_owned(), differences });
            }
            all.add_passes(&state);
        }
        Ok(Some(all))
    }

    fn send(&self, info: &PartInfo, state: &RenderState) -> Result<(), PartError> {
        let report = serde_json::to_value(&state.report).unwrap_or_default();
        let mut bytes = Vec::new();
        encode(&mut bytes, &PartInfo { report, ..info.clone() }, &state.film)
            .map_err(|source| PartError::Io { path: PathBuf::from("the message to rank 0"), source })?;
        let first = self.world.process_at_rank(0);
        first.send(&(bytes.len() as u64));
        bytes.chunks(MESSAGE).for_each(|chunk| first.send(chunk));
        Ok(())
    }

    fn receive(&self, rank: u32) -> Vec<u8> {
        let process = self.world.process_at_rank(rank.cast_signed());
        let (length, _) = process.receive::<u64>();
        let mut bytes = vec![0; length as usize];
        bytes.chunks_mut(MESSAGE).for_each(|chunk| {
            process.receive_into(chunk);
        });
        bytes
    }
}
