//! The standard estimate: the k nearest photons in a disc `[Jensen96]`, with any kernel.
//!
//! L(x, wo) = Σ f Φ K(d²/r²)/r², r the distance to the k-th photon. A kernel that does not vanish at the edge leaves
//! the k-th photon out: with k − 1 photons inside a radius drawn from the data the estimate is unbiased where the
//! density is flat (PHOTON_DIFFERENTIALS 4.1).

use std::num::NonZero;

use kiddo::{ImmutableKdTree, QueryResultItem, SquaredEuclidean};

use super::gather::{GatherPoint, Gathered};
use super::kernel;
use super::pair::reflected;
use crate::photon::PhotonMap;
use crate::photon::record::MIN_NORMAL_COSINE;
use crate::radiometry::Radiance;
use crate::scene::settings::KernelShape;

type Tree = ImmutableKdTree<f64, 3>;
/// A photon's index and its squared distance.
type Neighbour = QueryResultItem<(), u32, f64>;

/// Factor on the last point's radius: room for a density that falls a little.
const GUESS_MARGIN: f64 = 1.1;

/// Positions of a pass's photons, ready for nearest-neighbour queries.
pub struct NearestPhotons<'a> {
    map: &'a PhotonMap,
    /// `None` where fewer than two photons are stored: no radius can be had.
    tree: Option<Tree>,
}

impl<'a> NearestPhotons<'a> {
    pub fn new(map: &'a PhotonMap) -> Self {
        let positions: Vec<[f64; 3]> = map.photons.iter().map(|p| p.position().to_array()).collect();
        let tree = if positions.len() < 2 { None } else { ImmutableKdTree::new_from_slice(&positions).ok() };
        NearestPhotons { map, tree }
    }

    /// The estimates at `points` with `k` ≥ 2 neighbours.
    pub fn gather(&self, k: usize, kernel: KernelShape, points: &[GatherPoint]) -> Vec<Gathered> {
        let Some(tree) = &self.tree else { return vec![Gathered::default(); points.len()] };
        let mut discs = Discs { tree, k: k.min(self.map.photons.len()), guess: 0.0, distances: Vec::new() };
        points.iter().map(|point| self.estimate(kernel, point, discs.around(&point.p.to_array()))).collect()
    }

    fn estimate(&self, kernel: KernelShape, point: &GatherPoint, disc: Disc) -> Gathered {
        let mut gathered = Gathered::default();
        for neighbour in &disc.photons {
            let photon = &self.map.photons[neighbour.item as usize];
            // The k-th photon lies on the edge, where kernels that do not vanish leave it out.
            let elsewhere = neighbour.distance >= disc.radius2 || point.ng.dot(photon.normal()) < MIN_NORMAL_COSINE;
            if elsewhere || !point.asks.admits(photon) {
                continue;
            }
            let weight = kernel::evaluate(kernel, neighbour.distance / disc.radius2) / disc.radius2;
            gathered.radiance += Radiance(reflected(photon, point) * weight);
            gathered.density += weight;
        }
        gathered
    }
}

/// Finds the discs around neighbouring points one after the other.
///
/// A sorted list of the k nearest costs k log k a point. All photons within a radius that is likely to hold k come at a
/// fraction of that, and the k-th smallest of their distances is selected in linear time. The tree names photons in an
/// order that does not depend on the radius, so that sums over a disc have the same bits whatever the guess was.
struct Discs<'a> {
    tree: &'a Tree,
    k: usize,
    /// The last disc's radius, m.
    guess: f64,
    distances: Vec<f64>,
}

/// The photons within at least `radius2`, squared distances.
struct Disc {
    photons: Vec<Neighbour>,
    radius2: f64,
}

