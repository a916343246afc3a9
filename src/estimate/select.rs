//! The estimator that the settings name.

use super::bandwidth::neighbours;
use super::gather::{GatherPoint, Gathered, gather};
use super::nearest::NearestPhotons;
use crate::photon::PhotonMap;
use crate::scene::RenderSettings;
use crate::scene::settings::Estimator;

/// Photons of a pass, ready to be asked.
pub enum Estimate<'a> {
    Footprints(&'a PhotonMap, &'a RenderSettings),
    Nearest(NearestPhotons<'a>, usize, &'a RenderSettings),
}

impl<'a> Estimate<'a> {
    /// `map` holds the photons of pass `pass`.
    pub fn new(map: &'a PhotonMap, settings: &'a RenderSettings, pass: u32) -> Estimate<'a> {
        match settings.estimator {
            Estimator::Differentials | Estimator::Progressive => Estimate::Footprints(map, settings),
            Estimator::NearestNeighbours => {
                let k = neighbours(settings.k, settings.emission, pass);
                Estimate::Nearest(NearestPhotons::new(map), k, settings)
            }
        }
    }

    /// The light that the photons bring to each point.
    pub fn gather(&self, points: &[GatherPoint]) -> Vec<Gathered> {
        match self {
            Estimate::Footprints(map, settings) => gather(map, settings.kernel, points),
            Estimate::Nearest(photons, k, settings) => photons.gather(*k, settings.kernel, points),
        }
    }
}
