//! A scene file that takes another file in and says what that says, for people to change: camera, settings, materials and
//! lights. Read again it describes the same scene, bit for bit.
//!
//! What this format cannot spell (pictures within the other file, what a later importer may bring) is left to the file, with a
//! comment.

use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

use crate::scene::PhotonChoice;
use crate::scene::camera::PixelFilter;
use crate::scene::description::{
    CameraDescription, CameraModelDescription, CoatDescription, ExtentDescription, LightDescription, LightModel,
    MaterialDescription, MaterialModel, Parameter, SceneDescription, SpecularDescription,
};
use crate::scene::named_settings::settings_by_name;
use crate::scene::settings::RenderSettings;

/// The text of a scene file in `folder` that includes the file `included`, from which `scene` was read.
pub fn scene_file(scene: &SceneDescription, included: &Path, folder: &Path, lenient: bool) -> String {
    let mut text = String::from("format = 1\n");
    push(&mut text, "include", &quoted(&relative(included, folder).to_string_lossy()));
    if lenient {
        push(&mut text, "lenient", "true");
    }
    if let Some(camera) = &scene.camera {
        write_camera(&mut text, camera);
    }
    write_settings(&mut text, &scene.settings);
    scene.materials.iter().for_each(|material| write_material(&mut text, material));
    write_lights(&mut text, &scene.lights);
    text
}

fn push(text: &mut String, key: &str, value: &str) {
    let _ = writeln!(text, "{key} = {value}");
}

fn heading(text: &mut String, line: &str) {
    let _ = writeln!(text, "\n{line}");
}

/// A basic string of TOML; JSON escapes the same letters but one.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007f")
}

/// The shortest number that reads as the same bits.
fn number(x: f64) -> String {
    format!("{x:?}")
}

fn numbers(all: &[f64]) -> String {
    format!("[{}]", all.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "))
}

/// `path` as seen from `folder`: without a part in common, as it is.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (path, folder) = (absolute(path), absolute(folder));
    let (to, from): (Vec<Component>, Vec<Component>) = (path.components().collect(), folder.components().collect());
    let shared = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    // The root alone, or a drive, is no common folder.
    if shared < 2 {
        return path;
    }
    let up = from[shared..].iter().map(|_| Component::ParentDir);
    up.chain(to[shared..].iter().copied()).collect()
}

fn write_camera(text: &mut String, camera: &CameraDescription) {
    if !camera.motion.is_empty() {
        return heading(text, "# [camera]: it moves, as the file says.");
    }
    heading(text, "[camera]");
    let (name, keys): (&str, Vec<(&str, f64)>) = match camera.model {
        CameraModelDescription::Perspective { fov_degrees } => ("perspective", vec![("fov_degrees", fov_degrees)]),
        CameraModelDescription::Orthographic { width } => ("orthographic", vec![("width", width)]),
        CameraModelDescription::ThinLens { fov_degrees, lens_radius, focus_distance } => (
            "thin_lens",
            vec![("fov_degrees", fov_degrees), ("lens_radius", lens_radius), ("focus_distance", focus_distance)],
        ),
    };
    push(text, "type", &quoted(name));
    for (key, point) in [("position", camera.position), ("target", camera.target), ("up", camera.up)] {
        push(text, key, &numbers(&point));
    }
    keys.into_iter().for_each(|(key, value)| push(text, key, &number(value)));
    push(text, "resolution", &format!("{:?}", camera.resolution));
    push(text, "filter", if camera.filter == PixelFilter::Box { "\"box\"" } else { "\"gaussian\"" });
    if let Some(shutter) = camera.shutter {
        push(text, "shutter", &numbers(&shutter));
    }
}

/// Those that are not the usual ones.
fn write_settings(text: &mut String, settings: &RenderSettings) {
    let usual = settings_by_name(&RenderSettings::default());
    let own = settings_by_name(settings);
    heading(text, "[render]");
    // Numbers, words and lists of words are spelled alike in JSON.
    own.iter()
        .filter(|&(key, value)| usual.get(key) != Some(value))
        .for_each(|(key, value)| push(text, key, &value.to_string()));
}

fn write_material(text: &mut String, material: &MaterialDescription) {
    let name = quoted(&material.name);
    match keys(&material.model).filter(|_| material.interior.is_none()) {
        Some((kind, keys)) => {
            heading(text, &format!("[materials.{name}]"));
            push(text, "type", &quoted(kind));
            keys.iter().for_each(|(key, value)| push(text, key, value));
        }
        None => heading(text, &format!("# [materials.{name}]: with images or a medium, as the file says.")),
    }
}

