//! How dense a medium is from place to place: a grid of samples over a box, a factor on the medium's coefficients.

use crate::math::Transform;

/// Samples at the centres of equal cells of a box. Outside of the box nothing is.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityGrid {
    /// From the unit cube, over which the grid lies, to the world.
    pub place: Transform,
    /// Cells along the cube's x, y and z.
    pub counts: [usize; 3],
    /// Without unit, finite and ≥ 0; x changes fastest, then y.
    pub samples: Vec<f32>,
    pub between: Interpolation,
}

/// What is between the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear from centre to centre along each axis; in the outermost half cells as at the nearest centre.
    Linear,
    /// Each cell is as its sample all over.
    Cells,
}

impl Interpolation {
    pub const NAMES: &'static [&'static str] = &["linear", "cells"];

    pub const fn name(self) -> &'static str {
        match self {
            Interpolation::Linear => "linear",
            Interpolation::Cells => "cells",
        }
    }

    pub fn from_name(name: &str) -> Option<Interpolation> {
        match name {
            "linear" => Some(Interpolation::Linear),
            "cells" => Some(Interpolation::Cells),
            _ => None,
        }
    }
}

impl DensityGrid {
    /// The sample of a cell; of one beside the grid that of the nearest.
    pub fn sample(&self, cell: [i64; 3]) -> f64 {
        let [x, y, z]: [usize; 3] = std::array::from_fn(|k| cell[k].clamp(0, self.counts[k] as i64 - 1) as usize);
        self.samples[(z * self.counts[1] + y) * self.counts[0] + x].into()
    }
}
