//! pbrt's materials on the models of this house, as far as these can express them.

use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

use super::parameters::{Parameters, Values, shortened};
use super::spectra;
use super::textures::{Textures, Value};
use crate::import::ignored::Ignored;
use crate::import::names::Names;
use crate::scene::description::{InteriorDescription, MaterialDescription, MaterialModel, Parameter, Reference};
use crate::scene::error::{Problem, Source};
use crate::scene::metal::Metal;
use crate::scene::spelling::nearest;

/// GGX widths below this are smooth for pbrt, and here.
const SMOOTH_ALPHA: f64 = 1e-3;
/// Mixes of mixes.
const MAX_DEPTH: u32 = 16;

/// A material as the file writes it; nothing is made of it until an object asks.
#[derive(Debug)]
pub(super) struct Written {
    pub kind: String,
    pub parameters: Parameters,
}

/// What the graphics state refers to.
#[derive(Clone, Debug)]
pub(super) enum Chosen {
    Direct(Rc<Written>),
    /// By `NamedMaterial`, the directive with its place.
    Named(String, Rc<Parameters>),
}

/// What becomes of a material.
#[derive(Clone, Debug)]
pub(super) enum Surface {
    /// The name of its description.
    Material(String),
    /// Light passes as if nothing were there.
    Nothing,
}

/// A model before it has a name.
#[derive(Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "a scene has a few of them, copied while it is read")]
enum Model {
    Known(MaterialModel),
    Nothing,
}

/// The materials of a file.
pub(super) struct Materials {
    written: HashMap<String, Rc<Written>>,
    names: Names,
    pub described: Vec<MaterialDescription>,
    /// By the address of what was written, which is kept. `None`: reported.
    known: HashMap<usize, (Rc<Written>, Option<Surface>)>,
    /// Of those that are turned inside out.
    reversed: HashMap<String, String>,
    /// Of those that are around a medium, or around nothing.
    filled: HashMap<(String, Option<String>), String>,
}

/// What making models needs.
pub(super) struct Context<'c, 'a> {
    pub textures: &'c mut Textures<'a>,
    pub folder: &'c Path,
    pub ignored: &'c mut Ignored,
    pub lenient: bool,
    pub problems: &'c mut Vec<Problem>,
    /// What cannot be rendered, and was replaced.
    pub refused: &'c mut Vec<Problem>,
}

impl Context<'_, '_> {
    /// What cannot be rendered: an error, or with `lenient` a warning.
    fn cannot(&mut self, problem: Problem) -> Result<(), Problem> {
        if !self.lenient {
            return Err(problem);
        }
        self.refused.push(problem);
        Ok(())
    }
}

impl Materials {
    pub fn new() -> Materials {
        Materials {
            written: HashMap::new(),
            names: Names::default(),
            described: Vec::new(),
            known: HashMap::new(),
            reversed: HashMap::new(),
            filled: HashMap::new(),
        }
    }

    /// `MakeNamedMaterial`.
    pub fn define(&mut self, name: String, written: Written) -> Result<(), Problem> {
        if self.written.contains_key(&name) {
            let message = format!("there is another material \"{}\"", shortened(&name));
            return Err(written.parameters.problem(message, "names of materials must differ"));
        }
        // Names that the file gives come before those that are made up for others.
        self.names.unique(&name);
        self.written.insert(name, Rc::new(written));
        Ok(())
    }

    /// The same surface around `inside`, or nothing but the boundary of that; one that no light gets into is as it was.
    pub fn filled(&mut self, surface: &Surface, inside: &Option<Reference>, at: &Source) -> Surface {
        let interior = Some(InteriorDescription { medium: inside.clone(), priority: 0 });
        let filler = inside.as_ref().map_or("nothing", |medium| &medium.name);
        let (known, material) = match surface {
            Surface::Material(name) => (name.as_str(), self.described.iter().find(|m| m.name == *name).cloned()),
            Surface::Nothing if inside.is_none() => return Surface::Nothing,
            Surface::Nothing => {
                let (name, source) = ("interface".to_owned(), at.clone());
                (
                    "interface",
                    Some(MaterialDescription { name, source, model: MaterialModel::Interface, interior: None }),
                )
            }
        };
        let Some(material) = material.filter(|material| material.model.has_inside()) else { return surface.clone() };
        let key = (known.to_owned(), inside.as_ref().map(|medium| medium.name.clone()));
        if let Some(known) = self.filled.get(&key) {
            return Surface::Material(known.clone());
        }
        let name = self.names.unique(&format!("{known} around {filler}"));
        self.described.push(MaterialDescription { name: name.clone(), interior, ..material });
        self.filled.insert(key, name.clone());
        Surface::Material(name)
    }

