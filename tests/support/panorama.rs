//! A panorama that says where it is: N, E, S, W, U(p) and D(own), each on a face of its own colour, as a function of the
//! direction in our world, +y up, north −z and east +x.

use std::f64::consts::PI;
use std::path::Path;

use pdembree::math::{Dir3, Vec3};
use pdembree::sampling::warp::{UniformSphere, Warp};

/// Rows of five bits, from the top.
const N: [u8; 7] = [0b10001, 0b11001, 0b10101, 0b10011, 0b10001, 0b10001, 0b10001];
const E: [u8; 7] = [0b11111, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000, 0b11111];
const S: [u8; 7] = [0b01111, 0b10000, 0b01110, 0b00001, 0b00001, 0b10001, 0b01110];
const W: [u8; 7] = [0b10001, 0b10001, 0b10001, 0b10101, 0b10101, 0b11011, 0b10001];
const U: [u8; 7] = [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110];
const D: [u8; 7] = [0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110];

/// A face: ahead, to the right and to the top of one who reads it; its colour and letter.
struct Face {
    axes: [Vec3; 3],
    colour: [u8; 3],
    letter: [u8; 7],
}

const FACES: [Face; 6] = [
    Face { axes: [Vec3::NEG_Z, Vec3::X, Vec3::Y], colour: [40, 60, 200], letter: N },
    Face { axes: [Vec3::X, Vec3::Z, Vec3::Y], colour: [30, 140, 50], letter: E },
    Face { axes: [Vec3::Z, Vec3::NEG_X, Vec3::Y], colour: [200, 40, 30], letter: S },
    Face { axes: [Vec3::NEG_X, Vec3::NEG_Z, Vec3::Y], colour: [210, 170, 30], letter: W },
    Face { axes: [Vec3::Y, Vec3::X, Vec3::Z], colour: [120, 190, 230], letter: U },
    Face { axes: [Vec3::NEG_Y, Vec3::X, Vec3::NEG_Z], colour: [90, 70, 50], letter: D },
];

const INK: [u8; 3] = [255, 255, 255];

/// The way to the middle of each face, and its colour.
pub fn middles() -> [(Vec3, [u8; 3]); 6] {
    FACES.map(|face| (face.axes[0], face.colour))
}

/// What is written in a direction, sRGB.
pub fn label(w: Vec3) -> [u8; 3] {
    let face = FACES.iter().max_by(|a, b| a.axes[0].dot(w).total_cmp(&b.axes[0].dot(w))).expect("six");
    let [ahead, right, top] = face.axes.map(|axis| axis.dot(w));
    // A letter is half as wide as its face and 0.7 as high.
    let (x, y) = ((0.5 * right / ahead + 0.25) / 0.5, (0.35 - 0.5 * top / ahead) / 0.7);
    let inside = (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y);
    let written = |x: f64, y: f64| face.letter[(7.0 * y) as usize] >> (4 - (5.0 * x) as u32) & 1 == 1;
    if inside && written(x, y) { INK } else { face.colour }
}

fn write(path: &Path, size: [u32; 2], colour: impl Fn([f64; 2]) -> [u8; 3]) {
    let at = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    let image = image::RgbImage::from_fn(size[0], size[1], |x, y| image::Rgb(colour([at(x, size[0]), at(y, size[1])])));
    image.save(path).expect("written");
}

/// A lat-long image whose middle is at `centre` and whose top is +y.
pub fn write_lat_long(path: &Path, height: u32, centre: Vec3) {
    let left = Vec3::Y.cross(centre);
    write(path, [2 * height, height], |[x, y]| {
        let ((sin, cos), (aside, ahead)) = ((PI * y).sin_cos(), (PI * (1.0 - 2.0 * x)).sin_cos());
        label((centre * ahead + left * aside) * sin + Vec3::Y * cos)
    });
}

/// pbrt's map of a light's own space, which `to_ours` puts into the world.
pub fn write_octahedral(path: &Path, side: u32, to_ours: impl Fn(Vec3) -> Vec3) {
    write(path, [side, side], |u| label(to_ours(Dir3::to_vec(UniformSphere.sample(u)))));
}
