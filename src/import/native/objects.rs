//! `[[objects]]`.

use toml::Spanned;
use toml::de::DeValue;

use super::lights::Photons;
use crate::import::assets::Assets;
use crate::import::keyed::convert::{
    ANY, Array, Boolean, Choice, Colour, Direction, List, NON_NEGATIVE, POINT, POSITIVE, ScaleFactors, Text,
};
use crate::import::keyed::reader::Section;
use crate::scene::Caustics;
use crate::scene::description::{
    Emission, MotionKey, ObjectDescription, Reference, ShapeDescription, TransformMap, TransformStep, WaveDescription,
};
use crate::scene::error::Problem;

#[derive(Clone, Copy, PartialEq)]
enum ShapeName {
    Sphere,
    Cylinder,
    Torus,
    Disk,
    Rectangle,
    HeightField,
    Mesh,
}

const SHAPES: Choice<'_, ShapeName> = Choice {
    names: &["sphere", "cylinder", "torus", "disk", "rectangle", "height_field", "mesh"],
    from_name: |name| match name {
        "sphere" => Some(ShapeName::Sphere),
        "cylinder" => Some(ShapeName::Cylinder),
        "torus" => Some(ShapeName::Torus),
        "disk" => Some(ShapeName::Disk),
        "rectangle" => Some(ShapeName::Rectangle),
        "height_field" => Some(ShapeName::HeightField),
        "mesh" => Some(ShapeName::Mesh),
        _ => None,
    },
};

/// Stands where a mesh could not be read.
const ABSENT: ShapeDescription = ShapeDescription::Mesh { mesh: None };

pub(super) fn read(root: &Section<'_>, assets: &mut Assets) -> Vec<ObjectDescription> {
    let sections = root.tables("objects", |i| format!("object {i}"));
    sections.into_iter().enumerate().flat_map(|(i, section)| read_object(i, section, assets)).collect()
}

/// The object of a table, or the objects of the materials of its mesh file.
fn read_object(index: usize, section: Section<'_>, assets: &mut Assets) -> Vec<ObjectDescription> {
    let source = section.source();
    let name = section.or("name", Text, format!("object {index}"));
    let transform = read_transform(&section);
    let motion = section.tables("motion", |i| format!("key {i} of `motion`")).iter().map(read_key).collect::<Vec<_>>();
    let emission = read_emission(&section);
    let caustics = section.table("caustics").map_or(Caustics::default(), read_caustics);
    let material = section.get("material").map(|value| Reference {
        name: section.reader.convert("material", value, &Text).unwrap_or_default(),
        source: section.reader.source(value.span()),
    });
    let shape = match section.get("shape") {
        Some(value) => section.reader.convert("shape", value, &SHAPES),
        None => {
            section.missing("shape", &crate::import::keyed::convert::Convert::expects(&SHAPES));
            None
        }
    };
    let parts = match shape {
        Some(ShapeName::Mesh) => read_mesh(&section, material, assets),
        Some(shape) => {
            let material = material.unwrap_or_else(|| {
                section.missing("material", "the name of a material");
                Reference { name: String::new(), source: source.clone() }
            });
            vec![(read_shape(shape, &section), material)]
        }
        None => vec![(ABSENT, material.unwrap_or_else(|| Reference { name: String::new(), source: source.clone() }))],
    };
    if shape.is_some() {
        section.finish();
    }
    let several = parts.len() > 1;
    let part = |(shape, material): (ShapeDescription, Reference)| ObjectDescription {
        name: if several { format!("{name}/{}", material.name) } else { name.clone() },
        source: source.clone(),
        shape,
        material,
        transform: transform.clone(),
        motion: motion.clone(),
        emission: emission.clone(),
        caustics,
    };
    parts.into_iter().map(part).collect()
}

