//! What mesh files say, before a scene gives it a material and a place.

use crate::scene::error::{Problem, Problems, Source};
use crate::scene::mesh::TriangleMesh;

/// A mesh as a file gives it, its faces cut into triangles. Every number is finite, every index in range.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// The file as a whole.
    pub source: Source,
    pub mesh: TriangleMesh,
    /// The line of each triangle; empty where the file has no lines.
    pub triangle_lines: Vec<u32>,
    /// For each triangle its material, an index into `materials`.
    pub triangle_materials: Vec<Option<usize>>,
    pub materials: Vec<MeshMaterial>,
}

/// A material that a mesh file brings along.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshMaterial {
    pub name: String,
    pub source: Source,
    pub model: MeshMaterialModel,
}

/// What the materials of mesh files can say here. Colours are linear Rec.709.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshMaterialModel {
    /// With an image the albedo is a factor on it; the path is relative to the mesh file.
    Lambert {
        albedo: [f64; 3],
        image: Option<String>,
    },
    Mirror {
        reflectance: [f64; 3],
    },
    Dielectric {
        ior: f64,
    },
    RoughDielectric {
        ior: f64,
        roughness: f64,
    },
    /// A metal known by its reflectance at normal incidence.
    Metal {
        reflectance: [f64; 3],
        roughness: f64,
    },
}

/// The triangles of one material of a mesh file, over the vertices that they use.
pub struct Part {
    /// An index into the file's materials.
    pub material: usize,
    pub mesh: TriangleMesh,
    pub triangle_lines: Vec<u32>,
}

impl MeshFile {
    /// Cuts the mesh into one part for each material, in the order of the materials.
    ///
    /// # Errors
    /// A triangle without a material.
    pub fn into_parts(self) -> Result<Vec<Part>, Problems> {
        let bare = |m: &Option<usize>| m.is_none();
        if let Some(prim) = self.triangle_materials.iter().position(bare) {
            let source = self.triangle_lines.get(prim).map_or(self.source.clone(), |&line| self.source.at_line(line));
            let problem = Problem::new("the mesh has faces without a material").at(&source);
            return Err(problem.help("give `material` to the object that uses the file").into());
        }
        let parts = (0..self.materials.len()).map(|material| self.part(material));
        Ok(parts.filter(|part| !part.mesh.triangles.is_empty()).collect())
    }

    fn part(&self, material: usize) -> Part {
        let mut part = Part { material, mesh: TriangleMesh::default(), triangle_lines: Vec::new() };
        let mut renumbered: Vec<Option<u32>> = vec![None; self.mesh.positions.len()];
        for (prim, triangle) in self.mesh.triangles.iter().enumerate() {
            if self.triangle_materials[prim] != Some(material) {
                continue;
            }
            part.triangle_lines.extend(self.triangle_lines.get(prim));
            part.mesh.triangles.push(triangle.map(|vertex| {
                let vertex = vertex as usize;
                *renumbered[vertex].get_or_insert_with(|| {
                    part.mesh.positions.push(self.mesh.positions[vertex]);
                    part.mesh.normals.extend(self.mesh.normals.get(vertex));
                    part.mesh.uvs.extend(self.mesh.uvs.get(vertex));
                    part.mesh.colours.extend(self.mesh.colours.get(vertex));
                    part.mesh.positions.len() as u32 - 1
                })
            }));
        }
        part
    }
}
