//! All photons of a pass.

use std::ops::Range;
use std::sync::atomic::AtomicU64;

use rayon::prelude::*;

use super::index::{BoxTree, OuterBox, WIDTH};
use super::order::{self, ZCurve};
use super::path::PhotonCounts;
use super::record::Photon;
use crate::math::{Bounds3, Vec3};
use crate::radiometry::Flux;
use crate::scene::LightId;

/// Footprints over a point that a stratum keeps: their mean is then known to some ten per cent. Fewer would part a
/// lattice's photons, whose evenness needs all of them at one point, among a pixel's samples.
const STRATUM_COVERAGE: f64 = 64.0;
/// At most so many strata.
const MAX_STRATA: usize = 32;
/// Footprints over a point that a slice of a stratum keeps: a quarter of their light is noise, less than a diffuse bounce
/// has by itself.
const SLICE_COVERAGE: f64 = 16.0;
/// Photons at which coverage is measured, and photons whose footprints are tried there.
const COVERAGE_PROBES: usize = 256;
const COVERAGE_SAMPLE: usize = 16_384;

/// The photons of a pass, those of about the same size and place together, and trees over their footprints.
///
/// Where many footprints lie over every point they are dealt out to strata, each a map of its own with every m-th photon.
#[derive(Debug)]
pub struct PhotonMap {
    /// Stratum after stratum.
    pub photons: Vec<Photon>,
    pub counts: PhotonCounts,
    /// What became of each light's photons, in the order of the scene's lights.
    pub by_light: Vec<PhotonCounts>,
    strata: Vec<Stratum>,
    slices: usize,
    /// Pairs of a photon and a point that the estimate has weighed so far: what the work was.
    pub weighed: AtomicU64,
}

/// Some of the photons, spread over all.
#[derive(Debug)]
pub struct Stratum {
    /// Which of the map's.
    photons: Range<usize>,
    /// Over their footprints.
    pub tree: BoxTree,
}

/// Photons that come in while a pass is traced, in any order.
#[derive(Debug)]
pub struct PhotonHarvest {
    photons: Vec<Photon>,
    counts: PhotonCounts,
    by_light: Vec<PhotonCounts>,
    whole: bool,
}

impl PhotonHarvest {
    /// None yet, of so many lights.
    pub fn new(lights: usize) -> PhotonHarvest {
        let (photons, counts) = (Vec::new(), PhotonCounts::default());
        PhotonHarvest { photons, counts, by_light: vec![PhotonCounts::default(); lights], whole: false }
    }

    /// Of photons that are not to be dealt out to strata: one sheet of an even pattern, which strata would tear.
    pub fn whole(self, whole: bool) -> PhotonHarvest {
        PhotonHarvest { whole, ..self }
    }

    /// A unit's photons.
    pub fn add(&mut self, light: LightId, stored: Vec<Photon>, counts: &PhotonCounts) {
        self.photons.extend(stored);
        self.by_light[light.index()].merge(counts);
        self.counts.merge(counts);
    }

    /// The map of all; the same whatever order they came in.
    pub fn into_map(self) -> PhotonMap {
        let PhotonHarvest { mut photons, counts, by_light, whole } = self;
        let ranks = ranks(&photons);
        let coverage = coverage(&photons, &ranks);
        let m = if whole { 1 } else { strata_for(coverage) };
        let ends: Vec<usize> = (0..=m).map(|k| first_of_stratum(photons.len(), m, k)).collect();
        arrange(&mut photons, |place| {
            let k = ends.partition_point(|&end| end <= place) - 1;
            ranks[(place - ends[k]) * m + k] as usize
        });
        drop(ranks);
        let stratum = |range: Range<usize>| {
            let own = &photons[range.clone()];
            Stratum { photons: range, tree: BoxTree::build(own.len(), |i| footprint_box(&own[i])) }
        };
        let strata = ends.windows(2).map(|w| stratum(w[0]..w[1])).collect();
        let slices = slices_for(coverage / m as f64);
        PhotonMap { photons, counts, by_light, strata, slices, weighed: AtomicU64::new(0) }
    }
}

