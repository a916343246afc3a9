//! glTF 2.0 becomes part of a description: `.gltf` with its buffers beside it or within, and `.glb`.
//!
//! Metres, right-handed, +y up, as here. What a file uses and nothing here renders is listed in one warning. The mapping is
//! described in [`crate::doc::gltf`].

mod accessor;
mod buffers;
mod camera;
mod container;
mod layers;
mod lights;
mod materials;
mod mesh;
mod nodes;
mod references;
mod textures;
mod uri;
mod variants;

use std::collections::HashMap;
use std::path::Path;

use gltf::{Document, Primitive};

use self::buffers::Buffers;
use self::materials::Materials;
use self::mesh::Budget;
use self::nodes::Placed;
use self::textures::Textures;
use super::ignored::Ignored;
use super::imported::{Imported, Wanted};
use super::names::Names;
use super::{MAX_MESH_BYTES, read_bytes};
use crate::math::{Bounds3, Point3};
use crate::scene::Caustics;
use crate::scene::description::{
    LightDescription, MeshDescription, ObjectDescription, Reference, ShapeDescription, TransformStep,
};
use crate::scene::error::{Problem, Problems, Source};
use crate::scene::settings::RenderSettings;

/// Whether a file goes by a name that glTF files have.
pub fn is_gltf(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf") || e.eq_ignore_ascii_case("glb"))
}

/// Reads the file and those that it names.
///
/// # Errors
/// Files that cannot be read, and everything that makes this one no sound glTF.
pub fn read(path: &Path, wanted: &Wanted) -> Result<Imported, Problems> {
    let bytes = read_bytes(path, MAX_MESH_BYTES)?;
    parse_with(path, &bytes, wanted)
}

/// Like [`read`] with the content of the file at hand; `path` is for messages and for finding other files.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Imported, Problems> {
    parse_with(path, bytes, &Wanted::default())
}

fn parse_with(path: &Path, bytes: &[u8], wanted: &Wanted) -> Result<Imported, Problems> {
    let source = Source::file(path);
    let container = container::open(bytes, &source)?;
    let document = Document::from_json_without_validation(container.root);
    let folder = path.parent().unwrap_or(Path::new(""));
    let buffers = Buffers::load(&document, container.blob, folder, &source)?;
    let refuse = |what: String| Problem::new(format!("not a sound glTF file: {what}")).at(&source);
    let placed = nodes::placed(&document).map_err(refuse)?;

    let variant = variants::wanted(&document, wanted.variant.as_ref(), &source)?;
    let mut ignored = Ignored::default();
    note_ignored(&document, &mut ignored);
    let textures = Textures::new(&document, &buffers, folder, &source, &wanted.memory);
    let mut reading = Reading {
        source: &source,
        buffers: &buffers,
        budget: Budget::of(&buffers),
        variant,
        materials: Materials::new(&document, textures, &source),
        names: Names::default(),
        meshes: Vec::new(),
        mesh_index: HashMap::new(),
        objects: Vec::new(),
        bounds: Bounds3::EMPTY,
        has_lamp: false,
        ignored: &mut ignored,
    };
    for item in &placed {
        reading.add_objects(item)?;
    }
    let Reading { materials, meshes, objects, bounds, has_lamp, .. } = reading;
    let (materials, textures, media) = materials.into_parts();
    let lights: Vec<LightDescription> = placed
        .iter()
        .filter_map(|item| lights::describe(&item.node.light()?, &item.to_world, &source, &mut ignored))
        .collect();
    let cameras: Vec<&Placed<'_>> = placed.iter().filter(|item| item.node.camera().is_some()).collect();
    let taken = wanted.camera.as_ref().map_or(Ok(0), |name| camera::find(&cameras, name, &source))?;
    let taken = cameras.get(taken).and_then(|item| Some((item.node.camera()?, item.to_world)));
    let camera = taken.map(|(camera, to_world)| camera::describe(&camera, &to_world, &source));
    let camera = camera.transpose().map_err(refuse)?;
    ignored.note_if(cameras.len() > 1 && wanted.camera.is_none(), "cameras behind the first one");
    let warnings = ignored.warning(&source).into_iter().collect();
    let is_lit = has_lamp || !lights.is_empty();
    Ok(Imported {
        has_camera: camera.is_some(),
        camera: camera.unwrap_or_else(|| camera::framing(bounds, &source)),
        settings: RenderSettings::default(),
        source,
        materials,
        textures,
        media,
        meshes,
        objects,
        lights,
        is_lit,
        warnings,
    })
}

