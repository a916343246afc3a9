//! The estimate with photon differentials: the kernel over every footprint that covers a point.
//!
//! L(x, wo) = Σ_p f(x, wo, w_p) Φ_p K(dᵀ Q⁻¹ d)/√det Q, with Q = Q_photon + Q_eye (PHOTON_DIFFERENTIALS 3.1, 3.4):
//! adding the footprint of one eye sample keeps folds, where a photon's own area goes through zero, as sharp as the
//! picture can show and no sharper. The same Q makes the shape and the normalisation, so no energy is lost.

use std::ops::Range;

use crate::estimate::kernel;
use crate::math::{Dir3, Frame, Normal3, Point3, Vec2, Vec3};
use crate::photon::footprint::TangentForm;
use crate::photon::index::{BoxTree, OuterBox};
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
    /// Which photons are asked.
    pub asks: Asks,
}

/// Which photons answer for a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asks {
    /// All of them.
    All,
    /// The stratum that this number in [0, 1) draws, for all: unbiased, and enough behind a diffuse bounce, whose own
    /// noise is greater.
    Drawn(f64),
}

/// What the photons say at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    pub radiance: Radiance,
    /// Σ K/√det Q, photons per m².
    pub density: f64,
}

/// Points in a leaf of their tree.
const LEAF_SIZE: u32 = 8;

/// Estimates all of `points` at once: those that ask all photons together, the others with their stratum's.
pub fn gather(map: &PhotonMap, kernel: KernelShape, points: &[GatherPoint]) -> Vec<Gathered> {
    let mut gathered = vec![Gathered::default(); points.len()];
    let strata = map.strata();
    let of = |wanted: &dyn Fn(Asks) -> bool| (0..points.len()).filter(|&i| wanted(points[i].asks)).collect::<Vec<_>>();
    let mut answer = |asked: &[BoxTree], weight: f64, who: Vec<usize>| {
        let group: Vec<&GatherPoint> = who.iter().map(|&i| &points[i]).collect();
        for (i, sum) in who.into_iter().zip(splat_all(map, asked, kernel, &group)) {
            gathered[i] = Gathered { radiance: sum.radiance * weight, density: sum.density * weight };
        }
    };
    answer(strata, 1.0, of(&|asks| asks == Asks::All));
    for (k, stratum) in strata.iter().enumerate() {
        let drawn = |asks| matches!(asks, Asks::Drawn(u) if (u * strata.len() as f64) as usize == k);
        answer(std::slice::from_ref(stratum), strata.len() as f64, of(&drawn));
    }
    gathered
}

/// The sums over the photons of `strata`: every footprint that reaches one of the points is made ready once and splatted.
fn splat_all(map: &PhotonMap, strata: &[BoxTree], kernel: KernelShape, points: &[&GatherPoint]) -> Vec<Gathered> {
    let boxes: Vec<OuterBox> = points.iter().map(|point| OuterBox::new(point.p, half_extents(&point.eye))).collect();
    let tree = BoxTree::build(&boxes, LEAF_SIZE);
    // In the order of the leaves, so that a splat reads and writes runs.
    let points: Vec<&GatherPoint> = tree.order().iter().map(|&i| points[i as usize]).collect();
    let receivers: Vec<Receiver> = points.iter().map(|point| Receiver::new(point)).collect();
    let widest_eye = points.iter().map(|point| square_sum(&point.eye)).fold(0.0, f64::max);
    let mut sums = vec![Gathered::default(); points.len()];
    for stratum in strata {
        stratum.visit_over(&tree, |j, bounds| {
            let photon = &map.photons[j as usize];
            let splat = Splat::new(photon, kernel, widest_eye);
            let visit = |leaf: Range<usize>| {
                for i in leaf {
                    let weight = splat.weight(&receivers[i]);
                    if weight > 0.0 {
                        sums[i].radiance += Radiance(splat.reflected(&receivers[i], points[i]) * weight);
                        sums[i].density += weight;
                    }
                }
                true
            };
            tree.visit_where(bounds, |points| splat.may_reach(points), visit);
        });
    }
    let mut in_order = vec![Gathered::default(); points.len()];
    for (&i, sum) in tree.order().iter().zip(sums) {
        in_order[i as usize] = sum;
    }
    in_order
}

