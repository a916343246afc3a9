//! Image textures and parameters that may be textured.

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

/// A decoded image in linear Rec.709, row 0 at the top; texture coordinate v = 0 is the bottom row's lower edge.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageTexture {
    pub width: usize,
    pub height: usize,
    /// width · height texels, row by row from the top.
    pub texels: Vec<[f32; 3]>,
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
