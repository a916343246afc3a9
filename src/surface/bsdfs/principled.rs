//! Metal, coated base and glass in one, as glTF's metallic-roughness mixes them · local frame, 1/sr without the cosine.
//!
//! With metalness m and transmission t the surface is m metal + (1 − m)((1 − t) coated + t glass), all of the same facets:
//! GGX of one width, or smooth, when everything that they do is a delta lobe.
//!
//! - Metal: Schlick's reflectance from the base colour c, and a lobe of the light that meets more than one facet.
//! - Coated: a dielectric's reflectance, of a strength and a colour at normal incidence, over a diffuse base, f = c T(wo) T(wi) / (π T̄), where T is what the facets do not
//!   return of a direction's light and T̄ its mean over the hemisphere: reciprocal, and with c = 1 nothing is lost or
//!   gained: what the facets lose of the light on its way goes to the base.
//! - Glass: an interface with Fresnel's reflectance whose transmitted light is coloured by c at each crossing, or a sheet
//!   without thickness; with such a lobe, too.
//! - Where it covers only a part of what a point stands for, the rest of the light goes straight on.

use std::f64::consts::FRAC_1_PI;

use super::coat::Coat;
use super::dielectric::Dielectric;
use super::lambert::{cosine_pdf, sample_cosine};
use super::multiple::Multiple;
use super::rough_conductor::reflected;
use super::rough_dielectric::RoughDielectric;
use super::thin_glass::ThinGlass;
use super::{Arrival, LocalDelta, LocalDeltas, mirrored};
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::sampling::warp::Warp;
use crate::surface::facet_albedo::{self, LEAST_REFLECTANCE, schlick, smooth_diffuse_albedo};
use crate::surface::fresnel::{self, normal_reflectance};
use crate::surface::microfacet::Ggx;

/// An index of glass nearer to 1 than this would bend light too little for the arithmetic of rough facets.
const LEAST_BENDING: f64 = 1e-4;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    colour: Spectrum,
    metalness: f64,
    transmission: f64,
    /// Of the dielectric, inside to outside.
    ior: f64,
    /// What all of the coated base's reflectance is multiplied by, and that at normal incidence before it is: short, for a
    /// BSDF goes from hand to hand.
    specular: f32,
    specular_colour: [f32; 3],
    /// Of the light on the surface, what does not go straight on through its holes.
    coverage: f64,
    /// GGX width; 0 is smooth.
    alpha: f64,
    thin: bool,
    diffuse: bool,
    holes: bool,
    /// What lies over all of it, kept here for room: only [`super::coated`] looks at it.
    pub(super) coat: Coat,
}

/// The numbers of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    pub colour: Spectrum,
    pub metalness: f64,
    pub transmission: f64,
    pub coverage: f64,
    pub ior: f64,
    /// What the reflectance of the coated base is multiplied by everywhere, and at normal incidence only: there it is at
    /// most 1 before the former.
    pub specular: f64,
    pub specular_colour: Spectrum,
    pub facets: Option<Ggx>,
    /// Glass without thickness.
    pub thin: bool,
    /// Whether the material has a diffuse base, here or elsewhere: what scatters is then of class D all over it.
    pub diffuse: bool,
    /// Whether it has holes, here or elsewhere.
    pub holes: bool,
}

/// Probabilities of the lobes that are not deltas.
struct Choice {
    /// The facets of metal and coat.
    facets: f64,
    base: f64,
    glass: f64,
}

impl Principled {
    pub fn new(at: Parameters) -> Principled {
        let share = |x: f64| x.clamp(0.0, 1.0);
        let ior = if (at.ior - 1.0).abs() < LEAST_BENDING { 1.0 + LEAST_BENDING } else { at.ior };
        Principled {
            colour: at.colour.map(share),
            metalness: share(at.metalness),
            transmission: share(at.transmission),
            ior,
            specular: share(at.specular) as f32,
            specular_colour: at.specular_colour.to_array().map(|c| c as f32),
            coverage: if at.holes { share(at.coverage) } else { 1.0 },
            alpha: at.facets.map_or(0.0, |facets| facets.alpha()),
            thin: at.thin,
            diffuse: at.diffuse,
            holes: at.holes,
            coat: Coat::default(),
        }
    }

