//! `[[lights]]`.

use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::materials::SPACES;
use super::objects::read_key;
use crate::import::assets::Assets;
use crate::import::keyed::convert::{
    ANY, Choice, Colour, Convert, Direction, Integer, Mismatch, NON_NEGATIVE, Number, POINT, POSITIVE, Text, found,
};
use crate::import::keyed::reader::Section;
use crate::math::{Dir3, Transform, Vec3};
use crate::radiometry::Spectrum;
use crate::scene::PhotonChoice;
use crate::scene::description::{ExtentDescription, LightDescription, LightModel, Reference};
use crate::scene::error::Problem;
use crate::scene::light_group;
use crate::scene::panorama::{Panorama, Part, Projection};
use crate::scene::settings::MAX_PHOTONS_PER_PASS;

#[derive(Clone, Copy)]
enum LightName {
    Point,
    Spot,
    Directional,
    Environment,
}

const LIGHTS: Choice<'_, LightName> = Choice {
    names: &["point", "spot", "directional", "environment"],
    from_name: |name| match name {
        "point" => Some(LightName::Point),
        "spot" => Some(LightName::Spot),
        "directional" => Some(LightName::Directional),
        "environment" => Some(LightName::Environment),
        _ => None,
    },
};

/// Sine of the angle between axes up to which they count as parallel.
const PARALLEL: f64 = 1e-6;

const POWER: Colour = Colour(NON_NEGATIVE);

pub(super) fn read(root: &Section<'_>, assets: &mut Assets) -> Vec<LightDescription> {
    root.tables("lights", |i| format!("light {i}")).into_iter().map(|section| read_light(section, assets)).collect()
}

fn read_light(section: Section<'_>, assets: &mut Assets) -> LightDescription {
    let source = section.source();
    let name = match section.get("type") {
        Some(value) => section.reader.convert("type", value, &LIGHTS),
        None => {
            section.missing("type", &LIGHTS.expects());
            None
        }
    };
    let group = read_group(&section);
    let photons = section.or("photons", Photons, PhotonChoice::Auto);
    let Some(name) = name else {
        // Stands for the light that is meant, so that the scene does not seem to be dark.
        let model = LightModel::Environment { radiance: [1.0; 3] };
        return LightDescription { source, model, group: None, photons, motion: Vec::new() };
    };
    let model = match name {
        LightName::Point => LightModel::Point {
            position: section.required("position", POINT, [0.0; 3]),
            intensity: section.required("intensity", POWER, [1.0; 3]),
        },
        LightName::Spot => read_spot(&section),
        LightName::Directional => LightModel::Directional {
            direction: section.required("direction", Direction, [0.0, -1.0, 0.0]),
            irradiance: section.required("irradiance", POWER, [1.0; 3]),
            extent: section.table("extent").map_or(ExtentDescription::Unbounded, read_extent),
        },
        LightName::Environment => read_environment(&section, assets),
    };
    let motion = section.tables("motion", |i| format!("key {i} of `motion`")).iter().map(read_key).collect();
    section.finish();
    LightDescription { source, model, group, photons, motion }
}

/// `group`, of a light or an object that emits.
pub(super) fn read_group(section: &Section<'_>) -> Option<Reference> {
    let value = section.get("group")?;
    let name = section.reader.convert("group", value, &GroupName)?;
    Some(Reference { name, source: section.reader.source(value.span()) })
}

/// A name that a layer may have.
struct GroupName;

