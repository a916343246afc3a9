//! Textures as constants or images: what is made of several is computed texel by texel when the file is read.

use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

use super::budget::Budget;
use super::parameters::{Parameter, Parameters, shortened};
use super::spectra;
use crate::import::image::{ColourSpace, from_bytes, placed, read_file};
use crate::scene::description::{Parameter as Described, TextureDescription};
use crate::scene::error::{Problem, Source};
use crate::scene::spelling::nearest;
use crate::scene::texture::{ImageTexture, Placement, Raster, TextureMemory, Wrap};

/// Of all textures together.
const MAX_TEXELS: usize = 1 << 28;
/// Texels along a check; its edges are a texel wide.
const CHECK: usize = 64;

/// A texture, or what is written in the place of one.
#[derive(Clone, Debug)]
pub(super) enum Value {
    /// A number is grey.
    Constant([f64; 3]),
    Image {
        image: Rc<ImageTexture>,
        factor: [f64; 3],
    },
}

impl Value {
    fn grey(number: f64) -> Value {
        Value::Constant([number; 3])
    }
    /// The same everywhere.
    pub fn constant(&self) -> Option<[f64; 3]> {
        match self {
            Value::Constant(value) => Some(*value),
            Value::Image { .. } => None,
        }
    }
}

/// Textures have names of their own for each of the two types.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Type {
    Float,
    Spectrum,
}

/// What an image is for: its texels are changed accordingly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Use {
    Reflectance,
    /// pbrt's roughness, or the width α itself, as an artist's number, whose square is α.
    Roughness {
        remapped: bool,
    },
}

/// The address of an image, the bits of its factor, its use.
type UseKey = (usize, [u64; 3], Use);

/// The textures of a file.
pub(super) struct Textures<'a> {
    folder: &'a Path,
    memory: &'a TextureMemory,
    /// `None` for one that was reported.
    named: HashMap<(Type, String), Option<Value>>,
    /// By the image, its factor and its use; with the image, so that no other one takes its address.
    indices: HashMap<UseKey, (usize, Rc<ImageTexture>)>,
    pub described: Vec<TextureDescription>,
    texels: usize,
}

