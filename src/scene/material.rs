//! Materials as the scene file names them; `surface` turns them into BSDFs at a point.

use super::ids::TextureId;
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
    /// Metal, a diffuse base under a dielectric coat, and glass, mixed: `metalness` of the first, and of the rest
    /// `transmission` of the last, each in [0, 1]. `alpha` is 0 for a smooth surface. `thin` glass has no thickness and
    /// bends nothing. Where `coverage` is below 1 the rest of the light goes straight on, as if nothing were there.
    Principled {
        base_colour: Textured<Spectrum>,
        metalness: Textured<f64>,
        transmission: Textured<f64>,
        coverage: Textured<f64>,
        alpha: Textured<f64>,
        ior: f64,
        thin: bool,
        normal: Option<NormalMap>,
        specular: Option<Specular>,
        coat: Option<Coat>,
    },
    /// No surface, only the boundary of a medium: light does not notice it.
    Interface,
}

/// Of a principled material's reflectance over its diffuse base: `weight`, in [0, 1], multiplies all of it, `colour`, any
/// from 0 on, that at normal incidence, which is cut off at 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specular {
    pub weight: Textured<f64>,
    pub colour: Textured<Spectrum>,
}

/// A dielectric layer over all of a principled material, on the part `weight` in [0, 1] of it; `alpha` is 0 for a smooth one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    pub weight: Textured<f64>,
    pub alpha: Textured<f64>,
    pub ior: f64,
}

impl Coat {
    /// Whether it is smooth all over: an image of roughness never is.
    pub fn is_smooth(&self) -> bool {
        self.alpha == Textured::Constant(0.0)
    }
}

/// An image that bends shading normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    pub texture: TextureId,
    /// What slopes are multiplied by.
    pub scale: f64,
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
            Material::Principled {
                base_colour,
                metalness,
                transmission,
                coverage,
                alpha,
                normal,
                specular,
                coat,
                ..
            } => {
                let colours = [Some(base_colour), specular.as_ref().map(|specular| &specular.colour)];
                let layers = [specular.as_ref().map(|s| &s.weight), coat.as_ref().map(|c| &c.weight)];
                let coat_alpha = coat.as_ref().map(|coat| &coat.alpha);
                let layers = layers.into_iter().chain([coat_alpha]).flatten();
                let mut numbers = [metalness, transmission, coverage, alpha].into_iter().chain(layers);
                colours.into_iter().flatten().any(|colour| matches!(colour, Textured::Image { .. }))
                    || normal.is_some()
                    || numbers.any(|number| matches!(number, Textured::Image { .. }))
            }
            Material::Dielectric { .. } | Material::Conductor { .. } | Material::Interface => false,
        }
    }

    pub fn normal_map(&self) -> Option<NormalMap> {
        match self {
            Material::Principled { normal, .. } => *normal,
            _ => None,
        }
    }

    /// Whether colours of vertices change it.
    pub fn is_tinted_by_vertices(&self) -> bool {
        matches!(self, Material::Principled { .. })
    }

    /// Whether a BSDF of this material can focus light: it has a delta lobe, were it straight on through holes, or one of
    /// microfacets that is not of one class with a diffuse base.
    pub fn can_focus(&self) -> bool {
        match self {
            Material::Lambert { .. } | Material::Interface => false,
            Material::Principled { coat, .. } => {
                let mirrors = coat.is_some_and(|coat| coat.is_smooth());
                self.is_smooth() || mirrors || self.has_holes() || !self.has_diffuse_base()
            }
            Material::Mirror { .. }
            | Material::Dielectric { .. }
            | Material::Conductor { .. }
            | Material::Plastic { .. }
            | Material::RoughDielectric { .. }
            | Material::RoughConductor { .. } => true,
        }
    }

    /// Whether light goes through it into an inside.
    pub fn is_solid_glass(&self) -> bool {
        match self {
            Material::Dielectric { .. } | Material::RoughDielectric { .. } => true,
            Material::Principled { transmission, thin, .. } => !thin && *transmission != Textured::Constant(0.0),
            _ => false,
        }
    }

    /// Whether its objects have an inside that light gets to.
    pub fn has_inside(&self) -> bool {
        self.is_solid_glass() || *self == Material::Interface
    }

    /// Whether it is nothing but the boundary of a medium.
    pub fn is_interface(&self) -> bool {
        *self == Material::Interface
    }

    /// Whether a principled material is smooth all over below its coat: an image of roughness never is, glass that bends nothing always.
    pub fn is_smooth(&self) -> bool {
        let Material::Principled { alpha, metalness, transmission, ior, thin, .. } = self else { return false };
        let all_glass = *metalness == Textured::Constant(0.0) && *transmission == Textured::Constant(1.0);
        *alpha == Textured::Constant(0.0) || all_glass && !thin && *ior == 1.0
    }

    /// Whether a principled material may let light through its holes somewhere.
    pub fn has_holes(&self) -> bool {
        matches!(self, Material::Principled { coverage, .. } if *coverage != Textured::Constant(1.0))
    }

    /// Whether a principled material may have a diffuse base somewhere: it is not all metal and not all glass.
    pub fn has_diffuse_base(&self) -> bool {
        let all = |number: &Textured<f64>| *number == Textured::Constant(1.0);
        let Material::Principled { metalness, transmission, .. } = self else { return false };
        !all(metalness) && !all(transmission)
    }
}
