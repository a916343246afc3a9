//! A first pass that ends in time: it is begun, and given up for a smaller one where it would end too late.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use super::progress::Progress;
use super::watch::Watch;
use super::{Ended, RenderError, RenderState, go_on};
use crate::film::PixelBounds;
use crate::scene::RenderSettings;
use crate::world::World;

/// A pass is made smaller by this factor at most: its photons and its eye samples alike, so that whatever takes its time, a
/// part of it takes about that part of the time.
const MOST_PARTS: u32 = 16;

/// Sizes of passes between a whole and its half, in eighths; as many between the half and the quarter, and so on.
const EIGHTHS: [u32; 4] = [8, 7, 6, 5];

/// A part of a phase that says how long all of it takes: its units are spread over the whole.
const TELLING_PART: f64 = 1.0 / 16.0;

/// Time that a smaller pass is meant to take, of what is left: parts do not take quite their part of the time.
const MARGIN: f64 = 0.95;

/// Renders pass 0 of the whole picture, and leaves the world with the settings of passes of which one ends within `left`, or
/// with the smallest ones there are; their number is such that the whole has as many photons and samples. `given_up` hears of
/// each pass that was begun and would end too late: how long it would take, about. Where `watch` stops it, the pass is not whole.
pub fn render(
    world: &mut World,
    left: Duration,
    watch: &dyn Watch,
    mut given_up: impl FnMut(Duration),
) -> Result<RenderState, RenderError> {
    let (start, whole) = (Instant::now(), world.scene.settings.clone());
    let mut size = 1.0;
    loop {
        let left = left.saturating_sub(start.elapsed());
        let smaller: Vec<f64> = smaller_sizes(&whole).filter(|&other| other < size).collect();
        let trial = Trial::new(watch, (!smaller.is_empty()).then_some(left));
        let mut state = RenderState::new(world, PixelBounds::whole(world.scene.camera.resolution), 0);
        let ended = go_on(world, &mut state, &trial, |state| state.film.passes() == 0)?;
        let (Some(pass), Ended::Stopped, false) = (trial.late.get(), ended, watch.stop()) else {
            return Ok(state);
        };
        given_up(*pass);
        size = fitting(&smaller, size, *pass, left.saturating_sub(trial.start.elapsed()));
        world.scene.settings = part(&whole, size);
    }
}

/// The largest of the `smaller` sizes that ends within `left`, where one of `size` takes the time of `pass`.
fn fitting(smaller: &[f64], size: f64, pass: Duration, left: Duration) -> f64 {
    let in_time = |other: &f64| pass.mul_f64(other / size) <= left.mul_f64(MARGIN);
    smaller.iter().copied().find(in_time).or(smaller.last().copied()).unwrap_or(size)
}

/// Shares of a pass that are passes of their own, descending.
fn smaller_sizes(settings: &RenderSettings) -> impl Iterator<Item = f64> {
    let smallest = 1.0 / f64::from(settings.spp.clamp(1, MOST_PARTS));
    let sizes = (0..).flat_map(|halvings: u32| EIGHTHS.map(|eighths| f64::from(eighths) / f64::from(8u32 << halvings)));
    sizes.skip(1).take_while(move |&size| size >= smallest)
}

/// Settings of smaller passes, and of as many more.
fn part(whole: &RenderSettings, size: f64) -> RenderSettings {
    RenderSettings {
        photons: (whole.photons as f64 * size).ceil() as u64,
        spp: (f64::from(whole.spp) * size).round() as u32,
        passes: (f64::from(whole.passes) / size).ceil() as u32,
        ..whole.clone()
    }
}

/// Watches a pass, and stops it as soon as it is clear that it ends too late.
struct Trial<'a> {
    watch: &'a dyn Watch,
    start: Instant,
    /// From the start; `None`: the pass may take as long as it takes.
    limit: Option<Duration>,
    phase: Mutex<Phase>,
    /// How long the pass would take, about, if that is too long.
    late: OnceLock<Duration>,
}

/// The phase under way.
struct Phase {
    began: Instant,
    done: u64,
    total: u64,
}