    /// The surface of what an object refers to; `None` for one whose problem was reported.
    pub fn surface(&mut self, chosen: &Chosen, context: &mut Context<'_, '_>) -> Option<Surface> {
        let (name, written) = match chosen {
            Chosen::Direct(written) => (None, written.clone()),
            Chosen::Named(name, place) => match self.find(name, place) {
                Ok(written) => (Some(name.clone()), written),
                Err(problem) => {
                    context.problems.push(problem);
                    return None;
                }
            },
        };
        let key = Rc::as_ptr(&written) as usize;
        if let Some((_, known)) = self.known.get(&key) {
            return known.clone();
        }
        let surface = match self.model(&written, 0, context) {
            Err(problem) => {
                context.problems.push(problem);
                None
            }
            Ok(Model::Nothing) => Some(Surface::Nothing),
            Ok(Model::Known(model)) => {
                let name = name.unwrap_or_else(|| self.names.unique(&written.kind));
                let source = written.parameters.source.clone();
                self.described.push(MaterialDescription { name: name.clone(), source, model, interior: None });
                Some(Surface::Material(name))
            }
        };
        context.problems.extend(written.parameters.unknown());
        self.known.insert(key, (written, surface.clone()));
        surface
    }

    fn find(&self, name: &str, place: &Parameters) -> Result<Rc<Written>, Problem> {
        self.written.get(name).cloned().ok_or_else(|| {
            let mut names: Vec<&str> = self.written.keys().map(String::as_str).collect();
            names.sort_unstable();
            let help = match nearest(name, &names) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => "define it by MakeNamedMaterial".to_owned(),
            };
            place.problem(format!("there is no material \"{}\"", shortened(name)), help)
        })
    }

    /// Whether an image is part of the material `name`.
    pub fn has_image(&self, name: &str) -> bool {
        let image = |colour: &Parameter<[f64; 3]>| matches!(colour, Parameter::Image { .. });
        let number = |number: &Parameter<f64>| matches!(number, Parameter::Image { .. });
        self.described.iter().find(|m| m.name == name).is_some_and(|material| match &material.model {
            MaterialModel::Lambert { albedo } | MaterialModel::Plastic { albedo, .. } => image(albedo),
            MaterialModel::RoughDielectric { roughness, .. } | MaterialModel::RoughConductor { roughness, .. } => {
                number(roughness)
            }
            MaterialModel::Principled { base_colour, roughness, transmission, .. } => {
                image(base_colour) || number(roughness) || number(transmission)
            }
            MaterialModel::Mirror { .. }
            | MaterialModel::Dielectric { .. }
            | MaterialModel::Conductor { .. }
            | MaterialModel::Interface => false,
        })
    }

    /// The name of the material as it is on a surface whose outside is where its inside was; the same for what has none.
    pub fn inside_out(&mut self, name: &str) -> String {
        if let Some(known) = self.reversed.get(name) {
            return known.clone();
        }
        let found = self.described.iter().find(|m| m.name == name).cloned();
        let swapped = found.as_ref().and_then(|material| match material.model {
            MaterialModel::Dielectric { ior, exterior, fresnel } => {
                Some(MaterialModel::Dielectric { ior: exterior, exterior: ior, fresnel })
            }
            MaterialModel::RoughDielectric { ior, exterior, roughness } => {
                Some(MaterialModel::RoughDielectric { ior: exterior, exterior: ior, roughness })
            }
            _ => None,
        });
        let turned = match (found, swapped) {
            (Some(material), Some(model)) => {
                let turned = self.names.unique(&format!("{name} (inside out)"));
                self.described.push(MaterialDescription { name: turned.clone(), model, ..material });
                turned
            }
            _ => name.to_owned(),
        };
        self.reversed.insert(name.to_owned(), turned.clone());
        turned
    }

    fn model(&self, written: &Written, depth: u32, context: &mut Context<'_, '_>) -> Result<Model, Problem> {
        let ps = &written.parameters;
        if ps.has("normalmap") {
            context.cannot(ps.cannot("normal maps of pbrt cannot be rendered", "leave `normalmap` out"))?;
        }
        if ps.has("displacement") {
            context.cannot(ps.cannot("displacements cannot be rendered", "bake it into the mesh"))?;
        }
        let model = match written.kind.as_str() {
            "diffuse" => {
                let albedo = context.textures.colour(ps, "reflectance", [0.5; 3])?;
                MaterialModel::Lambert { albedo: context.textures.describe_colour(&albedo, &ps.source)? }
            }
            "coateddiffuse" => coated_diffuse(ps, context)?,
            "conductor" => conductor(ps, context)?,
            "dielectric" => dielectric(ps, context)?,
            "thindielectric" => thin_dielectric(ps, context)?,
            "diffusetransmission" => diffuse_transmission(ps, context)?,
            "mix" => return self.mix(ps, depth, context),
            "interface" | "none" | "" => return Ok(Model::Nothing),
            other => {
                const KINDS: &str = "diffuse, coateddiffuse, conductor, dielectric, thindielectric and mix can";
                let message = format!("the material \"{}\" cannot be rendered", shortened(other));
                context.cannot(ps.cannot(message, format!("{KINDS}; `pbrt --upgrade` turns older files")))?;
                ps.ignore_all();
                MaterialModel::Lambert { albedo: Parameter::Constant([0.5; 3]) }
            }
        };
        Ok(Model::Known(model))
    }

    /// One of two materials at each point, the second with the probability `amount`: expressed where one is all, or both are
    /// diffuse.
    fn mix(&self, ps: &Parameters, depth: u32, context: &mut Context<'_, '_>) -> Result<Model, Problem> {
        let names = match ps.find("materials").map(|p| &p.values) {
            Some(Values::Texts(names)) if names.len() == 2 => names,
            _ => return Err(ps.problem("a mix needs \"string materials\" of two names", "name two materials")),
        };
        if depth >= MAX_DEPTH {
            return Err(ps.problem(format!("mixes of mixes go deeper than {MAX_DEPTH}"), "does one contain itself?"));
        }
        let amount = context.textures.number(ps, "amount", 0.5)?;
        let share = amount.constant().map(|[share, ..]| share.clamp(0.0, 1.0));
        let one = |name: &String| self.find(name, ps);
        let [first, second] = [one(&names[0])?, one(&names[1])?];
        match share {
            Some(0.0) => return self.model(&first, depth + 1, context),
            Some(1.0) => return self.model(&second, depth + 1, context),
            _ => {}
        }
        if first.kind == "diffuse" && second.kind == "diffuse" {
            let albedo = |written: &Written, context: &mut Context<'_, '_>| {
                context.textures.colour(&written.parameters, "reflectance", [0.5; 3])
            };
            let (a, b) = (albedo(&first, context)?, albedo(&second, context)?);
            let mixed = context.textures.mixed(a, b, amount, ps)?;
            let albedo = context.textures.describe_colour(&mixed, &ps.source)?;
            return Ok(Model::Known(MaterialModel::Lambert { albedo }));
        }
        let message = format!("a mix of \"{}\" and \"{}\" cannot be rendered", first.kind, second.kind);
        context.cannot(ps.cannot(message, "two diffuse materials can be mixed, or an amount of 0 or 1 given"))?;
        // The one that has more of it.
        let larger = if share.is_some_and(|share| share > 0.5) { second } else { first };
        self.model(&larger, depth + 1, context)
    }
}

