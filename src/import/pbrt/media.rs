//! `MakeNamedMedium` and `MediumInterface`: what fills shapes · 1/m.
//!
//! A ray of pbrt's is told by each surface what medium it gets into; ours knows what it is inside of. Both agree where a
//! shape's outside is what the shape lies in, so that its inside alone is taken.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use glam::DMat4;

use super::budget::Budget;
use super::parameters::{Parameters, Values, shortened};
use super::spectra;
use crate::math::{Transform, Vec3};
use crate::scene::density::{DensityGrid, Interpolation};
use crate::scene::description::{MediumDescription, Reference};
use crate::scene::error::{Problem, Source};
use crate::scene::spelling::nearest;

/// What pbrt takes where nothing is said, 1/m.
const USUAL_ABSORPTION: [f64; 3] = [0.0011, 0.0024, 0.014];
const USUAL_SCATTERING: [f64; 3] = [2.55, 3.21, 3.77];
/// Samples along an axis at most.
const MAX_COUNT: i64 = 4096;

/// `MediumInterface`: names, empty for nothing.
#[derive(Debug)]
pub(super) struct Interface {
    pub inside: String,
    pub outside: String,
    pub source: Source,
}

/// A medium as the file writes it.
#[derive(Debug)]
struct Written {
    parameters: Parameters,
    to_world: DMat4,
}

/// The media of a file.
#[derive(Debug, Default)]
pub(super) struct Media {
    written: HashMap<String, Written>,
    /// In the order of the file.
    names: Vec<String>,
    /// Named as the inside of a shape.
    insides: HashSet<String>,
    /// Those that begin at some shape.
    begun: HashSet<String>,
    /// Where each was first named as the outside of a shape.
    outsides: HashMap<String, Source>,
}

impl Media {
    /// `MakeNamedMedium`, where the matrix was `to_world`.
    pub fn define(&mut self, name: String, parameters: Parameters, to_world: DMat4) -> Result<(), Problem> {
        if self.written.contains_key(&name) {
            let message = format!("there is another medium \"{}\"", shortened(&name));
            return Err(parameters.problem(message, "names of media must differ"));
        }
        self.names.push(name.clone());
        self.written.insert(name, Written { parameters, to_world });
        Ok(())
    }

    /// What fills a shape: the name of a medium, nothing at all, or what is not said.
    pub fn inside(&mut self, interface: Option<&Rc<Interface>>) -> Result<Option<Option<Reference>>, Problem> {
        let Some(interface) = interface else { return Ok(None) };
        let Interface { inside, outside, source } = &**interface;
        for name in [inside, outside].into_iter().filter(|name| !name.is_empty()) {
            self.known(name, source)?;
        }
        if !outside.is_empty() {
            self.outsides.entry(outside.clone()).or_insert_with(|| source.clone());
        }
        if inside.is_empty() {
            return Ok((!outside.is_empty()).then_some(None));
        }
        self.insides.insert(inside.clone());
        if inside != outside {
            self.begun.insert(inside.clone());
        }
        Ok(Some(Some(Reference { name: inside.clone(), source: source.clone() })))
    }

    fn known(&self, name: &str, at: &Source) -> Result<(), Problem> {
        if self.written.contains_key(name) {
            return Ok(());
        }
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let help = match nearest(name, &names) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => "define it by MakeNamedMedium".to_owned(),
        };
        Err(Problem::new(format!("there is no medium \"{}\"", shortened(name))).help(help).at(at))
    }

    /// Media that lie around shapes and fill none: they would be missing.
    pub fn missing(&self) -> Vec<(&str, &Source)> {
        let mut missing: Vec<(&str, &Source)> = self
            .outsides
            .iter()
            .filter(|(name, _)| !self.begun.contains(*name))
            .map(|(name, source)| (name.as_str(), source))
            .collect();
        missing.sort_unstable_by_key(|(name, _)| *name);
        missing
    }

    /// Those that fill something, in a world that `ours` makes of pbrt's, and what is wrong with any.
    pub fn describe(&self, ours: &DMat4, folder: &Path, budget: &mut Budget) -> (Vec<MediumDescription>, Vec<Problem>) {
        let (mut described, mut problems) = (Vec::new(), Vec::new());
        for name in &self.names {
            let Written { parameters, to_world } = &self.written[name];
            match medium(name, parameters, &(*ours * *to_world), folder, budget) {
                Err(problem) => problems.push(problem),
                Ok(medium) if self.insides.contains(name) => described.push(medium),
                Ok(_) => {}
            }
            problems.extend(parameters.unknown());
        }
        (described, problems)
    }
}