    pub(super) fn under(self, coat: Coat) -> Principled {
        Principled { coat, ..self }
    }

    /// Whether what scatters are facets alone.
    pub fn is_glossy(&self) -> bool {
        self.facets().is_some() && !self.diffuse
    }
    /// Whether there is a diffuse base, here or elsewhere on the surface.
    pub fn is_diffuse(&self) -> bool {
        self.diffuse
    }
    /// Whether it is the boundary of glass that light gets into.
    pub fn is_solid(&self) -> bool {
        !self.thin && self.glass() > 0.0
    }
    pub fn coverage(&self) -> f64 {
        self.coverage
    }
    pub fn without_holes(self) -> Principled {
        Principled { coverage: 1.0, holes: false, ..self }
    }
    pub fn has_delta(&self) -> bool {
        self.facets().is_none() || self.holes
    }
    pub fn has_scatter(&self) -> bool {
        self.facets().is_some() || self.diffuse
    }

    fn coated(&self) -> f64 {
        (1.0 - self.metalness) * (1.0 - self.transmission)
    }
    fn glass(&self) -> f64 {
        (1.0 - self.metalness) * self.transmission
    }
    fn facets(&self) -> Option<Ggx> {
        (self.alpha > 0.0).then(|| Ggx::new(self.alpha))
    }
    /// Over the diffuse base at normal incidence, before the factor.
    fn f0(&self) -> Spectrum {
        let tint = Spectrum::from(self.specular_colour.map(f64::from));
        tint.map(|c| (c * self.glass_f0()).min(1.0))
    }
    /// T̄ of the coat.
    fn mean_entering(&self) -> f64 {
        let (specular, most) = (f64::from(self.specular), self.f0().max_component());
        match self.facets() {
            Some(facets) => {
                let returned = specular * facet_albedo::diffuse_albedo(most, facets.alpha()) + facet_albedo::ERROR;
                (1.0 - returned).max(facet_albedo::ERROR)
            }
            None => 1.0 - specular * facet_albedo::smooth_diffuse_albedo(most),
        }
    }
    /// Of glass at normal incidence.
    fn glass_f0(&self) -> f64 {
        normal_reflectance(self.ior)
    }
    fn interface(&self) -> Dielectric {
        Dielectric::new(self.ior, 1.0, true)
    }
    /// n_i/n_t of what goes through.
    pub fn transmitted_eta(&self, arrival: &Arrival) -> f64 {
        if self.thin { 1.0 } else { self.interface().eta(arrival) }
    }
    pub fn is_thin(&self) -> bool {
        self.thin
    }

    /// What metal and coat reflect of light on a facet, with their shares of the surface.
    fn facet_reflectance(&self, cos: f64) -> Spectrum {
        let metal = self.colour.map(|c| schlick(c, cos));
        metal * self.metalness + self.f0().map(|f0| self.coated() * (f64::from(self.specular) * schlick(f0, cos)))
    }
    /// Of the light on a facet of the glass, the reflected part.
    fn glass_reflectance(&self, arrival: &Arrival, cos: f64) -> f64 {
        if self.thin {
            return schlick(self.glass_f0(), cos);
        }
        fresnel::dielectric(cos, self.interface().eta(arrival)).reflectance
    }
    /// T: the part of a direction's light that the coat does not return. It is that of the channel of which the coat returns
    /// most: a base that took in each channel what is left would look complementary to the coat.
    fn entering(&self, cos: f64) -> f64 {
        self.left_by(self.f0().max_component(), cos)
    }
    /// The same of one channel.
    fn left_by(&self, f0: f64, cos: f64) -> f64 {
        match self.facets() {
            Some(facets) => {
                let returned = f64::from(self.specular) * facet_albedo::albedo(f0, cos, facets.alpha());
                (1.0 - returned - facet_albedo::ERROR).max(0.0)
            }
            None => 1.0 - f64::from(self.specular) * schlick(f0, cos),
        }
    }

