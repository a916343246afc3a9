//! Files that a scene names, read once each: images and meshes.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::image::{self, ColourSpace};
use super::mesh_file::{MeshFile, MeshMaterial, MeshMaterialModel, Part};
use super::volume::{self, NumberFormat, Volume};
use super::{animated, obj, ply};
use crate::scene::description::{
    MaterialDescription, MaterialModel, MeshDescription, Parameter, Reference, TextureDescription,
};
use crate::scene::error::{Problem, Problems, Source};
use crate::scene::texture::{ImageTexture, TextureMemory, Wrap};

/// A mesh file and what is asked for its normals.
type MeshKey = (PathBuf, Option<bool>);

/// Mesh files of the frames, the bits of the first's and the last's time, and what is asked for normals.
type AnimatedKey = (Vec<PathBuf>, [u64; 2], Option<bool>);

/// What was read so far. A file that failed is reported by its first use only; its later uses get an empty error.
pub(crate) struct Assets {
    folder: PathBuf,
    memory: TextureMemory,
    pub textures: Vec<TextureDescription>,
    pub meshes: Vec<MeshDescription>,
    /// Materials that mesh files bring along.
    pub materials: Vec<MaterialDescription>,
    texture_index: HashMap<(PathBuf, Option<ColourSpace>, Wrap), Option<usize>>,
    mesh_index: HashMap<MeshKey, Option<usize>>,
    animated_index: HashMap<AnimatedKey, Option<usize>>,
    part_index: HashMap<MeshKey, Option<Vec<(usize, Reference)>>>,
}

impl Assets {
    /// Relative paths start at `folder`, textures find room in `memory`.
    pub fn new(folder: &Path, memory: TextureMemory) -> Assets {
        Assets {
            folder: folder.to_owned(),
            memory,
            textures: Vec::new(),
            meshes: Vec::new(),
            materials: Vec::new(),
            texture_index: HashMap::new(),
            mesh_index: HashMap::new(),
            animated_index: HashMap::new(),
            part_index: HashMap::new(),
        }
    }

    /// The index of an image, read if it is new.
    pub fn texture(
        &mut self,
        file: &str,
        space: Option<ColourSpace>,
        wrap: Wrap,
        used_at: &Source,
    ) -> Result<usize, Problems> {
        let path = self.folder.join(file);
        let key = (path.clone(), space, wrap);
        if let Some(known) = self.texture_index.get(&key) {
            return known.ok_or_else(Problems::default);
        }
        let read = image::read(&path, space, wrap, &self.memory);
        self.texture_index.insert(key, read.is_ok().then_some(self.textures.len()));
        let image = read.map_err(|problem| problem.at_unless_placed(used_at))?;
        self.textures.push(TextureDescription { source: used_at.clone(), image });
        Ok(self.textures.len() - 1)
    }

    /// A grid of numbers; each medium has its own.
    pub fn volume(
        &self,
        file: &str,
        raw: Option<([usize; 3], NumberFormat)>,
        used_at: &Source,
    ) -> Result<Volume, Problem> {
        volume::read(&self.folder.join(file), raw).map_err(|problem| problem.at_unless_placed(used_at))
    }

    /// An image that surrounds the scene, which is looked at all over: it is no texture that could be left in a file.
    pub fn panorama(&self, file: &str, space: Option<ColourSpace>, used_at: &Source) -> Result<ImageTexture, Problem> {
        let read = image::read(&self.folder.join(file), space, Wrap::Repeat, &TextureMemory::unlimited());
        read.map_err(|problem| problem.at_unless_placed(used_at))
    }

    /// The index of a whole mesh file, read if it is new. `smooth`: compute normals, or have none; else the file's.
    pub fn mesh(&mut self, file: &str, smooth: Option<bool>, used_at: &Source) -> Result<usize, Problems> {
        let key = (self.folder.join(file), smooth);
        if let Some(known) = self.mesh_index.get(&key) {
            return known.ok_or_else(Problems::default);
        }
        let read = read_mesh(&key.0, smooth, false, used_at);
        self.mesh_index.insert(key, read.is_ok().then_some(self.meshes.len()));
        let MeshFile { source, mesh, triangle_lines, .. } = read?;
        self.meshes.push(MeshDescription { source, mesh, triangle_lines });
        Ok(self.meshes.len() - 1)
    }

    /// The index of a mesh whose shapes are `files`, two at least, at equal intervals between the two `times`; read if it is
    /// new.
    pub fn animated_mesh(
        &mut self,
        files: &[String],
        times: [f64; 2],
        smooth: Option<bool>,
        used_at: &Source,
    ) -> Result<usize, Problems> {
        let paths: Vec<PathBuf> = files.iter().map(|file| self.folder.join(file)).collect();
        let key = (paths, times.map(f64::to_bits), smooth);
        if let Some(known) = self.animated_index.get(&key) {
            return known.ok_or_else(Problems::default);
        }
        let read = animated::read(&key.0, times, |path| read_mesh(path, smooth, false, used_at));
        self.animated_index.insert(key, read.is_ok().then_some(self.meshes.len()));
        let placed =
            |problems: Problems| Problems(problems.0.into_iter().map(|p| p.at_unless_placed(used_at)).collect());
        let MeshFile { source, mesh, triangle_lines, .. } = read.map_err(placed)?;
        self.meshes.push(MeshDescription { source, mesh, triangle_lines });
        Ok(self.meshes.len() - 1)
    }

