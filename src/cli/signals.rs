//! Signals as questions: nothing happens in a handler but a flag.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;

/// What the process was asked from outside.
pub struct Signals {
    /// The signal that asked to stop; 0 before.
    stop: Arc<AtomicUsize>,
    snapshot: Arc<AtomicBool>,
}

impl Signals {
    /// From now on the first SIGINT or SIGTERM is a question, a second one ends the process at once; SIGUSR1 asks for a
    /// snapshot.
    pub fn watch() -> io::Result<Signals> {
        let signals = Signals { stop: Arc::default(), snapshot: Arc::default() };
        let asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // Before the flag is set, so that the first signal does not see its own.
            flag::register_conditional_shutdown(signal, exit_code(signal), asked.clone())?;
            flag::register_usize(signal, signals.stop.clone(), signal as usize)?;
        }
        for signal in [SIGINT, SIGTERM] {
            flag::register(signal, asked.clone())?;
        }
        flag::register(SIGUSR1, signals.snapshot.clone())?;
        Ok(signals)
    }

    pub fn stop_asked(&self) -> bool {
        self.stop.load(Ordering::Relaxed) != 0
    }

    /// The exit code of a stop that was asked for: 130 or 143.
    pub fn exit_code(&self) -> Option<u8> {
        let signal = self.stop.load(Ordering::Relaxed) as i32;
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
