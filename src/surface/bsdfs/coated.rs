//! A dielectric coat over a principled surface · local frame, 1/sr without the cosine · the `coat` of OpenPBR, glTF's
//! clearcoat.
//!
//! Where there is the part k of a coat that returns E of a direction's light, T = 1 − k E is left to what is below:
//!
//! f = k f_coat + min(T(wo), T(wi)) f_base.
//!
//! The smaller of both is reciprocal, and as it is at most T(wo) a surface never sends on more than it gets: k E + T = 1. A
//! mirror below, whose two directions have one T, loses nothing, as in the series F + T² + T² F + … = 1 of light that the
//! coat throws back; a diffuse base loses what grazing directions let out less than the steep one let in.
//!
//! The coat lies on the outside of solid glass, and light within it meets only the glass; it lies on both sides of all
//! other surfaces. It does not widen the lobes below it, and has no colour.

use super::coat::Coat;
use super::principled::Principled;
use super::{Arrival, LocalDelta, LocalDeltas, mirrored};
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::sampling::discrete::BELOW_ONE;
use crate::surface::facet_albedo::schlick;

/// A principled surface with the layer that lies on it, which has holes where the surface has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coated {
    base: Principled,
}

impl Coated {
    pub fn new(coat: Coat, base: Principled) -> Coated {
        Coated { base: base.under(coat) }
    }

    pub fn base(&self) -> &Principled {
        &self.base
    }
    /// What is below the coat, where both are.
    fn covered(&self) -> Principled {
        self.base.without_holes()
    }
    pub fn is_glossy(&self) -> bool {
        self.has_scatter() && !self.base.is_diffuse()
    }
    pub fn has_delta(&self) -> bool {
        self.base.coat.facets().is_none() || self.base.has_delta()
    }
    pub fn has_scatter(&self) -> bool {
        self.base.coat.facets().is_some() || self.base.has_scatter()
    }

    /// The coat, if light that arrives so meets it first.
    fn met(&self, arrival: &Arrival) -> Option<&Coat> {
        (arrival.outside || !self.base.is_solid()).then_some(&self.base.coat)
    }
    /// What light of the base passes of the coat on its way in and out.
    fn passed(&self, arrival: &Arrival, wi: Vec3) -> f64 {
        let (here, there) =
            (self.base.coat.through(arrival.wo.z.min(1.0)), self.base.coat.through(wi.z.abs().min(1.0)));
        let goes_through = wi.z < 0.0;
        match (self.base.is_solid(), arrival.outside) {
            (false, _) => here.min(there),
            (true, true) if goes_through => here,
            (true, true) => here.min(there),
            (true, false) if goes_through => there,
            (true, false) => 1.0,
        }
    }

    pub fn deltas(&self, arrival: &Arrival) -> LocalDeltas {
        let (cos, coverage) = (arrival.wo.z.min(1.0), self.base.coverage());
        let below = |lobe: LocalDelta| {
            let weight = lobe.weight * (self.passed(arrival, lobe.wi) * coverage);
            LocalDelta { weight, ..lobe }
        };
        let smooth = self.met(arrival).filter(|coat| coat.facets().is_none());
        let own = smooth.map(|coat| LocalDelta {
            wi: mirrored(arrival.wo),
            weight: Spectrum::splat(coat.weight() * schlick(coat.f0(), cos) * coverage),
            eta: None,
        });
        let missing = 1.0 - coverage;
        let straight =
            (missing > 0.0).then(|| LocalDelta { wi: -arrival.wo, weight: Spectrum::splat(missing), eta: Some(1.0) });
        // Of one direction each: only glass without thickness may have holes.
        let [reflection, transmission] = self.covered().deltas(arrival).map(|lobe| lobe.map(below));
        [together(reflection, own), together(transmission, straight)]
    }

    pub fn f(&self, arrival: &Arrival, wi: Vec3) -> Spectrum {
        let own = self.met(arrival).map_or(0.0, |coat| coat.f(arrival.wo, wi));
        self.base.f(arrival, wi) * self.passed(arrival, wi) + Spectrum::splat(own * self.base.coverage())
    }

    /// What coat and base scatter of the light, as far as their mean facets tell.
    fn estimates(&self, arrival: &Arrival) -> [f64; 2] {
        let cos = arrival.wo.z.min(1.0);
        let base = self.covered().scatter_estimate(arrival);
        match self.met(arrival) {
            Some(coat) => {
                let own = if coat.facets().is_some() { coat.estimate(cos) } else { 0.0 };
                [own, coat.through(cos) * base]
            }
            None => [0.0, base],
        }
    }
    /// The probability that what scatters is drawn from the coat.
    fn coat_share(&self, arrival: &Arrival) -> f64 {
        let [coat, base] = self.estimates(arrival);
        if coat > 0.0 { coat / (coat + base) } else { 0.0 }
    }

    pub fn pdf(&self, arrival: &Arrival, wi: Vec3) -> f64 {
        let share = self.coat_share(arrival);
        share * self.base.coat.pdf(arrival.wo, wi) + (1.0 - share) * self.base.pdf(arrival, wi)
    }
    /// As [`Principled::parts`].
    pub fn parts(&self, arrival: &Arrival, wi: Vec3) -> [f64; 2] {
        let share = self.coat_share(arrival);
        let [single, more] = self.base.parts(arrival, wi).map(|part| (1.0 - share) * part);
        [single + share * self.base.coat.pdf(arrival.wo, wi), more]
    }
    pub fn sample(&self, arrival: &Arrival, uc: f64, u: [f64; 2]) -> Option<Vec3> {
        let share = self.coat_share(arrival);
        if uc < share {
            return self.base.coat.sample(arrival.wo, u);
        }
        self.base.sample(arrival, ((uc - share) / (1.0 - share)).min(BELOW_ONE), u)
    }

    /// The probability of the lobes that are not deltas, `deltas` being the weight of those.
    pub fn scatter_share(&self, arrival: &Arrival, deltas: f64) -> f64 {
        let scatter = self.estimates(arrival).iter().sum::<f64>() * self.base.coverage();
        if scatter > 0.0 { scatter / (scatter + deltas) } else { 0.0 }
    }

    /// Exact for mirrors; otherwise what all lobes return at most.
    pub fn albedo(&self, arrival: &Arrival) -> Spectrum {
        let through = self.met(arrival).map_or(1.0, |coat| coat.through(arrival.wo.z.min(1.0)));
        let covered = Spectrum::splat(1.0 - through) + self.covered().albedo(arrival) * through;
        covered * self.base.coverage() + Spectrum::splat(1.0 - self.base.coverage())
    }
}

/// Two lobes of one direction, or the one that is there.
fn together(a: Option<LocalDelta>, b: Option<LocalDelta>) -> Option<LocalDelta> {
    match (a, b) {
        (Some(a), Some(b)) => Some(LocalDelta { weight: a.weight + b.weight, ..a }),
        (one, other) => one.or(other),
    }
}
