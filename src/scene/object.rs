//! Things that rays can hit.

use super::ids::{LightId, MaterialId, MeshId};
use super::mesh::TriangleMesh;
use crate::math::{Bounds3, Point3, Transform};
use crate::shape::Shape;

/// Geometry in object space and where it stands.
#[derive(Clone, Debug)]
pub enum ObjectGeometry {
    /// A mesh; meshes that several objects name are instanced by the backends, others may be baked.
    Mesh { mesh: MeshId, to_world: Transform },
    /// An exact shape.
    Shape { shape: Shape, to_world: Transform },
}

impl ObjectGeometry {
    /// Around it in the world; `meshes` are the bounds of the scene's meshes.
    pub fn bounds(&self, meshes: &[Bounds3]) -> Bounds3 {
        match self {
            ObjectGeometry::Mesh { mesh, to_world } => meshes[mesh.index()].transformed(to_world),
            ObjectGeometry::Shape { shape, to_world } => shape.bounds().transformed(to_world),
        }
    }
}

/// One object of the scene.
#[derive(Clone, Debug)]
pub struct Object {
    pub name: String,
    pub geometry: ObjectGeometry,
    /// Around it in the world.
    pub bounds: Bounds3,
    pub material: MaterialId,
    /// The area light that this object is, if it emits.
    pub light: Option<LightId>,
}

impl Object {
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
        if let ObjectGeometry::Shape { shape: Shape::Sphere(sphere), to_world } = &self.geometry {
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
