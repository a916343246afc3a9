//! A light chosen among many by what may arrive from it: a binary tree of bounds, walked from the root by the importance of
//! both halves [ContyKulla18], as pbrt's `BVHLightSampler` does.

use super::bounds::{LightBounds, Receiver};
use super::select::LightChoice;
use crate::math::Bounds3;
use crate::radiometry::Pmf;
use crate::sampling::discrete::BELOW_ONE;
use crate::scene::LightId;

/// Parts of an axis between which halves are parted.
const BUCKETS: usize = 12;
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    /// The place of the first half; the other is behind it.
    Halves(u32),
    Light(LightId),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    bounds: LightBounds,
    content: Content,
    parent: u32,
}

/// The tree. Halves stand beside each other, at odd places and behind them; the root is first.
#[derive(Clone, Debug, PartialEq)]
pub struct LightTree {
    nodes: Vec<Node>,
    /// Place of each light's leaf, by its id; `None` for lights that are not in the tree.
    leaves: Vec<Option<u32>>,
}

type Placed = (LightId, LightBounds);

impl LightTree {
    /// Of lights that send something; `None` without any.
    pub fn new(lights: Vec<Placed>) -> Option<LightTree> {
        let most = lights.iter().map(|(light, _)| light.index()).max()?;
        let all = together(&lights)?;
        let placeholder = Node { bounds: all, content: Content::Halves(0), parent: 0 };
        let mut tree = LightTree { nodes: vec![placeholder], leaves: vec![None; most + 1] };
        let mut open = vec![(0, lights)];
        while let Some((place, lights)) = open.pop() {
            if let [(light, bounds)] = lights[..] {
                (tree.nodes[place].bounds, tree.nodes[place].content) = (bounds, Content::Light(light));
                tree.leaves[light.index()] = Some(place as u32);
                continue;
            }
            let halves = parted(lights);
            let first = tree.nodes.len();
            tree.nodes[place].content = Content::Halves(first as u32);
            for (k, half) in halves.into_iter().enumerate() {
                let bounds = together(&half).unwrap_or(all);
                tree.nodes.push(Node { bounds, parent: place as u32, ..placeholder });
                open.push((first + k, half));
            }
        }
        Some(tree)
    }

    /// A light by what may arrive from it, or by its power among those that the bounds of all did not exclude but their own do.
    pub fn pick(&self, at: &Receiver, mut u: f64) -> LightChoice {
        let (mut place, mut pmf) = (0, 1.0);
        loop {
            match self.nodes[place].content {
                Content::Light(light) => return LightChoice { light, pmf: Pmf(pmf), reused: u },
                Content::Halves(first) => {
                    let first_part = self.first_part(first as usize, at);
                    let (part, half) = if u < first_part {
                        u /= first_part;
                        (first_part, 0)
                    } else {
                        u = (u - first_part) / (1.0 - first_part);
                        (1.0 - first_part, 1)
                    };
                    (place, pmf, u) = (first as usize + half, pmf * part, u.clamp(0.0, BELOW_ONE));
                }
            }
        }
    }

    /// The probability with which [`LightTree::pick`] chooses `light`.
    pub fn pmf(&self, at: &Receiver, light: LightId) -> Pmf {
        let Some(mut place) = self.leaves.get(light.index()).copied().flatten().map(|place| place as usize) else {
            return Pmf(0.0);
        };
        let mut pmf = 1.0;
        while place > 0 {
            let first = (place - 1) / 2 * 2 + 1;
            let part = self.first_part(first, at);
            pmf *= if place == first { part } else { 1.0 - part };
            place = self.nodes[place].parent as usize;
        }
        Pmf(pmf)
    }

    /// The probability of the first of two halves.
    fn first_part(&self, first: usize, at: &Receiver) -> f64 {
        let halves = [0, 1].map(|half| &self.nodes[first + half].bounds);
        let [a, b] = match halves.map(|half| half.importance(at)) {
            [0.0, 0.0] => halves.map(|half| half.power),
            important => important,
        };
        a / (a + b)
    }
}

fn together(lights: &[Placed]) -> Option<LightBounds> {
    lights.iter().map(|(_, bounds)| *bounds).reduce(LightBounds::union)
}

/// In two, between the buckets along an axis where both cost least; in the middle of the list where all stand at one place.
fn parted(mut lights: Vec<Placed>) -> [Vec<Placed>; 2] {
    let centres = Bounds3::from_points(lights.iter().map(|(_, light)| light.bounds.centre()));
    let (low, extent) = (centres.min.to_array(), centres.diagonal());
    let widest = extent.max_element();
    let bucket = |light: &LightBounds, axis: usize| {
        let t = (light.bounds.centre().to_array()[axis] - low[axis]) / extent[axis];
        ((t * BUCKETS as f64) as usize).min(BUCKETS - 1)
    };
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
        for (_, light) in &lights {
            let sum = &mut buckets[bucket(light, axis)];
            *sum = Some(sum.map_or(*light, |sum| sum.union(*light)));
        }
        let union = |part: &[Option<LightBounds>]| part.iter().flatten().copied().reduce(LightBounds::union);
        // Long boxes are parted across.
        let slender = widest / extent[axis];
        for cut in 1..BUCKETS {
            let (Some(a), Some(b)) = (union(&buckets[..cut]), union(&buckets[cut..])) else { continue };
            let cost = slender * (a.cost() + b.cost());
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, cut));
            }
        }
    }
    match best {
        Some((_, axis, cut)) => {
            let (a, b) = lights.into_iter().partition(|(_, light)| bucket(light, axis) < cut);
            [a, b]
        }
        None => {
            let rest = lights.split_off(lights.len() / 2);
            [lights, rest]
        }
    }
}
