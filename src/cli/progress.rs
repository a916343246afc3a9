//! How far the work is: a bar, plain lines or JSON lines on stderr, or what farms read on stdout.

use std::io::{self, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use pdembree::output::sidecar::Phase;
use pdembree::render::budget::{Budget, MAX_PASSES};
use pdembree::render::progress::Progress;
use serde_json::json;

use super::console::{Verbosity, stderr_is_terminal};
use super::eta::Eta;
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
    /// ALF_PROGRESS 42% on stdout, for Tractor and its like
    Alf,
    /// openjd_progress and openjd_status on stdout, for Open Job Description
    Openjd,
    None,
}

impl Mode {
    /// The line by which a failure is told in this mode, beside the message on stderr.
    pub fn failure(self, message: &str) -> Option<String> {
        (self == Mode::Openjd).then(|| format!("openjd_fail: {}\n", message.replace('\n', " ")))
    }
}

/// What the work is measured by.
#[derive(Clone, Copy)]
enum Whole {
    /// Passes of phases, whose times foretell the end.
    Passes,
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
    finished_steps: u64,
    /// Steps that cost no time.
    skipped_steps: u64,
    eta: Eta,
    passes: Passes,
    /// Never goes back.
    percent: f64,
    last_line: Instant,
    last_told: Option<(u64, String)>,
}

/// Passes as a reader of the progress counts them.
#[derive(Clone, Copy, Default)]
struct Passes {
    /// Ended before this run began.
    before: u32,
    ended: u32,
    /// None where only time or error ends the render.
    of: Option<u32>,
}

impl Reporter {
    /// For a render, or other work whose phases differ.
    pub fn new(mode: Mode, verbosity: Verbosity) -> Reporter {
        Reporter::of(mode, verbosity, Whole::Passes)
    }

    /// For work of `steps` steps in all phases together.
    pub fn of_steps(mode: Mode, verbosity: Verbosity, steps: u64) -> Reporter {
        Reporter::of(mode, verbosity, Whole::Steps(steps.max(1)))
    }

