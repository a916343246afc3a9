//! Materials: their numbers, their textures, and finding them by name.

use std::collections::HashMap;

use super::Report;
use crate::radiometry::Spectrum;
use crate::scene::description::{MaterialDescription, MaterialModel, Parameter, Reference, SceneDescription};
use crate::scene::error::{Problem, Source};
use crate::scene::ids::{MaterialId, TextureId};
use crate::scene::material::{Coat, Material, NormalMap, Specular};
use crate::scene::spelling::nearest;
use crate::scene::texture::{ImageTexture, Textured};

/// Below this GGX lobes are too narrow for their own arithmetic; smooth materials have names of their own.
const MIN_ALPHA: f64 = 1e-4;

pub(super) struct Materials {
    pub materials: Vec<Material>,
    pub textures: Vec<ImageTexture>,
    by_name: HashMap<String, MaterialId>,
}

impl Materials {
    pub fn assemble(description: &SceneDescription, report: &mut Report) -> Materials {
        let textures = description.textures.iter().map(|t| t.image.clone()).collect();
        let mut assembled = Materials { materials: Vec::new(), textures, by_name: HashMap::new() };
        let mut sources: HashMap<&str, &Source> = HashMap::new();
        for item in &description.materials {
            let material = assembled.material(item, report);
            let id = MaterialId(assembled.materials.len() as u32);
            assembled.materials.push(material);
            if let Some(first) = sources.insert(&item.name, &item.source) {
                let problem = Problem::new(format!("two materials are named `{}`", item.name)).at(&item.source);
                report.problem(problem.help(format!("the other is at {first}")));
            }
            assembled.by_name.insert(item.name.clone(), id);
        }
        assembled
    }

    pub fn lookup(&self, name: &str) -> Option<&Material> {
        self.by_name.get(name).and_then(|id| self.materials.get(id.index()))
    }

    /// Of all, in their order.
    pub fn names(&self) -> Vec<String> {
        let mut names = vec![String::new(); self.materials.len()];
        self.by_name.iter().for_each(|(name, id)| names[id.index()].clone_from(name));
        names
    }

    /// The material of that name; an unknown one is reported. An empty name stands for one that was reported.
    pub fn find(&self, reference: &Reference, report: &mut Report) -> Option<MaterialId> {
        let found = self.by_name.get(&reference.name).copied();
        if found.is_none() && !reference.name.is_empty() {
            let mut names: Vec<&str> = self.by_name.keys().map(String::as_str).collect();
            names.sort_unstable();
            let help = match nearest(&reference.name, &names) {
                Some(near) => format!("did you mean `{near}`?"),
                None if names.is_empty() => "add a [materials.NAME] table".to_owned(),
                None => format!("known materials: {}", names.join(", ")),
            };
            let problem = Problem::new(format!("there is no material `{}`", reference.name));
            report.problem(problem.help(help).at(&reference.source));
        }
        found
    }

