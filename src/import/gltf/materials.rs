//! Metallic-roughness materials on the models of this house.

use gltf::material::{AlphaMode, NormalTexture, PbrSpecularGlossiness};
use gltf::texture::Info;
use gltf::{Document, Material};
use serde_json::Value;

use super::layers;
use super::textures::{Channels, Textures, plain_uv_set, uv_set};
use crate::import::ignored::Ignored;
use crate::import::names::Names;
use crate::scene::PhotonChoice;
use crate::scene::description::{
    CoatDescription, Emission, InteriorDescription, MaterialDescription, MaterialModel, MediumDescription,
    NormalMapDescription, Parameter, Reference, TextureDescription,
};
use crate::scene::error::{Problem, Source};

/// What a mesh needs to know of its material.
#[derive(Clone)]
pub(super) struct Finish {
    pub name: String,
    pub emission: Option<Emission>,
    /// Whether it is a lamp and no picture that glows.
    pub is_lamp: bool,
    /// The set of texture coordinates that the material's images lie in.
    pub uv_set: Option<u32>,
}

/// Materials as they are asked for.
pub(super) struct Materials<'a> {
    textures: Textures<'a>,
    source: &'a Source,
    names: Names,
    pub described: Vec<MaterialDescription>,
    /// What fills solid glass that is coloured inside.
    media: Vec<MediumDescription>,
    /// By index; the last is that of meshes without a material.
    finishes: Vec<Option<Finish>>,
}

impl<'a> Materials<'a> {
    pub fn new(document: &Document, textures: Textures<'a>, source: &'a Source) -> Materials<'a> {
        let finishes = vec![None; document.materials().len() + 1];
        Materials { textures, source, names: Names::default(), described: Vec::new(), media: Vec::new(), finishes }
    }

    pub fn into_parts(self) -> (Vec<MaterialDescription>, Vec<TextureDescription>, Vec<MediumDescription>) {
        (self.described, self.textures.described, self.media)
    }

    pub fn of(&mut self, material: &Material<'_>, ignored: &mut Ignored) -> Result<Finish, Problem> {
        let place = material.index().unwrap_or(self.finishes.len() - 1);
        if let Some(known) = &self.finishes[place] {
            return Ok(known.clone());
        }
        let name = match (material.name(), material.index()) {
            (Some(name), _) => name.to_owned(),
            (None, Some(index)) => format!("material {index}"),
            (None, None) => "default material".to_owned(),
        };
        let name = self.names.unique(&name);
        note_ignored(material, ignored);
        let mut uses = Uses { textures: &mut self.textures, ignored, uv_set: None };
        let model = model(material, &mut uses)?;
        let emission = emission(material, &mut uses, self.source)?;
        let is_lamp = emission.is_some() && material.emissive_texture().is_none();
        let finish = Finish { name: name.clone(), emission, is_lamp, uv_set: uses.uv_set };
        let source = self.source.clone();
        let interior = attenuation(material).map(|sigma_a| {
            let inside = format!("{name}: inside");
            let medium = Reference { name: inside.clone(), source: source.clone() };
            let (sigma_s, g, density) = ([0.0; 3], 0.0, None);
            self.media.push(MediumDescription { name: inside, source: source.clone(), sigma_a, sigma_s, g, density });
            InteriorDescription { medium: Some(medium), priority: 0 }
        });
        self.described.push(MaterialDescription { name, source, model, interior });
        self.finishes[place] = Some(finish.clone());
        Ok(finish)
    }
}

/// The images of one material. A mesh has one set of texture coordinates here: that of the first image.
pub(super) struct Uses<'t, 'a> {
    textures: &'t mut Textures<'a>,
    pub ignored: &'t mut Ignored,
    uv_set: Option<u32>,
}

impl Uses<'_, '_> {
    fn normals(&mut self, info: &NormalTexture<'_>) -> Result<NormalMapDescription, Problem> {
        self.lies_in(info.tex_coord());
        Ok(NormalMapDescription { texture: self.textures.normals(info)?, scale: info.scale().into() })
    }

    fn image(&mut self, info: &Info<'_>, channels: Channels) -> Result<usize, Problem> {
        self.lies_in(uv_set(info));
        self.textures.of(info, channels)
    }

