//! Coordinates in which densities on disks and spheres are even, and the chi² test of that.

use std::f64::consts::PI;

use pdembree::math::{Dir3, Frame, Vec3};

use super::statistics::chi2_test;

/// Azimuth as a fraction of a turn, and the axial coordinate, of a vector in a frame.
fn turn(frame: &Frame, v: Vec3) -> (f64, f64) {
    let local = frame.to_local(v);
    (local.y.atan2(local.x) / (2.0 * PI) + 0.5, local.z)
}

/// Coordinates of a point of a disk in which equal areas are equal: azimuth, squared radius.
pub fn on_disk(frame: &Frame, x: Vec3, radius: f64) -> [f64; 2] {
    [turn(frame, x).0, frame.project(x).length_squared() / (radius * radius)]
}

/// Coordinates of a direction in which equal solid angles within `height` = 1 − cos of `axis` are equal.
pub fn in_cone(axis: impl Into<Vec3>, w: impl Into<Vec3>, height: f64) -> [f64; 2] {
    let (turn, cos) = turn(&Frame::from_unit(axis), w.into());
    [turn, (1.0 - cos) / height]
}

/// Coordinates of a cosine-weighted direction in which its density is even.
pub fn about(n: impl Into<Vec3>, w: Dir3) -> [f64; 2] {
    let (turn, cos) = turn(&Frame::from_unit(n), w.to_vec());
    [turn, cos * cos]
}

/// p-value of "the coordinates are even over the unit cube of their dimension", in cells of the side 1/`ticks`.
pub fn evenness(ticks: usize, draws: usize, mut draw: impl FnMut() -> Vec<f64>) -> f64 {
    let dimensions = draw().len();
    let mut counts = vec![0u64; ticks.pow(dimensions as u32)];
    for _ in 0..draws {
        let cell = draw().into_iter().fold(0, |cell, x| {
            assert!((-1e-8..=1.0 + 1e-8).contains(&x), "a coordinate {x} outside of [0, 1]");
            cell * ticks + ((x.max(0.0) * ticks as f64) as usize).min(ticks - 1)
        });
        counts[cell] += 1;
    }
    chi2_test(&counts, &vec![draws as f64 / counts.len() as f64; counts.len()])
}