    pub fn deltas(&self, arrival: &Arrival) -> LocalDeltas {
        let wo = arrival.wo;
        let missing = 1.0 - self.coverage;
        let straight = LocalDelta { wi: -wo, weight: Spectrum::splat(missing), eta: Some(1.0) };
        if self.facets().is_some() {
            return [None, (missing > 0.0).then_some(straight)];
        }
        let cos = wo.z.min(1.0);
        let glass = self.glass();
        let refracted = if self.thin {
            Some((-wo, 1.0 - schlick(self.glass_f0(), cos)))
        } else {
            let eta = self.interface().eta(arrival);
            let interface = fresnel::dielectric(cos, eta);
            interface.cos_t.map(|cos_t| (Vec3::new(-eta * wo.x, -eta * wo.y, -cos_t), interface.transmittance))
        };
        let glass_reflects = Spectrum::splat(glass * self.glass_reflectance(arrival, cos));
        let weight = (self.facet_reflectance(cos) + glass_reflects) * self.coverage;
        let reflection = LocalDelta { wi: mirrored(wo), weight, eta: None };
        let eta = Some(self.transmitted_eta(arrival));
        let transmission = refracted.filter(|_| glass > 0.0).map(|(wi, through)| {
            let weight = self.colour * (glass * through * self.coverage);
            LocalDelta { wi, weight: weight + straight.weight, eta }
        });
        [Some(reflection), transmission.or((missing > 0.0).then_some(straight))]
    }

    pub fn f(&self, arrival: &Arrival, wi: Vec3) -> Spectrum {
        self.covered_f(arrival, wi) * self.coverage
    }
    /// Where there are no holes.
    fn covered_f(&self, arrival: &Arrival, wi: Vec3) -> Spectrum {
        let wo = arrival.wo;
        let mut f = Spectrum::BLACK;
        if wi.z > 0.0 && self.coated() > 0.0 {
            let through = self.entering(wo.z) * self.entering(wi.z) / self.mean_entering();
            f += self.colour * (self.coated() * through * FRAC_1_PI);
        }
        let Some(facets) = self.facets() else { return f };
        if wi.z > 0.0 {
            let m = (wo + wi).normalize();
            let shape = facets.d(m) * facets.g2_reflection(wo, wi) / (4.0 * wo.z * wi.z);
            f += self.facet_reflectance(wo.dot(m).clamp(0.0, 1.0)) * shape;
            if let Some(multiple) = self.among_metal(facets) {
                let colour = multiple.coloured(self.colour.map(smooth_diffuse_albedo));
                f += colour * (self.metalness * multiple.f(wo, wi));
            }
        }
        if self.glass() > 0.0 {
            let tint = if wi.z > 0.0 { Spectrum::ONE } else { self.colour };
            let glass = match self.thin {
                true => Spectrum::splat(ThinGlass { f0: self.glass_f0(), facets }.f(arrival, wi)),
                false => RoughDielectric { interface: self.interface(), facets }.f(arrival, wi),
            };
            f += glass * tint * self.glass();
        }
        f
    }

    fn among_metal(&self, facets: Ggx) -> Option<Multiple> {
        Multiple::among_mirrors(facets).filter(|_| self.metalness > 0.0)
    }
    /// The probability that what the facets of metal and coat send on is light that met more than one.
    fn metal_share(&self, multiple: Option<&Multiple>, wo: Vec3) -> f64 {
        multiple.map_or(0.0, |multiple| multiple.share(wo) * self.metalness / (self.metalness + self.coated()))
    }

    /// In proportion to what each lobe sends on, as far as the mean facet tells.
    fn choice(&self, arrival: &Arrival) -> Option<Choice> {
        let cos = arrival.wo.z.min(1.0);
        let base = self.coated() * self.colour.mean() * self.entering(cos);
        let (facets, glass) = match self.facets() {
            Some(_) => {
                let least = LEAST_REFLECTANCE * (self.metalness + self.coated());
                (self.facet_reflectance(cos).mean().max(least), self.glass())
            }
            None => (0.0, 0.0),
        };
        let total = facets + base + glass;
        (total > 0.0).then(|| Choice { facets: facets / total, base: base / total, glass: glass / total })
    }

