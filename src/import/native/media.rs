//! `[media.*]`, `atmosphere`, and the `interior` of materials.

use toml::Spanned;

use crate::import::keyed::convert::{Colour, Integer, NON_NEGATIVE, Number, POSITIVE, Text};
use crate::import::keyed::reader::Section;
use crate::scene::description::{InteriorDescription, MediumDescription, Reference};

/// A mean cosine that is not that of one direction.
const MEAN_COSINE: Number = Number::between(-1.0, 1.0);

const MAX_PRIORITY: u64 = 1_000_000;

pub(super) fn read(root: &Section<'_>) -> Vec<MediumDescription> {
    let Some(media) = root.table("media") else { return Vec::new() };
    let read_one = |(name, value): (&Spanned<_>, _)| {
        let name: &str = toml::de::DeString::as_ref(name.get_ref());
        let section = Section::of_value(root.reader, format!("medium `{name}`"), value);
        section.map(|section| read_medium(name, &section))
    };
    media.entries().into_iter().filter_map(read_one).collect()
}

fn read_medium(name: &str, section: &Section<'_>) -> MediumDescription {
    let sigma = |key| section.or(key, Colour(NON_NEGATIVE), [0.0; 3]);
    let (sigma_a, sigma_s) = (sigma("sigma_a"), sigma("sigma_s"));
    let scale = section.or("scale", POSITIVE, 1.0);
    let g = section.or("g", MEAN_COSINE, 0.0);
    section.finish();
    let scaled = |sigma: [f64; 3]| sigma.map(|s| s * scale);
    MediumDescription {
        name: name.to_owned(),
        source: section.source(),
        sigma_a: scaled(sigma_a),
        sigma_s: scaled(sigma_s),
        g,
    }
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
