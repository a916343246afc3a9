//! An image as it was decoded, before it has its place in memory or in a file.

use std::sync::Arc;

use super::samples::{Curve, Samples};
use super::{Texels, TextureError, TextureMemory};

/// Row 0 at the top.
#[derive(Clone, Debug)]
pub struct Raster {
    pub width: usize,
    pub height: usize,
    /// width · height texels, row by row from the top.
    pub samples: Samples,
    /// What bytes among them stand for.
    pub curve: Arc<Curve>,
}

impl Raster {
    pub fn of_bytes(width: usize, height: usize, samples: Samples, curve: Curve) -> Raster {
        Raster { width, height, samples, curve: Arc::new(curve) }
    }

    pub fn of_colours(width: usize, height: usize, colours: Vec<[f32; 3]>) -> Raster {
        Raster::of_numbers(width, height, Samples::of_colours(colours))
    }

    pub fn of_numbers(width: usize, height: usize, samples: Samples) -> Raster {
        Raster::of_bytes(width, height, samples, Curve::new(|_, byte| f32::from(byte) / 255.0))
    }

    /// All texels, row by row.
    pub fn texels(&self) -> impl Iterator<Item = [f32; 3]> {
        (0..self.samples.len()).map(|k| self.samples.texel(k, &self.curve))
    }

    /// One component in the place of all three.
    pub fn component(self, c: usize) -> Raster {
        let curve = Arc::new(self.curve.of_component(c));
        let samples = match self.samples {
            Samples::Bytes(all) => Samples::GreyBytes(all.iter().map(|texel| texel[c]).collect()),
            Samples::Colours(all) => Samples::Grey(all.iter().map(|texel| texel[c]).collect()),
            grey => grey,
        };
        Raster { samples, curve, ..self }
    }

    /// `f` of the component's number and its value, in each component of each texel.
    pub fn mapped(self, f: impl Fn(usize, f32) -> f32) -> Raster {
        let samples = match self.samples {
            bytes @ (Samples::GreyBytes(_) | Samples::Bytes(_)) => {
                return Raster { samples: bytes, curve: Arc::new(self.curve.mapped(f)), ..self };
            }
            numbers => numbers,
        };
        let colour = |k: usize| {
            let texel = samples.texel(k, &self.curve);
            [0, 1, 2].map(|c| f(c, texel[c]))
        };
        Raster::of_colours(self.width, self.height, (0..samples.len()).map(colour).collect())
    }

    /// In its place: whole where `memory` has room for it and its coarser levels, else in tiles of a file.
    ///
    /// # Errors
    /// The tiles cannot be written.
    pub fn placed(self, memory: &TextureMemory) -> Result<Texels, TextureError> {
        let texels = Texels::place(self, memory);
        memory.failure().map_or(Ok(texels), |failure| Err(failure.clone()))
    }
}