    pub fn pdf(&self, arrival: &Arrival, wi: Vec3) -> f64 {
        let base = self.choice(arrival).map_or(0.0, |choice| choice.base * cosine_pdf(wi));
        base + self.parts(arrival, wi).iter().sum::<f64>()
    }
    /// The parts of the facets' density, of one event and of more.
    pub fn parts(&self, arrival: &Arrival, wi: Vec3) -> [f64; 2] {
        let wo = arrival.wo;
        let (Some(choice), Some(facets)) = (self.choice(arrival), self.facets()) else { return [0.0; 2] };
        let mut parts = [0.0; 2];
        if wi.z > 0.0 {
            let m = (wo + wi).normalize();
            let multiple = self.among_metal(facets);
            let share = self.metal_share(multiple.as_ref(), wo);
            parts[0] = choice.facets * (1.0 - share) * facets.visible_pdf(wo, m) / (4.0 * wo.dot(m));
            parts[1] = choice.facets * share * multiple.map_or(0.0, |multiple| multiple.pdf(wi));
        }
        if choice.glass > 0.0 {
            let glass = match self.thin {
                true => ThinGlass { f0: self.glass_f0(), facets }.parts(arrival, wi),
                false => RoughDielectric { interface: self.interface(), facets }.parts(arrival, wi),
            };
            parts = std::array::from_fn(|k| parts[k] + choice.glass * glass[k]);
        }
        parts
    }

    pub fn sample(&self, arrival: &Arrival, uc: f64, u: [f64; 2]) -> Option<Vec3> {
        let choice = self.choice(arrival)?;
        let Some(facets) = self.facets().filter(|_| uc >= choice.base) else { return Some(sample_cosine(u)) };
        let left = uc - choice.base;
        if left < choice.facets {
            let multiple = self.among_metal(facets);
            if left < choice.facets * self.metal_share(multiple.as_ref(), arrival.wo) {
                return multiple.and_then(|multiple| multiple.sample(1.0, u));
            }
            let wi = reflected(arrival.wo, facets.visible(arrival.wo).sample(u).to_vec());
            return (wi.z > 0.0).then_some(wi);
        }
        if choice.glass <= 0.0 {
            return None;
        }
        let uc = ((left - choice.facets) / choice.glass).min(1.0);
        match self.thin {
            true => ThinGlass { f0: self.glass_f0(), facets }.sample(arrival, uc, u),
            false => RoughDielectric { interface: self.interface(), facets }.sample(arrival, uc, u),
        }
    }

    /// The probability of the lobes that are not deltas, `deltas` being the weight of those.
    pub fn scatter_share(&self, arrival: &Arrival, deltas: f64) -> f64 {
        if self.facets().is_some() {
            return self.coverage;
        }
        let base = self.base_albedo(arrival).mean() * self.coverage;
        if base > 0.0 { base / (base + deltas) } else { 0.0 }
    }

    /// What the lobes that are not deltas send on, as far as the mean facet tells; other facets may where that does not.
    pub fn scatter_estimate(&self, arrival: &Arrival) -> f64 {
        match self.facets() {
            Some(_) => self.albedo(arrival).mean().max(LEAST_REFLECTANCE),
            None => self.base_albedo(arrival).mean(),
        }
    }

    /// What the base returns of light from `wo`: ∫ f cos dwi of it.
    fn base_albedo(&self, arrival: &Arrival) -> Spectrum {
        self.colour * (self.coated() * self.entering(arrival.wo.z.min(1.0)))
    }
    /// Exact where the facets are smooth; else the mean facet answers for metal and glass.
    pub fn albedo(&self, arrival: &Arrival) -> Spectrum {
        let cos = arrival.wo.z.min(1.0);
        let reflected = self.glass_reflectance(arrival, cos);
        let glass = Spectrum::splat(reflected) + self.colour * (1.0 - reflected);
        let metal = self.colour.map(|c| schlick(c, cos));
        let coat = self.f0().map(|f0| self.coated() * (1.0 - self.left_by(f0, cos)));
        let covered = metal * self.metalness + coat + self.base_albedo(arrival) + glass * self.glass();
        covered * self.coverage + Spectrum::splat(1.0 - self.coverage)
    }
}
