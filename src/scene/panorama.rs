//! An image of what lies infinitely far away around the scene · W/(m²·sr) · world frame.
//!
//! Every texel has one radiance, the same all over it: so what the eye sees is what is drawn from.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use super::texture::ImageTexture;
use crate::math::Dir3;
use crate::radiometry::Spectrum;

/// A texel is bright if it outshines the mean of the sphere so many times; at most as small a part of the sphere is.
const BRIGHT: f64 = 32.0;
/// What is bright is a light of its own if it holds that much of the whole.
const WORTH_A_LIGHT: f64 = 0.01;

/// How an image covers the sphere. Its rows run from the top; either map preserves areas in coordinates (s, t) of the unit
/// square, s across and t downwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Columns are longitudes, rows latitudes from the pole on +z downwards: t = (1 − cos θ)/2. The middle of the image is +x,
    /// to the left of it lies +y.
    LatLong,
    /// The square folded up to an octahedron `[Clarberg08]`; pbrt's: +z in the middle, −z at the corners, s along x, t along y.
    Octahedral,
}

/// Which texels count, by their luminance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    All,
    Above(f64),
    UpTo(f64),
}

/// An image, where it is and which part of it is meant.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    pub image: Arc<ImageTexture>,
    pub projection: Projection,
    /// Where the map's x, y, z are: perpendicular, of either handedness.
    pub axes: [Dir3; 3],
    /// What texels are multiplied by.
    pub factor: Spectrum,
    pub part: Part,
}

impl Panorama {
    /// Edges of the rows in t, from 0 to 1.
    pub fn row_edges(&self) -> Vec<f64> {
        let height = self.image.texels.height();
        let edge = |row: usize| match self.projection {
            // (1 − cos θ)/2 at θ = π row/height.
            Projection::LatLong => (FRAC_PI_2 * row as f64 / height as f64).sin().powi(2),
            Projection::Octahedral => row as f64 / height as f64,
        };
        (0..height).map(edge).chain([1.0]).collect()
    }

    /// What comes from the `i`th texel, row by row; zero from one of another part.
    pub fn radiance(&self, i: usize) -> Spectrum {
        let [r, g, b] = self.image.texels.texel(i).map(f64::from);
        let radiance = Spectrum::rgb(r, g, b) * self.factor;
        let luminance = radiance.luminance();
        let counts = match self.part {
            Part::All => true,
            Part::Above(limit) => luminance > limit,
            Part::UpTo(limit) => luminance <= limit,
        };
        if counts { radiance } else { Spectrum::BLACK }
    }

    /// ∫ L dω, and sr of the texels that shine.
    pub fn integral(&self) -> (Spectrum, f64) {
        let (edges, width) = (self.row_edges(), self.image.texels.width());
        let (mut light, mut shining) = (Spectrum::BLACK, 0.0);
        for (row, edge) in edges.windows(2).enumerate() {
            let texel = 4.0 * PI * (edge[1] - edge[0]) / width as f64;
            let (mut of_row, mut count) = (Spectrum::BLACK, 0usize);
            for column in 0..width {
                let radiance = self.radiance(row * width + column);
                of_row += radiance;
                count += usize::from(!radiance.is_black());
            }
            light += of_row * texel;
            shining += texel * count as f64;
        }
        (light, shining)
    }

    /// As lights: a sun, or lamps, apart from the sky about them. Photons of a small bright part are close together in
    /// direction and spread over positions, those of a sky both; and as a light of its own it is looked at, guided and weighed
    /// against the eye's paths for itself.
    pub fn into_lights(self) -> Vec<Panorama> {
        let all = self.integral().0.luminance();
        let limit = BRIGHT * all / (4.0 * PI);
        let bright = Panorama { part: Part::Above(limit), ..self.clone() };
        let of_bright = bright.integral().0.luminance();
        if of_bright < WORTH_A_LIGHT * all {
            return vec![self];
        }
        let dim = Panorama { part: Part::UpTo(limit), ..self };
        if dim.integral().0.is_black() { vec![bright] } else { vec![bright, dim] }
    }
}
