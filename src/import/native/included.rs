//! What a glTF file brings into a scene, and what stands in for what it lacks.

use crate::import::assets::Assets;
use crate::import::gltf::GltfScene;
use crate::scene::description::{
    CameraDescription, ExtentDescription, LightDescription, LightModel, ObjectDescription,
};
use crate::scene::error::{Problem, Source};

/// What stands in for lights: an even sky, W/(m²·sr), and a sun from above, to the right and before the things, W/m². The sky
/// alone would show white things as nothing.
const SKY: [f64; 3] = [0.5; 3];
const SUN: [f64; 3] = [2.0; 3];
const SUN_DIRECTION: [f64; 3] = [-0.4, -0.8, -0.5];

/// A file whose meshes, textures and materials are among the assets.
pub(super) struct Included {
    source: Source,
    /// The file's, or one that has everything in view.
    pub camera: CameraDescription,
    has_camera: bool,
    objects: Vec<ObjectDescription>,
    lights: Vec<LightDescription>,
    is_lit: bool,
    warnings: Vec<Problem>,
}

impl Included {
    /// `assets` hold nothing yet, so that its indices stay what they are.
    pub fn into_assets(gltf: GltfScene, assets: &mut Assets) -> Included {
        let (has_camera, framing) = (gltf.camera.is_some(), gltf.framing_camera());
        let GltfScene { source, camera, materials, textures, meshes, objects, lights, is_lit, warnings, .. } = gltf;
        assets.materials = materials;
        assets.textures = textures;
        assets.meshes = meshes;
        Included { source, camera: camera.unwrap_or(framing), has_camera, objects, lights, is_lit, warnings }
    }

    /// Puts the file's things before the scene's own; returns what is to be said about it.
    pub fn add_to(
        mut self,
        objects: &mut Vec<ObjectDescription>,
        lights: &mut Vec<LightDescription>,
        camera_is_given: bool,
    ) -> Vec<Problem> {
        let is_lit = self.is_lit || !lights.is_empty() || objects.iter().any(|object| object.emission.is_some());
        objects.splice(0..0, self.objects);
        lights.splice(0..0, self.lights);
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
            lights.extend(stand_ins.map(|model| LightDescription { source: self.source.clone(), model }));
            say("the file has no light: a sky of 0.5 W/(m² sr) and a sun of 2 W/m² stand in", "add lights to it");
        }
        self.warnings
    }
}
