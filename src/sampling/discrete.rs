//! Choices with given probabilities: a table over one number (lights by power), and a mosaic over the unit square
//! (triangles by area).
//!
//! Both keep the position within the chosen piece as a fresh uniform number, so that one well-spread pattern serves
//! the choice and what follows it.

use crate::radiometry::Pmf;

/// The largest `f64` below 1, so that a reused number stays in [0, 1).
pub const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Sum of the weights if all are finite, none is negative and some is positive.
fn sound_total(weights: &[f64]) -> Option<f64> {
    let total: f64 = weights.iter().sum();
    (weights.iter().all(|w| *w >= 0.0) && total > 0.0 && total.is_finite()).then_some(total)
}

/// A chosen entry of a [`DiscreteTable`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscreteSample {
    pub index: usize,
    pub pmf: Pmf,
    /// Where in its interval the number fell, uniform in [0, 1). Its derivative by the number is 1/pmf.
    pub reused: f64,
}

/// Entries by cumulated probability.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscreteTable {
    /// Upper bound of each entry's interval; the last is exactly 1.
    cumulated: Vec<f64>,
}

impl DiscreteTable {
    /// Probabilities in proportion to the weights; `None` without a positive weight or with one that is negative or
    /// not finite.
    pub fn new(weights: &[f64]) -> Option<DiscreteTable> {
        let total = sound_total(weights)?;
        let mut sum = 0.0;
        let mut cumulated: Vec<f64> = weights
            .iter()
            .map(|w| {
                sum += w;
                (sum / total).min(1.0)
            })
            .collect();
        // Rounding must not leave a gap below 1, nor give trailing entries of weight zero a share.
        let last = weights.iter().rposition(|w| *w > 0.0)?;
        cumulated[last..].fill(1.0);
        Some(DiscreteTable { cumulated })
    }

    pub fn len(&self) -> usize {
        self.cumulated.len()
    }
    pub fn is_empty(&self) -> bool {
        self.cumulated.is_empty()
    }

    /// The interval of entry `index`.
    fn interval(&self, index: usize) -> (f64, f64) {
        (if index == 0 { 0.0 } else { self.cumulated[index - 1] }, self.cumulated[index])
    }

    /// Probability of entry `index`, zero out of range.
    pub fn pmf(&self, index: usize) -> Pmf {
        if index >= self.len() {
            return Pmf(0.0);
        }
        let (low, high) = self.interval(index);
        Pmf(high - low)
    }

    /// The entry whose interval holds `u` in [0, 1).
    pub fn sample(&self, u: f64) -> DiscreteSample {
        let index = self.cumulated.partition_point(|&c| c <= u).min(self.len() - 1);
        let (low, high) = self.interval(index);
        DiscreteSample { index, pmf: Pmf(high - low), reused: ((u - low) / (high - low)).clamp(0.0, BELOW_ONE) }
    }

    /// The number that chooses `index` and is reused as `reused`; `None` for an entry of probability zero.
    pub fn inverse(&self, index: usize, reused: f64) -> Option<f64> {
        if self.pmf(index).0 <= 0.0 {
            return None;
        }
        let (low, high) = self.interval(index);
        Some(low + reused * (high - low))
    }
}

/// An axis-aligned piece of the unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tile {
    min: [f64; 2],
    size: [f64; 2],
}

/// Where a mosaic was cut: along `axis` at `at`; the entries before `middle` lie below.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    axis: usize,
    at: f64,
    middle: usize,
    /// Index of the cut of the upper half; the lower half's cut follows this one.
    upper: usize,
}

/// A chosen entry of a [`Mosaic`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MosaicSample {
    pub index: usize,
    pub pmf: Pmf,
    /// Where in its tile the point fell, uniform in [0, 1)².
    pub reused: [f64; 2],
    /// ∂reused/∂u for each of the two axes; their product is 1/pmf.
    pub stretch: [f64; 2],
}

