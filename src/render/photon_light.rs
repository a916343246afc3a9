//! The photons' light at vertices of eye paths: which maps each vertex asks.
//!
//! What the eye sees is asked for with all maps. Behind a bounce one map answers for all of them, drawn in half by the flux
//! that each holds and in half evenly: such a vertex is one of many whose light a pixel averages, and its own noise is
//! greater than what the draw adds.
//!
//! Where groups of lights have layers of their own, the photons of each group have maps of their own.

use super::beam_light::BeamLight;
use super::eye_path::Query;
use crate::estimate::{Asks, Estimate, GatherPoint};
use crate::film::{Arrival, EyeSample, LightKind, Part};
use crate::photon::{Kinds, PhotonMap};
use crate::sampling::discrete::DiscreteTable;
use crate::scene::{GroupId, RenderSettings};

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
    sources: Vec<Source<'a>>,
    /// Draws a map that holds photons, if there are any: for vertices that leave the scattered kinds out, and others.
    draws: [Option<DiscreteTable>; 2],
    beams: Option<&'a BeamLight>,
}

/// One map: photons of one kind from one group of lights.
struct Source<'a> {
    estimate: Estimate<'a>,
    part: Part,
    arrival: Arrival,
    group: GroupId,
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
    /// `maps` are those of pass `pass`, of all lights together.
    pub fn of_pass(maps: &'a Kinds<PhotonMap>, settings: &'a RenderSettings, pass: u32) -> PhotonLight<'a> {
        PhotonLight::of_groups(std::slice::from_ref(maps), settings, pass)
    }

    /// The same with the maps of each group of lights, in the order of their ids.
    pub fn of_groups(maps: &'a [Kinds<PhotonMap>], settings: &'a RenderSettings, pass: u32) -> PhotonLight<'a> {
        let all =
            || GroupId::all().zip(maps).flat_map(|(group, maps)| maps.as_ref().map(|map| (group, map)).into_array());
        let kinds = LIGHT.into_array().into_iter().cycle();
        let source = |((group, map), (part, arrival))| Source {
            estimate: Estimate::new(map, settings, pass),
            part,
            arrival,
            group,
        };
        let sources: Vec<Source> = all().zip(kinds).map(source).collect();
        let flux: Vec<f64> = all().map(|(_, map)| map.flux().0.mean()).collect();
        let draws = [false, true].map(|scattered| {
            draw(
                sources
                    .iter()
                    .zip(&flux)
                    .map(|(source, &flux)| if source.answers(scattered) { flux } else { 0.0 })
                    .collect(),
            )
        });
        PhotonLight { sources, draws, beams: None }
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
        for (source, asked) in self.sources.iter().zip(self.ask(queries)) {
            let points: Vec<GatherPoint> = asked.iter().map(|asked| asked.point).collect();
            for (Asked { query, weight, .. }, light) in asked.iter().zip(source.estimate.gather(&points)) {
                let (query, sample) = (&queries[*query], &mut samples[owners[*query]].2);
                let Source { part, arrival, group, .. } = *source;
                let kind = LightKind { part, arrival: query.arrival(arrival), group };
                sample.add(kind, query.beta * light.radiance.0 * *weight);
                if query.first && arrival == Arrival::Focused {
                    sample.photon_density += light.density;
                }
            }
        }
    }

    /// Who asks each map.
    fn ask(&self, queries: &[Query]) -> Vec<Vec<Asked>> {
        let mut asked: Vec<Vec<Asked>> = self.sources.iter().map(|_| Vec::new()).collect();
        for (i, query) in queries.iter().enumerate() {
            match query.point.asks {
                Asks::All(_) => {
                    let answering =
                        self.sources.iter().zip(&mut asked).filter(|(source, _)| source.answers(query.scattered));
                    for (_, asked) in answering {
                        asked.push(Asked { query: i, point: query.point, weight: 1.0 });
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

impl Source<'_> {
    /// Whether a vertex asks it: not all ask for light straight from a surface that scatters.
    fn answers(&self, scattered: bool) -> bool {
        scattered || self.arrival != Arrival::Scattered
    }
}

/// Of maps with so much flux.
fn draw(flux: Vec<f64>) -> Option<DiscreteTable> {
    let total: f64 = flux.iter().sum();
    let maps = flux.iter().filter(|&&flux| flux > 0.0).count() as f64;
    let weight = |&flux: &f64| if flux > 0.0 { 0.5 * (flux / total + 1.0 / maps) } else { 0.0 };
    DiscreteTable::new(&flux.iter().map(weight).collect::<Vec<f64>>())
}
