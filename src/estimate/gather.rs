//! The estimate with photon differentials: the kernel over every footprint that covers a point.
//!
//! L(x, wo) = Σ_p f(x, wo, w_p) Φ_p K(dᵀ Q⁻¹ d)/√det Q, with Q = Q_photon + Q_eye (PHOTON_DIFFERENTIALS 3.1, 3.4):
//! adding the footprint of one eye sample keeps folds, where a photon's own area goes through zero, as sharp as the
//! picture can show and no sharper. The same Q makes the shape and the normalisation, so no energy is lost.

use std::ops::ControlFlow;
use std::sync::atomic::Ordering;

use super::pair;
use super::receivers::Receivers;
use super::splat::{Part, Splat, Splatting};
use crate::math::{Dir3, Normal3, Point3, Vec3};
use crate::photon::footprint::half_extents;
use crate::photon::index::{Boxes, Lanes, OuterBox, Visitor};
use crate::photon::map::Stratum;
use crate::photon::{Photon, PhotonMap};
use crate::radiometry::Radiance;
use crate::scene::settings::KernelShape;
use crate::surface::Bsdf;

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
    /// Where in the shutter's interval the eye looks, from −½ to ½, on an object that is carried along: the light of that
    /// moment is asked for, of photons that say where theirs is then.
    pub moment: Option<f64>,
}

impl GatherPoint {
    /// Around the point and its eye footprint.
    pub fn outer_box(&self) -> OuterBox {
        OuterBox::new(self.p, half_extents(self.eye))
    }
}

/// Which photons answer for a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asks {
    /// All of them; or, of those whose footprints are much wider than the pixel, the point's share in turn with the
    /// pixel's other samples.
    All(Turn),
    /// Those that were scattered at most `bounces_left` times: what the eye's own bounces leave of a path's. The slice of
    /// a stratum that `u` in [0, 1) draws answers for all: unbiased, and enough behind a diffuse bounce, whose own noise is
    /// greater.
    Drawn { u: f64, bounces_left: u32 },
}

impl Asks {
    /// Whether the photon's path and the eye's together are none too long.
    pub fn admits(&self, photon: &Photon) -> bool {
        match *self {
            Asks::All(_) => true,
            Asks::Drawn { bounces_left, .. } => photon.bounces() <= bounces_left,
        }
    }
}

/// A point's place among the samples of its pixel.
///
/// Where many footprints lie over a pixel, samples take turns to ask the wide ones, a group of strata each: together they
/// ask every photon once, and each of them alone is unbiased. Narrow footprints, which differ from sample to sample,
/// answer all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turn {
    /// Number of the sample, below `of`.
    pub index: u32,
    /// Samples in the pixel; the same for all points that are asked about together.
    pub of: u32,
}

impl Turn {
    /// A point that asks for itself.
    pub const ALONE: Turn = Turn { index: 0, of: 1 };

    /// Which of so many groups the point asks, and for how many it answers.
    fn group(self, groups: u32) -> (u32, f64) {
        let group = self.index % groups;
        let askers = (self.of - group).div_ceil(groups);
        (group, f64::from(self.of) / f64::from(askers))
    }
}

/// What the photons say at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    pub radiance: Radiance,
    /// Σ K/√det Q, photons per m².
    pub density: f64,
}

/// Estimates all of `points`: those that ask all photons together, which suits neighbours, the others one by one.
///
/// Photons come in the order of the map whatever points are asked about: a point's sum has the same bits for every
/// partition of the picture.
pub fn gather(map: &PhotonMap, kernel: KernelShape, points: &[GatherPoint]) -> Vec<Gathered> {
    if map.photons.is_empty() {
        return vec![Gathered::default(); points.len()];
    }
    let mut gathered = vec![Gathered::default(); points.len()];
    look_up_drawn(map, kernel, points, &mut gathered);
    let turn = |point: &GatherPoint| match point.asks {
        Asks::All(turn) => Some(turn),
        Asks::Drawn { .. } => None,
    };
    let asking_all: Vec<(usize, Turn)> = (0..).zip(points).filter_map(|(i, p)| Some((i, turn(p)?))).collect();
    if let Some(&(_, Turn { of, .. })) = asking_all.first() {
        debug_assert!(asking_all.iter().all(|(_, turn)| turn.of == of), "points of different pictures");
        splat_all(map, kernel, points, &asking_all, &mut gathered);
    }
    gathered
}

