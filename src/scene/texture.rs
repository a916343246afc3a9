//! Image textures and parameters that may be textured.

mod memory;
mod raster;
mod samples;
mod texels;

pub use memory::{TextureError, TextureMemory, TextureReport};
pub use raster::Raster;
pub use samples::{Curve, Samples};
pub use texels::{Cursor, Rows, Texels};

use super::ids::TextureId;

/// A constant or an image times a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Textured<T> {
    Constant(T),
    Image { texture: TextureId, factor: T },
}

/// What happens beyond [0, 1]².
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    Repeat,
    Clamp,
    Mirror,
}

/// A decoded image; texture coordinate v = 0 is the bottom row's lower edge. A clone shares the texels.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageTexture {
    pub texels: Texels,
    /// Across and up.
    pub wrap: [Wrap; 2],
    pub placement: Placement,
}

/// Where an image lies among texture coordinates: it is looked up at M (u, v) + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Rows of [M | t].
    pub rows: [[f64; 3]; 2],
}

impl Placement {
    /// On [0, 1]².
    pub const IDENTITY: Placement = Placement { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
}