/// What a splat asks of a point, packed: the point itself, with its BSDF, fills several cache lines.
struct Receiver {
    p: Point3,
    ng: Normal3,
    eye: [Vec3; 2],
    even: Option<Even>,
}

/// A BSDF that sends the same to all directions, with its normals turned to the side of `wo`.
struct Even {
    f: Spectrum,
    ng: Vec3,
    ns: Vec3,
}

impl Receiver {
    fn new(point: &GatherPoint) -> Receiver {
        let turned = |n: Normal3| n.as_dir().to_vec() * 1.0f64.copysign(n.dot(point.wo));
        let even = |f| Even { f, ng: turned(point.ng), ns: turned(point.ns) };
        Receiver { p: point.p, ng: point.ng, eye: point.eye, even: point.bsdf.even_value(point.wo).map(even) }
    }
}

/// A photon's footprint made ready for many points.
///
/// A point at offset o from the photon lies at height h = n·o over its plane and at d = (t·o', b·o') in it, where
/// o' = o − h·slide: exact for parallel light on a curved receiver, the offset goes along the beam into the photon's
/// plane, and the beam cuts areas in the ratio of the cosines out of the two planes (PHOTON_DIFFERENTIALS 3.3 b).
struct Splat<'a> {
    photon: &'a Photon,
    kernel: KernelShape,
    position: Point3,
    frame: Frame,
    slide: Vec3,
    form: TangentForm,
    /// o ↦ d as two rows.
    plane: [Vec3; 2],
    flux: Spectrum,
    wi: Vec3,
    /// Square of the height over the photon's plane that its light reaches.
    thickness2: f64,
    /// o ↦ y with |y|² = dᵀ (Q + λ)⁻¹ d, where λ is at least every eye footprint: |y| ≥ 1 lies outside for every point.
    outside: [Vec3; 2],
}