    fn material(&mut self, item: &MaterialDescription, report: &mut Report) -> Material {
        let mut checks = Checks { item, report };
        match item.model {
            MaterialModel::Lambert { albedo } => Material::Lambert { albedo: self.reflectance(albedo, &mut checks) },
            MaterialModel::Mirror { reflectance } => {
                Material::Mirror { reflectance: self.reflectance(reflectance, &mut checks) }
            }
            MaterialModel::Dielectric { ior, exterior, fresnel } => {
                checks.indices(ior, exterior);
                Material::Dielectric { ior, exterior, fresnel }
            }
            MaterialModel::Interface => Material::Interface,
            MaterialModel::Conductor { eta, k } => {
                let (eta, k) = checks.metal(eta, k);
                Material::Conductor { eta, k }
            }
            MaterialModel::RoughDielectric { ior, exterior, roughness } => {
                checks.indices(ior, exterior);
                Material::RoughDielectric { ior, exterior, alpha: self.alpha(roughness, &mut checks) }
            }
            MaterialModel::RoughConductor { eta, k, roughness } => {
                let (eta, k) = checks.metal(eta, k);
                Material::RoughConductor { eta, k, alpha: self.alpha(roughness, &mut checks) }
            }
            MaterialModel::Plastic { albedo, ior } => {
                checks.index("ior", ior);
                Material::Plastic { albedo: self.reflectance(albedo, &mut checks), ior }
            }
            MaterialModel::Principled {
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
            } => {
                checks.index("ior", ior);
                let solid = !thin && transmission != Parameter::Constant(0.0);
                if solid && coverage != Parameter::Constant(1.0) {
                    let help =
                        "holes belong to surfaces, not to what they enclose: leave `coverage` out, or set `thin`";
                    checks.refuse("is solid glass with `coverage`".to_owned(), help);
                }
                let alpha = self.alpha_or_smooth(roughness, &mut checks);
                Material::Principled {
                    base_colour: self.reflectance(base_colour, &mut checks),
                    metalness: self.share("metalness", metalness, &mut checks),
                    transmission: self.share("transmission", transmission, &mut checks),
                    coverage: self.share("coverage", coverage, &mut checks),
                    alpha,
                    ior,
                    thin,
                    normal: normal.map(|map| NormalMap { texture: TextureId(map.texture as u32), scale: map.scale }),
                    specular: specular.map(|specular| Specular {
                        weight: self.share("specular", specular.weight, &mut checks),
                        colour: self.multiplier("specular_colour", specular.colour, &mut checks),
                    }),
                    coat: coat.map(|coat| {
                        checks.index("coat_ior", coat.ior);
                        let weight = self.share("coat", coat.weight, &mut checks);
                        let alpha = self.alpha_or_smooth(coat.roughness, &mut checks);
                        Coat { weight, alpha, ior: coat.ior }
                    }),
                }
            }
        }
    }

    fn reflectance(&self, parameter: Parameter<[f64; 3]>, checks: &mut Checks<'_>) -> Textured<Spectrum> {
        match parameter {
            Parameter::Constant(value) => {
                if !value.iter().all(|c| (0.0..=1.0).contains(c)) {
                    checks.refuse(format!("reflects {value:?} of the light"), "each share must be from 0 to 1");
                }
                Textured::Constant(Spectrum::from(value))
            }
            Parameter::Image { texture, factor } => {
                let brightest = self.textures.get(texture).map_or([0.0; 3], brightest);
                if !(0..3).all(|c| (0.0..=1.0 + 1e-6).contains(&(factor[c] * f64::from(brightest[c])))) {
                    let brightest = (0..3).map(|c| factor[c] * f64::from(brightest[c])).fold(0.0, f64::max);
                    let help = "lower `factor` until no texel times factor is above 1";
                    checks.refuse(format!("reflects up to {brightest:.3} of the light"), help);
                }
                Textured::Image { texture: TextureId(texture as u32), factor: Spectrum::from(factor) }
            }
        }
    }

    /// A colour without an upper end.
    fn multiplier(&self, name: &str, parameter: Parameter<[f64; 3]>, checks: &mut Checks<'_>) -> Textured<Spectrum> {
        let (Parameter::Constant(value) | Parameter::Image { factor: value, .. }) = parameter;
        if !value.iter().all(|c| *c >= 0.0 && c.is_finite()) {
            checks.refuse(format!("has `{name}` {value:?}"), "each component must be a finite number from 0 on");
        }
        match parameter {
            Parameter::Constant(value) => Textured::Constant(Spectrum::from(value)),
            Parameter::Image { texture, factor } => {
                Textured::Image { texture: TextureId(texture as u32), factor: Spectrum::from(factor) }
            }
        }
    }

