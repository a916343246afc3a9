//! Meshes of triangles out of what pbrt's shapes say · object space.

use std::f64::consts::TAU;

use glam::DVec3;

use super::budget::Budget;
use super::loop_subdivision::Control;
use super::parameters::Parameters;
use crate::scene::error::Problem;
use crate::scene::mesh::TriangleMesh;

/// Bytes of a vertex with its normal and texture coordinates, and of a triangle.
const VERTEX: usize = 32;
const TRIANGLE: usize = 12;
/// Cells along a side of a bent bilinear patch: the triangles are then nearer to it than 1/1024 of how far its corner is from
/// closing the parallelogram.
const PATCH_CELLS: u32 = 16;
/// Of a whole turn.
const TURN_CELLS: f64 = 128.0;
/// Relative deviation, by rounding of what is written, up to which four points are a parallelogram.
const FLAT: f64 = 1e-6;

/// `trianglemesh`.
pub(super) fn triangles(ps: &Parameters, budget: &mut Budget) -> Result<TriangleMesh, Problem> {
    let points = points(ps, "P")?.ok_or_else(|| ps.problem("the mesh has no \"point3 P\"", "give its vertices"))?;
    let triangles = indices::<3>(ps, points.len())?;
    budget.spend(points.len(), VERTEX, &ps.source)?;
    budget.spend(triangles.len(), TRIANGLE, &ps.source)?;
    let mut mesh = TriangleMesh { positions: single(points), triangles, ..TriangleMesh::default() };
    if let Some(normals) = per_vertex::<3>(ps, "N", &["normal"], points.len())? {
        mesh.normals = units(normals, ps)?;
    }
    if let Some(uvs) = per_vertex::<2>(ps, "uv", &["point2"], points.len())? {
        mesh.uvs = uvs.iter().map(|uv| uv.map(|c| c as f32)).collect();
    }
    // How tangents lie, and what Ptex would ask for.
    ps.ignore(&["S", "faceIndices"]);
    face_normals(&mut mesh);
    Ok(mesh)
}

/// `bilinearmesh`: patches over four corners p00, p10, p01, p11, cut into triangles.
pub(super) fn bilinear(ps: &Parameters, budget: &mut Budget) -> Result<TriangleMesh, Problem> {
    let points = points(ps, "P")?.ok_or_else(|| ps.problem("the mesh has no \"point3 P\"", "give its vertices"))?;
    let patches = indices::<4>(ps, points.len())?;
    let given = per_vertex::<3>(ps, "N", &["normal"], points.len())?.map(|n| units(n, ps)).transpose()?;
    let uvs = per_vertex::<2>(ps, "uv", &["point2"], points.len())?;
    ps.ignore(&["faceIndices"]);
    if ps.has("emissionfilename") {
        return Err(ps.cannot("an image of emission cannot be rendered", "give the light a constant \"rgb L\""));
    }
    let point = |i: u32| DVec3::from_array(points[i as usize]);
    let is_bent = |patch: &[u32; 4]| {
        let [a, b, c, d] = patch.map(point);
        (a - b - c + d).length() > FLAT * ((b - a).length() + (c - a).length())
    };
    let all_flat = !patches.iter().any(is_bent);
    let mut mesh = TriangleMesh::default();
    for patch in &patches {
        let corners = patch.map(point);
        let cells = if is_bent(patch) { PATCH_CELLS } else { 1 };
        let own_uvs = uvs.map(|uvs| patch.map(|i| uvs[i as usize]));
        let own_normals = given.as_ref().map(|n| patch.map(|i| DVec3::from_array(n[i as usize].map(f64::from))));
        let at = |u: f64, v: f64| {
            let p = mix(u, v, corners);
            let [a, b, c, d] = corners;
            let smooth = (b - a).lerp(d - c, v).cross((c - a).lerp(d - b, u));
            let normal = own_normals.map_or(smooth, |n| mix(u, v, n));
            let [s, t] = own_uvs.map_or([u, v], |uvs| {
                let uv = mix(u, v, uvs.map(|[s, t]| DVec3::new(s, t, 0.0)));
                [uv.x, uv.y]
            });
            Node { p, normal, uv: [s, t] }
        };
        add_grid(&mut mesh, [cells; 2], at, budget, ps)?;
    }
    // Flat patches need no normals.
    if all_flat && given.is_none() {
        mesh.normals.clear();
    }
    face_normals(&mut mesh);
    Ok(mesh)
}

fn mix(u: f64, v: f64, [p00, p10, p01, p11]: [DVec3; 4]) -> DVec3 {
    p00.lerp(p10, u).lerp(p01.lerp(p11, u), v)
}

