//! Whither a photon goes on from a surface that scatters: as its BSDF says, or towards the objects that make caustics.
//!
//! Light that a floor sends through a glass back to the floor leaves it in a small part of the hemisphere, the only part
//! that matters here. Half of the photons go there, evenly over the cone that holds those objects; all count with the
//! density of the mixture, ½ p_aim + ½ p_bsdf (the balance heuristic, `[Veach97 9.2]`).

use std::f64::consts::TAU;

use crate::differential::{Differential, bounced};
use crate::light::{Aim, Directions};
use crate::math::{Dir3, Normal3, Point3};
use crate::medium::HenyeyGreenstein;
use crate::radiometry::{Pdf, SolidAngle, Spectrum};
use crate::sampling::Stream;
use crate::scene::settings::BounceFootprint;
use crate::surface::adjoint::shading_normal_factor;
use crate::surface::{Bsdf, Interaction, TransportMode};

/// Which part of the photons is aimed, where there is something to aim at.
const AIMED: f64 = 0.5;

/// How photons bounce.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounces {
    /// Around the objects that make caustics; `Everywhere` if there are none.
    pub aim: Aim,
    /// What a photon stands for afterwards.
    pub footprint: BounceFootprint,
    /// Photons of its kind.
    pub photons: f64,
    /// How many times its own share of the directions a photon's cell is: they are drawn, not even.
    pub overlap: f64,
    /// Of all surfaces, m²: what [`BounceFootprint::Coverage`] shares out; others do not look at it.
    pub area: f64,
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

    /// The same in a medium at `p`, to which light came along `w`.
    pub fn sample_in_medium(&self, p: Point3, w: Dir3, phase: &HenyeyGreenstein, stream: &mut Stream) -> Bounce {
        let (choice, u) = (stream.uniform(), stream.uniform2());
        let cone = Some(Directions::towards(p, &self.aim)).filter(|to| *to != Directions::Sphere);
        let wi = match &cone {
            Some(cone) if choice < AIMED => cone.sample(u),
            _ => phase.turn(w, u).0,
        };
        let own = phase.between(w, wi);
        let (mut pdf, mut aimed) = (own, false);
        if let Some(cone) = cone {
            aimed = cone.contains(wi);
            let to_cone = if aimed { cone.pdf() } else { Pdf::ZERO };
            pdf = AIMED * to_cone.get() + (1.0 - AIMED) * own;
        }
        Bounce { wi, weight: Spectrum::splat(own / pdf), pdf: Pdf::new(pdf), aimed }
    }

    /// The columns of a photon that bounces for the `nth` time, counted from 1, into `bounce`; they were put on the surface
    /// with normal `ng` by [`crate::differential::transfer()`].
    pub fn columns<const N: usize>(
        &self,
        columns: &Differential<N>,
        ng: Normal3,
        bounce: &Bounce,
        nth: u32,
    ) -> Differential<N> {
        let (n, p) = (self.photons, bounce.pdf.get());
        let bounced = |patch: &Differential<N>, cell| bounced(patch, ng, bounce.wi, cell);
        match self.footprint {
            BounceFootprint::Shared => bounced(columns, self.overlap / (n * p)),
            BounceFootprint::Root => bounced(columns, self.overlap / (n.sqrt() * p)),
            BounceFootprint::Reset => bounced(&Differential::ZERO, self.overlap / (n * p)),
            BounceFootprint::Coverage => bounced(columns, UNIT_CELL),
            BounceFootprint::Path => {
                // One more choice: each of the former has had n^(1/nth) cells.
                let [before, now] = [nth, nth + 1].map(|choices| n.powf(1.0 / f64::from(choices)));
                bounced(&columns.scaled((before / now).sqrt()), self.overlap / (now * p))
            }
        }
    }

    /// The columns of a photon that comes straight from a bounce and lands at `si`: [`BounceFootprint::Coverage`] knows
    /// only now how far the cell of directions reaches.
    pub fn landing<const N: usize>(&self, columns: &Differential<N>, si: &Interaction) -> Differential<N> {
        if self.footprint != BounceFootprint::Coverage {
            return *columns;
        }
        let cell = (self.overlap * self.area / self.photons * si.ng.dot(si.wo).abs() / (si.t * si.t)).min(TAU);
        let widened = (cell / UNIT_CELL).sqrt();
        columns.scaled_each(std::array::from_fn(|k| if k < N / 2 { 1.0 } else { widened }))
    }
}

/// Of columns that are scaled when the photon lands, sr.
const UNIT_CELL: f64 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::differential::Column;
    use crate::math::{Normal3, Vec3};
    use crate::sampling::Purpose;
    use crate::surface::test_support::{flat_at, lambert_at};
    use std::f64::consts::PI;

    const POINTS: u64 = 200_000;

    fn bounces(aim: Aim, footprint: BounceFootprint) -> Bounces {
        Bounces { aim, footprint, photons: 100.0, overlap: 4.0, area: 7.0, share: 1.0, max: 1 }
    }

    /// ∫ f cos g dω = ∫ ρ/π cos² dω = ⅔ ρ for g = cos, from outside the aim and from within; and what is drawn has the
    /// density that is claimed: the mean of 1/pdf over a cap is the cap's solid angle. Within five standard errors.
    #[test]
    fn bounces_have_the_mean_and_the_density_that_they_claim() {
        let (si, bsdf) = (flat_at(Point3::ORIGIN, Normal3::Z), lambert_at(Point3::ORIGIN, Normal3::Z, 0.7));
        let axis = Dir3::new(Vec3::new(1.0, 0.0, 1.0)).expect("non-zero");
        for radius in [0.4, 3.0] {
            let aim = Aim::Sphere { centre: Point3::from_vec(axis * 1.5), radius };
            let bounces = bounces(aim, BounceFootprint::Shared);
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

    /// Areas of the patch and of the cell of directions that each policy leaves behind: n = 100 photons of which four share
    /// a place, a patch of 1 m² and a direction with p = 2/sr.
    #[test]
    fn policies_leave_the_areas_that_they_promise() {
        let si = flat_at(Point3::ORIGIN, Normal3::Z);
        let side = std::f64::consts::FRAC_2_SQRT_PI;
        let patch = [Vec3::X * side, Vec3::Y * side, Vec3::ZERO, Vec3::ZERO].map(Column::position);
        let bounce = Bounce { wi: Dir3::Z, weight: Spectrum::ONE, pdf: Pdf::new(2.0), aimed: false };
        let area = |a: Vec3, b: Vec3| std::f64::consts::FRAC_PI_4 * a.cross(b).length();
        for (footprint, nth, expected) in [
            (BounceFootprint::Shared, 1, [1.0, 0.02]),
            (BounceFootprint::Root, 1, [1.0, 0.2]),
            (BounceFootprint::Reset, 1, [0.0, 0.02]),
            (BounceFootprint::Path, 1, [10.0, 0.2]),
            (BounceFootprint::Path, 2, [100f64.powf(1.0 / 6.0), 2.0 / 100f64.cbrt()]),
            // 4 of 7 m²/100 seen at the distance of `si`, at right angles.
            (BounceFootprint::Coverage, 1, [1.0, 0.28 / (si.t * si.t) * si.ng.dot(si.wo).abs()]),
        ] {
            let bounces = bounces(Aim::Everywhere, footprint);
            let after = bounces.landing(&bounces.columns(&Differential::<4>::new(patch), si.ng, &bounce, nth), &si);
            let found = [area(after.dx.get(0), after.dx.get(1)), area(after.dw.get(2), after.dw.get(3))];
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{footprint:?}: {found}, not {expected}");
            }
        }
    }
}