/// The artist's roughness, `None` for a smooth surface.
fn roughness(ps: &Parameters, context: &mut Context<'_, '_>) -> Result<Option<Parameter<f64>>, Problem> {
    let remapped = ps.flag("remaproughness", true)?;
    let both = context.textures.number(ps, "roughness", 0.0)?;
    let along = if ps.has("uroughness") { context.textures.number(ps, "uroughness", 0.0)? } else { both.clone() };
    let across = if ps.has("vroughness") { context.textures.number(ps, "vroughness", 0.0)? } else { both };
    let same = match (&along, &across) {
        (Value::Constant(u), Value::Constant(v)) => u == v,
        (Value::Image { image: u, factor: f }, Value::Image { image: v, factor: g }) => Rc::ptr_eq(u, v) && f == g,
        _ => false,
    };
    if !same {
        let help = "give one `roughness`, or `uroughness` and `vroughness` that agree";
        context.cannot(ps.cannot("roughness that differs between directions cannot be rendered", help))?;
    }
    let described = context.textures.describe_roughness(&along, remapped, &ps.source)?;
    let smooth = matches!(described, Parameter::Constant(r) if r * r < SMOOTH_ALPHA);
    Ok((!smooth).then_some(described))
}

/// The index of the glass `name` at the sodium line.
fn index(ps: &Parameters, context: &mut Context<'_, '_>) -> Result<f64, Problem> {
    const USUAL: f64 = 1.5;
    let Some(parameter) = ps.find("eta") else { return Ok(USUAL) };
    let (index, disperses) = spectra::glass_index(parameter, context.folder)?;
    context.ignored.note_if(disperses, "the dispersion of glass (its index at the sodium line is taken)");
    if index == 0.0 {
        return Err(parameter.problem("an index of refraction is 0", "it must be above 0"));
    }
    Ok(index)
}