/// Extensions that are read.
const READ: [&str; 12] = [
    "KHR_lights_punctual",
    "KHR_texture_transform",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
];

fn note_ignored(document: &Document, ignored: &mut Ignored) {
    for name in document.extensions_used().filter(|name| !READ.contains(name)) {
        ignored.note(name);
    }
    ignored.note_if(document.animations().len() > 0, "animations");
    ignored.note_if(document.skins().len() > 0, "skins");
    ignored.note_if(document.scenes().len() > 1, "scenes other than the default one");
}

/// Objects as they are put together.
struct Reading<'a, 'i> {
    source: &'a Source,
    buffers: &'a Buffers<'a>,
    budget: Budget,
    /// Which of the file's.
    variant: Option<u32>,
    materials: Materials<'a>,
    names: Names,
    meshes: Vec<MeshDescription>,
    /// By mesh and primitive; a mesh that several nodes show is read once. `None` for points and lines.
    mesh_index: HashMap<(usize, usize), Option<usize>>,
    objects: Vec<ObjectDescription>,
    bounds: Bounds3,
    has_lamp: bool,
    ignored: &'i mut Ignored,
}

impl Reading<'_, '_> {
    /// One object for each primitive of the node's mesh.
    fn add_objects(&mut self, item: &Placed<'_>) -> Result<(), Problem> {
        let Some(mesh) = item.node.mesh() else { return Ok(()) };
        if nodes::is_flat(&item.to_world) {
            self.ignored.note("meshes of nodes that are scaled to nothing");
            return Ok(());
        }
        self.ignored.note_if(item.node.weights().or(mesh.weights()).is_some(), "morph targets");
        let label =
            item.node.name().or(mesh.name()).map_or_else(|| format!("node {}", item.node.index()), str::to_owned);
        for primitive in mesh.primitives() {
            let finish = self.materials.of(&variants::material(&primitive, self.variant), self.ignored)?;
            let key = (mesh.index(), primitive.index());
            let index = match self.mesh_index.get(&key) {
                Some(known) => *known,
                None => self.read_mesh(key, &primitive, finish.uv_set)?,
            };
            let Some(index) = index else { continue };
            let map = nodes::transform_map(&item.to_world);
            let transform = map.map(|map| TransformStep { source: self.source.clone(), map });
            self.include(index, item);
            self.has_lamp |= finish.is_lamp;
            self.objects.push(ObjectDescription {
                name: self.names.unique(&label),
                source: self.source.clone(),
                shape: ShapeDescription::Mesh { mesh: Some(index) },
                material: Reference { name: finish.name, source: self.source.clone() },
                transform: transform.into_iter().collect(),
                motion: Vec::new(),
                emission: finish.emission,
                caustics: Caustics::default(),
            });
        }
        Ok(())
    }

    fn read_mesh(
        &mut self,
        key: (usize, usize),
        primitive: &Primitive<'_>,
        uv_set: Option<u32>,
    ) -> Result<Option<usize>, Problem> {
        let read = mesh::read(primitive, uv_set, self.buffers, &mut self.budget, self.ignored).map_err(|what| {
            let place = format!("meshes[{}].primitives[{}]", key.0, key.1);
            Problem::new(format!("not a sound glTF file: {place}: {what}")).at(self.source)
        })?;
        let index = read.map(|mesh| {
            self.meshes.push(MeshDescription { source: self.source.clone(), mesh, triangle_lines: Vec::new() });
            self.meshes.len() - 1
        });
        self.mesh_index.insert(key, index);
        Ok(index)
    }

    fn include(&mut self, mesh: usize, item: &Placed<'_>) {
        let corners = self.meshes[mesh].mesh.bounds().corners();
        let world = corners.map(|p| item.to_world.transform_point3(glam::DVec3::new(p.x, p.y, p.z)));
        self.bounds = self.bounds.union(Bounds3::from_points(world.map(|p| Point3::new(p.x, p.y, p.z))));
    }
}
