//! `[materials.*]`.

use toml::Spanned;
use toml::de::DeValue;

use super::media;
use crate::import::assets::Assets;
use crate::import::image::ColourSpace;
use crate::import::keyed::convert::{
    Boolean, Choice, Colour, Convert, FRACTION, Mismatch, NON_NEGATIVE, Number, POSITIVE, Text, found,
};
use crate::import::keyed::reader::Section;
use crate::scene::description::{
    CoatDescription, MaterialDescription, MaterialModel, NormalMapDescription, Parameter, SpecularDescription,
};
use crate::scene::metal::Metal;
use crate::scene::texture::Wrap;

#[derive(Clone, Copy)]
enum MaterialName {
    Lambert,
    Mirror,
    Dielectric,
    Conductor,
    RoughDielectric,
    RoughConductor,
    Plastic,
    Principled,
    Interface,
}

impl MaterialName {
    fn has_inside(self) -> bool {
        match self {
            MaterialName::Dielectric
            | MaterialName::RoughDielectric
            | MaterialName::Principled
            | MaterialName::Interface => true,
            MaterialName::Lambert
            | MaterialName::Mirror
            | MaterialName::Conductor
            | MaterialName::RoughConductor
            | MaterialName::Plastic => false,
        }
    }
}

const MATERIALS: Choice<'_, MaterialName> = Choice {
    names: &[
        "lambert",
        "mirror",
        "dielectric",
        "conductor",
        "rough_dielectric",
        "rough_conductor",
        "plastic",
        "principled",
        "interface",
    ],
    from_name: |name| match name {
        "lambert" => Some(MaterialName::Lambert),
        "mirror" => Some(MaterialName::Mirror),
        "dielectric" => Some(MaterialName::Dielectric),
        "conductor" => Some(MaterialName::Conductor),
        "rough_dielectric" => Some(MaterialName::RoughDielectric),
        "rough_conductor" => Some(MaterialName::RoughConductor),
        "plastic" => Some(MaterialName::Plastic),
        "principled" => Some(MaterialName::Principled),
        "interface" => Some(MaterialName::Interface),
        _ => None,
    },
};

pub(super) const SPACES: Choice<'_, ColourSpace> =
    Choice { names: ColourSpace::NAMES, from_name: ColourSpace::from_name };

const WRAPS: Choice<'_, Wrap> = Choice {
    names: &["repeat", "clamp", "mirror"],
    from_name: |name| match name {
        "repeat" => Some(Wrap::Repeat),
        "clamp" => Some(Wrap::Clamp),
        "mirror" => Some(Wrap::Mirror),
        _ => None,
    },
};

/// Reflectances lie in [0, 1].
const REFLECTANCE: Colour = Colour(FRACTION);
/// Zero would be a smooth surface, which has a material of its own.
const ROUGHNESS: Number = Number::above_up_to(0.0, 1.0);

pub(super) fn read(root: &Section<'_>, assets: &mut Assets) -> Vec<MaterialDescription> {
    let Some(materials) = root.table("materials") else { return Vec::new() };
    let read_one = |(name, value): (&Spanned<_>, _)| {
        let name: &str = toml::de::DeString::as_ref(name.get_ref());
        let label = format!("material `{name}`");
        Section::of_value(root.reader, label, value).map(|section| read_material(name, section, assets))
    };
    materials.entries().into_iter().filter_map(read_one).collect()
}

fn read_material(name: &str, section: Section<'_>, assets: &mut Assets) -> MaterialDescription {
    let source = section.source();
    let kind = match section.get("type") {
        Some(value) => section.reader.convert("type", value, &MATERIALS),
        None => {
            section.missing("type", &MATERIALS.expects());
            None
        }
    };
    let (model, interior) = match kind {
        Some(kind) => {
            let model = read_model(kind, &section, assets);
            let interior = if kind.has_inside() { media::read_interior(&section) } else { None };
            if matches!(kind, MaterialName::Interface) && interior.is_none() {
                section.missing("interior", "the name of the medium inside");
            }
            section.finish();
            (model, interior)
        }
        None => (MaterialModel::Lambert { albedo: Parameter::Constant([0.5; 3]) }, None),
    };
    MaterialDescription { name: name.to_owned(), source, model, interior }
}

fn read_model(kind: MaterialName, section: &Section<'_>, assets: &mut Assets) -> MaterialModel {
    match kind {
        MaterialName::Lambert => MaterialModel::Lambert { albedo: colour("albedo", section, assets) },
        MaterialName::Mirror => MaterialModel::Mirror { reflectance: colour("reflectance", section, assets) },
        MaterialName::Dielectric => MaterialModel::Dielectric {
            ior: section.required("ior", POSITIVE, 1.5),
            exterior: section.or("exterior", POSITIVE, 1.0),
            fresnel: section.or("fresnel", Boolean, true),
        },
        MaterialName::Conductor => {
            let (eta, k) = metal(section);
            MaterialModel::Conductor { eta, k }
        }
        MaterialName::RoughDielectric => MaterialModel::RoughDielectric {
            ior: section.required("ior", POSITIVE, 1.5),
            exterior: section.or("exterior", POSITIVE, 1.0),
            roughness: roughness(section, assets),
        },
        MaterialName::RoughConductor => {
            let (eta, k) = metal(section);
            MaterialModel::RoughConductor { eta, k, roughness: roughness(section, assets) }
        }
        MaterialName::Plastic => {
            MaterialModel::Plastic { albedo: colour("albedo", section, assets), ior: section.or("ior", POSITIVE, 1.5) }
        }
        MaterialName::Interface => MaterialModel::Interface,
        MaterialName::Principled => MaterialModel::Principled {
            base_colour: colour("base_colour", section, assets),
            metalness: share("metalness", 0.0, section, assets),
            roughness: share("roughness", 0.5, section, assets),
            transmission: share("transmission", 0.0, section, assets),
            coverage: share("coverage", 1.0, section, assets),
            ior: section.or("ior", POSITIVE, 1.5),
            thin: section.or("thin", Boolean, false),
            normal: normal_map(section, assets),
            specular: specular(section, assets),
            coat: coat(section, assets),
        },
    }
}

