//! Who looks over a render's shoulder: may save it, show it, or stop it between two units.

use super::RenderState;
use super::progress::Progress;
use crate::surface::Textures;

/// Hears of the progress, and is asked between units.
pub trait Watch: Progress {
    /// Whether no further unit shall be begun; asked by any thread.
    fn stop(&self) -> bool {
        false
    }
    /// Called on the conductor's thread after every unit and every pass.
    fn look(&self, _state: &RenderState) {}
}

/// The render was stopped before it was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

/// Lets a render run to its end.
pub struct Unattended<'a>(pub &'a dyn Progress);

impl Progress for Unattended<'_> {
    fn phase(&self, name: &str, total: u64) {
        self.0.phase(name, total);
    }
    fn advance(&self, n: u64) {
        self.0.advance(n);
    }
    fn finish(&self) {
        self.0.finish();
    }
    fn skip(&self, n: u64) {
        self.0.skip(n);
    }
}

impl Watch for Unattended<'_> {}

/// Stops a render whose textures cannot be read any more, and shows nobody what came of it. A failure is known before the
/// unit that met it is handed over.
pub struct WhileTexturesAreRead<'a> {
    pub watch: &'a dyn Watch,
    pub textures: &'a Textures,
}

impl Progress for WhileTexturesAreRead<'_> {
    fn phase(&self, name: &str, total: u64) {
        self.watch.phase(name, total);
    }
    fn advance(&self, n: u64) {
        self.watch.advance(n);
    }
    fn finish(&self) {
        self.watch.finish();
    }
    fn skip(&self, n: u64) {
        self.watch.skip(n);
    }
}

impl Watch for WhileTexturesAreRead<'_> {
    fn stop(&self) -> bool {
        self.watch.stop() || self.textures.failure().is_some()
    }
    fn look(&self, state: &RenderState) {
        if self.textures.failure().is_none() {
            self.watch.look(state);
        }
    }
}