fn read_shape(name: ShapeName, section: &Section<'_>) -> ShapeDescription {
    let centre = || section.required("centre", POINT, [0.0; 3]);
    match name {
        ShapeName::Sphere => {
            ShapeDescription::Sphere { centre: centre(), radius: section.required("radius", POSITIVE, 1.0) }
        }
        ShapeName::Cylinder => ShapeDescription::Cylinder {
            base: section.required("base", POINT, [0.0; 3]),
            top: section.required("top", POINT, [0.0, 0.0, 1.0]),
            radius: section.required("radius", POSITIVE, 1.0),
        },
        ShapeName::Torus => ShapeDescription::Torus {
            centre: centre(),
            axis: section.required("axis", Direction, [0.0, 1.0, 0.0]),
            major_radius: section.required("major_radius", POSITIVE, 2.0),
            minor_radius: section.required("minor_radius", POSITIVE, 1.0),
        },
        ShapeName::Disk => ShapeDescription::Disk {
            centre: centre(),
            normal: section.required("normal", Direction, [0.0, 1.0, 0.0]),
            radius: section.required("radius", POSITIVE, 1.0),
        },
        ShapeName::Rectangle => ShapeDescription::Rectangle {
            centre: centre(),
            a: section.required("a", Direction, [1.0, 0.0, 0.0]),
            b: section.required("b", Direction, [0.0, 1.0, 0.0]),
        },
        ShapeName::HeightField => ShapeDescription::HeightField {
            centre: centre(),
            half_size: section.required("half_size", Array(POSITIVE), [1.0; 2]),
            up: section.or("up", Direction, [0.0, 0.0, 1.0]),
            x_axis: section.or("x_axis", Direction, [1.0, 0.0, 0.0]),
            waves: section
                .tables("waves", |i| format!("wave {i} of {}", section.label()))
                .into_iter()
                .map(read_wave)
                .collect(),
        },
        ShapeName::Mesh => ABSENT,
    }
}

fn read_wave(section: Section<'_>) -> WaveDescription {
    let wave = WaveDescription {
        amplitude: section.required("amplitude", ANY, 1.0),
        wave_vector: section.required("wave_vector", Array(ANY), [1.0, 0.0]),
        phase: section.or("phase", ANY, 0.0),
        speed: section.or("speed", ANY, 0.0),
    };
    section.finish();
    wave
}

fn read_mesh(
    section: &Section<'_>,
    material: Option<Reference>,
    assets: &mut Assets,
) -> Vec<(ShapeDescription, Reference)> {
    let smooth = section.optional("smooth", Boolean);
    let absent = |material: Option<Reference>| {
        let source = section.source();
        vec![(ABSENT, material.unwrap_or(Reference { name: String::new(), source }))]
    };
    let Some(value) = section.get("file") else {
        section.missing("file", "the path of an OBJ or PLY file");
        return absent(material);
    };
    let used_at = section.reader.source(value.span());
    let shape = |mesh| ShapeDescription::Mesh { mesh: Some(mesh) };
    if let DeValue::Array(_) = value.get_ref() {
        let Some(files) = section.reader.convert("file", value, &List(Text)) else { return absent(material) };
        return match read_frames(section, &files, smooth, material.as_ref(), assets) {
            Some((mesh, material)) => vec![(shape(mesh), material)],
            None => absent(material),
        };
    }
    if let Some(times) = section.get("times") {
        let problem = Problem::new("`times` are those of several files, `file` is one");
        let problem = problem.help("write file = [\"first.obj\", \"last.obj\"], or take `times` away");
        section.reader.report(problem.at(&section.reader.source(times.span())));
    }
    let Some(file) = section.reader.convert("file", value, &Text) else { return absent(material) };
    let parts = match &material {
        Some(material) => assets.mesh(&file, smooth, &used_at).map(|mesh| vec![(shape(mesh), material.clone())]),
        None => assets
            .mesh_with_materials(&file, smooth, &used_at)
            .map(|parts| parts.into_iter().map(|(mesh, material)| (shape(mesh), material)).collect()),
    };
    parts.unwrap_or_else(|problems| {
        section.reader.report_all(problems);
        absent(material)
    })
}

