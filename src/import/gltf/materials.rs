//! Metallic-roughness materials on the models of this house.

use gltf::material::AlphaMode;
use gltf::texture::Info;
use gltf::{Document, Material};

use super::ignored::Ignored;
use super::names::Names;
use super::textures::{Channels, Textures, uv_set};
use crate::scene::description::{Emission, MaterialDescription, MaterialModel, Parameter};
use crate::scene::error::{Problem, Source};

/// What a mesh needs to know of its material.
#[derive(Clone)]
pub(super) struct Finish {
    pub name: String,
    pub emission: Option<Emission>,
    /// The set of texture coordinates that the material's images lie in.
    pub uv_set: Option<u32>,
}

/// Materials as they are asked for.
pub(super) struct Materials<'a> {
    textures: Textures<'a>,
    source: &'a Source,
    names: Names,
    pub described: Vec<MaterialDescription>,
    /// By index; the last is that of meshes without a material.
    finishes: Vec<Option<Finish>>,
}

impl<'a> Materials<'a> {
    pub fn new(document: &Document, textures: Textures<'a>, source: &'a Source) -> Materials<'a> {
        let finishes = vec![None; document.materials().len() + 1];
        Materials { textures, source, names: Names::default(), described: Vec::new(), finishes }
    }

    pub fn into_parts(self) -> (Vec<MaterialDescription>, Vec<crate::scene::description::TextureDescription>) {
        (self.described, self.textures.described)
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
        let finish = Finish { name: name.clone(), emission, uv_set: uses.uv_set };
        self.described.push(MaterialDescription { name, source: self.source.clone(), model });
        self.finishes[place] = Some(finish.clone());
        Ok(finish)
    }
}

/// The images of one material. A mesh has one set of texture coordinates here: that of the first image.
struct Uses<'t, 'a> {
    textures: &'t mut Textures<'a>,
    ignored: &'t mut Ignored,
    uv_set: Option<u32>,
}

impl Uses<'_, '_> {
    fn image(&mut self, info: &Info<'_>, channels: Channels) -> Result<usize, Problem> {
        let set = uv_set(info);
        if *self.uv_set.get_or_insert(set) != set {
            self.ignored.note("a second set of texture coordinates in one material");
        }
        self.textures.of(info, channels)
    }

    fn colour(&mut self, info: Option<Info<'_>>, factor: [f64; 3]) -> Result<Parameter<[f64; 3]>, Problem> {
        let Some(info) = info else { return Ok(Parameter::Constant(factor)) };
        Ok(Parameter::Image { texture: self.image(&info, Channels::Colour)?, factor })
    }
}

/// Components of `f32` that were meant to be at most 1 are.
fn share(x: f32) -> f64 {
    f64::from(x).clamp(0.0, 1.0)
}

fn model(material: &Material<'_>, uses: &mut Uses<'_, '_>) -> Result<MaterialModel, Problem> {
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, _] = pbr.base_color_factor();
    let albedo = uses.colour(pbr.base_color_texture(), [r, g, b].map(share))?;
    Ok(MaterialModel::Lambert { albedo })
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
    let emission = Emission { source: source.clone(), radiance, two_sided };
    Ok((radiance != [0.0; 3]).then_some(emission))
}

fn note_ignored(material: &Material<'_>, ignored: &mut Ignored) {
    ignored.note_if(material.normal_texture().is_some(), "normalTexture");
    ignored.note_if(material.occlusion_texture().is_some(), "occlusionTexture");
    match material.alpha_mode() {
        AlphaMode::Opaque => {}
        AlphaMode::Mask => ignored.note("alphaMode MASK"),
        AlphaMode::Blend => ignored.note("alphaMode BLEND"),
    }
}
