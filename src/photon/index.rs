//! Which boxes lie over which: an implicit tree with eight children a node.
//!
//! The boxes come in an order in which neighbours are near each other ([`super::order`]); node k of a level holds the
//! boxes of the eight nodes 8k … 8k + 7 below it, so that there is nothing to store but boxes: 27 bytes for each. Boxes
//! are tested eight at once.
#![expect(clippy::needless_range_loop, reason = "one loop over the lanes of several arrays compiles to vectors")]

use std::array;
use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::math::{Dir3, Point3, Vec3};

/// Children of a node.
pub const WIDTH: usize = 8;

/// Levels of a tree over all that 32 bits can count.
const MAX_LEVELS: usize = 11;

/// Nodes from which on a level is built on all cores.
const PARALLEL_FROM: usize = 4096;

/// A box rounded outwards to `f32`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OuterBox {
    pub lo: [f32; 3],
    pub hi: [f32; 3],
}

impl OuterBox {
    /// Overlaps nothing, and adds nothing to a union.
    pub const EMPTY: OuterBox = OuterBox { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

    /// Given by its centre and half extents.
    pub fn new(centre: Point3, half: Vec3) -> OuterBox {
        // One rounding of the centre and one of the sum; four units in the last place are above both.
        let margin = (centre.abs() + half) * (4.0 * f64::from(f32::EPSILON));
        let (lo, hi) = (centre.to_vec() - half - margin, centre.to_vec() + half + margin);
        OuterBox { lo: lo.as_vec3().to_array(), hi: hi.as_vec3().to_array() }
    }
    pub fn union(self, other: OuterBox) -> OuterBox {
        OuterBox {
            lo: array::from_fn(|k| self.lo[k].min(other.lo[k])),
            hi: array::from_fn(|k| self.hi[k].max(other.hi[k])),
        }
    }
    pub fn overlaps(&self, other: &OuterBox) -> bool {
        (0..3).all(|k| self.lo[k] <= other.hi[k] && self.hi[k] >= other.lo[k])
    }
    /// The longest of its half extents, m.
    pub fn half_width(&self) -> f32 {
        (0..3).map(|k| 0.5 * (self.hi[k] - self.lo[k])).fold(0.0, f32::max)
    }
}

/// A ray made ready to be held against boxes, in single precision: it may meet a few more boxes than it should, none less.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabRay {
    /// The origin, moved by what rounding may have moved it: forwards for the side where a ray comes in …
    first: [f32; 3],
    /// … and backwards for the one where it leaves.
    last: [f32; 3],
    /// Of the direction; of a component that is zero that of a tiny one, so that no difference of zero becomes NaN.
    inverse: [f32; 3],
    length: f32,
}

/// Above one by more than the roundings of a distance: of the inverse, of the difference, of their product.
const WIDENED: f32 = 1.0 + 8.0 * f32::EPSILON;

impl SlabRay {
    /// Whose every place is the middle of a box with these half extents, m, zero for a ray as thin as it is: it meets what any
    /// of these overlaps.
    pub fn new(origin: Point3, w: Dir3, length: f64, half: Vec3) -> SlabRay {
        let inverse = w.to_vec().to_array().map(|c| (1.0 / if c.abs() < TINY { TINY } else { c }) as f32);
        let (origin, half) = (origin.to_vec().to_array(), half.to_array());
        let moved = |sign: f64| {
            array::from_fn(|k| {
                // Moving the ray's sides towards a box is widening the box.
                let slack = half[k] + origin[k].abs() * 4.0 * f64::from(f32::EPSILON) + f64::from(f32::MIN_POSITIVE);
                (origin[k] + slack * sign * f64::from(inverse[k]).signum()) as f32
            })
        };
        SlabRay { first: moved(1.0), last: moved(-1.0), inverse, length: length as f32 * WIDENED }
    }
}

/// A component of a direction that bends a ray by less than boxes are rounded.
const TINY: f64 = 1e-30;

/// Eight boxes, coordinate by coordinate.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub struct Boxes {
    pub lo: [[f32; WIDTH]; 3],
    pub hi: [[f32; WIDTH]; 3],
}

