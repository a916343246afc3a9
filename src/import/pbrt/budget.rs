//! What a file may make this program allocate: a short line must not become a large scene.

use crate::scene::error::{Problem, Source};

/// Bytes for a byte of the files.
const LARGEST_GROWTH: usize = 64;
/// Bytes that even a short file may need.
const ALWAYS: usize = 32 << 20;

/// Bytes that may still be allocated.
pub(super) struct Budget {
    left: usize,
}

impl Budget {
    pub fn new() -> Budget {
        Budget { left: ALWAYS }
    }
    /// `bytes` more have been read.
    pub fn earn(&mut self, bytes: usize) {
        self.left = self.left.saturating_add(bytes.saturating_mul(LARGEST_GROWTH));
    }
    /// `count` things of `size` bytes are about to be made.
    pub fn spend(&mut self, count: usize, size: usize, place: &Source) -> Result<(), Problem> {
        let left = count.checked_mul(size).and_then(|bytes| self.left.checked_sub(bytes));
        self.left = left.ok_or_else(|| {
            let message = "the scene is far larger than the files that describe it";
            let help = format!("at most {LARGEST_GROWTH} bytes for each of theirs and {} MiB are given", ALWAYS >> 20);
            Problem::new(message).help(help).at(place)
        })?;
        Ok(())
    }
}
