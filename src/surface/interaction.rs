//! The surface about a hit · world frame, metres · recomputed in `f64` from the ids, so that backends agree ·
//! PHOTON_DIFFERENTIALS 1.1 for the derivatives of normals, under instance transforms too.

use super::triangle;
use crate::backend::RawHit;
use crate::differential::ShapeOperator;
use crate::math::float::{offset_ray_origin, origin_offset};
use crate::math::{Dir3, Frame, Normal3, Point3, Ray, Transform, Vec2, Vec3};
use crate::scene::{MaterialId, ObjectGeometry, ObjectId, Scene};
use crate::shape::Shape;

/// A surface point, oriented as the object is (normals are not turned towards the ray).
///
/// Outward is decided in the object's own space: a shape's own outward side, the side from which a triangle's corners
/// run counter-clockwise. The normal is carried to the world by M⁻ᵀ, so that a mirrored instance keeps its outside
/// outside, although its corners then run clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interaction {
    pub p: Point3,
    /// How far a ray that leaves this point must start from it, metres (`math::float::origin_offset`).
    pub error: f64,
    /// Distance along the ray that came here, metres.
    pub t: f64,
    /// Back along the ray.
    pub wo: Dir3,
    /// Geometric normal, outward.
    pub ng: Normal3,
    /// Shading normal, in the half space of `ng`.
    pub ns: Normal3,
    pub uv: Vec2,
    /// ∂p/∂u and ∂p/∂v, never parallel: unit tangents where the parametrisation has none (poles, meshes whose texture
    /// coordinates are constant).
    pub dpdu: Vec3,
    pub dpdv: Vec3,
    /// dNs/dx.
    pub shape: ShapeOperator,
    pub object: ObjectId,
    pub primitive: u32,
    pub material: MaterialId,
    /// Whether the hit was found again in `f64`. If not (a degenerate triangle, a ray in its plane), t and (u, v) are
    /// the backend's own; conductors count these.
    pub exact: bool,
}

/// What the geometry alone says of a hit, in world space.
pub(super) struct Found {
    pub p: Point3,
    pub t: f64,
    pub ng: Normal3,
    pub ns: Normal3,
    pub shape: ShapeOperator,
    pub uv: Vec2,
    pub dpdu: Vec3,
    pub dpdv: Vec3,
    /// Largest |coordinate| that entered the ray library's arithmetic.
    pub extent: f64,
    pub exact: bool,
}

impl Interaction {
    /// The surface where `ray` (world, unit direction) met what `hit` names. Only the ids are taken from the hit, and
    /// its t as the place to look: t, p and the normals are computed again in `f64`.
    pub fn from_hit(scene: &Scene, ray: &Ray, hit: &RawHit) -> Interaction {
        let object = &scene.objects[hit.object.index()];
        let found = match &object.geometry {
            ObjectGeometry::Mesh { mesh, to_world } => triangle::find(&scene.meshes[mesh.index()], to_world, ray, hit),
            ObjectGeometry::Shape { shape, to_world } => find_on_shape(shape, to_world, ray, hit),
        };
        let (dpdu, dpdv) = spanning(found.dpdu, found.dpdv, found.ng);
        Interaction {
            p: found.p,
            error: origin_offset(found.extent.max(found.p.abs().max_element())),
            t: found.t,
            wo: Dir3::from_unit(-ray.direction),
            ng: found.ng,
            ns: found.ns,
            uv: found.uv,
            dpdu,
            dpdv,
            shape: found.shape,
            object: hit.object,
            primitive: hit.primitive,
            material: object.material,
            exact: found.exact,
        }
    }

    /// Where a ray towards `w` starts.
    pub fn ray_origin(&self, w: Dir3) -> Point3 {
        offset_ray_origin(self.p, self.error, self.ng, w)
    }
}

fn find_on_shape(shape: &Shape, to_world: &Transform, ray: &Ray, hit: &RawHit) -> Found {
    let extent = shape.bounds().corners().into_iter().map(|p| reach(to_world, p)).fold(0.0, f64::max);
    let own = to_object(to_world, ray);
    // The backend's t may have passed through f32; the first root near it is the one that was meant.
    let window = 4.0 * origin_offset(extent + hit.t.abs());
    let near = Ray { t_min: ray.t_min.max(hit.t - window), t_max: hit.t + window, ..own };
    let again = shape.intersect(&near);
    let t = again.map_or(hit.t, |h| h.t);
    let local = shape.surface_at(own.at(t));
    let (ng, operator) = to_world_normal(to_world, local.n.to_vec(), local.shape.matrix())
        .unwrap_or((Normal3::from_unit(-ray.direction), ShapeOperator::FLAT));
    Found {
        p: to_world.point(local.p),
        t,
        ng,
        ns: ng,
        shape: operator,
        uv: local.uv,
        dpdu: to_world.vector(local.dpdu),
        dpdv: to_world.vector(local.dpdv),
        extent,
        exact: again.is_some(),
    }
}

/// The ray in the object's space, with the same t.
pub(super) fn to_object(to_world: &Transform, ray: &Ray) -> Ray {
    Ray { origin: to_world.inverse_point(ray.origin), direction: to_world.inverse_vector(ray.direction), ..*ray }
}

/// The largest |number| that shows up while `p` is taken to the world: |M| |p| + |t|, the largest coordinate.
pub(super) fn reach(to_world: &Transform, p: Point3) -> f64 {
    let [x, y, z] = to_world.columns();
    let sum = x.abs() * p.x.abs() + y.abs() * p.y.abs() + z.abs() * p.z.abs() + to_world.translation().abs();
    sum.max_element()
}

/// The world normal and dN/dx of an object-space normal `n` (any length) and its derivative `dn`: n is carried by M⁻ᵀ,
/// and the renormalisation is part of the derivative, S = (I − N Nᵀ) M⁻ᵀ dn M⁻¹ / |M⁻ᵀ n|. `None` for a zero normal.
pub(super) fn to_world_normal(to_world: &Transform, n: Vec3, dn: glam::DMat3) -> Option<(Normal3, ShapeOperator)> {
    let carried = to_world.normal_unnormalised(n);
    let normal = Normal3::new(carried)?;
    let inverse = glam::DMat3::from_cols(
        to_world.inverse_vector(Vec3::X),
        to_world.inverse_vector(Vec3::Y),
        to_world.inverse_vector(Vec3::Z),
    );
    let change = inverse.transpose() * dn * inverse * (1.0 / carried.length());
    let along = normal.to_vec();
    // (I − N Nᵀ) A, column by column.
    let tangent = |column: Vec3| column - along * along.dot(column);
    let operator = glam::DMat3::from_cols(tangent(change.x_axis), tangent(change.y_axis), tangent(change.z_axis));
    operator.is_finite().then(|| (normal, ShapeOperator::from_matrix(operator)))
}

/// The given tangents, or two unit ones if they span no plane (the sine of their angle is below 1e-6: its square
/// still stands well above the rounding of their Gram matrix).
fn spanning(dpdu: Vec3, dpdv: Vec3, ng: Normal3) -> (Vec3, Vec3) {
    let cross = dpdu.cross(dpdv).length();
    // Written so that a NaN is replaced too.
    if cross > 1e-6 * dpdu.length() * dpdv.length() && cross.is_finite() {
        (dpdu, dpdv)
    } else {
        let frame = Frame::from_unit(ng);
        (frame.t, frame.b)
    }
}