    /// The same where the crate leaves an extension as JSON.
    pub fn plain_image(&mut self, info: &Value, channels: Channels) -> Result<usize, Problem> {
        self.lies_in(plain_uv_set(info));
        self.textures.of_json(info, channels)
    }

    fn lies_in(&mut self, set: u32) {
        if *self.uv_set.get_or_insert(set) != set {
            self.ignored.note("a second set of texture coordinates in one material");
        }
    }

    pub fn number(
        &mut self,
        info: Option<Info<'_>>,
        channels: Channels,
        factor: f64,
    ) -> Result<Parameter<f64>, Problem> {
        let Some(info) = info else { return Ok(Parameter::Constant(factor)) };
        Ok(Parameter::Image { texture: self.image(&info, channels)?, factor })
    }

    pub fn colour(&mut self, info: Option<Info<'_>>, factor: [f64; 3]) -> Result<Parameter<[f64; 3]>, Problem> {
        let Some(info) = info else { return Ok(Parameter::Constant(factor)) };
        Ok(Parameter::Image { texture: self.image(&info, Channels::Colour)?, factor })
    }
}

/// Of refraction, where a material does not say.
const USUAL_INDEX: f32 = 1.5;
/// Of alpha, likewise.
const USUAL_CUTOFF: f32 = 0.5;

/// Components of `f32` that were meant to be at most 1 are.
pub(super) fn share(x: f32) -> f64 {
    f64::from(x).clamp(0.0, 1.0)
}

fn model(material: &Material<'_>, uses: &mut Uses<'_, '_>) -> Result<MaterialModel, Problem> {
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, _] = pbr.base_color_factor();
    let base_colour = uses.colour(pbr.base_color_texture(), [r, g, b].map(share))?;
    let both = pbr.metallic_roughness_texture();
    let roughness = uses.number(both, Channels::Green, share(pbr.roughness_factor()))?;
    let metalness = uses.number(pbr.metallic_roughness_texture(), Channels::Blue, share(pbr.metallic_factor()))?;
    let transmission = match material.transmission() {
        Some(t) => uses.number(t.transmission_texture(), Channels::Red, share(t.transmission_factor()))?,
        None => Parameter::Constant(0.0),
    };
    let thin = material.volume().is_none_or(|volume| volume.thickness_factor() == 0.0);
    let ior = index(material, uses.ignored);
    let coverage = coverage(material, uses)?;
    let normal = match material.normal_texture() {
        Some(map) => Some(uses.normals(&map)?),
        None => None,
    };
    let (specular, coat) = (layers::specular(material, uses)?, layers::coat(material, uses)?);
    let model = MaterialModel::Principled {
        base_colour,
        metalness,
        roughness,
        transmission,
        coverage,
        ior,
        thin,
        normal,
        specular,
        coat,
    };
    match material.pbr_specular_glossiness() {
        Some(older) => specular_glossiness(&older, coverage, normal, coat, uses),
        None => Ok(without_unused_images(model)),
    }
}

/// What a distance leaves of a channel at least, so that a coefficient is finite.
const BLACKEST: f64 = 1e-6;

/// `KHR_materials_volume`: the coefficient of absorption, 1/m, that leaves the attenuation colour of light after the
/// attenuation distance, c = e^(−σ_a d). `None` where nothing is taken away, or nothing goes through.
fn attenuation(material: &Material<'_>) -> Option<[f64; 3]> {
    let volume = material.volume().filter(|volume| volume.thickness_factor() > 0.0)?;
    material.transmission().filter(|transmission| transmission.transmission_factor() > 0.0)?;
    let distance = f64::from(volume.attenuation_distance());
    let sigma = volume.attenuation_color().map(|c| -share(c).max(BLACKEST).ln() / distance);
    (sigma != [0.0; 3] && sigma.iter().all(|s| s.is_finite())).then_some(sigma)
}

