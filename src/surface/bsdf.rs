//! The BSDF at a point: one enum over the models, world-space directions in and out.
//!
//! `wo` and `wi` both leave the surface. Values are in 1/sr and without the cosine. Delta lobes never show in
//! [`Bsdf::f`] or [`Bsdf::pdf`]; they come out of [`Bsdf::sample`] or, all at once, of [`Bsdf::delta_branches`].
//!
//! **Sides.** The geometric normal decides on which side of the surface a direction lies, so no light leaks through a
//! smoothed mesh; the shading normal shapes the value and carries the cosine |wi·ns|. A direction that the two normals
//! put on different sides is black, for delta lobes too ([`Bsdf::normals_agree`] tells).
//!
//! **Modes.** Refraction spreads or gathers solid angle, which changes radiance but not flux: in
//! [`TransportMode::Radiance`] every transmitted value and weight has the factor (n_i/n_t)², n_i being the index on the
//! side of `wo` [Veach97 5.2]. The correction of photons for shading normals is not in any value or weight here: callers
//! multiply by [`super::adjoint::shading_normal_factor`] at non-delta events.

use super::bsdfs::coat::Coat;
use super::bsdfs::coated::Coated;
use super::bsdfs::conductor::Conductor;
use super::bsdfs::dielectric::Dielectric;
use super::bsdfs::lambert::Lambert;
use super::bsdfs::mirror::Mirror;
use super::bsdfs::plastic::Plastic;
use super::bsdfs::principled::{Parameters, Principled};
use super::bsdfs::rough_conductor::RoughConductor;
use super::bsdfs::rough_dielectric::RoughDielectric;
use super::bsdfs::{Arrival, LocalDeltas};
use super::event::{BsdfSample, DeltaBranch, DeltaBranches, Event, Passage, TransportMode};
use super::interaction::Interaction;
use super::microfacet::Ggx;
use super::parametrisation::Lookup;
use super::texture::Textures;
use crate::math::{Dir3, Frame, Normal3, Vec3};
use crate::radiometry::{Pdf, SolidAngle, Spectrum};
use crate::scene::Material;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Model {
    Lambert(Lambert),
    Mirror(Mirror),
    Dielectric(Dielectric),
    Conductor(Conductor),
    RoughDielectric(RoughDielectric),
    RoughConductor(RoughConductor),
    Plastic(Plastic),
    Principled(Principled),
    Coated(Coated),
}

/// A material at a point, its textures looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bsdf {
    /// About the shading normal, on the outward side.
    frame: Frame,
    ng: Normal3,
    model: Model,
}

/// The frame turned to the side that `wo` lies on.
struct Side {
    frame: Frame,
    ng: Normal3,
    arrival: Arrival,
}

impl Side {
    fn to_world(&self, wi: Vec3) -> Dir3 {
        // Keeps long chains of events at unit length.
        let w = self.frame.to_world(wi);
        Dir3::from_unit(w * (1.5 - 0.5 * w.length_squared()))
    }
    /// Whether both normals put `wi` (local and world) on the same side.
    fn admits(&self, local: Vec3, world: Dir3) -> bool {
        local.z * self.ng.dot(world) > 0.0
    }
}

