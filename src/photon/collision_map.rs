//! All collisions of a pass of one kind, and which of them a ray or a place may lie in.

use super::beam::Beam;
use super::collision::Collision;
use super::footprint::Spread;
use super::index::{BoxTree, OuterBox, SlabRay};
use super::order::ZCurve;
use crate::math::{Bounds3, Point3, Vec3};
use crate::sampling::Stream;
use crate::scene::Medium;

/// Collisions with a tree over the boxes around them.
#[derive(Debug)]
pub struct CollisionMap {
    pub collisions: Vec<Collision>,
    tree: BoxTree,
}

impl CollisionMap {
    /// Bytes that each of the collisions takes while their map is built: itself, the key by which it is sorted, its box.
    pub const BYTES_PER_COLLISION: u64 = size_of::<Collision>() as u64 + 16 + 27;

    /// `count` collisions on each of the beams, which go through these media; the same whatever order they come in.
    /// `stream` gives each beam its numbers.
    pub fn new(
        mut beams: Vec<Beam>,
        media: &[Medium],
        count: u32,
        spread: Spread,
        stream: impl Fn(u64) -> Stream,
    ) -> CollisionMap {
        beams.sort_by_cached_key(Beam::bits);
        let mut collisions = Vec::with_capacity(beams.len() * count as usize);
        for (i, beam) in (0..).zip(&beams) {
            let medium = &media[beam.medium.index()];
            beam.collide(medium, count, spread, &mut stream(i), |collision| collisions.push(collision));
        }
        CollisionMap::of(collisions)
    }

    /// Of these collisions.
    pub fn of(mut collisions: Vec<Collision>) -> CollisionMap {
        let curve = ZCurve::through(&Bounds3::from_points(collisions.iter().map(|c| c.p)));
        collisions.sort_by_cached_key(|c| curve.code(c.p));
        let tree = BoxTree::build(collisions.len(), |i| OuterBox::new(collisions[i].p, collisions[i].half_extents()));
        CollisionMap { collisions, tree }
    }

    /// Leads `visit` to the collisions whose boxes the ray meets.
    #[inline(always)]
    pub fn along(&self, ray: &SlabRay, mut visit: impl FnMut(&Collision)) {
        self.tree.along(ray, |i| visit(&self.collisions[i]));
    }

    /// Leads `visit` to the collisions whose boxes hold the place.
    pub fn over(&self, p: Point3, mut visit: impl FnMut(&Collision)) {
        self.tree.around(OuterBox::new(p, Vec3::ZERO), |i| visit(&self.collisions[i]));
    }
}
