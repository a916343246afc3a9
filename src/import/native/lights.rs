//! `[[lights]]`.

use toml::Spanned;
use toml::de::DeValue;

use super::objects::read_key;
use crate::import::keyed::convert::{
    Choice, Colour, Convert, Direction, Mismatch, NON_NEGATIVE, Number, POINT, POSITIVE, found,
};
use crate::import::keyed::reader::Section;
use crate::scene::description::{ExtentDescription, LightDescription, LightModel, Reference};
use crate::scene::light_group;

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

const POWER: Colour = Colour(NON_NEGATIVE);

pub(super) fn read(root: &Section<'_>) -> Vec<LightDescription> {
    root.tables("lights", |i| format!("light {i}")).into_iter().map(read_light).collect()
}

fn read_light(section: Section<'_>) -> LightDescription {
    let source = section.source();
    let name = match section.get("type") {
        Some(value) => section.reader.convert("type", value, &LIGHTS),
        None => {
            section.missing("type", &LIGHTS.expects());
            None
        }
    };
    let group = read_group(&section);
    let Some(name) = name else {
        // Stands for the light that is meant, so that the scene does not seem to be dark.
        let model = LightModel::Environment { radiance: [1.0; 3] };
        return LightDescription { source, model, group: None, motion: Vec::new() };
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
        LightName::Environment => LightModel::Environment { radiance: section.required("radiance", POWER, [1.0; 3]) },
    };
    let motion = section.tables("motion", |i| format!("key {i} of `motion`")).iter().map(read_key).collect();
    section.finish();
    LightDescription { source, model, group, motion }
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