    fn of(mode: Mode, verbosity: Verbosity, whole: Whole) -> Reporter {
        let mode = match mode {
            _ if verbosity.quiet && matches!(mode, Mode::Auto | Mode::Bar | Mode::Plain) => Mode::None,
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
        let mut eta = Eta::default();
        eta.expect(1.0, None);
        let state = State {
            name: String::new(),
            phase_started: now,
            done: 0,
            total: 0,
            finished: Vec::new(),
            finished_steps: 0,
            skipped_steps: 0,
            eta,
            passes: Passes::default(),
            percent: 0.0,
            last_line: now,
            last_told: None,
        };
        Reporter { mode, whole, started: now, bar, state: Mutex::new(state) }
    }

    /// The render goes on after `before` passes, until the budget is spent.
    pub fn expect(&self, budget: &Budget, before: u32) {
        let of = (budget.end < MAX_PASSES).then_some(budget.end);
        let mut state = self.state();
        state.passes = Passes { before, ended: before, of };
        let limit = budget.time.map(|limit| limit.as_secs_f64());
        state.eta.expect(f64::from(budget.end.saturating_sub(before)), limit);
        let now = self.now();
        state.eta.passes_ended(0.0, now);
    }

    /// So many passes have ended; with as much noise the wanted error needs `enough` of them, if that is known.
    pub fn pass(&self, ended: u32, enough: Option<u32>) {
        let mut state = self.state();
        let now = self.now();
        state.passes.ended = ended;
        let before = state.passes.before;
        state.eta.passes_ended(f64::from(ended - before), now);
        if let Some(enough) = enough {
            let end = state.passes.of.map_or(enough, |of| enough.min(of));
            state.eta.set_passes(f64::from(end.saturating_sub(before)));
        }
    }

    /// What the phases so far took.
    pub fn phases(&self) -> Vec<Phase> {
        self.state().finished.clone()
    }

    /// Takes the bar away; says that all is done to who counts percents.
    pub fn end(&self) {
        self.bar.finish_and_clear();
        let mut state = self.state();
        state.percent = 100.0;
        if matches!(self.mode, Mode::Alf | Mode::Openjd | Mode::Json) {
            state.name = "done".to_owned();
            self.tell(&mut state, Some(0.0));
        }
    }

    /// Seconds since the start.
    fn now(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
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
        let (percent, left) = self.how_far(state);
        state.percent = state.percent.max(percent.min(100.0));
        self.tell(state, left);
    }

    /// Percent of the work, and seconds left if they are known.
    fn how_far(&self, state: &mut State) -> (f64, Option<f64>) {
        let elapsed = self.now();
        match self.whole {
            Whole::Passes => {
                let inside = if state.total > 0 { state.done as f64 / state.total as f64 } else { 0.0 };
                state.eta.advance(inside);
                let left = state.eta.left(elapsed);
                (left.map_or(0.0, |left| 100.0 * elapsed / (elapsed + left).max(1e-9)), left)
            }
            Whole::Steps(all) => {
                let all = all as f64;
                let whole = (state.skipped_steps + state.finished_steps + state.done) as f64 / all;
                let worked = whole - state.skipped_steps as f64 / all;
                let left = (worked > 0.0).then(|| elapsed * (1.0 - whole).max(0.0) / worked);
                (100.0 * whole, left)
            }
        }
    }

    fn tell(&self, state: &mut State, left: Option<f64>) {
        let (elapsed, percent) = (self.now(), state.percent);
        let eta = left.map_or_else(String::new, |s| format!(", about {} left", duration(s)));
        let pass = match state.passes {
            Passes { of: Some(of), ended, .. } if of > 1 => format!(", pass {} of {of}", (ended + 1).min(of)),
            Passes { of: None, ended, .. } if ended > 0 => format!(", pass {}", ended + 1),
            _ => String::new(),
        };
        // Nobody is left to be told when stderr or stdout is closed.
        let line = |text: String| drop(writeln!(io::stderr().lock(), "{text}"));
        match self.mode {
            Mode::Bar => {
                self.bar.set_position((percent / 100.0 * BAR_STEPS as f64) as u64);
                self.bar.set_message(format!("{percent:3.0} % {}{pass}{eta}", state.name));
            }
            Mode::Plain => line(format!("pdembree: {percent:.0} % {}{pass}, {}{eta}", state.name, duration(elapsed))),
            Mode::Json => line(
                json!({
                    "event": "progress", "phase": state.name, "done": state.done, "total": state.total,
                    "pass": state.passes.ended, "passes": state.passes.of,
                    "percent": percent, "elapsed_s": elapsed, "eta_s": left, "rss_bytes": memory::resident(),
                })
                .to_string(),
            ),
            Mode::Alf => self.tell_once(state, String::new(), |percent, _| format!("ALF_PROGRESS {percent}%\n")),
            Mode::Openjd => {
                let status = format!("{}{pass}", state.name);
                self.tell_once(state, status, |percent, status| {
                    format!("openjd_progress: {percent}.0\nopenjd_status: {status}\n")
                });
            }
            Mode::Auto | Mode::None => {}
        }
    }

    /// A line on stdout where the percent or the status is a new one.
    fn tell_once(&self, state: &mut State, status: String, text: impl Fn(u64, &str) -> String) {
        let now = (state.percent as u64, status);
        if state.last_told.as_ref() != Some(&now) {
            let mut stdout = io::stdout().lock();
            let _ = stdout.write_all(text(now.0, &now.1).as_bytes()).and_then(|()| stdout.flush());
            state.last_told = Some(now);
        }
    }
}

impl Progress for Reporter {
    fn phase(&self, name: &str, total: u64) {
        let now = self.now();
        let mut state = self.state();
        name.clone_into(&mut state.name);
        (state.done, state.total, state.phase_started) = (0, total, Instant::now());
        state.eta.phase(name, now);
        self.say(&mut state, true);
    }

    fn advance(&self, n: u64) {
        let mut state = self.state();
        state.done += n;
        self.say(&mut state, false);
    }

    fn finish(&self) {
        let now = self.now();
        let mut state = self.state();
        state.done = state.total;
        self.say(&mut state, true);
        state.eta.finish(now);
        let seconds = state.phase_started.elapsed().as_secs_f64();
        let name = std::mem::take(&mut state.name);
        match state.finished.iter_mut().find(|phase| phase.name == name) {
            Some(phase) => phase.seconds += seconds,
            None => state.finished.push(Phase { name, seconds }),
        }
        state.finished_steps += state.total;
        (state.done, state.total) = (0, 0);
    }

    fn skip(&self, n: u64) {
        self.state().skipped_steps += n;
    }
}

/// Bytes as one says them: `512 B`, `1.5 MiB`, `2.0 GiB`.
pub fn size(bytes: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let power = (bytes.max(1).ilog2() / 10).min(4);
    match power {
        0 => format!("{bytes} B"),
        power => format!("{:.1} {}", bytes as f64 / 1024f64.powi(power as i32), units[power as usize]),
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
