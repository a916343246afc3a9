//! A description becomes a scene, or the list of everything that is wrong with it.
//!
//! Each part reports what it finds and goes on with a stand-in, so that one run names every problem; a scene comes out
//! only when there was none.

mod camera;
mod geometry;
mod groups;
mod lights;
mod materials;
mod media;
mod meshes;
mod motion;

use std::collections::HashMap;

use self::geometry::{Geometry, Placed};
use self::lights::AssembledLights;
use self::materials::Materials;
use super::artistic::LightPhotons;
use super::camera::Shutter;
use super::description::{ObjectDescription, SceneDescription, ShapeDescription};
use super::error::{Problem, Problems};
use super::hash::{digest, digest_of_contents};
use super::ids::{LightId, ObjectId};
use super::light::LightSource;
use super::material::Material;
use super::object::{Object, ObjectGeometry};
use super::settings::{Indirect, MAX_PHOTONS_PER_PASS, Method, RenderSettings};
use super::{CameraSettings, LightGroups, Media, Scene, TriangleMesh};
use crate::math::Bounds3;
use crate::radiometry::Spectrum;

/// Farther out the single precision of the ray backends resolves nothing.
const MAX_COORDINATE: f64 = 1e9;

/// What is wrong, and what is merely suspicious.
#[derive(Default)]
struct Report {
    problems: Problems,
    warnings: Vec<Problem>,
}

impl Report {
    fn problem(&mut self, problem: Problem) {
        self.problems.push(problem);
    }
    fn warning(&mut self, warning: Problem) {
        self.warnings.push(warning);
    }
}

/// Checks a description whole and makes the scene of it, with warnings about what is probably not meant.
///
/// # Errors
/// All problems, each with the place it comes from.
pub fn assemble(mut description: SceneDescription) -> Result<(Scene, Vec<Problem>), Problems> {
    let mut report = Report { warnings: std::mem::take(&mut description.warnings), ..Report::default() };
    let hashes = (digest(&description), digest_of_contents(&description));

    let shutter = description
        .camera
        .as_ref()
        .map_or(Shutter::instant(0.0), |camera| motion::shutter(camera.shutter, &camera.source, &mut report));
    let camera = camera::assemble(description.camera.as_ref(), shutter, &description.source, &mut report);
    check_settings(&description, &mut report);
    let materials = Materials::assemble(&description, &mut report);
    let media = media::assemble(&description, &materials, &mut report);
    let geometry = Geometry::assemble(&mut description, shutter, &materials, &mut report);
    let assembled = lights::assemble(&description.lights, shutter, &mut report);
    let AssembledLights { sources: mut lights, motions: light_motions, described, mut photons } = assembled;
    let objects = place_objects(&description, shutter, &materials, &geometry, &mut lights, &mut report);
    let emissions = description.objects.iter().filter_map(|object| object.emission.as_ref());
    photons.extend(emissions.map(|emission| emission.photons));
    let light_photons = LightPhotons::new(photons);
    lights::check_photons(&light_photons, &description, &mut report);
    let light_groups = groups::assemble(&mut description, (&lights, &described), &objects, &mut report);
    check_names(&description, &mut report);
    lights::check_some_light(&lights, &description, &mut report);
    let bounds = objects.iter().fold(Bounds3::EMPTY, |all, object| all.union(object.bounds));
    check_bounds(bounds, &description, &mut report);
    warn_without_caustics(&materials, &description, &mut report);

    let Report { problems, warnings } = report;
    // Without a camera there is a problem, so the default is never seen.
    let Some(camera) = camera else { return Err(problems) };
    let lights_move = light_motions.iter().any(Option::is_some);
    let moves = lights_move
        || !camera.motion.is_empty()
        || objects.iter().any(Object::moves)
        || geometry.meshes.iter().any(TriangleMesh::changes);
    let shutter = if moves { shutter } else { Shutter::instant(shutter.open) };
    let scene = scene(camera, description.settings, materials, geometry, objects, lights, hashes);
    problems
        .into_result((Scene { bounds, shutter, light_motions, light_groups, light_photons, media, ..scene }, warnings))
}

fn scene(
    camera: CameraSettings,
    settings: RenderSettings,
    materials: Materials,
    geometry: Geometry,
    objects: Vec<Object>,
    lights: Vec<LightSource>,
    (hash, contents): (String, String),
) -> Scene {
    Scene {
        objects,
        meshes: geometry.meshes,
        material_names: materials.names(),
        materials: materials.materials,
        textures: materials.textures,
        media: Media::default(),
        lights,
        light_motions: Vec::new(),
        light_groups: LightGroups::default(),
        light_photons: LightPhotons::default(),
        camera,
        shutter: Shutter::instant(0.0),
        settings,
        bounds: Bounds3::EMPTY,
        hash,
        contents,
    }
}