/// `preset`, or `eta` and `k`.
fn metal(section: &Section<'_>) -> ([f64; 3], [f64; 3]) {
    let presets = Choice { names: Metal::NAMES, from_name: Metal::from_name };
    let preset = section.get("preset");
    let (eta, k) = (section.get("eta"), section.get("k"));
    let placeholder = ([1.0; 3], [1.0; 3]);
    match (preset, eta, k) {
        (Some(value), None, None) => {
            let metal = section.reader.convert("preset", value, &presets);
            metal.map_or(placeholder, |m| (m.index().eta, m.index().k))
        }
        (None, Some(eta), Some(k)) => (
            section.reader.convert("eta", eta, &Colour(POSITIVE)).unwrap_or(placeholder.0),
            section.reader.convert("k", k, &Colour(NON_NEGATIVE)).unwrap_or(placeholder.1),
        ),
        _ => {
            section.missing("preset", &format!("{}; or both `eta` and `k` instead", presets.expects()));
            placeholder
        }
    }
}

fn colour(key: &'static str, section: &Section<'_>, assets: &mut Assets) -> Parameter<[f64; 3]> {
    parameter(key, section, assets, &REFLECTANCE, Colour(NON_NEGATIVE), [1.0; 3], None)
}

fn roughness(section: &Section<'_>, assets: &mut Assets) -> Parameter<f64> {
    parameter("roughness", section, assets, &ROUGHNESS, NON_NEGATIVE, 1.0, Some(ColourSpace::Linear))
}

/// `specular` and `specular_colour`, which lies in [0, ∞).
fn specular(section: &Section<'_>, assets: &mut Assets) -> Option<SpecularDescription> {
    let weight = share("specular", 1.0, section, assets);
    let any = Colour(NON_NEGATIVE);
    let colour = match section.get("specular_colour") {
        None => Parameter::Constant([1.0; 3]),
        Some(_) => parameter("specular_colour", section, assets, &any, any, [1.0; 3], None),
    };
    SpecularDescription { weight, colour }.unless_plain()
}

/// `coat` and what it is like.
fn coat(section: &Section<'_>, assets: &mut Assets) -> Option<CoatDescription> {
    let weight = share("coat", 0.0, section, assets);
    let roughness = share("coat_roughness", 0.0, section, assets);
    CoatDescription { weight, roughness, ior: section.or("coat_ior", POSITIVE, 1.5) }.unless_bare()
}

/// `{ image, factor, … }` of tangent-space normals; the factor scales slopes.
fn normal_map(section: &Section<'_>, assets: &mut Assets) -> Option<NormalMapDescription> {
    section.get("normal")?;
    let space = Some(ColourSpace::Linear);
    match parameter("normal", section, assets, &NoNumber, NON_NEGATIVE, 1.0, space) {
        Parameter::Image { texture, factor: scale } => Some(NormalMapDescription { texture, scale }),
        Parameter::Constant(_) => None,
    }
}

/// No constant will do.
struct NoNumber;

impl Convert for NoNumber {
    type Output = f64;
    fn expects(&self) -> String {
        "{ image = \"file\" }".to_owned()
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<f64, Mismatch> {
        Err(Mismatch { found: found(value.get_ref()), span: value.span() })
    }
}

/// A number from 0 to 1 that may be left out.
fn share(key: &'static str, default: f64, section: &Section<'_>, assets: &mut Assets) -> Parameter<f64> {
    match section.get(key) {
        None => Parameter::Constant(default),
        Some(_) => parameter(key, section, assets, &FRACTION, NON_NEGATIVE, 1.0, Some(ColourSpace::Linear)),
    }
}

/// A constant, or `{ image, space, wrap, factor }`.
fn parameter<K: Convert<Output: Copy>, F: Convert<Output = K::Output>>(
    key: &'static str,
    section: &Section<'_>,
    assets: &mut Assets,
    kind: &K,
    factor_kind: F,
    one: K::Output,
    default_space: Option<ColourSpace>,
) -> Parameter<K::Output> {
    let Some(value) = section.get(key) else {
        section.missing(key, &format!("{}, or {{ image = \"file\" }}", kind.expects()));
        return Parameter::Constant(one);
    };
    let DeValue::Table(table) = value.get_ref() else {
        return Parameter::Constant(section.reader.convert(key, value, kind).unwrap_or(one));
    };
    let image = Section::new(section.reader, format!("`{key}` of {}", section.label()), table, value.span());
    let file = image.required("image", Text, String::new());
    let space = image.optional("space", SPACES).or(default_space);
    let wrap = image.or("wrap", WRAPS, Wrap::Repeat);
    let factor = image.or("factor", factor_kind, one);
    let source = image.source();
    image.finish();
    if file.is_empty() {
        return Parameter::Constant(one);
    }
    match assets.texture(&file, space, wrap, &source) {
        Ok(texture) => Parameter::Image { texture, factor },
        Err(problems) => {
            section.reader.report_all(problems);
            Parameter::Constant(one)
        }
    }
}