impl Boxes {
    fn from_fn(boxed: impl Fn(usize) -> OuterBox) -> Boxes {
        let boxes: [OuterBox; WIDTH] = array::from_fn(boxed);
        Boxes { lo: array::from_fn(|k| boxes.map(|b| b.lo[k])), hi: array::from_fn(|k| boxes.map(|b| b.hi[k])) }
    }
    fn get(&self, lane: usize) -> OuterBox {
        OuterBox { lo: self.lo.map(|lanes| lanes[lane]), hi: self.hi.map(|lanes| lanes[lane]) }
    }
    fn union(&self) -> OuterBox {
        (0..WIDTH).map(|lane| self.get(lane)).fold(OuterBox::EMPTY, OuterBox::union)
    }
    /// Those that a ray meets.
    #[inline(always)]
    pub fn met(&self, ray: &SlabRay) -> Lanes {
        let (mut near, mut far) = ([0.0f32; WIDTH], [ray.length; WIDTH]);
        for k in 0..3 {
            // Not by comparing distances: an empty box has to stay one.
            let [first, last] =
                if ray.inverse[k] > 0.0 { [&self.lo[k], &self.hi[k]] } else { [&self.hi[k], &self.lo[k]] };
            for i in 0..WIDTH {
                let (a, b) = ((first[i] - ray.first[k]) * ray.inverse[k], (last[i] - ray.last[k]) * ray.inverse[k]);
                // Not `max` and `min`, which do more about what is not a number.
                near[i] = if a > near[i] { a } else { near[i] };
                far[i] = if b < far[i] { b } else { far[i] };
            }
        }
        Lanes::from(array::from_fn(|i| near[i] <= far[i] * WIDENED))
    }
    /// Those that overlap `bounds`.
    #[inline(always)]
    pub fn overlapping(&self, bounds: &OuterBox) -> Lanes {
        let mut overlaps = [false; WIDTH];
        for i in 0..WIDTH {
            let mut over = true;
            for k in 0..3 {
                over &= self.lo[k][i] <= bounds.hi[k];
                over &= self.hi[k][i] >= bounds.lo[k];
            }
            overlaps[i] = over;
        }
        Lanes::from(overlaps)
    }
}

/// Some of eight lanes, a bit for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lanes(u8);

impl From<[bool; WIDTH]> for Lanes {
    #[inline(always)]
    fn from(lanes: [bool; WIDTH]) -> Lanes {
        // Eight bytes of one bit each at once: the factor moves the bit of byte i to place 56 + i.
        let bytes = u64::from_le_bytes(lanes.map(u8::from));
        Lanes((bytes.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8)
    }
}

impl Lanes {
    pub const NONE: Lanes = Lanes(0);

    /// Every `step`-th from `first` on.
    pub fn every(step: usize, first: usize) -> Lanes {
        (first..WIDTH).step_by(step).fold(Lanes::NONE, Lanes::with)
    }
    /// This one too.
    pub fn with(self, lane: usize) -> Lanes {
        Lanes(self.0 | 1 << lane)
    }
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    pub fn and(self, other: Lanes) -> Lanes {
        Lanes(self.0 & other.0)
    }
    /// Those that `keep` confirms.
    pub fn filter(self, keep: impl Fn(usize) -> bool) -> Lanes {
        self.fold(Lanes(0), |kept, lane| Lanes(kept.0 | u8::from(keep(lane)) << lane))
    }
}

impl Iterator for Lanes {
    type Item = usize;
    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lane = self.0.trailing_zeros();
        self.0 &= self.0 - 1;
        Some(lane as usize)
    }
}

/// Who goes through a tree. Not closures: those are not compiled for the processor that calls them.
pub trait Visitor {
    /// Which of a node's eight boxes are wanted; level 0 are the boxes themselves.
    fn enter(&mut self, level: usize, boxes: &Boxes) -> Lanes;
    /// A wanted box.
    fn visit(&mut self, i: usize) -> ControlFlow<()>;
}

/// A tree over boxes, which are named by their place in the order they were given in.
#[derive(Debug)]
pub struct BoxTree {
    /// From the boxes themselves to the root's children.
    levels: Vec<Vec<Boxes>>,
    bounds: OuterBox,
}

