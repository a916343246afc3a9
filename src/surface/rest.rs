//! Where light of different times meets on a surface that moves: at the same point of the object, put where the object is in
//! the middle of the shutter's interval.
//!
//! A photon that came at one time and an eye sample of another time lie on the same part of an object, not at the same place
//! in the world. Both are carried along with the object; what is gathered there is the mean over the shutter's interval of
//! the light on each point of the object.

use super::interaction::{Interaction, to_world_normal};
use super::triangle;
use crate::differential::{Column, Differential};
use crate::math::{Dir3, Normal3, Transform};
use crate::scene::{Deformation, ObjectGeometry, Scene, TriangleMesh};

/// The map from an object's place at one time to that in the middle of the shutter's interval; of a mesh that changes its
/// shape, from a triangle's place.
#[derive(Clone, Copy, Debug)]
pub struct ToRest {
    map: Transform,
    middle: f64,
}

impl Interaction {
    /// Whether its object is elsewhere at other times.
    pub fn is_carried(&self, scene: &Scene) -> bool {
        let object = &scene.objects[self.object.index()];
        object.motion.is_some() || self.deforming(scene).is_some()
    }
    fn deforming<'a>(&self, scene: &'a Scene) -> Option<(&'a TriangleMesh, &'a Deformation)> {
        let ObjectGeometry::Mesh { mesh, .. } = &scene.objects[self.object.index()].geometry else { return None };
        let mesh = &scene.meshes[mesh.index()];
        mesh.deformation.as_deref().map(|deformation| (mesh, deformation))
    }
    /// What carries this point along with its object.
    pub fn to_rest(&self, scene: &Scene) -> ToRest {
        let object = &scene.objects[self.object.index()];
        let own = self
            .deforming(scene)
            .and_then(|(mesh, deformation)| triangle::to_rest(deformation, mesh, self.primitive, self.time));
        let out_of = object.to_world(self.time).inverse();
        let own = own.map_or(out_of, |own| own.compose(&out_of));
        let map = object.geometry.to_world().compose(&own);
        ToRest { map, middle: scene.shutter.middle() }
    }
}

impl ToRest {
    pub fn direction(&self, w: Dir3) -> Dir3 {
        Dir3::new(self.map.vector(w.to_vec())).unwrap_or(w)
    }
    pub fn interaction(&self, si: &Interaction) -> Interaction {
        let carried = |n: Normal3| to_world_normal(&self.map, n.to_vec(), si.shape.matrix());
        let (ns, shape) = carried(si.ns).unwrap_or((si.ns, si.shape));
        let ng = carried(si.ng).map_or(si.ng, |(ng, _)| ng);
        Interaction { p: self.map.point(si.p), ng, ns, shape, wo: self.direction(si.wo), time: self.middle, ..*si }
    }
    pub fn columns<const N: usize>(&self, columns: &Differential<N>) -> Differential<N> {
        let carried = |c: Column| Column { dx: self.map.vector(c.dx), dw: self.map.vector(c.dw) };
        Differential::new(columns.columns().map(carried))
    }
    /// Area there over area here, of a surface with this normal: |det M| |M⁻ᵀ n|, 1 where nothing is stretched.
    pub fn area(&self, n: Normal3) -> f64 {
        let [x, y, z] = self.map.columns();
        x.dot(y.cross(z)).abs() * self.map.normal_unnormalised(n.to_vec()).length()
    }
}
