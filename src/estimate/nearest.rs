//! The standard estimate: the k nearest photons in a disc `[Jensen96]`, with any kernel.
//!
//! L(x, wo) = Σ f Φ K(d²/r²)/r², r the distance to the k-th photon. A kernel that does not vanish at the edge leaves
//! the k-th photon out: with k − 1 photons inside a radius drawn from the data the estimate is unbiased where the
//! density is flat (PHOTON_DIFFERENTIALS 4.1).

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use super::gather::{GatherPoint, Gathered, reflected};
use super::kernel;
use crate::photon::PhotonMap;
use crate::radiometry::Radiance;
use crate::scene::settings::KernelShape;

/// As in the footprint estimate: photons on a surface turned away are another surface's.
const MIN_NORMAL_COSINE: f64 = 0.9;

/// Positions of a pass's photons, ready for nearest-neighbour queries.
pub struct NearestPhotons<'a> {
    map: &'a PhotonMap,
    /// `None` where fewer than two photons are stored: no radius can be had.
    tree: Option<ImmutableKdTree<f64, 3>>,
}

impl<'a> NearestPhotons<'a> {
    pub fn new(map: &'a PhotonMap) -> Self {
        let positions: Vec<[f64; 3]> = map.photons.iter().map(|p| p.position().to_array()).collect();
        let tree = if positions.len() < 2 { None } else { ImmutableKdTree::new_from_slice(&positions).ok() };
        NearestPhotons { map, tree }
    }

    /// The estimate at one point with `k` ≥ 2 neighbours.
    pub fn gather(&self, k: NonZero<usize>, kernel: KernelShape, point: &GatherPoint) -> Gathered {
        let mut gathered = Gathered::default();
        let Some(tree) = &self.tree else { return gathered };
        let nearest = tree.query(&point.p.to_array()).nearest_n::<SquaredEuclidean<f64>>(k).execute();
        let Some(last) = nearest.last() else { return gathered };
        let radius2 = last.distance;
        if radius2 <= 0.0 {
            return gathered;
        }
        let inside = if kernel::vanishes_at_edge(kernel) { nearest.len() } else { nearest.len() - 1 };
        for neighbour in &nearest[..inside] {
            let photon = &self.map.photons[neighbour.item as usize];
            if point.ng.dot(photon.normal()) < MIN_NORMAL_COSINE {
                continue;
            }
            let weight = kernel::evaluate(kernel, neighbour.distance / radius2) / radius2;
            gathered.radiance += Radiance(reflected(point, photon) * weight);
            gathered.density += weight;
        }
        gathered
    }
}

#[cfg(test)]
mod tests {
    use super::super::gather::Asks;
    use super::*;
    use crate::math::{Dir3, Normal3, Point3, Vec3};
    use crate::photon::footprint::TangentForm;
    use crate::photon::{Photon, PhotonCounts};
    use crate::radiometry::{Flux, Spectrum};
    use crate::sampling::{Purpose, Stream};
    use crate::scene::{LightId, ObjectId};
    use crate::surface::test_support::lambert_at;

    /// Photons spread evenly at random over the unit square: the density estimate at the centre has the mean n, for
    /// every kernel (PHOTON_DIFFERENTIALS 4.1). A z-test over 4000 maps, five standard errors.
    #[test]
    fn the_estimate_is_unbiased_where_the_density_is_flat() {
        let (n, k, trials, seed) = (100, NonZero::new(10).expect("ten"), 4000u64, 11);
        for kernel in [KernelShape::Uniform, KernelShape::Epanechnikov, KernelShape::Biweight, KernelShape::Cone] {
            let densities: Vec<f64> = (0..trials).map(|t| one_density(n, k, kernel, seed, t)).collect();
            let mean = densities.iter().sum::<f64>() / trials as f64;
            let variance = densities.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (trials - 1) as f64;
            let z = (mean - f64::from(n)) / (variance / trials as f64).sqrt();
            assert!(z.abs() < 5.0, "{}: mean {mean}, z = {z}, seed {seed}", kernel.name());
        }
    }

    fn one_density(n: u32, k: NonZero<usize>, kernel: KernelShape, seed: u64, trial: u64) -> f64 {
        let mut s = Stream::new(seed, Purpose::Test, 0, trial);
        let photons = (0..n)
            .map(|_| {
                let p = Point3::new(s.uniform(), s.uniform(), 0.0);
                Photon::new(p, Dir3::Z, Normal3::Z, Flux(Spectrum::ONE), TangentForm::default(), ObjectId(0))
            })
            .collect();
        let map = PhotonMap::from_units(1, [(LightId(0), photons, PhotonCounts::default())]);
        let (p, n) = (Point3::new(0.5, 0.5, 0.0), Normal3::Z);
        let bsdf = lambert_at(p, n, 1.0);
        let point = GatherPoint { p, ng: n, ns: n, wo: n.as_dir(), bsdf, eye: [Vec3::ZERO; 2], asks: Asks::All };
        NearestPhotons::new(&map).gather(k, kernel, &point).density
    }
}
