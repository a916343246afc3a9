//! What f64 says of one reported hit, and how far an f32 backend may be from it. World frame, metres.
//!
//! With u = 2⁻²⁴, |·| lengths and d the ray's direction, an f32 backend places the ray relative to a triangle with an
//! error across the ray of at most
//!
//! ε = 32 u (|o| + |p|max)                                                                                  (a)
//!
//! since rounding the origin and each corner's difference to it gives 2 u of these lengths, the direction over the way
//! to the triangle 1, and an edge function — an edge (1) crossed (3) with the sum of two corners (1), multiplied by d
//! (3), over the edge's length — 8 on twice the distance, 19 together. The report says how much of the bounds was used.
//!
//! An instance's ray goes through an f32 inverse. With ω = |m0||m1||m2| / |det M| (1 for rotations and scales) each
//! row of the inverse errs by u ω relatively, which puts the ray off by 64 u ω² (|o| + |p|max + |shift|) in the world;
//! then (a) holds in object space and is carried out by ‖M‖.
//!
//! Along the ray the hit moves by ε q / cos θ and its barycentrics by ε q / (h cos θ), where θ is the angle of
//! incidence, h the triangle's smallest height and q ≥ 1 the loss of its normal in the cross product of two edges,
//! |e1||e2| / |e1 × e2|.

use crate::backend::RawHit;
use crate::backend::geometry::{Geometry, Item, PlacedShape, Triangles, to_object};
use crate::math::{Frame, Point3, Ray, Transform, Vec3};

/// Unit roundoff of f32.
const U: f64 = 1.0 / 16_777_216.0;

/// A hit seen in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Where the ray crosses the primitive's plane, or meets the shape.
    t: f64,
    /// How far from the outline the ray passes, metres across the ray, and whether inside.
    outline: f64,
    inside: bool,
    /// ε above.
    rounding: f64,
    /// Bound of |t − t(f64)|, in units of the direction; infinite where the ray lies in the plane.
    pub t_bound: f64,
    /// Bound of the barycentrics' difference.
    pub uv_bound: f64,
}

impl Verdict {
    /// Whether a backend may report this hit.
    pub fn confirms(&self, hit: &RawHit) -> bool {
        (self.inside || self.is_marginal()) && (self.t_bound == f64::INFINITY || (hit.t - self.t).abs() <= self.t_bound)
    }
    /// Whether rounding alone decides if the triangle is hit.
    pub fn is_marginal(&self) -> bool {
        self.outline <= self.rounding
    }
    fn nowhere() -> Verdict {
        Verdict { t: f64::NAN, outline: f64::INFINITY, inside: false, rounding: 0.0, t_bound: 0.0, uv_bound: 0.0 }
    }
}

/// What f64 says of the primitive that `hit` names. A primitive that does not exist is confirmed by nothing.
pub fn verdict(geometry: &Geometry, ray: &Ray, hit: &RawHit) -> Verdict {
    match geometry.items.get(hit.object.index()) {
        Some(Item::Mesh(mesh)) => of_mesh(mesh, &Transform::IDENTITY, ray, hit.primitive),
        Some(Item::Instance { mesh, to_world }) => of_mesh(&geometry.shared[*mesh], to_world, ray, hit.primitive),
        Some(Item::MovingMesh { mesh, motion }) => {
            of_mesh(&geometry.shared[*mesh], &motion.at(ray.time), ray, hit.primitive)
        }
        Some(Item::Shape(placed)) if hit.primitive == 0 => of_shape(placed, ray),
        Some(Item::Shape(_)) | None => Verdict::nowhere(),
    }
}

fn of_shape(placed: &PlacedShape, ray: &Ray) -> Verdict {
    placed.intersect(ray).map_or(Verdict::nowhere(), |t| Verdict { t, inside: true, ..Verdict::nowhere() })
}

