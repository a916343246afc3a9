//! The references themselves, against numbers computed independently (given to the digits printed).

use pdembree::sampling::stream::{Purpose, Stream};

use crate::support::closed_form::{ball, ring, wave};
use crate::support::statistics::{assert_plausible, z_test};

#[track_caller]
fn close(a: f64, b: f64, absolute: f64) {
    assert!((a - b).abs() <= absolute, "{a} is not {b} within {absolute}");
}

#[test]
fn wave_irradiance_at_points() {
    let expected = [
        (0.0, 1.560124, 1.447206, 3),
        (0.05, 1.623941, 1.508093, 3),
        (0.1, 1.902987, 1.773164, 3),
        (0.15, 4.234790, 3.969157, 3),
        (0.2, 0.457853, 0.429180, 1),
        (0.3, 0.446102, 0.423283, 1),
        (0.5, 0.429243, 0.409655, 1),
    ];
    for (x, e, with_fresnel, sheets) in expected {
        close(wave::irradiance(x, false), e, 6e-7);
        close(wave::irradiance(x, true), with_fresnel, 6e-7);
        assert_eq!(wave::sheets(x).len(), sheets, "sheets at {x}");
    }
    close(wave::stretch(0.0), -2.066918, 6e-7);
    close(wave::stretch(0.5), 2.329681, 6e-7);
}

#[test]
fn wave_stretch_is_the_derivative_of_the_landing() {
    let h = 1e-5;
    for x in [-0.4, -0.127, 0.02, 0.2, 0.33] {
        // Central difference: error h²/6 · |X‴| < 2e-11 · 6000, rounding 1e-11.
        close((wave::landing(x + h) - wave::landing(x - h)) / (2.0 * h), wave::stretch(x), 1.2e-7);
    }
}

/// E − E_outside = C/√d at the distance d inside the fold, C = 2/√(2 X″) = 0.317110.
#[test]
fn wave_folds_where_it_should_and_as_steeply() {
    let (x, image) = wave::fold();
    close(x, 0.127308, 6e-7);
    close(image.abs(), 0.157197, 6e-7);
    let h = 1e-4;
    let curvature = (wave::stretch(x + h) - wave::stretch(x - h)) / (2.0 * h);
    close(curvature, 19.889, 6e-4);
    let strength = 2.0 / (2.0 * curvature).sqrt();
    close(strength, 0.317110, 6e-6);
    // The next term is smaller by the distance over the wave's scale.
    for d in [1e-3, 1e-4, 1e-5] {
        let inside = wave::irradiance(image.abs() - d, false) - wave::irradiance(image.abs() + d, false);
        close(inside * d.sqrt() / strength, 1.0, 2.0 * d);
    }
}

#[test]
fn wave_rows_hold_the_flux_that_lands_in_them() {
    for (fresnel, fraction) in [(false, 0.905208), (true, 0.849586)] {
        let row = wave::averaged_row(480, fresnel);
        close(row.iter().sum::<f64>() / 480.0, fraction, 6e-7);
        close(wave::mean_irradiance(-wave::HALF_VIEW, wave::HALF_VIEW, fresnel), fraction, 6e-7);
    }
    let brightest = wave::averaged_row(480, false).into_iter().fold(0.0, f64::max);
    close(brightest, 12.3655, 6e-5);
    // Away from the folds a pixel's samples and its average differ by the curvature of E only.
    let (sampled, averaged) = (wave::sampled_row(480, 3, false), wave::averaged_row(480, false));
    for i in (0..480).filter(|&i| (i as f64 / 400.0 - 0.6).abs() > 0.2) {
        close(sampled[i], averaged[i], 1e-5);
    }
}

#[test]
fn ring_paths_and_area_factors() {
    let expected = [
        ((0.2, 0.3), [0.58816935, 0.04469107], 0.06480246),
        ((0.5, -0.4), [0.38374543, 0.17446059], 0.70970413),
        ((0.7, 0.1), [0.10807513, -0.08009522], 0.81914370),
    ];
    for ((x, y), end, factor) in expected {
        let (p, j) = ring::landing(x, y, ring::TRAVEL);
        close(p[0], end[0], 1e-8);
        close(p[1], end[1], 1e-8);
        close(j, factor, 6e-9);
    }
}