    /// A number from 0 to 1.
    fn share(&self, name: &str, parameter: Parameter<f64>, checks: &mut Checks<'_>) -> Textured<f64> {
        let (most, textured) = match parameter {
            Parameter::Constant(value) => (value, Textured::Constant(value)),
            Parameter::Image { texture, factor } => {
                let [most, ..] = self.textures.get(texture).map_or([0.0; 3], brightest);
                (factor * f64::from(most), Textured::Image { texture: TextureId(texture as u32), factor })
            }
        };
        if !(0.0..=1.0 + 1e-6).contains(&most) {
            checks.refuse(format!("has `{name}` {most}"), "it must be from 0 to 1");
        }
        textured
    }

    /// As [`Materials::alpha`], where a roughness of 0 all over is a smooth surface.
    fn alpha_or_smooth(&mut self, roughness: Parameter<f64>, checks: &mut Checks<'_>) -> Textured<f64> {
        match roughness {
            Parameter::Constant(0.0) => Textured::Constant(0.0),
            _ => self.alpha(roughness, checks),
        }
    }

    /// alpha = roughness², in an image texel by texel.
    fn alpha(&mut self, roughness: Parameter<f64>, checks: &mut Checks<'_>) -> Textured<f64> {
        match roughness {
            Parameter::Constant(value) => {
                if !(value > 0.0 && value <= 1.0) {
                    checks.refuse(format!("has roughness {value}"), "it must be above 0 and at most 1");
                }
                let alpha = value * value;
                if alpha < MIN_ALPHA {
                    checks.raised_roughness();
                }
                Textured::Constant(alpha.max(MIN_ALPHA))
            }
            Parameter::Image { texture, factor } => {
                let Some(image) = self.textures.get(texture) else { return Textured::Constant(1.0) };
                let alpha = |roughness: f32| (f64::from(roughness) * factor).clamp(0.0, 1.0).powi(2);
                // It goes up, or down, all the way.
                if image.texels.extremes().as_flattened().iter().any(|roughness| alpha(*roughness) < MIN_ALPHA) {
                    checks.raised_roughness();
                }
                let texels = image.texels.mapped(|_, roughness| alpha(roughness).max(MIN_ALPHA) as f32);
                let squared = ImageTexture { texels, ..*image };
                self.textures.push(squared);
                Textured::Image { texture: TextureId(self.textures.len() as u32 - 1), factor: 1.0 }
            }
        }
    }
}

fn brightest(image: &ImageTexture) -> [f32; 3] {
    image.texels.extremes()[1].map(|most| most.max(0.0))
}

struct Checks<'a> {
    item: &'a MaterialDescription,
    report: &'a mut Report,
}

impl Checks<'_> {
    fn refuse(&mut self, what: String, help: &str) {
        let problem = Problem::new(format!("material `{}` {what}", self.item.name));
        self.report.problem(problem.help(help).at(&self.item.source));
    }
    fn raised_roughness(&mut self) {
        let least = MIN_ALPHA.sqrt();
        let warning = Problem::new(format!("material `{}`: roughness below {least} is raised to it", self.item.name));
        self.report.warning(warning.help("for a smooth surface use the smooth material").at(&self.item.source));
    }
    fn index(&mut self, name: &str, value: f64) {
        if !(value > 0.0 && value.is_finite()) {
            self.refuse(format!("has `{name}` {value}"), "an index of refraction is a finite number > 0");
        }
    }
    fn indices(&mut self, ior: f64, exterior: f64) {
        self.index("ior", ior);
        self.index("exterior", exterior);
        if ior == exterior {
            let message = format!("material `{}` is invisible: inside and outside have index {ior}", self.item.name);
            self.report.warning(Problem::new(message).help("is `exterior` meant?").at(&self.item.source));
        }
    }
    fn metal(&mut self, eta: [f64; 3], k: [f64; 3]) -> (Spectrum, Spectrum) {
        let sound = eta.iter().all(|e| *e > 0.0 && e.is_finite()) && k.iter().all(|k| *k >= 0.0 && k.is_finite());
        if !sound {
            self.refuse(format!("has the complex index {eta:?} + i {k:?}"), "eta must be > 0 and k ≥ 0");
        }
        (Spectrum::from(eta), Spectrum::from(k))
    }
}