impl Discs<'_> {
    fn around(&mut self, p: &[f64; 3]) -> Disc {
        let mut radius = if self.guess > 0.0 { GUESS_MARGIN * self.guess } else { self.sorted(p) };
        loop {
            let photons = self.tree.query(p).within::<SquaredEuclidean<f64>>(radius * radius).unsorted().execute();
            // Beyond all bounds there is nothing more to be found.
            if photons.len() < self.k && radius.is_finite() {
                radius *= if photons.len() > self.k / 4 { 1.0 + 1.0 / 3.0 } else { 2.0 };
                continue;
            }
            self.distances.clear();
            self.distances.extend(photons.iter().map(|n| n.distance));
            let Some(last) = photons.len().min(self.k).checked_sub(1) else { return Disc { photons, radius2: 0.0 } };
            let (_, &mut radius2, _) = self.distances.select_nth_unstable_by(last, f64::total_cmp);
            self.guess = radius2.sqrt();
            return Disc { photons, radius2 };
        }
    }

    /// The first point's radius.
    fn sorted(&self, p: &[f64; 3]) -> f64 {
        let k = NonZero::new(self.k).unwrap_or(NonZero::<usize>::MIN);
        let nearest = self.tree.query(p).nearest_n::<SquaredEuclidean<f64>>(k).execute();
        nearest.last().map_or(0.0, |last| last.distance.sqrt() * GUESS_MARGIN).max(f64::MIN_POSITIVE.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::super::gather::{Asks, Turn};
    use super::*;
    use crate::math::{Dir3, Normal3, Point3, Vec3};
    use crate::photon::footprint::TangentForm;
    use crate::photon::{Photon, PhotonCounts, PhotonHarvest};
    use crate::radiometry::{Flux, Spectrum};
    use crate::sampling::{Purpose, Stream};
    use crate::scene::LightId;
    use crate::surface::test_support::lambert_at;

    fn map(photons: Vec<Photon>) -> PhotonMap {
        let mut harvest = PhotonHarvest::new(1);
        harvest.add(LightId(0), photons, &PhotonCounts::default());
        harvest.into_map()
    }

    /// Photons spread evenly at random over the unit square: the density estimate at the centre has the mean n, for
    /// every kernel (PHOTON_DIFFERENTIALS 4.1). A z-test over 4000 maps, five standard errors.
    #[test]
    fn the_estimate_is_unbiased_where_the_density_is_flat() {
        let (n, k, trials, seed) = (100, 10, 4000u64, 11);
        for kernel in [KernelShape::Uniform, KernelShape::Epanechnikov, KernelShape::Biweight, KernelShape::Cone] {
            let densities: Vec<f64> = (0..trials).map(|t| one_density(n, k, kernel, seed, t)).collect();
            let mean = densities.iter().sum::<f64>() / trials as f64;
            let variance = densities.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (trials - 1) as f64;
            let z = (mean - f64::from(n)) / (variance / trials as f64).sqrt();
            assert!(z.abs() < 5.0, "{}: mean {mean}, z = {z}, seed {seed}", kernel.name());
        }
    }

    /// A point's estimate has the same bits alone and after others, whose radii were guesses for it.
    #[test]
    fn the_guess_leaves_no_trace() {
        let mut s = Stream::new(3, Purpose::Test, 0, 0);
        let photons = (0..3000)
            .map(|_| {
                let p = Point3::new(s.uniform().powi(3), s.uniform(), 0.0);
                Photon::new(p, Dir3::Z, Normal3::Z, Flux(Spectrum::ONE), TangentForm::default(), 0)
            })
            .collect();
        let map = map(photons);
        let nearest = NearestPhotons::new(&map);
        let points: Vec<GatherPoint> =
            (0..200).map(|_| point(Point3::new(2.0 * s.uniform(), s.uniform(), 0.0))).collect();
        let together = nearest.gather(50, KernelShape::Epanechnikov, &points);
        for (point, found) in points.iter().zip(together) {
            assert_eq!(nearest.gather(50, KernelShape::Epanechnikov, &[*point])[0], found);
        }
    }

    fn point(p: Point3) -> GatherPoint {
        let n = Normal3::Z;
        let bsdf = lambert_at(p, n, 1.0);
        let (ng, ns, wo, eye) = (n, n, n.as_dir(), [Vec3::ZERO; 2]);
        GatherPoint { p, ng, ns, wo, bsdf, eye, asks: Asks::All(Turn::ALONE), moment: None }
    }

    fn one_density(n: u32, k: usize, kernel: KernelShape, seed: u64, trial: u64) -> f64 {
        let mut s = Stream::new(seed, Purpose::Test, 0, trial);
        let photons = (0..n)
            .map(|_| {
                let p = Point3::new(s.uniform(), s.uniform(), 0.0);
                Photon::new(p, Dir3::Z, Normal3::Z, Flux(Spectrum::ONE), TangentForm::default(), 0)
            })
            .collect();
        let map = map(photons);
        NearestPhotons::new(&map).gather(k, kernel, &[point(Point3::new(0.5, 0.5, 0.0))])[0].density
    }
}
