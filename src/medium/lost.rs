//! Rays through media that lost count of where they are: each may see a wrong medium from there on.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

/// How often that happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LostCount {
    /// Entered one object more than are remembered at once; the outermost was forgotten.
    pub nested_too_deep: u64,
    /// Went through more surfaces, as through nothing, than anything but a loop has.
    pub caught_in_interfaces: u64,
}

impl LostCount {
    pub fn plus(self, other: LostCount) -> LostCount {
        LostCount {
            nested_too_deep: self.nested_too_deep + other.nested_too_deep,
            caught_in_interfaces: self.caught_in_interfaces + other.caught_in_interfaces,
        }
    }

    /// What has been added since it was `before`.
    pub fn since(self, before: LostCount) -> LostCount {
        LostCount {
            nested_too_deep: self.nested_too_deep - before.nested_too_deep,
            caught_in_interfaces: self.caught_in_interfaces - before.caught_in_interfaces,
        }
    }
}

/// Counted by rays on all threads.
#[derive(Debug, Default)]
pub(super) struct Losses {
    nested: AtomicU64,
    caught: AtomicU64,
}

impl Losses {
    pub fn note_nested(&self) {
        self.nested.fetch_add(1, Ordering::Relaxed);
    }

    pub fn note_caught(&self) {
        self.caught.fetch_add(1, Ordering::Relaxed);
    }

    pub fn count(&self) -> LostCount {
        LostCount {
            nested_too_deep: self.nested.load(Ordering::Relaxed),
            caught_in_interfaces: self.caught.load(Ordering::Relaxed),
        }
    }
}
