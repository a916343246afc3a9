//! The surface about a hit with a triangle · world frame, metres · interpolated (Phong) normals with their full
//! derivative `[Igehy99]`; the flat normal carries rays, the interpolated one turns them.

use super::interaction::{Found, reach, to_object, to_world_normal};
use crate::backend::RawHit;
use crate::differential::{ShapeOperator, SurfaceMotion};
use crate::math::{Normal3, Point3, Ray, Transform, Vec2, Vec3};
use crate::radiometry::Spectrum;
use crate::scene::{Deformation, TriangleMesh};
use crate::shape::Parametrisation;

/// How far outside the triangle a recomputed hit may lie, in barycentric units. The f32 rounding that a ray library is
/// allowed explains this much on triangles some tens of roundings wide; beyond it the ray runs within rounding of the
/// plane and where it crosses it means nothing.
const OUTSIDE: f64 = 0.1;

/// A triangle in its own space, with the plane gradients of its barycentric coordinates l1 and l2.
struct Plane {
    corner: Point3,
    edges: [Vec3; 2],
    /// e1 × e2.
    cross: Vec3,
    gradients: [Vec3; 2],
}

impl Plane {
    fn new([a, b, c]: [Point3; 3]) -> Plane {
        let (e1, e2) = (b - a, c - a);
        let cross = e1.cross(e2);
        let squared = cross.length_squared();
        Plane { corner: a, edges: [e1, e2], cross, gradients: [e2.cross(cross) / squared, cross.cross(e1) / squared] }
    }

    /// t and (l1, l2) where the ray crosses the plane, if that is on the triangle.
    fn cross_with(&self, ray: &Ray) -> Option<(f64, [f64; 2])> {
        let t = self.cross.dot(self.corner - ray.origin) / self.cross.dot(ray.direction);
        let from_corner = ray.at(t) - self.corner;
        let l = self.gradients.map(|g| g.dot(from_corner));
        // Written so that a NaN is refused.
        (t.is_finite() && l[0] >= -OUTSIDE && l[1] >= -OUTSIDE && l[0] + l[1] <= 1.0 + OUTSIDE).then_some((t, l))
    }
}

/// Where a mesh's corners are at a time.
fn corners_at(mesh: &TriangleMesh, primitive: u32, time: f64) -> [Point3; 3] {
    match &mesh.deformation {
        None => mesh.corners(primitive),
        Some(deformation) => deformation.between(time).positions(mesh.triangles[primitive as usize]),
    }
}

/// The corners' normals at a time, if the mesh has normals.
fn normals_at(mesh: &TriangleMesh, primitive: u32, time: f64) -> Option<[Vec3; 3]> {
    if mesh.normals.is_empty() {
        return None;
    }
    let corners = mesh.triangles[primitive as usize];
    Some(match &mesh.deformation {
        None => corners.map(|i| Point3::from_f32(mesh.normals[i as usize]).to_vec()),
        Some(deformation) => deformation.between(time).normals(corners),
    })
}

/// How a mesh that changes its shape moves about a point of one of its triangles, in its own space: the velocity of the
/// point, and the turn ω = N × dN/dt of the normal that light meets there, the interpolated one if there is one.
///
/// With v = Σ lᵢ vᵢ; N = n/|n| and n = Σ lᵢ nᵢ, or n = e₁ × e₂, so that n' = e₁' × e₂ + e₁ × e₂'.
pub(super) fn deforming(
    deformation: &Deformation,
    mesh: &TriangleMesh,
    primitive: u32,
    [l1, l2]: [f64; 2],
    time: f64,
) -> (Vec3, Turning) {
    let corners = mesh.triangles[primitive as usize];
    let between = deformation.between(time);
    let blend = |[a, b, c]: [Vec3; 3]| a + (b - a) * l1 + (c - a) * l2;
    let velocities = between.velocities(corners);
    let (n, change) = if mesh.normals.is_empty() {
        let [a, b, c] = between.positions(corners);
        let (e1, e2) = (b - a, c - a);
        let [d1, d2] = [velocities[1] - velocities[0], velocities[2] - velocities[0]];
        (e1.cross(e2), d1.cross(e2) + e1.cross(d2))
    } else {
        (blend(between.normals(corners)), blend(between.turning(corners)))
    };
    (blend(velocities), Turning { n, change })
}

/// A normal of any length and its change per second.
pub(super) struct Turning {
    n: Vec3,
    change: Vec3,
}

impl Turning {
    /// In the world, where both are carried by M⁻ᵀ: as the gradient of a body that turns likewise, \[N × dN/dt\]×. Zero
    /// where there is no normal.
    pub fn gradient(&self, to_world: &Transform) -> glam::DMat3 {
        let [n, change] = [self.n, self.change].map(|v| to_world.normal_unnormalised(v));
        let omega = n.cross(change) / n.length_squared();
        if !omega.is_finite() {
            return glam::DMat3::ZERO;
        }
        SurfaceMotion::rigid(Vec3::ZERO, omega).gradient
    }
}

