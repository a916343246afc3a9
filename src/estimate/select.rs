//! The estimator that the settings name.

use std::num::NonZero;

use super::gather::{GatherPoint, Gathered, gather};
use super::nearest::NearestPhotons;
use crate::photon::PhotonMap;
use crate::scene::RenderSettings;
use crate::scene::settings::Estimator;

/// Photons of a pass, ready to be asked.
pub enum Estimate<'a> {
    Footprints(&'a PhotonMap, &'a RenderSettings),
    Nearest(NearestPhotons<'a>, NonZero<usize>, &'a RenderSettings),
}

impl<'a> Estimate<'a> {
    pub fn new(map: &'a PhotonMap, settings: &'a RenderSettings) -> Estimate<'a> {
        match settings.estimator {
            Estimator::Differentials | Estimator::Progressive => Estimate::Footprints(map, settings),
            Estimator::NearestNeighbours => {
                // A radius needs two photons.
                let k = NonZero::new(settings.k.max(2) as usize).unwrap_or(NonZero::<usize>::MIN);
                Estimate::Nearest(NearestPhotons::new(map), k, settings)
            }
        }
    }

    /// The light that the photons bring to each point.
    pub fn gather(&self, points: &[GatherPoint]) -> Vec<Gathered> {
        match self {
            Estimate::Footprints(map, settings) => gather(map, settings.kernel, points),
            Estimate::Nearest(photons, k, settings) => {
                points.iter().map(|point| photons.gather(*k, settings.kernel, point)).collect()
            }
        }
    }
}