impl BoxTree {
    /// A tree over the boxes `boxed(0)` … `boxed(len − 1)`, neighbours near each other.
    pub fn build(len: usize, boxed: impl Fn(usize) -> OuterBox + Sync) -> BoxTree {
        let mut levels = vec![level(len, &boxed)];
        while let Some(below) = levels.last()
            && below.len() > 1
        {
            let next = level(below.len(), &|i| below[i].union());
            levels.push(next);
        }
        let bounds = levels.last().and_then(|top| top.first()).map_or(OuterBox::EMPTY, Boxes::union);
        BoxTree { levels, bounds }
    }

    /// The box around all.
    pub fn bounds(&self) -> &OuterBox {
        &self.bounds
    }

    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(level.as_slice())).sum()
    }

    /// Leads `visitor` to every box below nodes that it enters, in their order, until it breaks.
    #[inline(always)]
    pub fn lead(&self, visitor: &mut impl Visitor) {
        let mut level = self.levels.len() - 1;
        let Some(root) = self.levels[level].first() else { return };
        // Of each level the node that is open, and its children still to come.
        let mut open = [(0, Lanes(0)); MAX_LEVELS];
        open[level].1 = visitor.enter(level, root);
        loop {
            let (node, children) = &mut open[level];
            let Some(lane) = children.next() else {
                level += 1;
                if level == self.levels.len() {
                    return;
                }
                continue;
            };
            let child = *node * WIDTH + lane;
            if level > 0 {
                level -= 1;
                open[level] = (child, visitor.enter(level, &self.levels[level][child]));
            } else if visitor.visit(child).is_break() {
                return;
            }
        }
    }

    /// Leads `visit` to the boxes that the ray may meet, in their order.
    #[inline(always)]
    pub fn along(&self, ray: &SlabRay, visit: impl FnMut(usize)) {
        struct Along<'a, F>(&'a SlabRay, F);
        impl<F: FnMut(usize)> Visitor for Along<'_, F> {
            #[inline(always)]
            fn enter(&mut self, _: usize, boxes: &Boxes) -> Lanes {
                boxes.met(self.0)
            }
            #[inline(always)]
            fn visit(&mut self, i: usize) -> ControlFlow<()> {
                (self.1)(i);
                ControlFlow::Continue(())
            }
        }
        self.lead(&mut Along(ray, visit));
    }

    /// Leads `visit` to the boxes that may overlap the one around a place, in their order.
    pub fn around(&self, place: OuterBox, visit: impl FnMut(usize)) {
        struct Around<F>(OuterBox, F);
        impl<F: FnMut(usize)> Visitor for Around<F> {
            fn enter(&mut self, _: usize, boxes: &Boxes) -> Lanes {
                boxes.overlapping(&self.0)
            }
            fn visit(&mut self, i: usize) -> ControlFlow<()> {
                (self.1)(i);
                ControlFlow::Continue(())
            }
        }
        self.lead(&mut Around(place, visit));
    }

    /// Whether one of the boxes overlaps `bounds`.
    pub fn any_overlaps(&self, bounds: &OuterBox) -> bool {
        struct Any<'a>(&'a OuterBox, bool);
        impl Visitor for Any<'_> {
            fn enter(&mut self, _: usize, boxes: &Boxes) -> Lanes {
                boxes.overlapping(self.0)
            }
            fn visit(&mut self, _: usize) -> ControlFlow<()> {
                self.1 = true;
                ControlFlow::Break(())
            }
        }
        let mut any = Any(bounds, false);
        self.lead(&mut any);
        any.1
    }

    /// Every box that may overlap one of `others`', in their order.
    pub fn over(&self, others: &BoxTree) -> Vec<usize> {
        struct Over<'a>(&'a BoxTree, Vec<usize>);
        impl Visitor for Over<'_> {
            fn enter(&mut self, level: usize, boxes: &Boxes) -> Lanes {
                let near = boxes.overlapping(self.0.bounds());
                // The boxes themselves are left to the caller, who asks more precisely.
                if level == 0 { near } else { near.filter(|lane| self.0.any_overlaps(&boxes.get(lane))) }
            }
            fn visit(&mut self, i: usize) -> ControlFlow<()> {
                self.1.push(i);
                ControlFlow::Continue(())
            }
        }
        let mut over = Over(others, Vec::new());
        self.lead(&mut over);
        over.1
    }
}