impl<'a> Trial<'a> {
    fn new(watch: &'a dyn Watch, limit: Option<Duration>) -> Trial<'a> {
        let start = Instant::now();
        Trial {
            watch,
            start,
            limit,
            phase: Mutex::new(Phase { began: start, done: 0, total: 0 }),
            late: OnceLock::new(),
        }
    }

    fn phase(&self) -> MutexGuard<'_, Phase> {
        self.phase.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Phase {
    /// How long the whole phase takes, if it goes on like this, and the least that it may take: of few units the mean says
    /// little, and they may differ as much as their mean.
    fn expected(&self, so_far: Duration) -> [Duration; 2] {
        let (done, total) = (self.done as f64, self.total as f64);
        let doubt = if done >= total * TELLING_PART { 0.0 } else { (2.0 / done.sqrt()).min(1.0) };
        let all = so_far.mul_f64(total / done);
        [all, all.mul_f64(1.0 - doubt)]
    }
}

impl Progress for Trial<'_> {
    fn phase(&self, name: &str, total: u64) {
        *self.phase() = Phase { began: Instant::now(), done: 0, total };
        self.watch.phase(name, total);
    }
    fn advance(&self, n: u64) {
        let mut phase = self.phase();
        phase.done += n;
        if let Some(limit) = self.limit
            && phase.done > 0
        {
            // The phases that are still to come make it later still.
            let (before, so_far) = (phase.began - self.start, phase.began.elapsed());
            let [all, least] = phase.expected(so_far);
            if before + least > limit {
                // Only the first to say so counts.
                let _ = self.late.set(before + all);
            }
        }
        drop(phase);
        self.watch.advance(n);
    }
    fn finish(&self) {
        self.watch.finish();
    }
    fn skip(&self, n: u64) {
        self.watch.skip(n);
    }
}

impl Watch for Trial<'_> {
    fn stop(&self) -> bool {
        self.late.get().is_some() || self.watch.stop()
    }
    fn look(&self, state: &RenderState) {
        self.watch.look(state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_as_large_as_the_time_allows() {
        let whole = RenderSettings { photons: 1_000_000, spp: 16, passes: 1, ..RenderSettings::default() };
        let sizes: Vec<f64> = smaller_sizes(&whole).collect();
        let fit = |seconds: f64| {
            let settings =
                part(&whole, fitting(&sizes, 1.0, Duration::from_secs(16), Duration::from_secs_f64(seconds)));
            (settings.photons, settings.spp, settings.passes)
        };
        assert_eq!(fit(16.0 / MARGIN - 0.1), (875_000, 14, 2));
        assert_eq!(fit(12.0), (625_000, 10, 2));
        assert_eq!(fit(3.0 / MARGIN + 0.01), (187_500, 3, 6));
        assert_eq!(fit(0.0), (62_500, 1, 16));
        // A half that took longer than a half is made smaller from there.
        let smaller: Vec<f64> = sizes.into_iter().filter(|&size| size < 0.5).collect();
        assert_eq!(fitting(&smaller, 0.5, Duration::from_secs(10), Duration::from_secs(8)), 0.375);
    }

    #[test]
    fn no_pass_has_less_than_a_sample() {
        let of = |spp| smaller_sizes(&RenderSettings { spp, ..RenderSettings::default() }).collect::<Vec<f64>>();
        assert_eq!(of(1), [0.0; 0]);
        assert_eq!(of(3), [0.875, 0.75, 0.625, 0.5, 0.4375, 0.375]);
        assert_eq!((of(16).len(), of(16).last()), (16, Some(&0.0625)));
        assert_eq!(of(16), of(1000));
        let smallest =
            |spp| part(&RenderSettings { spp, ..RenderSettings::default() }, *of(spp).last().expect("a part"));
        assert!((2..100).all(|spp| smallest(spp).spp >= 1));
    }

    #[test]
    fn a_few_units_say_less_than_a_sixteenth() {
        let expected = |done, total| {
            let phase = Phase { began: Instant::now(), done, total };
            phase.expected(Duration::from_secs(1)).map(|time| time.as_secs_f64())
        };
        assert_eq!(expected(2, 1000), [500.0, 0.0]);
        assert_eq!(expected(16, 1600), [100.0, 50.0]);
        assert_eq!(expected(100, 1600), [16.0, 16.0]);
        assert_eq!(expected(1, 4), [4.0, 4.0]);
    }
}