impl Bsdf {
    /// The BSDF of `material` at `hit`; `texture` is where its images are looked up, if it has any.
    ///
    /// A rough material whose `alpha` is here below [`Ggx::SMOOTH_BELOW`], or whose two indices are equal, is its smooth
    /// limit.
    pub fn new(material: &Material, textures: &Textures, hit: &Interaction, texture: &Lookup) -> Bsdf {
        let colour = |value| textures.colour(value, texture);
        let number = |value| textures.number(value, texture);
        let model = match material {
            Material::Lambert { albedo } => Model::Lambert(Lambert { albedo: colour(albedo) }),
            Material::Mirror { reflectance } => Model::Mirror(Mirror { reflectance: colour(reflectance) }),
            Material::Dielectric { ior, exterior, fresnel } => {
                Model::Dielectric(Dielectric::new(*ior, *exterior, *fresnel))
            }
            // Callers fly on through it; to others it is glass of no index.
            Material::Interface => Model::Dielectric(Dielectric::new(1.0, 1.0, true)),
            Material::Conductor { eta, k } => Model::Conductor(Conductor { eta: *eta, k: *k }),
            Material::RoughDielectric { ior, exterior, alpha } => {
                let (interface, alpha) = (Dielectric::new(*ior, *exterior, true), number(alpha));
                if alpha < Ggx::SMOOTH_BELOW || ior == exterior {
                    Model::Dielectric(interface)
                } else {
                    Model::RoughDielectric(RoughDielectric { interface, facets: Ggx::new(alpha) })
                }
            }
            Material::RoughConductor { eta, k, alpha } => {
                let (metal, alpha) = (Conductor { eta: *eta, k: *k }, number(alpha));
                if alpha < Ggx::SMOOTH_BELOW {
                    Model::Conductor(metal)
                } else {
                    Model::RoughConductor(RoughConductor { metal, facets: Ggx::new(alpha) })
                }
            }
            Material::Plastic { albedo, ior } => Model::Plastic(Plastic::new(colour(albedo), *ior)),
            Material::Principled {
                base_colour,
                metalness,
                transmission,
                coverage,
                alpha,
                ior,
                thin,
                specular,
                coat,
                ..
            } => {
                // What the material is smooth or diffuse by holds all over it, whatever a filtered image says.
                let facets = (!material.is_smooth()).then(|| Ggx::new(number(alpha).max(Ggx::SMOOTH_BELOW)));
                let specular = specular.as_ref();
                let base = Principled::new(Parameters {
                    colour: colour(base_colour) * texture.tint.unwrap_or(Spectrum::ONE),
                    metalness: number(metalness),
                    transmission: number(transmission),
                    coverage: number(coverage),
                    ior: *ior,
                    specular: specular.map_or(1.0, |specular| number(&specular.weight)),
                    specular_colour: specular.map_or(Spectrum::ONE, |specular| colour(&specular.colour)),
                    facets,
                    thin: *thin,
                    diffuse: material.has_diffuse_base(),
                    holes: material.has_holes(),
                });
                match coat {
                    None => Model::Principled(base),
                    Some(coat) => {
                        let facets = (!coat.is_smooth()).then(|| Ggx::new(number(&coat.alpha).max(Ggx::SMOOTH_BELOW)));
                        Model::Coated(Coated::new(Coat::new(number(&coat.weight), coat.ior, facets), base))
                    }
                }
            }
        };
        Bsdf { frame: Frame::from_unit(hit.ns), ng: hit.ng, model }
    }

    /// Whether the lobe that is not a delta is that of microfacets. It focuses as a delta lobe does, more or less blurred,
    /// and belongs to the same class of events, S, whatever its width: no edge in width, nothing for the eye and photons to
    /// disagree about where a texture sets it, and measured with a small lamp behind rough glass photons are ahead of
    /// eye paths up to the widest lobe.
    pub fn is_glossy(&self) -> bool {
        match &self.model {
            Model::RoughDielectric(_) | Model::RoughConductor(_) => true,
            Model::Principled(m) => m.is_glossy(),
            Model::Coated(m) => m.is_glossy(),
            _ => false,
        }
    }
    /// Whether there is a lobe of class D.
    pub fn is_diffuse(&self) -> bool {
        self.has_scatter() && !self.is_glossy()
    }
    /// How a glossy surface sends light from `wo` to `wi`. `None` for other models, or where the two normals disagree.
    pub fn passage(&self, wo: Dir3, wi: Dir3) -> Option<Passage> {
        let (side, local) = self.pair(wo, wi)?;
        let arrival = &side.arrival;
        let [single, more] = match &self.model {
            Model::RoughDielectric(m) => m.parts(arrival, local),
            Model::RoughConductor(m) => m.parts(arrival, local),
            Model::Principled(m) if m.is_glossy() => m.parts(arrival, local),
            Model::Coated(m) if m.is_glossy() => m.parts(arrival, local),
            _ => return None,
        };
        if more > single {
            return Some(Passage::Many);
        }
        let eta = match (&self.model, self.principled()) {
            (Model::RoughDielectric(m), _) if local.z < 0.0 => Some(m.interface.eta(arrival)),
            // Straight through in the mean, whatever the facet.
            (_, Some(m)) if local.z < 0.0 && m.is_thin() => {
                return Some(Passage::Facet { normal: Normal3::from_unit(self.frame.n), eta: Some(1.0) });
            }
            (_, Some(m)) if local.z < 0.0 => Some(m.transmitted_eta(arrival)),
            _ => None,
        };
        // [Walter07 (16)]; for a mirroring facet the ratio is 1.
        let normal = Normal3::new(wo * eta.unwrap_or(1.0) + wi.to_vec())?;
        Some(Passage::Facet { normal, eta })
    }

