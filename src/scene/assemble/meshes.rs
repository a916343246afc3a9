//! Meshes: finite vertices, indices in range, triangles with an area, and what their edges say about the solid.

use std::sync::Arc;

use rayon::prelude::*;

use super::Report;
use crate::math::Point3;
use crate::scene::camera::Shutter;
use crate::scene::deformation::MAX_STEPS;
use crate::scene::description::MeshDescription;
use crate::scene::error::Problem;
use crate::scene::mesh::TriangleMesh;

/// Twice a triangle's area over its longest edge squared, below which no ray can be sure to hit it.
const DEGENERATE: f64 = 1e-12;

/// Triangles and vertices that ids of 32 bits can count.
const MAX_ELEMENTS: usize = u32::MAX as usize - 1;

/// Drops triangles without area, with a warning; `false` after reporting what cannot be mended.
pub(super) fn make_sound(described: &mut MeshDescription, shutter: Shutter, report: &mut Report) -> bool {
    is_sound(described, report) && at_shutter(described, shutter, report) && drop_degenerate(described, report)
}

/// Leaves of the mesh's shapes what the shutter sees; `false` after reporting that this is too much.
fn at_shutter(described: &mut MeshDescription, shutter: Shutter, report: &mut Report) -> bool {
    let Some(deformation) = described.mesh.deformation.take() else { return true };
    if !shutter.is_instant() && deformation.step_count(shutter) > MAX_STEPS as f64 {
        let message = format!(
            "the shutter is open for {:.0} frames of the mesh, at most {MAX_STEPS} can be held",
            deformation.step_count(shutter)
        );
        report.problem(Problem::new(message).help("open the shutter for less time").at(&described.source));
        return false;
    }
    let middle = deformation.at(shutter.middle());
    (described.mesh.positions, described.mesh.normals) = (middle.positions, middle.normals);
    described.mesh.deformation = deformation.seen(shutter).map(Arc::new);
    true
}

fn is_sound(described: &MeshDescription, report: &mut Report) -> bool {
    let source = described.source.clone();
    let before = report.problems.len();
    let mut refuse = |message: String, help: &str| report.problem(Problem::new(message).help(help).at(&source));
    let TriangleMesh { positions, normals, uvs, colours, triangles, deformation } = &described.mesh;
    let vertices = positions.len();
    if triangles.is_empty() {
        refuse("the mesh has no triangle".to_owned(), "is the file empty, or all points and lines?");
    }
    if vertices.max(triangles.len()) > MAX_ELEMENTS {
        refuse(format!("the mesh has {} triangles over {vertices} vertices", triangles.len()), "split it");
    }
    let per_vertex = |n: usize| n == 0 || n == vertices;
    if !per_vertex(normals.len()) || !per_vertex(uvs.len()) || !per_vertex(colours.len()) {
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
    if let Some(i) = colours.iter().position(|colour| !colour.iter().all(|c| (0.0..=1.0).contains(c))) {
        refuse(format!("the colour of vertex {i} is {:?}", colours[i]), "its components must be from 0 to 1");
    }
    for (i, frame) in deformation.iter().flat_map(|deformation| &deformation.frames).enumerate() {
        let finite = frame.positions.iter().flatten().all(|x| x.is_finite());
        if !finite || !frame.normals.iter().all(|n| is_unit(*n)) {
            refuse(
                format!("frame {i} of the mesh has a vertex that is not finite, or a normal not of unit length"),
                "",
            );
        }
    }
    let out_of_range = |t: &[u32; 3]| t.iter().any(|&i| i as usize >= vertices);
    if let Some(prim) = triangles.iter().position(out_of_range) {
        let message = format!("triangle {prim} names the vertices {:?} of {vertices}", triangles[prim]);
        report.problem(Problem::new(message).help("vertices count from 0").at(&described.triangle_source(prim)));
    }
    report.problems.len() == before
}

fn is_unit(n: [f32; 3]) -> bool {
    let length_squared: f32 = n.iter().map(|x| x * x).sum();
    (length_squared - 1.0).abs() < 1e-3
}

fn drop_degenerate(described: &mut MeshDescription, report: &mut Report) -> bool {
    let mesh = &described.mesh;
    let degenerate: Vec<bool> = (0..mesh.triangles.len() as u32)
        .map(|prim| mesh.deformation.is_none() && is_degenerate(mesh.corners(prim)))
        .collect();
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

/// A side of a triangle, from the lower to the higher vertex. In order of these, the sides of an edge stand together and its
/// first triangle first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    edge: (u32, u32),
    prim: u32,
    /// Whether the triangle runs along it this way.
    along: bool,
}

impl Topology {
    pub fn of(mesh: &TriangleMesh) -> Topology {
        let mut sides = sides(mesh);
        // Sorted and not hashed: a hash table of millions misses the cache.
        sides.par_sort_unstable();
        let mut topology = Topology { open_edges: None, crowded_edges: None, flipped_edges: None };
        for edge in sides.chunk_by(|a, b| a.edge == b.edge) {
            let kind = match edge {
                [_] => &mut topology.open_edges,
                [a, b] if a.along == b.along => &mut topology.flipped_edges,
                [_, _] => continue,
                _ => &mut topology.crowded_edges,
            };
            let prim = edge[0].prim as usize;
            let (count, first) = kind.get_or_insert((0, prim));
            (*count, *first) = (*count + 1, prim.min(*first));
        }
        topology
    }
    pub fn is_closed(&self) -> bool {
        self.open_edges.is_none() && self.crowded_edges.is_none() && self.flipped_edges.is_none()
    }
}

fn sides(mesh: &TriangleMesh) -> Vec<Side> {
    let welded = mesh.welded_vertices();
    let of = |prim: usize| {
        let [a, b, c] = mesh.triangles[prim].map(|i| welded[i as usize]);
        [(a, b), (b, c), (c, a)].map(|(a, b)| Side { edge: (a.min(b), a.max(b)), prim: prim as u32, along: a < b })
    };
    (0..mesh.triangles.len()).flat_map(of).collect()
}