/// The unit square cut into one rectangle for each entry, with areas in proportion to the weights and sides as even
/// as halving along the longer side makes them.
///
/// A table over one coordinate would stretch that coordinate alone by 1/pmf: the differentials of light from a mesh
/// of many triangles would be needles. Here both are stretched about equally.
#[derive(Clone, Debug, PartialEq)]
pub struct Mosaic {
    cuts: Vec<Cut>,
    tiles: Vec<Tile>,
    /// Entries of positive weight, in the order of the tiles.
    entries: Vec<usize>,
    /// Tile of each entry.
    tile_of: Vec<Option<usize>>,
}

impl Mosaic {
    /// As [`DiscreteTable::new`].
    pub fn new(weights: &[f64]) -> Option<Mosaic> {
        sound_total(weights)?;
        let entries: Vec<usize> = (0..weights.len()).filter(|&i| weights[i] > 0.0).collect();
        let mut tile_of = vec![None; weights.len()];
        for (tile, &entry) in entries.iter().enumerate() {
            tile_of[entry] = Some(tile);
        }
        let whole = Tile { min: [0.0; 2], size: [1.0; 2] };
        let mut mosaic =
            Mosaic { cuts: Vec::with_capacity(entries.len()), tiles: vec![whole; entries.len()], entries, tile_of };
        mosaic.divide(weights, 0, mosaic.entries.len(), whole);
        Some(mosaic)
    }

    /// Cuts `tile` for the entries [low, high), halving the weight as nearly as the order of entries allows. The sums
    /// are taken anew in every piece, so that entries far smaller than the whole keep their proportions.
    fn divide(&mut self, weights: &[f64], low: usize, high: usize, tile: Tile) {
        if high - low == 1 {
            self.tiles[low] = tile;
            return;
        }
        let total: f64 = self.entries[low..high].iter().map(|&i| weights[i]).sum();
        let (mut middle, mut below) = (low + 1, weights[self.entries[low]]);
        // Take one more entry while that brings the lower part nearer to the half.
        while middle < high - 1 && 2.0 * below + weights[self.entries[middle]] < total {
            below += weights[self.entries[middle]];
            middle += 1;
        }
        let share = below / total;
        let axis = usize::from(tile.size[1] > tile.size[0]);
        let (mut lower, mut upper) = (tile, tile);
        lower.size[axis] = tile.size[axis] * share;
        upper.min[axis] = tile.min[axis] + lower.size[axis];
        upper.size[axis] = tile.size[axis] * (1.0 - share);
        let own = self.cuts.len();
        self.cuts.push(Cut { axis, at: upper.min[axis], middle, upper: 0 });
        self.divide(weights, low, middle, lower);
        self.cuts[own].upper = self.cuts.len();
        self.divide(weights, middle, high, upper);
    }

    /// The entry whose tile holds `u` in [0, 1)².
    pub fn sample(&self, u: [f64; 2]) -> MosaicSample {
        let (mut low, mut high, mut at) = (0, self.tiles.len(), 0);
        while high - low > 1 {
            let cut = self.cuts[at];
            if u[cut.axis] < cut.at {
                (high, at) = (cut.middle, at + 1);
            } else {
                (low, at) = (cut.middle, cut.upper);
            }
        }
        let Tile { min, size } = self.tiles[low];
        let reused = std::array::from_fn(|k| ((u[k] - min[k]) / size[k]).clamp(0.0, BELOW_ONE));
        MosaicSample { index: self.entries[low], pmf: Pmf(size[0] * size[1]), reused, stretch: size.map(|s| 1.0 / s) }
    }

    /// Probability of entry `index`, zero out of range.
    pub fn pmf(&self, index: usize) -> Pmf {
        Pmf(self.tile(index).map_or(0.0, |tile| tile.size[0] * tile.size[1]))
    }

    /// The point that chooses `index` and is reused as `reused`; `None` for an entry of probability zero.
    pub fn inverse(&self, index: usize, reused: [f64; 2]) -> Option<[f64; 2]> {
        let Tile { min, size } = self.tile(index)?;
        Some(std::array::from_fn(|k| min[k] + reused[k] * size[k]))
    }

    fn tile(&self, index: usize) -> Option<Tile> {
        self.tile_of.get(index).copied().flatten().map(|tile| self.tiles[tile])
    }
}
