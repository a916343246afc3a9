//! What the samples of one pixel start from: numbers that fill their squares evenly, pair by pair.
//!
//! The samples divide the square into as many rows and as many columns, one sample in each, in the order of the golden
//! lattice, so that they lie nowhere close and leave no hole. Every pair goes through it in an order of its own, moved by
//! whole rows and columns at random, and every sample has its own random place in its row and column. Any one sample is
//! uniform and independent from pair to pair, so estimates are unbiased. A lattice moved as a whole would be as even, but all
//! of its points would err to the same side: of a slope along one side of the square n points have the mean with an error
//! of 1/(√12 n), and in rows of their own with 1/(√12 n^{3/2}).

use super::discrete::BELOW_ONE;
use super::qmc;
use super::{Purpose, Stream};

const PAIRS: usize = 5;

/// How the samples of any pixel lie in rows and columns.
#[derive(Clone, Debug)]
pub struct PixelPattern {
    samples: u32,
    /// Of a point of the golden lattice, by its column.
    rows: Vec<u32>,
    /// Each pair's order, by what a sample's number is multiplied with.
    units: [u64; PAIRS],
}

/// The samples of one pixel in one pass.
#[derive(Clone, Debug)]
pub struct PixelSamples<'a> {
    pattern: &'a PixelPattern,
    seed: u64,
    pass: u32,
    pixel: u64,
    /// By how many columns and rows each pair's points are moved.
    shifts: [[u32; 2]; PAIRS],
    /// Behind the numbers of the shifts.
    times: Stream,
}

/// Numbers of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelSample {
    /// Where in the pixel.
    pub raster: [f64; 2],
    /// Where on the lens.
    pub lens: [f64; 2],
    /// Where on a light, at the first vertex that scatters.
    pub light: [f64; 2],
    /// Whither from there.
    pub bounce: [f64; 2],
    /// Which light and which lobe there.
    pub choices: [f64; 2],
}

impl PixelPattern {
    /// Of `samples` > 0 in a pixel.
    pub fn new(samples: u32) -> PixelPattern {
        let n = u64::from(samples);
        let mut upwards: Vec<u32> = (0..samples).collect();
        upwards.sort_by(|&a, &b| {
            let height = |i: u32| qmc::golden_lattice(i.into(), n)[1];
            height(a).total_cmp(&height(b))
        });
        let mut rows = vec![0; samples as usize];
        for (row, &column) in upwards.iter().enumerate() {
            rows[column as usize] = row as u32;
        }
        PixelPattern { samples, rows, units: std::array::from_fn(|k| qmc::unit(n, k as u64)) }
    }

    /// The samples of the pixel numbered `pixel`.
    pub fn of(&self, seed: u64, pass: u32, pixel: u64) -> PixelSamples<'_> {
        let mut stream = stream_of(seed, pass, pixel, 0);
        let cell = |u: f64| (u * f64::from(self.samples)) as u32;
        let shifts = std::array::from_fn(|_| stream.uniform2().map(cell));
        PixelSamples { pattern: self, seed, pass, pixel, shifts, times: stream }
    }
}

impl PixelSamples<'_> {
    /// When sample `i` is taken, as a share of the shutter's interval: each in a part of its own. Only pictures of what moves
    /// ask.
    pub fn time(&self, i: u32) -> f64 {
        let samples = self.pattern.samples;
        let place = qmc::reordered(i.into(), samples.into(), PAIRS as u64);
        (place as f64 + self.times.clone().uniform()) / f64::from(samples)
    }

    /// Sample `i`, and the random numbers of its own path for all that comes after.
    pub fn get(&self, i: u32) -> (PixelSample, Stream) {
        let mut stream = stream_of(self.seed, self.pass, self.pixel, u64::from(i) + 1);
        let [raster, lens, light, bounce, choices] = std::array::from_fn(|k| self.place(i, k, stream.uniform2()));
        (PixelSample { raster, lens, light, bounce, choices }, stream)
    }

    /// Where sample `i` lies in the square of pair `k`, at `offset` in [0, 1)² in its column and row.
    fn place(&self, i: u32, k: usize, offset: [f64; 2]) -> [f64; 2] {
        let n = self.pattern.samples;
        let column = (u64::from(i) * self.pattern.units[k] % u64::from(n)) as u32;
        let cell = [column, self.pattern.rows[column as usize]];
        std::array::from_fn(|axis| {
            let moved = (u64::from(cell[axis]) + u64::from(self.shifts[k][axis])) % u64::from(n);
            ((moved as f64 + offset[axis]) / f64::from(n)).min(BELOW_ONE)
        })
    }
}

