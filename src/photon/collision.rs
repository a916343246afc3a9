//! Places where photons meet a medium: points of light in space, for the estimates that ask points instead of beams.
//!
//! A collision is drawn on a beam, n of them in as many parts of equal chance. Its form is three-dimensional: across the way
//! it is the beam's, Q(s), along it the cell of the free flight, of the length ℓ = 1/(n p(s)),
//!
//!   Q₃ = Q(s) + (½ ℓ)² w wᵀ, widened by the scale of the spread (PHOTON_DIFFERENTIALS 8).
//!
//! World frame, metres, W.

use super::beam::Beam;
use super::footprint::{Spread, TangentForm};
use crate::math::{Dir3, Frame, Point3, Vec2, Vec3};
use crate::medium::Way;
use crate::radiometry::Spectrum;
use crate::sampling::Stream;
use crate::scene::{Medium, MediumId};

/// A place on a photon's way through a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    pub p: Point3,
    /// The way that the light went.
    pub w: Dir3,
    /// Φ T/(n p): flux times the column that the place stands for, W m; σ_s times it is scattered.
    pub light: Spectrum,
    pub medium: MediumId,
    /// How often the photon was scattered, D, before.
    pub bounces: u32,
    /// Q₃ across the way, in the axes (t, b) of the frame about it, m².
    pub across: TangentForm,
    /// Semi-axis along the way, m.
    pub along: f64,
}

impl Collision {
    /// The axes of its form.
    pub fn frame(&self) -> Frame {
        Frame::from_unit(self.w)
    }

    /// Half extents along the world's axes.
    pub fn half_extents(&self) -> Vec3 {
        let (across, along) = (self.across.world_half_extents(&self.frame()), self.w.to_vec() * self.along);
        Vec3::new(across.x.hypot(along.x), across.y.hypot(along.y), across.z.hypot(along.z))
    }

    /// Eᵀ Q₃ E: the form as it is seen along a ray, in the axes (t, b) of the frame about that.
    pub fn seen_along(&self, ray: &Frame) -> TangentForm {
        let own = self.frame();
        let [e, f]: [Vec2; 2] = [ray.t, ray.b].map(|axis| own.project(axis));
        let [a, b] = [ray.t, ray.b].map(|axis| self.w.dot(axis) * self.along);
        TangentForm {
            xx: self.across.along(e) + a * a,
            xy: self.across.between(e, f) + a * b,
            yy: self.across.along(f) + b * b,
        }
    }
}

impl Beam {
    /// Draws `count` collisions on it and hands them to `each`.
    pub fn collide(
        &self,
        medium: &Medium,
        count: u32,
        spread: Spread,
        stream: &mut Stream,
        mut each: impl FnMut(Collision),
    ) {
        let n = f64::from(count);
        let way = Way { medium, origin: self.origin, w: self.w, from: 0.0, to: self.length };
        for k in 0..count {
            let [channel, u] = stream.uniform2();
            let u = [channel, (f64::from(k) + u) / n];
            let Some((s, left, density)) = way.place_within(self.flux.0, u) else { continue };
            let p = self.at(s);
            let per_metre = density * medium.density.as_ref().map_or(1.0, |grid| grid.at(p));
            let cell = (1.0 / (n * per_metre)).min(self.length);
            let along = match spread {
                Spread::Columns { scale, .. } => 0.5 * scale * cell,
                Spread::Disc { radius } => radius,
            };
            let light = self.flux.0 * left / (n * density);
            let (w, medium, bounces) = (self.w, self.medium, self.bounces);
            each(Collision { p, w, light, medium, bounces, across: self.width.at(s), along });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photon::BeamWidth;
    use crate::radiometry::Flux;
    use crate::sampling::Purpose;
    use crate::scene::settings::FootprintRule;

    fn direction(x: f64, y: f64, z: f64) -> Dir3 {
        Dir3::new(Vec3::new(x, y, z)).expect("not zero")
    }

    /// Q₃ = Σ a aᵀ of three axes, and what of it is seen along a ray is the sum over the axes as they are seen.
    #[test]
    fn a_ray_sees_the_projection_of_all_three_axes() {
        let w = direction(0.3, -0.5, 0.7);
        let frame = Frame::from_unit(w);
        let axes = [frame.t * 0.3 + frame.b * 0.1, frame.b * 0.2 - frame.t * 0.05];
        let collision = Collision {
            p: Point3::ORIGIN,
            w,
            light: Spectrum::ONE,
            medium: MediumId(0),
            bounces: 0,
            across: TangentForm::from_axes(&frame, axes),
            along: 0.4,
        };
        let all = [axes[0], axes[1], w * 0.4];
        for ray in [direction(1.0, 0.2, 0.1), direction(0.3, -0.5, 0.7), direction(-0.2, 0.9, 0.4)] {
            let ray = Frame::from_unit(ray);
            let (expected, found) = (TangentForm::from_axes(&ray, all), collision.seen_along(&ray));
            for (a, b) in [(expected.xx, found.xx), (expected.xy, found.xy), (expected.yy, found.yy)] {
                assert!((a - b).abs() < 1e-15, "{expected:?} {found:?}");
            }
        }
        let extents = collision.half_extents().to_array();
        for (k, axis) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
            let squared: f64 = all.iter().map(|a| a.dot(axis).powi(2)).sum();
            assert!((extents[k] - squared.sqrt()).abs() < 1e-15);
        }
    }

    /// Σ (Φ T/(n p)) f(s) = ∫ Φ T f ds: of f = 1 exactly where one channel alone is drawn from, and cells tile the way.
    #[test]
    fn collisions_stand_for_the_light_on_the_whole_way() {
        let medium = Medium {
            absorption: Spectrum::splat(0.3),
            scattering: Spectrum::splat(0.5),
            asymmetry: 0.0,
            density: None,
        };
        let beam = Beam {
            origin: Point3::ORIGIN,
            w: direction(1.0, 2.0, 2.0),
            length: 3.0,
            flux: Flux(Spectrum::splat(2.0)),
            medium: MediumId(0),
            bounces: 0,
            width: BeamWidth::disc(0.1),
        };
        let spread = Spread::Columns { rule: FootprintRule::Quadratic, scale: 2.0 };
        let (mut light, mut cells) = (0.0, 0.0);
        let n = 50;
        beam.collide(&medium, n, spread, &mut Stream::new(8, Purpose::Test, 0, 0), |c| {
            light += c.light.g();
            cells += c.along;
            assert_eq!(c.across, beam.width.at(0.0));
        });
        let expected = 2.0 * (1.0 - (-0.8f64 * 3.0).exp()) / 0.8;
        assert!((light / expected - 1.0).abs() < 1e-12, "{light}, not {expected}");
        // Stratified: the sum of 1/(n p) at one point in each stratum is the way's length but for the ends' strata, whose
        // cells are as long as 1/(n p) is at most.
        let longest = (1.0 - (-2.4f64).exp()) / (0.8 * (-2.4f64).exp()) / f64::from(n);
        assert!((cells - 3.0).abs() < longest, "{cells}");
    }
}
