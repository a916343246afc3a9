//! What photon beams say along a piece of an eye's ray · W/(m²·sr) · PHOTON_DIFFERENTIALS 8 `[Jarosz11]`.
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
use crate::photon::index::SlabRay;
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

/// Beams less parallel to the ray than this are weighed; what is left out is a part of the same order of all directions.
const LEAST_SINE: f64 = 1e-6;

/// Light that beams bring to the start of the segment.
pub fn radiance(map: &BeamMap, kernel: KernelShape, segment: &EyeSegment) -> Radiance {
    let phase = HenyeyGreenstein::new(segment.medium.asymmetry);
    let ray = SlabRay::new(segment.origin, segment.w, segment.length);
    let mut sum = Spectrum::BLACK;
    map.along(&ray, |beam, piece| {
        if beam.medium == segment.id && beam.bounces <= segment.bounces {
            sum += crossing(beam, piece, kernel, &phase, segment);
        }
    });
    Radiance(sum)
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
