//! Where first derivatives stop meaning anything: columns that claim to turn a ray by a large angle.
//!
//! A cell that meets a mirror at its silhouette, or glass next to total reflection, is turned by far more than its
//! derivative holds for; followed on, it would cover the whole scene. Such a column is narrowed, position and direction
//! together: it stays the exact derivative of a smaller cell. A kernel's energy does not depend on its width, so what
//! is lost is evenness, never light.

use super::state::Differential;

/// The largest turn of a direction by one cell, radians, at which a sine and its tangent still agree to 3 %.
pub const MAX_SPREAD: f64 = 0.3;

/// Narrows every column with |∂ω| above `max_spread`, and returns how many these are.
pub fn narrow<const N: usize>(d: &mut Differential<N>, max_spread: f64) -> u32 {
    let spread = d.dw.length_squared().sqrt().0;
    let count = spread.iter().map(|&spread| u32::from(spread > max_spread)).sum();
    // Nearly always none is.
    if count > 0 {
        *d = d.scaled_each(spread.map(|spread| if spread > max_spread { max_spread / spread } else { 1.0 }));
    }
    count
}

#[cfg(test)]
mod tests {
    use super::super::state::Column;
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn a_wide_column_shrinks_as_a_whole_and_a_narrow_one_stays() {
        let wide = Column { dx: Vec3::X, dw: Vec3::Y * 3.0 };
        let flat = Column { dx: Vec3::Z, dw: Vec3::X * 0.1 };
        let mut d = Differential::new([wide, flat]);
        assert_eq!(narrow(&mut d, 0.3), 1);
        assert_eq!(d.column(1), flat);
        assert!((d.column(0).dw - Vec3::Y * 0.3).length() < 1e-15);
        assert!((d.column(0).dx - Vec3::X * 0.1).length() < 1e-15);
    }
}