impl PhotonMap {
    /// The map of a scene that cannot make caustics.
    pub fn empty(lights: usize) -> PhotonMap {
        PhotonHarvest::new(lights).into_map()
    }

    /// Trees over the footprints, none of which is in two.
    pub fn strata(&self) -> &[Stratum] {
        &self.strata
    }

    /// How many slices a stratum has: lane l of all nodes of its tree belongs to slice l modulo this, of 1, 2, 4 or 8.
    pub fn slices(&self) -> usize {
        self.slices
    }

    /// Of all photons.
    pub fn flux(&self) -> Flux {
        self.photons.iter().map(Photon::flux).sum()
    }

    /// Bytes of photons and trees.
    pub fn bytes(&self) -> usize {
        let trees: usize = self.strata.iter().map(|stratum| stratum.tree.bytes()).sum();
        trees + size_of_val(self.photons.as_slice())
    }

    /// What a stratum's tree counts from 0 on.
    pub fn photons_of(&self, stratum: &Stratum) -> &[Photon] {
        &self.photons[stratum.photons.clone()]
    }
}

/// Where stratum `k` of `m` begins when `n` photons are dealt out to them in turn.
fn first_of_stratum(n: usize, m: usize, k: usize) -> usize {
    n / m * k + k.min(n % m)
}

/// The photons' indices in the map's order: by the size of their footprints in powers of four, then along a curve through
/// space. Photons in the same place are told apart by what they are, so that the order they came in does not matter.
fn ranks(photons: &[Photon]) -> Vec<u32> {
    let bounds = Bounds3::from_points(photons.iter().map(Photon::position));
    let curve = ZCurve::through(&bounds);
    let key = |photon: &Photon| {
        // The exponent without its last bit: of the sign, which is 0, and the eight bits of the exponent seven stay.
        let size = u64::from(footprint_box(photon).half_width().to_bits() >> 24);
        size << order::CODE_BITS | curve.code(photon.position())
    };
    let mut keyed: Vec<(u64, u32)> =
        (0..photons.len() as u32).into_par_iter().map(|i| (key(&photons[i as usize]), i)).collect();
    keyed.par_sort_unstable_by(|a, b| {
        a.0.cmp(&b.0).then_with(|| photons[a.1 as usize].bits().cmp(&photons[b.1 as usize].bits()))
    });
    keyed.into_iter().map(|(_, i)| i).collect()
}

/// Puts into each place the item that was at `source(place)`, a permutation, without a second list.
fn arrange<T: Copy>(items: &mut [T], source: impl Fn(usize) -> usize) {
    let mut done = vec![false; items.len()];
    for start in 0..items.len() {
        if done[start] {
            continue;
        }
        let first = items[start];
        let mut place = start;
        loop {
            done[place] = true;
            let from = source(place);
            if from == start {
                items[place] = first;
                break;
            }
            items[place] = items[from];
            place = from;
        }
    }
}

/// How many strata keep [`STRATUM_COVERAGE`] footprints over a point.
fn strata_for(coverage: f64) -> usize {
    ((coverage / STRATUM_COVERAGE) as usize).clamp(1, MAX_STRATA)
}

/// How many slices of a stratum keep [`SLICE_COVERAGE`] footprints over a point.
fn slices_for(coverage: f64) -> usize {
    1 << ((coverage / SLICE_COVERAGE) as usize).clamp(1, WIDTH).ilog2()
}

