//! What every importer produces: a scene as plain data, as its author wrote it, each item with its place in a file.
//!
//! Nothing here is checked beyond its type: names may dangle, lights may be missing, triangles may be degenerate.
//! [`assemble`](super::assemble()) checks the whole and reports every problem at once. World space, metres, right-handed;
//! numbers are in the units that the fields name.

use std::sync::Arc;

use super::artistic::{Caustics, PhotonChoice};
use super::camera::PixelFilter;
use super::density::DensityGrid;
use super::error::{Problem, Source};
use super::mesh::TriangleMesh;
use super::panorama::Panorama;
use super::settings::RenderSettings;
use super::texture::ImageTexture;

/// A scene as an importer read it.
#[derive(Clone, Debug)]
pub struct SceneDescription {
    /// The scene file as a whole.
    pub source: Source,
    pub camera: Option<CameraDescription>,
    pub settings: RenderSettings,
    pub settings_source: Source,
    pub materials: Vec<MaterialDescription>,
    pub textures: Vec<TextureDescription>,
    pub media: Vec<MediumDescription>,
    /// The medium that fills the whole scene.
    pub atmosphere: Option<Reference>,
    pub meshes: Vec<MeshDescription>,
    pub objects: Vec<ObjectDescription>,
    /// Area lights are objects with [`ObjectDescription::emission`], the others are here.
    pub lights: Vec<LightDescription>,
    /// What importers left out or assumed.
    pub warnings: Vec<Problem>,
}

/// A name that refers to another item, and where it was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    pub name: String,
    pub source: Source,
}

#[derive(Clone, Debug)]
pub struct CameraDescription {
    pub source: Source,
    pub model: CameraModelDescription,
    pub position: [f64; 3],
    pub target: [f64; 3],
    pub up: [f64; 3],
    /// Pixels: width, height.
    pub resolution: [u32; 2],
    pub filter: PixelFilter,
    /// When it opens and closes, s.
    pub shutter: Option<[f64; 2]>,
    /// Where it is at other times than always.
    pub motion: Vec<CameraKeyDescription>,
}

/// The camera's place at one time.
#[derive(Clone, Debug)]
pub struct CameraKeyDescription {
    pub source: Source,
    /// s.
    pub time: f64,
    pub position: [f64; 3],
    pub target: [f64; 3],
    pub up: [f64; 3],
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraModelDescription {
    /// Full horizontal angle.
    Perspective { fov_degrees: f64 },
    /// Metres across the picture.
    Orthographic { width: f64 },
    /// Lens radius and focus distance in metres.
    ThinLens { fov_degrees: f64, lens_radius: f64, focus_distance: f64 },
}

/// A constant, or image `texture` (an index into the description's textures) times `factor`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter<T> {
    Constant(T),
    Image { texture: usize, factor: T },
}

#[derive(Clone, Debug)]
pub struct MaterialDescription {
    pub name: String,
    pub source: Source,
    pub model: MaterialModel,
    /// What the material's objects are filled with, where that is said.
    pub interior: Option<InteriorDescription>,
}

/// What is inside of objects.
#[derive(Clone, Debug, PartialEq)]
pub struct InteriorDescription {
    pub medium: Option<Reference>,
    /// Where objects overlap the highest one counts.
    pub priority: u32,
}

/// A participating medium, coefficients in 1/m.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumDescription {
    pub name: String,
    pub source: Source,
    pub sigma_a: [f64; 3],
    pub sigma_s: [f64; 3],
    /// Mean cosine of the phase function.
    pub g: f64,
    /// What the coefficients are multiplied by from place to place.
    pub density: Option<Arc<DensityGrid>>,
}

/// Linear Rec.709 triples; roughness is the artist's number, whose square is the GGX width.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a scene has a few of them, copied while it is read")]
pub enum MaterialModel {
    Lambert {
        albedo: Parameter<[f64; 3]>,
    },
    Mirror {
        reflectance: Parameter<[f64; 3]>,
    },
    Dielectric {
        ior: f64,
        exterior: f64,
        fresnel: bool,
    },
    Conductor {
        eta: [f64; 3],
        k: [f64; 3],
    },
    RoughDielectric {
        ior: f64,
        exterior: f64,
        roughness: Parameter<f64>,
    },
    RoughConductor {
        eta: [f64; 3],
        k: [f64; 3],
        roughness: Parameter<f64>,
    },
    Plastic {
        albedo: Parameter<[f64; 3]>,
        ior: f64,
    },
    Principled {
        base_colour: Parameter<[f64; 3]>,
        metalness: Parameter<f64>,
        roughness: Parameter<f64>,
        transmission: Parameter<f64>,
        coverage: Parameter<f64>,
        ior: f64,
        thin: bool,
        normal: Option<NormalMapDescription>,
        specular: Option<SpecularDescription>,
        coat: Option<CoatDescription>,
    },
    /// No surface, only the boundary of a medium.
    Interface,
}

impl MaterialModel {
    /// Whether light gets into its objects.
    pub fn has_inside(&self) -> bool {
        matches!(
            self,
            MaterialModel::Dielectric { .. }
                | MaterialModel::RoughDielectric { .. }
                | MaterialModel::Principled { .. }
                | MaterialModel::Interface
        )
    }
}

/// What the reflectance over a principled material's diffuse base is multiplied by: everywhere, and at normal incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularDescription {
    pub weight: Parameter<f64>,
    pub colour: Parameter<[f64; 3]>,
}

/// The dielectric layer over a principled material, of which there is the part `weight`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatDescription {
    pub weight: Parameter<f64>,
    pub roughness: Parameter<f64>,
    pub ior: f64,
}

