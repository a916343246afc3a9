//! The whole picture's sums, and the means they stand for.

use super::image::{Channel, Image};
use super::layer::{BEAUTY, Layout};
use super::refused::Refused;
use super::splat::SplatBuffer;
use super::tile::Tile;
use crate::scene::settings::Layer;

/// `f64` sums per pixel and layer over all passes so far.
///
/// A picture's value is (sum of eye samples) / (samples taken) + (sum of splats) / (passes); with the same number of
/// samples in every pass that is the mean of the passes.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    layout: Layout,
    sums: Vec<f64>,
    taken: Vec<u64>,
    /// Same records as `sums`; empty until the first splat.
    splats: Vec<f64>,
    passes: u32,
    refused: Refused,
}

impl Film {
    pub fn new(width: u32, height: u32, layers: &[Layer]) -> Film {
        let layout = Layout::new(layers);
        let pixels = width as usize * height as usize;
        Film {
            width,
            height,
            sums: vec![0.0; pixels * layout.stride()],
            layout,
            taken: vec![0; pixels],
            splats: Vec::new(),
            passes: 0,
            refused: Refused::default(),
        }
    }

    pub fn width(&self) -> u32 {
        self.width
    }
    pub fn height(&self) -> u32 {
        self.height
    }
    pub fn layout(&self) -> &Layout {
        &self.layout
    }
    /// Passes that were ended, and so the number of the one under way.
    pub fn passes(&self) -> u32 {
        self.passes
    }
    pub fn refused(&self) -> &Refused {
        &self.refused
    }

    /// Adds a unit's tile. Call in unit order: the sum of floating-point numbers depends on it.
    pub fn add_tile(&mut self, tile: &Tile) {
        assert_eq!(tile.layout, self.layout, "tiles are made from their film's layout");
        let stride = self.layout.stride();
        let (row, bounds) = (tile.bounds.width() as usize, tile.bounds);
        for (line, y) in (bounds.y0..bounds.y1).enumerate() {
            let to = y as usize * self.width as usize + bounds.x0 as usize;
            let from = line * row;
            for (sum, value) in self.sums[to * stride..(to + row) * stride].iter_mut().zip(&tile.sums[from * stride..])
            {
                *sum += value;
            }
            for (sum, value) in self.taken[to..to + row].iter_mut().zip(&tile.taken[from..]) {
                *sum += u64::from(*value);
            }
        }
        self.refused.merge(&tile.refused);
    }

    /// Adds a unit's splats. Call in unit order.
    pub fn add_splats(&mut self, buffer: &SplatBuffer) {
        self.refused.merge(&buffer.refused);
        if buffer.splats.is_empty() {
            return;
        }
        let stride = self.layout.stride();
        if self.splats.is_empty() {
            self.splats = vec![0.0; self.sums.len()];
        }
        for splat in &buffer.splats {
            let record = &mut self.splats[splat.pixel as usize * stride..][..stride];
            let value = splat.value.to_array();
            for (sum, v) in record.iter_mut().zip(value) {
                *sum += v;
            }
            if let Some((_, offset)) = self.layout.offsets().find(|&(layer, _)| layer == splat.part) {
                for (sum, v) in record[offset..].iter_mut().zip(value) {
                    *sum += v;
                }
            }
        }
    }

    /// Ends a pass: what is added from now on belongs to the next one.
    pub fn end_pass(&mut self) {
        self.passes += 1;
    }

    /// The picture so far. Before the first pass ends it counts as one, so that a partial picture has its right scale.
    pub fn resolve(&self) -> Image {
        let stride = self.layout.stride();
        let depth = self.layout.offsets().find(|&(layer, _)| layer == Layer::Depth).map(|(_, offset)| offset);
        let passes = f64::from(self.passes.max(1));
        let channels = self.layout.channel_names().enumerate().map(|(place, name)| {
            let value = |pixel: usize| {
                let record = pixel * stride;
                // Depth is the mean over the samples that hit: the sum of coverages.
                let count = if depth == Some(place) { self.sums[record + ALPHA] } else { self.taken[pixel] as f64 };
                let mean = if count > 0.0 { self.sums[record + place] / count } else { 0.0 };
                let splat = self.splats.get(record + place).map_or(0.0, |sum| sum / passes);
                (mean + splat) as f32
            };
            Channel { name: name.to_owned(), samples: (0..self.taken.len()).map(value).collect() }
        });
        Image { width: self.width, height: self.height, channels: channels.collect() }
    }
}

/// Place of the coverage in a record.
const ALPHA: usize = BEAUTY.len() - 1;
