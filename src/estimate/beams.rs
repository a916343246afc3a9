//! What photon beams say along a piece of an eye's ray, and at a place in a medium · W/(m²·sr) · PHOTON_DIFFERENTIALS 8 `[Jarosz11]`.
//!
//! The blur is one-dimensional, along the common perpendicular m of beam and ray, of which the beam's own form Q at the
//! nearest point says how wide it is:
//!
//!   L = Σ Φ T_b(s_b) T_e(s_e) σ_s p(cos) k₁(d/h)/(h sin θ),  h² = mᵀ (Q(s_b) + Q_eye(s_e)) m.
//!
//! A beam whose width is that of a disc has the same h everywhere: the estimate of fixed radius.

use super::kernel;
use crate::math::{Dir3, Point3, Vec3};
use crate::medium::{HenyeyGreenstein, Profile};
use crate::photon::Beam;
use crate::photon::beam_map::{BeamMap, Piece};
use crate::photon::footprint::{TangentForm, half_extents};
use crate::photon::index::{OuterBox, SlabRay};
use crate::radiometry::{Radiance, Spectrum};
use crate::scene::settings::KernelShape;
use crate::scene::{Medium, MediumId};

/// A piece of an eye's ray that lies in one medium.
#[derive(Clone, Debug)]
pub struct EyeSegment<'a> {
    pub origin: Point3,
    pub w: Dir3,
    pub length: f64,
    pub id: MediumId,
    pub medium: &'a Medium,
    /// How much of the medium lies before each of its places.
    pub profile: Profile<'a>,
    /// Semi-axes of the eye sample's footprint at the origin, m, and what they gain along the ray, rad.
    pub eye: [(Vec3, Vec3); 2],
    /// How often a beam may have been scattered.
    pub bounces: u32,
}

impl EyeSegment<'_> {
    /// The segment with its footprint around it, which reaches light whose own does not reach the ray.
    pub(super) fn slab_ray(&self) -> SlabRay {
        let [near, far] = [0.0, self.length].map(|s| half_extents(self.eye.map(|(dx, dw)| dx + dw * s)));
        SlabRay::new(self.origin, self.w, self.length, near.max(far))
    }
}

/// Beams less parallel to the ray than this are weighed; what is left out is a part of the same order of all directions.
const LEAST_SINE: f64 = 1e-6;

/// Light that beams bring to the start of the segment.
pub fn radiance(map: &BeamMap, kernel: KernelShape, segment: &EyeSegment) -> Radiance {
    let ray = segment.slab_ray();
    Radiance(pulp::Arch::new().dispatch(Crossed { map, kernel, segment, ray: &ray }))
}

/// [`radiance`] as the processor at hand does it best.
struct Crossed<'a> {
    map: &'a BeamMap,
    kernel: KernelShape,
    segment: &'a EyeSegment<'a>,
    ray: &'a SlabRay,
}

impl pulp::NullaryFnOnce for Crossed<'_> {
    type Output = Spectrum;

    #[inline(always)]
    fn call(self) -> Spectrum {
        let Crossed { map, kernel, segment, ray } = self;
        let phase = HenyeyGreenstein::new(segment.medium.asymmetry);
        let mut sum = Spectrum::BLACK;
        map.along(ray, |beam, piece| {
            if beam.medium == segment.id && beam.bounces <= segment.bounces {
                sum += crossing(beam, piece, kernel, &phase, segment);
            }
        });
        sum
    }
}

/// A place in a medium at which light is scattered towards the eye.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    pub p: Point3,
    /// The way of the eye's ray.
    pub w: Dir3,
    pub id: MediumId,
    pub medium: &'a Medium,
    /// Semi-axes of the eye sample's footprint, m.
    pub eye: [Vec3; 2],
    /// How often light may have been scattered.
    pub bounces: u32,
}

/// Light that beams bring to a place, as far as it would be scattered towards the eye there:
/// L_in = Σ Φ T(s) p(cos) K₂(dᵀ Q⁻¹ d)/√det Q, d at right angles to the beam and Q = Q(s) + Q_eye across it.
pub fn radiance_at(map: &BeamMap, kernel: KernelShape, place: &Place) -> Radiance {
    let phase = HenyeyGreenstein::new(place.medium.asymmetry);
    let mut sum = Spectrum::BLACK;
    map.over(OuterBox::new(place.p, half_extents(place.eye)), |beam, piece| {
        if beam.medium == place.id && beam.bounces <= place.bounces {
            sum += over(beam, piece, kernel, &phase, place);
        }
    });
    Radiance(sum)
}

/// What one piece of a beam adds at a place.
fn over(beam: &Beam, piece: &Piece, kernel: KernelShape, phase: &HenyeyGreenstein, place: &Place) -> Spectrum {
    let (apart, frame) = (place.p - beam.origin, beam.frame());
    let s = apart.dot(beam.w.to_vec());
    if !(piece.from <= s && s < piece.to) {
        return Spectrum::BLACK;
    }
    let form = beam.width.at(s).plus(TangentForm::from_axes(&frame, place.eye));
    let determinant = form.determinant();
    let t = form.adjugate_form(frame.project(apart)) / determinant;
    // Also where there is no width at all.
    if t.is_nan() || t >= 1.0 {
        return Spectrum::BLACK;
    }
    let column = match &place.medium.density {
        None => s,
        Some(grid) => piece.column + grid.column(beam.origin, beam.w, [piece.from, s]),
    };
    let weight = kernel::evaluate(kernel, t) / determinant.sqrt() * phase.between(beam.w, -place.w);
    beam.flux.0 * place.medium.transmittance(column) * weight
}

/// What one piece of a beam adds.
fn crossing(
    beam: &Beam,
    piece: &Piece,
    kernel: KernelShape,
    phase: &HenyeyGreenstein,
    segment: &EyeSegment,
) -> Spectrum {
    let cross = segment.w.cross(beam.w.to_vec());
    let sine = cross.length();
    if sine < LEAST_SINE {
        return Spectrum::BLACK;
    }
    let (m, cos) = (cross / sine, segment.w.dot(beam.w));
    let apart = beam.origin - segment.origin;
    // Where the two lines are nearest to each other.
    let (along_eye, along_beam) = (apart.dot(segment.w.to_vec()), apart.dot(beam.w.to_vec()));
    let s_b = (cos * along_eye - along_beam) / (sine * sine);
    let s_e = along_eye + cos * s_b;
    if !(piece.from <= s_b && s_b < piece.to && 0.0 <= s_e && s_e < segment.length) {
        return Spectrum::BLACK;
    }
    let own = beam.width.at(s_b).along(beam.frame().project(m));
    let eye: f64 = segment.eye.iter().map(|(dx, dw)| (*dx + *dw * s_e).dot(m).powi(2)).sum();
    let squared = own + eye;
    let d = apart.dot(m);
    let t = d * d / squared;
    // Also where there is no width at all.
    if t.is_nan() || t >= 1.0 {
        return Spectrum::BLACK;
    }
    let weight = kernel::evaluate_line(kernel, t) / (squared.sqrt() * sine) * phase.between(beam.w, -segment.w);
    let medium = segment.medium;
    if let Some(grid) = &medium.density {
        let (density, before) = segment.profile.at(s_e);
        let column = piece.column + grid.column(beam.origin, beam.w, [piece.from, s_b]) + before;
        return beam.flux.0 * medium.transmittance(column) * medium.scattering * (density * weight);
    }
    beam.flux.0 * medium.transmittance(s_b + s_e) * medium.scattering * weight
}
