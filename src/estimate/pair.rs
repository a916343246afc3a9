//! One photon and one point: the estimate's formula as it reads, in double precision.
//!
//! A point at offset o from the photon lies at height h = n·o over its plane and at d = (t·o', b·o') in it, where
//! o' = o − h·slide: exact for parallel light on a curved receiver, the offset goes along the beam into the photon's
//! plane, and the beam cuts areas in the ratio of the cosines out of the two planes (PHOTON_DIFFERENTIALS 3.3 b).

use super::gather::GatherPoint;
use super::kernel;
use crate::math::Dir3;
use crate::photon::Photon;
use crate::photon::footprint::TangentForm;
use crate::photon::record::MIN_NORMAL_COSINE;
use crate::radiometry::Spectrum;
use crate::scene::settings::KernelShape;
use crate::surface::TransportMode;

/// K(dᵀ Q⁻¹ d)/√det Q in 1/m², Q = Q_photon + Q_eye; 0 where the footprint does not reach the point or belongs to another
/// surface.
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
    let distance = form.adjugate_form(frame.project(o - slide * height));
    // Neither without area nor out of reach; false for NaN.
    if !(determinant > 0.0 && distance < determinant) {
        return 0.0;
    }
    kernel::evaluate(kernel, distance / determinant) / determinant.sqrt() * point.ng.dot(slide).abs()
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
