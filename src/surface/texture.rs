//! Texture lookups.

use super::mipmap::MipMap;
use super::parametrisation::Lookup;
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

    /// A colour, filtered over the lookup's parallelogram.
    pub fn colour(&self, value: &Textured<Spectrum>, at: &Lookup) -> Spectrum {
        match value {
            Textured::Constant(c) => *c,
            Textured::Image { texture, factor } => *factor * self.maps[texture.index()].filtered(at.uv, at.footprint),
        }
    }

    /// A number: the mean of the image's three components.
    pub fn number(&self, value: &Textured<f64>, at: &Lookup) -> f64 {
        match value {
            Textured::Constant(x) => *x,
            Textured::Image { texture, factor } => {
                *factor * self.maps[texture.index()].filtered(at.uv, at.footprint).mean()
            }
        }
    }
}