/// `len` boxes by eights; the last eight are filled up with empty ones.
fn level(len: usize, boxed: &(impl Fn(usize) -> OuterBox + Sync)) -> Vec<Boxes> {
    let nodes = len.div_ceil(WIDTH);
    let node = |k: usize| {
        Boxes::from_fn(|lane| {
            let i = k * WIDTH + lane;
            if i < len { boxed(i) } else { OuterBox::EMPTY }
        })
    };
    if nodes < PARALLEL_FROM { (0..nodes).map(node).collect() } else { (0..nodes).into_par_iter().map(node).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Purpose, Stream};

    fn boxes(n: usize, size: f64, seed: u64) -> Vec<OuterBox> {
        let mut s = Stream::new(seed, Purpose::Test, 0, 0);
        (0..n)
            .map(|_| {
                let p = Point3::new(s.uniform(), s.uniform(), 0.2 * s.uniform());
                OuterBox::new(p, Vec3::new(s.uniform(), s.uniform(), s.uniform()) * size)
            })
            .collect()
    }
    fn tree(boxes: &[OuterBox]) -> BoxTree {
        BoxTree::build(boxes.len(), |i| boxes[i])
    }
    #[test]
    fn all_that_overlap_are_visited_once_and_in_order() {
        for n in [0, 1, 7, 8, 9, 64, 65, 500, 5000] {
            let footprints = boxes(n, 0.1, 2);
            let tree = tree(&footprints);
            for point in boxes(50, 0.01, 1) {
                let expected: Vec<usize> = (0..n).filter(|&j| footprints[j].overlaps(&point)).collect();
                let found = tree.over(&BoxTree::build(1, |_| point));
                assert_eq!(found, expected);
                assert_eq!(tree.any_overlaps(&point), !expected.is_empty());
            }
        }
    }

    /// A ray meets the boxes that some point of it is in, and no empty one.
    #[test]
    fn a_ray_meets_all_boxes_that_it_goes_through() {
        let (n, mut s) = (501, Stream::new(4, Purpose::Test, 0, 0));
        let all = boxes(n, 0.1, 2);
        let tree = tree(&all);
        struct Met<'a>(&'a SlabRay, Vec<usize>);
        impl Visitor for Met<'_> {
            fn enter(&mut self, _: usize, boxes: &Boxes) -> Lanes {
                boxes.met(self.0)
            }
            fn visit(&mut self, i: usize) -> ControlFlow<()> {
                self.1.push(i);
                ControlFlow::Continue(())
            }
        }
        for k in 0..100 {
            let mut number = || 2.0 * s.uniform() - 1.0;
            let (origin, along) = (Point3::new(number(), number(), number()), Vec3::new(number(), number(), number()));
            let w = Dir3::new(if k % 3 == 0 { Vec3::X } else { along }).expect("a direction");
            let half = if k % 2 == 0 { Vec3::ZERO } else { Vec3::new(0.1, 0.0, 0.02) };
            let ray = SlabRay::new(origin, w, 2.0, half);
            let mut met = Met(&ray, Vec::new());
            tree.lead(&mut met);
            assert!(met.1.windows(2).all(|w| w[0] < w[1]) && met.1.iter().all(|&i| i < n));
            for step in 0..2000 {
                let p = OuterBox::new(origin + w * (f64::from(step) * 1e-3), half);
                let within = |b: &OuterBox| (0..3).all(|k| b.lo[k] < p.hi[k] && p.lo[k] < b.hi[k]);
                assert!((0..n).filter(|&i| within(&all[i])).all(|i| met.1.contains(&i)), "ray {k}, step {step}");
            }
        }
    }

    #[test]
    fn a_tree_over_a_tree_misses_no_pair() {
        for (n, m) in [(0, 5), (5, 0), (1, 1), (300, 500)] {
            let (points, footprints) = (boxes(n, 0.0, 1), boxes(m, 0.1, 2));
            let found = tree(&footprints).over(&tree(&points));
            assert!(found.windows(2).all(|w| w[0] < w[1]), "out of order");
            let wanted = |j: &usize| points.iter().any(|point| point.overlaps(&footprints[*j]));
            assert!((0..m).filter(wanted).all(|j| found.contains(&j)));
        }
    }

    #[test]
    fn the_index_takes_less_than_32_bytes_a_box() {
        assert!(tree(&boxes(10_000, 0.1, 3)).bytes() < 32 * 10_000);
    }
}
