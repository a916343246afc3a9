//! What the samples of one pixel start from: numbers that fill their squares evenly, pair by pair.
//!
//! Every pair goes through the golden lattice of as many points as the pixel has samples, each pair in an order of its
//! own and moved by its own random shift: any one sample is uniform and independent from pair to pair, so estimates are
//! unbiased, and all of them together lie nowhere close and leave no hole.

use super::qmc;
use super::{Purpose, Stream};

const PAIRS: usize = 5;

/// The samples of one pixel in one pass.
#[derive(Clone, Debug)]
pub struct PixelSamples {
    samples: u64,
    shifts: [[f64; 2]; PAIRS],
    /// Each pair's order, by what a sample's number is multiplied with.
    units: [u64; PAIRS],
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

impl PixelSamples {
    /// Of `samples` > 0 in the pixel numbered `pixel`.
    pub fn new(seed: u64, pass: u32, pixel: u64, samples: u32) -> PixelSamples {
        let mut stream = PixelSamples::stream_of(seed, pass, pixel, 0);
        let samples = samples.into();
        let units = std::array::from_fn(|k| qmc::unit(samples, k as u64));
        PixelSamples { samples, shifts: std::array::from_fn(|_| stream.uniform2()), units }
    }

    /// When sample `i` of `samples` is taken, as a share of the shutter's interval: each in a part of its own. Only pictures
    /// of what moves ask.
    pub fn time(seed: u64, pass: u32, pixel: u64, samples: u32, i: u32) -> f64 {
        // Behind the numbers of the pairs.
        let mut stream = PixelSamples::stream_of(seed, pass, pixel, 0);
        for _ in 0..PAIRS {
            stream.uniform2();
        }
        let place = qmc::reordered(i.into(), samples.into(), PAIRS as u64);
        (place as f64 + stream.uniform()) / f64::from(samples)
    }

    /// The random numbers of sample `i`'s own path, for all that comes after.
    pub fn stream(seed: u64, pass: u32, pixel: u64, i: u32) -> Stream {
        PixelSamples::stream_of(seed, pass, pixel, u64::from(i) + 1)
    }

    /// Stream 0 of a pixel's own range belongs to all of its samples.
    fn stream_of(seed: u64, pass: u32, pixel: u64, k: u64) -> Stream {
        Stream::new(seed, Purpose::Camera, pass, pixel << 24 | k)
    }

    pub fn get(&self, i: u32) -> PixelSample {
        let [raster, lens, light, bounce, choices] = std::array::from_fn(|k| {
            let place = u64::from(i) * self.units[k] % self.samples;
            qmc::shifted(qmc::golden_lattice(place, self.samples), self.shifts[k])
        });
        PixelSample { raster, lens, light, bounce, choices }
    }
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
            let numbers = |pixel| {
                let s = PixelSamples::new(3, 0, pixel, samples).get(i);
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
        let pixel = PixelSamples::new(3, 0, 5, 16);
        let samples: Vec<PixelSample> = (0..16).map(|i| pixel.get(i)).collect();
        let pairs: [fn(&PixelSample) -> [f64; 2]; 5] =
            [|s| s.raster, |s| s.lens, |s| s.light, |s| s.bounce, |s| s.choices];
        for pair in pairs {
            for axis in 0..2 {
                let mut x: Vec<f64> = samples.iter().map(|s| pair(s)[axis]).collect();
                x.sort_by(f64::total_cmp);
                let widest = x.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
                assert!(widest < 2.7 / 16.0, "a gap of {widest} in {x:?}");
            }
        }
    }
}
