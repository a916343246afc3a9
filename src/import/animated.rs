//! Mesh files of equal topology become one mesh that changes its shape.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::mesh_file::MeshFile;
use crate::scene::Deformation;
use crate::scene::deformation::VertexFrame;
use crate::scene::error::{Problem, Problems};

/// The first of `files` with the shapes of all of them, at equal intervals between the two `times`, s.
///
/// # Errors
/// Fewer than two files, times that do not increase, files that cannot be read, or whose triangles are not those of the
/// first.
pub(super) fn read(
    files: &[PathBuf],
    [start, end]: [f64; 2],
    read: impl Fn(&Path) -> Result<MeshFile, Problems>,
) -> Result<MeshFile, Problems> {
    if files.len() < 2 {
        let problem = Problem::new("a mesh that changes its shape needs at least two files");
        return Err(problem.help("write file = \"name.obj\" for one that keeps it").into());
    }
    let interval = (end - start) / (files.len() - 1) as f64;
    // Written so that a NaN fails.
    if !(interval > 0.0 && interval.is_finite()) {
        let problem = Problem::new(format!("the first file is of the time {start} s, the last one of {end} s"));
        return Err(problem.help("write times = [first, last], the last being later").into());
    }
    let mut first = read(&files[0])?;
    let mut frames = vec![frame(&mut first)];
    for path in &files[1..] {
        let mut file = read(path)?;
        let next = frame(&mut file);
        let same = next.positions.len() == frames[0].positions.len() && next.normals.len() == frames[0].normals.len();
        if !same || file.mesh.triangles != first.mesh.triangles {
            let problem =
                Problem::new(format!("`{}` has not the triangles of `{}`", path.display(), files[0].display()));
            let help =
                "all files must have the same faces over as many vertices, and normals in all of them or in none";
            return Err(problem.help(help).at(&file.source).into());
        }
        frames.push(next);
    }
    (first.mesh.positions, first.mesh.normals) = (frames[0].positions.clone(), frames[0].normals.clone());
    first.mesh.deformation = Some(Arc::new(Deformation { start, interval, frames }));
    Ok(first)
}

fn frame(file: &mut MeshFile) -> VertexFrame {
    let mesh = &mut file.mesh;
    VertexFrame { positions: std::mem::take(&mut mesh.positions), normals: std::mem::take(&mut mesh.normals) }
}
