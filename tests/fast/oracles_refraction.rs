//! Water, prism, wave and the edge of total reflection against closed forms (PHOTON_DIFFERENTIALS 1.2 and 12, items 9,
//! 10, 12).

use std::f64::consts::{FRAC_PI_2, TAU};

use pdembree::math::{Normal3, Point3, Vec2, Vec3};
use pdembree::shape::{HeightField, Rectangle, Shape, Wave};
use pdembree::surface::fresnel::dielectric;

use crate::support::optics::{Act, Beam, Bench, beam, floor, zero};

fn tilted(degrees: f64) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3::new(sin, 0.0, -cos)
}

#[test]
fn a_point_source_over_water_lights_the_floor_by_the_spread_of_its_columns() {
    let n = 1.33;
    let bench = Bench::new(vec![floor(0.0), floor(-2.0)]);
    // (angle, dA/dΩ, radius, E with Fresnel)
    let table = [
        (0.0, 6.26881113, 0.0, 0.15632002),
        (20.0, 7.07019097, 0.89618495, 0.13857621),
        (40.0, 10.34179808, 1.94320834, 0.09435961),
        (60.0, 22.77304579, 3.44796215, 0.04131526),
        (75.0, 97.58444292, 5.84505282, 0.00808093),
    ];
    for (angle, spread, radius, irradiance) in table {
        let start = beam(Point3::new(0.0, 0.0, 1.0), tilted(angle));
        let b = bench.trace(&start, &[(0, Act::Refract(1.0 / n)), (1, Act::Land)]).expect("hits");
        // r = tan θ + 2 tan θ', and dA/dΩ = (r / sin θ) dr/dθ.
        let i = f64::to_radians(angle);
        let sin_t = i.sin() / n;
        let cos_t = (1.0 - sin_t * sin_t).sqrt();
        let r = i.tan() + 2.0 * sin_t / cos_t;
        let slope = 1.0 / i.cos().powi(2) + 2.0 / cos_t.powi(3) * i.cos() / n;
        let exact = if angle == 0.0 { slope * slope } else { r / i.sin() * slope };
        assert!((exact - spread).abs() < 6e-9, "{angle}°: the document has {spread}, the closed form {exact}");
        assert!((b.area(2, 3) / exact - 1.0).abs() < 1e-13, "{angle}°: {}, not {exact}", b.area(2, 3));
        assert!((b.p.x - radius).abs() < 6e-9 && (b.p.x - r).abs() < 1e-14 * (1.0 + r), "{angle}°: {:?}", b.p);
        let e = (1.0 - dielectric(i.cos(), 1.0 / n).reflectance) / b.area(2, 3);
        assert!((e - irradiance).abs() < 6e-9, "{angle}°: E = {e}, not {irradiance}");
    }
}

#[test]
fn a_flat_slab_leaves_the_area_of_collimated_light() {
    let bench = Bench::new(vec![floor(0.0), floor(-0.4), floor(-2.0)]);
    for angle in [0.0, 30.0, 70.0, 85.0] {
        let start = beam(Point3::new(0.0, 0.0, 1.0), tilted(angle));
        let legs = [(0, Act::Refract(1.0 / 1.5)), (1, Act::Refract(1.5)), (2, Act::Land)];
        let slab = bench.trace(&start, &legs).expect("hits").area(0, 1);
        let free = bench.trace(&start, &[(2, Act::Land)]).expect("hits").area(0, 1);
        assert!((slab / free - 1.0).abs() < 1e-13, "{angle}°: {slab} against {free}");
    }
}

/// A prism of 60° whose edge is along z, its bisector along y: the ray runs about +x.
fn prism() -> Bench {
    let half = 30f64.to_radians();
    let face = |side: f64| {
        let along = Vec3::new(side * half.sin(), -half.cos(), 0.0);
        let centre = Point3::from_vec(along);
        Shape::Rectangle(Rectangle::new(centre, along * 5.0, Vec3::Z).expect("valid"))
    };
    Bench::new(vec![face(-1.0), face(1.0)])
}

/// The beam behind the prism for an angle of incidence in radians; column 2 turns it in the plane of the path.
fn behind_prism(n: f64, incidence: f64) -> Beam {
    // The entry face's outward normal points up and to the left, 30° above −x.
    let w = 30f64.to_radians() - incidence;
    let direction = Vec3::new(w.cos(), -w.sin(), 0.0);
    let start = Point3::new(-0.5, -(30f64.to_radians().cos()), 0.0) - direction * 0.3;
    let mut b = beam(start, direction);
    let in_plane = Vec3::Z.cross(direction);
    let mut columns = b.columns.columns();
    columns[2].dw = in_plane;
    b.columns = pdembree::differential::Differential::new(columns);
    prism().trace(&b, &[(0, Act::Refract(1.0 / n)), (1, Act::Refract(n))]).expect("passes the prism")
}