type Keys = Vec<(&'static str, String)>;

/// Kind and keys of a material without images.
fn keys(model: &MaterialModel) -> Option<(&'static str, Keys)> {
    let colour = |parameter: &Parameter<[f64; 3]>| match parameter {
        Parameter::Constant(rgb) => Some(numbers(rgb)),
        Parameter::Image { .. } => None,
    };
    let single = |parameter: &Parameter<f64>| match parameter {
        Parameter::Constant(x) => Some(number(*x)),
        Parameter::Image { .. } => None,
    };
    Some(match model {
        MaterialModel::Lambert { albedo } => ("lambert", vec![("albedo", colour(albedo)?)]),
        MaterialModel::Mirror { reflectance } => ("mirror", vec![("reflectance", colour(reflectance)?)]),
        MaterialModel::Dielectric { ior, exterior, fresnel } => (
            "dielectric",
            vec![("ior", number(*ior)), ("exterior", number(*exterior)), ("fresnel", fresnel.to_string())],
        ),
        MaterialModel::Conductor { eta, k } => ("conductor", vec![("eta", numbers(eta)), ("k", numbers(k))]),
        MaterialModel::RoughDielectric { ior, exterior, roughness } => (
            "rough_dielectric",
            vec![("ior", number(*ior)), ("exterior", number(*exterior)), ("roughness", single(roughness)?)],
        ),
        MaterialModel::RoughConductor { eta, k, roughness } => {
            ("rough_conductor", vec![("eta", numbers(eta)), ("k", numbers(k)), ("roughness", single(roughness)?)])
        }
        MaterialModel::Plastic { albedo, ior } => ("plastic", vec![("albedo", colour(albedo)?), ("ior", number(*ior))]),
        MaterialModel::Principled {
            base_colour,
            metalness,
            roughness,
            transmission,
            coverage,
            ior,
            thin,
            normal: None,
            specular,
            coat,
        } => {
            let mut keys = vec![
                ("base_colour", colour(base_colour)?),
                ("metalness", single(metalness)?),
                ("roughness", single(roughness)?),
                ("transmission", single(transmission)?),
                ("coverage", single(coverage)?),
                ("ior", number(*ior)),
                ("thin", thin.to_string()),
            ];
            if let Some(SpecularDescription { weight, colour: tint }) = specular {
                keys.extend([("specular", single(weight)?), ("specular_colour", colour(tint)?)]);
            }
            if let Some(CoatDescription { weight, roughness, ior }) = coat {
                let (weight, roughness) = (single(weight)?, single(roughness)?);
                keys.extend([("coat", weight), ("coat_roughness", roughness), ("coat_ior", number(*ior))]);
            }
            ("principled", keys)
        }
        MaterialModel::Principled { normal: Some(_), .. } | MaterialModel::Interface => return None,
    })
}

/// All or none: those of a scene file take the place of all others.
fn write_lights(text: &mut String, lights: &[LightDescription]) {
    match lights.iter().map(light).collect::<Option<Vec<Keys>>>() {
        Some(all) => all.iter().for_each(|keys| {
            heading(text, "[[lights]]");
            keys.iter().for_each(|(key, value)| push(text, key, value));
        }),
        None => heading(text, "# [[lights]]: with images or motion, as the file says."),
    }
}

fn light(light: &LightDescription) -> Option<Keys> {
    let mut keys = match &light.model {
        LightModel::Point { position, intensity } => {
            vec![("type", quoted("point")), ("position", numbers(position)), ("intensity", numbers(intensity))]
        }
        LightModel::Spot { position, target, intensity, angle_degrees, penumbra_degrees } => vec![
            ("type", quoted("spot")),
            ("position", numbers(position)),
            ("target", numbers(target)),
            ("intensity", numbers(intensity)),
            ("angle_degrees", number(*angle_degrees)),
            ("penumbra_degrees", number(*penumbra_degrees)),
        ],
        LightModel::Directional { direction, irradiance, extent } => {
            let mut keys = vec![
                ("type", quoted("directional")),
                ("direction", numbers(direction)),
                ("irradiance", numbers(irradiance)),
            ];
            match extent {
                ExtentDescription::Unbounded => {}
                ExtentDescription::Disk { centre, radius } => {
                    keys.push(("extent", format!("{{ centre = {}, radius = {} }}", numbers(centre), number(*radius))));
                }
                ExtentDescription::Rectangle { centre, a, b } => {
                    let [centre, a, b] = [centre, a, b].map(|v| numbers(v));
                    keys.push(("extent", format!("{{ centre = {centre}, a = {a}, b = {b} }}")));
                }
            }
            keys
        }
        LightModel::Environment { radiance } => {
            vec![("type", quoted("environment")), ("radiance", numbers(radiance))]
        }
        LightModel::Panorama(_) => return None,
    };
    keys.extend(light.group.as_ref().map(|group| ("group", quoted(&group.name))));
    match light.photons {
        PhotonChoice::Auto => {}
        PhotonChoice::Off => keys.push(("photons", quoted("off"))),
        PhotonChoice::Count(n) => keys.push(("photons", n.to_string())),
    }
    light.motion.is_empty().then_some(keys)
}
