//! Texture lookups.

use super::mipmap::MipMap;
use crate::math::Vec2;
use crate::radiometry::Spectrum;
use crate::scene::{ImageTexture, Textured};

/// All image textures of a scene, prepared once and shared by every thread.
#[derive(Clone, Debug)]
pub struct Textures {
    maps: Vec<MipMap>,
}

impl Textures {
    /// In the order of `Scene::textures`.
    pub fn new(images: &[ImageTexture]) -> Textures {
        Textures { maps: images.iter().map(MipMap::new).collect() }
    }

    /// A colour at `uv`, filtered over the parallelogram of `footprint` = (∂uv/∂x, ∂uv/∂y).
    pub fn colour(&self, value: &Textured<Spectrum>, uv: Vec2, footprint: [Vec2; 2]) -> Spectrum {
        match value {
            Textured::Constant(c) => *c,
            Textured::Image { texture, factor } => *factor * self.maps[texture.index()].filtered(uv, footprint),
        }
    }

    /// A number at `uv`: the mean of the image's three components.
    pub fn number(&self, value: &Textured<f64>, uv: Vec2, footprint: [Vec2; 2]) -> f64 {
        match value {
            Textured::Constant(x) => *x,
            Textured::Image { texture, factor } => *factor * self.maps[texture.index()].filtered(uv, footprint).mean(),
        }
    }
}
