//! A primitive as a mesh: indices of any type, strips and fans cut into triangles.

use gltf::Primitive;
use gltf::mesh::Mode;

use super::accessor::{self, COLOURS, INDICES, Kinds, TEXTURE_COORDINATES, VECTORS};
use super::buffers::Buffers;
use crate::import::ignored::Ignored;
use crate::scene::mesh::TriangleMesh;

/// Bytes of meshes for a byte of buffers: what many primitives over the same bytes may take together.
const LARGEST_GROWTH: usize = 64;

/// What may still be allocated for meshes.
pub(super) struct Budget(usize);

impl Budget {
    pub fn of(buffers: &Buffers<'_>) -> Budget {
        Budget(buffers.total_bytes().saturating_mul(LARGEST_GROWTH))
    }
    fn spend(&mut self, vertices: usize, corners: usize) -> Result<(), String> {
        // Position, normal, texture coordinates and colour of a vertex; a strip has a triangle for each corner.
        let bytes = vertices.saturating_mul(44).saturating_add(corners.saturating_mul(12));
        self.0 =
            self.0.checked_sub(bytes).ok_or("the primitives together are far larger than the buffers they lie in")?;
        Ok(())
    }
}

/// Reads a primitive with the texture coordinates `uv_set`; `None` for points and lines.
pub(super) fn read(
    primitive: &Primitive<'_>,
    uv_set: Option<u32>,
    buffers: &Buffers<'_>,
    budget: &mut Budget,
    ignored: &mut Ignored,
) -> Result<Option<TriangleMesh>, String> {
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        ignored.note("points and lines");
        return Ok(None);
    }
    let positions = primitive.get(&gltf::Semantic::Positions).ok_or("it has no POSITION")?;
    let vertices = positions.count();
    let per_vertex = |semantic: gltf::Semantic, kinds: Kinds| {
        let Some(values) = primitive.get(&semantic) else { return Ok(false) };
        accessor::check(&values, buffers, kinds)?;
        match values.count() {
            n if n == vertices => Ok(true),
            n => Err(format!("it has {vertices} vertices, but {n} values of {}", semantic.to_string())),
        }
    };
    per_vertex(gltf::Semantic::Positions, VECTORS)?;
    let has_normals = per_vertex(gltf::Semantic::Normals, VECTORS)?;
    let has_colours = per_vertex(gltf::Semantic::Colors(0), COLOURS)?;
    let has_uvs = uv_set.map(|set| per_vertex(gltf::Semantic::TexCoords(set), TEXTURE_COORDINATES)).transpose()?;
    let corners = match primitive.indices() {
        Some(indices) => accessor::check(&indices, buffers, INDICES).map(|()| indices.count())?,
        None => vertices,
    };
    budget.spend(vertices, corners)?;

    let reader = primitive.reader(|buffer| buffers.of(&buffer));
    let indices: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..u32::try_from(vertices).map_err(|_| "it has too many vertices")?).collect(),
    };
    if let Some(index) = indices.iter().find(|i| **i as usize >= vertices) {
        return Err(format!("an index is {index}, but there are {vertices} vertices, counted from 0"));
    }
    let mut mesh = TriangleMesh {
        positions: reader.read_positions().into_iter().flatten().collect(),
        triangles: triangles(primitive.mode(), &indices)?,
        ..TriangleMesh::default()
    };
    if has_normals {
        let normals: Vec<[f32; 3]> = reader.read_normals().into_iter().flatten().collect();
        mesh.normals = unit(&normals).unwrap_or_else(|| {
            ignored.note("normals without length (computed instead)");
            mesh.angle_weighted_normals()
        });
    }
    if has_colours {
        let colours = reader.read_colors(0).into_iter().flat_map(|colours| colours.into_rgb_f32());
        mesh.colours = colours.map(|colour| colour.map(|c| c.clamp(0.0, 1.0))).collect();
    }
    if let Some(set) = uv_set {
        mesh.uvs = match has_uvs {
            // Rows of an image run downwards in glTF, here v runs upwards.
            Some(true) => reader.read_tex_coords(set).map(|uvs| uvs.into_f32().map(|[u, v]| [u, 1.0 - v]).collect()),
            _ => None,
        }
        .unwrap_or_else(|| {
            ignored.note(format!("textures of meshes without TEXCOORD_{set} (their first texel is taken)"));
            vec![[0.0, 1.0]; vertices]
        });
    }
    Ok(Some(mesh))
}

/// The corners of each triangle, in the order of the format's own figures.
fn triangles(mode: Mode, indices: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    let count = indices.len();
    if count < 3 || mode == Mode::Triangles && !count.is_multiple_of(3) {
        return Err(format!("{count} corners make no triangles"));
    }
    let triangle = |at: [usize; 3]| at.map(|i| indices[i]);
    Ok(match mode {
        Mode::TriangleStrip => (0..count - 2).map(|i| triangle([i, i + 1 + i % 2, i + 2 - i % 2])).collect(),
        Mode::TriangleFan => (0..count - 2).map(|i| triangle([i + 1, i + 2, 0])).collect(),
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    })
}

/// Of unit length, as rounding leaves few; `None` if one has no length.
fn unit(normals: &[[f32; 3]]) -> Option<Vec<[f32; 3]>> {
    let unit = |n: &[f32; 3]| {
        let length = n.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        (length > 0.0 && length.is_finite()).then(|| n.map(|x| (f64::from(x) / length) as f32))
    };
    normals.iter().map(unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Signed area of a triangle over vertices in the plane.
    fn area(points: &[[f64; 2]], t: [u32; 3]) -> f64 {
        let [a, b, c] = t.map(|i| points[i as usize]);
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
    }

    #[test]
    fn strips_and_fans_keep_the_winding_of_their_first_triangle() {
        let strip = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.0, 2.0]];
        let cut = triangles(Mode::TriangleStrip, &[0, 1, 2, 3, 4]).expect("a strip");
        assert_eq!(cut, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert!(cut.iter().all(|t| area(&strip, *t) == 0.5));
        let fan = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let cut = triangles(Mode::TriangleFan, &[0, 1, 2, 3]).expect("a fan");
        assert_eq!(cut, [[1, 2, 0], [2, 3, 0]]);
        assert!(cut.iter().all(|t| area(&fan, *t) == 0.5));
        assert!(triangles(Mode::Triangles, &[0, 1, 2, 0]).is_err());
        assert!(triangles(Mode::TriangleFan, &[0, 1]).is_err());
    }
}
