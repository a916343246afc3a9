//! Which footprints reach which points: two trees of boxes.
//!
//! The photons' footprints and a tile's eye points each get a bounding-volume tree. The photon tree is descended wherever
//! its boxes hold points, and every footprint found is splatted into the tree of points. A footprint is so made ready
//! once for all points of a tile, and the footprints come in the order of their tree's leaves whatever points are asked
//! about: sums have the same bits for every partition of the picture.

use std::ops::Range;

use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use crate::math::{Point3, Vec3};

/// A box given by its centre and half extents, rounded outwards to `f32`.
#[derive(Clone, Copy, Debug)]
pub struct OuterBox(Aabb);

impl OuterBox {
    pub fn new(centre: Point3, half: Vec3) -> OuterBox {
        // One rounding of the centre and one of the sum; four units in the last place are above both.
        let margin = (centre.abs() + half) * (4.0 * f64::from(f32::EPSILON));
        let (lo, hi) = (centre.to_vec() - half - margin, centre.to_vec() + half + margin);
        OuterBox(Aabb::new(lo.as_vec3a(), hi.as_vec3a()))
    }
    pub fn centre(&self) -> Point3 {
        Point3::from_f32(self.0.center().to_array())
    }
    pub fn half_extents(&self) -> Vec3 {
        Vec3::from((0.5 * self.0.diagonal()).to_array().map(f64::from))
    }
    /// The box of its middle alone.
    pub fn at_centre(&self) -> OuterBox {
        OuterBox(Aabb::from_point(self.0.center()))
    }
}

impl Boundable for OuterBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// A tree over boxes, which have indices; a leaf holds a run of [`BoxTree::order`].
pub struct BoxTree {
    tree: Bvh2,
}

/// What entering a node costs, in tests of one box of a leaf.
const TRAVERSAL_COST: f32 = 1.0;

impl BoxTree {
    /// A tree with at most `leaf_size` boxes in a leaf.
    pub fn build(boxes: &[OuterBox], leaf_size: u32) -> BoxTree {
        let indices = (0..boxes.len() as u32).collect();
        let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Minimum,
            boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        collapse(&mut tree, leaf_size, TRAVERSAL_COST);
        BoxTree { tree }
    }

    /// A tree over every `step`-th box from `first` on, with one box in a leaf; boxes keep their indices.
    pub fn build_every(boxes: &[OuterBox], first: usize, step: usize) -> BoxTree {
        let chosen: Vec<OuterBox> = boxes.iter().skip(first).step_by(step).copied().collect();
        let mut built = BoxTree::build(&chosen, 1);
        for index in &mut built.tree.primitive_indices {
            *index = (first + *index as usize * step) as u32;
        }
        built
    }

    /// All boxes in the order in which leaves hold them: [`BoxTree::visit`] gives ranges of this list.
    pub fn order(&self) -> &[u32] {
        &self.tree.primitive_indices
    }

    /// Calls `visit` with every leaf that overlaps `bounds`, as a range of [`BoxTree::order`], always from left to
    /// right, until it returns false.
    pub fn visit(&self, bounds: &OuterBox, visit: impl FnMut(Range<usize>) -> bool) {
        self.visit_where(bounds, |_| true, visit);
    }

    /// As [`BoxTree::visit`], and leaves out what lies below a box that `enter` refuses.
    pub fn visit_where(
        &self,
        bounds: &OuterBox,
        enter: impl Fn(&OuterBox) -> bool,
        mut visit: impl FnMut(Range<usize>) -> bool,
    ) {
        let enters = |aabb: &Aabb| aabb.intersect_aabb(&bounds.0) && enter(&OuterBox(*aabb));
        self.descend(enters, |node| visit(range(node)));
    }