/// The sums over the slices that points draw, stratum by stratum, of which one at a time is near the processor.
fn look_up_drawn(map: &PhotonMap, kernel: KernelShape, points: &[GatherPoint], gathered: &mut [Gathered]) {
    let strata = map.strata();
    let slices = strata.len() * map.slices();
    let slice = |point: &GatherPoint| match point.asks {
        Asks::Drawn { u, .. } => Some((u * slices as f64) as usize),
        Asks::All(_) => None,
    };
    let mut drawn: Vec<(usize, usize)> = (0..).zip(points).filter_map(|(i, p)| Some((slice(p)?, i))).collect();
    drawn.sort_unstable_by_key(|&(slice, i)| (slice % strata.len(), i));
    for (slice, i) in drawn {
        let (stratum, lanes) = (&strata[slice % strata.len()], Lanes::every(map.slices(), slice / strata.len()));
        let of_all = look_up(map, stratum, lanes, kernel, &points[i]);
        let weight = slices as f64;
        gathered[i] = Gathered { radiance: of_all.radiance * weight, density: of_all.density * weight };
    }
}

/// The sums over all photons: every footprint that may reach one of the points is made ready once and splatted into the
/// trees over the points that ask it.
fn splat_all(
    map: &PhotonMap,
    kernel: KernelShape,
    points: &[GatherPoint],
    asking: &[(usize, Turn)],
    gathered: &mut [Gathered],
) {
    let processor = pulp::Arch::new();
    let groups = (map.strata().len() as u32).min(asking[0].1.of);
    let chosen = |wanted: &dyn Fn(Turn) -> bool| {
        let chosen = asking.iter().filter(|(_, turn)| wanted(*turn)).map(|&(i, _)| i).collect();
        Receivers::new(points, chosen)
    };
    let mut all = chosen(&|_| true);
    let mut taking_turns: Vec<Receivers> = match groups {
        1 => Vec::new(),
        _ => (0..groups).map(|group| chosen(&|turn| turn.group(groups).0 == group)).collect(),
    };
    for (s, stratum) in (0..).zip(map.strata()) {
        let photons = map.photons_of(stratum);
        for j in stratum.tree.over(&all.tree) {
            let splat = Splat::new(&photons[j], kernel);
            let Some(group) = taking_turns.get_mut((s % groups) as usize) else {
                processor.dispatch(Splatting { splat: &splat, part: Part::Whole, receivers: &mut all });
                continue;
            };
            if splat.has(Part::Narrow, all.shared_range) {
                processor.dispatch(Splatting { splat: &splat, part: Part::Narrow, receivers: &mut all });
            }
            if splat.has(Part::Wide, group.shared_range) {
                processor.dispatch(Splatting { splat: &splat, part: Part::Wide, receivers: group });
            }
        }
    }
    let weighed = all.weighed + taking_turns.iter().map(|group| group.weighed).sum::<u64>();
    map.weighed.fetch_add(weighed, Ordering::Relaxed);
    all.add_to(gathered, |_| 1.0);
    for group in &taking_turns {
        group.add_to(gathered, |point| match point.asks {
            Asks::All(turn) => turn.group(groups).1,
            Asks::Drawn { .. } => 0.0,
        });
    }
}