#[test]
fn the_prism_turns_least_where_its_column_says_so() {
    for (n, printed, slope) in [(1.5, 37.180756, 1.51185789), (1.62, 48.191863, 1.70523372)] {
        let minimum = |n: f64| 2.0 * (0.5 * n).asin() - 60f64.to_radians();
        let incidence = f64::asin(0.5 * n);
        let b = behind_prism(n, incidence);
        let start = Vec3::new((30f64.to_radians() - incidence).cos(), -(30f64.to_radians() - incidence).sin(), 0.0);
        let turned = start.cross(b.w.to_vec()).length().atan2(start.dot(b.w.to_vec()));
        assert!((turned.to_degrees() - printed).abs() < 6e-7, "n = {n}: {}°, not {printed}°", turned.to_degrees());
        assert!((turned - minimum(n)).abs() < 1e-14);
        // Stationary: a turned ray leaves turned by as much, δ' = 0.
        let response = b.dw(2).dot(Vec3::Z.cross(b.w.to_vec()));
        assert!((response - 1.0).abs() < 1e-14, "n = {n}: dδ/di = {}", response - 1.0);
        // dδ/dn at fixed incidence, by differences: there is no wavelength column yet.
        let angle = |n: f64| {
            let w = behind_prism(n, incidence).w;
            start.cross(w.to_vec()).length().atan2(start.dot(w.to_vec()))
        };
        let difference = (angle(n + 1e-5) - angle(n - 1e-5)) / 2e-5;
        assert!((difference - slope).abs() < 1e-8, "n = {n}: dδ/dn = {difference}, not {slope}");
    }
}

#[test]
fn the_columns_grow_towards_total_reflection_as_the_transmittance_falls() {
    // (degrees below the critical angle, dθt/dθi, transmittance), both to the digits that the document prints.
    let table = [(5.0, 2.739, 0.887), (1.0, 5.753, 0.657), (0.1, 17.93, 0.298), (0.01, 56.60, 0.108)];
    let bench = Bench::new(vec![floor(0.0)]);
    let critical = f64::asin(1.0 / 1.5).to_degrees();
    for (below, growth, transmittance) in table {
        let angle = critical - below;
        let start = beam(Point3::new(0.0, 0.0, 1.0), tilted(angle));
        let b = bench.trace(&start, &[(0, Act::Refract(1.5))]).expect("still passes");
        // Column 3 turns the ray in its plane of incidence.
        let i = angle.to_radians();
        let exact = 1.5 * i.cos() / (1.0 - (1.5 * i.sin()).powi(2)).sqrt();
        let turned = b.dw(3).length();
        assert!((turned / exact - 1.0).abs() < 1e-9, "{below}° below: {turned}, not {exact}");
        assert!((turned - growth).abs() < 6e-4 * growth, "{below}° below: {turned}, not {growth}");
        let t = 1.0 - dielectric(i.cos(), 1.5).reflectance;
        assert!((t - transmittance).abs() < 6e-4, "{below}° below: T = {t}, not {transmittance}");
    }
    let beyond = beam(Point3::new(0.0, 0.0, 1.0), tilted(critical + 0.001));
    assert!(bench.trace(&beyond, &[(0, Act::Refract(1.5))]).is_none(), "totally reflected");
}

/// The document writes 1.543, but all of its digits belong to 1.5433: its two slopes 1 ∓ 4π²·0.25·(1 − 1/n)·d at crest and
/// trough, d = 0.6327 ± 0.25, give n = 1.54330.
const WAVE_INDEX: f64 = 1.5433;

/// The wave of [Schjoth07] as rebuilt in PHOTON_DIFFERENTIALS 5.2: z = 0.25 cos 2πx over a floor at −0.6327.
fn wave() -> Bench {
    let wave = Wave { amplitude: 0.25, wave_vector: Vec2::new(TAU, 0.0), phase: FRAC_PI_2, rate: 0.0 };
    let field = HeightField::new(Point3::ORIGIN, Vec3::X, Vec3::Z, Vec2::new(1.0, 0.1), vec![wave]).expect("valid");
    Bench::new(vec![Shape::HeightField(field), floor(-0.6327)])
}

/// The landing beam of light down at x, and its Fresnel transmittance. Column 1 is ∂/∂x.
fn under_wave(bench: &Bench, x: f64) -> (Beam, f64) {
    let start = beam(Point3::new(x, 0.0, 1.0), -Vec3::Z);
    let at = bench.meet(&start, 0).expect("over the window");
    let transmittance = 1.0 - dielectric(at.wo.dot(at.ns), 1.0 / WAVE_INDEX).reflectance;
    let legs = [(0, Act::Refract(1.0 / WAVE_INDEX)), (1, Act::Land)];
    (bench.trace(&start, &legs).expect("into the denser medium"), transmittance)
}

