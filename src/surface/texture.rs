//! Texture lookups.

use super::mipmap::MipMap;
use super::normal_map::Image;
use super::parametrisation::Lookup;
use crate::math::Vec2;
use crate::radiometry::Spectrum;
use crate::scene::texture::{TextureError, TextureReport};
use crate::scene::{ImageTexture, TextureId, Textured};

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

    /// Why lookups are black that should not be, if their file failed.
    pub fn failure(&self) -> Option<&TextureError> {
        self.maps.iter().find_map(|map| map.memory().failure())
    }

    /// # Errors
    /// Lookups gave black that should not have.
    pub fn check(&self) -> Result<(), TextureError> {
        self.failure().map_or(Ok(()), |failure| Err(failure.clone()))
    }

    /// What they took; `None` where there are none. A scene's images share one memory.
    pub fn report(&self) -> Option<TextureReport> {
        self.maps.first().map(|map| map.memory().report())
    }

    /// A colour, filtered over the lookup's parallelogram.
    pub fn colour(&self, value: &Textured<Spectrum>, at: &Lookup) -> Spectrum {
        match value {
            Textured::Constant(c) => *c,
            Textured::Image { texture, factor } => *factor * self.maps[texture.index()].filtered(at.uv, at.footprint),
        }
    }

    /// An image at a point without a filter, and how it changes there: central differences over half a texel, between
    /// which it is all but linear.
    pub fn with_slopes(&self, texture: TextureId, uv: Vec2) -> Image {
        let map = &self.maps[texture.index()];
        let at = |uv: Vec2| map.filtered(uv, [Vec2::ZERO; 2]);
        let steps = map.texel_steps() * 0.25;
        let slope = |step: Vec2, length: f64| (at(uv + step) - at(uv - step)) * (0.5 / length);
        Image {
            colour: at(uv),
            du: slope(Vec2::new(steps.x, 0.0), steps.x),
            dv: slope(Vec2::new(0.0, steps.y), steps.y),
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
