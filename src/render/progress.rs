//! What a renderer tells the world while it works. Nothing here prints.

/// Receives events from any thread.
pub trait Progress: Sync {
    /// A phase of `total` steps begins.
    fn phase(&self, name: &str, total: u64);
    /// `n` more steps of the phase are done.
    fn advance(&self, n: u64);
    /// The phase is over.
    fn finish(&self);
    /// `n` steps of the whole need no work: their results were there, or it turned out that they are not wanted.
    fn skip(&self, n: u64);
}

/// Listens to nothing.
pub struct Silent;

impl Progress for Silent {
    fn phase(&self, _name: &str, _total: u64) {}
    fn advance(&self, _n: u64) {}
    fn finish(&self) {}
    fn skip(&self, _n: u64) {}
}
