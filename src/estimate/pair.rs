//! One photon and one point: the estimate's formula as it reads, in double precision.
//!
//! A point at offset o from the photon lies at height h = n·o over its plane and at d = (t·o', b·o') in it, where
//! o' = o − h·slide: exact for parallel light on a curved receiver, the offset goes along the beam into the photon's
//! plane, and the beam cuts areas in the ratio of the cosines out of the two planes (PHOTON_DIFFERENTIALS 3.3 b).

use super::gather::GatherPoint;
use super::kernel;
use crate::math::{Dir3, Vec2};
use crate::photon::Photon;
use crate::photon::footprint::TangentForm;
use crate::photon::record::MIN_NORMAL_COSINE;
use crate::radiometry::Spectrum;
use crate::scene::settings::KernelShape;
use crate::surface::TransportMode;

/// K(dᵀ Q⁻¹ d)/√det Q in 1/m², Q = Q_photon + Q_eye; 0 where the footprint does not reach the point or belongs to another
/// surface. Where the point has a moment, the kernel is where the photon's light is then.
pub fn weight(photon: &Photon, kernel: KernelShape, point: &GatherPoint) -> f64 {
    let n = photon.normal();
    let o = point.p - photon.position();
    let height = o.dot(n);
    if point.ng.dot(n) < MIN_NORMAL_COSINE || height.abs() > photon.thickness() {
        return 0.0;
    }
    let (frame, slide) = (photon.frame(), photon.slide());
    let form = photon.form().plus(TangentForm::from_axes(&frame, point.eye));
    let determinant = form.determinant();
    let d = frame.project(o - slide * height);
    let (distance, swept) = match (photon.sweep(), point.moment) {
        (None, _) => (form.adjugate_form(d), 0.0),
        (Some(sweep), Some(moment)) => (form.adjugate_form(d - sweep * moment), 0.0),
        (Some(sweep), None) => over_segment(&form, kernel, d, sweep),
    };
    // Neither without area nor out of reach; false for NaN.
    if !(determinant > 0.0 && distance < determinant) {
        return 0.0;
    }
    kernel::evaluate(kernel, distance / determinant) / (determinant.sqrt() + swept) * point.ng.dot(slide).abs()
}

/// Of the kernel that is swept over the segment of half `sweep` to both sides: dᵀ adj Q d from the segment's nearest point,
/// and what the sweep adds to √det Q `[Schjoth11]`.
///
/// The points within r of the segment, by dᵀ Q⁻¹ d ≤ r², are the ellipse of size r swept along D, of the area
/// π r² √det Q + r l |D|, where l |D| = 2 √(Dᵀ adj Q D) is its width across times the way. So the integral of K is
/// √det Q + l |D| ∫₀¹ K(r²) dr, which 2011's area has for the uniform kernel only.
fn over_segment(form: &TangentForm, kernel: KernelShape, d: Vec2, sweep: Vec2) -> (f64, f64) {
    let along = form.adjugate_form(sweep);
    let place = if along > 0.0 { (form.adjugate_between(sweep, d) / along).clamp(-0.5, 0.5) } else { 0.0 };
    let swept = 2.0 * along.max(0.0).sqrt() * kernel::line_integral(kernel);
    (form.adjugate_form(d - sweep * place), swept)
}

/// f Φ, with the cosine of the shading normal in place of the geometric one that the footprint's area has.
pub fn reflected(photon: &Photon, point: &GatherPoint) -> Spectrum {
    let wi = Dir3::from_unit(photon.wi());
    let cos_g = wi.dot(point.ng).abs();
    if cos_g == 0.0 {
        return Spectrum::BLACK;
    }
    let f = point.bsdf.f(point.wo, wi, TransportMode::Radiance);
    f * photon.flux().0 * (wi.dot(point.ns).abs() / cos_g)
}
