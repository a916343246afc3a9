//! Materials as the scene file names them; `surface` turns them into BSDFs at a point.

use super::texture::Textured;
use crate::radiometry::Spectrum;

/// A material. Indices of refraction are real ratios to vacuum at the sodium line unless the scene says otherwise;
/// `alpha` is the GGX width, roughness squared where a file gives roughness.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Two-sided ideal diffuse reflector.
    Lambert { albedo: Textured<Spectrum> },
    /// Two-sided ideal mirror of constant reflectance.
    Mirror { reflectance: Textured<Spectrum> },
    /// Smooth interface between the outside (`exterior`) and the inside (`ior`) of a closed surface, unpolarised
    /// Fresnel. With `fresnel = false` everything that can be transmitted is (for comparison with closed forms).
    Dielectric { ior: f64, exterior: f64, fresnel: bool },
    /// Smooth metal with complex index eta + i k.
    Conductor { eta: Spectrum, k: Spectrum },
    /// GGX interface between two dielectrics.
    RoughDielectric { ior: f64, exterior: f64, alpha: Textured<f64> },
    /// GGX metal.
    RoughConductor { eta: Spectrum, k: Spectrum, alpha: Textured<f64> },
    /// Diffuse base under a smooth dielectric coat (a delta lobe beside a diffuse one), opaque, two-sided.
    Plastic { albedo: Textured<Spectrum>, ior: f64 },
}

impl Material {
    /// Whether any parameter is an image.
    pub fn has_image(&self) -> bool {
        match self {
            Material::Lambert { albedo: colour }
            | Material::Mirror { reflectance: colour }
            | Material::Plastic { albedo: colour, .. } => matches!(colour, Textured::Image { .. }),
            Material::RoughDielectric { alpha, .. } | Material::RoughConductor { alpha, .. } => {
                matches!(alpha, Textured::Image { .. })
            }
            Material::Dielectric { .. } | Material::Conductor { .. } => false,
        }
    }
}
