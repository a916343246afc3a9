//! What a foreign scene file holds, in the terms of a description: a scene file of ours takes it in.

use crate::scene::description::{
    CameraDescription, LightDescription, MaterialDescription, MediumDescription, MeshDescription, ObjectDescription,
    TextureDescription,
};
use crate::scene::error::{Problem, Source};
use crate::scene::settings::RenderSettings;

/// A glTF or pbrt file that was read.
pub struct Imported {
    pub source: Source,
    /// Its camera, or one that stands in.
    pub camera: CameraDescription,
    /// Whether the camera is its own.
    pub has_camera: bool,
    /// What a render of it uses where nobody says otherwise.
    pub settings: RenderSettings,
    pub materials: Vec<MaterialDescription>,
    pub textures: Vec<TextureDescription>,
    pub media: Vec<MediumDescription>,
    pub meshes: Vec<MeshDescription>,
    pub objects: Vec<ObjectDescription>,
    pub lights: Vec<LightDescription>,
    /// Whether it brings its own light: glowing pictures alone are no lamps.
    pub is_lit: bool,
    /// About what is left out.
    pub warnings: Vec<Problem>,
}
