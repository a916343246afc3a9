//! The surface about a hit · world frame, metres · recomputed in `f64` from the ids, so that backends agree ·
//! PHOTON_DIFFERENTIALS 1.1 for the derivatives of normals, under instance transforms too.

use super::triangle;
use crate::backend::RawHit;
use crate::differential::{ShapeOperator, SurfaceMotion};
use crate::math::float::{offset_ray_origin, origin_offset};
use crate::math::{Dir3, Normal3, Point3, Ray, Transform, Vec3};
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
    /// The ray's, s.
    pub time: f64,
    /// Back along the ray.
    pub wo: Dir3,
    /// Geometric normal, outward.
    pub ng: Normal3,
    /// Shading normal, in the half space of `ng`.
    pub ns: Normal3,
    /// dNs/dx.
    pub shape: ShapeOperator,
    /// Weights of a triangle's second and third corner; zero on an exact shape.
    pub barycentric: [f64; 2],
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
    pub barycentric: [f64; 2],
    /// Largest |coordinate| that entered the ray library's arithmetic.
    pub extent: f64,
    pub exact: bool,
}

impl Interaction {
    /// The surface where `ray` (world, unit direction) met what `hit` names. Of a triangle only the ids are taken from
    /// the hit: t, p and the normals are computed again in `f64`. Shapes were hit in `f64`, so their t is.
    pub fn from_hit(scene: &Scene, ray: &Ray, hit: &RawHit) -> Interaction {
        let object = &scene.objects[hit.object.index()];
        let moved;
        let to_world = match &object.motion {
            None => object.geometry.to_world(),
            Some(motion) => {
                moved = motion.at(ray.time);
                &moved
            }
        };
        let found = match &object.geometry {
            ObjectGeometry::Mesh { mesh, .. } => triangle::find(&scene.meshes[mesh.index()], to_world, ray, hit),
            ObjectGeometry::Shape { shape, .. } => find_on_shape(shape, to_world, ray, hit),
        };
        Interaction {
            p: found.p,
            error: origin_offset(found.extent.max(found.p.abs().max_element())),
            t: found.t,
            time: ray.time,
            wo: Dir3::from_unit(-ray.direction),
            ng: found.ng,
            ns: found.ns,
            shape: found.shape,
            barycentric: found.barycentric,
            object: hit.object,
            primitive: hit.primitive,
            material: object.material,
            exact: found.exact,
        }
    }

    /// How the object moves here, per second.
    pub fn motion(&self, scene: &Scene) -> SurfaceMotion {
        let object = &scene.objects[self.object.index()];
        let mut found = match &object.motion {
            None => SurfaceMotion::STILL,
            Some(motion) => {
                let (velocity, gradient) = motion.velocity(self.time, self.p);
                SurfaceMotion { velocity, gradient }
            }
        };
        let to_world = object.to_world(self.time);
        if let ObjectGeometry::Shape { shape, .. } = &object.geometry
            && let Some((velocity, gradient)) = shape.velocity_at(to_world.inverse_point(self.p), self.time)
        {
            found.velocity += to_world.vector(velocity);
            found.gradient += to_world.carried(gradient);
        }
        if let ObjectGeometry::Mesh { mesh, .. } = &object.geometry
            && let mesh = &scene.meshes[mesh.index()]
            && let Some(deformation) = &mesh.deformation
        {
            let (velocity, turning) =
                triangle::deforming(deformation, mesh, self.primitive, self.barycentric, self.time);
            found.velocity += to_world.vector(velocity);
            found.gradient += turning.gradient(&to_world);
        }
        found
    }

    /// The ray that leaves towards `w`.
    pub fn ray(&self, w: Dir3) -> Ray {
        Ray { time: self.time, ..Ray::new(self.ray_origin(w), w) }
    }

    /// Where a ray towards `w` starts.
    pub fn ray_origin(&self, w: Dir3) -> Point3 {
        offset_ray_origin(self.p, self.error, self.ng, w)
    }
}

fn find_on_shape(shape: &Shape, to_world: &Transform, ray: &Ray, hit: &RawHit) -> Found {
    let local = shape.surface_at(to_object(to_world, ray).at(hit.t), ray.time);
    let (ng, operator) = if to_world.only_moves() {
        (local.n, local.shape)
    } else {
        to_world_normal(to_world, local.n.to_vec(), local.shape.matrix())
            .unwrap_or((Normal3::from_unit(-ray.direction), ShapeOperator::FLAT))
    };
    Found {
        p: to_world.point(local.p),
        t: hit.t,
        ng,
        ns: ng,
        shape: operator,
        barycentric: [0.0; 2],
        // What the box's corners reach at most.
        extent: reach(to_world, shape.bounds().farthest()),
        exact: true,
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
    let change = to_world.form(dn) * (1.0 / carried.length());
    let along = normal.to_vec();
    // (I − N Nᵀ) A, column by column.
    let tangent = |column: Vec3| column - along * along.dot(column);
    let operator = glam::DMat3::from_cols(tangent(change.x_axis), tangent(change.y_axis), tangent(change.z_axis));
    operator.is_finite().then(|| (normal, ShapeOperator::from_matrix(operator)))
}
