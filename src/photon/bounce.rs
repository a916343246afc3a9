//! Whither a photon goes on from a surface that scatters: as its BSDF says, or towards the objects that make caustics.
//!
//! Light that a floor sends through a glass back to the floor leaves it in a small part of the hemisphere, the only part
//! that matters here. Half of the photons go there, evenly over the cone that holds those objects; all count with the
//! density of the mixture, ½ p_aim + ½ p_bsdf (the balance heuristic, `[Veach97 9.2]`).

use crate::light::{Aim, Directions};
use crate::math::Dir3;
use crate::radiometry::{Pdf, SolidAngle, Spectrum};
use crate::sampling::Stream;
use crate::surface::adjoint::shading_normal_factor;
use crate::surface::{Bsdf, Interaction, TransportMode};

/// Which part of the photons is aimed, where there is something to aim at.
const AIMED: f64 = 0.5;

/// How photons bounce.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounces {
    /// Around the objects that make caustics.
    pub aim: Aim,
    /// So many photons share all directions out between them: the cell of each is 1/(sharing p), sr.
    pub sharing: f64,
    /// Which part of the photons that could bounce does, at random.
    pub share: f64,
    /// Bounces of a photon at most.
    pub max: u32,
}

/// A photon's next direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    pub wi: Dir3,
    /// On the photon's flux: f |cos| / pdf, with the particles' correction for shading normals.
    pub weight: Spectrum,
    pub pdf: Pdf<SolidAngle>,
    /// Whether it goes where light is wanted.
    pub aimed: bool,
}

impl Bounces {
    /// Draws a direction from the lobes that are not deltas. `None` is absorption.
    pub fn sample(&self, si: &Interaction, bsdf: &Bsdf, stream: &mut Stream) -> Option<Bounce> {
        let mode = TransportMode::Importance;
        let (choice, uc, u) = (stream.uniform(), stream.uniform(), stream.uniform2());
        let cone = Some(Directions::towards(si.p, &self.aim)).filter(|to| *to != Directions::Sphere);
        let wi = match &cone {
            Some(cone) if choice < AIMED => cone.sample(u),
            _ => bsdf.sample_scatter(si.wo, uc, u, mode)?.wi,
        };
        let own = bsdf.pdf_scatter(si.wo, wi, mode);
        let (mut pdf, mut aimed) = (own, false);
        if let Some(cone) = cone {
            aimed = cone.contains(wi);
            let to_cone = if aimed { cone.pdf() } else { Pdf::ZERO };
            pdf = Pdf::new(AIMED * to_cone.get() + (1.0 - AIMED) * own.get());
        }
        let cosine = bsdf.shading_cosine(wi) * shading_normal_factor(si.wo, wi, si.ns, si.ng);
        let weight = bsdf.f(si.wo, wi, mode) * (cosine / pdf.get());
        (!weight.is_black()).then_some(Bounce { wi, weight, pdf, aimed })
    }

    /// The cell of a direction with this density, sr.
    pub fn cell(&self, pdf: Pdf<SolidAngle>) -> f64 {
        1.0 / (self.sharing * pdf.get())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Normal3, Point3, Vec3};
    use crate::sampling::Purpose;
    use crate::surface::test_support::{flat_at, lambert_at};
    use std::f64::consts::PI;

    const POINTS: u64 = 200_000;

    /// ∫ f cos g dω = ∫ ρ/π cos² dω = ⅔ ρ for g = cos, from outside the aim and from within; and what is drawn has the
    /// density that is claimed: the mean of 1/pdf over a cap is the cap's solid angle. Within five standard errors.
    #[test]
    fn bounces_have_the_mean_and_the_density_that_they_claim() {
        let (si, bsdf) = (flat_at(Point3::ORIGIN, Normal3::Z), lambert_at(Point3::ORIGIN, Normal3::Z, 0.7));
        let axis = Dir3::new(Vec3::new(1.0, 0.0, 1.0)).expect("non-zero");
        for radius in [0.4, 3.0] {
            let aim = Aim::Sphere { centre: Point3::from_vec(axis * 1.5), radius };
            let bounces = Bounces { aim, sharing: 1.0, share: 1.0, max: 1 };
            let mut moments = [[0.0; 2]; 2];
            for i in 0..POINTS {
                let mut stream = Stream::new(5, Purpose::Test, 0, i);
                let Some(bounce) = bounces.sample(&si, &bsdf, &mut stream) else { continue };
                let inside = if bounce.wi.dot(axis) > 0.9 { 1.0 / bounce.pdf.get() } else { 0.0 };
                for (moment, x) in moments.iter_mut().zip([bounce.weight.mean() * bounce.wi.z, inside]) {
                    *moment = [moment[0] + x, moment[1] + x * x];
                }
            }
            let n = POINTS as f64;
            for ([sum, squares], expected) in moments.into_iter().zip([0.7 * 2.0 / 3.0, 2.0 * PI * 0.1]) {
                let (mean, variance) = (sum / n, squares / n - (sum / n).powi(2));
                assert!((mean - expected).abs() < 5.0 * (variance / n).sqrt(), "{radius}: {mean}, not {expected}");
            }
        }
    }
}
