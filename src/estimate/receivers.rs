//! Points that ask for light, packed by eights: what the inner loop reads of them, number by number.

use std::array;

use super::gather::{GatherPoint, Gathered};
use crate::math::{Bounds3, Normal3, Point3, Vec3};
use crate::photon::index::{BoxTree, Lanes, OuterBox, WIDTH};
use crate::photon::order::ZCurve;
use crate::radiometry::{Radiance, Spectrum};

/// One number of each of eight points.
pub type Eight = [f32; WIDTH];
/// One vector of each, coordinate by coordinate.
pub type Vec3Eight = [Eight; 3];

/// Points in the order of a curve through space, and a tree over their blocks.
pub struct Receivers<'a> {
    /// In the order they were given in.
    points: &'a [&'a GatherPoint],
    /// Which of them stands in each lane, block after block.
    order: Vec<u32>,
    pub blocks: Vec<Block>,
    pub sums: Vec<Sums>,
    /// Pairs of a photon and a point so far.
    pub weighed: u64,
    pub tree: BoxTree,
}

/// Eight points near each other. Lanes without a point are too far away for any light.
#[repr(align(32))]
pub struct Block {
    /// Positions are relative to it, so that single precision is enough for them.
    pub origin: Point3,
    pub p: Vec3Eight,
    pub ng: Vec3Eight,
    /// 1 where `wo` is on the outer side, else −1.
    pub side: Eight,
    /// Turned to the side of `wo`.
    pub ns: Vec3Eight,
    pub eye: [Vec3Eight; 2],
    /// Squares of semi-axes that the eye footprints do not exceed, m².
    pub widest_eye: Eight,
    /// The BSDF's value, where it is the same for all directions of light; else 0.
    pub f: [Eight; 3],
    /// Lanes where it is not.
    pub uneven: Lanes,
}

/// What has been gathered for a block.
#[derive(Clone, Default)]
pub struct Sums {
    pub radiance: [[f64; WIDTH]; 3],
    pub density: [f64; WIDTH],
}

/// Further away than any photon can reach, and still a number whose square is one.
const NOWHERE: f32 = 1e18;

impl<'a> Receivers<'a> {
    pub fn new(points: &'a [&'a GatherPoint]) -> Receivers<'a> {
        let order = curve_order(points);
        let lanes: Vec<&[u32]> = order.chunks(WIDTH).collect();
        let block = |lanes: &&[u32]| {
            let of: Vec<&GatherPoint> = lanes.iter().map(|&i| points[i as usize]).collect();
            Block::new(&of)
        };
        let boxed = |lanes: &[u32]| {
            let boxes = lanes.iter().map(|&i| points[i as usize].outer_box());
            boxes.fold(OuterBox::EMPTY, OuterBox::union)
        };
        Receivers {
            blocks: lanes.iter().map(block).collect(),
            sums: vec![Sums::default(); lanes.len()],
            weighed: 0,
            tree: BoxTree::build(lanes.len(), |b| boxed(lanes[b])),
            order,
            points,
        }
    }

    /// The point in a lane of a block.
    pub fn point(&self, block: usize, lane: usize) -> &GatherPoint {
        self.points[self.order[block * WIDTH + lane] as usize]
    }

    /// What was gathered for each point, in the order they were given in.
    pub fn gathered(&self) -> Vec<Gathered> {
        let mut gathered = vec![Gathered::default(); self.points.len()];
        for (place, &i) in self.order.iter().enumerate() {
            let (sums, lane) = (&self.sums[place / WIDTH], place % WIDTH);
            let radiance = Radiance(Spectrum::from(sums.radiance.map(|channel| channel[lane])));
            gathered[i as usize] = Gathered { radiance, density: sums.density[lane] };
        }
        gathered
    }
}

impl Block {
    /// At most eight points.
    fn new(points: &[&GatherPoint]) -> Block {
        let origin = points[0].p;
        let lanes = |number: &dyn Fn(&GatherPoint) -> f64, absent: f32| -> Eight {
            array::from_fn(|lane| points.get(lane).map_or(absent, |point| number(point) as f32))
        };
        let vectors = |vector: &dyn Fn(&GatherPoint) -> Vec3, absent: f32| -> Vec3Eight {
            array::from_fn(|k| lanes(&|point| vector(point)[k], absent))
        };
        let side = |point: &GatherPoint, n: Normal3| 1.0f64.copysign(n.dot(point.wo));
        let even: Vec<Option<Spectrum>> = points.iter().map(|point| point.bsdf.even_value(point.wo)).collect();
        let value = |lane: usize| even.get(lane).copied().flatten().unwrap_or(Spectrum::BLACK).to_array();
        Block {
            origin,
            p: vectors(&|point| point.p - origin, NOWHERE),
            ng: vectors(&|point| point.ng.to_vec(), 0.0),
            side: lanes(&|point| side(point, point.ng), 0.0),
            ns: vectors(&|point| point.ns * side(point, point.ns), 0.0),
            eye: array::from_fn(|k| vectors(&|point| point.eye[k], 0.0)),
            widest_eye: lanes(&|point| point.eye.iter().map(|axis| axis.length_squared()).sum(), 0.0),
            f: array::from_fn(|k| array::from_fn(|lane| value(lane)[k] as f32)),
            uneven: Lanes::from(array::from_fn(|lane| even.get(lane).is_some_and(Option::is_none))),
        }
    }
}

fn curve_order(points: &[&GatherPoint]) -> Vec<u32> {
    let curve = ZCurve::through(&Bounds3::from_points(points.iter().map(|point| point.p)));
    let mut keyed: Vec<(u64, u32)> = (0..).zip(points).map(|(i, point)| (curve.code(point.p), i)).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}