/// `loopsubdiv`: refined `levels` times, then taken to the limit.
pub(super) fn subdivided(ps: &Parameters, budget: &mut Budget) -> Result<TriangleMesh, Problem> {
    let points = points(ps, "P")?.ok_or_else(|| ps.problem("the mesh has no \"point3 P\"", "give its vertices"))?;
    let triangles = indices::<3>(ps, points.len())?;
    let levels = ps.integer("levels", 0..=10, 3)?;
    ps.ignore(&["scheme"]);
    // While it is refined a triangle takes several times its final size.
    let growth = 4usize.pow(levels as u32);
    budget.spend(triangles.len().saturating_mul(growth), 2 * (VERTEX + TRIANGLE), &ps.source)?;
    budget.spend(points.len(), 2 * VERTEX, &ps.source)?;
    let mut control = Control { points: points.iter().map(|p| DVec3::from_array(*p)).collect(), triangles };
    let refuse = |what: &str| ps.problem(format!("the mesh {what}"), "mend it, or use a trianglemesh");
    control.check().map_err(refuse)?;
    for _ in 0..levels {
        control = control.refined().ok_or_else(|| refuse("touches itself at a vertex"))?;
    }
    let limit = control.limit().ok_or_else(|| refuse("touches itself at a vertex"))?;
    let vectors = |all: &[DVec3]| all.iter().map(|p| p.to_array().map(|c| c as f32)).collect();
    Ok(TriangleMesh {
        positions: vectors(&limit.points),
        normals: vectors(&limit.normals),
        triangles: control.triangles,
        ..TriangleMesh::default()
    })
}

/// A point of a patch.
struct Node {
    p: DVec3,
    /// Of any length.
    normal: DVec3,
    uv: [f64; 2],
}

/// Part of a sphere, cylinder or disk: `at(cosine and sine of φ, v)` over `turn` radians of φ, cut finely enough to be smooth.
pub(super) fn round(
    turn: f64,
    rows: u32,
    at: impl Fn([f64; 2], f64) -> (DVec3, DVec3),
    budget: &mut Budget,
    ps: &Parameters,
) -> Result<TriangleMesh, Problem> {
    let mut mesh = TriangleMesh::default();
    let columns = (TURN_CELLS * turn / TAU).ceil().max(3.0) as u32;
    let node = |u: f64, v| {
        // After a whole turn the first vertices come again, to the last bit.
        let angle = if u == 1.0 && turn == TAU { 0.0 } else { u * turn };
        let (p, normal) = at([angle.cos(), angle.sin()], v);
        Node { p, normal, uv: [u, v] }
    };
    add_grid(&mut mesh, [columns, rows], node, budget, ps)?;
    Ok(mesh)
}

/// Two triangles a cell, which face u × v.
fn add_grid(
    mesh: &mut TriangleMesh,
    [columns, rows]: [u32; 2],
    at: impl Fn(f64, f64) -> Node,
    budget: &mut Budget,
    ps: &Parameters,
) -> Result<(), Problem> {
    budget.spend(((columns + 1) * (rows + 1)) as usize, VERTEX, &ps.source)?;
    budget.spend((2 * columns * rows) as usize, TRIANGLE, &ps.source)?;
    let first = u32::try_from(mesh.positions.len()).ok().filter(|n| *n < u32::MAX / 2);
    let first = first.ok_or_else(|| ps.problem("the mesh has too many vertices", "split it"))?;
    for j in 0..=rows {
        for i in 0..=columns {
            let node = at(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            mesh.positions.push(node.p.to_array().map(|c| c as f32));
            mesh.normals.push(node.normal.normalize_or(DVec3::Z).to_array().map(|c| c as f32));
            mesh.uvs.push(node.uv.map(|c| c as f32));
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let corner = first + j * (columns + 1) + i;
            let (right, above, across) = (corner + 1, corner + columns + 1, corner + columns + 2);
            // At a pole two corners are one.
            let differ = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                a != b && b != c && c != a
            };
            let cell = [[corner, right, across], [corner, across, above]];
            mesh.triangles.extend(cell.into_iter().filter(differ));
        }
    }
    Ok(())
}

fn points<'p>(ps: &'p Parameters, name: &str) -> Result<Option<&'p [[f64; 3]]>, Problem> {
    ps.tuples::<3>(name, &["point3"])
}

