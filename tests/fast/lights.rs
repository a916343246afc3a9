//! Emission of every light as a map: inverse, Jacobian, densities; power; photons shared among lights.

use std::f64::consts::PI;

use pdembree::light::{Aim, AreaLight, DirectionalLight, Light, PointLight, SpotLight, select};
use pdembree::math::{Point3, Transform, Vec3};
use pdembree::radiometry::{Intensity, Irradiance, Radiance};
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::light::BeamExtent;

use crate::support::lights::{COLOUR, Case, SCENE, cases, dir, shapes, skewed, tetrahedron};
use crate::support::quartet::{smooth_difference, with};

const SEED: u64 = 4711;

/// The largest coordinate of an emission's origin, for rounding.
const SIZE: f64 = 10.0;

fn draws(case: &Case, n: usize) -> impl Iterator<Item = [f64; 4]> {
    let _ = case;
    let mut stream = Stream::new(SEED, Purpose::Test, 0, 0);
    (0..n).map(move |_| {
        let ([a, b], [c, d]) = (stream.uniform2(), stream.uniform2());
        [a, b, c, d]
    })
}

/// Length of the cross product, or 1 for a pair of columns that the source does not have.
fn cell(a: Vec3, b: Vec3) -> f64 {
    if a == Vec3::ZERO && b == Vec3::ZERO { 1.0 } else { a.cross(b).length() }
}

#[test]
fn the_jacobian_of_every_emission_is_its_derivative() {
    for case in cases() {
        let (mut tried, mut compared) = (0, 0);
        for u in draws(&case, 60) {
            let Some(emission) = case.light.emit(u, &case.aim) else { continue };
            for (k, column) in emission.jacobian.columns().iter().enumerate() {
                if u[k] < 1e-3 || u[k] > 1.0 - 1e-3 {
                    continue;
                }
                let origin = |t: f64| case.light.emit(with(u, k, t), &case.aim).map(|e| e.origin.to_vec());
                let direction = |t: f64| case.light.emit(with(u, k, t), &case.aim).map(|e| e.direction.to_vec());
                tried += 1;
                let (Some((dx, bound_x)), Some((dw, bound_w))) =
                    (smooth_difference(origin, u[k], SIZE), smooth_difference(direction, u[k], SIZE))
                else {
                    continue;
                };
                compared += 1;
                let at = format!("{}, column {k} at u = {u:?}, seed {SEED}", case.name);
                assert!((column.dx - dx).length() <= bound_x, "{at}: dx {} ≠ {dx} ± {bound_x:e}", column.dx);
                assert!((column.dw - dw).length() <= bound_w, "{at}: dw {} ≠ {dw} ± {bound_w:e}", column.dw);
            }
        }
        assert!(10 * compared >= 9 * tried, "{}: only {compared} of {tried} columns were compared", case.name);
    }
}

#[test]
fn densities_are_the_jacobians_inverse() {
    for case in cases() {
        for u in draws(&case, 200) {
            let Some(e) = case.light.emit(u, &case.aim) else { continue };
            let [cu, cv, ct, cp] = e.jacobian.columns();
            let (area, angle) = (cell(cu.dx, cv.dx), cell(ct.dw, cp.dw));
            let pdf_a = e.pdf_a.map_or(1.0, |p| p.get());
            let pdf_w = e.pdf_w.map_or(1.0, |p| p.get());
            let at = format!("{} at u = {u:?}, seed {SEED}", case.name);
            // Cross products lose as many digits as the columns are far from perpendicular.
            let skew = cu.dx.length() * cv.dx.length() / area + ct.dw.length() * cp.dw.length() / angle;
            let bound = 64.0 * f64::EPSILON * (1.0 + skew).powi(2);
            assert!((area * pdf_a - 1.0).abs() <= bound, "{at}: area {area}, pdf {pdf_a}, bound {bound:e}");
            assert!((angle * pdf_w - 1.0).abs() <= bound, "{at}: solid angle {angle}, pdf {pdf_w}, bound {bound:e}");
            assert_eq!(e.pdf_a.is_some(), cu.dx != Vec3::ZERO, "{at}");
            assert_eq!(e.pdf_w.is_some(), ct.dw != Vec3::ZERO, "{at}");
        }
    }
}

