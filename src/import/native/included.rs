//! What a glTF or pbrt file brings into a scene, and what stands in for what it lacks.

use std::path::Path;

use crate::import::assets::Assets;
use crate::import::imported::{Imported, Wanted};
use crate::import::keyed::convert::Text;
use crate::import::keyed::reader::Section;
use crate::import::{gltf, is_foreign, pbrt};
use crate::scene::PhotonChoice;
use crate::scene::description::{
    CameraDescription, ExtentDescription, LightDescription, LightModel, MaterialDescription, MediumDescription,
    ObjectDescription,
};
use crate::scene::error::{Problem, Problems, Source};
use crate::scene::settings::RenderSettings;

/// What stands in for lights: an even sky, W/(m²·sr), and a sun from above, to the right and before the things, W/m². The sky
/// alone would show white things as nothing.
const SKY: [f64; 3] = [0.5; 3];
const SUN: [f64; 3] = [2.0; 3];
const SUN_DIRECTION: [f64; 3] = [-0.4, -0.8, -0.5];

/// A file whose meshes and textures are among the assets.
pub(super) struct Included {
    source: Source,
    /// The file's, or one that has everything in view.
    pub camera: CameraDescription,
    has_camera: bool,
    pub settings: RenderSettings,
    materials: Vec<MaterialDescription>,
    media: Vec<MediumDescription>,
    objects: Vec<ObjectDescription>,
    lights: Vec<LightDescription>,
    is_lit: bool,
    warnings: Vec<Problem>,
}

/// The file that `include` names, if it can be read.
pub(super) fn read(root: &Section<'_>, folder: &Path, wanted: &Wanted) -> Option<Imported> {
    let Some(value) = root.get("include") else {
        for name in wanted.camera.iter().chain(&wanted.variant) {
            let problem = Problem::new(format!("`{}` is to be found in a file, but none is included", name.name));
            root.reader.report(problem.help("name the file: include = \"x.gltf\"").at(&name.source));
        }
        return None;
    };
    let name = root.reader.convert("include", value, &Text)?;
    let path = folder.join(&name);
    let used_at = root.reader.source(value.span());
    if !is_foreign(&path) {
        let problem = Problem::new(format!("`{name}` is no file that can be included"));
        let help = "glTF and pbrt files are, whose names end in .gltf, .glb or .pbrt";
        root.reader.report(problem.help(help).at(&used_at));
        return None;
    }
    let placed = |problems: Problems| Problems(problems.0.into_iter().map(|p| p.at_unless_placed(&used_at)).collect());
    read_file(&path, wanted).map_err(|problems| root.reader.report_all(placed(problems))).ok()
}

/// A glTF or pbrt file by its name.
pub(super) fn read_file(path: &Path, wanted: &Wanted) -> Result<Imported, Problems> {
    if !pbrt::is_pbrt(path) {
        return gltf::read(path, wanted);
    }
    match wanted.camera.as_ref().or(wanted.variant.as_ref()) {
        None => pbrt::read(path, wanted.lenient, &wanted.memory),
        Some(name) => {
            let problem =
                Problem::new(format!("{} is a pbrt file: it has no cameras or variants by name", path.display()));
            Err(problem.help("it has one camera; leave the name out").at(&name.source).into())
        }
    }
}

impl Included {
    /// `assets` hold nothing yet, so that its indices stay what they are.
    pub fn into_assets(imported: Imported, assets: &mut Assets) -> Included {
        let Imported { source, camera, has_camera, settings, materials, textures, meshes, objects, .. } = imported;
        let Imported { media, lights, is_lit, warnings, .. } = imported;
        assets.textures = textures;
        assets.meshes = meshes;
        Included { source, camera, has_camera, settings, materials, media, objects, lights, is_lit, warnings }
    }

    /// Puts the file's things before the scene's own, which take the place of materials and media of the same name and of all lights
    /// that are no objects; returns what is to be said about it.
    pub fn add_to(
        mut self,
        materials: &mut Vec<MaterialDescription>,
        media: &mut Vec<MediumDescription>,
        objects: &mut Vec<ObjectDescription>,
        lights: &mut Vec<LightDescription>,
        camera_is_given: bool,
    ) -> Vec<Problem> {
        let is_lit = self.is_lit || !lights.is_empty() || objects.iter().any(|object| object.emission.is_some());
        self.materials.retain(|own| materials.iter().all(|material| material.name != own.name));
        materials.splice(0..0, self.materials);
        self.media.retain(|own| media.iter().all(|medium| medium.name != own.name));
        media.append(&mut self.media);
        objects.splice(0..0, self.objects);
        if lights.is_empty() {
            lights.append(&mut self.lights);
        }
        let mut say = |what: &str, help: &str| self.warnings.push(Problem::new(what).help(help).at(&self.source));
        if !self.has_camera && !camera_is_given {
            say("the file has no camera: one that has everything in view stands in", "set camera.position and others");
        }
        if !is_lit {
            let sun = LightModel::Directional {
                direction: SUN_DIRECTION,
                irradiance: SUN,
                extent: ExtentDescription::Unbounded,
            };
            let stand_ins = [LightModel::Environment { radiance: SKY }, sun];
            lights.extend(stand_ins.map(|model| LightDescription {
                source: self.source.clone(),
                model,
                group: None,
                photons: PhotonChoice::Auto,
                motion: Vec::new(),
            }));
            say("the file has no light: a sky of 0.5 W/(m² sr) and a sun of 2 W/m² stand in", "add lights to it");
        }
        self.warnings
    }
}