    /// The parts of a mesh file by its own materials: index of the mesh and name of the material.
    pub fn mesh_with_materials(
        &mut self,
        file: &str,
        smooth: Option<bool>,
        used_at: &Source,
    ) -> Result<Vec<(usize, Reference)>, Problems> {
        let key = (self.folder.join(file), smooth);
        if let Some(known) = self.part_index.get(&key) {
            return known.clone().ok_or_else(Problems::default);
        }
        let read = read_mesh(&key.0, smooth, true, used_at).and_then(|mesh| self.add_parts(mesh, file, used_at));
        self.part_index.insert(key, read.as_ref().ok().cloned());
        read
    }

    fn add_parts(&mut self, mesh: MeshFile, file: &str, used_at: &Source) -> Result<Vec<(usize, Reference)>, Problems> {
        let (source, materials) = (mesh.source.clone(), mesh.materials.clone());
        let parts = mesh.into_parts().map_err(|problems| {
            if materials.is_empty() {
                let problem = Problem::new(format!("`{file}` brings no material along"));
                return problem.help("give the object a `material`").at(used_at).into();
            }
            problems
        })?;
        let mut placed = Vec::new();
        for part in parts {
            let material = self.add_material(&materials[part.material], file)?;
            let Part { mesh, triangle_lines, .. } = part;
            self.meshes.push(MeshDescription { source: source.clone(), mesh, triangle_lines });
            placed.push((self.meshes.len() - 1, material));
        }
        Ok(placed)
    }

    /// Describes a mesh file's material under a name that no scene file is likely to use.
    fn add_material(&mut self, material: &MeshMaterial, file: &str) -> Result<Reference, Problems> {
        let name = format!("{file}:{}", material.name);
        let reference = Reference { name: name.clone(), source: material.source.clone() };
        if self.materials.iter().any(|m| m.name == name) {
            return Ok(reference);
        }
        let beside_mesh = |image: &str| match Path::new(file).parent() {
            Some(folder) => folder.join(image).to_string_lossy().into_owned(),
            None => image.to_owned(),
        };
        let model = match &material.model {
            MeshMaterialModel::Lambert { albedo, image: None } => {
                MaterialModel::Lambert { albedo: Parameter::Constant(*albedo) }
            }
            MeshMaterialModel::Lambert { albedo, image: Some(image) } => {
                let image = beside_mesh(image);
                let texture = self.texture(&image, None, Wrap::Repeat, &material.source)?;
                MaterialModel::Lambert { albedo: Parameter::Image { texture, factor: *albedo } }
            }
            MeshMaterialModel::Mirror { reflectance } => {
                MaterialModel::Mirror { reflectance: Parameter::Constant(*reflectance) }
            }
            MeshMaterialModel::Dielectric { ior } => {
                MaterialModel::Dielectric { ior: *ior, exterior: 1.0, fresnel: true }
            }
            MeshMaterialModel::RoughDielectric { ior, roughness } => {
                let roughness = Parameter::Constant(*roughness);
                MaterialModel::RoughDielectric { ior: *ior, exterior: 1.0, roughness }
            }
            MeshMaterialModel::Metal { reflectance, roughness } => MaterialModel::RoughConductor {
                eta: reflectance.map(index_of_reflectance),
                k: [0.0; 3],
                roughness: Parameter::Constant(*roughness),
            },
        };
        self.materials.push(MaterialDescription { name, source: material.source.clone(), model, interior: None });
        Ok(reference)
    }
}

/// The real index whose Fresnel reflectance at normal incidence is `r`: η = (1 + √r)/(1 − √r).
fn index_of_reflectance(r: f64) -> f64 {
    // A real index never reflects everything.
    let root = r.clamp(0.0, 0.999).sqrt();
    (1.0 + root) / (1.0 - root)
}

fn read_mesh(path: &Path, smooth: Option<bool>, materials: bool, used_at: &Source) -> Result<MeshFile, Problems> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let read = match extension.as_str() {
        "obj" => obj::read(path, obj::Wanted { normals: smooth.is_none(), materials }),
        "ply" => ply::read(path, smooth.is_none()),
        _ => {
            let problem = Problem::new(format!("`{}` is no mesh file that can be read", path.display()));
            return Err(problem.help("meshes are .obj or .ply files").at(used_at).into());
        }
    };
    let placed = |problems: Problems| Problems(problems.0.into_iter().map(|p| p.at_unless_placed(used_at)).collect());
    let mut file = read.map_err(placed)?;
    match smooth {
        Some(true) => file.mesh.normals = file.mesh.angle_weighted_normals(),
        Some(false) => file.mesh.normals.clear(),
        None => {}
    }
    Ok(file)
}
