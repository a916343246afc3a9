//! The photons' light at vertices of eye paths: which maps each vertex asks.
//!
//! What the eye sees is asked for with all maps. Behind a bounce one map answers for all of them, drawn in half by the flux
//! that each holds and in half evenly: such a vertex is one of many whose light a pixel averages, and its own noise is
//! greater than what the draw adds.

use super::beam_light::BeamLight;
use super::eye_path::Query;
use crate::estimate::{Asks, Estimate, GatherPoint};
use crate::film::{Arrival, EyeSample, LightKind, Part};
use crate::photon::{Kinds, PhotonMap};
use crate::sampling::discrete::DiscreteTable;
use crate::scene::RenderSettings;

/// What light of each kind is to the eye that sees it arrive.
pub(super) const LIGHT: Kinds<(Part, Arrival)> = Kinds {
    caustic: (Part::Caustic, Arrival::Focused),
    onward: (Part::Caustic, Arrival::SentBack),
    bounced: (Part::Indirect, Arrival::SentBack),
    onward_scattered: (Part::Caustic, Arrival::Scattered),
    scattered: (Part::Indirect, Arrival::Scattered),
};

/// All photons of a pass, ready to be asked.
pub struct PhotonLight<'a> {
    estimates: Kinds<Estimate<'a>>,
    /// Draws a map that holds photons, if there are any: for vertices that leave the scattered kinds out, and others.
    draws: [Option<DiscreteTable>; 2],
    beams: Option<&'a BeamLight>,
}

/// A question to one map.
struct Asked {
    /// Index of the query.
    query: usize,
    point: GatherPoint,
    /// How much the answer counts.
    weight: f64,
}

impl<'a> PhotonLight<'a> {
    /// `maps` are those of pass `pass`.
    pub fn of_pass(maps: &'a Kinds<PhotonMap>, settings: &'a RenderSettings, pass: u32) -> PhotonLight<'a> {
        let estimates = maps.as_ref().map(|map| Estimate::new(map, settings, pass));
        let flux = maps.as_ref().map(|map| map.flux().0.mean()).into_array();
        let draws = [false, true]
            .map(|scattered| draw(std::array::from_fn(|k| if asks(scattered, k) { flux[k] } else { 0.0 })));
        PhotonLight { estimates, draws, beams: None }
    }

    /// With the same pass's beams.
    pub(super) fn with_beams(self, beams: Option<&'a BeamLight>) -> PhotonLight<'a> {
        PhotonLight { beams, ..self }
    }

    pub(super) fn beams(&self) -> Option<&'a BeamLight> {
        self.beams
    }

    /// Adds the light at each query to the sample that owns it.
    pub fn add(&self, queries: &[Query], owners: &[usize], samples: &mut [(u32, u32, EyeSample)]) {
        let asked = self.ask(queries);
        let kinds = self.estimates.as_ref().into_array().into_iter().zip(LIGHT.into_array()).zip(asked);
        for (k, ((estimate, (part, arrival)), asked)) in kinds.enumerate() {
            let points: Vec<GatherPoint> = asked.iter().map(|asked| asked.point).collect();
            for (Asked { query, weight, .. }, light) in asked.iter().zip(estimate.gather(&points)) {
                let (query, sample) = (&queries[*query], &mut samples[owners[*query]].2);
                let kind = LightKind { part, arrival: query.arrival(arrival) };
                sample.add(kind, query.beta * light.radiance.0 * *weight);
                if query.first && k == 0 {
                    sample.photon_density = light.density;
                }
            }
        }
    }

    /// Who asks each map.
    fn ask(&self, queries: &[Query]) -> [Vec<Asked>; 5] {
        let mut asked: [Vec<Asked>; 5] = Default::default();
        for (i, query) in queries.iter().enumerate() {
            match query.point.asks {
                Asks::All(_) => {
                    for k in (0..5).filter(|&k| asks(query.scattered, k)) {
                        asked[k].push(Asked { query: i, point: query.point, weight: 1.0 });
                    }
                }
                Asks::Drawn { u, bounces_left } => {
                    let Some(draw) = &self.draws[usize::from(query.scattered)] else { continue };
                    let map = draw.sample(u);
                    let point = GatherPoint { asks: Asks::Drawn { u: map.reused, bounces_left }, ..query.point };
                    asked[map.index].push(Asked { query: i, point, weight: 1.0 / map.pmf.0 });
                }
            }
        }
        asked
    }
}

/// Whether a vertex asks the `k`th map: not all ask for light straight from a surface that scatters.
fn asks(scattered: bool, k: usize) -> bool {
    scattered || LIGHT.into_array()[k].1 != Arrival::Scattered
}

/// Of maps with so much flux.
fn draw(flux: [f64; 5]) -> Option<DiscreteTable> {
    let total: f64 = flux.iter().sum();
    let maps = flux.iter().filter(|&&flux| flux > 0.0).count() as f64;
    DiscreteTable::new(&flux.map(|flux| if flux > 0.0 { 0.5 * (flux / total + 1.0 / maps) } else { 0.0 }))
}
