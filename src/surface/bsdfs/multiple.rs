//! Light that meets more than one facet, as a lobe of its own · 1/sr without the cosine · `[Kulla17]`.
//!
//! What one event loses of the light from a direction, L(wo), comes out anywhere, in proportion to what is lost of the
//! light from there: f = L(wo) L(wi) / (π L̄). Both ends look alike to it, as photons and eye paths must see one surface:
//! that is why it is a lobe, and not a factor on the single event by the direction of one end. With perfect facets
//! nothing is lost but the tables' error.
//!
//! An interface sends the part t on to the far side, with L of that side for wi. Flux is reciprocal if n² L̄ t is the same
//! from both sides; t = (1 − F̄) min(1, L̄ there / L̄ here) is, for n²(1 − F̄) is.

use std::f64::consts::{FRAC_1_PI, TAU};

use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::sampling::warp::{UniformCone, Warp};
use crate::surface::facet_loss::Loss;
use crate::surface::fresnel;
use crate::surface::microfacet::Ggx;

/// The lobe of one width of facets, seen from one side.
#[derive(Clone, Copy)]
pub struct Multiple {
    here: Loss,
    there: Loss,
    mean_here: f64,
    mean_there: f64,
    /// t.
    through: f64,
}

impl Multiple {
    /// Among facets that reflect everything; for others see [`Multiple::coloured`]. `None` where nothing is lost.
    pub fn among_mirrors(facets: Ggx) -> Option<Multiple> {
        Multiple::of_sheet(facets, 0.0)
    }

    /// Of facets alike on both sides that send the part `through` of all light to the far one.
    pub fn of_sheet(facets: Ggx, through: f64) -> Option<Multiple> {
        let loss = Loss::of_mirrors(facets.alpha());
        let mean = loss.mean();
        let lobe = Multiple { here: loss, there: loss, mean_here: mean, mean_there: mean, through };
        (mean > 0.0).then_some(lobe)
    }

    /// Of an interface, from the side whose index is `eta` times the other's.
    pub fn of_interface(facets: Ggx, eta: f64) -> Option<Multiple> {
        let [here, there] = [eta, 1.0 / eta].map(|eta| Loss::of_interface(eta, facets.alpha()));
        let (here, there) = (here?, there?);
        let (mean_here, mean_there) = (here.mean(), there.mean());
        if mean_here <= 0.0 {
            return None;
        }
        let through = (1.0 - fresnel::dielectric_diffuse(1.0 / eta)) * (mean_there / mean_here).min(1.0);
        Some(Multiple { here, there, mean_here, mean_there, through })
    }

    /// What is left of the lobe's light after so many facets of the mean reflectance F̄: F̄² Ē / (1 − F̄ (1 − Ē)), the sum over
    /// two and more of them of which each lets Ē out.
    pub fn coloured(&self, mean_reflectance: Spectrum) -> Spectrum {
        let lost = self.mean_here;
        mean_reflectance.map(|f| f * f * (1.0 - lost) / (1.0 - f * lost))
    }

    /// The lobe's part of the light from `wo`, and the probability to draw from it.
    pub fn share(&self, wo: Vec3) -> f64 {
        self.here.at(wo.z)
    }

    pub fn f(&self, wo: Vec3, wi: Vec3) -> f64 {
        let (part, loss, mean) = self.towards(wi);
        if part <= 0.0 {
            return 0.0;
        }
        part * self.here.at(wo.z) * loss.at(wi.z.abs()) / mean * FRAC_1_PI
    }

    /// Even over the hemisphere of a side, but for directions into which nothing comes out: grazing ones, of which most is
    /// lost, get the more.
    pub fn pdf(&self, wi: Vec3) -> f64 {
        let (part, loss, _) = self.towards(wi);
        if loss.at(wi.z.abs()) > 0.0 { part / TAU } else { 0.0 }
    }

    /// `uc` chooses the side. `None` where nothing comes out.
    pub fn sample(&self, uc: f64, u: [f64; 2]) -> Option<Vec3> {
        let up = UniformCone::from_cos(0.0).sample(u).to_vec();
        let wi = if uc < self.through { -up } else { up };
        (self.pdf(wi) > 0.0).then_some(wi)
    }

    /// The part of the light that goes to the side of `wi`, with L and L̄ of that side.
    fn towards(&self, wi: Vec3) -> (f64, &Loss, f64) {
        match wi.z > 0.0 {
            true => (1.0 - self.through, &self.here, self.mean_here),
            false => (self.through, &self.there, self.mean_there),
        }
    }
}

/// The density of a lobe of one event, `single`, and of what more of them add, each with its probability.
pub fn mixed(multiple: Option<&Multiple>, single: f64, wo: Vec3, wi: Vec3) -> [f64; 2] {
    let Some(multiple) = multiple else { return [single, 0.0] };
    let share = multiple.share(wo);
    [single * (1.0 - share), share * multiple.pdf(wi)]
}

/// Of those, which is drawn: `Ok` is the lobe of one event, with what is left of `uc`; else a direction of the other, if any.
pub fn choose(multiple: Option<&Multiple>, wo: Vec3, uc: f64, u: [f64; 2]) -> Result<f64, Option<Vec3>> {
    let Some(multiple) = multiple else { return Ok(uc) };
    let share = multiple.share(wo);
    if uc < share { Err(multiple.sample(uc / share, u)) } else { Ok(((uc - share) / (1.0 - share)).min(1.0)) }
}
