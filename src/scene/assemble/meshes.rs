//! Meshes: finite vertices, indices in range, triangles with an area, and what their edges say about the solid.

use std::collections::HashMap;

use super::Report;
use crate::math::Point3;
use crate::scene::description::MeshDescription;
use crate::scene::error::Problem;
use crate::scene::mesh::TriangleMesh;

/// Twice a triangle's area over its longest edge squared, below which no ray can be sure to hit it.
const DEGENERATE: f64 = 1e-12;

/// Triangles and vertices that ids of 32 bits can count.
const MAX_ELEMENTS: usize = u32::MAX as usize - 1;

/// Drops triangles without area, with a warning; `false` after reporting what cannot be mended.
pub(super) fn make_sound(described: &mut MeshDescription, report: &mut Report) -> bool {
    let source = described.source.clone();
    let before = report.problems.len();
    let mut refuse = |message: String, help: &str| report.problem(Problem::new(message).help(help).at(&source));
    let TriangleMesh { positions, normals, uvs, triangles } = &described.mesh;
    let vertices = positions.len();
    if triangles.is_empty() {
        refuse("the mesh has no triangle".to_owned(), "is the file empty, or all points and lines?");
    }
    if vertices.max(triangles.len()) > MAX_ELEMENTS {
        refuse(format!("the mesh has {} triangles over {vertices} vertices", triangles.len()), "split it");
    }
    let per_vertex = |n: usize| n == 0 || n == vertices;
    if !per_vertex(normals.len()) || !per_vertex(uvs.len()) {
        let counts = format!("{vertices} vertices, {} normals, {} texture coordinates", normals.len(), uvs.len());
        refuse(format!("the mesh has {counts}"), "there must be none, or one a vertex");
    }
    if let Some(i) = positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        refuse(format!("vertex {i} is {:?}", positions[i]), "coordinates must be finite");
    }
    if let Some(i) = normals.iter().position(|n| !is_unit(*n)) {
        refuse(format!("normal {i} is {:?}", normals[i]), "normals must be of unit length");
    }
    if let Some(i) = uvs.iter().position(|uv| !uv.iter().all(|x| x.is_finite())) {
        refuse(format!("texture coordinate {i} is {:?}", uvs[i]), "it must be finite");
    }
    let out_of_range = |t: &[u32; 3]| t.iter().any(|&i| i as usize >= vertices);
    if let Some(prim) = triangles.iter().position(out_of_range) {
        let message = format!("triangle {prim} names the vertices {:?} of {vertices}", triangles[prim]);
        report.problem(Problem::new(message).help("vertices count from 0").at(&described.triangle_source(prim)));
    }
    report.problems.len() == before && drop_degenerate(described, report)
}

fn is_unit(n: [f32; 3]) -> bool {
    let length_squared: f32 = n.iter().map(|x| x * x).sum();
    (length_squared - 1.0).abs() < 1e-3
}

fn drop_degenerate(described: &mut MeshDescription, report: &mut Report) -> bool {
    let mesh = &described.mesh;
    let degenerate: Vec<bool> =
        (0..mesh.triangles.len() as u32).map(|prim| is_degenerate(mesh.corners(prim))).collect();
    let count = degenerate.iter().filter(|d| **d).count();
    let Some(first) = degenerate.iter().position(|d| *d) else { return true };
    let at = described.triangle_source(first);
    if count == degenerate.len() {
        let message = format!("the mesh has no area: all of its {count} triangles are degenerate");
        let help = "their corners coincide or lie on a line";
        report.problem(Problem::new(message).help(help).at(&at));
        return false;
    }
    let (subject, verb) = if count == 1 { ("triangle", "is") } else { ("triangles", "are") };
    let message = format!("{count} degenerate {subject} without area {verb} left out, the first is triangle {first}");
    report.warning(Problem::new(message).help("their corners coincide or lie on a line").at(&at));
    let mut keep = degenerate.iter().map(|d| !d);
    described.mesh.triangles.retain(|_| keep.next().unwrap_or(true));
    let mut keep = degenerate.iter().map(|d| !d);
    described.triangle_lines.retain(|_| keep.next().unwrap_or(true));
    true
}

fn is_degenerate([a, b, c]: [Point3; 3]) -> bool {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    let doubled_area = (b - a).cross(c - a).length();
    doubled_area <= DEGENERATE * longest
}

/// How the triangles of a mesh meet, vertices at the same place counted as one.
///
/// Each irregularity is (how many edges, a triangle at one of them).
pub(super) struct Topology {
    pub open_edges: Option<(usize, usize)>,
    pub crowded_edges: Option<(usize, usize)>,
    /// Two triangles run along the edge in the same direction.
    pub flipped_edges: Option<(usize, usize)>,
}

/// Triangles along an edge in the direction of its key and against it, and the first of them.
struct Edge {
    along: u32,
    against: u32,
    first: usize,
}

impl Topology {
    pub fn of(mesh: &TriangleMesh) -> Topology {
        let welded = mesh.welded_vertices();
        let mut edges: HashMap<(u32, u32), Edge> = HashMap::with_capacity(mesh.triangles.len() * 3 / 2);
        for (prim, triangle) in mesh.triangles.iter().enumerate() {
            let corners = triangle.map(|i| welded[i as usize]);
            for (a, b) in [(corners[0], corners[1]), (corners[1], corners[2]), (corners[2], corners[0])] {
                let edge = edges.entry((a.min(b), a.max(b))).or_insert(Edge { along: 0, against: 0, first: prim });
                *(if a < b { &mut edge.along } else { &mut edge.against }) += 1;
            }
        }
        let find = |irregular: fn(&Edge) -> bool| {
            let matching = || edges.values().filter(|e| irregular(e));
            matching().map(|e| e.first).min().map(|first| (matching().count(), first))
        };
        Topology {
            open_edges: find(|e| e.along + e.against == 1),
            crowded_edges: find(|e| e.along + e.against > 2),
            flipped_edges: find(|e| e.along + e.against == 2 && e.along != 1),
        }
    }
    pub fn is_closed(&self) -> bool {
        self.open_edges.is_none() && self.crowded_edges.is_none() && self.flipped_edges.is_none()
    }
}