    /// The principled surface that this is, or that its coat lies on.
    fn principled(&self) -> Option<&Principled> {
        match &self.model {
            Model::Principled(m) => Some(m),
            Model::Coated(m) => Some(m.base()),
            _ => None,
        }
    }

    /// Whether there is a delta lobe: a mirror, a smooth interface or coat.
    pub fn has_delta(&self) -> bool {
        match &self.model {
            Model::Mirror(_) | Model::Dielectric(_) | Model::Conductor(_) | Model::Plastic(_) => true,
            Model::Principled(m) => m.has_delta(),
            Model::Coated(m) => m.has_delta(),
            Model::Lambert(_) | Model::RoughDielectric(_) | Model::RoughConductor(_) => false,
        }
    }
    /// Whether there is a lobe that is not a delta.
    pub fn has_scatter(&self) -> bool {
        match &self.model {
            Model::Lambert(_) | Model::RoughDielectric(_) | Model::RoughConductor(_) | Model::Plastic(_) => true,
            Model::Principled(m) => m.has_scatter(),
            Model::Coated(m) => m.has_scatter(),
            Model::Mirror(_) | Model::Dielectric(_) | Model::Conductor(_) => false,
        }
    }
    /// Whether both normals put `w` on the same side; if not, everything about `w` is black here.
    pub fn normals_agree(&self, w: Dir3) -> bool {
        self.ng.dot(w) * w.dot(self.frame.n) > 0.0
    }

    /// |w·ns|, the cosine that goes with [`Bsdf::f`].
    pub fn shading_cosine(&self, w: Dir3) -> f64 {
        w.dot(self.frame.n).abs()
    }

    /// The non-delta part, 1/sr.
    pub fn f(&self, wo: Dir3, wi: Dir3, mode: TransportMode) -> Spectrum {
        let Some((side, wi)) = self.pair(wo, wi) else { return Spectrum::BLACK };
        self.local_f(&side, wi, mode)
    }

    /// The value of [`Bsdf::f`] for every `wi` on the side of `wo`, where it is the same for all and there is none on the
    /// other: `None` for other models.
    pub fn even_value(&self, wo: Dir3) -> Option<Spectrum> {
        let Model::Lambert(lambert) = &self.model else { return None };
        self.side(wo).map(|_| lambert.f(Vec3::Z))
    }

    /// Density of [`Bsdf::sample`] drawing `wi` from a lobe that is not a delta; its integral is the probability of that.
    /// This is the density for multiple importance sampling against [`Bsdf::sample`].
    /// No model of today draws differently in the two modes.
    pub fn pdf(&self, wo: Dir3, wi: Dir3, _mode: TransportMode) -> Pdf<SolidAngle> {
        let Some((side, wi)) = self.pair(wo, wi) else { return Pdf::ZERO };
        let share = self.scatter_share(&side, &self.deltas(&side));
        Pdf::new(share * self.local_pdf(&side, wi))
    }

    /// Density of [`Bsdf::sample_scatter`]: as [`Bsdf::pdf`], given that no delta lobe is chosen.
    pub fn pdf_scatter(&self, wo: Dir3, wi: Dir3, _mode: TransportMode) -> Pdf<SolidAngle> {
        let Some((side, wi)) = self.pair(wo, wi) else { return Pdf::ZERO };
        Pdf::new(self.local_pdf(&side, wi))
    }

