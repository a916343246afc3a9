//! The estimate with photon differentials: the kernel over every footprint that covers a point.
//!
//! L(x, wo) = Σ_p f(x, wo, w_p) Φ_p K(dᵀ Q⁻¹ d)/√det Q, with Q = Q_photon + Q_eye (PHOTON_DIFFERENTIALS 3.1, 3.4):
//! adding the footprint of one eye sample keeps folds, where a photon's own area goes through zero, as sharp as the
//! picture can show and no sharper. The same Q makes the shape and the normalisation, so no energy is lost.

use crate::estimate::kernel;
use crate::math::{Dir3, Frame, Normal3, Point3, Vec3};
use crate::photon::footprint::TangentForm;
use crate::photon::index::{BoxTree, OuterBox, for_each_overlap};
use crate::photon::{Photon, PhotonMap};
use crate::radiometry::{Radiance, Spectrum};
use crate::scene::settings::KernelShape;
use crate::surface::{Bsdf, TransportMode};

/// Photons on a surface turned further than this from the point's are not its light (cosine of the angle).
const MIN_NORMAL_COSINE: f64 = 0.9;
/// A point whose light from photons is wanted.
#[derive(Clone, Copy, Debug)]
pub struct GatherPoint {
    pub p: Point3,
    pub ng: Normal3,
    pub ns: Normal3,
    pub wo: Dir3,
    pub bsdf: Bsdf,
    /// Semi-axes of the eye sample's footprint on the surface, zero where it has none.
    pub eye: [Vec3; 2],
}

/// What the photons say at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    pub radiance: Radiance,
    /// Σ K/√det Q, photons per m².
    pub density: f64,
}

/// Estimates all of `points` at once.
pub fn gather(map: &PhotonMap, kernel: KernelShape, points: &[GatherPoint]) -> Vec<Gathered> {
    let mut gathered = vec![Gathered::default(); points.len()];
    let boxes: Vec<OuterBox> = points.iter().map(|point| OuterBox::new(point.p, half_extents(&point.eye))).collect();
    for_each_overlap(&BoxTree::build(&boxes), map.tree(), |i, j| {
        let (point, photon) = (&points[i as usize], &map.photons[j as usize]);
        let weight = kernel_weight(point, photon, kernel);
        if weight > 0.0 {
            let sum = &mut gathered[i as usize];
            sum.radiance += Radiance(reflected(point, photon) * weight);
            sum.density += weight;
        }
    });
    gathered
}

/// K(dᵀ Q⁻¹ d)/√det Q in 1/m², 0 where the footprint does not reach the point or belongs to another surface.
fn kernel_weight(point: &GatherPoint, photon: &Photon, kernel: KernelShape) -> f64 {
    // In the order of what it costs to find out.
    let normal = photon.normal();
    if point.ng.dot(normal) < MIN_NORMAL_COSINE {
        return 0.0;
    }
    let offset = point.p - photon.position();
    let height = offset.dot(normal);
    if !photon.is_within(height) {
        return 0.0;
    }
    let frame = Frame::from_unit(normal);
    let form = photon.form().plus(TangentForm::from_axes(&frame, point.eye));
    let determinant = form.determinant();
    if determinant <= 0.0 {
        return 0.0;
    }
    // Exact for parallel light on a curved receiver: the offset goes along the beam into the photon's plane, and the
    // beam cuts areas in the ratio of the cosines out of the two planes (PHOTON_DIFFERENTIALS 3.3 b).
    let slide = photon.slide();
    let d = frame.project(offset - slide * height);
    let turn = point.ng.dot(slide).abs();
    kernel::evaluate(kernel, form.inverse_form(d, determinant)) / determinant.sqrt() * turn
}

/// f Φ, with the cosine of the shading normal in place of the geometric one that the footprint's area has.
pub(super) fn reflected(point: &GatherPoint, photon: &Photon) -> Spectrum {
    let wi = Dir3::from_unit(photon.wi());
    let cos_g = wi.dot(point.ng).abs();
    if cos_g == 0.0 {
        return Spectrum::BLACK;
    }
    let f = point.bsdf.f(point.wo, wi, TransportMode::Radiance);
    f * photon.flux().0 * (wi.dot(point.ns).abs() / cos_g)
}