/// A mesh that changes its shape: files at equal intervals between two `times`.
fn read_frames(
    section: &Section<'_>,
    files: &[String],
    smooth: Option<bool>,
    material: Option<&Reference>,
    assets: &mut Assets,
) -> Option<(usize, Reference)> {
    let Some(times) = section.get("times") else {
        section.missing("times", "the times of the first and the last file, s");
        return None;
    };
    let used_at = section.reader.source(times.span());
    let times = section.reader.convert("times", times, &Array::<_, 2>(ANY))?;
    let Some(material) = material else {
        section.missing("material", "the name of a material, which several files cannot bring along");
        return None;
    };
    match assets.animated_mesh(files, times, smooth, &used_at) {
        Ok(mesh) => Some((mesh, material.clone())),
        Err(problems) => {
            section.reader.report_all(problems);
            None
        }
    }
}

fn read_emission(section: &Section<'_>) -> Option<Emission> {
    let two_sided = section.get("two_sided");
    let group = super::lights::read_group(section);
    let photons = section.get("photons");
    let Some(value) = section.get("emission") else {
        let given = [("two_sided", two_sided), ("photons", photons)].into_iter();
        let given = given.filter_map(|(key, value)| Some((key, section.reader.source(value?.span()))));
        for (key, source) in given.chain(group.map(|group| ("group", group.source))) {
            let problem = Problem::new(format!("`{key}` without `emission` says nothing"));
            section.reader.report(problem.help("give emission = [r, g, b] in W/(m² sr), or remove it").at(&source));
        }
        return None;
    };
    Some(Emission {
        source: section.reader.source(value.span()),
        radiance: section.reader.convert("emission", value, &Colour(NON_NEGATIVE)).unwrap_or([1.0; 3]),
        two_sided: two_sided.and_then(|v| section.reader.convert("two_sided", v, &Boolean)).unwrap_or(false),
        group,
        photons: photons.and_then(|v| section.reader.convert("photons", v, &Photons)).unwrap_or_default(),
    })
}

/// `caustics = { cast, receive }`.
fn read_caustics(section: Section<'_>) -> Caustics {
    let caustics = Caustics { cast: section.or("cast", Boolean, true), receive: section.or("receive", Boolean, true) };
    section.finish();
    caustics
}

fn read_transform(section: &Section<'_>) -> Vec<TransformStep> {
    let steps = section.tables("transform", |i| format!("step {i} of `transform`"));
    steps.into_iter().filter_map(read_step).collect()
}

/// A time and where the object or the light is then.
pub(super) fn read_key(section: &Section<'_>) -> MotionKey {
    let time = section.required("time", ANY, 0.0);
    let key = MotionKey { source: section.source(), time, transform: read_transform(section) };
    section.finish();
    key
}

/// A table with one of the keys translate, rotate, scale, matrix.
fn read_step(section: Section<'_>) -> Option<TransformStep> {
    let source = section.source();
    let mut maps = Vec::new();
    maps.extend(section.optional("translate", POINT).map(TransformMap::Translate));
    maps.extend(section.get("rotate").and_then(|value| read_rotation(&section, value)));
    maps.extend(section.optional("scale", ScaleFactors).map(TransformMap::Scale));
    maps.extend(section.optional("matrix", Array::<_, 3>(Array::<_, 4>(ANY))).map(TransformMap::Matrix));
    let keys = section.entries().len();
    if keys != 1 {
        let message = format!("{} must have one key, it has {keys}", section.label());
        let help = "write { translate = [x, y, z] }, { rotate = { axis, degrees } }, { scale = s } or { matrix = [[..4], [..4], [..4]] }";
        section.reader.report(crate::scene::error::Problem::new(message).help(help).at(&source));
    }
    section.finish();
    maps.into_iter().next().map(|map| TransformStep { source, map })
}

fn read_rotation<'t>(section: &Section<'t>, value: &'t Spanned<DeValue<'t>>) -> Option<TransformMap> {
    let rotation = Section::of_value(section.reader, "`rotate`", value)?;
    let map = TransformMap::Rotate {
        axis: rotation.required("axis", Direction, [0.0, 1.0, 0.0]),
        degrees: rotation.required("degrees", ANY, 0.0),
    };
    rotation.finish();
    Some(map)
}
