//! Indexed triangle meshes in storage precision.

use std::sync::Arc;

use rayon::prelude::*;

use super::deformation::Deformation;
use crate::math::{Bounds3, Point3, Vec3};

/// Triangles over shared vertices, object space, metres. Counter-clockwise seen from outside. Of a mesh that changes its
/// shape, vertices and normals are those of the middle of the shutter's interval, once a scene is assembled.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TriangleMesh {
    pub positions: Vec<[f32; 3]>,
    /// Unit shading normals, one a vertex, or empty: then the triangles are flat.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, one a vertex, or empty.
    pub uvs: Vec<[f32; 2]>,
    /// What principled materials' base colours are multiplied by, linear Rec.709, one a vertex, or empty.
    pub colours: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// How it changes its shape; `None`: not at all.
    pub deformation: Option<Arc<Deformation>>,
}

impl TriangleMesh {
    /// The three corners of triangle `prim`.
    pub fn corners(&self, prim: u32) -> [Point3; 3] {
        self.triangles[prim as usize].map(|i| Point3::from_f32(self.positions[i as usize]))
    }
    pub fn bounds(&self) -> Bounds3 {
        Bounds3::from_points(self.positions.iter().map(|&p| Point3::from_f32(p)))
    }
    /// Whether it has another shape at another time.
    pub fn changes(&self) -> bool {
        self.deformation.is_some()
    }
    /// Around the mesh at all times.
    pub fn swept_bounds(&self) -> Bounds3 {
        self.deformation.as_ref().map_or_else(|| self.bounds(), |deformation| deformation.bounds())
    }
    pub fn area(&self) -> f64 {
        (0..self.triangles.len() as u32)
            .map(|prim| {
                let [a, b, c] = self.corners(prim);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum()
    }
    /// Volume inside a closed mesh, m³; negative if its triangles face inwards.
    pub fn signed_volume(&self) -> f64 {
        let Some(&origin) = self.positions.first() else { return 0.0 };
        let origin = Point3::from_f32(origin);
        let tetrahedron = |prim| {
            let [a, b, c] = self.corners(prim).map(|p| p - origin);
            a.dot(b.cross(c)) / 6.0
        };
        (0..self.triangles.len() as u32).map(tetrahedron).sum()
    }
    /// For each vertex the first one at the same place, so that seams of normals or texture close.
    pub fn welded_vertices(&self) -> Vec<u32> {
        // Adding zero makes −0 the same place as 0. Sorted and not hashed: a hash table of millions misses the cache.
        let key = |p: &[f32; 3]| p.map(|x| (x + 0.0).to_bits());
        let mut keyed: Vec<([u32; 3], u32)> = self.positions.iter().map(key).zip(0..).collect();
        keyed.par_sort_unstable();
        let mut welded = vec![0; keyed.len()];
        for same in keyed.chunk_by(|a, b| a.0 == b.0) {
            for (_, i) in same {
                welded[*i as usize] = same[0].1;
            }
        }
        welded
    }
    /// Normals of the vertices as means over their triangles weighted by the angle at the vertex, vertices at the same
    /// place taken as one. Where the triangles' normals cancel each other it is the first triangle's own; a vertex that
    /// only triangles without area use, which are never rendered, gets +z.
    pub fn angle_weighted_normals(&self) -> Vec<[f32; 3]> {
        // [Thuermer98]
        let welded = self.welded_vertices();
        let mut sums = vec![Vec3::ZERO; self.positions.len()];
        let mut firsts = vec![Vec3::ZERO; self.positions.len()];
        for (prim, triangle) in self.triangles.iter().enumerate() {
            let corners = self.corners(prim as u32);
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a).normalize_or_zero();
            for i in 0..3 {
                let (to_next, to_last) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
                let angle = to_next.cross(to_last).length().atan2(to_next.dot(to_last));
                let vertex = welded[triangle[i] as usize] as usize;
                sums[vertex] += angle * normal;
                if firsts[vertex] == Vec3::ZERO {
                    firsts[vertex] = normal;
                }
            }
        }
        // Of a sum of angles; what rounding leaves of normals that cancel is far below.
        const CANCELLED: f64 = 1e-12;
        let unit = |&vertex: &u32| {
            let (sum, first) = (sums[vertex as usize], firsts[vertex as usize]);
            let n = if sum.length() > CANCELLED { sum.normalize() } else { first.normalize_or(Vec3::Z) };
            [n.x as f32, n.y as f32, n.z as f32]
        };
        welded.iter().map(unit).collect()
    }
}
