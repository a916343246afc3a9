//! Free flight to a surface · [Igehy99 (10)–(12)].

use super::lanes::Vectors;
use super::state::Differential;
use crate::math::{Dir3, Normal3};

/// Moves the columns a distance `s` along `w` onto the surface with geometric normal `ng`. The caller guarantees
/// w·ng ≠ 0; a grazing hit makes long columns, which is right and not clamped here.
#[inline(always)]
pub fn transfer<const N: usize>(d: &Differential<N>, w: Dir3, s: f64, ng: Normal3) -> Differential<N> {
    let cos = w.dot(ng);
    let moved = d.dx + d.dw * s;
    Differential { dx: moved - Vectors::multiples(w.to_vec(), moved.dot(ng.to_vec()) / cos), dw: d.dw }
}
