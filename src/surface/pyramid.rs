//! Levels of an image pyramid: each averages the one below over about 2×2 texels · `[Williams83]`.

use crate::math::{Vec2, Vec3};
use crate::scene::ImageTexture;

/// An image of the pyramid, row 0 at the top.
#[derive(Clone, Debug)]
pub struct Level {
    pub width: usize,
    pub height: usize,
    /// Texels of the finest level to one of this, across and down.
    pub scale: Vec2,
    texels: Vec<[f32; 3]>,
}

impl Level {
    pub fn finest(image: &ImageTexture) -> Level {
        let texels = image.texels.clone();
        Level { width: image.width, height: image.height, scale: Vec2::ONE, texels }
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
        for j in 0..height {
            let rows = overlaps(j, height, self.height);
            for column in &columns {
                let mut sum = Vec3::ZERO;
                for &(y, wy) in &rows {
                    for &(x, wx) in column {
                        sum += wx * wy * self.texel(x, y);
                    }
                }
                texels.push(sum.to_array().map(|x| x as f32));
            }
        }
        let shrink = Vec2::new(self.width as f64 / width as f64, self.height as f64 / height as f64);
        Some(Level { width, height, scale: self.scale * shrink, texels })
    }

    /// Indices inside the image.
    pub fn texel(&self, i: usize, j: usize) -> Vec3 {
        wide(self.texels[j * self.width + i])
    }

    /// Of the whole level, which is what its only texel holds on the coarsest.
    pub fn mean(&self) -> [f64; 3] {
        let sum: Vec3 = self.texels.iter().copied().map(wide).sum();
        (sum / self.texels.len() as f64).to_array()
    }
}

fn wide(texel: [f32; 3]) -> Vec3 {
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
    use crate::scene::texture::{Placement, Wrap};

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
        let image = ImageTexture { width, height, texels, wrap: [Wrap::Repeat; 2], placement: Placement::IDENTITY };
        let mut level = Level::finest(&image);
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