/// Groups of `N` indices; a mesh of just so many vertices goes without.
fn indices<const N: usize>(ps: &Parameters, vertices: usize) -> Result<Vec<[u32; N]>, Problem> {
    let Some(parameter) = ps.find("indices") else {
        if vertices == N {
            return Ok(vec![std::array::from_fn(|i| i as u32)]);
        }
        return Err(ps.problem(format!("the mesh has {vertices} vertices and no \"integer indices\""), "give them"));
    };
    let groups = parameter.tuples::<N>(&["integer"])?;
    let sound = |index: &f64| index.fract() == 0.0 && (0.0..vertices as f64).contains(index);
    if let Some(index) = groups.as_flattened().iter().find(|index| !sound(index)) {
        let message = format!("`indices` has {index}, but there are {vertices} vertices");
        return Err(parameter.problem(message, "vertices count from 0"));
    }
    if groups.is_empty() {
        return Err(parameter.problem("`indices` is empty", "give at least one face"));
    }
    Ok(groups.iter().map(|group| group.map(|index| index as u32)).collect())
}

fn per_vertex<'p, const N: usize>(
    ps: &'p Parameters,
    name: &str,
    kinds: &[&str],
    vertices: usize,
) -> Result<Option<&'p [[f64; N]]>, Problem> {
    let Some(parameter) = ps.find(name) else { return Ok(None) };
    let values = parameter.tuples::<N>(kinds)?;
    if values.len() != vertices {
        let message = format!("there are {vertices} vertices and {} values of `{name}`", values.len());
        return Err(parameter.problem(message, "give one for each vertex"));
    }
    Ok(Some(values))
}

fn single(points: &[[f64; 3]]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.map(|c| c as f32)).collect()
}

fn units(normals: &[[f64; 3]], ps: &Parameters) -> Result<Vec<[f32; 3]>, Problem> {
    let unit = |(i, n): (usize, &[f64; 3])| match DVec3::from_array(*n).try_normalize() {
        Some(unit) => Ok(unit.to_array().map(|c| c as f32)),
        None => Err(ps.problem(format!("normal {i} has no length"), "normals must point somewhere, or be left out")),
    };
    normals.iter().enumerate().map(unit).collect()
}

/// Turns triangles to the side of their normals, as pbrt does.
pub(super) fn face_normals(mesh: &mut TriangleMesh) {
    if mesh.normals.is_empty() {
        return;
    }
    for triangle in &mut mesh.triangles {
        let [a, b, c] = triangle.map(|i| DVec3::from_array(mesh.positions[i as usize].map(f64::from)));
        let side = triangle.map(|i| DVec3::from_array(mesh.normals[i as usize].map(f64::from))).iter().sum::<DVec3>();
        if (b - a).cross(c - a).dot(side) < 0.0 {
            triangle.swap(1, 2);
        }
    }
}

/// Turns the outside of a mesh inwards.
pub(super) fn reverse(mesh: &mut TriangleMesh) {
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh.normals.iter_mut().for_each(|normal| *normal = normal.map(|c| -c));
}

/// pbrt's texture coordinates of triangles without any: (0, 0), (1, 0), (1, 1).
pub(super) fn with_texture_coordinates(mesh: &TriangleMesh) -> TriangleMesh {
    let corners = || mesh.triangles.as_flattened().iter().map(|i| *i as usize);
    let each = |values: &[[f32; 3]]| {
        if values.is_empty() { Vec::new() } else { corners().map(|i| values[i]).collect() }
    };
    let count = mesh.triangles.len();
    TriangleMesh {
        deformation: None,
        positions: each(&mesh.positions),
        normals: each(&mesh.normals),
        colours: each(&mesh.colours),
        uvs: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]].repeat(count),
        triangles: (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    }
}

/// Bytes that [`with_texture_coordinates`] takes.
pub(super) fn size_with_texture_coordinates(mesh: &TriangleMesh) -> usize {
    mesh.triangles.len().saturating_mul(3 * VERTEX + TRIANGLE)
}

/// The one area that all triangles have after `to_world`, if they have.
pub(super) fn common_area(mesh: &TriangleMesh, to_world: &glam::DMat4) -> Option<f64> {
    const SAME: f64 = 1e-4;
    let area = |triangle: &[u32; 3]| {
        let corner = |i: u32| to_world.transform_point3(DVec3::from_array(mesh.positions[i as usize].map(f64::from)));
        let [a, b, c] = triangle.map(corner);
        0.5 * (b - a).cross(c - a).length()
    };
    let first = mesh.triangles.first().map(area).filter(|a| *a > 0.0)?;
    mesh.triangles.iter().all(|t| (area(t) - first).abs() <= SAME * first).then_some(first)
}

/// Whether a mesh's numbers came out as single precision can hold them.
pub(super) fn check_finite(mesh: &TriangleMesh, ps: &Parameters) -> Result<(), Problem> {
    let finite = mesh.positions.as_flattened().iter().chain(mesh.uvs.as_flattened()).all(|c| c.is_finite());
    if finite { Ok(()) } else { Err(ps.problem("the shape has a number above 3e38", "is an exponent wrong?")) }
}