fn coated_diffuse(ps: &Parameters, context: &mut Context<'_, '_>) -> Result<MaterialModel, Problem> {
    let albedo = context.textures.colour(ps, "reflectance", [0.5; 3])?;
    let albedo = context.textures.describe_colour(&albedo, &ps.source)?;
    let (ior, roughness) = (index(ps, context)?, roughness(ps, context)?);
    if context.textures.colour(ps, "albedo", [0.0; 3])?.constant() != Some([0.0; 3]) {
        context.cannot(ps.cannot("a coat that scatters within cannot be rendered", "leave its `albedo` out"))?;
    }
    // Of a coat that does not scatter, and how pbrt samples it.
    ps.ignore(&["thickness", "g", "maxdepth", "nsamples"]);
    Ok(match roughness {
        None => MaterialModel::Plastic { albedo, ior },
        Some(roughness) => MaterialModel::Principled {
            base_colour: albedo,
            metalness: Parameter::Constant(0.0),
            roughness,
            transmission: Parameter::Constant(0.0),
            coverage: Parameter::Constant(1.0),
            ior,
            thin: true,
            normal: None,
            specular: None,
            coat: None,
        },
    })
}

fn conductor(ps: &Parameters, context: &mut Context<'_, '_>) -> Result<MaterialModel, Problem> {
    let copper = Metal::Copper.index();
    let (eta, k) = if let Some(parameter) = ps.find("reflectance") {
        if ps.has("eta") || ps.has("k") {
            return Err(parameter.problem("a conductor has `reflectance` beside `eta` or `k`", "give one of both"));
        }
        let value = context.textures.colour(ps, "reflectance", [0.5; 3])?;
        let Some(reflectance) = value.constant() else {
            return Err(ps.cannot("an image as a metal's reflectance cannot be rendered", "give a colour"));
        };
        // η = 1 and the k that reflects so much at normal incidence: r = k²/(4 + k²).
        ([1.0; 3], reflectance.map(|r| 2.0 * (r.min(0.9999) / (1.0 - r.min(0.9999))).sqrt()))
    } else {
        let read = |name: &str, default| {
            ps.find(name).map_or(Ok(default), |parameter| spectra::metal_index(parameter, context.folder))
        };
        (read("eta", copper.eta)?, read("k", copper.k)?)
    };
    Ok(match roughness(ps, context)? {
        None => MaterialModel::Conductor { eta, k },
        Some(roughness) => MaterialModel::RoughConductor { eta, k, roughness },
    })
}

fn dielectric(ps: &Parameters, context: &mut Context<'_, '_>) -> Result<MaterialModel, Problem> {
    let (ior, exterior) = (index(ps, context)?, 1.0);
    Ok(match roughness(ps, context)? {
        None => MaterialModel::Dielectric { ior, exterior, fresnel: true },
        Some(roughness) => MaterialModel::RoughDielectric { ior, exterior, roughness },
    })
}

/// Light goes to and fro between the two faces of pbrt's sheet, of which ours has one: F' = F + (1 − F)² F / (1 − F²) =
/// 2F/(1 + F) at normal incidence, so its index is that whose one face reflects so much.
fn thin_dielectric(ps: &Parameters, context: &mut Context<'_, '_>) -> Result<MaterialModel, Problem> {
    let index = index(ps, context)?;
    let face = ((index - 1.0) / (index + 1.0)).powi(2);
    let root = (2.0 * face / (1.0 + face)).sqrt();
    Ok(MaterialModel::Principled {
        base_colour: Parameter::Constant([1.0; 3]),
        metalness: Parameter::Constant(0.0),
        roughness: Parameter::Constant(0.0),
        transmission: Parameter::Constant(1.0),
        coverage: Parameter::Constant(1.0),
        ior: (1.0 + root) / (1.0 - root),
        thin: true,
        normal: None,
        specular: None,
        coat: None,
    })
}

fn diffuse_transmission(ps: &Parameters, context: &mut Context<'_, '_>) -> Result<MaterialModel, Problem> {
    let scale = ps.number("scale", 1.0)?;
    let albedo = context.textures.colour(ps, "reflectance", [0.25; 3])?;
    let through = context.textures.colour(ps, "transmittance", [0.25; 3])?;
    if through.constant() != Some([0.0; 3]) {
        let help = "give a `transmittance` of 0, or use diffuse";
        context.cannot(ps.cannot("diffuse light through a surface cannot be rendered", help))?;
    }
    let scaled = context.textures.scaled(albedo, scale, ps)?;
    Ok(MaterialModel::Lambert { albedo: context.textures.describe_colour(&scaled, &ps.source)? })
}
