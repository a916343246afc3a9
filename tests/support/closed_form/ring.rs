//! The ring's floor: a mirror cylinder of radius 1 stands on a disc, parallel light enters over its rim and travels
//! ℓ = h / tan e horizontally before it reaches the floor.
//! · irradiance in units of that at the rim's plane · lengths in radii · the light travels towards +x
//!
//! Seen from above, a ray is a path of length ℓ in the unit disc. One that starts at height y = sin φ meets the wall at
//! the angle φ, and after its k-th bounce it leaves W_k at the angle φ + (k − 1)(π + 2φ) in the direction k(π + 2φ); all
//! chords are 2 cos φ long. With t left after the last bounce, ∂(x, y)/∂(start) = |2k t/cos φ − (2k − 1)|: for one
//! bounce |1 − 2t/cos φ|, the cardioid's fold at t = cos φ / 2.

use std::f64::consts::PI;

use super::bisect;

/// The horizontal travel of the reference numbers.
pub const TRAVEL: f64 = 1.2;
/// Bounces that are followed. A path of more has chords below ℓ/12: 1e-4 of the light.
const MAX_BOUNCES: i32 = 12;

/// Where light entering at (x, y) lands, and the area factor of the map.
pub fn landing(x: f64, y: f64, travel: f64) -> ([f64; 2], f64) {
    let phi = y.asin();
    let to_wall = phi.cos() - x;
    if travel <= to_wall {
        return ([x + travel, y], 1.0);
    }
    let chord = 2.0 * phi.cos();
    let k = 1 + ((travel - to_wall) / chord).floor() as i32;
    let t = travel - to_wall - f64::from(k - 1) * chord;
    let (w, r) = last_leg(k, phi);
    ([w[0] + t * r[0], w[1] + t * r[1]], area_factor(k, t, phi))
}

/// The last wall point and the direction from it.
fn last_leg(k: i32, phi: f64) -> ([f64; 2], [f64; 2]) {
    let turn = PI + 2.0 * phi;
    let (sw, cw) = (phi + f64::from(k - 1) * turn).sin_cos();
    let (sr, cr) = (f64::from(k) * turn).sin_cos();
    ([cw, sw], [cr, sr])
}

fn area_factor(k: i32, t: f64, phi: f64) -> f64 {
    (2.0 * f64::from(k) * t / phi.cos() - f64::from(2 * k - 1)).abs()
}

/// E at a floor point with a wall of reflectance `reflectance`.
pub fn irradiance(p: [f64; 2], travel: f64, reflectance: f64) -> f64 {
    if p[0] * p[0] + p[1] * p[1] >= 1.0 {
        return 0.0;
    }
    let unreflected = (p[0] - travel).powi(2) + p[1] * p[1] < 1.0;
    let bounced = (1..=MAX_BOUNCES).map(|k| reflectance.powi(k) * after_bounces(k, p, travel));
    f64::from(u8::from(unreflected)) + bounced.sum::<f64>()
}

/// Σ 1/area factor over the paths with `k` bounces that end in `p`.
fn after_bounces(k: i32, p: [f64; 2], travel: f64) -> f64 {
    // The miss of p by the last leg's line, as a function of φ.
    let miss = |phi: f64| {
        let (w, r) = last_leg(k, phi);
        (p[0] - w[0]) * r[1] - (p[1] - w[1]) * r[0]
    };
    // (k − 1) chords ≤ ℓ ≤ (k + 1) chords bounds φ.
    let steep = (0.5 * travel / f64::from(k + 1)).acos();
    let flat = if k == 1 { 0.0 } else { (0.5 * travel / f64::from(k - 1)).min(1.0).acos() };
    const STEPS: u32 = 96;
    let mut sum = 0.0;
    for (from, to) in [(-steep, -flat), (flat, steep)] {
        let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(STEPS);
        let brackets = (0..STEPS).map(|i| (at(i), at(i + 1)));
        for (a, b) in brackets.filter(|&(a, b)| miss(a).is_sign_positive() != miss(b).is_sign_positive()) {
            let phi = bisect(miss, a, b);
            let (w, r) = last_leg(k, phi);
            let t = (p[0] - w[0]) * r[0] + (p[1] - w[1]) * r[1];
            let chord = 2.0 * phi.cos();
            let before = travel - t - f64::from(k - 1) * chord;
            if (0.0..chord).contains(&t) && (0.0..chord).contains(&before) {
                sum += 1.0 / area_factor(k, t, phi);
            }
        }
    }
    sum
}
