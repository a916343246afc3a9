//! An order in which what is near in space is mostly near in a list: along a Z-curve `[Morton66]`.

use crate::math::{Bounds3, Point3};

/// Bits of a coordinate in a code.
const BITS: u32 = 19;
/// Bits of a code.
pub const CODE_BITS: u32 = 3 * BITS;

/// Places points of a box on the curve.
#[derive(Clone, Copy, Debug)]
pub struct ZCurve {
    lo: Point3,
    /// Cells a metre, the same along all axes.
    scale: f64,
}

impl ZCurve {
    /// Through the box `bounds`; empty ones and points are allowed.
    pub fn through(bounds: &Bounds3) -> ZCurve {
        let width = (bounds.max - bounds.min).max_element();
        let scale = f64::from((1u32 << BITS) - 1) / width;
        ZCurve { lo: bounds.min, scale: if scale.is_finite() && scale > 0.0 { scale } else { 0.0 } }
    }

    /// How far along the curve the cell of `p` lies.
    pub fn code(&self, p: Point3) -> u64 {
        let cell = (p - self.lo) * self.scale;
        // The cast saturates: what lies outside the box counts to the cells at its sides.
        let [x, y, z] = cell.to_array().map(|c| spread(u64::from((c as u32).min((1 << BITS) - 1))));
        x | y << 1 | z << 2
    }
}

/// The bits of x, two zeros between neighbours.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_interleave_the_bits_of_the_coordinates() {
        for x in [0u64, 1, 0b1011, (1 << BITS) - 1] {
            let expected = (0..BITS).map(|bit| (x >> bit & 1) << (3 * bit)).sum::<u64>();
            assert_eq!(spread(x), expected, "{x:b}");
        }
    }

    /// Sorted by the curve, neighbours of a list are near each other: their mean distance is a small part of what it
    /// is at random.
    #[test]
    fn neighbours_on_the_curve_are_near() {
        let grid = 32;
        let bounds = Bounds3 { min: Point3::ORIGIN, max: Point3::new(31.0, 31.0, 31.0) };
        let curve = ZCurve::through(&bounds);
        let at = |i: i32| Point3::new(f64::from(i % grid), f64::from(i / grid % grid), f64::from(i / grid / grid));
        let mut points: Vec<Point3> = (0..grid * grid * grid).map(at).collect();
        points.sort_by_key(|&p| curve.code(p));
        let mean = points.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>() / points.len() as f64;
        assert!(mean < 2.0, "{mean}");
    }

    #[test]
    fn a_box_without_extent_has_one_cell() {
        let p = Point3::new(1.0, 2.0, 3.0);
        assert_eq!(ZCurve::through(&Bounds3 { min: p, max: p }).code(p), 0);
    }
}
