//! Points that ask for light, packed by eights: what the inner loop reads of them, number by number.

use super::gather::{Asks, GatherPoint, Gathered};
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
    points: &'a [GatherPoint],
    /// Which of them stands in each lane, block after block.
    order: Vec<u32>,
    pub blocks: Vec<Block>,
    pub sums: Vec<Sums>,
    /// Pairs of a photon and a point so far.
    pub weighed: u64,
    pub tree: BoxTree,
    /// Of all blocks.
    pub shared_range: [f32; 2],
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
    /// Whether both normals are one and the same in all lanes.
    pub smooth: bool,
    pub eye: [Vec3Eight; 2],
    /// Squares of semi-axes that the eye footprints do not exceed, m².
    pub widest_eye: Eight,
    /// Footprints whose shorter semi-axis, squared, is above this are wide ones: the samples of a pixel share them; m².
    pub shared_above: Eight,
    /// The least and the greatest of them.
    pub shared_range: [f32; 2],
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

const NO_RANGE: [f32; 2] = [f32::INFINITY, 0.0];

/// From how many times the eye footprint of a whole pixel on the shorter semi-axis of a footprint is wide: about two
/// pixels. Where in the pixel it is asked then changes its light by a third, random from photon to photon; where there are
/// enough of them to be shared, their number alone makes more noise.
const WIDE: f64 = 2.0;

impl<'a> Receivers<'a> {
    /// Over the `chosen` ones of the points.
    pub fn new(points: &'a [GatherPoint], chosen: Vec<usize>) -> Receivers<'a> {
        let order = curve_order(points, chosen);
        let lanes: Vec<&[u32]> = order.chunks(WIDTH).collect();
        let block = |lanes: &&[u32]| {
            let mut block = Block::around(points[lanes[0] as usize].p);
            for (lane, &i) in lanes.iter().enumerate() {
                block.place(lane, &points[i as usize]);
            }
            block
        };
        let boxed = |lanes: &[u32]| {
            let boxes = lanes.iter().map(|&i| points[i as usize].outer_box());
            boxes.fold(OuterBox::EMPTY, OuterBox::union)
        };
        let blocks: Vec<Block> = lanes.iter().map(block).collect();
        let shared_range = blocks.iter().fold(NO_RANGE, |[low, high], block| {
            let [least, greatest] = block.shared_range;
            [low.min(least), high.max(greatest)]
        });
        Receivers {
            blocks,
            sums: vec![Sums::default(); lanes.len()],
            weighed: 0,
            tree: BoxTree::build(lanes.len(), |b| boxed(lanes[b])),
            order,
            points,
            shared_range,
        }
    }

    /// The point in a lane of a block.
    pub fn point(&self, block: usize, lane: usize) -> &GatherPoint {
        &self.points[self.order[block * WIDTH + lane] as usize]
    }

    /// How many of a block's lanes have a point.
    pub fn lanes(&self, block: usize) -> usize {
        (self.order.len() - block * WIDTH).min(WIDTH)
    }

    /// Adds what was gathered for each point, times its weight, to the list of all points.
    pub fn add_to(&self, gathered: &mut [Gathered], weight: impl Fn(&GatherPoint) -> f64) {
        for (place, &i) in self.order.iter().enumerate() {
            let (sums, lane, i) = (&self.sums[place / WIDTH], place % WIDTH, i as usize);
            let weight = weight(&self.points[i]);
            gathered[i].radiance += Radiance(Spectrum::from(sums.radiance.map(|channel| channel[lane])) * weight);
            gathered[i].density += sums.density[lane] * weight;
        }
    }
}

impl Block {
    /// No points, around a place.
    fn around(origin: Point3) -> Block {
        Block {
            origin,
            p: [[NOWHERE; WIDTH]; 3],
            ng: [[0.0; WIDTH]; 3],
            side: [0.0; WIDTH],
            ns: [[0.0; WIDTH]; 3],
            smooth: true,
            eye: [[[0.0; WIDTH]; 3]; 2],
            widest_eye: [0.0; WIDTH],
            shared_above: [0.0; WIDTH],
            shared_range: NO_RANGE,
            f: [[0.0; WIDTH]; 3],
            uneven: Lanes::NONE,
        }
    }

    /// One of at most eight.
    fn place(&mut self, lane: usize, point: &GatherPoint) {
        let set = |vector: &mut Vec3Eight, value: Vec3| {
            for (lanes, coordinate) in vector.iter_mut().zip(value.to_array()) {
                lanes[lane] = coordinate as f32;
            }
        };
        let side = |n: Normal3| 1.0f64.copysign(n.dot(point.wo));
        set(&mut self.p, point.p - self.origin);
        set(&mut self.ng, point.ng.to_vec());
        set(&mut self.ns, point.ns * side(point.ns));
        self.smooth &= point.ns == point.ng;
        set(&mut self.eye[0], point.eye[0]);
        set(&mut self.eye[1], point.eye[1]);
        self.side[lane] = side(point.ng) as f32;
        self.widest_eye[lane] = widest_eye(point) as f32;
        let shared_above = shared_above(point) as f32;
        self.shared_above[lane] = shared_above;
        self.shared_range = [self.shared_range[0].min(shared_above), self.shared_range[1].max(shared_above)];
        match point.bsdf.even_value(point.wo) {
            Some(f) => set(&mut self.f, Vec3::from_array(f.to_array())),
            None => self.uneven = self.uneven.with(lane),
        }
    }
}

/// A bound of the square of the eye footprint's semi-axes, m².
fn widest_eye(point: &GatherPoint) -> f64 {
    point.eye.iter().map(|axis| axis.length_squared()).sum()
}

/// [`Block::shared_above`]: the samples' footprints together cover their pixel.
fn shared_above(point: &GatherPoint) -> f64 {
    let samples = match point.asks {
        Asks::All(turn) => f64::from(turn.of),
        Asks::Drawn { .. } => 1.0,
    };
    WIDE * WIDE * samples * widest_eye(point)
}

fn curve_order(points: &[GatherPoint], chosen: Vec<usize>) -> Vec<u32> {
    let curve = ZCurve::through(&Bounds3::from_points(chosen.iter().map(|&i| points[i].p)));
    let mut keyed: Vec<(u64, u32)> = chosen.into_iter().map(|i| (curve.code(points[i].p), i as u32)).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}
