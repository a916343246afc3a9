//! What every target holds its reader to, beside its own checks: memory in proportion to what is read.

use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Bytes that a reader may take whatever it is given: messages of problems, buffers of readers, tables of named spectra.
const FLOOR: usize = 1 << 20;

/// Runs `read` on a file of `length` bytes; panics if it held more than 64 times as many at once, beside [`FLOOR`].
pub fn bounded(length: usize, read: impl FnOnce()) {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    read();
    let held = MEMORY.peak_usage().saturating_sub(before);
    assert!(held <= 64 * length + FLOOR, "{held} bytes held at once for a file of {length}");
}