#[test]
fn every_emission_is_found_again_by_its_inverse() {
    for case in cases() {
        for u in draws(&case, 200) {
            let Some(e) = case.light.emit(u, &case.aim) else { continue };
            let at = format!("{} at u = {u:?}, seed {SEED}", case.name);
            let back = case.light.emission_inverse(e.origin, e.direction, &case.aim);
            let back = back.unwrap_or_else(|| panic!("{at}: not found"));
            let [cu, cv, ct, cp] = e.jacobian.columns();
            // Rounding of the ray, through the inverse of each pair of columns and of the coupling of both.
            let position = cu.dx.length().max(cv.dx.length()) / cell(cu.dx, cv.dx);
            let direction = ct.dw.length().max(cp.dw.length()) / cell(ct.dw, cp.dw);
            let coupling = cu.dw.length() + cv.dw.length() + ct.dx.length() + cp.dx.length();
            let bound = 64.0 * f64::EPSILON * (1.0 + SIZE * position) * (1.0 + direction) * (1.0 + coupling);
            let used = [e.pdf_a.is_some(), e.pdf_a.is_some(), e.pdf_w.is_some(), e.pdf_w.is_some()];
            for k in (0..4).filter(|&k| used[k]) {
                assert!((back[k] - u[k]).abs() <= bound, "{at}: inverse {back:?}, bound {bound:e}");
            }
        }
    }
}

#[test]
fn every_emission_reaches_its_aim() {
    for case in cases() {
        let Aim::Sphere { centre, radius } = case.aim else { continue };
        for u in draws(&case, 200) {
            let Some(e) = case.light.emit(u, &case.aim) else { continue };
            let ahead = e.direction.dot(centre - e.origin).max(0.0);
            let nearest = (e.origin + e.direction * ahead).distance(centre);
            // Cones and disks count their rims in, to 1e-9 of their size.
            assert!(nearest <= radius * (1.0 + 1e-8) + 1e-8, "{} at u = {u:?}: passes at {nearest}", case.name);
        }
    }
}

/// Rounding of sums over thousands of terms.
const CLOSE: f64 = 1e-12;

fn assert_grey(what: &str, got: pdembree::radiometry::Flux, factor: f64) {
    for (a, b) in got.0.to_array().into_iter().zip((COLOUR * factor).to_array()) {
        assert!((a - b).abs() <= CLOSE * b, "{what}: {a} ≠ {b}");
    }
}

#[test]
fn powers_have_their_closed_forms() {
    let at = Point3::new(1.0, 2.0, 3.0);
    assert_grey("point", PointLight { position: at, intensity: Intensity(COLOUR) }.power(), 4.0 * PI);
    let spot = |inner, outer| SpotLight::new(at, dir(1.0, 0.0, 0.0), Intensity(COLOUR), inner, outer).power();
    assert_grey("sharp spot", spot(0.7, 0.7), 2.0 * PI * 0.3);
    assert_grey("soft spot", spot(0.9, 0.7), 2.0 * PI * 0.2);
    let beam = |extent| DirectionalLight::new(dir(0.0, -1.0, 0.0), Irradiance(COLOUR), &extent, SCENE);
    let rectangle = BeamExtent::Rectangle { centre: at, a: Vec3::new(0.5, 0.0, 0.0), b: Vec3::new(0.0, 0.0, 0.25) };
    assert_grey("rectangle beam", beam(rectangle).expect("has area").power(), 0.5);
    // A rectangle that leans by 60° lets half of that through.
    let leaning = BeamExtent::Rectangle {
        centre: at,
        a: Vec3::new(0.5, 0.0, 0.0),
        b: Vec3::new(0.0, 0.25 * (PI / 3.0).sin(), 0.25 * (PI / 3.0).cos()),
    };
    assert_grey("leaning beam", beam(leaning).expect("has area").power(), 0.25);
    assert_grey("disk beam", beam(BeamExtent::Disk { centre: at, radius: 2.0 }).expect("has area").power(), 4.0 * PI);
    assert_grey("sun", beam(BeamExtent::Unbounded).expect("has area").power(), 16.0 * PI);
    assert!(
        beam(BeamExtent::Rectangle { centre: at, a: Vec3::X, b: Vec3::X }).is_none(),
        "a beam without a cross-section is refused"
    );
}

#[test]
fn areas_and_powers_of_surfaces() {
    let radiance = Radiance(COLOUR);
    let still = Transform::IDENTITY;
    let areas = [
        ("sphere", 4.0 * PI * 0.25),
        ("cylinder", 2.0 * PI * 0.3 * Vec3::new(0.3, 0.8, 0.2).length()),
        ("torus", 4.0 * PI * PI * 0.6 * 0.2),
        ("disk", PI * 0.25),
        ("rectangle", 4.0 * 0.5 * 0.3),
    ];
    for ((name, shape), (expected_name, area)) in shapes().into_iter().zip(areas) {
        assert_eq!(name, expected_name);
        let one = AreaLight::from_shape(&shape, &still, radiance, false).expect("has area");
        assert_grey(name, one.power(), PI * area);
        let two = AreaLight::from_shape(&shape, &still, radiance, true).expect("has area");
        assert_grey(name, two.power(), 2.0 * PI * area);
        let twice = Transform::scale(Vec3::splat(2.0)).expect("invertible");
        let large = AreaLight::from_shape(&shape, &twice, radiance, false).expect("has area");
        assert_grey(name, large.power(), 4.0 * PI * area);
    }
    let faces = [0.7 / 2.0, 0.4 / 2.0, 0.28 / 2.0];
    let slanted = 0.5 * Vec3::new(-1.0, 0.7, 0.0).cross(Vec3::new(-1.0, 0.0, 0.4)).length();
    let mesh = AreaLight::from_mesh(&tetrahedron(), &still, radiance, false).expect("has area");
    // Corners are stored as f32.
    let area: f64 = faces.iter().sum::<f64>() + slanted;
    assert!((mesh.area() - area).abs() <= 4.0 * f64::from(f32::EPSILON) * area);
}

