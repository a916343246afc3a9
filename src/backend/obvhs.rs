//! Pure Rust: trees by the crate `obvhs`, leaves tested in f64 by the same functions as `brute`.
//!
//! World frame, metres. Two levels: one tree over all baked triangles, shapes and instances, what moves in a box around all
//! its places; one tree for each shared mesh in its own space. The trees only cull, in f32, and never lose a hit:
//!
//! - a ray enters a tree by f64 arithmetic at its root box, so culling sees no coordinate larger than the box's own
//!   and a unit direction, however far away the ray starts;
//! - boxes are padded by `PADDING` of the tree's largest coordinate. In units of 2⁻²⁴ of that coordinate the culling
//!   errs by 1 for the origin, about 6 for the slabs' differences and products over a path of at most the diagonal, and
//!   7 for the direction's roundings and `obvhs`'s smallest component; 32 covers the sum twice.

use std::sync::Arc;

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::faststack::{HeapStack, StackStack};
use obvhs::ray::{Ray as CullRay, RayHit};

use super::geometry::{Geometry, Item, Triangles, hit_triangle, outward, to_object};
use super::nearest::{Gate, Nearest};
use super::triangle::ShearedRay;
use super::{Backend, RawHit};
use crate::math::{Bounds3, Ray};
use crate::scene::ObjectId;

/// 2⁻¹⁹.
const PADDING: f64 = 1.0 / 524_288.0;

/// Depth up to which the traversal's stack lives on the thread's own.
const SHALLOW: usize = 96;

/// Trees of `obvhs` over the scene.
pub struct ObvhsBackend {
    geometry: Arc<Geometry>,
    top: Tree,
    /// What the top tree's primitives are: object and primitive.
    leaves: Vec<(ObjectId, u32)>,
    /// One tree for each of [`Geometry::shared`].
    shared: Vec<Tree>,
    gate: Gate,
}

impl ObvhsBackend {
    pub fn new(geometry: Arc<Geometry>) -> ObvhsBackend {
        let mut leaves = Vec::new();
        let mut boxes = Vec::new();
        for (object, item) in geometry.objects() {
            match item {
                Item::Mesh(mesh) => {
                    leaves.extend((0..mesh.triangles.len() as u32).map(|primitive| (object, primitive)));
                    boxes.extend(mesh.boxes());
                }
                Item::Instance { .. } | Item::MovingMesh { .. } | Item::Shape(_) => {
                    leaves.push((object, 0));
                    boxes.push(geometry.bounds(object));
                }
            }
        }
        let top = Tree::over(&boxes);
        let leaves = top.order.iter().map(|&i| leaves[i as usize]).collect();
        let shared = geometry.shared.iter().map(|mesh| Tree::over(&mesh.boxes().collect::<Vec<_>>())).collect();
        ObvhsBackend { geometry, top, leaves, shared, gate: Gate::default() }
    }

    /// The first hit, or any hit.
    fn search(&self, ray: &Ray, any: bool) -> Option<RawHit> {
        if !self.gate.admits(ray) {
            return None;
        }
        let world = ShearedRay::new(ray);
        let mut nearest = Nearest::before(ray.t_max);
        self.top.visit(ray, |leaf| {
            let (object, primitive) = self.leaves[leaf];
            match &self.geometry.items[object.index()] {
                Item::Mesh(mesh) => offer(mesh, object, primitive, &world, &mut nearest),
                Item::Instance { mesh, to_world } => {
                    let own = Ray { t_max: nearest.end, ..to_object(to_world, ray) };
                    self.search_instance(*mesh, object, &own, any, &mut nearest);
                }
                Item::MovingMesh { mesh, motion } => {
                    let own = Ray { t_max: nearest.end, ..to_object(&motion.at(ray.time), ray) };
                    self.search_instance(*mesh, object, &own, any, &mut nearest);
                }
                Item::Shape(placed) => {
                    if let Some(t) = placed.intersect(&Ray { t_max: nearest.end, ..*ray }) {
                        nearest.offer(RawHit { t, object, primitive, uv: [0.0; 2] });
                    }
                }
            }
            next_end(&nearest, any)
        });
        nearest.hit
    }

    fn search_instance(&self, mesh: usize, object: ObjectId, ray: &Ray, any: bool, nearest: &mut Nearest) {
        let sheared = ShearedRay::new(ray);
        let tree = &self.shared[mesh];
        tree.visit(ray, |leaf| {
            offer(&self.geometry.shared[mesh], object, tree.order[leaf], &sheared, nearest);
            next_end(nearest, any)
        });
    }
}