    /// Draws from all lobes, each in proportion to its share of the light: `uc` chooses, `u` draws. `None` is
    /// absorption: a black surface, or a direction that the normals disagree about.
    pub fn sample(&self, wo: Dir3, uc: f64, u: [f64; 2], mode: TransportMode) -> Option<BsdfSample> {
        let side = self.side(wo)?;
        let deltas = self.deltas(&side);
        let share = self.scatter_share(&side, &deltas);
        if uc < share {
            return self.scatter(&side, share, uc / share, u, mode);
        }
        let total: f64 = deltas.iter().map(|b| b.weight.mean()).sum();
        let mut left = (uc - share) / (1.0 - share) * total;
        // Rounding may leave a remainder behind the last branch, which then takes it.
        let last = deltas.len().checked_sub(1)?;
        let chosen = deltas.iter().enumerate().find_map(|(i, branch)| {
            left -= branch.weight.mean();
            (left < 0.0 || i == last).then_some(branch)
        })?;
        let probability = (1.0 - share) * chosen.weight.mean() / total;
        if chosen.weight.is_black() {
            return None;
        }
        let event = match chosen.eta {
            Some(eta) => Event::DeltaTransmission { probability, eta },
            None => Event::DeltaReflection { probability },
        };
        Some(BsdfSample { wi: chosen.wi, weight: chosen.transport_weight(mode) / probability, event })
    }

    /// Draws from the lobes that are not deltas, the density being [`Bsdf::pdf_scatter`].
    pub fn sample_scatter(&self, wo: Dir3, uc: f64, u: [f64; 2], mode: TransportMode) -> Option<BsdfSample> {
        self.scatter(&self.side(wo)?, 1.0, uc, u, mode)
    }

    /// Every delta lobe at once. A smooth dielectric has the mirrored and the refracted one, or at total reflection the
    /// mirrored one alone with weight 1. Empty where the normals disagree about `wo`; a lobe whose direction they
    /// disagree about is left out.
    pub fn delta_branches(&self, wo: Dir3) -> DeltaBranches {
        match self.side(wo) {
            Some(side) => self.deltas(&side),
            None => {
                let mut none = DeltaBranches::none();
                if self.has_delta() {
                    none.refuse();
                }
                none
            }
        }
    }

    /// The fraction of the light from `wo` that leaves again. Exact for smooth and diffuse models; rough ones answer for
    /// their mean facet, which is above what a single bounce returns.
    pub fn albedo(&self, wo: Dir3) -> Spectrum {
        let Some(Side { arrival, .. }) = self.side(wo) else { return Spectrum::BLACK };
        match &self.model {
            Model::Lambert(m) => m.albedo(&arrival),
            Model::Mirror(m) => m.albedo(&arrival),
            Model::Dielectric(m) => m.albedo(&arrival),
            Model::Conductor(m) => m.albedo(&arrival),
            Model::RoughDielectric(m) => m.albedo(&arrival),
            Model::RoughConductor(m) => m.albedo(&arrival),
            Model::Plastic(m) => m.albedo(&arrival),
            Model::Principled(m) => m.albedo(&arrival),
            Model::Coated(m) => m.albedo(&arrival),
        }
    }

    /// The frame on the side of `wo`, if both normals agree about it.
    fn side(&self, wo: Dir3) -> Option<Side> {
        if !self.normals_agree(wo) {
            return None;
        }
        let outside = self.ng.dot(wo) > 0.0;
        let Frame { t, b, n } = self.frame;
        // Turned about t, so that it stays right-handed.
        let frame = if outside { self.frame } else { Frame { t, b: -b, n: -n } };
        let ng = if outside { self.ng } else { -self.ng };
        Some(Side { frame, ng, arrival: Arrival { wo: frame.to_local(wo), outside } })
    }

    /// `wo`'s side and the local `wi`, if the normals agree about both.
    fn pair(&self, wo: Dir3, wi: Dir3) -> Option<(Side, Vec3)> {
        let side = self.side(wo)?;
        let local = side.frame.to_local(wi);
        side.admits(local, wi).then_some((side, local))
    }

    fn local_f(&self, side: &Side, wi: Vec3, mode: TransportMode) -> Spectrum {
        let arrival = &side.arrival;
        match &self.model {
            Model::Lambert(m) => m.f(wi),
            Model::RoughDielectric(m) => {
                let eta = m.interface.eta(arrival);
                let spread = if mode == TransportMode::Radiance && wi.z < 0.0 { eta * eta } else { 1.0 };
                m.f(arrival, wi) * spread
            }
            Model::RoughConductor(m) => m.f(arrival, wi),
            Model::Plastic(m) => m.f(arrival, wi),
            Model::Principled(m) => {
                let eta = m.transmitted_eta(arrival);
                let spread = if mode == TransportMode::Radiance && wi.z < 0.0 { eta * eta } else { 1.0 };
                m.f(arrival, wi) * spread
            }
            Model::Coated(m) => {
                let eta = m.base().transmitted_eta(arrival);
                let spread = if mode == TransportMode::Radiance && wi.z < 0.0 { eta * eta } else { 1.0 };
                m.f(arrival, wi) * spread
            }
            Model::Mirror(_) | Model::Dielectric(_) | Model::Conductor(_) => Spectrum::BLACK,
        }
    }