    /// Calls `visit(j, bounds)` for every box of this tree that lies in a leaf overlapping a leaf of `points`, always
    /// from left to right.
    pub fn visit_over(&self, points: &BoxTree, mut visit: impl FnMut(u32, &OuterBox)) {
        let is_over = |aabb: &Aabb| {
            let mut found = false;
            points.visit(&OuterBox(*aabb), |_| {
                found = true;
                false
            });
            found
        };
        self.descend(is_over, |node| {
            for &j in &self.order()[range(node)] {
                visit(j, &OuterBox(*node.aabb()));
            }
            true
        });
    }

    /// Leaves from left to right below every node that `enter` lets in, until `leaf` returns false.
    fn descend(&self, mut enter: impl FnMut(&Aabb) -> bool, mut leaf: impl FnMut(&Bvh2Node) -> bool) {
        if let Some(root) = self.tree.nodes.first() {
            self.descend_from(root, &mut enter, &mut leaf);
        }
    }

    fn descend_from(
        &self,
        node: &Bvh2Node,
        enter: &mut impl FnMut(&Aabb) -> bool,
        leaf: &mut impl FnMut(&Bvh2Node) -> bool,
    ) -> bool {
        if !enter(node.aabb()) {
            return true;
        }
        if node.is_leaf() {
            return leaf(node);
        }
        let [left, right] = [0, 1].map(|side| &self.tree.nodes[node.first_index as usize + side]);
        self.descend_from(left, enter, leaf) && self.descend_from(right, enter, leaf)
    }
}

fn range(leaf: &Bvh2Node) -> Range<usize> {
    let first = leaf.first_index as usize;
    first..first + leaf.prim_count as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Purpose, Stream};

    fn boxes(n: usize, size: f64, seed: u64) -> Vec<(Point3, Vec3)> {
        let mut s = Stream::new(seed, Purpose::Test, 0, 0);
        (0..n)
            .map(|_| {
                let p = Point3::new(s.uniform(), s.uniform(), 0.2 * s.uniform());
                (p, Vec3::new(s.uniform(), s.uniform(), s.uniform()) * size)
            })
            .collect()
    }
    fn tree(boxes: &[(Point3, Vec3)], leaf_size: u32) -> BoxTree {
        BoxTree::build(&boxes.iter().map(|&(c, h)| OuterBox::new(c, h)).collect::<Vec<_>>(), leaf_size)
    }
    fn overlaps(points: &[(Point3, Vec3)], footprints: &[(Point3, Vec3)]) -> Vec<Vec<u32>> {
        let mut found = vec![Vec::new(); points.len()];
        let points = tree(points, 8);
        tree(footprints, 1).visit_over(&points, |j, bounds| {
            points.visit(bounds, |leaf| {
                points.order()[leaf].iter().for_each(|&i| found[i as usize].push(j));
                true
            });
        });
        found
    }

    #[test]
    fn every_overlapping_pair_is_visited_exactly_once() {
        for (n, m) in [(0, 5), (5, 0), (1, 1), (300, 500)] {
            let (points, footprints) = (boxes(n, 0.0, 1), boxes(m, 0.1, 2));
            let mut found = overlaps(&points, &footprints);
            for (i, list) in found.iter_mut().enumerate() {
                list.sort_unstable();
                assert!(list.windows(2).all(|w| w[0] < w[1]), "a pair came twice");
                for (j, (c, h)) in footprints.iter().enumerate() {
                    if (points[i].0 - *c).abs().cmple(*h).all() {
                        assert!(list.contains(&(j as u32)), "pair ({i}, {j}) missed");
                    }
                }
            }
        }
    }

    /// What a point shares its leaf with may add footprints that miss it, and never changes the order of the others.
    #[test]
    fn the_order_at_a_point_does_not_depend_on_the_other_points() {
        let (points, footprints) = (boxes(200, 0.0, 3), boxes(400, 0.2, 4));
        let together = overlaps(&points, &footprints);
        for (i, point) in points.iter().enumerate() {
            let alone = overlaps(&[*point], &footprints);
            let mut alone = alone[0].iter().peekable();
            for j in &together[i] {
                alone.next_if_eq(&j);
            }
            assert_eq!(alone.next(), None);
        }
    }
}
