//! Every primitive against every ray, in f64: the judge of the other backends. World frame, metres.

use std::sync::Arc;

use super::geometry::{Geometry, Item, Triangles, hit_triangle, to_object};
use super::nearest::{Gate, Nearest};
use super::triangle::ShearedRay;
use super::{Backend, RawHit};
use crate::math::Ray;
use crate::scene::ObjectId;

/// A linear loop over the scene.
#[derive(Debug)]
pub struct BruteBackend {
    geometry: Arc<Geometry>,
    gate: Gate,
}

impl BruteBackend {
    pub fn new(geometry: Arc<Geometry>) -> BruteBackend {
        BruteBackend { geometry, gate: Gate::default() }
    }
}

impl Backend for BruteBackend {
    fn intersect(&self, ray: &Ray) -> Option<RawHit> {
        if !self.gate.admits(ray) {
            return None;
        }
        let world = ShearedRay::new(ray);
        let mut nearest = Nearest::before(ray.t_max);
        for (object, item) in self.geometry.objects() {
            match item {
                Item::Mesh(mesh) => offer_all(mesh, object, &world, &mut nearest),
                Item::Instance { mesh, to_world } => {
                    let own = ShearedRay::new(&to_object(to_world, ray));
                    offer_all(&self.geometry.shared[*mesh], object, &own, &mut nearest);
                }
                Item::MovingMesh { mesh, motion } => {
                    let own = ShearedRay::new(&to_object(&motion.at(ray.time), ray));
                    offer_all(&self.geometry.shared[*mesh], object, &own, &mut nearest);
                }
                Item::Shape(placed) => {
                    if let Some(t) = placed.intersect(&Ray { t_max: nearest.end, ..*ray }) {
                        nearest.offer(RawHit { t, object, primitive: 0, uv: [0.0; 2] });
                    }
                }
            }
        }
        nearest.hit
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.intersect(ray).is_some()
    }

    fn describe(&self) -> String {
        "brute (f64)".to_owned()
    }

    fn invalid_rays(&self) -> u64 {
        self.gate.refused()
    }
}

fn offer_all(mesh: &Triangles, object: ObjectId, ray: &ShearedRay, nearest: &mut Nearest) {
    for primitive in 0..mesh.triangles.len() as u32 {
        if let Some(hit) = hit_triangle(ray, mesh, primitive, nearest.end) {
            nearest.offer(RawHit { t: hit.t, object, primitive, uv: [hit.u, hit.v] });
        }
    }
}