fn medium(
    name: &str,
    ps: &Parameters,
    to_world: &DMat4,
    folder: &Path,
    budget: &mut Budget,
) -> Result<MediumDescription, Problem> {
    let density = match ps.text("type")? {
        Some("homogeneous") => None,
        Some("uniformgrid") => Some(Arc::new(density(ps, to_world, budget)?)),
        Some(other) => {
            ps.ignore_all();
            let message = format!("media of the type \"{}\" cannot be rendered", shortened(other));
            return Err(ps.cannot(message, "homogeneous and uniformgrid can"));
        }
        None => return Err(ps.problem("the medium has no \"string type\"", "homogeneous or uniformgrid")),
    };
    if ps.has("preset") {
        return Err(ps.cannot("media by the name of a substance cannot be rendered", "give sigma_a and sigma_s"));
    }
    for glow in ["Le", "temperature"] {
        let dark = |values: &Values| matches!(values, Values::Numbers(all) if all.iter().all(|&x| x == 0.0));
        if ps.find(glow).is_some_and(|parameter| !dark(&parameter.values)) {
            let message = format!("media that glow (`{glow}`) cannot be rendered");
            return Err(ps.cannot(message, "leave it out"));
        }
    }
    ps.ignore(&["Lescale", "temperatureoffset", "temperaturescale"]);
    let scale = ps.number("scale", 1.0)?;
    let sigma = |key: &str, usual: [f64; 3]| {
        let sigma = ps.find(key).map_or(Ok(usual), |parameter| spectra::coefficient(parameter, folder))?;
        let scaled = sigma.map(|sigma| sigma * scale);
        if scaled.iter().all(|sigma| sigma.is_finite() && *sigma >= 0.0) {
            return Ok(scaled);
        }
        Err(ps.problem(format!("`{key}` times `scale` is {scaled:?}"), "coefficients are finite and at least 0"))
    };
    let (sigma_a, sigma_s) = (sigma("sigma_a", USUAL_ABSORPTION)?, sigma("sigma_s", USUAL_SCATTERING)?);
    let g = ps.number("g", 0.0)?;
    if !(-1.0 < g && g < 1.0) {
        return Err(ps.problem(format!("the mean cosine `g` is {g}"), "it lies between -1 and 1"));
    }
    Ok(MediumDescription { name: name.to_owned(), source: ps.source.clone(), sigma_a, sigma_s, g, density })
}

/// A grid over the box from `p0` to `p1`. pbrt's density falls to zero in the outermost half cells, towards samples of zero
/// beside the grid; here those are a layer of samples of their own.
fn density(ps: &Parameters, to_world: &DMat4, budget: &mut Budget) -> Result<DensityGrid, Problem> {
    let [nx, ny, nz] = ["nx", "ny", "nz"].map(|key| ps.integer(key, 1..=MAX_COUNT, 1));
    let counts = [nx? as usize, ny? as usize, nz? as usize];
    let samples: Vec<f32> = match ps.find("density").map(|parameter| (parameter, &parameter.values)) {
        Some((_, Values::Numbers(all))) => all.iter().map(|&x| x as f32).collect(),
        Some((parameter, _)) => return Err(parameter.problem("`density` is not of numbers", "write \"float density\"")),
        None => return Err(ps.problem("a uniformgrid needs \"float density\"", "give nx ny nz numbers")),
    };
    let wanted: usize = counts.iter().product();
    if samples.len() != wanted {
        let message = format!("`density` has {} numbers, not nx ny nz = {wanted}", samples.len());
        return Err(ps.problem(message, "one is missing or too many"));
    }
    if !samples.iter().all(|x| x.is_finite() && *x >= 0.0) {
        return Err(ps.problem("a density is negative or no number", "densities are finite and at least 0"));
    }
    let [low, high] = [ps.point("p0", [0.0; 3])?, ps.point("p1", [1.0; 3])?].map(Vec3::from_array);
    let padded = counts.map(|n| n + 2);
    budget.spend(padded.iter().product(), size_of::<f32>(), &ps.source)?;
    let cell = (high - low) / Vec3::from_array(counts.map(|n| n as f64));
    let (origin, size) = (low - cell, (high - low) + cell * 2.0);
    let axes = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z].map(|axis| to_world.transform_vector3(axis));
    let place = Transform::new(axes, to_world.transform_point3(origin));
    let Some(place) = place.filter(|_| size.min_element() > 0.0) else {
        return Err(ps.problem("the box of a medium has no inside", "`p1` lies beyond `p0` along each axis"));
    };
    let within = |i: usize, n: usize| (1..=n).contains(&i).then(|| i - 1);
    let mut all = Vec::with_capacity(padded.iter().product());
    for z in 0..padded[2] {
        for y in 0..padded[1] {
            for x in 0..padded[0] {
                let cell = (within(x, counts[0]), within(y, counts[1]), within(z, counts[2]));
                let (Some(x), Some(y), Some(z)) = cell else {
                    all.push(0.0);
                    continue;
                };
                all.push(samples[(z * counts[1] + y) * counts[0] + x]);
            }
        }
    }
    Ok(DensityGrid { place, counts: padded, samples: all, between: Interpolation::Linear })
}
