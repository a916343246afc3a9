//! Whither an eye path goes on from a surface that scatters: as its BSDF says, or towards the objects that make caustics.
//!
//! Light that a glass or a mirror sends back to a floor comes from a small part of the hemisphere, often the only part
//! that is not dark. A share α of the samples goes there, evenly over the cone that holds those objects; all count with
//! the density of the mixture, α p_aim + (1 − α) p_bsdf (the balance heuristic, `[Veach97 9.2]`), which is unbiased for
//! every α below 1.

use crate::light::{Aim, Directions};
use crate::math::{Dir3, Point3};
use crate::radiometry::{Pdf, SolidAngle};
use crate::surface::{Bsdf, BsdfSample, Event, Interaction, TransportMode};

/// How bounces are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounces {
    /// Around the objects that make caustics.
    pub aim: Aim,
    /// α, below 1.
    pub aimed: f64,
}

impl Bounces {
    /// By the BSDF alone.
    pub const UNAIMED: Bounces = Bounces { aim: Aim::Everywhere, aimed: 0.0 };

    /// The density of the aimed samples; `None` from where nothing is aimed at, inside the aim's sphere.
    pub fn aimed_pdf(&self, from: Point3, wi: Dir3) -> Option<Pdf<SolidAngle>> {
        self.cone(from).map(|cone| pdf_in(&cone, wi))
    }

    /// The cone that is aimed at, if it is.
    fn cone(&self, from: Point3) -> Option<Directions> {
        if self.aimed == 0.0 {
            return None;
        }
        Some(Directions::towards(from, &self.aim)).filter(|directions| *directions != Directions::Sphere)
    }

    fn mixed(&self, cone: &Directions, own: Pdf<SolidAngle>, wi: Dir3) -> Pdf<SolidAngle> {
        Pdf::new(self.aimed * pdf_in(cone, wi).get() + (1.0 - self.aimed) * own.get())
    }

    /// Density of [`Bounces::sample`] drawing `wi` from a lobe that is not a delta.
    pub fn pdf(&self, si: &Interaction, bsdf: &Bsdf, wi: Dir3) -> Pdf<SolidAngle> {
        let own = bsdf.pdf(si.wo, wi, TransportMode::Radiance);
        self.cone(si.p).map_or(own, |cone| self.mixed(&cone, own, wi))
    }

    /// Draws a direction: `uc` chooses, `u` draws. `None` is absorption.
    pub fn sample(&self, si: &Interaction, bsdf: &Bsdf, uc: f64, u: [f64; 2]) -> Option<BsdfSample> {
        let mode = TransportMode::Radiance;
        let Some(cone) = self.cone(si.p).filter(|_| bsdf.has_scatter()) else {
            return bsdf.sample(si.wo, uc, u, mode);
        };
        let wi = if uc < self.aimed {
            cone.sample(u)
        } else {
            let sample = bsdf.sample(si.wo, (uc - self.aimed) / (1.0 - self.aimed), u, mode)?;
            if !matches!(sample.event, Event::Scatter { .. }) {
                return Some(BsdfSample { weight: sample.weight * (1.0 / (1.0 - self.aimed)), ..sample });
            }
            sample.wi
        };
        let pdf = self.mixed(&cone, bsdf.pdf(si.wo, wi, mode), wi);
        let weight = bsdf.f(si.wo, wi, mode) * (bsdf.shading_cosine(wi) / pdf.get());
        (!weight.is_black()).then_some(BsdfSample { wi, weight, event: Event::Scatter { pdf } })
    }
}

fn pdf_in(cone: &Directions, wi: Dir3) -> Pdf<SolidAngle> {
    if cone.contains(wi) { cone.pdf() } else { Pdf::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Normal3, Vec3};
    use crate::sampling::qmc;
    use crate::surface::test_support::{flat_at, lambert_at};
    use std::f64::consts::PI;

    const POINTS: u64 = 100_000;

    /// ∫ f cos g dω = ∫ ρ/π cos² dω = ⅔ ρ for g = cos, whatever share is aimed, from outside the aim and from within; and
    /// what is drawn has the density that is claimed: the mean of 1/pdf over a cap is the cap's solid angle.
    #[test]
    fn any_share_has_the_same_mean_and_the_density_it_claims() {
        let (si, bsdf) = (flat_at(Point3::ORIGIN, Normal3::Z), lambert_at(Point3::ORIGIN, Normal3::Z, 0.7));
        let axis = Dir3::new(Vec3::new(1.0, 0.0, 1.0)).expect("non-zero");
        for radius in [0.4, 3.0] {
            for aimed in [0.0, 0.25, 0.5, 0.9] {
                let aim = Aim::Sphere { centre: Point3::from_vec(axis * 1.5), radius };
                let bounces = Bounces { aim, aimed };
                let (mut sum, mut cap) = (0.0, 0.0);
                for i in 0..POINTS {
                    let uc = (i as f64 + 0.5) * 0.618_033_988_749_894_9 % 1.0;
                    let Some(sample) = bounces.sample(&si, &bsdf, uc, qmc::r2(i)) else { continue };
                    let Event::Scatter { pdf } = sample.event else { panic!("a delta lobe of a matte surface") };
                    assert!((bounces.pdf(&si, &bsdf, sample.wi).get() / pdf.get() - 1.0).abs() < 1e-12);
                    sum += sample.weight.mean() * sample.wi.to_vec().z;
                    cap += if sample.wi.dot(axis) > 0.9 { 1.0 / pdf.get() } else { 0.0 };
                }
                let n = POINTS as f64;
                assert!((sum / n / (0.7 * 2.0 / 3.0) - 1.0).abs() < 2e-3, "{radius} {aimed}: {}", sum / n);
                assert!((cap / n / (2.0 * PI * 0.1) - 1.0).abs() < 5e-3, "{radius} {aimed}: {}", cap / n);
            }
        }
    }
}