/// Objects with their materials; those that emit become lights.
fn place_objects(
    description: &SceneDescription,
    shutter: Shutter,
    materials: &Materials,
    geometry: &Geometry,
    lights: &mut Vec<LightSource>,
    report: &mut Report,
) -> Vec<Object> {
    if description.objects.is_empty() {
        let problem = Problem::new("the scene is empty: it has no object").at(&description.source);
        report.problem(problem.help("add at least one [[objects]] table"));
    }
    let mut objects = Vec::new();
    for (item, placed) in description.objects.iter().zip(&geometry.placed) {
        let material = materials.find(&item.material, report);
        let (Some(material), Some(placed)) = (material, placed) else { continue };
        let Placed { geometry: own, motion } = placed.clone();
        check_texture_coordinates(item, &own, materials, geometry, report);
        let light = item.emission.as_ref().map(|emission| {
            let object = ObjectId(objects.len() as u32);
            let radiance = Spectrum::from(emission.radiance);
            if radiance.is_black() {
                let problem = Problem::new(format!("`{}` is a light that emits nothing", item.name));
                report.problem(problem.help("give a radiance above 0, or remove `emission`").at(&emission.source));
            }
            if let ShapeDescription::HeightField { .. } = item.shape {
                let problem = Problem::new(format!("`{}` is a height field, which cannot be a light", item.name));
                report.problem(problem.help("make it a mesh, or a rectangle").at(&emission.source));
            }
            if own.mesh().is_some_and(|mesh| geometry.meshes[mesh.index()].changes()) {
                let problem = Problem::new(format!("`{}` emits and changes its shape", item.name));
                let help = "let a mesh that emits have one `file`, or take `emission` away";
                report.problem(problem.help(help).at(&emission.source));
            }
            lights.push(LightSource::Area { object, radiance, two_sided: emission.two_sided });
            LightId(lights.len() as u32 - 1)
        });
        let bounds = Object::swept_bounds(&own, motion.as_deref(), shutter, &geometry.mesh_bounds);
        objects.push(Object {
            name: item.name.clone(),
            geometry: own,
            motion,
            bounds,
            material,
            light,
            caustics: item.caustics,
        });
    }
    objects
}

/// An image needs to know where on the surface it lies; exact shapes always do.
fn check_texture_coordinates(
    item: &ObjectDescription,
    placed: &ObjectGeometry,
    materials: &Materials,
    geometry: &Geometry,
    report: &mut Report,
) {
    let ObjectGeometry::Mesh { mesh, .. } = placed else { return };
    let textured = materials.lookup(&item.material.name).is_some_and(Material::has_image);
    if textured && geometry.meshes.get(mesh.index()).is_some_and(|m| m.uvs.is_empty()) {
        let message = format!("the material of `{}` has an image, its mesh no texture coordinates", item.name);
        report.problem(Problem::new(message).help("add them to the mesh, or use a constant").at(&item.source));
    }
}

fn check_names(description: &SceneDescription, report: &mut Report) {
    let mut seen = HashMap::new();
    for object in &description.objects {
        if let Some(first) = seen.insert(object.name.as_str(), &object.source) {
            let problem = Problem::new(format!("two objects are named `{}`", object.name)).at(&object.source);
            report.problem(problem.help(format!("the other is at {first}; names are for messages and must differ")));
        }
    }
}

fn check_settings(description: &SceneDescription, report: &mut Report) {
    let settings = &description.settings;
    let mut refuse = |message: String, help: &str| {
        report.problem(Problem::new(message).help(help).at(&description.settings_source));
    };
    if settings.photons == 0 {
        refuse("`photons` is 0: no caustic can be estimated".to_owned(), "a million is a good start");
    }
    if settings.photons > MAX_PHOTONS_PER_PASS {
        let message = format!("`photons` is {}, a pass emits at most {MAX_PHOTONS_PER_PASS}", settings.photons);
        refuse(message, "emit more with more `passes`");
    }
    for (name, value) in [("spp", settings.spp), ("passes", settings.passes), ("max_depth", settings.max_depth)] {
        if value == 0 {
            refuse(format!("`{name}` is 0"), "it must be at least 1");
        }
    }
    if settings.k < 2 {
        refuse(format!("`k` is {}", settings.k), "the k-th neighbour only sets the radius: at least 2 are needed");
    }
}

fn check_bounds(bounds: Bounds3, description: &SceneDescription, report: &mut Report) {
    let extent = bounds.max_abs();
    if !bounds.is_empty() && (extent > MAX_COORDINATE || extent.is_nan()) {
        let message =
            format!("the scene reaches out to {extent:.3e} m, beyond the {MAX_COORDINATE:.0e} m of the ray backends");
        report.problem(Problem::new(message).help("lengths are metres; is a transform wrong?").at(&description.source));
    }
}

/// Caustics need something that reflects or refracts sharply.
fn warn_without_caustics(materials: &Materials, description: &SceneDescription, report: &mut Report) {
    let specular = description.objects.iter().any(|object| {
        let material = materials.lookup(&object.material.name);
        material.is_none_or(Material::can_focus)
    });
    let settings = &description.settings;
    let only_caustics = settings.method == Method::PhotonMap && settings.indirect == Indirect::Path;
    if !specular && !description.objects.is_empty() && only_caustics {
        let warning = Problem::new("no object reflects or refracts specularly: there can be no caustic");
        report.warning(warning.help("give an object a dielectric, mirror or conductor").at(&description.source));
    }
}
