//! A rectangle of pixels that one work unit fills.

use serde::{Deserialize, Serialize};

use super::exact::ExactSum;
use super::layer::EyeSample;
use super::layout::Layout;
use super::matte::Counts;
use super::refused::{Refused, RefusedSample, check_sample};

/// Pixels `x0 ≤ x < x1`, `y0 ≤ y < y1`; (0, 0) is the top left one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct PixelBounds {
    pub x0: u32,
    pub y0: u32,
    pub x1: u32,
    pub y1: u32,
}

impl PixelBounds {
    pub fn width(&self) -> u32 {
        self.x1 - self.x0
    }
    pub fn height(&self) -> u32 {
        self.y1 - self.y0
    }
    pub fn pixels(&self) -> usize {
        self.width() as usize * self.height() as usize
    }
    pub fn contains(&self, x: u32, y: u32) -> bool {
        (self.x0..self.x1).contains(&x) && (self.y0..self.y1).contains(&y)
    }
    pub fn contains_all(&self, other: &PixelBounds) -> bool {
        other.x0 >= self.x0 && other.x1 <= self.x1 && other.y0 >= self.y0 && other.y1 <= self.y1
    }
    pub fn overlaps(&self, other: &PixelBounds) -> bool {
        self.x0 < other.x1 && other.x0 < self.x1 && self.y0 < other.y1 && other.y0 < self.y1
    }
    /// The whole of a picture.
    pub fn whole([width, height]: [u32; 2]) -> PixelBounds {
        PixelBounds { x0: 0, y0: 0, x1: width, y1: height }
    }

    /// Cuts a picture of `width` × `height` into tiles of at most `size` × `size` pixels, row by row.
    pub fn tiles(width: u32, height: u32, size: u32) -> Vec<PixelBounds> {
        let size = size.max(1);
        let mut tiles = Vec::new();
        for y0 in (0..height).step_by(size as usize) {
            for x0 in (0..width).step_by(size as usize) {
                let (x1, y1) = (x0.saturating_add(size).min(width), y0.saturating_add(size).min(height));
                tiles.push(PixelBounds { x0, y0, x1, y1 });
            }
        }
        tiles
    }
}

/// Sums of the eye samples of one pass over a rectangle of pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    pub(super) bounds: PixelBounds,
    pub(super) pass: u32,
    pub(super) layout: Layout,
    /// Records of `layout.stride()` sums, row by row.
    pub(super) sums: Vec<ExactSum>,
    /// Samples taken, one number a pixel.
    pub(super) taken: Vec<u32>,
    /// Of each of the layout's mattes.
    pub(super) mattes: Vec<Vec<Counts>>,
    pub(super) refused: Refused,
}

impl Tile {
    pub fn new(layout: &Layout, bounds: PixelBounds, pass: u32) -> Tile {
        let pixels = bounds.pixels();
        Tile {
            bounds,
            pass,
            layout: layout.clone(),
            sums: vec![ExactSum::default(); pixels * layout.stride()],
            taken: vec![0; pixels],
            mattes: vec![vec![Counts::default(); pixels]; layout.mattes().len()],
            refused: Refused::default(),
        }
    }

    pub fn bounds(&self) -> PixelBounds {
        self.bounds
    }

    /// Adds one eye sample of pixel (x, y), which must lie in the tile. A sample with a number that is not finite, or
    /// with negative light, is refused as a whole and counted; the pixel is then the mean of its other samples.
    pub fn add(&mut self, x: u32, y: u32, sample: &EyeSample) {
        debug_assert!(self.bounds.contains(x, y), "pixel ({x}, {y}) outside {:?}", self.bounds);
        if let Err(cause) = check_sample(sample) {
            self.refused.record(RefusedSample { x, y, pass: self.pass, cause });
            return;
        }
        let pixel = (y - self.bounds.y0) as usize * self.bounds.width() as usize + (x - self.bounds.x0) as usize;
        let stride = self.layout.stride();
        let record = &mut self.sums[pixel * stride..(pixel + 1) * stride];
        self.taken[pixel] += 1;
        let [r, g, b] = sample.radiance().to_array();
        let coverage = if sample.depth.is_some() { 1.0 } else { 0.0 };
        for (sum, value) in record.iter_mut().zip([r, g, b, coverage]) {
            sum.add(value);
        }
        for (layer, offset) in self.layout.offsets() {
            let values = sample.values(layer);
            for (sum, value) in record[offset..].iter_mut().zip(&values[..layer.channels().len()]) {
                sum.add(*value);
            }
        }
        for (share, offset) in self.layout.shares() {
            for (sum, value) in record[offset..].iter_mut().zip(sample.of_group(share).to_array()) {
                sum.add(value);
            }
        }
        for (matte, pixels) in self.layout.mattes().iter().zip(&mut self.mattes) {
            if let Some(thing) = matte.met(sample) {
                pixels[pixel].add(thing);
            }
        }
    }
}