#[test]
fn the_wave_folds_where_its_column_vanishes() {
    let bench = wave();
    assert_eq!(under_wave(&bench, 0.1).0.dx(0).x, 0.0, "column 0 is ∂/∂y");
    let slope = |x: f64| under_wave(&bench, x).0.dx(1).x;
    for (x, printed) in [(0.0, -2.066918), (0.5, 2.329681)] {
        assert!((slope(x) - printed).abs() < 6e-7, "dX/dx at {x} is {}, not {printed}", slope(x));
    }
    let fold = zero(0.05, 0.3, slope);
    let x = under_wave(&bench, fold).0.p.x;
    assert!((fold - 0.127308).abs() < 6e-7, "the fold's light comes from {fold}");
    assert!((x + 0.157197).abs() < 6e-7, "the fold is at {x}");
    let mirrored = zero(-0.3, -0.05, slope);
    assert!((mirrored + fold).abs() < 1e-14 && (under_wave(&bench, mirrored).0.p.x + x).abs() < 1e-14);
    let bend = (slope(fold + 1e-5) - slope(fold - 1e-5)) / 2e-5;
    assert!((bend - 19.889).abs() < 6e-4, "X'' = {bend}");
}

/// All x in the window whose light lands at `target`: between the folds and beyond them X is monotonic.
fn sheets(bench: &Bench, target: f64) -> Vec<f64> {
    let offset = |x: f64| under_wave(bench, x).0.p.x - target;
    let fold = zero(0.05, 0.3, |x| under_wave(bench, x).0.dx(1).x);
    [-0.6, -fold, fold, 0.6]
        .windows(2)
        .filter(|piece| offset(piece[0]) * offset(piece[1]) <= 0.0)
        .map(|piece| zero(piece[0], piece[1], offset))
        .collect()
}

#[test]
fn the_irradiance_under_the_wave_is_the_sum_over_its_sheets() {
    let bench = wave();
    // (X, sheets, E, E with Fresnel)
    let table = [
        (0.0, 3, 1.560124, 1.447206),
        (0.05, 3, 1.623941, 1.508093),
        (0.1, 3, 1.902987, 1.773164),
        (0.15, 3, 4.234790, 3.969157),
        (0.2, 1, 0.457853, 0.429180),
        (0.3, 1, 0.446102, 0.423283),
        (0.5, 1, 0.429243, 0.409655),
    ];
    for (x, count, irradiance, with_fresnel) in table {
        let sheets = sheets(&bench, x);
        assert_eq!(sheets.len(), count, "X = {x}: {sheets:?}");
        let (mut e, mut fresnel) = (0.0, 0.0);
        for x in sheets {
            let (b, transmittance) = under_wave(&bench, x);
            e += 1.0 / b.area(0, 1);
            fresnel += transmittance / b.area(0, 1);
        }
        assert!((e - irradiance).abs() < 6e-7, "E({x}) = {e}, not {irradiance}");
        assert!((fresnel - with_fresnel).abs() < 6e-7, "E({x}) with Fresnel = {fresnel}, not {with_fresnel}");
    }
}

#[test]
fn the_irradiance_falls_from_the_fold_by_the_inverse_root() {
    let bench = wave();
    let at = |x: f64| sheets(&bench, x).iter().map(|&x| 1.0 / under_wave(&bench, x).0.area(0, 1)).sum::<f64>();
    let fold = 0.157197;
    let fold =
        -under_wave(&bench, zero(0.12, 0.13, |x| under_wave(&bench, x).0.dx(1).x)).0.p.x.clamp(-fold - 1e-6, 0.0);
    let outside = at(fold + 1e-4);
    let rise = at(fold - 1e-4) - outside;
    assert!((rise - 31.724).abs() < 0.02, "{rise} at a distance of 1e-4");
    // C/√d with C = 0.317110, the next term being of relative order √d.
    assert!((rise * 1e-2 / 0.317110 - 1.0).abs() < 1e-2);
}

#[test]
fn the_wave_has_the_normal_of_its_slope() {
    let bench = wave();
    for x in [0.0, 0.13, 0.4] {
        let at = bench.meet(&beam(Point3::new(x, 0.0, 1.0), -Vec3::Z), 0).expect("over the window");
        let n = Normal3::new(Vec3::new(0.25 * TAU * f64::sin(TAU * x), 0.0, 1.0)).expect("a normal");
        assert!((at.ng.to_vec() - n.to_vec()).length() < 1e-15, "{x}");
    }
}
