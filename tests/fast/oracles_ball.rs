//! Glass balls and raindrops against closed forms (PHOTON_DIFFERENTIALS 12, items 1, 2, 3, 11). Unit ball about the
//! origin, light down −z at height h from the axis along y, the direction of column 0.

use pdembree::math::{Point3, Vec3};
use pdembree::surface::fresnel::dielectric;

use crate::support::optics::{Act, Beam, Bench, beam, floor, unit_ball, zero};

fn at_height(h: f64) -> Beam {
    beam(Point3::new(0.0, h, 4.0), -Vec3::Z)
}

fn through(n: f64) -> [(usize, Act); 2] {
    [(0, Act::Refract(1.0 / n)), (0, Act::Refract(n))]
}

/// The beam behind a ball of index n.
fn behind(n: f64, h: f64) -> Beam {
    Bench::new(vec![unit_ball()]).trace(&at_height(h), &through(n)).expect("h < 1 passes through")
}

/// The same, landed on the plane at distance d from the centre.
fn on_plane(n: f64, h: f64, d: f64) -> Beam {
    let legs = [through(n)[0], through(n)[1], (1, Act::Land)];
    Bench::new(vec![unit_ball(), floor(-d)]).trace(&at_height(h), &legs).expect("hits the plane")
}

#[test]
fn paraxial_light_meets_at_the_focal_length() {
    for (n, printed) in [(1.5, 1.5f64), (1.33, 2.01515152), (1.8, 1.125), (2.0, 1.0)] {
        let focal = n / (2.0 * (n - 1.0));
        assert!((focal - printed).abs() < 5e-9, "the document's own closed form");
        let b = behind(n, 0.0);
        for k in [0, 1] {
            let focus = b.p.z - b.focus(k);
            assert!((focus + focal).abs() < 1e-14, "n = {n}: column {k} focuses at {focus}, not {}", -focal);
            // For n = 2 the focus is on the ball itself.
            assert!(b.flown(b.focus(k)).dx(k).length() < 1e-15, "n = {n}");
        }
    }
}

#[test]
fn a_ray_off_the_axis_crosses_it_where_snells_law_says() {
    let table = [
        (0.1, 1.49582706),
        (0.2, 1.48323202),
        (0.3, 1.46197844),
        (0.5, 1.39157295),
        (0.7, 1.27778702),
        (0.9, 1.10444557),
    ];
    for (h, printed) in table {
        let (i, r) = (f64::asin(h), f64::asin(h / 1.5));
        let exact = h / (2.0 * (i - r)).sin();
        assert!((exact - printed).abs() < 5e-9, "h = {h}: the document has {printed}, the closed form {exact}");
        let b = behind(1.5, h);
        let crossing = b.p.z - b.p.y * b.w.z / b.w.y;
        assert!((crossing + exact).abs() < 1e-14, "h = {h}: {crossing}");
        // Sagittal rays turn about the axis: that column vanishes there too.
        let sagittal = b.p.z + b.focus(1) * b.w.z;
        assert!((sagittal + exact).abs() < 1e-13, "h = {h}: sagittal focus {sagittal}");
    }
}

#[test]
fn the_axis_behind_the_ball_is_brighter_by_the_square_of_the_focal_ratio() {
    let passed = (1.0 - dielectric(1.0, 1.0 / 1.5).reflectance) * (1.0 - dielectric(1.0, 1.5).reflectance);
    assert!((passed - 0.9216).abs() < 1e-15);
    for (d, factor, with_fresnel) in [(1.2, 25.0, 23.04), (2.0, 9.0, 8.2944), (3.0, 1.0, 0.9216)] {
        let brightness = 1.0 / on_plane(1.5, 0.0, d).area(0, 1);
        assert!((brightness / factor - 1.0).abs() < 1e-13, "d = {d}: {brightness}");
        assert!((brightness * passed / with_fresnel - 1.0).abs() < 1e-13, "d = {d}");
    }
}

#[test]
fn the_fold_on_a_plane_is_where_the_radial_column_vanishes() {
    // (n, plane, fold radius, height of its ray, bracket of heights)
    let table = [
        (1.5, 1.1, 0.120885, 0.624758, 0.3, 0.89),
        (1.5, 1.25, 0.054917, 0.470754, 0.2, 0.7),
        (1.5, 1.4, 0.013032, 0.287960, 0.1, 0.48),
        (1.33, 1.6, 0.066739, 0.462984, 0.2, 0.7),
    ];
    for (n, d, radius, height, lo, hi) in table {
        let h = zero(lo, hi, |h| on_plane(n, h, d).dx(0).y);
        let y = on_plane(n, h, d).p.y;
        assert!((h - height).abs() < 6e-7, "n = {n}, d = {d}: h = {h}, not {height}");
        assert!((y.abs() - radius).abs() < 6e-7, "n = {n}, d = {d}: r = {y}, not {radius}");
    }
}

/// Total turning of the ray after one inner reflection, degrees.
fn deviation(b: &Beam) -> f64 {
    // Two refractions turn by i − r each, the reflection by π − 2r: less than a full turn, so the angle is the arc.
    (-b.w.z).clamp(-1.0, 1.0).acos().to_degrees()
}

#[test]
fn the_rainbow_stands_where_the_deviation_is_stationary() {
    let bench = Bench::new(vec![unit_ball()]);
    let drop = |n: f64, h: f64| {
        let legs = [(0, Act::Refract(1.0 / n)), (0, Act::Mirror), (0, Act::Refract(n))];
        bench.trace(&at_height(h), &legs).expect("passes")
    };
    for (n, printed) in [(4.0 / 3.0, 42.029659), (1.333, 42.078107), (1.5, 22.841522)] {
        // D' by h has one component, in the plane of the path: signed along x × D.
        let turning = |h: f64| {
            let b = drop(n, h);
            b.dw(0).dot(Vec3::X.cross(b.w.to_vec()))
        };
        let h = zero(0.5, 0.99, turning);
        let bow = 180.0 - deviation(&drop(n, h));
        assert!((bow - printed).abs() < 6e-7, "n = {n}: bow at {bow}, not {printed}");
        let exact = ((4.0 - n * n) / 3.0f64).sqrt();
        assert!((h - exact).abs() < 1e-13, "n = {n}: h = {h}, not {exact}");
        if n == 4.0 / 3.0 {
            assert!((h - 0.860663).abs() < 6e-7 && (h.asin().to_degrees() - 59.391102).abs() < 6e-7, "{h}");
            assert!((deviation(&drop(n, h)) - 137.970341).abs() < 6e-7);
        }
    }
}
