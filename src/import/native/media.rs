//! `[media.*]`, `atmosphere`, and the `interior` of materials.

use std::sync::Arc;

use toml::Spanned;

use crate::import::assets::Assets;
use crate::import::keyed::convert::{
    Array, Choice, Colour, Integer, List, NON_NEGATIVE, Number, POINT, POSITIVE, Text,
};
use crate::import::keyed::reader::Section;
use crate::import::volume::{NumberFormat, Volume};
use crate::math::{Transform, Vec3};
use crate::scene::density::{DensityGrid, Interpolation};
use crate::scene::description::{InteriorDescription, MediumDescription, Reference};
use crate::scene::error::Problem;

/// A mean cosine that is not that of one direction.
const MEAN_COSINE: Number = Number::between(-1.0, 1.0);

const MAX_PRIORITY: u64 = 1_000_000;

/// Samples of a grid along one axis.
const MAX_COUNT: u64 = 65_536;

pub(super) fn read(root: &Section<'_>, assets: &Assets) -> Vec<MediumDescription> {
    let Some(media) = root.table("media") else { return Vec::new() };
    let read_one = |(name, value): (&Spanned<_>, _)| {
        let name: &str = toml::de::DeString::as_ref(name.get_ref());
        let section = Section::of_value(root.reader, format!("medium `{name}`"), value);
        section.map(|section| read_medium(name, &section, assets))
    };
    media.entries().into_iter().filter_map(read_one).collect()
}

fn read_medium(name: &str, section: &Section<'_>, assets: &Assets) -> MediumDescription {
    let sigma = |key| section.or(key, Colour(NON_NEGATIVE), [0.0; 3]);
    let (sigma_a, sigma_s) = (sigma("sigma_a"), sigma("sigma_s"));
    let scale = section.or("scale", POSITIVE, 1.0);
    let g = section.or("g", MEAN_COSINE, 0.0);
    let density = section.table("density").and_then(|section| read_density(&section, assets));
    section.finish();
    let scaled = |sigma: [f64; 3]| sigma.map(|s| s * scale);
    MediumDescription {
        name: name.to_owned(),
        source: section.source(),
        sigma_a: scaled(sigma_a),
        sigma_s: scaled(sigma_s),
        g,
        density: density.map(Arc::new),
    }
}

/// A grid over a box along the world's axes; one that cannot be used is reported.
fn read_density(section: &Section<'_>, assets: &Assets) -> Option<DensityGrid> {
    let samples = read_samples(section, assets);
    let corner = |key| section.required(key, POINT, [f64::NAN; 3]);
    let (min, max) = (corner("min"), corner("max"));
    let between = section.or(
        "between",
        Choice { names: Interpolation::NAMES, from_name: Interpolation::from_name },
        Interpolation::Linear,
    );
    section.finish();
    let Volume { counts, samples } = samples?;
    let size = Vec3::from_array(max) - Vec3::from_array(min);
    // A corner that was reported is not a number.
    if size.is_nan() {
        return None;
    }
    let place = Transform::scale(size).filter(|_| size.cmpgt(Vec3::ZERO).all());
    let Some(scale) = place else {
        let problem =
            Problem::new("the box of a density has no inside").help("`max` lies beyond `min` along each axis");
        section.reader.report(problem.at(&section.source()));
        return None;
    };
    let place = Transform::translate(Vec3::from_array(min)).compose(&scale);
    Some(DensityGrid { place, counts, samples, between })
}

/// From a file, or as they are written.
fn read_samples(section: &Section<'_>, assets: &Assets) -> Option<Volume> {
    let file = section.optional("file", Text);
    let values = section.optional("values", List(NON_NEGATIVE));
    let counts = section.optional("counts", Array::<_, 3>(Integer::within(1, MAX_COUNT)));
    let counts = counts.map(|counts| counts.map(|n| n as usize));
    let numbers =
        section.optional("numbers", Choice { names: NumberFormat::NAMES, from_name: NumberFormat::from_name });
    let problem = match (file, values, counts, numbers) {
        (Some(file), None, None, None) => match assets.volume(&file, None, &section.source()) {
            Ok(volume) => return Some(volume),
            Err(problem) => problem,
        },
        (Some(file), None, Some(counts), Some(numbers)) => {
            match assets.volume(&file, Some((counts, numbers)), &section.source()) {
                Ok(volume) => return Some(volume),
                Err(problem) => problem,
            }
        }
        (None, Some(values), Some(counts), None) if values.len() == counts.iter().product::<usize>() => {
            return Some(Volume { counts, samples: values.iter().map(|v| *v as f32).collect() });
        }
        _ => Problem::new("a density does not say what its samples are").help(
            "give `file` of an .npy array; or `file`, `counts` and `numbers` of a raw one; or `counts` and as many `values`",
        ),
    };
    section.reader.report(problem.at_unless_placed(&section.source()));
    None
}

/// The medium that `key` names.
pub(super) fn reference(section: &Section<'_>, key: &'static str) -> Option<Reference> {
    let value = section.get(key)?;
    let name = section.reader.convert(key, value, &Text).unwrap_or_default();
    Some(Reference { name, source: section.reader.source(value.span()) })
}

/// `interior` and `priority` of a material that light goes into.
pub(super) fn read_interior(section: &Section<'_>) -> Option<InteriorDescription> {
    let medium = reference(section, "interior");
    let priority = section.optional("priority", Integer::within(0, MAX_PRIORITY));
    let given = medium.is_some() || priority.is_some();
    given.then(|| InteriorDescription { medium, priority: priority.unwrap_or(0) as u32 })
}