impl<'a> Splat<'a> {
    fn new(photon: &'a Photon, kernel: KernelShape, widest_eye: f64) -> Splat<'a> {
        let (frame, slide, form) = (photon.frame(), photon.slide(), photon.form());
        let plane = [frame.t, frame.b].map(|axis| axis - frame.n * axis.dot(slide));
        // Cholesky: Q + λ = L Lᵀ, y = L⁻¹ d.
        let l11 = (form.xx + widest_eye).sqrt();
        let l21 = form.xy / l11;
        let l22 = (form.yy + widest_eye - l21 * l21).max(0.0).sqrt();
        let first = plane[0] / l11;
        let second = (plane[1] - first * l21) / l22;
        Splat {
            photon,
            kernel,
            position: photon.position(),
            frame,
            slide,
            form,
            plane,
            flux: photon.flux().0,
            wi: photon.wi(),
            thickness2: photon.thickness().powi(2),
            outside: [first, second],
        }
    }

    /// False where the box lies outside the footprint as a whole: long thin footprints fill little of their own boxes.
    fn may_reach(&self, points: &OuterBox) -> bool {
        let (o, half) = (points.centre() - self.position, points.half_extents());
        // Not a comparison with ≤, so that NaN rows, of a footprint without area, let all boxes pass.
        !self.outside.iter().any(|row| row.dot(o).abs() > 1.0 + 1e-5 + row.abs().dot(half))
    }

    /// K(dᵀ Q⁻¹ d)/√det Q in 1/m², 0 where the footprint does not reach the point or belongs to another surface.
    fn weight(&self, point: &Receiver) -> f64 {
        // In the order of what it costs to find out. The margin keeps this first test from deciding close cases; it lets
        // pass what is NaN for a footprint without area.
        let o = point.p - self.position;
        let [y0, y1] = self.outside.map(|row| row.dot(o));
        if y0 * y0 + y1 * y1 > 1.0 + 1e-9 {
            return 0.0;
        }
        let height = o.dot(self.frame.n);
        if point.ng.dot(self.frame.n) < MIN_NORMAL_COSINE || height * height > self.thickness2 {
            return 0.0;
        }
        let form = self.form.plus(TangentForm::from_axes(&self.frame, point.eye));
        let determinant = form.determinant();
        if determinant <= 0.0 {
            return 0.0;
        }
        let [x, y] = self.plane.map(|row| row.dot(o));
        let turn = point.ng.dot(self.slide).abs();
        let inverse = 1.0 / determinant;
        kernel::evaluate(self.kernel, form.adjugate_form(Vec2::new(x, y)) * inverse) * inverse.sqrt() * turn
    }

    /// As [`reflected`], of this photon.
    fn reflected(&self, receiver: &Receiver, point: &GatherPoint) -> Spectrum {
        let Some(even) = &receiver.even else { return reflected(point, self.photon) };
        let [cos_s, cos_g] = [even.ns, even.ng].map(|n| n.dot(self.wi));
        if cos_s > 0.0 && cos_g > 0.0 { even.f * self.flux * (cos_s / cos_g) } else { Spectrum::BLACK }
    }
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

fn square_sum(axes: &[Vec3; 2]) -> f64 {
    axes.iter().map(|axis| axis.length_squared()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
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
        GatherPoint { p, ng: n, ns: n, wo: n.as_dir(), bsdf: lambert_at(p, n, 1.0), eye, asks: Asks::All }
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

    /// Over all numbers that can be drawn, the mean of the strata's answers is what all photons say together.
    #[test]
    fn strata_answer_for_all_photons_in_the_mean() {
        let map = map(random_photons(4000));
        let strata = map.strata().len();
        assert!(strata > 4, "footprints as wide as these are worth strata, not {strata}");
        let mut centre = point(Point3::new(0.5, 0.5, 0.0), Normal3::Z, [Vec3::ZERO; 2]);
        let all = gather(&map, KernelShape::Triweight, &[centre])[0];
        let drawn: Vec<f64> = (0..strata)
            .map(|k| {
                centre.asks = Asks::Drawn((k as f64 + 0.5) / strata as f64);
                gather(&map, KernelShape::Triweight, &[centre])[0].density
            })
            .collect();
        let mean = drawn.iter().sum::<f64>() / strata as f64;
        assert!((mean / all.density - 1.0).abs() < 1e-12, "{mean} against {}", all.density);
        assert!(drawn.iter().any(|d| (d / all.density - 1.0).abs() > 1e-3), "strata are all the same");
    }

    /// The trees leave out what no footprint reaches and nothing else: against all pairs, one by one.
    #[test]
    fn trees_find_all_that_single_pairs_find() {
        let photons = random_photons(300);
        let map = map(photons.clone());
        let mut s = Stream::new(6, Purpose::Test, 0, 0);
        let points: Vec<_> = (0..500)
            .map(|_| {
                let p = Point3::new(1.4 * s.uniform() - 0.2, 1.4 * s.uniform() - 0.2, 1e-4 * (s.uniform() - 0.5));
                point(p, Normal3::Z, [Vec3::X * 0.02 * s.uniform(), Vec3::Y * 0.01])
            })
            .collect();
        for (g, point) in gather(&map, KernelShape::Epanechnikov, &points).iter().zip(&points) {
            let single = |photon| {
                Splat::new(photon, KernelShape::Epanechnikov, square_sum(&point.eye)).weight(&Receiver::new(point))
            };
            let expected: f64 = photons.iter().map(single).sum();
            assert!((g.density - expected).abs() <= 1e-9 * expected, "{} against {expected}", g.density);
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