    fn local_pdf(&self, side: &Side, wi: Vec3) -> f64 {
        match &self.model {
            Model::Lambert(m) => m.pdf(wi),
            Model::RoughDielectric(m) => m.pdf(&side.arrival, wi),
            Model::RoughConductor(m) => m.pdf(&side.arrival, wi),
            Model::Plastic(m) => m.pdf(wi),
            Model::Principled(m) => m.pdf(&side.arrival, wi),
            Model::Coated(m) => m.pdf(&side.arrival, wi),
            Model::Mirror(_) | Model::Dielectric(_) | Model::Conductor(_) => 0.0,
        }
    }

    /// Draws from the non-delta lobes, which were chosen with probability `share`.
    fn scatter(&self, side: &Side, share: f64, uc: f64, u: [f64; 2], mode: TransportMode) -> Option<BsdfSample> {
        let arrival = &side.arrival;
        let local = match &self.model {
            Model::Lambert(m) => m.sample(u),
            Model::RoughDielectric(m) => m.sample(arrival, uc, u),
            Model::RoughConductor(m) => m.sample(arrival, uc, u),
            Model::Plastic(m) => m.sample(u),
            Model::Principled(m) => m.sample(arrival, uc, u),
            Model::Coated(m) => m.sample(arrival, uc, u),
            Model::Mirror(_) | Model::Dielectric(_) | Model::Conductor(_) => None,
        }?;
        let wi = side.to_world(local);
        let pdf = share * self.local_pdf(side, local);
        if !side.admits(local, wi) || pdf <= 0.0 {
            return None;
        }
        let weight = self.local_f(side, local, mode) * (local.z.abs() / pdf);
        (!weight.is_black()).then_some(BsdfSample { wi, weight, event: Event::Scatter { pdf: Pdf::new(pdf) } })
    }

    /// The delta lobes in the world.
    fn deltas(&self, side: &Side) -> DeltaBranches {
        let arrival = &side.arrival;
        let local: LocalDeltas = match &self.model {
            Model::Mirror(m) => m.deltas(arrival),
            Model::Dielectric(m) => m.deltas(arrival),
            Model::Conductor(m) => m.deltas(arrival),
            Model::Plastic(m) => m.deltas(arrival),
            Model::Principled(m) => m.deltas(arrival),
            Model::Coated(m) => m.deltas(arrival),
            Model::Lambert(_) | Model::RoughDielectric(_) | Model::RoughConductor(_) => [None; 2],
        };
        let mut list = DeltaBranches::none();
        for delta in local.into_iter().flatten() {
            let wi = side.to_world(delta.wi);
            if side.admits(delta.wi, wi) {
                list.push(DeltaBranch { wi, weight: delta.weight, eta: delta.eta });
            } else {
                list.refuse();
            }
        }
        list
    }

    /// The probability with which [`Bsdf::sample`] takes a non-delta lobe.
    fn scatter_share(&self, side: &Side, deltas: &DeltaBranches) -> f64 {
        match &self.model {
            Model::Lambert(_) | Model::RoughDielectric(_) | Model::RoughConductor(_) => 1.0,
            Model::Plastic(m) => {
                let base = m.scatter_albedo(&side.arrival).mean();
                let coat: f64 = deltas.iter().map(|b| b.weight.mean()).sum();
                if base > 0.0 { base / (base + coat) } else { 0.0 }
            }
            Model::Principled(m) => m.scatter_share(&side.arrival, deltas.iter().map(|b| b.weight.mean()).sum()),
            Model::Coated(m) => m.scatter_share(&side.arrival, deltas.iter().map(|b| b.weight.mean()).sum()),
            Model::Mirror(_) | Model::Dielectric(_) | Model::Conductor(_) => 0.0,
        }
    }
}