/// An oblate spheroid of semi-axes a, a, c has the area 2π a² (1 + (1 − e²)/e artanh e), e² = 1 − c²/a².
#[test]
fn a_squashed_sphere_has_the_area_of_a_spheroid() {
    let (name, sphere) = shapes().swap_remove(0);
    assert_eq!(name, "sphere");
    let squash = Transform::scale(Vec3::new(2.0, 2.0, 1.0)).expect("invertible");
    let light = AreaLight::from_shape(&sphere, &squash, Radiance(COLOUR), false).expect("has area");
    let (a, c) = (1.0f64, 0.5f64);
    let e = (1.0 - c * c / (a * a)).sqrt();
    let expected = 2.0 * PI * a * a * (1.0 + (1.0 - e * e) / e * e.atanh());
    // The midpoint rule over 128² cells, second order.
    assert!((light.area() / expected - 1.0).abs() < 1.0 / (128.0 * 128.0), "{} ≠ {expected}", light.area());
}

/// The outward side of a mirrored mesh and of a mirrored shape is the one that shines.
#[test]
fn a_mirrored_light_still_shines_outward() {
    let mirror = Transform::scale(Vec3::new(1.0, 1.0, -1.0)).expect("invertible");
    let inside = mirror.point(Point3::new(0.1, 0.1, 0.05));
    let mesh = AreaLight::from_mesh(&tetrahedron(), &mirror, Radiance(COLOUR), false).expect("has area");
    let (_, sphere) = shapes().swap_remove(0);
    let ball = AreaLight::from_shape(&sphere, &skewed(), Radiance(COLOUR), false).expect("has area");
    let centre = skewed().point(Point3::new(0.1, 0.2, 0.3));
    let mut stream = Stream::new(SEED, Purpose::Test, 1, 0);
    for _ in 0..100 {
        let ([a, b], [c, d]) = (stream.uniform2(), stream.uniform2());
        for (light, middle) in [(&mesh, inside), (&ball, centre)] {
            let e = light.emit([a, b, c, d], &Aim::Everywhere).expect("no aim to miss");
            let n = e.normal.expect("a surface");
            assert!(n.dot(e.origin - middle) > 0.0 && n.dot(e.direction) > 0.0);
            assert_eq!(light.radiance(n, e.direction), Radiance(COLOUR));
            assert!(light.radiance(n, -e.direction).is_zero());
            assert!(light.sample_li(middle, [a, b]).is_none(), "dark inside");
        }
    }
}

#[test]
fn photons_are_shared_by_largest_remainders() {
    assert_eq!(select::allot(10, &[1.0, 1.0, 1.0]), [4, 3, 3]);
    assert_eq!(select::allot(100, &[1.0, 2.5, 6.5]), [10, 25, 65]);
    assert_eq!(select::allot(7, &[0.0, 3.0, 4.0]), [0, 3, 4]);
    // A dim light gets its one, the others share what is left.
    assert_eq!(select::allot(101, &[1e-9, 3.0, 1.0]), [1, 75, 25]);
    assert_eq!(select::allot(2, &[1.0, 1.0, 1.0, 1.0]), [1, 1, 1, 1]);
    assert_eq!(select::allot(0, &[1.0]), [1]);
    assert_eq!(select::allot(5, &[]), [0u64; 0]);
    assert_eq!(select::allot(5, &[0.0]), [0]);
    let mut stream = Stream::new(SEED, Purpose::Test, 2, 0);
    for n in [1000u64, 12_345, 1_000_000_007] {
        let shares: Vec<f64> = (0..50).map(|_| stream.uniform()).collect();
        let counts = select::allot(n, &shares);
        assert_eq!(counts.iter().sum::<u64>(), n);
        let total: f64 = shares.iter().sum();
        for (count, share) in counts.iter().zip(&shares) {
            assert!((*count as f64 - n as f64 * share / total).abs() < 2.0, "{count} of {n} for {share}, seed {SEED}");
        }
    }
}