impl Convert for GroupName {
    type Output = String;
    fn expects(&self) -> String {
        "the name of a group of lights, of letters, digits and _, a letter first".to_owned()
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<String, Mismatch> {
        match value.get_ref() {
            DeValue::String(name) if light_group::is_name(name) => Ok(name.to_string()),
            other => Err(Mismatch { found: found(other), span: value.span() }),
        }
    }
}

/// `photons`, of a light or an object that emits.
pub(super) struct Photons;

impl Convert for Photons {
    type Output = PhotonChoice;
    fn expects(&self) -> String {
        format!("\"auto\", \"off\" or an integer from 1 to {MAX_PHOTONS_PER_PASS}")
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<PhotonChoice, Mismatch> {
        match value.get_ref() {
            DeValue::String(word) if word == "auto" => Ok(PhotonChoice::Auto),
            DeValue::String(word) if word == "off" => Ok(PhotonChoice::Off),
            _ => Integer::within(1, MAX_PHOTONS_PER_PASS).convert(value).map(PhotonChoice::Count),
        }
    }
}

/// `radiance` is a colour or `{ image, space, factor }`; an image has a place.
fn read_environment(section: &Section<'_>, assets: &mut Assets) -> LightModel {
    if let Some(value) = section.get("radiance")
        && let DeValue::Table(table) = value.get_ref()
    {
        return read_panorama(section, value, table, assets).unwrap_or(LightModel::Environment { radiance: [1.0; 3] });
    }
    LightModel::Environment { radiance: section.required("radiance", POWER, [1.0; 3]) }
}

fn read_panorama<'t>(
    section: &Section<'t>,
    value: &Spanned<DeValue<'t>>,
    table: &'t DeTable<'t>,
    assets: &Assets,
) -> Option<LightModel> {
    let image = Section::new(section.reader, format!("`radiance` of {}", section.label()), table, value.span());
    let file = image.required("image", Text, String::new());
    let space = image.optional("space", SPACES);
    let factor = image.or("factor", POWER, [1.0; 3]);
    let source = image.source();
    image.finish();
    let up = section.or("up", Direction, [0.0, 1.0, 0.0]);
    let centre = section.or("centre", Direction, [0.0, 0.0, 1.0]);
    let turn = section.or("rotation_degrees", ANY, 0.0);
    let axes = axes(up, centre, turn).or_else(|| {
        let problem = Problem::new(format!("{}: `up` and `centre` are parallel", section.label()));
        let help = "`up` is where the top of the image is, `centre` where the middle of it is";
        section.reader.report(problem.help(help).at(&section.source()));
        None
    });
    if file.is_empty() {
        return None;
    }
    let image = assets.panorama(&file, space, &source).map_err(|problem| section.reader.report(problem)).ok()?;
    let (projection, factor) = (Projection::LatLong, Spectrum::from(factor));
    Some(LightModel::Panorama(Panorama { image: Arc::new(image), projection, axes: axes?, factor, part: Part::All }))
}

/// The middle, the left and the top of a lat-long image, turned about `up`; `None` where there is no telling.
fn axes(up: [f64; 3], centre: [f64; 3], degrees: f64) -> Option<[Dir3; 3]> {
    let up = Dir3::new(Vec3::from(up))?;
    let across = up.cross(Dir3::new(Vec3::from(centre))?);
    let left = Dir3::new(across).filter(|_| across.length() > PARALLEL)?;
    let middle = Dir3::new(left.cross(up))?;
    let turn = Transform::rotate(up, degrees.to_radians());
    let [middle, left] = [middle, left].map(|axis| Dir3::new(turn.vector(axis.to_vec())));
    Some([middle?, left?, up])
}

fn read_spot(section: &Section<'_>) -> LightModel {
    let angle_degrees = section.required("angle_degrees", Number::above_up_to(0.0, 180.0), 180.0);
    LightModel::Spot {
        position: section.required("position", POINT, [0.0; 3]),
        target: section.required("target", POINT, [0.0, 0.0, 1.0]),
        intensity: section.required("intensity", POWER, [1.0; 3]),
        angle_degrees,
        penumbra_degrees: section.or("penumbra_degrees", Number::from_up_to(0.0, angle_degrees), 0.0),
    }
}

fn read_extent(section: Section<'_>) -> ExtentDescription {
    let centre = section.required("centre", POINT, [0.0; 3]);
    let extent = if let Some(value) = section.get("radius") {
        let radius = section.reader.convert("radius", value, &POSITIVE).unwrap_or(1.0);
        ExtentDescription::Disk { centre, radius }
    } else {
        ExtentDescription::Rectangle {
            centre,
            a: section.required("a", Direction, [1.0, 0.0, 0.0]),
            b: section.required("b", Direction, [0.0, 0.0, 1.0]),
        }
    };
    section.finish();
    extent
}
