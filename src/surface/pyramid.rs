//! Levels of an image pyramid: each averages the one below over about 2×2 texels · `[Williams83]`.

use crate::math::{Vec2, Vec3};
use crate::scene::texture::{Cursor, Texels, TextureMemory};

/// An image of the pyramid, row 0 at the top.
#[derive(Clone, Debug)]
pub struct Level {
    pub width: usize,
    pub height: usize,
    /// Texels of the finest level to one of this, across and down.
    pub scale: Vec2,
    texels: Texels,
}

impl Level {
    /// The image itself, which it shares.
    pub fn finest(texels: &Texels) -> Level {
        Level { width: texels.width(), height: texels.height(), scale: Vec2::ONE, texels: texels.clone() }
    }

    /// Half as wide and high, odd sizes rounded down; `None` after a single texel. Every texel is the mean over its own
    /// part of the image, so the mean of the image is the same on all levels.
    pub fn coarser(&self) -> Option<Level> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let columns: Vec<_> = (0..width).map(|i| overlaps(i, width, self.width)).collect();
        let mut texels = Vec::with_capacity(width * height);
        let (mut finer, mut sums) = (self.texels.rows(), vec![Vec3::ZERO; width]);
        for j in 0..height {
            sums.fill(Vec3::ZERO);
            for (y, wy) in overlaps(j, height, self.height) {
                let row = finer.row(y);
                for (sum, column) in sums.iter_mut().zip(&columns) {
                    for &(x, wx) in column {
                        *sum += wx * wy * wide(row[x]);
                    }
                }
            }
            texels.extend(sums.iter().map(|sum| sum.to_array().map(|x| x as f32)));
        }
        let shrink = Vec2::new(self.width as f64 / width as f64, self.height as f64 / height as f64);
        Some(Level { width, height, scale: self.scale * shrink, texels: self.texels.coarser(width, height, texels) })
    }

    pub fn memory(&self) -> &TextureMemory {
        self.texels.memory()
    }

    /// For texels close together.
    pub fn cursor(&self) -> Cursor<'_> {
        self.texels.cursor()
    }

    /// Of the whole level, which is what its only texel holds on the coarsest.
    pub fn mean(&self) -> [f64; 3] {
        let mut rows = self.texels.rows();
        let mut sum = Vec3::ZERO;
        for j in 0..self.height {
            for texel in rows.row(j) {
                sum += wide(*texel);
            }
        }
        (sum / self.texels.len() as f64).to_array()
    }
}

pub fn wide(texel: [f32; 3]) -> Vec3 {
    Vec3::from_array(texel.map(f64::from))
}

/// The texels of `n` that the `i`th of `m` ≤ n equal parts covers, with their shares of it.
fn overlaps(i: usize, m: usize, n: usize) -> Vec<(usize, f64)> {
    // In units of 1/m of a texel, where all borders are whole numbers.
    let (from, to) = (i * n, (i + 1) * n);
    (from / m..to.div_ceil(m))
        .map(|k| (k, ((k + 1) * m).min(to) - (k * m).max(from)))
        .map(|(k, covered)| (k, covered as f64 / n as f64))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Purpose, Stream};

    #[test]
    fn parts_share_the_texels_without_gap() {
        for (m, n) in [(1, 1), (1, 3), (2, 5), (3, 7), (4, 8)] {
            let mut covered = vec![0.0; n];
            for i in 0..m {
                let part = overlaps(i, m, n);
                assert!((part.iter().map(|p| p.1).sum::<f64>() - 1.0).abs() < 1e-15);
                part.iter().for_each(|&(k, share)| covered[k] += share * n as f64 / m as f64);
            }
            assert!(covered.iter().all(|c| (c - 1.0).abs() < 1e-14), "{m} of {n}: {covered:?}");
        }
    }

    #[test]
    fn every_level_has_the_mean_of_the_image() {
        let (width, height) = (13, 6);
        let mut stream = Stream::new(1, Purpose::Test, 0, 0);
        let texels = (0..width * height).map(|_| [0; 3].map(|_: i32| stream.uniform() as f32)).collect();
        let mut level = Level::finest(&Texels::new(width, height, texels));
        let mean = level.mean();
        let mut sizes = vec![(width, height)];
        while let Some(coarser) = level.coarser() {
            level = coarser;
            sizes.push((level.width, level.height));
            assert!((level.scale - Vec2::new(13.0 / level.width as f64, 6.0 / level.height as f64)).length() < 1e-12);
            // Texels are rounded to f32.
            level.mean().iter().zip(mean).for_each(|(a, b)| assert!((a - b).abs() < 1e-6, "{level:?}"));
        }
        assert_eq!(sizes, [(13, 6), (6, 3), (3, 1), (1, 1)]);
    }
}
