//! The way that a photon's light goes in a time, as a record has room for it: 24 bits · m, tangent frame.
//!
//! The swept kernel of `[Schjoth11]` asks for it, and points on objects that are carried through the light
//! (`estimate::pair`). A direction of 12 bits is right to 0.8 mrad and a length of 12 bits, from 2⁻²⁴ to 2⁸ m in steps of
//! 0.5 %, to 0.3 %. Shape and normalisation of the kernel read the same record, so that its rounding neither gains nor
//! loses light.

use crate::math::Vec2;

const STEPS: f64 = 4096.0;
/// Length codes per octave, and the octave that they start at.
const PER_OCTAVE: f64 = 128.0;
const FIRST_OCTAVE: f64 = -24.0;

/// The code of a way; `None` where it is too short or too long to be told.
pub fn encode(sweep: Vec2) -> Option<u32> {
    let length = ((sweep.length().log2() - FIRST_OCTAVE) * PER_OCTAVE).round();
    // Written so that a NaN fails.
    if !(0.0..STEPS).contains(&length) {
        return None;
    }
    let turn = sweep.y.atan2(sweep.x).rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU;
    let direction = (turn * STEPS).round() % STEPS;
    Some((direction as u32) << 12 | length as u32)
}

/// The way of a code.
pub fn decode(code: u32) -> Vec2 {
    let [direction, length] = [code >> 12 & 0xfff, code & 0xfff].map(f64::from);
    let length = (length / PER_OCTAVE + FIRST_OCTAVE).exp2();
    Vec2::from_angle(direction / STEPS * std::f64::consts::TAU) * length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_kept_but_for_rounding() {
        for k in 0..500 {
            let (angle, length) = (0.037 * f64::from(k), (0.045 * f64::from(k) - 16.0).exp2());
            let sweep = Vec2::from_angle(angle) * length;
            let read = decode(encode(sweep).expect("in range"));
            assert!(read.dot(sweep) > 0.0 && read.perp_dot(sweep).abs() < 7.8e-4 * length * length, "{sweep} {read}");
            assert!((read.length() / length - 1.0).abs() < 2.8e-3, "{sweep} {read}");
        }
        for sweep in [Vec2::ZERO, Vec2::X * 1e-9, Vec2::X * 1e9, Vec2::X * f64::NAN] {
            assert_eq!(encode(sweep), None, "{sweep}");
        }
    }
}