/// About the mean number of footprint boxes over a photon.
fn coverage(photons: &[Photon], ranks: &[u32]) -> f64 {
    let every = |n: usize| ranks.iter().step_by(ranks.len().div_ceil(n).max(1)).map(|&i| &photons[i as usize]);
    let boxes: Vec<OuterBox> = every(COVERAGE_SAMPLE).map(footprint_box).collect();
    let over = |photon: &Photon| {
        let place = OuterBox::new(photon.position(), Vec3::ZERO);
        boxes.iter().filter(|footprint| footprint.overlaps(&place)).count()
    };
    let counts: Vec<usize> = every(COVERAGE_PROBES).map(over).collect();
    let mean = counts.iter().sum::<usize>() as f64 / counts.len().max(1) as f64;
    mean * photons.len() as f64 / boxes.len().max(1) as f64
}

/// Around every point that the footprint may light: the ellipse, and what slides into it from both sides.
fn footprint_box(photon: &Photon) -> OuterBox {
    let ellipse = photon.outer_form().world_half_extents(&photon.frame());
    OuterBox::new(photon.position(), ellipse + photon.slide().abs() * photon.thickness())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Dir3, Normal3, Point3};
    use crate::photon::footprint::TangentForm;
    use crate::radiometry::{Flux, Spectrum};
    use crate::sampling::{Purpose, Stream};

    fn photons(n: usize, width: f64) -> Vec<Photon> {
        let mut s = Stream::new(8, Purpose::Test, 0, 0);
        let mut photon = || {
            let p = Point3::new(s.uniform(), s.uniform(), 0.0);
            let axis = width * 10f64.powf(s.uniform());
            let form = TangentForm { xx: axis * axis, xy: 0.0, yy: axis * axis };
            Photon::new(p, Dir3::Z, Normal3::Z, Flux(Spectrum::ONE), form, 0)
        };
        (0..n).map(|_| photon()).collect()
    }

    fn map(units: &[Vec<Photon>]) -> PhotonMap {
        let mut harvest = PhotonHarvest::new(1);
        units.iter().for_each(|unit| harvest.add(LightId(0), unit.clone(), &PhotonCounts::default()));
        harvest.into_map()
    }

    #[test]
    fn the_order_that_units_come_in_does_not_matter() {
        let all = photons(1000, 0.001);
        let units: Vec<Vec<Photon>> = all.chunks(77).map(<[_]>::to_vec).collect();
        // One photon twice: nothing but what they are tells them apart.
        let twice = [units.clone(), vec![vec![all[3]]]].concat();
        let backwards: Vec<Vec<Photon>> = twice.iter().rev().cloned().collect();
        assert_eq!(map(&twice).photons, map(&backwards).photons);
    }

    #[test]
    fn strata_share_the_photons_out() {
        for (n, width) in [(0, 0.1), (1, 0.1), (5, 0.1), (1000, 0.1), (1001, 0.1), (1003, 0.001)] {
            let map = map(&[photons(n, width)]);
            let lengths: Vec<usize> = map.strata().iter().map(|stratum| map.photons_of(stratum).len()).collect();
            assert_eq!(lengths.iter().sum::<usize>(), n);
            assert!(lengths.iter().all(|l| l.abs_diff(lengths[0]) <= 1), "{lengths:?}");
            let sorted = |photons: &[Photon]| {
                let mut bits: Vec<_> = photons.iter().map(Photon::bits).collect();
                bits.sort_unstable();
                bits
            };
            assert_eq!(sorted(&map.photons), sorted(&photons(n, width)), "photons were lost or made");
        }
        assert!(map(&[photons(1000, 0.1)]).strata().len() > 4, "wide footprints are worth strata");
        let mut sheet = PhotonHarvest::new(1).whole(true);
        sheet.add(LightId(0), photons(1000, 0.1), &PhotonCounts::default());
        assert_eq!(sheet.into_map().strata().len(), 1);
    }

    #[test]
    fn arranging_is_what_copying_would_be() {
        let source = [3usize, 0, 2, 4, 1];
        let mut items = [10, 11, 12, 13, 14];
        arrange(&mut items, |place| source[place]);
        assert_eq!(items, [13, 10, 12, 14, 11]);
    }
}
