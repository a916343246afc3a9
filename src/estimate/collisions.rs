//! What collisions of photons say along a piece of an eye's ray, and at a place in a medium · W/(m²·sr) ·
//! PHOTON_DIFFERENTIALS 8 `[Jarosz11]`.
//!
//! Along a ray the blur is two-dimensional, by the collision's form Q₃ as it is seen along the ray, C = Eᵀ (Q₃ + Q_eye) E:
//!
//!   L = Σ (Φ T/p) T_e(s_e) σ_s p(cos) K₂(dᵀ C⁻¹ d)/√det C,  d at right angles to the ray.
//!
//! At a place it is three-dimensional, and the light is what comes in, of which the medium scatters σ_s ρ a metre:
//!
//!   L_in = Σ (Φ T/p) p(cos) K₃(dᵀ Q₃⁻¹ d)/(ρ √det Q₃).

use super::beams::{EyeSegment, Place};
use super::kernel;
use crate::math::{Frame, Vec3};
use crate::medium::HenyeyGreenstein;
use crate::photon::Collision;
use crate::photon::collision_map::CollisionMap;
use crate::photon::footprint::TangentForm;
use crate::photon::index::SlabRay;
use crate::radiometry::{Radiance, Spectrum};
use crate::scene::settings::KernelShape;

/// Light that collisions bring to the start of the segment.
pub fn radiance(map: &CollisionMap, kernel: KernelShape, segment: &EyeSegment) -> Radiance {
    let ray = segment.slab_ray();
    Radiance(pulp::Arch::new().dispatch(Seen { map, kernel, segment, ray: &ray }))
}

/// [`radiance`] as the processor at hand does it best.
struct Seen<'a> {
    map: &'a CollisionMap,
    kernel: KernelShape,
    segment: &'a EyeSegment<'a>,
    ray: &'a SlabRay,
}

impl pulp::NullaryFnOnce for Seen<'_> {
    type Output = Spectrum;

    #[inline(always)]
    fn call(self) -> Spectrum {
        let Seen { map, kernel, segment, ray } = self;
        let (phase, frame) = (HenyeyGreenstein::new(segment.medium.asymmetry), Frame::from_unit(segment.w));
        let mut sum = Spectrum::BLACK;
        map.along(ray, |collision| {
            if collision.medium == segment.id && collision.bounces <= segment.bounces {
                sum += seen(collision, kernel, &phase, segment, &frame);
            }
        });
        sum
    }
}

/// What one collision adds along the ray, whose plane has the axes of `frame`.
fn seen(
    collision: &Collision,
    kernel: KernelShape,
    phase: &HenyeyGreenstein,
    segment: &EyeSegment,
    frame: &Frame,
) -> Spectrum {
    let apart = collision.p - segment.origin;
    let s_e = apart.dot(segment.w.to_vec());
    if !(0.0 <= s_e && s_e < segment.length) {
        return Spectrum::BLACK;
    }
    let eye = TangentForm::from_axes(frame, segment.eye.map(|(dx, dw)| dx + dw * s_e));
    let form = collision.seen_along(frame).plus(eye);
    let determinant = form.determinant();
    let t = form.adjugate_form(frame.project(apart)) / determinant;
    // Also where it has no width at all.
    if t.is_nan() || t >= 1.0 {
        return Spectrum::BLACK;
    }
    let weight = kernel::evaluate(kernel, t) / determinant.sqrt() * phase.between(collision.w, -segment.w);
    let medium = segment.medium;
    let (_, before) = segment.profile.at(s_e);
    collision.light * medium.transmittance(before) * medium.scattering * weight
}

/// Light that collisions bring to a place, as far as it would be scattered towards the eye there.
pub fn radiance_at(map: &CollisionMap, kernel: KernelShape, place: &Place) -> Radiance {
    let phase = HenyeyGreenstein::new(place.medium.asymmetry);
    let density = place.medium.density.as_ref().map_or(1.0, |grid| grid.at(place.p));
    let mut sum = Spectrum::BLACK;
    map.over(place.p, |collision| {
        if collision.medium == place.id && collision.bounces <= place.bounces {
            sum += at(collision, kernel, &phase, place);
        }
    });
    Radiance(if density > 0.0 { sum / density } else { Spectrum::BLACK })
}

/// What one collision adds at a place. Only what of the eye's footprint lies across its way widens it.
fn at(collision: &Collision, kernel: KernelShape, phase: &HenyeyGreenstein, place: &Place) -> Spectrum {
    let (frame, apart): (Frame, Vec3) = (collision.frame(), place.p - collision.p);
    let across = collision.across.plus(TangentForm::from_axes(&frame, place.eye));
    let along = apart.dot(collision.w.to_vec()) / collision.along;
    let determinant = across.determinant();
    let t = across.adjugate_form(frame.project(apart)) / determinant + along * along;
    if t.is_nan() || t >= 1.0 {
        return Spectrum::BLACK;
    }
    let volume = determinant.sqrt() * collision.along;
    collision.light * (kernel::evaluate_ball(kernel, t) / volume * phase.between(collision.w, -place.w))
}
