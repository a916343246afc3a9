//! The surface of an emissive mesh · world frame, m² · triangles by area on a mosaic of the unit square.

use super::SurfacePoint;
use crate::light::NormalCone;
use crate::math::{Bounds3, Normal3, Point3, Transform, Vec3};
use crate::sampling::discrete::Mosaic;
use crate::sampling::warp::{Triangle, Warp};
use crate::scene::TriangleMesh;

/// The mesh's triangles in the world. Its normals are geometric: what a triangle sends is even over it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MeshSurface {
    triangles: Vec<Triangle>,
    mosaic: Mosaic,
    area: f64,
    /// Whether the transform mirrors, which turns the corners' order.
    mirrored: bool,
}

impl MeshSurface {
    /// `None` for a mesh without area.
    pub fn new(mesh: &TriangleMesh, to_world: &Transform) -> Option<MeshSurface> {
        let triangles: Vec<Triangle> = (0..mesh.triangles.len() as u32)
            .map(|prim| Triangle { corners: mesh.corners(prim).map(|p| to_world.point(p)) })
            .collect();
        let areas: Vec<f64> = triangles.iter().map(Triangle::area).collect();
        let mosaic = Mosaic::new(&areas)?;
        Some(MeshSurface { triangles, mosaic, area: areas.iter().sum(), mirrored: to_world.flips_handedness() })
    }

    pub fn area(&self) -> f64 {
        self.area
    }

    /// Around all triangles, and around their normals.
    pub fn bounds(&self) -> (Bounds3, NormalCone) {
        let bounds = Bounds3::from_points(self.triangles.iter().flat_map(|triangle| triangle.corners));
        let normals = self.triangles.iter().filter_map(|triangle| self.normal(triangle)).map(NormalCone::of);
        (bounds, normals.reduce(NormalCone::union).unwrap_or(NormalCone::SPHERE))
    }

    /// Outward; `None` for a triangle without area.
    fn normal(&self, triangle: &Triangle) -> Option<Normal3> {
        let [a, b, c] = triangle.corners;
        Normal3::new((b - a).cross(c - a) * if self.mirrored { -1.0 } else { 1.0 })
    }

    pub fn sample(&self, u: [f64; 2]) -> Option<SurfacePoint> {
        let choice = self.mosaic.sample(u);
        let triangle = &self.triangles[choice.index];
        let (p, [du, dv]) = triangle.sample_with_jacobian(choice.reused);
        Some(SurfacePoint {
            p,
            n: self.normal(triangle)?,
            dpdu: du * choice.stretch[0],
            dpdv: dv * choice.stretch[1],
            dndu: Vec3::ZERO,
            dndv: Vec3::ZERO,
        })
    }

    /// Searches all triangles: for tests and inspection.
    pub fn inverse(&self, p: Point3) -> Option<[f64; 2]> {
        let off_plane = |t: &Triangle| {
            let [a, b, c] = t.corners;
            Normal3::new((b - a).cross(c - a)).map_or(f64::INFINITY, |n| n.dot(p - a).abs())
        };
        let (index, reused) = self
            .triangles
            .iter()
            .enumerate()
            .filter_map(|(i, t)| t.inverse(p).map(|u| (i, u, off_plane(t))))
            .min_by(|a, b| a.2.total_cmp(&b.2))
            .map(|(i, u, _)| (i, u))?;
        self.mosaic.inverse(index, reused)
    }
}
