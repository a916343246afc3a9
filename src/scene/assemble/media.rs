//! Media: their numbers, finding them by name, and the insides of materials.

use std::collections::HashMap;

use super::Report;
use super::materials::Materials;
use crate::radiometry::Spectrum;
use crate::scene::description::{MediumDescription, Reference, SceneDescription};
use crate::scene::error::{Problem, Source};
use crate::scene::ids::MediumId;
use crate::scene::material::Material;
use crate::scene::medium::{Interior, Media, Medium};
use crate::scene::spelling::nearest;

/// All media of the description, by the materials that they are inside of.
pub(super) fn assemble(description: &SceneDescription, materials: &Materials, report: &mut Report) -> Media {
    let names = names(&description.media, report);
    let media = description.media.iter().map(|item| medium(item, report)).collect();
    let mut find = |reference: &Reference| find(reference, &names, report);
    let interiors = description.materials.iter().zip(&materials.materials);
    let interiors = interiors
        .map(|(item, material)| {
            let own = item.interior.as_ref();
            let medium = own.and_then(|interior| find(interior.medium.as_ref()?));
            let interior = Interior { medium, priority: own.map_or(0, |interior| interior.priority) };
            material.has_inside().then_some(interior)
        })
        .collect();
    let atmosphere = description.atmosphere.as_ref().and_then(&mut find);
    let of_object = |reference: &Reference| materials.lookup(&reference.name);
    let has_interfaces =
        description.objects.iter().any(|object| of_object(&object.material).is_some_and(Material::is_interface));
    Media { media, interiors, atmosphere, has_interfaces }
}

fn names<'d>(media: &'d [MediumDescription], report: &mut Report) -> HashMap<&'d str, MediumId> {
    let mut sources: HashMap<&str, &Source> = HashMap::new();
    let mut names = HashMap::new();
    for (i, item) in media.iter().enumerate() {
        if let Some(first) = sources.insert(&item.name, &item.source) {
            let problem = Problem::new(format!("two media are named `{}`", item.name)).at(&item.source);
            report.problem(problem.help(format!("the other is at {first}")));
        }
        names.insert(item.name.as_str(), MediumId(i as u32));
    }
    names
}

fn medium(item: &MediumDescription, report: &mut Report) -> Medium {
    let mut refuse = |what: String, help: &str| {
        let problem = Problem::new(format!("medium `{}` {what}", item.name));
        report.problem(problem.help(help).at(&item.source));
    };
    let sound = |sigma: &[f64; 3]| sigma.iter().all(|s| *s >= 0.0 && s.is_finite());
    if !sound(&item.sigma_a) || !sound(&item.sigma_s) {
        refuse("has a coefficient that is no finite number ≥ 0".to_owned(), "give 1/m");
    }
    if item.sigma_a == [0.0; 3] && item.sigma_s == [0.0; 3] {
        refuse("neither absorbs nor scatters".to_owned(), "give `sigma_a` or `sigma_s` in 1/m, or remove it");
    }
    if !(item.g > -1.0 && item.g < 1.0) {
        refuse(format!("has `g` {}", item.g), "a mean cosine is above −1 and below 1; 0 scatters evenly");
    }
    let spectrum = |sigma: [f64; 3]| Spectrum::from(sigma);
    Medium {
        absorption: spectrum(item.sigma_a),
        scattering: spectrum(item.sigma_s),
        asymmetry: item.g,
        density: item.density.clone(),
    }
}

/// The medium of that name; an unknown one is reported. An empty name stands for one that was reported.
fn find(reference: &Reference, names: &HashMap<&str, MediumId>, report: &mut Report) -> Option<MediumId> {
    let found = names.get(reference.name.as_str()).copied();
    if found.is_none() && !reference.name.is_empty() {
        let mut known: Vec<&str> = names.keys().copied().collect();
        known.sort_unstable();
        let help = match nearest(&reference.name, &known) {
            Some(near) => format!("did you mean `{near}`?"),
            None if known.is_empty() => "add a [media.NAME] table".to_owned(),
            None => format!("known media: {}", known.join(", ")),
        };
        let problem = Problem::new(format!("there is no medium `{}`", reference.name));
        report.problem(problem.help(help).at(&reference.source));
    }
    found
}
