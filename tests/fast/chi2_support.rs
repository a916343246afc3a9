//! The chi² machinery accepts a right density and rejects wrong ones.

use pdembree::sampling::{Purpose, Stream};

use crate::support::chi2::{Grid, integrate, sphere_direction, sphere_point};
use crate::support::statistics::LEVEL;

/// Uniform on the upper hemisphere, as seen by a density that is off by the factor and the tilt given.
fn hemisphere(factor: f64, tilt: f64) -> f64 {
    let mut stream = Stream::new(5, Purpose::Test, 0, 0);
    let draw = || {
        let [a, b] = stream.uniform2();
        Some(sphere_point(sphere_direction([std::f64::consts::TAU * (a - 0.5), b])))
    };
    let density = |[_, z]: [f64; 2]| {
        if z > 0.0 { factor * (1.0 + tilt * (z - 0.5)) / std::f64::consts::TAU } else { 0.0 }
    };
    Grid::sphere(16, 8).test(100_000, draw, density).p
}

#[test]
fn a_right_density_passes_and_wrong_ones_do_not() {
    assert!(hemisphere(1.0, 0.0) > LEVEL);
    assert!(hemisphere(1.0, 0.1) < LEVEL, "a tilt of 5 % from end to end");
    assert!(hemisphere(0.99, 0.0) < LEVEL, "a hundredth too little: draws that should have failed did not");
}

#[test]
fn draws_that_fail_are_held_against_the_missing_density() {
    let mut stream = Stream::new(6, Purpose::Test, 0, 0);
    let mut half = |p: f64| {
        let draw = || (stream.uniform() < 0.5).then(|| stream.uniform2());
        Grid::unit(8).test(50_000, draw, |_| p).p
    };
    assert!(half(0.5) > LEVEL);
    assert!(half(0.52) < LEVEL);
}

#[test]
fn the_cubature_follows_lobes_and_jumps() {
    let narrow =
        |[x, y]: [f64; 2]| (-((x - 0.3).powi(2) + (y - 0.6).powi(2)) / 2e-4).exp() / (2e-4 * std::f64::consts::PI);
    assert!((integrate(&narrow, [0.0, 1.0], [0.0, 1.0], 1e-9) - 1.0).abs() < 1e-6);
    // The strip of cells that the jump crosses at the last level is √2/2⁸ wide at most, half of it wrong on average.
    let jump = |[x, y]: [f64; 2]| if x + 0.7 * y < 0.6 { 1.0 } else { 0.0 };
    assert!((integrate(&jump, [0.0, 1.0], [0.0, 1.0], 1e-9) - 0.5 * 0.6 * 0.6 / 0.7).abs() < 1e-3);
}
