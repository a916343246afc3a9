//! Looks after a render while it works: saves it, shows it, stops it when a signal asked.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use pdembree::film::Image;
use pdembree::output::exr::Window;
use pdembree::output::tev::Viewer;
use pdembree::output::{PartInfo, WriteError, exr};
use pdembree::render::RenderState;
use pdembree::render::progress::Progress;
use pdembree::render::store;
use pdembree::render::watch::Watch;

use super::console::{Verbosity, note};
use super::progress::Reporter;
use super::signals::Signals;

/// Where and how often a render is saved.
pub struct Checkpoint {
    pub path: PathBuf,
    pub every: Duration,
    pub info: PartInfo,
}

/// Where SIGUSR1 puts the picture so far.
pub struct Snapshot {
    pub path: PathBuf,
    /// Of the whole picture.
    pub resolution: [u32; 2],
}

/// Looks after one render.
pub struct Keeper<'a> {
    pub reporter: &'a Reporter,
    pub signals: &'a Signals,
    pub checkpoint: Option<Checkpoint>,
    pub viewer: Option<Viewer>,
    pub snapshot: Snapshot,
    pub verbosity: Verbosity,
    clock: Mutex<Clock>,
}

/// When things were done last; of the monotonic clock, which does not jump.
struct Clock {
    saved: Instant,
    /// When the viewer gets the next picture.
    show: Instant,
    save_failed: bool,
}

/// Pictures go to the viewer this often, and at most a twentieth of the time is spent making them.
const SHOW_EVERY: Duration = Duration::from_secs(1);
const SHOW_SHARE: u32 = 20;

impl<'a> Keeper<'a> {
    pub fn new(
        reporter: &'a Reporter,
        signals: &'a Signals,
        checkpoint: Option<Checkpoint>,
        viewer: Option<Viewer>,
        snapshot: Snapshot,
        verbosity: Verbosity,
    ) -> Keeper<'a> {
        let now = Instant::now();
        let clock = Mutex::new(Clock { saved: now, show: now, save_failed: false });
        Keeper { reporter, signals, checkpoint, viewer, snapshot, verbosity, clock }
    }

    /// Shows the final picture; says what went wrong with the viewer, if something did.
    pub fn close_viewer(self, picture: Image) -> Option<String> {
        let viewer = self.viewer?;
        viewer.show(picture);
        viewer.close()
    }

    /// Saves the render now, if it is to be saved at all.
    pub fn save(&self, state: &RenderState) -> Result<(), WriteError> {
        self.checkpoint.as_ref().map_or(Ok(()), |to| store::save(&to.path, &to.info, state))
    }

    /// Writes the picture so far beside the one that is to come.
    pub fn write_snapshot(&self, state: &RenderState) -> Result<(), WriteError> {
        let bounds = state.film.bounds();
        let window = Window { origin: [bounds.x0, bounds.y0], whole: self.snapshot.resolution };
        let passes = ("passes".to_owned(), state.film.passes().to_string());
        exr::write_window(&self.snapshot.path, &state.film.resolve(), window, &[passes])
    }

    fn look(&self, state: &RenderState) {
        if self.signals.take_snapshot() {
            match self.write_snapshot(state) {
                Ok(()) => note(self.verbosity, "snapshot", &self.snapshot.path.display().to_string()),
                Err(error) => note(self.verbosity, "warning", &format!("no snapshot: {error}")),
            }
        }
        let mut clock = self.clock.lock().unwrap_or_else(PoisonError::into_inner);
        if self.checkpoint.as_ref().is_some_and(|to| clock.saved.elapsed() >= to.every) {
            self.save_in_the_middle(state, &mut clock);
        }
        if let Some(viewer) = self.viewer.as_ref().filter(|_| Instant::now() >= clock.show) {
            let start = Instant::now();
            viewer.show(state.film.resolve());
            clock.show = Instant::now() + SHOW_EVERY.max(start.elapsed() * SHOW_SHARE);
        }
    }

    /// A disk that is full now may be free again later: the render goes on, and the last good file is still there.
    fn save_in_the_middle(&self, state: &RenderState, clock: &mut Clock) {
        match self.save(state) {
            Ok(()) => clock.save_failed = false,
            Err(error) if !clock.save_failed => {
                clock.save_failed = true;
                note(self.verbosity, "warning", &format!("no checkpoint, will be tried again: {error}"));
            }
            Err(_) => {}
        }
        clock.saved = Instant::now();
    }
}

impl Progress for Keeper<'_> {
    fn phase(&self, name: &str, total: u64) {
        self.reporter.phase(name, total);
    }
    fn advance(&self, n: u64) {
        self.reporter.advance(n);
    }
    fn finish(&self) {
        self.reporter.finish();
    }
    fn skip(&self, n: u64) {
        self.reporter.skip(n);
    }
}

impl Watch for Keeper<'_> {
    fn stop(&self) -> bool {
        self.signals.stop_asked()
    }
    fn look(&self, state: &RenderState) {
        Keeper::look(self, state);
    }
}
