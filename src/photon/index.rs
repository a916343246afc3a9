//! All footprints over a point: two trees of boxes, one recursion.
//!
//! The photons' footprints and the eye's points each get a bounding-volume tree, and the pairs of boxes that overlap
//! are found by descending both together. For any one point the photons come in the order of the photon tree's
//! leaves, whatever other points are asked about with it: sums have the same bits for every partition of the picture.

use glam::Vec3A;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
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
}

impl Boundable for OuterBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// A tree over boxes; leaves name the boxes by their index.
pub struct BoxTree {
    tree: Bvh2,
}

impl BoxTree {
    pub fn build(boxes: &[OuterBox]) -> BoxTree {
        let indices = (0..boxes.len() as u32).collect();
        let tree = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Minimum,
            boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        BoxTree { tree }
    }
    pub fn is_empty(&self) -> bool {
        self.tree.nodes.is_empty()
    }
}

/// Calls `visit(i, j)` for every pair of overlapping boxes, i of `points` and j of `footprints`. For a fixed i the j
/// come in the order of the leaves of `footprints`.
pub fn for_each_overlap(points: &BoxTree, footprints: &BoxTree, mut visit: impl FnMut(u32, u32)) {
    if points.is_empty() || footprints.is_empty() {
        return;
    }
    let (p, f) = (&points.tree, &footprints.tree);
    let mut stack = vec![(0u32, 0u32)];
    while let Some((i, j)) = stack.pop() {
        let (a, b) = (&p.nodes[i as usize], &f.nodes[j as usize]);
        if !a.aabb().intersect_aabb(b.aabb()) {
            continue;
        }
        match (a.is_leaf(), b.is_leaf()) {
            (true, true) => {
                for &point in leaf(p, i) {
                    for &footprint in leaf(f, j) {
                        visit(point, footprint);
                    }
                }
            }
            // The larger box is opened; the right child goes first onto the stack so that the left comes off first.
            (false, true) => stack.extend([(a.first_index + 1, j), (a.first_index, j)]),
            (true, false) => stack.extend([(i, b.first_index + 1), (i, b.first_index)]),
            (false, false) if larger(a.aabb(), b.aabb()) => stack.extend([(a.first_index + 1, j), (a.first_index, j)]),
            (false, false) => stack.extend([(i, b.first_index + 1), (i, b.first_index)]),
        }
    }
}

fn leaf(tree: &Bvh2, node: u32) -> &[u32] {
    let node = &tree.nodes[node as usize];
    let first = node.first_index as usize;
    &tree.primitive_indices[first..first + node.prim_count as usize]
}

fn larger(a: &Aabb, b: &Aabb) -> bool {
    let extent = |x: &Aabb| Vec3A::max_element(x.diagonal());
    extent(a) > extent(b)
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
    fn tree(boxes: &[(Point3, Vec3)]) -> BoxTree {
        BoxTree::build(&boxes.iter().map(|&(c, h)| OuterBox::new(c, h)).collect::<Vec<_>>())
    }
    fn overlaps(points: &[(Point3, Vec3)], footprints: &[(Point3, Vec3)]) -> Vec<Vec<u32>> {
        let mut found = vec![Vec::new(); points.len()];
        for_each_overlap(&tree(points), &tree(footprints), |i, j| found[i as usize].push(j));
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

    #[test]
    fn the_order_at_a_point_does_not_depend_on_the_other_points() {
        let (points, footprints) = (boxes(200, 0.0, 3), boxes(400, 0.2, 4));
        let together = overlaps(&points, &footprints);
        for (i, point) in points.iter().enumerate() {
            assert_eq!(together[i], overlaps(&[*point], &footprints)[0]);
        }
    }
}