impl SpecularDescription {
    /// `None` where it changes nothing.
    pub fn unless_plain(self) -> Option<SpecularDescription> {
        let plain = SpecularDescription { weight: Parameter::Constant(1.0), colour: Parameter::Constant([1.0; 3]) };
        (self != plain).then_some(self)
    }
}

impl CoatDescription {
    /// `None` where there is nothing of it.
    pub fn unless_bare(self) -> Option<CoatDescription> {
        (self.weight != Parameter::Constant(0.0)).then_some(self)
    }
}

/// Image `texture` (an index into the description's textures) that bends shading normals; slopes are multiplied by `scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMapDescription {
    pub texture: usize,
    pub scale: f64,
}

/// An image that was read. Its wrapping is part of it: two uses with other wrapping are two textures.
#[derive(Clone, Debug)]
pub struct TextureDescription {
    /// Where the scene names the image.
    pub source: Source,
    pub image: ImageTexture,
}

/// A mesh that was read.
#[derive(Clone, Debug)]
pub struct MeshDescription {
    /// The mesh file.
    pub source: Source,
    pub mesh: TriangleMesh,
    /// The line of the file that defines each triangle; empty where a file has no lines.
    pub triangle_lines: Vec<u32>,
}

impl MeshDescription {
    /// Where triangle `prim` is defined, as exactly as the file allows.
    pub fn triangle_source(&self, prim: usize) -> Source {
        match self.triangle_lines.get(prim) {
            Some(&line) => self.source.at_line(line),
            None => self.source.clone(),
        }
    }
}

#[derive(Clone, Debug)]
pub struct ObjectDescription {
    /// As messages name it.
    pub name: String,
    pub source: Source,
    pub shape: ShapeDescription,
    pub material: Reference,
    /// Applied last to first, as matrices multiply.
    pub transform: Vec<TransformStep>,
    /// What happens to it after that, from time to time; empty for what stands still.
    pub motion: Vec<MotionKey>,
    pub emission: Option<Emission>,
    pub caustics: Caustics,
}

/// Geometry in object space, metres.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeDescription {
    Sphere {
        centre: [f64; 3],
        radius: f64,
    },
    /// An open band between two points of its axis.
    Cylinder {
        base: [f64; 3],
        top: [f64; 3],
        radius: f64,
    },
    Torus {
        centre: [f64; 3],
        axis: [f64; 3],
        major_radius: f64,
        minor_radius: f64,
    },
    Disk {
        centre: [f64; 3],
        normal: [f64; 3],
        radius: f64,
    },
    /// Half axes, perpendicular; normal along a × b.
    Rectangle {
        centre: [f64; 3],
        a: [f64; 3],
        b: [f64; 3],
    },
    /// z = Σ amplitude · sin(k·(x, y) + phase) over |x| ≤ hx, |y| ≤ hy in the frame (x_axis, up × x_axis, up).
    HeightField {
        centre: [f64; 3],
        half_size: [f64; 2],
        up: [f64; 3],
        x_axis: [f64; 3],
        waves: Vec<WaveDescription>,
    },
    /// An index into the description's meshes; `None` where its file could not be read (which was reported).
    Mesh {
        mesh: Option<usize>,
    },
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveDescription {
    /// Metres.
    pub amplitude: f64,
    /// Radians per metre.
    pub wave_vector: [f64; 2],
    /// Radians.
    pub phase: f64,
    /// Along the wave vector, m/s.
    pub speed: f64,
}

/// Where an object is at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionKey {
    pub source: Source,
    /// s.
    pub time: f64,
    pub transform: Vec<TransformStep>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct TransformStep {
    pub source: Source,
    pub map: TransformMap,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransformMap {
    Translate([f64; 3]),
    /// Right-handed.
    Rotate {
        axis: [f64; 3],
        degrees: f64,
    },
    Scale([f64; 3]),
    /// Rows of the 3×4 matrix [M | t].
    Matrix([[f64; 4]; 3]),
}

/// Makes an object a diffuse area light: W/(m²·sr).
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    pub source: Source,
    pub radiance: [f64; 3],
    pub two_sided: bool,
    /// The group of lights that it belongs to, if it says so.
    pub group: Option<Reference>,
    pub photons: PhotonChoice,
}

#[derive(Clone, Debug, PartialEq)]
pub struct LightDescription {
    pub source: Source,
    pub model: LightModel,
    /// The group of lights that it belongs to, if it says so.
    pub group: Option<Reference>,
    pub photons: PhotonChoice,
    /// What happens to it from time to time; empty for what stands still.
    pub motion: Vec<MotionKey>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum LightModel {
    /// W/sr.
    Point { position: [f64; 3], intensity: [f64; 3] },
    /// W/sr; `angle_degrees` is the half angle of the cone, `penumbra_degrees` the width of its smooth rim inside.
    Spot { position: [f64; 3], target: [f64; 3], intensity: [f64; 3], angle_degrees: f64, penumbra_degrees: f64 },
    /// Direction of travel; W/m² on a plane perpendicular to it.
    Directional { direction: [f64; 3], irradiance: [f64; 3], extent: ExtentDescription },
    /// W/(m²·sr).
    Environment { radiance: [f64; 3] },
    /// An image of radiance, W/(m²·sr), times a factor.
    Panorama(Panorama),
}

/// Cross-section of a collimated beam, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExtentDescription {
    Unbounded,
    Rectangle { centre: [f64; 3], a: [f64; 3], b: [f64; 3] },
    Disk { centre: [f64; 3], radius: f64 },
}