impl Backend for ObvhsBackend {
    fn intersect(&self, ray: &Ray) -> Option<RawHit> {
        self.search(ray, false)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.search(ray, true).is_some()
    }

    fn describe(&self) -> String {
        "obvhs 0.4".to_owned()
    }

    fn invalid_rays(&self) -> u64 {
        self.gate.refused()
    }
}

fn offer(mesh: &Triangles, object: ObjectId, primitive: u32, ray: &ShearedRay, nearest: &mut Nearest) {
    if let Some(hit) = hit_triangle(ray, mesh, primitive, nearest.end) {
        nearest.offer(RawHit { t: hit.t, object, primitive, uv: [hit.u, hit.v] });
    }
}

/// Where the traversal may stop: behind the best hit, or at once where any hit will do.
fn next_end(nearest: &Nearest, any: bool) -> f64 {
    if any && nearest.hit.is_some() { f64::NEG_INFINITY } else { nearest.end }
}

/// A culling tree over boxes.
struct Tree {
    bvh: Bvh2,
    /// Primitive at each place of the tree's leaves.
    order: Vec<u32>,
    /// The padded root.
    root: Bounds3,
}

impl Tree {
    fn over(boxes: &[Bounds3]) -> Tree {
        let bounds = boxes.iter().fold(Bounds3::EMPTY, |all, b| all.union(*b));
        // A scene that is one point at the origin still gets boxes with an inside.
        let pad = bounds.max_abs() * PADDING + f64::from(f32::MIN_POSITIVE);
        let padded: Vec<Aabb> = boxes.iter().map(|b| to_f32(b.expanded(pad))).collect();
        let mut bvh = if padded.is_empty() {
            Bvh2::default()
        } else {
            build_bvh2(&padded, BvhBuildParams::medium_build(), &mut std::time::Duration::default())
        };
        // The builder's figure is the depth before its optimisations, which may deepen the tree.
        bvh.max_depth = if bvh.nodes.is_empty() { 0 } else { bvh.depth(0) + 1 };
        let order = std::mem::take(&mut bvh.primitive_indices);
        Tree { bvh, order, root: bounds.expanded(pad) }
    }

    /// Calls `test` with the place of every primitive whose box the ray may meet before the end that `test` last
    /// returned, nearer boxes roughly first.
    fn visit(&self, ray: &Ray, mut test: impl FnMut(usize) -> f64) {
        let Some((enter, leave)) = self.root_interval(ray) else { return };
        let length = ray.direction.length();
        let to_cull = |t: f64| ((t.min(leave) - enter) * length) as f32;
        let origin = ray.at(enter).to_array().map(|x| x as f32);
        let direction = (ray.direction / length).to_array().map(|x| x as f32);
        // The padding also covers the rounding of the interval's end.
        let cull = CullRay::new(origin.into(), direction.into(), 0.0, to_cull(ray.t_max).next_up());
        let in_leaf = |node: &obvhs::bvh2::node::Bvh2Node, cull: &mut CullRay, _: &mut RayHit| {
            for place in node.first_index..node.first_index + node.prim_count {
                let end = test(place as usize);
                if end == f64::NEG_INFINITY {
                    return false;
                }
                cull.tmax = cull.tmax.min(to_cull(end).next_up());
            }
            true
        };
        self.traverse(cull, in_leaf);
    }

    fn traverse(
        &self,
        cull: CullRay,
        in_leaf: impl FnMut(&obvhs::bvh2::node::Bvh2Node, &mut CullRay, &mut RayHit) -> bool,
    ) {
        let mut unused = RayHit::none();
        if self.bvh.max_depth <= SHALLOW {
            let mut stack = StackStack::<u32, SHALLOW>::default();
            self.bvh.ray_traverse_dynamic(&mut stack, cull, &mut unused, in_leaf);
        } else {
            let mut stack = HeapStack::<u32>::new_with_capacity(self.bvh.max_depth);
            self.bvh.ray_traverse_dynamic(&mut stack, cull, &mut unused, in_leaf);
        }
    }

    /// The part of the ray's interval that lies in the root box.
    fn root_interval(&self, ray: &Ray) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (ray.t_min, ray.t_max);
        let (min, max) = (self.root.min.to_array(), self.root.max.to_array());
        for (axis, (&o, &d)) in ray.origin.to_array().iter().zip(&ray.direction.to_array()).enumerate() {
            if d == 0.0 {
                if o < min[axis] || o > max[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((min[axis] - o) / d, (max[axis] - o) / d);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter <= leave).then_some((enter, leave))
    }
}

fn to_f32(b: Bounds3) -> Aabb {
    let (lower, upper) = outward(b);
    Aabb::new(lower.into(), upper.into())
}