impl<'a> Textures<'a> {
    pub fn new(folder: &'a Path, memory: &'a TextureMemory) -> Textures<'a> {
        let (named, indices) = (HashMap::new(), HashMap::new());
        Textures { folder, memory, named, indices, described: Vec::new(), texels: 0 }
    }

    /// `Texture "name" "kind" "class" …`; `Err` with the texture known as one that was reported.
    pub fn define(
        &mut self,
        name: String,
        kind: Type,
        class: &str,
        parameters: &Parameters,
        budget: &mut Budget,
    ) -> Result<(), Problem> {
        let key = (kind, name);
        if self.named.contains_key(&key) {
            let message = format!("there is another texture \"{}\"", shortened(&key.1));
            return Err(parameters.problem(message, "names of textures of one type must differ"));
        }
        let value = self.value(kind, class, parameters, budget);
        self.named.insert(key, value.as_ref().ok().cloned());
        value.map(drop)
    }

    fn value(&mut self, kind: Type, class: &str, ps: &Parameters, budget: &mut Budget) -> Result<Value, Problem> {
        match class {
            "constant" => self.operand(kind, ps, "value", 1.0),
            "scale" => {
                let (tex, scale) = (self.operand(kind, ps, "tex", 1.0)?, self.operand(Type::Float, ps, "scale", 1.0)?);
                self.combine([tex, scale, Value::grey(0.0)], |[a, b, _]| a * b, ps)
            }
            "mix" => {
                let [a, b] = [self.operand(kind, ps, "tex1", 0.0)?, self.operand(kind, ps, "tex2", 1.0)?];
                let amount = self.operand(Type::Float, ps, "amount", 0.5)?;
                self.mixed(a, b, amount, ps)
            }
            "checkerboard" => self.checkerboard(kind, ps, budget),
            "imagemap" => self.image_map(kind, ps),
            _ => {
                let message = format!("textures of the class \"{}\" cannot be rendered", shortened(class));
                Err(ps.cannot(message, "constant, scale, mix, checkerboard and imagemap can; bake others to an image"))
            }
        }
    }

    fn operand(&self, kind: Type, ps: &Parameters, name: &str, default: f64) -> Result<Value, Problem> {
        match kind {
            Type::Float => self.number(ps, name, default),
            Type::Spectrum => self.colour(ps, name, [default; 3]),
        }
    }

    /// A colour, a spectrum or a texture.
    pub fn colour(&self, ps: &Parameters, name: &str, default: [f64; 3]) -> Result<Value, Problem> {
        match ps.find(name) {
            None => Ok(Value::Constant(default)),
            Some(p) if p.kind == "texture" => self.lookup(p, Type::Spectrum, default),
            Some(p) => spectra::reflectance(p, self.folder).map(Value::Constant),
        }
    }

    /// A number or a texture.
    pub fn number(&self, ps: &Parameters, name: &str, default: f64) -> Result<Value, Problem> {
        match ps.find(name) {
            None => Ok(Value::grey(default)),
            Some(p) if p.kind == "texture" => self.lookup(p, Type::Float, [default; 3]),
            Some(p) => p.number(&["float"]).map(Value::grey),
        }
    }

    fn lookup(&self, parameter: &Parameter, kind: Type, default: [f64; 3]) -> Result<Value, Problem> {
        let name = parameter.text("texture")?;
        match self.named.get(&(kind, name.to_owned())) {
            Some(value) => Ok(value.clone().unwrap_or(Value::Constant(default))),
            None => {
                let mut names: Vec<&str> =
                    self.named.keys().filter(|(k, _)| *k == kind).map(|(_, name)| name.as_str()).collect();
                names.sort_unstable();
                let help = match nearest(name, &names) {
                    Some(near) => format!("did you mean \"{near}\"?"),
                    None => "a texture must be defined before it is used".to_owned(),
                };
                let type_name = if kind == Type::Float { "float" } else { "spectrum" };
                Err(parameter.problem(format!("there is no {type_name} texture \"{}\"", shortened(name)), help))
            }
        }
    }

    /// `f` of three values, channel by channel; images among them must agree in size and place.
    fn combine(&mut self, values: [Value; 3], f: impl Fn([f64; 3]) -> f64, ps: &Parameters) -> Result<Value, Problem> {
        let Some(first) = values.iter().find_map(image) else {
            let constants = values.map(|v| v.constant().unwrap_or_default());
            return Ok(Value::Constant(std::array::from_fn(|c| f(constants.map(|v| v[c])))));
        };
        let alike = |other: &ImageTexture| {
            let size = |image: &ImageTexture| (image.texels.width(), image.texels.height());
            size(other) == size(first) && other.wrap == first.wrap && other.placement == first.placement
        };
        if !values.iter().filter_map(image).all(|other| alike(other)) {
            let message = "images of different sizes or mappings cannot be put together";
            return Err(ps.cannot(message, "make them agree, or bake the result to one image"));
        }
        let (width, height) = (first.texels.width(), first.texels.height());
        let mut rows = values.each_ref().map(|value| image(value).map(|image| image.texels.rows()));
        let mut colours = Vec::with_capacity(width * height);
        for j in 0..height {
            let rows = rows.each_mut().map(|rows| rows.as_mut().map(|rows| rows.row(j)));
            let value = |k: usize, i: usize, c: usize| match (&values[k], rows[k]) {
                (Value::Constant(constant), _) => constant[c],
                (Value::Image { factor, .. }, row) => row.map_or(0.0, |row| f64::from(row[i][c]) * factor[c]),
            };
            let texel = |i: usize| [0, 1, 2].map(|c| f([0, 1, 2].map(|k| value(k, i, c))) as f32);
            colours.extend((0..width).map(texel));
        }
        self.keep(Raster::of_colours(width, height, colours), first.wrap, first.placement, &ps.source)
    }

    /// (1 − t) a + t b.
    pub fn mixed(&mut self, a: Value, b: Value, t: Value, ps: &Parameters) -> Result<Value, Problem> {
        self.combine([a, b, t], |[a, b, t]| (1.0 - t) * a + t * b, ps)
    }

    pub fn scaled(&mut self, value: Value, scale: f64, ps: &Parameters) -> Result<Value, Problem> {
        self.combine([value, Value::grey(scale), Value::grey(0.0)], |[a, b, _]| a * b, ps)
    }

    fn keep(
        &mut self,
        raster: Raster,
        wrap: [Wrap; 2],
        placement: Placement,
        source: &Source,
    ) -> Result<Value, Problem> {
        self.count(raster.samples.len(), source)?;
        let image = placed(raster, wrap, placement, self.memory).map_err(|problem| problem.at_unless_placed(source))?;
        Ok(Value::Image { image: Rc::new(image), factor: [1.0; 3] })
    }

    fn count(&mut self, texels: usize, source: &Source) -> Result<(), Problem> {
        self.texels += texels;
        if self.texels > MAX_TEXELS {
            let problem = Problem::new(format!("the textures together have more than {MAX_TEXELS} texels"));
            return Err(problem.help("scale the images down").at(source));
        }
        Ok(())
    }

    fn checkerboard(&mut self, kind: Type, ps: &Parameters, budget: &mut Budget) -> Result<Value, Problem> {
        if ps.integer("dimension", 2..=3, 2)? == 3 {
            return Err(ps.cannot("checkerboards in space cannot be rendered", "use dimension 2"));
        }
        let [even, odd] = [self.operand(kind, ps, "tex1", 1.0)?, self.operand(kind, ps, "tex2", 0.0)?];
        let (Some(even), Some(odd)) = (even.constant(), odd.constant()) else {
            return Err(ps.cannot("a checkerboard of images cannot be rendered", "bake it to one image"));
        };
        let [u, v] = mapping(ps)?;
        budget.spend(4 * CHECK * CHECK, size_of::<[f32; 3]>(), &ps.source)?;
        let side = 2 * CHECK;
        let texel = |i: usize| {
            let (x, y) = (i % side / CHECK, (side - 1 - i / side) / CHECK);
            if (x + y).is_multiple_of(2) { even } else { odd }.map(|c| c as f32)
        };
        // Two checks are the image.
        let placement = Placement { rows: [u, v].map(|row| row.map(|c| 0.5 * c)) };
        let raster = Raster::of_colours(side, side, (0..side * side).map(texel).collect());
        self.keep(raster, [Wrap::Repeat; 2], placement, &ps.source)
    }

    fn image_map(&mut self, kind: Type, ps: &Parameters) -> Result<Value, Problem> {
        let Some(name) = ps.text("filename")? else {
            return Err(ps.problem("an imagemap needs \"string filename\"", "name the image"));
        };
        let wrap = match ps.text("wrap")? {
            None | Some("repeat") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some(other) => {
                let message = format!("images that are wrapped by \"{}\" cannot be rendered", shortened(other));
                return Err(ps.cannot(message, "repeat and clamp can"));
            }
        };
        let encoding = ps.text("encoding")?.unwrap_or("sRGB");
        let gamma = encoding.strip_prefix("gamma ").and_then(|g| g.trim().parse::<f64>().ok()).filter(|g| *g > 0.0);
        let space = match encoding {
            "sRGB" => None,
            "linear" => Some(ColourSpace::Linear),
            _ if gamma.is_some() => Some(ColourSpace::Linear),
            other => {
                let message = format!("there is no encoding \"{}\"", shortened(other));
                return Err(ps.problem(message, "encodings are sRGB, linear and gamma with a number"));
            }
        };
        let (scale, invert, rows) = (ps.number("scale", 1.0)?, ps.flag("invert", false)?, mapping(ps)?);
        ps.ignore(&["filter", "maxanisotropy"]);
        let path = self.folder.join(name);
        let read = read_file(&path).and_then(|bytes| from_bytes(&path, &bytes, space));
        let raster = read.map_err(|problem| problem.at_unless_placed(&ps.source))?;
        let linear = |c: f32| gamma.map_or(f64::from(c), |gamma| f64::from(c).powf(gamma));
        let shown = |c: f64| if invert { 1.0 - scale * c } else { scale * c }.max(0.0) as f32;
        let raster = if kind == Type::Float {
            let mean = |texel: [f32; 3]| [shown(texel.map(linear).iter().sum::<f64>() / 3.0); 3];
            Raster::of_colours(raster.width, raster.height, raster.texels().map(mean).collect())
        } else {
            raster.mapped(|_, c| shown(linear(c)))
        };
        self.keep(raster, [wrap; 2], Placement { rows }, &ps.source)
    }

    /// A reflectance or another share of light in each channel; what is above 1 becomes 1.
    pub fn describe_colour(&mut self, value: &Value, source: &Source) -> Result<Described<[f64; 3]>, Problem> {
        match value {
            Value::Constant(colour) => Ok(Described::Constant(colour.map(|c| c.clamp(0.0, 1.0)))),
            Value::Image { image, factor } => {
                let texture = self.describe(image, *factor, Use::Reflectance, source)?;
                Ok(Described::Image { texture, factor: [1.0; 3] })
            }
        }
    }

    /// An artist's roughness; `remapped` says whether α is the root of pbrt's number or that itself.
    pub fn describe_roughness(
        &mut self,
        value: &Value,
        remapped: bool,
        source: &Source,
    ) -> Result<Described<f64>, Problem> {
        match value {
            Value::Constant([number, ..]) => Ok(Described::Constant(artists_roughness(*number, remapped))),
            Value::Image { image, factor } => {
                let texture = self.describe(image, *factor, Use::Roughness { remapped }, source)?;
                Ok(Described::Image { texture, factor: 1.0 })
            }
        }
    }

    fn describe(
        &mut self,
        image: &Rc<ImageTexture>,
        factor: [f64; 3],
        used: Use,
        source: &Source,
    ) -> Result<usize, Problem> {
        let key = (Rc::as_ptr(image) as usize, factor.map(f64::to_bits), used);
        if let Some((known, _)) = self.indices.get(&key) {
            return Ok(*known);
        }
        self.count(image.texels.len(), source)?;
        let texels = image.texels.mapped(|c, value| {
            let value = f64::from(value) * factor[c];
            let value = match used {
                Use::Reflectance => value.clamp(0.0, 1.0),
                Use::Roughness { remapped } => artists_roughness(value, remapped),
            };
            value as f32
        });
        let image_used = ImageTexture { texels, ..**image };
        self.described.push(TextureDescription { source: source.clone(), image: image_used });
        let index = self.described.len() - 1;
        self.indices.insert(key, (index, image.clone()));
        Ok(index)
    }
}

/// α = √roughness where pbrt remaps it, else the roughness; the artist's number is √α.
pub(super) fn artists_roughness(number: f64, remapped: bool) -> f64 {
    let alpha = if remapped { number.max(0.0).sqrt() } else { number.max(0.0) };
    alpha.min(1.0).sqrt()
}

fn image(value: &Value) -> Option<&Rc<ImageTexture>> {
    match value {
        Value::Constant(_) => None,
        Value::Image { image, .. } => Some(image),
    }
}

/// Rows of the map from texture coordinates to those of the texture.
fn mapping(ps: &Parameters) -> Result<[[f64; 3]; 2], Problem> {
    if let Some(other) = ps.text("mapping")?.filter(|name| *name != "uv") {
        let message = format!("the mapping \"{}\" cannot be rendered", shortened(other));
        return Err(ps.cannot(message, "\"uv\" can"));
    }
    let number = |name, default| ps.number(name, default);
    Ok([[number("uscale", 1.0)?, 0.0, number("udelta", 0.0)?], [0.0, number("vscale", 1.0)?, number("vdelta", 0.0)?]])
}
