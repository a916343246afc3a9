//! What is rendered: geometry, materials, lights, camera and settings as plain validated data.
//!
//! Importers produce a [`description`], [`assemble()`] checks it whole and makes a [`Scene`].

pub mod artistic;
pub mod assemble;
pub mod camera;
pub mod deformation;
pub mod density;
pub mod description;
pub mod error;
pub mod hash;
pub mod ids;
pub mod light;
pub mod light_group;
pub mod material;
pub mod medium;
pub mod mesh;
pub mod metal;
pub mod named_settings;
pub mod object;
pub mod panorama;
pub mod settings;
pub mod spelling;
pub mod texture;

pub use artistic::{Caustics, LightPhotons, PhotonChoice};
pub use assemble::assemble;
pub use camera::{CameraModel, CameraSettings, Shutter};
pub use deformation::Deformation;
pub use ids::{LightId, MaterialId, MediumId, MeshId, ObjectId, TextureId};
pub use light::LightSource;
pub use light_group::{GroupId, GroupLayer, LightGroups};
pub use material::Material;
pub use medium::{Media, Medium};
pub use mesh::TriangleMesh;
pub use object::{Object, ObjectGeometry};
pub use panorama::Panorama;
pub use settings::RenderSettings;
pub use texture::{ImageTexture, TextureMemory, Textured};

use std::sync::Arc;

use crate::math::{Bounds3, Motion};

/// A scene that was checked whole: every id is in range, every number finite, every mesh index valid.
#[derive(Clone, Debug)]
pub struct Scene {
    pub objects: Vec<Object>,
    pub meshes: Vec<TriangleMesh>,
    pub materials: Vec<Material>,
    /// What the scene file calls them.
    pub material_names: Vec<String>,
    pub textures: Vec<ImageTexture>,
    pub media: Media,
    /// Area lights are among them, naming their object.
    pub lights: Vec<LightSource>,
    /// How light i moves while the shutter is open, rigidly; shorter than `lights` where the last ones do not. What moves is
    /// in `lights` where it is in the middle of the interval. Area lights move as their objects do.
    pub light_motions: Vec<Option<Arc<Motion>>>,
    /// Whose light is kept apart.
    pub light_groups: LightGroups,
    /// How many photons each is to send.
    pub light_photons: LightPhotons,
    pub camera: CameraSettings,
    /// When the picture is taken; an instant unless something moves meanwhile.
    pub shutter: Shutter,
    pub settings: RenderSettings,
    /// World bounds of all objects, wherever they are while the shutter is open.
    pub bounds: Bounds3,
    /// Digest of everything that can change a pixel, hexadecimal.
    pub hash: String,
    /// Digest of the scene's contents, without the settings it is rendered with.
    pub contents: String,
}
