//! Signals as questions: nothing happens in a handler but a flag.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;

use super::failure::{Failure, code};

/// What the process was asked from outside.
pub struct Signals {
    /// The signal that asked to stop; 0 before.
    signal: Arc<AtomicUsize>,
    stop: Arc<AtomicBool>,
    snapshot: Arc<AtomicBool>,
}

impl Signals {
    /// From now on the first SIGINT or SIGTERM is a question, a second one ends the process at once; SIGUSR1 asks for a
    /// snapshot.
    ///
    /// # Errors
    /// The system does not let us.
    pub fn watch() -> Result<Signals, Failure> {
        let signals = Signals { signal: Arc::default(), stop: Arc::default(), snapshot: Arc::default() };
        signals.register().map_err(|error| Failure::new(code::FAILED, format!("cannot listen to signals: {error}")))?;
        Ok(signals)
    }

    fn register(&self) -> io::Result<()> {
        for signal in [SIGINT, SIGTERM] {
            // Before the flag is set, so that the first signal does not see its own.
            flag::register_conditional_shutdown(signal, exit_code(signal), self.stop.clone())?;
            flag::register_usize(signal, self.signal.clone(), signal as usize)?;
            flag::register(signal, self.stop.clone())?;
        }
        flag::register(SIGUSR1, self.snapshot.clone())?;
        Ok(())
    }

    pub fn stop_asked(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Becomes true when it is asked to stop.
    pub fn stop_flag(&self) -> &AtomicBool {
        &self.stop
    }

    /// The exit code of a stop that was asked for: 130 or 143.
    pub fn exit_code(&self) -> Option<u8> {
        let signal = self.signal.load(Ordering::Relaxed) as i32;
        (signal != 0).then(|| exit_code(signal) as u8)
    }

    /// Whether a snapshot was asked for since the last time this was called.
    pub fn take_snapshot(&self) -> bool {
        self.snapshot.load(Ordering::Relaxed) && self.snapshot.swap(false, Ordering::Relaxed)
    }
}

/// As shells report a process that died of a signal.
fn exit_code(signal: i32) -> i32 {
    128 + signal
}
