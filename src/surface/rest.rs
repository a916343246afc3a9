//! Where light of different times meets on a surface that moves: at the same point of the object, put where the object is in
//! the middle of the shutter's interval.
//!
//! A photon that came at one time and an eye sample of another time lie on the same part of an object, not at the same place
//! in the world. Both are carried along with the object; what is gathered there is the mean over the shutter's interval of
//! the light on each point of the object.

use super::interaction::{Interaction, to_world_normal};
use crate::differential::{Column, Differential};
use crate::math::{Dir3, Normal3, Transform};
use crate::scene::Scene;

/// The map from an object's place at one time to that in the middle of the shutter's interval.
#[derive(Clone, Copy, Debug)]
pub struct ToRest {
    map: Transform,
    middle: f64,
}

impl Interaction {
    /// Whether its object is elsewhere at other times.
    pub fn is_carried(&self, scene: &Scene) -> bool {
        scene.objects[self.object.index()].motion.is_some()
    }
    /// What carries this point along with its object.
    pub fn to_rest(&self, scene: &Scene) -> ToRest {
        let object = &scene.objects[self.object.index()];
        let map = object.geometry.to_world().compose(&object.to_world(self.time).inverse());
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
