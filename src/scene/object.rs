//! Things that rays can hit.

use std::borrow::Cow;
use std::sync::Arc;

use super::artistic::Caustics;
use super::camera::Shutter;
use super::ids::{LightId, MaterialId, MeshId};
use super::mesh::TriangleMesh;
use crate::math::{Bounds3, Motion, Point3, Transform};
use crate::shape::Shape;

/// Geometry in object space and where it stands; of what moves, in the middle of the shutter's interval.
#[derive(Clone, Debug)]
pub enum ObjectGeometry {
    /// A mesh; meshes that several objects name are instanced by the backends, others may be baked.
    Mesh { mesh: MeshId, to_world: Transform },
    /// An exact shape.
    Shape { shape: Shape, to_world: Transform },
}

impl ObjectGeometry {
    pub fn to_world(&self) -> &Transform {
        match self {
            ObjectGeometry::Mesh { to_world, .. } | ObjectGeometry::Shape { to_world, .. } => to_world,
        }
    }
    /// The mesh that it is, if it is one.
    pub fn mesh(&self) -> Option<MeshId> {
        match self {
            ObjectGeometry::Mesh { mesh, .. } => Some(*mesh),
            ObjectGeometry::Shape { .. } => None,
        }
    }
    /// Around it in its own space; `meshes` are the bounds of the scene's meshes, whatever their shapes.
    pub fn own_bounds(&self, meshes: &[Bounds3]) -> Bounds3 {
        match self {
            ObjectGeometry::Mesh { mesh, .. } => meshes[mesh.index()],
            ObjectGeometry::Shape { shape, .. } => shape.bounds(),
        }
    }
    /// Around it in the world.
    pub fn bounds(&self, meshes: &[Bounds3]) -> Bounds3 {
        self.own_bounds(meshes).transformed(self.to_world())
    }
}

/// One object of the scene.
#[derive(Clone, Debug)]
pub struct Object {
    pub name: String,
    pub geometry: ObjectGeometry,
    /// How it moves while the shutter is open; `None`: not at all.
    pub motion: Option<Arc<Motion>>,
    /// Around it in the world, wherever it is while the shutter is open.
    pub bounds: Bounds3,
    pub material: MaterialId,
    /// The area light that this object is, if it emits.
    pub light: Option<LightId>,
    /// Which caustics are left out of the picture.
    pub caustics: Caustics,
}

impl Object {
    /// Whether it is not the same all the time that the shutter is open.
    pub fn moves(&self) -> bool {
        self.motion.is_some() || matches!(&self.geometry, ObjectGeometry::Shape { shape, .. } if shape.changes())
    }

    /// Where it is at `time`.
    pub fn to_world(&self, time: f64) -> Cow<'_, Transform> {
        match &self.motion {
            None => Cow::Borrowed(self.geometry.to_world()),
            Some(motion) => Cow::Owned(motion.at(time)),
        }
    }

    /// Around it in the world while the shutter is open; `meshes` are the bounds of the scene's meshes.
    pub fn swept_bounds(
        geometry: &ObjectGeometry,
        motion: Option<&Motion>,
        shutter: Shutter,
        meshes: &[Bounds3],
    ) -> Bounds3 {
        match motion {
            None => geometry.bounds(meshes),
            Some(motion) => motion.bounds(&geometry.own_bounds(meshes), shutter.open, shutter.close),
        }
    }

    /// About its area in the world, m²: exact where the transform scales evenly; a shape without an area of its own counts
    /// as half of its box.
    pub fn area(&self, meshes: &[TriangleMesh]) -> f64 {
        let (own, to_world) = match &self.geometry {
            ObjectGeometry::Mesh { mesh, to_world } => (Some(meshes[mesh.index()].area()), to_world),
            ObjectGeometry::Shape { shape, to_world } => (shape.area(), to_world),
        };
        let [a, b, c] = to_world.columns();
        own.map_or(0.5 * self.bounds.area(), |area| area * a.dot(b.cross(c)).abs().powf(2.0 / 3.0))
    }

    /// Centre and radius of a sphere around the object in the world.
    pub fn bounding_sphere(&self) -> (Point3, f64) {
        if let ObjectGeometry::Shape { shape: Shape::Sphere(sphere), to_world } = &self.geometry
            && self.motion.is_none()
        {
            let [a, b, c] = to_world.columns();
            // Axes that stay perpendicular: the ball becomes an ellipsoid along them.
            let skew = a.dot(b).abs() + b.dot(c).abs() + c.dot(a).abs();
            if skew < 1e-12 * (a.length_squared() + b.length_squared() + c.length_squared()) {
                let stretch = a.length().max(b.length()).max(c.length());
                return (to_world.point(sphere.centre()), sphere.radius() * stretch);
            }
        }
        self.bounds.bounding_sphere()
    }
}