fn of_mesh(mesh: &Triangles, to_world: &Transform, ray: &Ray, primitive: u32) -> Verdict {
    if primitive as usize >= mesh.triangles.len() {
        return Verdict::nowhere();
    }
    let own = mesh.corners(primitive, ray.time);
    let corners = own.map(|p| to_world.point(p));
    let mut rounding = 32.0 * U * size(ray.origin, &corners);
    if let Some(deformation) = &mesh.deformation {
        // A time is rounded as a part of the whole course, and vertices are blended from the products of two.
        let course = (deformation.end() - deformation.start) * deformation.interval.recip();
        let steps = deformation.between(ray.time).velocities(mesh.triangles[primitive as usize]);
        let longest = steps.map(|v| to_world.vector(v).length() * deformation.interval).into_iter().fold(0.0, f64::max);
        rounding += 16.0 * U * course * longest;
    }
    let mut loss = normal_loss(&corners);
    if !to_world.is_identity() {
        rounding = rounding_of_instance(to_world, ray, &own, &corners);
        loss = loss.max(normal_loss(&own));
    }
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let along = ray.direction.length();
    let cosine = (normal.dot(ray.direction) / (normal.length() * along)).abs();
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let height = normal.length() / longest;
    let (outline, inside) = outline(ray, &corners);
    Verdict {
        t: (a - ray.origin).dot(normal) / ray.direction.dot(normal),
        outline,
        inside,
        rounding,
        t_bound: or_infinite(rounding * loss / (cosine * along)),
        uv_bound: or_infinite(rounding * loss / (cosine * height)),
    }
}

/// Distances of the origin and of the farthest corner from 0, added.
fn size(origin: Point3, corners: &[Point3; 3]) -> f64 {
    origin.length() + corners.iter().map(|p| p.length()).fold(0.0, f64::max)
}

fn rounding_of_instance(to_world: &Transform, ray: &Ray, own: &[Point3; 3], corners: &[Point3; 3]) -> f64 {
    let columns = to_world.columns();
    let lengths = columns.map(Vec3::length);
    let volume = columns[0].cross(columns[1]).dot(columns[2]).abs();
    let skew = lengths.iter().product::<f64>() / volume;
    let shift = to_world.translation().length();
    let largest_column = lengths.into_iter().fold(0.0, f64::max);
    let placing = 64.0 * U * skew * skew * (size(ray.origin, corners) + shift);
    let inside = 32.0 * U * size(to_object(to_world, ray).origin, own);
    // ‖M‖ is at most √3 times its longest column.
    placing + 3f64.sqrt() * largest_column * inside
}

/// |e1||e2| / |e1 × e2| of the two shorter edges, at least 1.
fn normal_loss(corners: &[Point3; 3]) -> f64 {
    let [a, b, c] = *corners;
    let mut lengths = [(b - a).length(), (c - b).length(), (a - c).length()];
    lengths.sort_by(f64::total_cmp);
    (lengths[0] * lengths[1] / (b - a).cross(c - a).length()).max(1.0)
}

/// Distance across the ray from it to the nearest edge, and whether it passes inside.
fn outline(ray: &Ray, corners: &[Point3; 3]) -> (f64, bool) {
    let frame = Frame::from_unit(ray.direction.normalize());
    let [a, b, c] = corners.map(|p| frame.project(p - ray.origin));
    let edges = [(a, b), (b, c), (c, a)];
    let distance = |(p, q): (crate::math::Vec2, crate::math::Vec2)| {
        let edge = q - p;
        let squared = edge.length_squared();
        let along = if squared > 0.0 { (-p.dot(edge) / squared).clamp(0.0, 1.0) } else { 0.0 };
        (p + edge * along).length()
    };
    let sides = edges.map(|(p, q)| p.perp_dot(q));
    let inside = sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0);
    (edges.map(distance).into_iter().fold(f64::INFINITY, f64::min), inside)
}

/// A bound that is no number bounds nothing.
fn or_infinite(bound: f64) -> f64 {
    if bound.is_finite() { bound } else { f64::INFINITY }
}