/// How much of a point is there: alpha itself, or whether it reaches the cutoff.
fn coverage(material: &Material<'_>, uses: &mut Uses<'_, '_>) -> Result<Parameter<f64>, Problem> {
    let pbr = material.pbr_metallic_roughness();
    let [.., alpha] = pbr.base_color_factor();
    let solid = material.transmission().is_some() && material.volume().is_some_and(|v| v.thickness_factor() > 0.0);
    if solid && material.alpha_mode() != AlphaMode::Opaque {
        uses.ignored.note("the alpha of solid glass");
        return Ok(Parameter::Constant(1.0));
    }
    match material.alpha_mode() {
        AlphaMode::Opaque => Ok(Parameter::Constant(1.0)),
        AlphaMode::Blend => uses.number(pbr.base_color_texture(), Channels::Opacity, share(alpha)),
        AlphaMode::Mask => {
            let cutoff = material.alpha_cutoff().unwrap_or(USUAL_CUTOFF);
            if pbr.base_color_texture().is_none() {
                return Ok(Parameter::Constant(if alpha >= cutoff { 1.0 } else { 0.0 }));
            }
            // A factor of 0 leaves nothing that could reach a cutoff above 0.
            uses.number(pbr.base_color_texture(), Channels::Mask((cutoff / alpha).to_bits()), 1.0)
        }
    }
}

/// `KHR_materials_ior`; its 0 stands for a coat that reflects everything, for the sake of an older extension.
fn index(material: &Material<'_>, ignored: &mut Ignored) -> f64 {
    let given = f64::from(material.ior().unwrap_or(USUAL_INDEX));
    if given == 0.0 {
        ignored.note("KHR_materials_ior of 0 (1.5 is taken)");
        return USUAL_INDEX.into();
    }
    given
}

/// The older way to say it: a diffuse base and a specular colour; a coat of the usual index stands in for the latter.
fn specular_glossiness(
    older: &PbrSpecularGlossiness<'_>,
    coverage: Parameter<f64>,
    normal: Option<NormalMapDescription>,
    coat: Option<CoatDescription>,
    uses: &mut Uses<'_, '_>,
) -> Result<MaterialModel, Problem> {
    uses.ignored.note("the specular colour of KHR_materials_pbrSpecularGlossiness");
    let image = older.specular_glossiness_texture().is_some();
    uses.ignored.note_if(image, "specularGlossinessTexture");
    let [r, g, b, _] = older.diffuse_factor();
    Ok(MaterialModel::Principled {
        base_colour: uses.colour(older.diffuse_texture(), [r, g, b].map(share))?,
        metalness: Parameter::Constant(0.0),
        roughness: Parameter::Constant(1.0 - share(older.glossiness_factor())),
        transmission: Parameter::Constant(0.0),
        coverage,
        ior: USUAL_INDEX.into(),
        thin: true,
        normal,
        specular: None,
        coat,
    })
}

/// An image times 0 is 0: so the material is known to be no metal anywhere, or smooth.
fn without_unused_images(mut model: MaterialModel) -> MaterialModel {
    let plain = |number: Parameter<f64>| match number {
        Parameter::Image { factor: 0.0, .. } => Parameter::Constant(0.0),
        other => other,
    };
    if let MaterialModel::Principled { metalness, roughness, transmission, .. } = &mut model {
        for number in [metalness, roughness, transmission] {
            *number = plain(*number);
        }
    }
    model
}

/// The radiance that a material sends out of itself. An image of it is replaced by its mean: lamps are even here.
fn emission(material: &Material<'_>, uses: &mut Uses<'_, '_>, source: &Source) -> Result<Option<Emission>, Problem> {
    let strength = f64::from(material.emissive_strength().unwrap_or(1.0));
    let mut radiance = material.emissive_factor().map(|c| f64::from(c) * strength);
    if radiance == [0.0; 3] {
        return Ok(None);
    }
    if let Some(info) = material.emissive_texture() {
        let mean = uses.textures.mean(&info)?;
        radiance = std::array::from_fn(|c| radiance[c] * mean[c]);
        uses.ignored.note("emissiveTexture (its mean is taken)");
    }
    let two_sided = material.double_sided();
    let emission = Emission { source: source.clone(), radiance, two_sided, group: None, photons: PhotonChoice::Auto };
    Ok((radiance != [0.0; 3]).then_some(emission))
}

fn note_ignored(material: &Material<'_>, ignored: &mut Ignored) {
    ignored.note_if(material.occlusion_texture().is_some(), "occlusionTexture");
    layers::note_dispersion(material, ignored);
    ignored.note_if(material.unlit(), "KHR_materials_unlit (lit as others are)");
}