/// The area factor is |det| of central differences, for paths of one to four bounces.
#[test]
fn ring_area_factor_is_the_determinant() {
    let h = 1e-6;
    for (x, y) in [(0.2, 0.3), (0.1, -0.8), (-0.1, 0.9), (0.05, 0.95), (-0.9, 0.1)] {
        let at = |x, y| ring::landing(x, y, ring::TRAVEL).0;
        let column = |a: [f64; 2], b: [f64; 2]| [(a[0] - b[0]) / (2.0 * h), (a[1] - b[1]) / (2.0 * h)];
        let (dx, dy) = (column(at(x + h, y), at(x - h, y)), column(at(x, y + h), at(x, y - h)));
        let det = (dx[0] * dy[1] - dx[1] * dy[0]).abs();
        close(det, ring::landing(x, y, ring::TRAVEL).1, 1e-6 * (1.0 + det));
    }
}

/// Gathering on the floor is the same light as scattering over the rim: random rays land in a square as often as its
/// irradiance says (z-test of a binomial count; the squares lie off the folds, where the midpoint rule is exact to 1e-4).
#[test]
fn ring_irradiance_is_the_density_of_landings() {
    const RAYS: u64 = 400_000;
    const N: usize = 16;
    let squares = [(-0.6, 0.0), (-0.25, 0.3), (0.1, -0.45), (0.5, 0.55), (0.3, 0.0), (0.8, -0.3)];
    let half = 0.05;
    let mut counts = [0u64; 6];
    let mut stream = Stream::new(1, Purpose::Test, 0, 0);
    let mut started = 0;
    while started < RAYS {
        let [x, y] = stream.uniform2().map(|u| 2.0 * u - 1.0);
        if x * x + y * y < 1.0 {
            started += 1;
            let (p, _) = ring::landing(x, y, ring::TRAVEL);
            for (count, c) in counts.iter_mut().zip(squares) {
                *count += u64::from((p[0] - c.0).abs() < half && (p[1] - c.1).abs() < half);
            }
        }
    }
    for (&count, c) in counts.iter().zip(squares) {
        let at = |i: usize| half * (2.0 * (i as f64 + 0.5) / N as f64 - 1.0);
        let e = |i: usize, j: usize| ring::irradiance([c.0 + at(i), c.1 + at(j)], ring::TRAVEL, 1.0);
        let mean = (0..N * N).map(|i| e(i / N, i % N)).sum::<f64>() / (N * N) as f64;
        let p = mean * (2.0 * half).powi(2) / std::f64::consts::PI;
        let spread = (RAYS as f64 * p * (1.0 - p)).sqrt();
        let plausible = z_test(count as f64, RAYS as f64 * p, spread);
        assert_plausible(plausible, 6, format!("seed 1, square at {c:?}: {count} rays, {} expected", RAYS as f64 * p));
    }
}

#[test]
fn ball_lens_crossings_factors_and_folds() {
    for (n, focus) in [(1.5, 1.5), (1.33, 2.01515152), (1.8, 1.125), (2.0, 1.0)] {
        close(ball::crossing(0.0, n), focus, 6e-9);
    }
    let crossings = [
        (0.1, 1.49582706),
        (0.2, 1.48323202),
        (0.3, 1.46197844),
        (0.5, 1.39157295),
        (0.7, 1.27778702),
        (0.9, 1.10444557),
    ];
    for (h, axis) in crossings {
        close(ball::crossing(h, 1.5), axis, 6e-9);
    }
    for (d, e) in [(1.2, 23.04), (2.0, 8.2944), (3.0, 0.9216)] {
        close(ball::on_axis(d, 1.5), e, 1e-12 * e + 1e-12);
    }
    for (d, radius, h) in [(1.1, 0.120885, 0.624758), (1.25, 0.054917, 0.470754), (1.4, 0.013032, 0.287960)] {
        let (r, at) = ball::fold(d, 1.5);
        close(r.abs(), radius, 6e-7);
        close(at, h, 2e-6);
    }
    close(ball::fold(1.6, 1.33).0.abs(), 0.066739, 6e-7);
}

#[test]
fn ball_lens_flux_and_means() {
    close(ball::flux_fraction(1.0, 1.5), 0.83554440, 6e-8);
    close(ball::flux_fraction(1.0, 1.33), 0.88229525, 6e-8);
    for d in [2.0, 3.0] {
        // A small disc has the axis' value but for terms in radius²: ten times the radius, a hundred times the error.
        let error = |radius: f64| ball::mean_within(radius, d, 1.5) - ball::on_axis(d, 1.5);
        close(error(1e-3) / error(1e-2), 0.01, 1e-3);
    }
}