/// Half extents along the world axes of the ellipse with these semi-axes.
fn half_extents(axes: &[Vec3; 2]) -> Vec3 {
    let [a, b] = axes;
    let along = |a: f64, b: f64| (a * a + b * b).sqrt();
    Vec3::new(along(a.x, b.x), along(a.y, b.y), along(a.z, b.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;
    use crate::photon::PhotonCounts;
    use crate::radiometry::Flux;
    use crate::sampling::{Purpose, Stream};
    use crate::scene::{LightId, ObjectId};
    use crate::surface::test_support::lambert_at;
    use std::f64::consts::PI;

    const KERNELS: [KernelShape; 6] = [
        KernelShape::Uniform,
        KernelShape::Cone,
        KernelShape::Epanechnikov,
        KernelShape::Biweight,
        KernelShape::Triweight,
        KernelShape::Gaussian,
    ];

    fn map(photons: Vec<Photon>) -> PhotonMap {
        PhotonMap::from_units(1, [(LightId(0), photons, PhotonCounts::default())])
    }

    /// A photon of 1 W arriving along `-wi` at `p` on a plane with normal `n`, its semi-axes given in the plane z = 0.
    fn photon(p: Point3, wi: Vec3, n: Normal3, axes: [Vec3; 2]) -> Photon {
        let form = TangentForm::from_axes(&Photon::frame_of(n), axes);
        Photon::new(p, Dir3::new(wi).expect("non-zero"), n, Flux(Spectrum::ONE), form, ObjectId(0))
    }

    fn point(p: Point3, n: Normal3, eye: [Vec3; 2]) -> GatherPoint {
        GatherPoint { p, ng: n, ns: n, wo: n.as_dir(), bsdf: lambert_at(p, n, 1.0), eye }
    }

    fn random_photons(n: usize) -> Vec<Photon> {
        let mut s = Stream::new(5, Purpose::Test, 0, 0);
        (0..n)
            .map(|_| {
                let mut axis = || Vec3::new(s.uniform() - 0.5, s.uniform() - 0.5, 0.0) * 0.4;
                let axes = [axis(), axis()];
                let p = Point3::new(s.uniform(), s.uniform(), 0.0);
                photon(p, Vec3::new(s.uniform() - 0.5, s.uniform() - 0.5, 1.0), Normal3::Z, axes)
            })
            .collect()
    }

    /// ∫ E dA over a plane = Σ Φ, for every kernel, with and without the eye sample's footprint. The tolerance is the
    /// midpoint rule's own error, measured as the difference between two grids.
    #[test]
    fn footprints_keep_the_photons_flux() {
        let map = map(random_photons(40));
        for eye in [[Vec3::ZERO; 2], [Vec3::X * 0.05, Vec3::Y * 0.03]] {
            for kernel in KERNELS {
                let [coarse, fine] = [400, 800].map(|n| {
                    let h = 3.0 / f64::from(n);
                    let at = |i: i32| -1.0 + (f64::from(i) + 0.5) * h;
                    let points: Vec<_> =
                        (0..n * n).map(|i| point(Point3::new(at(i % n), at(i / n), 0.0), Normal3::Z, eye)).collect();
                    // E = π L for a white diffuser.
                    gather(&map, kernel, &points).iter().map(|g| PI * g.radiance.0.r() * h * h).sum::<f64>()
                });
                let tolerance = 2.0 * (fine - coarse).abs() + 1e-6;
                assert!((fine - 40.0).abs() < tolerance.max(0.01), "{}: {fine} ± {tolerance}", kernel.name());
            }
        }
    }

    #[test]
    fn a_photon_lights_only_its_own_side_and_sheet() {
        let axes = [Vec3::X * 0.05, Vec3::Y * 0.05];
        let at = |z, n, eye| {
            gather(
                &map(vec![photon(Point3::ORIGIN, Vec3::Z, Normal3::Z, axes)]),
                KernelShape::Epanechnikov,
                &[point(Point3::new(0.0, 0.0, z), n, eye)],
            )[0]
        };
        assert!(at(0.0, Normal3::Z, [Vec3::ZERO; 2]).radiance.0.r() > 0.0);
        // The other face of a thin closed wall has the opposite normal.
        assert_eq!(at(-1e-6, -Normal3::Z, [Vec3::ZERO; 2]), Gathered::default());
        // A parallel sheet further than the footprint is thick.
        assert_eq!(at(0.02, Normal3::Z, [Vec3::ZERO; 2]), Gathered::default());
        // A wall at a right angle.
        assert_eq!(at(0.0, Normal3::X, [Vec3::ZERO; 2]), Gathered::default());
    }

    #[test]
    fn a_degenerate_footprint_is_as_sharp_as_the_eye_sample() {
        let line = map(vec![photon(Point3::ORIGIN, Vec3::Z, Normal3::Z, [Vec3::X * 0.1, Vec3::ZERO])]);
        let centre = |eye| gather(&line, KernelShape::Uniform, &[point(Point3::ORIGIN, Normal3::Z, eye)])[0].density;
        assert_eq!(centre([Vec3::ZERO; 2]), 0.0);
        let eye = [Vec3::X * 0.01, Vec3::Y * 0.01];
        let expected = 1.0 / (PI * (0.1f64 * 0.1 + 1e-4).sqrt() * 0.01);
        assert!((centre(eye) / expected - 1.0).abs() < 1e-6);
    }

    /// Sliding along the photon's direction: a beam of constant cross-section lights a tilted receiver in proportion
    /// to the cosine.
    #[test]
    fn a_parallel_beam_on_a_tilted_receiver_keeps_the_cosine_law() {
        let tilt = 0.3f64;
        let n = Normal3::new(Vec3::new(tilt.sin(), 0.0, tilt.cos())).expect("unit");
        let axes = [Vec3::X, Vec3::Y];
        let map = map(vec![photon(Point3::ORIGIN, Vec3::Z, Normal3::Z, axes)]);
        // On the tilted plane through the origin, inside the thickness limit.
        let p = Point3::from_vec(Vec3::new(tilt.cos(), 0.0, -tilt.sin()) * 0.2);
        let g = gather(&map, KernelShape::Uniform, &[point(p, n, [Vec3::ZERO; 2])])[0];
        assert!((g.density * PI - tilt.cos()).abs() < 1e-6, "{}", g.density * PI);
        assert!(Vec2::new(p.x, p.y).length() < 1.0);
    }
}
