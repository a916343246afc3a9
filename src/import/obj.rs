//! Wavefront OBJ: meshes through `tobj`, after a scan of our own that finds what is wrong and on which line.
//!
//! The scan hands `tobj` a cleaned text: absolute indices, three corners or more a face, a texture coordinate at every
//! corner (the first is (0, 0) and stands for a missing one), nothing that this program does not read.

mod mtl;
mod scan;

use std::cell::RefCell;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use tobj::{LoadError, LoadOptions, Model};

use self::scan::Scan;
use super::mesh_file::{MeshFile, MeshMaterial};
use super::{MAX_MESH_BYTES, read_bytes};
use crate::scene::error::{Problem, Problems, Source};
use crate::scene::mesh::TriangleMesh;

/// What is wanted of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Its normals.
    pub normals: bool,
    /// The materials of its MTL.
    pub materials: bool,
}

/// Reads an OBJ file and, if wanted, the MTL files that it names.
///
/// # Errors
/// A file that cannot be read; what is wrong in it, with the line: numbers that are not finite, indices out of range,
/// faces of less than three corners, faces with and without normals if normals are wanted.
pub fn read(path: &Path, wanted: Wanted) -> Result<MeshFile, Problems> {
    // Comments and names are in whatever encoding their program writes.
    let bytes = read_bytes(path, MAX_MESH_BYTES)?;
    parse(path, &String::from_utf8_lossy(&bytes), wanted)
}

/// Like [`read`] with the content of the OBJ file at hand.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, text: &str, wanted: Wanted) -> Result<MeshFile, Problems> {
    let source = Source::file(path);
    let scan = Scan::of(text, &source, wanted)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let materials: RefCell<Vec<MeshMaterial>> = RefCell::default();
    let problems: RefCell<Problems> = RefCell::default();
    let load_materials = |library: &Path| {
        let used_at = source.at_line(scan.library_line(library));
        mtl::read(&folder.join(library), &used_at).map_or_else(
            |found| {
                problems.borrow_mut().append(found);
                Err(LoadError::OpenFileFailed)
            },
            |(tables, described)| {
                materials.borrow_mut().extend(described);
                tables
            },
        )
    };
    let options = LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let loaded = tobj::load_obj_buf(&mut Cursor::new(scan.clean.as_bytes()), &options, load_materials);
    let problems = problems.into_inner();
    if !problems.is_empty() {
        return Err(problems);
    }
    // The scan leaves nothing for tobj to refuse.
    let (models, _) = loaded.map_err(|error| Problem::new(format!("cannot read the file: {error}")).at(&source))?;
    Ok(join(&models, &scan, source, materials.into_inner(), wanted))
}

/// Lays tobj's models, one for each change of material, behind each other.
fn join(models: &[Model], scan: &Scan, source: Source, materials: Vec<MeshMaterial>, wanted: Wanted) -> MeshFile {
    let mut mesh = TriangleMesh::default();
    let mut triangle_materials = Vec::new();
    for Model { mesh: part, .. } in models {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(part.positions.as_chunks::<3>().0);
        mesh.uvs.extend(part.texcoords.as_chunks::<2>().0);
        mesh.normals.extend(part.normals.as_chunks::<3>().0.iter().map(|n| normalised(*n)));
        let corners = part.indices.as_chunks::<3>().0;
        mesh.triangles.extend(corners.iter().map(|t| t.map(|i| first + i)));
        triangle_materials.extend(corners.iter().map(|_| part.material_id));
    }
    if !scan.has_uvs {
        mesh.uvs.clear();
    }
    if !wanted.normals {
        mesh.normals.clear();
    }
    MeshFile { source, mesh, triangle_lines: scan.triangle_lines.clone(), triangle_materials, materials }
}

fn normalised(n: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = n.map(f64::from);
    let length = (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|c| (c / length) as f32)
}

/// The path that `mtllib` names, as tobj reads it.
fn library_path(rest: &str) -> PathBuf {
    PathBuf::from(rest.trim())
}