/// The sum over those of a stratum's photons in `lanes` of its tree whose footprints' boxes hold the point.
fn look_up(map: &PhotonMap, stratum: &Stratum, lanes: Lanes, kernel: KernelShape, point: &GatherPoint) -> Gathered {
    struct LookUp<'a> {
        photons: &'a [Photon],
        lanes: Lanes,
        kernel: KernelShape,
        point: &'a GatherPoint,
        place: OuterBox,
        weighed: u64,
        sum: Gathered,
    }
    impl Visitor for LookUp<'_> {
        fn enter(&mut self, level: usize, boxes: &Boxes) -> Lanes {
            let over = boxes.overlapping(&self.place);
            if level == 0 { over.and(self.lanes) } else { over }
        }
        fn visit(&mut self, j: usize) -> ControlFlow<()> {
            let photon = &self.photons[j];
            if !self.point.asks.admits(photon) {
                return ControlFlow::Continue(());
            }
            self.weighed += 1;
            let weight = pair::weight(photon, self.kernel, self.point);
            if weight > 0.0 {
                self.sum.radiance += Radiance(pair::reflected(photon, self.point) * weight);
                self.sum.density += weight;
            }
            ControlFlow::Continue(())
        }
    }
    let (photons, sum) = (map.photons_of(stratum), Gathered::default());
    let mut look_up = LookUp { photons, lanes, kernel, point, place: point.outer_box(), weighed: 0, sum };
    stratum.tree.lead(&mut look_up);
    map.weighed.fetch_add(look_up.weighed, Ordering::Relaxed);
    look_up.sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::kernel;
    use crate::math::Vec2;
    use crate::photon::footprint::TangentForm;
    use crate::photon::{PhotonCounts, PhotonHarvest};
    use crate::radiometry::{Flux, Spectrum};
    use crate::sampling::{Purpose, Stream};
    use crate::scene::LightId;
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
        let mut harvest = PhotonHarvest::new(1);
        harvest.add(LightId(0), photons, &PhotonCounts::default());
        harvest.into_map()
    }

    /// A photon of 1 W arriving along `-wi` at `p` on a plane with normal `n`, its semi-axes given in the plane z = 0.
    fn photon(p: Point3, wi: Vec3, n: Normal3, axes: [Vec3; 2]) -> Photon {
        let form = TangentForm::from_axes(&Photon::frame_of(n), axes);
        Photon::new(p, Dir3::new(wi).expect("non-zero"), n, Flux(Spectrum::ONE), form, 0)
    }

    fn point(p: Point3, n: Normal3, eye: [Vec3; 2]) -> GatherPoint {
        let (ng, ns, wo, bsdf) = (n, n, n.as_dir(), lambert_at(p, n, 1.0));
        GatherPoint { p, ng, ns, wo, bsdf, eye, asks: Asks::All(Turn::ALONE), moment: None }
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

    /// ∫ E dA over a plane, which is to be Σ Φ = `flux`. The tolerance is the midpoint rule's own error, measured as the
    /// difference between a grid of `n` × `n` points and one of twice as many a side.
    fn assert_flux(map: &PhotonMap, kernel: KernelShape, eye: [Vec3; 2], n: i32, flux: f64) {
        let [coarse, fine] = [n, 2 * n].map(|n| {
            let h = 3.0 / f64::from(n);
            let at = |i: i32| -1.0 + (f64::from(i) + 0.5) * h;
            let points: Vec<_> =
                (0..n * n).map(|i| point(Point3::new(at(i % n), at(i / n), 0.0), Normal3::Z, eye)).collect();
            // E = π L for a white diffuser.
            gather(map, kernel, &points).iter().map(|g| PI * g.radiance.0.r() * h * h).sum::<f64>()
        });
        let tolerance = 2.0 * (fine - coarse).abs() + 1e-6;
        assert!((fine - flux).abs() < tolerance.max(0.01), "{}: {fine} ± {tolerance}", kernel.name());
    }

    const EYES: [[Vec3; 2]; 2] = [[Vec3::ZERO; 2], [Vec3::new(0.05, 0.0, 0.0), Vec3::new(0.0, 0.03, 0.0)]];

    /// For every kernel, with and without the eye sample's footprint.
    #[test]
    fn footprints_keep_the_photons_flux() {
        let map = map(random_photons(40));
        for (eye, kernel) in EYES.into_iter().flat_map(|eye| KERNELS.map(|kernel| (eye, kernel))) {
            assert_flux(&map, kernel, eye, 400, 40.0);
        }
    }

    /// The same of footprints that are swept, however far; and no tree loses what a swept kernel reaches.
    #[test]
    fn swept_footprints_keep_the_photons_flux() {
        let mut s = Stream::new(6, Purpose::Test, 0, 0);
        let sweep = |k: usize| Vec2::from_angle(k as f64) * 0.9 * (k as f64 / 11.0).powi(2);
        let swept = |(k, photon): (usize, Photon)| photon.over(sweep(k)).unwrap_or(photon);
        let photons: Vec<Photon> = random_photons(12).into_iter().enumerate().map(swept).collect();
        assert_eq!(photons.iter().filter(|photon| photon.sweep().is_some()).count(), 11);
        let map = map(photons.clone());
        for (eye, kernel) in EYES.into_iter().flat_map(|eye| KERNELS.map(|kernel| (eye, kernel))) {
            assert_flux(&map, kernel, eye, 150, 12.0);
            let here = point(Point3::new(s.uniform(), s.uniform(), 0.0), Normal3::Z, eye);
            let all: f64 = photons.iter().map(|photon| pair::weight(photon, kernel, &here)).sum();
            let found = gather(&map, kernel, &[here])[0].density;
            assert!((found - all).abs() <= 1e-5 * all, "{}: {found}, not {all}", kernel.name());
        }
    }

    /// A point with a moment finds a swept photon where that is then, as narrow as one that does not move.
    #[test]
    fn a_moments_light_is_where_the_photon_is_then() {
        let axes = [Vec3::X * 0.1, Vec3::Y * 0.05];
        let still = photon(Point3::new(0.2, 0.1, 0.0), Vec3::new(0.3, 0.1, 1.0), Normal3::Z, axes);
        let way = still.frame().project(Vec3::new(0.8, -0.4, 0.0));
        let moving = still.over(way).expect("room");
        for moment in [-0.5, 0.0, 0.25, 0.5] {
            let at = |p| GatherPoint { moment: Some(moment), ..point(p, Normal3::Z, EYES[1]) };
            let place = still.position() + Vec3::new(0.02, 0.01, 0.0);
            let gone = Vec3::new(0.8, -0.4, 0.0) * moment;
            let [there, here] = [(&moving, at(place + gone)), (&still, at(place))]
                .map(|(photon, point)| gather(&map(vec![*photon]), KernelShape::Triweight, &[point])[0].density);
            // The way is kept to 0.3 %, some 1.3 mm of half of it; the kernel's slope is below 6/0.05 of it a metre.
            assert!((there / here - 1.0).abs() < 6.0 / 0.05 * 0.0015, "{moment}: {there}, not {here}");
        }
    }

    /// Over all numbers that can be drawn, the mean of the strata's answers is what all photons say together.
    #[test]
    fn slices_answer_for_all_photons_in_the_mean() {
        let map = map(random_photons(4000));
        assert!(map.strata().len() > 4 && map.slices() > 1, "footprints as wide as these are worth more");
        let slices = map.strata().len() * map.slices();
        let mut centre = point(Point3::new(0.5, 0.5, 0.0), Normal3::Z, [Vec3::ZERO; 2]);
        let all = gather(&map, KernelShape::Triweight, &[centre])[0];
        let drawn: Vec<f64> = (0..slices)
            .map(|k| {
                centre.asks = Asks::Drawn { u: (k as f64 + 0.5) / slices as f64, bounces_left: 0 };
                gather(&map, KernelShape::Triweight, &[centre])[0].density
            })
            .collect();
        let mean = drawn.iter().sum::<f64>() / slices as f64;
        assert!((mean / all.density - 1.0).abs() < 1e-6, "{mean} against {}", all.density);
        assert!(drawn.iter().any(|d| (d / all.density - 1.0).abs() > 1e-3), "slices are all the same");
    }

    /// Samples at one place that take turns say together what each of them would say alone, however many there are of them
    /// and of strata; where no footprint is wide for them, each says it by itself.
    #[test]
    fn samples_that_take_turns_ask_every_photon_once() {
        let map = map(random_photons(4000));
        assert!(map.strata().len() > 4, "{}", map.strata().len());
        let place = |eye, asks| GatherPoint { asks, ..point(Point3::new(0.5, 0.4, 0.0), Normal3::Z, eye) };
        for (eye, wide) in [(1e-4, true), (1.0, false)] {
            let eye = [Vec3::X * eye, Vec3::Y * eye];
            let alone = gather(&map, KernelShape::Triweight, &[place(eye, Asks::All(Turn::ALONE))])[0].density;
            for of in [2, 3, 16, 33, 40] {
                let points: Vec<GatherPoint> = (0..of).map(|index| place(eye, Asks::All(Turn { index, of }))).collect();
                let said: Vec<f64> = gather(&map, KernelShape::Triweight, &points).iter().map(|g| g.density).collect();
                let mean = said.iter().sum::<f64>() / f64::from(of);
                assert!((mean / alone - 1.0).abs() < 1e-5, "{mean} against {alone}, {of} samples");
                let same = said.iter().all(|density| (density / alone - 1.0).abs() < 1e-5);
                assert_eq!(same, !wide, "{said:?}");
            }
        }
    }

    /// Points about the photons of [`random_photons`], a little off their plane, some with an eye's footprint.
    fn random_points(n: usize) -> Vec<GatherPoint> {
        let mut s = Stream::new(6, Purpose::Test, 0, 0);
        (0..n)
            .map(|_| {
                let p = Point3::new(1.4 * s.uniform() - 0.2, 1.4 * s.uniform() - 0.2, 1e-4 * (s.uniform() - 0.5));
                point(p, Normal3::Z, [Vec3::X * 0.02 * s.uniform(), Vec3::Y * 0.01])
            })
            .collect()
    }

    /// Eight at once, in single precision and through the trees, against all pairs one by one: nothing that a footprint
    /// reaches is left out, and nothing is added.
    #[test]
    fn eight_at_once_are_what_single_pairs_are() {
        let photons = random_photons(300);
        let map = map(photons.clone());
        let points = random_points(501);
        for kernel in KERNELS {
            let alone = |point| photons.iter().map(|photon| pair::weight(photon, kernel, point)).sum::<f64>();
            let expected: Vec<f64> = points.iter().map(alone).collect();
            // Rounding moves points within a footprint, which tells most at the foot of a steep kernel; those that end in a
            // step may find a point on its other side.
            let largest = expected.iter().copied().fold(0.0, f64::max);
            let step = if kernel::vanishes_at_edge(kernel) { 0.0 } else { 1e-4 };
            for (g, expected) in gather(&map, kernel, &points).iter().zip(expected) {
                let tolerance = (1e-5 + step) * expected + 1e-7 * largest;
                assert!((g.density - expected).abs() <= tolerance, "{} against {expected}", g.density);
            }
        }
    }

    /// Thin, turned footprints, near and far from the origin: what single precision keeps of them.
    #[test]
    fn thin_footprints_keep_their_light_in_single_precision() {
        let mut s = Stream::new(7, Purpose::Test, 0, 0);
        for _ in 0..2000 {
            let (centre, turn) = (Vec3::new(s.uniform(), s.uniform(), 0.0) * 30.0, 6.3 * s.uniform());
            let along = Vec3::new(turn.cos(), turn.sin(), 0.0);
            let thin = 10f64.powf(-3.0 * s.uniform());
            let across = Vec3::new(-along.y, along.x, 0.0) * thin;
            let p = Point3::from_vec(centre);
            let photon = photon(p, Vec3::new(0.3, 0.1, 1.0), Normal3::Z, [along, across]);
            let d = along * (s.uniform() - 0.5) + across * (s.uniform() - 0.5);
            let point = point(photon.position() + d, Normal3::Z, [Vec3::X * 1e-3, Vec3::Y * 2e-3]);
            let expected = pair::weight(&photon, KernelShape::Triweight, &point);
            let found = gather(&map(vec![photon]), KernelShape::Triweight, &[point])[0].density;
            assert!((found / expected - 1.0).abs() < 2e-4, "{found} against {expected}, {thin} thin");
        }
    }

    /// What is compiled for this processor and what is compiled for all give the same bits.
    #[test]
    fn every_processor_gives_the_same_bits() {
        let (photons, points) = (random_photons(100), random_points(300));
        let run = |dispatch: &dyn Fn(Splatting)| {
            let mut receivers = Receivers::new(&points, (0..points.len()).collect());
            for photon in &photons {
                let splat = &Splat::new(photon, KernelShape::Triweight);
                dispatch(Splatting { splat, part: Part::Whole, receivers: &mut receivers });
            }
            let mut gathered = vec![Gathered::default(); points.len()];
            receivers.add_to(&mut gathered, |_| 1.0);
            gathered
        };
        let best = run(&|splatting| pulp::Arch::new().dispatch(splatting));
        let plain = run(&|splatting| pulp::NullaryFnOnce::call(splatting));
        assert_eq!(best, plain);
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
