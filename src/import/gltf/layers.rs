//! What lies over the base of a material: `KHR_materials_specular`, `KHR_materials_clearcoat`; and what glass does to colours,
//! `KHR_materials_dispersion`.

use gltf::Material;
use serde_json::Value;

use super::materials::{Uses, share};
use super::textures::Channels;
use crate::import::ignored::Ignored;
use crate::scene::description::{CoatDescription, Parameter, SpecularDescription};
use crate::scene::error::Problem;

const CLEARCOAT: &str = "KHR_materials_clearcoat";
const DISPERSION: &str = "KHR_materials_dispersion";

/// Of the layer, which the format fixes.
const COAT_INDEX: f64 = 1.5;

/// The strength lies in the alpha of its image; the colour may be brighter than white.
pub(super) fn specular(
    material: &Material<'_>,
    uses: &mut Uses<'_, '_>,
) -> Result<Option<SpecularDescription>, Problem> {
    let Some(specular) = material.specular() else { return Ok(None) };
    let factor = share(specular.specular_factor());
    let weight = uses.number(specular.specular_texture(), Channels::Opacity, factor)?;
    let tint = specular.specular_color_factor().map(|c| f64::from(c).max(0.0));
    let colour = uses.colour(specular.specular_color_texture(), tint)?;
    let described = SpecularDescription { weight, colour }.unless_plain();
    let of_glass = described.is_some() && material.transmission().is_some_and(|t| t.transmission_factor() > 0.0);
    uses.ignored.note_if(of_glass, "KHR_materials_specular of glass (its index alone counts)");
    Ok(described)
}

/// A layer of the index 1.5 with the shading normal of what is below it.
pub(super) fn coat(material: &Material<'_>, uses: &mut Uses<'_, '_>) -> Result<Option<CoatDescription>, Problem> {
    let Some(coat) = material.extension_value(CLEARCOAT) else { return Ok(None) };
    let factor = |name: &str| share(coat[name].as_f64().unwrap_or(0.0) as f32);
    let (weight, roughness) = (factor("clearcoatFactor"), factor("clearcoatRoughnessFactor"));
    if weight == 0.0 {
        return Ok(None);
    }
    let weight = of_layer(&coat["clearcoatTexture"], Channels::Red, weight, uses)?;
    let roughness = match roughness {
        0.0 => Parameter::Constant(0.0),
        factor => of_layer(&coat["clearcoatRoughnessTexture"], Channels::Green, factor, uses)?,
    };
    let own_normals = !coat["clearcoatNormalTexture"].is_null();
    uses.ignored.note_if(own_normals, "clearcoatNormalTexture");
    let bent = material.normal_texture().is_some();
    uses.ignored.note_if(bent, "a clearcoat that a normalTexture leaves even (it is bent, too)");
    Ok(Some(CoatDescription { weight, roughness, ior: COAT_INDEX }))
}

fn of_layer(info: &Value, channels: Channels, factor: f64, uses: &mut Uses<'_, '_>) -> Result<Parameter<f64>, Problem> {
    if info.is_null() {
        return Ok(Parameter::Constant(factor));
    }
    Ok(Parameter::Image { texture: uses.plain_image(info, channels)?, factor })
}

/// 20/V with V the Abbe number: read, and glass that has some is listed until colours part here.
pub(super) fn note_dispersion(material: &Material<'_>, ignored: &mut Ignored) {
    let dispersion = material.extension_value(DISPERSION).and_then(|d| d["dispersion"].as_f64()).unwrap_or(0.0);
    let of_glass = material.transmission().is_some_and(|t| t.transmission_factor() > 0.0);
    ignored.note_if(dispersion > 0.0 && of_glass, "KHR_materials_dispersion (read, but one index for all colours)");
}
