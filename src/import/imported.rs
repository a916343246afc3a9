//! What a foreign scene file holds, in the terms of a description: a scene file of ours takes it in.

use crate::scene::description::{
    CameraDescription, LightDescription, MaterialDescription, MediumDescription, MeshDescription, ObjectDescription,
    Reference, TextureDescription,
};
use crate::scene::error::{Problem, Source};
use crate::scene::settings::RenderSettings;
use crate::scene::spelling::nearest;
use crate::scene::texture::TextureMemory;

/// Which of several things in a file are taken.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// The camera of that name; the first without.
    pub camera: Option<Reference>,
    /// The variant of that name; the materials that the file shows without.
    pub variant: Option<Reference>,
    /// Whether what of a pbrt file cannot be rendered is left out, with a warning.
    pub lenient: bool,
    /// Where textures find room.
    pub memory: TextureMemory,
}

/// The place of the name that is wanted among `names`, of things of this `kind` in a file.
///
/// # Errors
/// It is none of them.
pub(super) fn find(kind: &str, wanted: &Reference, names: &[&str], file: &Source) -> Result<usize, Problem> {
    names.iter().position(|name| *name == wanted.name).ok_or_else(|| {
        let help = match nearest(&wanted.name, names) {
            Some(near) => format!("did you mean `{near}`?"),
            None if names.is_empty() => format!("it has no {kind} with a name"),
            None => format!("it has: {}", names.join(", ")),
        };
        Problem::new(format!("{file} has no {kind} `{}`", wanted.name)).help(help).at(&wanted.source)
    })
}

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
