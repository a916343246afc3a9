//! Work units on all cores. The one place of the renderers that knows threads.
//!
//! A unit is a pure function of its number; its size never depends on the number of threads. Results are handed over as
//! they come: whoever adds them up must not depend on the order, and the film's exact sums do not.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;

pub use rayon::ThreadPoolBuildError as NoThread;

use super::watch::{Stopped, Watch};

/// The program's threads.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// Runs `work` on one thread, whatever the program's number is.
///
/// # Errors
/// The system gives no thread.
pub fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, NoThread> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(1).build()?.install(work))
}

/// Results that may wait for their turn, for each thread; bounds memory, not results.
const WAITING: usize = 4;

/// Starts the program's threads: `wanted`, or one for each processor if 0. Returns how many there are. To be called
/// before any work.
///
/// # Errors
/// The system gives no threads, or they were started before.
pub fn start_threads(wanted: usize) -> Result<usize, NoThread> {
    rayon::ThreadPoolBuilder::new().num_threads(wanted).build_global()?;
    Ok(rayon::current_num_threads())
}

/// Runs `units` and hands each number and result to `take`, on the calling thread.
///
/// # Errors
/// `watch` asked to stop: units that were begun are finished and taken, the rest is not.
pub fn run_units<T: Send>(
    units: &[usize],
    watch: &dyn Watch,
    unit: impl Fn(usize) -> T + Sync,
    mut take: impl FnMut(usize, T),
) -> Result<(), Stopped> {
    let next = AtomicUsize::new(0);
    let draw = || {
        let number = *units.get(next.fetch_add(1, Ordering::Relaxed))?;
        (!watch.stop()).then_some(number)
    };
    let mut taken = 0;
    let mut count = |number, result| {
        take(number, result);
        watch.advance(1);
        taken += 1;
    };
    if rayon::current_thread_index().is_some() {
        // A worker that waited for others could wait for itself.
        while let Some(number) = draw() {
            count(number, unit(number));
        }
    } else {
        let threads = rayon::current_num_threads();
        rayon::in_place_scope(|scope| {
            let (results, taker) = sync_channel(WAITING * threads);
            for _ in 0..threads.min(units.len()) {
                let (results, draw, unit) = (results.clone(), &draw, &unit);
                scope.spawn(move |_| {
                    while let Some(number) = draw() {
                        if results.send((number, unit(number))).is_err() {
                            return;
                        }
                    }
                });
            }
            drop(results);
            taker.into_iter().for_each(|(number, result)| count(number, result));
        });
    }
    if taken == units.len() { Ok(()) } else { Err(Stopped) }
}

/// Runs units 0 … count − 1, and gives their results in unit order.
///
/// # Errors
/// `watch` asked to stop.
pub fn collect_units<T: Send>(
    count: usize,
    watch: &dyn Watch,
    unit: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>, Stopped> {
    let mut results: Vec<Option<T>> = (0..count).map(|_| None).collect();
    run_units(&scattered(count), watch, unit, |i, result| results[i] = Some(result))?;
    Ok(results.into_iter().flatten().collect())
}

/// 0 … count − 1 so that any run of them is spread over all: the first tenth of the work says how long the rest will
/// take, and a picture under way can be judged.
pub fn scattered(count: usize) -> Vec<usize> {
    /// 2⁶⁴ over the golden ratio.
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&i| (i as u64).wrapping_mul(GOLDEN));
    order
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::render::progress::{Progress, Silent};
    use crate::render::watch::Unattended;

    #[test]
    fn every_unit_is_taken_once() {
        let units = scattered(1000);
        let mut seen = vec![0; 1000];
        let done = run_units(&units, &Unattended(&Silent), |i| i * i, |i, x| seen[i] += usize::from(x == i * i));
        assert!(done.is_ok() && seen.iter().all(|&n| n == 1));
        // From inside the pool too.
        let inside = rayon::scope(|_| {
            let mut sum = 0;
            run_units(&units, &Unattended(&Silent), |i| i, |_, x| sum += x).map(|()| sum)
        });
        assert_eq!(inside.ok(), Some(999 * 500));
        let squares = collect_units(1000, &Unattended(&Silent), |i| i * i);
        assert_eq!(squares, Ok((0..1000).map(|i| i * i).collect()));
        // A tenth of the numbers lies everywhere.
        let mut tenth: Vec<usize> = units[..100].to_vec();
        tenth.sort_unstable();
        assert!(tenth.windows(2).all(|w| w[1] - w[0] < 25), "{tenth:?}");
    }

    /// Stops when asked, after the units that were begun.
    struct StopAfter(usize, AtomicUsize, AtomicBool);

    impl Progress for StopAfter {
        fn phase(&self, _name: &str, _total: u64) {}
        fn advance(&self, n: u64) {
            let done = self.1.fetch_add(n as usize, Ordering::Relaxed) + n as usize;
            self.2.fetch_or(done >= self.0, Ordering::Relaxed);
        }
        fn finish(&self) {}
        fn skip(&self, _n: u64) {}
    }
    impl Watch for StopAfter {
        fn stop(&self) -> bool {
            self.2.load(Ordering::Relaxed)
        }
    }

    #[test]
    fn a_stopped_run_says_so_and_what_was_begun_is_taken() {
        let watch = StopAfter(10, AtomicUsize::new(0), AtomicBool::new(false));
        let begun = AtomicUsize::new(0);
        let mut taken = 0;
        let units: Vec<usize> = (0..100_000).collect();
        let unit = |_| begun.fetch_add(1, Ordering::Relaxed);
        let stopped = run_units(&units, &watch, unit, |_, _| taken += 1);
        assert!(stopped.is_err() && taken >= 10 && taken < units.len(), "{taken}");
        assert_eq!(taken, begun.into_inner());
    }
}
