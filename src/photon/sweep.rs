//! The segment that a photon's light sweeps over in its time cell, as a record has room for it: 24 bits · m, tangent frame.
//!
//! Only the swept kernel of `[Schjoth11]` asks for it. A direction of 12 bits is right to 0.4 mrad and a length of 12 bits,
//! from 2⁻²⁴ to 2⁸ m in steps of 0.5 %, to 0.3 %. Shape and normalisation of the kernel read the same record, so that its
//! rounding neither gains nor loses light.

use crate::math::Vec2;

const STEPS: f64 = 4096.0;
/// Length codes per octave, and the octave that they start at.
const PER_OCTAVE: f64 = 128.0;
const FIRST_OCTAVE: f64 = -24.0;

/// The code of a sweep that goes as far to both sides, so that only its line counts; `None` where it is too short or too
/// long to be told.
pub fn encode(sweep: Vec2) -> Option<u32> {
    let length = ((sweep.length().log2() - FIRST_OCTAVE) * PER_OCTAVE).round();
    // Written so that a NaN fails.
    if !(0.0..STEPS).contains(&length) {
        return None;
    }
    let turn = sweep.y.atan2(sweep.x).rem_euclid(std::f64::consts::PI) / std::f64::consts::PI;
    let direction = (turn * STEPS).round() % STEPS;
    Some((direction as u32) << 12 | length as u32)
}

/// The sweep of a code, to either side.
pub fn decode(code: u32) -> Vec2 {
    let [direction, length] = [code >> 12 & 0xfff, code & 0xfff].map(f64::from);
    let length = (length / PER_OCTAVE + FIRST_OCTAVE).exp2();
    Vec2::from_angle(direction / STEPS * std::f64::consts::PI) * length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_keep_their_line_and_length_but_for_rounding() {
        for k in 0..500 {
            let (angle, length) = (0.037 * f64::from(k), (0.045 * f64::from(k) - 16.0).exp2());
            let sweep = Vec2::from_angle(angle) * length;
            let read = decode(encode(sweep).expect("in range"));
            assert!(read.perp_dot(sweep).abs() < 4e-4 * length * length, "{sweep} {read}");
            assert!((read.length() / length - 1.0).abs() < 2.8e-3, "{sweep} {read}");
        }
        for sweep in [Vec2::ZERO, Vec2::X * 1e-9, Vec2::X * 1e9, Vec2::X * f64::NAN] {
            assert_eq!(encode(sweep), None, "{sweep}");
        }
    }
}
