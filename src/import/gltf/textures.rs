//! Images as textures: which channels of them, how they wrap, and `KHR_texture_transform`.

use std::collections::HashMap;
use std::path::Path;

use gltf::material::NormalTexture;
use gltf::texture::{Info, WrappingMode};
use gltf::{Document, Image, Texture};
use serde_json::Value;

use super::buffers::Buffers;
use super::uri::{Resource, resolve};
use crate::import::image::{self, ColourSpace, from_bytes, opacity, read_file};
use crate::scene::description::TextureDescription;
use crate::scene::error::{Problem, Source};
use crate::scene::texture::{Placement, Raster, TextureMemory, Wrap};

/// What of an image is used. Colours are encoded with the sRGB curve, single channels hold numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Channels {
    Colour,
    Red,
    Green,
    Blue,
    /// All three as numbers.
    Numbers,
    Opacity,
    /// 1 where the opacity is at least the number of these bits, else 0.
    Mask(u32),
}

/// Of all textures together: one image may be many textures, each with its own place.
const MAX_TEXELS: usize = 1 << 28;

#[derive(PartialEq, Eq, Hash)]
struct Key {
    image: usize,
    channels: Channels,
    wrap: [Wrap; 2],
    placement: [u64; 6],
}

/// The textures that materials have asked for so far.
pub(super) struct Textures<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    folder: &'a Path,
    source: &'a Source,
    memory: &'a TextureMemory,
    pub described: Vec<TextureDescription>,
    known: HashMap<Key, usize>,
    /// Of all together.
    texels: usize,
}

impl<'a> Textures<'a> {
    pub fn new(
        document: &'a Document,
        buffers: &'a Buffers<'a>,
        folder: &'a Path,
        source: &'a Source,
        memory: &'a TextureMemory,
    ) -> Textures<'a> {
        Textures { document, buffers, folder, source, memory, described: Vec::new(), known: HashMap::new(), texels: 0 }
    }

    /// The index of a texture, read if it is new.
    pub fn of(&mut self, info: &Info<'_>, channels: Channels) -> Result<usize, Problem> {
        self.placed(&info.texture(), placement(info), channels)
    }

    /// The same of an extension that the crate leaves as JSON, and does not check.
    pub fn of_json(&mut self, info: &Value, channels: Channels) -> Result<usize, Problem> {
        let index = info["index"].as_u64().and_then(|index| usize::try_from(index).ok());
        let Some(texture) = index.and_then(|index| self.document.textures().nth(index)) else {
            let message = format!("not a sound glTF file: a material names the texture {}", info["index"]);
            let there = self.document.textures().len();
            return Err(Problem::new(message).help(format!("the file has {there}, counted from 0")).at(self.source));
        };
        self.placed(&texture, placement_of(info["extensions"].get("KHR_texture_transform")), channels)
    }

    /// The image of a normal map; the crate does not read its transform.
    pub fn normals(&mut self, info: &NormalTexture<'_>) -> Result<usize, Problem> {
        self.placed(&info.texture(), placement_of(info.extension_value("KHR_texture_transform")), Channels::Numbers)
    }

    fn placed(&mut self, texture: &Texture<'_>, placement: Placement, channels: Channels) -> Result<usize, Problem> {
        let (image, sampler) = (texture.source(), texture.sampler());
        let wrap = [sampler.wrap_s(), sampler.wrap_t()].map(wrap);
        let bits = placement.rows.as_flattened().iter().map(|x| x.to_bits());
        let mut key = Key { image: image.index(), channels, wrap, placement: [0; 6] };
        key.placement.iter_mut().zip(bits).for_each(|(slot, bits)| *slot = bits);
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let decoded = self.decode(&image, channels).map_err(|problem| self.of_image(&image, problem))?;
        self.texels += decoded.samples.len();
        if self.texels > MAX_TEXELS {
            let problem = Problem::new(format!("the textures together have more than {MAX_TEXELS} texels"));
            return Err(problem.help("scale the images down").at(self.source));
        }
        let placed = image::placed(decoded, wrap, placement, self.memory);
        let image = placed.map_err(|problem| problem.at_unless_placed(self.source))?;
        self.described.push(TextureDescription { source: self.source.clone(), image });
        self.known.insert(key, self.described.len() - 1);
        Ok(self.described.len() - 1)
    }

    /// The mean colour of an image.
    pub fn mean(&self, info: &Info<'_>) -> Result<[f64; 3], Problem> {
        let image = info.texture().source();
        let decoded = self.decode(&image, Channels::Colour).map_err(|p| self.of_image(&image, p))?;
        let mut sum = [0.0; 3];
        for texel in decoded.texels() {
            sum = std::array::from_fn(|c| sum[c] + f64::from(texel[c]));
        }
        Ok(sum.map(|s| s / decoded.samples.len() as f64))
    }

    fn of_image(&self, image: &Image<'_>, problem: Problem) -> Problem {
        let message = format!("images[{}]: {}", image.index(), problem.message);
        Problem { message, ..problem }.at_unless_placed(self.source)
    }

    fn decode(&self, image: &Image<'_>, channels: Channels) -> Result<Raster, Problem> {
        let space = if channels == Channels::Colour { ColourSpace::Srgb } else { ColourSpace::Linear };
        let read = |path: &Path, bytes: &[u8]| match channels {
            Channels::Opacity | Channels::Mask(_) => opacity(path, bytes),
            _ => from_bytes(path, bytes, Some(space)),
        };
        let decoded = match image.source() {
            gltf::image::Source::View { view, .. } => {
                let bytes = self.buffers.view(&view);
                let bytes = bytes.ok_or_else(|| Problem::new("its buffer view reaches out of its buffer"))?;
                read(&self.source.file, bytes)?
            }
            gltf::image::Source::Uri { uri, .. } => match resolve(uri, self.folder).map_err(Problem::new)? {
                Resource::Embedded(bytes) => read(&self.source.file, &bytes)?,
                Resource::File(path) => read(&path, &read_file(&path)?)?,
            },
        };
        Ok(match channels {
            Channels::Colour | Channels::Numbers | Channels::Opacity => decoded,
            Channels::Mask(least) => {
                decoded.mapped(|_, opacity| if opacity >= f32::from_bits(least) { 1.0 } else { 0.0 })
            }
            Channels::Red => decoded.component(0),
            Channels::Green => decoded.component(1),
            Channels::Blue => decoded.component(2),
        })
    }
}

