//! How far the work is, told on stderr: a bar, plain lines or JSON lines.

use std::io::{self, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use pdembree::output::sidecar::Phase;
use pdembree::render::progress::Progress;
use serde_json::json;

use super::console::{Verbosity, stderr_is_terminal};
use super::memory;

/// What `--progress` may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Mode {
    /// A bar on a terminal, plain lines elsewhere
    #[default]
    Auto,
    Bar,
    /// A line every ten seconds
    Plain,
    /// One JSON object a line, twice a second
    Json,
    None,
}

/// What the work is measured by.
#[derive(Clone, Copy)]
enum Whole {
    /// Phases that take about equally long.
    Phases(u64),
    /// Steps of all phases together.
    Steps(u64),
}

/// Steps of the bar.
const BAR_STEPS: u64 = 1000;

/// Listens to a render, or to a study. Phases follow one another.
pub struct Reporter {
    mode: Mode,
    whole: Whole,
    started: Instant,
    bar: ProgressBar,
    state: Mutex<State>,
}

struct State {
    name: String,
    phase_started: Instant,
    done: u64,
    total: u64,
    /// Phases that are over, those of the same name added up, in the order of their first appearance.
    finished: Vec<Phase>,
    finished_count: u64,
    finished_steps: u64,
    /// Steps that cost no time.
    skipped_steps: u64,
    last_line: Instant,
}

impl Reporter {
    /// For work of `phases` phases.
    pub fn new(mode: Mode, verbosity: Verbosity, phases: u64) -> Reporter {
        Reporter::of(mode, verbosity, Whole::Phases(phases.max(1)))
    }

    /// For work of `steps` steps in all phases together.
    pub fn of_steps(mode: Mode, verbosity: Verbosity, steps: u64) -> Reporter {
        Reporter::of(mode, verbosity, Whole::Steps(steps.max(1)))
    }

    fn of(mode: Mode, verbosity: Verbosity, whole: Whole) -> Reporter {
        let mode = match mode {
            _ if verbosity.quiet && mode != Mode::Json => Mode::None,
            Mode::Auto if stderr_is_terminal() => Mode::Bar,
            Mode::Auto => Mode::Plain,
            chosen => chosen,
        };
        let target = if mode == Mode::Bar { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), target);
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        let now = Instant::now();
        let state = State {
            name: String::new(),
            phase_started: now,
            done: 0,
            total: 0,
            finished: Vec::new(),
            finished_count: 0,
            finished_steps: 0,
            skipped_steps: 0,
            last_line: now,
        };
        Reporter { mode, whole, started: now, bar, state: Mutex::new(state) }
    }

    /// What the phases so far took.
    pub fn phases(&self) -> Vec<Phase> {
        self.state().finished.clone()
    }

    /// Takes the bar away.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }

    /// A panic of another thread does not make the counts wrong.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn say(&self, state: &mut State, at_once: bool) {
        let pause = match self.mode {
            Mode::Json => Duration::from_millis(500),
            Mode::Plain => Duration::from_secs(10),
            _ => Duration::from_millis(100),
        };
        let phase_edge = at_once && self.mode != Mode::Plain;
        if self.mode == Mode::None || !phase_edge && state.last_line.elapsed() < pause {
            return;
        }
        state.last_line = Instant::now();
        let inside = if state.total > 0 { state.done as f64 / state.total as f64 } else { 0.0 };
        let whole = match self.whole {
            Whole::Phases(all) => (state.finished_count as f64 + inside) / all as f64,
            Whole::Steps(all) => (state.skipped_steps + state.finished_steps + state.done) as f64 / all as f64,
        };
        let whole = whole.min(1.0);
        let elapsed = self.started.elapsed().as_secs_f64();
        let skipped = match self.whole {
            Whole::Phases(_) => 0.0,
            Whole::Steps(all) => state.skipped_steps as f64 / all as f64,
        };
        let worked = whole - skipped;
        let left = (worked > 0.0).then(|| elapsed * (1.0 - whole) / worked);
        let percent = 100.0 * whole;
        let eta = left.map_or_else(String::new, |s| format!(", about {} left", duration(s)));
        // Nobody is left to be told when stderr is closed.
        let line = |text: String| drop(writeln!(io::stderr().lock(), "{text}"));
        match self.mode {
            Mode::Bar => {
                self.bar.set_position((whole * BAR_STEPS as f64) as u64);
                self.bar.set_message(format!("{percent:3.0} % {}{eta}", state.name));
            }
            Mode::Plain => line(format!("pdembree: {percent:.0} % {}, {}{eta}", state.name, duration(elapsed))),
            Mode::Json => line(
                json!({
                    "event": "progress", "phase": state.name, "done": state.done, "total": state.total,
                    "percent": percent, "elapsed_s": elapsed, "eta_s": left, "rss_bytes": memory::resident(),
                })
                .to_string(),
            ),
            Mode::Auto | Mode::None => {}
        }
    }
}

impl Progress for Reporter {
    fn phase(&self, name: &str, total: u64) {
        let mut state = self.state();
        name.clone_into(&mut state.name);
        (state.done, state.total, state.phase_started) = (0, total, Instant::now());
        self.say(&mut state, true);
    }

    fn advance(&self, n: u64) {
        let mut state = self.state();
        state.done += n;
        self.say(&mut state, false);
    }

    fn finish(&self) {
        let mut state = self.state();
        state.done = state.total;
        self.say(&mut state, true);
        let seconds = state.phase_started.elapsed().as_secs_f64();
        let name = std::mem::take(&mut state.name);
        match state.finished.iter_mut().find(|phase| phase.name == name) {
            Some(phase) => phase.seconds += seconds,
            None => state.finished.push(Phase { name, seconds }),
        }
        state.finished_count += 1;
        state.finished_steps += state.total;
        (state.done, state.total) = (0, 0);
    }

    fn skip(&self, n: u64) {
        self.state().skipped_steps += n;
    }
}

/// Seconds as one says them: `0.4 s`, `75 s`, `12 min`, `3.5 h`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