/// The affine map of a triangle that changes its shape from where it is at `time` to where it rests, in the mesh's own
/// space; along the normal lengths stay. `None` where the triangle has no area.
pub(super) fn to_rest(deformation: &Deformation, mesh: &TriangleMesh, primitive: u32, time: f64) -> Option<Transform> {
    let frame = |[a, b, c]: [Point3; 3]| {
        let (e1, e2) = (b - a, c - a);
        Transform::new([e1, e2, e1.cross(e2).normalize_or_zero()], a.to_vec())
    };
    let there = frame(deformation.between(time).positions(mesh.triangles[primitive as usize]))?;
    Some(frame(mesh.corners(primitive))?.compose(&there.inverse()))
}

/// The backend's (u, v), pulled into the triangle.
fn clamped([u, v]: [f64; 2]) -> [f64; 2] {
    if !(u.is_finite() && v.is_finite()) {
        return [1.0 / 3.0; 2];
    }
    let u = u.clamp(0.0, 1.0);
    [u, v.clamp(0.0, 1.0 - u)]
}

pub(super) fn find(mesh: &TriangleMesh, to_world: &Transform, ray: &Ray, hit: &RawHit) -> Found {
    let corners = corners_at(mesh, hit.primitive, ray.time);
    let plane = Plane::new(corners);
    let crossing = plane.cross_with(&to_object(to_world, ray));
    let (t, l) = crossing.unwrap_or_else(|| (hit.t, clamped(hit.uv)));
    let [e1, e2] = plane.edges;
    let ng = Normal3::new(to_world.normal_unnormalised(plane.cross)).unwrap_or(Normal3::from_unit(-ray.direction));
    let normals = normals_at(mesh, hit.primitive, ray.time);
    let (ns, shape) = shading_normal(normals, &plane, l, to_world, ng);
    Found {
        p: to_world.point(plane.corner + e1 * l[0] + e2 * l[1]),
        t,
        ng,
        ns,
        shape,
        barycentric: l,
        extent: corners.into_iter().map(|p| reach(to_world, p)).fold(0.0, f64::max),
        exact: crossing.is_some(),
    }
}

/// The interpolated normal and its derivative, on the side of `ng`; the flat one where there is none.
fn shading_normal(
    normals: Option<[Vec3; 3]>,
    plane: &Plane,
    l: [f64; 2],
    to_world: &Transform,
    ng: Normal3,
) -> (Normal3, ShapeOperator) {
    let flat = (ng, ShapeOperator::FLAT);
    let Some([n0, n1, n2]) = normals else { return flat };
    let (d1, d2) = (n1 - n0, n2 - n0);
    let n = n0 + d1 * l[0] + d2 * l[1];
    // dn/dx = (N1 − N0) ∇l1ᵀ + (N2 − N0) ∇l2ᵀ.
    let [g1, g2] = plane.gradients;
    let dn = glam::DMat3::from_cols(d1 * g1.x + d2 * g2.x, d1 * g1.y + d2 * g2.y, d1 * g1.z + d2 * g2.z);
    match to_world_normal(to_world, n, dn) {
        None => flat,
        Some((ns, shape)) if ns.dot(ng) < 0.0 => (-ns, shape.flipped()),
        Some(found) => found,
    }
}

/// The colour that the vertices have been given, interpolated.
pub(super) fn colour(mesh: &TriangleMesh, primitive: u32, [l1, l2]: [f64; 2]) -> Option<Spectrum> {
    if mesh.colours.is_empty() {
        return None;
    }
    let corners = mesh.triangles[primitive as usize].map(|i| mesh.colours[i as usize].map(f64::from));
    let [a, b, c] = corners.map(Spectrum::from);
    // A hit that was found again may lie a little outside.
    Some((a + (b - a) * l1 + (c - a) * l2).map(|x| x.clamp(0.0, 1.0)))
}

/// Texture coordinates and their tangents in object space where the barycentric weights are `l`; a mesh without texture
/// coordinates is parametrised by the weights themselves.
pub(super) fn parametrisation(mesh: &TriangleMesh, primitive: u32, l: [f64; 2], time: f64) -> Parametrisation {
    let [a, b, c] = corners_at(mesh, primitive, time);
    let (e1, e2) = (b - a, c - a);
    if mesh.uvs.is_empty() {
        return Parametrisation { uv: Vec2::from_array(l), dpdu: e1, dpdv: e2 };
    }
    let corners = mesh.triangles[primitive as usize];
    let [a, b, c] = corners.map(|i| Vec2::new(mesh.uvs[i as usize][0].into(), mesh.uvs[i as usize][1].into()));
    let (d1, d2) = (b - a, c - a);
    // [∂p/∂u ∂p/∂v] = [e1 e2] [d1 d2]⁻¹; parallel d1, d2 give infinities, which the caller replaces.
    let determinant = d1.perp_dot(d2);
    let dpdu = (e1 * d2.y - e2 * d1.y) / determinant;
    let dpdv = (e2 * d1.x - e1 * d2.x) / determinant;
    Parametrisation { uv: a + d1 * l[0] + d2 * l[1], dpdu, dpdv }
}