/// Which of a mesh's sets of texture coordinates the texture lies in.
pub(super) fn uv_set(info: &Info<'_>) -> u32 {
    info.texture_transform().and_then(|t| t.tex_coord()).unwrap_or_else(|| info.tex_coord())
}

/// The same where it is mere JSON.
pub(super) fn plain_uv_set(info: &Value) -> u32 {
    let transformed = &info["extensions"]["KHR_texture_transform"]["texCoord"];
    let set = transformed.as_u64().or(info["texCoord"].as_u64()).unwrap_or(0);
    u32::try_from(set).unwrap_or(u32::MAX)
}

fn wrap(mode: WrappingMode) -> Wrap {
    match mode {
        WrappingMode::Repeat => Wrap::Repeat,
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
    }
}

/// `KHR_texture_transform` maps (u, v) with v downwards to T R S (u, v), R turning by [[cos, sin], [−sin, cos]]. Here v
/// runs upwards on both sides of it.
fn placement(info: &Info<'_>) -> Placement {
    let Some(transform) = info.texture_transform() else { return Placement::IDENTITY };
    upwards(transform.offset().map(f64::from), transform.rotation().into(), transform.scale().map(f64::from))
}

/// The same where it is mere JSON; what it leaves out, or says wrongly, changes nothing.
fn placement_of(transform: Option<&Value>) -> Placement {
    let Some(transform) = transform else { return Placement::IDENTITY };
    let pair = |name: &str, default: f64| [0, 1].map(|i| transform[name][i].as_f64().unwrap_or(default));
    upwards(pair("offset", 0.0), transform["rotation"].as_f64().unwrap_or(0.0), pair("scale", 1.0))
}

fn upwards(offset: [f64; 2], rotation: f64, scale: [f64; 2]) -> Placement {
    let (sin, cos) = rotation.sin_cos();
    let down = [[cos * scale[0], sin * scale[1], offset[0]], [-sin * scale[0], cos * scale[1], offset[1]]];
    // v ↦ 1 − v before, then after.
    let [u, v] = down.map(|[a, b, t]| [a, -b, t + b]);
    Placement { rows: [u, [-v[0], -v[1], 1.0 - v[2]]] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The specification's own example: offset (0, 1), rotation π/2, scale (0.5, 0.5).
    #[test]
    fn a_transform_is_the_formats_with_v_turned_over() {
        let place = |p: &Placement, [u, v]: [f64; 2]| p.rows.map(|[a, b, t]| a * u + b * v + t);
        let (offset, rotation, scale) = ([0.3, -0.2], 0.7f64, [2.0, 0.5]);
        let (sin, cos) = rotation.sin_cos();
        for [u, v] in [[0.0, 0.0], [1.0, 0.0], [0.2, 0.9]] {
            // T · R · S of the extension's text, columns (cos, −sin), (sin, cos).
            let (x, y) = (scale[0] * u, scale[1] * v);
            let expected = [cos * x + sin * y + offset[0], -sin * x + cos * y + offset[1]];
            let [pu, pv] = place(&upwards(offset, rotation, scale), [u, 1.0 - v]);
            assert!((pu - expected[0]).abs() < 1e-15 && (1.0 - pv - expected[1]).abs() < 1e-15, "{u} {v}");
        }
        assert_eq!(upwards([0.0; 2], 0.0, [1.0; 2]), Placement::IDENTITY);
        let quarter = upwards([0.0, 1.0], std::f64::consts::FRAC_PI_2, [0.5, 0.5]);
        // The image's upper left half-way: (0, 0) in the format's coordinates is looked up at (0, 1).
        let [u, v] = place(&quarter, [0.0, 1.0]);
        assert!(u.abs() < 1e-15 && v.abs() < 1e-15, "{u} {v}");
    }
}