/// Stream 0 of a pixel's own range belongs to all of its samples.
fn stream_of(seed: u64, pass: u32, pixel: u64, k: u64) -> Stream {
    Stream::new(seed, Purpose::Camera, pass, pixel << 24 | k)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every sample alone is uniform in each of its numbers, and independent from pair to pair: means, second moments and
    /// products over many pixels, within five standard errors.
    #[test]
    fn each_sample_is_uniform_and_pairs_are_independent() {
        const PIXELS: u64 = 20_000;
        for (samples, i) in [(1, 0), (16, 0), (16, 7), (5, 4)] {
            let pattern = PixelPattern::new(samples);
            let numbers = |pixel| {
                let s = pattern.of(3, 0, pixel).get(i).0;
                [s.raster, s.lens, s.light, s.bounce, s.choices].concat()
            };
            let all: Vec<Vec<f64>> = (0..PIXELS).map(numbers).collect();
            let mean = |f: &dyn Fn(&[f64]) -> f64| all.iter().map(|x| f(x)).sum::<f64>() / PIXELS as f64;
            let error = |variance: f64| 5.0 * (variance / PIXELS as f64).sqrt();
            for a in 0..10 {
                assert!((mean(&|x| x[a]) - 0.5).abs() < error(1.0 / 12.0));
                assert!((mean(&|x| x[a] * x[a]) - 1.0 / 3.0).abs() < error(4.0 / 45.0));
                for b in 0..a {
                    assert!((mean(&|x| (x[a] - 0.5) * (x[b] - 0.5))).abs() < error(1.0 / 144.0), "{a} {b}");
                }
            }
        }
    }

    /// The samples of a pixel together: each pair's 16 points lie in 16 different rows and 16 different columns.
    #[test]
    fn all_samples_together_are_even() {
        let pattern = PixelPattern::new(16);
        let pixel = pattern.of(3, 0, 5);
        let samples: Vec<PixelSample> = (0..16).map(|i| pixel.get(i).0).collect();
        let pairs: [fn(&PixelSample) -> [f64; 2]; 5] =
            [|s| s.raster, |s| s.lens, |s| s.light, |s| s.bounce, |s| s.choices];
        for pair in pairs {
            for axis in 0..2 {
                let mut cells: Vec<u32> = samples.iter().map(|s| (pair(s)[axis] * 16.0) as u32).collect();
                cells.sort_unstable();
                assert!(cells.iter().copied().eq(0..16), "{cells:?}");
            }
        }
    }

    /// The mean over n samples of each of a pair's numbers has the variance 1/(12 n³), within five standard errors: of n
    /// independent places in rows of 1/n. A lattice moved as a whole has 1/(12 n²).
    #[test]
    fn the_mean_of_a_slope_errs_by_the_places_in_the_rows_alone() {
        const PIXELS: u64 = 4000;
        for n in [1u32, 5, 16] {
            let pattern = PixelPattern::new(n);
            for axis in 0..2 {
                let mean = |pixel| {
                    let samples = pattern.of(7, 0, pixel);
                    (0..n).map(|i| samples.get(i).0.light[axis]).sum::<f64>() / f64::from(n)
                };
                let variance = (0..PIXELS).map(|pixel| (mean(pixel) - 0.5).powi(2)).sum::<f64>() / PIXELS as f64;
                let expected = 1.0 / (12.0 * f64::from(n).powi(3));
                // Of a sum of uniform numbers the fourth moment is less than the normal distribution's 3σ⁴.
                let error = expected * (2.0 / PIXELS as f64).sqrt();
                assert!((variance - expected).abs() < 5.0 * error, "n={n}: {variance} for {expected}");
            }
        }
    }
}
