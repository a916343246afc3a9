//! Work units on all cores, results in unit order. The one place of the renderers that knows threads.
//!
//! A unit is a pure function of its number; its size never depends on the number of threads. Results are taken in
//! order, so every sum has the same bits on any number of threads.

use rayon::ThreadPoolBuildError;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use super::progress::Progress;

/// Units whose results wait for their turn at once; bounds memory, not results.
const BATCH: usize = 256;

/// Starts the program's threads: `wanted`, or one for each processor if 0. Returns how many there are. To be called
/// before any work.
///
/// # Errors
/// The system gives no threads, or they were started before.
pub fn start_threads(wanted: usize) -> Result<usize, ThreadPoolBuildError> {
    rayon::ThreadPoolBuilder::new().num_threads(wanted).build_global()?;
    Ok(rayon::current_num_threads())
}

/// Runs units 0..count and hands each result, in unit order, to `merge`.
pub fn run_in_order<T: Send>(
    count: usize,
    progress: &dyn Progress,
    unit: impl Fn(usize) -> T + Sync,
    mut merge: impl FnMut(T),
) {
    for start in (0..count).step_by(BATCH) {
        let batch = start..(start + BATCH).min(count);
        let results: Vec<T> = batch
            .into_par_iter()
            .map(|i| {
                let result = unit(i);
                progress.advance(1);
                result
            })
            .collect();
        results.into_iter().for_each(&mut merge);
    }
}

#[cfg(test)]
mod tests {
    use super::super::progress::Silent;
    use super::*;

    #[test]
    fn results_come_in_unit_order() {
        let mut seen = Vec::new();
        run_in_order(1000, &Silent, |i| i * i, |x| seen.push(x));
        assert!(seen.iter().enumerate().all(|(i, &x)| x == i * i) && seen.len() == 1000);
    }
}
