//! Sums that do not depend on the order of their terms: integers, in fixed point.
//!
//! Passes, tiles and machines may then be added up in any order and any grouping, and the picture keeps its bits. The
//! resolution is absolute: of a sum above 10⁻¹⁴ no digit is lost that an `f32` could show.

/// Bits behind the point of an [`ExactSum`].
const FRACTION: i32 = 70;

/// The largest term: 10¹² in round numbers, so that 2¹⁷ of them fit into a sum. A clear sky's sun has 10⁷ W/(m²·sr), a
/// 1 W laser beam of 1 mm² and 1 mrad 10¹².
pub const LARGEST: f64 = 1_099_511_627_776.0;

/// 2ⁿ, −1022 ≤ n ≤ 1023.
const fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((1023 + n) as u64) << 52)
}

/// A sum of numbers of either sign, each rounded to a multiple of 2⁻⁷⁰ and not larger than [`LARGEST`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExactSum(i128);

impl ExactSum {
    /// Adds one term.
    pub fn add(&mut self, x: f64) {
        // Multiplying by a power of two is exact; the cast rounds towards zero, which has no preferred direction in the
        // order of terms.
        self.0 = self.0.saturating_add((x * const { power_of_two(FRACTION) }) as i128);
    }
    pub fn merge(&mut self, other: ExactSum) {
        self.0 = self.0.saturating_add(other.0);
    }
    pub fn value(self) -> f64 {
        self.0 as f64 * const { power_of_two(-FRACTION) }
    }
    pub fn is_zero(self) -> bool {
        self.0 == 0
    }
    pub fn to_le_bytes(self) -> [u8; 16] {
        self.0.to_le_bytes()
    }
    pub fn from_le_bytes(bytes: [u8; 16]) -> ExactSum {
        ExactSum(i128::from_le_bytes(bytes))
    }
}

/// Bits behind the point of a sum of squares: those of [`LARGEST`]² and of 10⁻¹⁶ both fit, with room for 2¹⁶ passes.
const SQUARE_FRACTION: i32 = 160;
const LIMBS: usize = 4;

/// A sum of numbers that are not negative, over the range of squares of an [`ExactSum`]'s terms; 256 bits, little end
/// first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExactSquares([u64; LIMBS]);

impl ExactSquares {
    /// Adds x².
    pub fn add_square_of(&mut self, x: f64) {
        let q = x * x;
        // q = mantissa · 2^exponent, for a normal number; below that there is nothing to add.
        let bits = q.to_bits();
        let biased = (bits >> 52) as i32;
        if biased == 0 {
            return;
        }
        let mantissa = bits & ((1 << 52) - 1) | 1 << 52;
        let shift = biased - 1075 + SQUARE_FRACTION;
        let wide = u128::from(mantissa);
        let (limb, wide) = match u32::try_from(shift) {
            Ok(shift) => (shift as usize / 64, wide << (shift % 64)),
            Err(_) => (0, wide.checked_shr(shift.unsigned_abs()).unwrap_or(0)),
        };
        let mut term = [0; LIMBS];
        for (k, part) in [wide as u64, (wide >> 64) as u64].into_iter().enumerate() {
            match term.get_mut(limb + k) {
                Some(place) => *place = part,
                None if part == 0 => {}
                None => term = [u64::MAX; LIMBS],
            }
        }
        self.merge(ExactSquares(term));
    }

    /// Saturates, which is as independent of the order as adding.
    pub fn merge(&mut self, other: ExactSquares) {
        let mut carry = false;
        for (a, b) in self.0.iter_mut().zip(other.0) {
            let (sum, first) = a.overflowing_add(b);
            let (sum, second) = sum.overflowing_add(u64::from(carry));
            (*a, carry) = (sum, first || second);
        }
        if carry {
            self.0 = [u64::MAX; LIMBS];
        }
    }

    pub fn value(self) -> f64 {
        let limb = |(k, &limb): (usize, &u64)| limb as f64 * power_of_two(64 * k as i32 - SQUARE_FRACTION);
        self.0.iter().enumerate().map(limb).sum()
    }

    pub fn to_le_bytes(self) -> [u8; 32] {
        let mut bytes = [0; 32];
        for (place, limb) in bytes.chunks_exact_mut(8).zip(self.0) {
            place.copy_from_slice(&limb.to_le_bytes());
        }
        bytes
    }
    pub fn from_le_bytes(bytes: [u8; 32]) -> ExactSquares {
        let mut limbs = [0; LIMBS];
        for (limb, place) in limbs.iter_mut().zip(bytes.as_chunks().0) {
            *limb = u64::from_le_bytes(*place);
        }
        ExactSquares(limbs)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Any grouping of any order gives the same integer, and the value is the sum's to the resolution.
        #[test]
        fn order_and_grouping_do_not_matter(terms in prop::collection::vec(-1e6..1e6f64, 1..50), cut in 0usize..50) {
            let sum = |terms: &[f64]| {
                let mut sum = ExactSum::default();
                terms.iter().for_each(|&x| sum.add(x));
                sum
            };
            let reversed: Vec<f64> = terms.iter().rev().copied().collect();
            let (left, right) = terms.split_at(cut.min(terms.len()));
            let mut grouped = sum(right);
            grouped.merge(sum(left));
            prop_assert_eq!(sum(&terms), sum(&reversed));
            prop_assert_eq!(sum(&terms), grouped);
            let magnitude: f64 = terms.iter().map(|x| x.abs()).sum();
            prop_assert!((sum(&terms).value() - terms.iter().sum::<f64>()).abs() <= 1e-15 * magnitude * terms.len() as f64);
        }

        #[test]
        fn squares_add_over_the_whole_range(exponents in prop::collection::vec(-50..40i32, 1..20), m in 1.0..2.0f64) {
            let terms: Vec<f64> = exponents.iter().map(|&e| m * power_of_two(e) * 0.99).collect();
            let (mut there, mut back) = (ExactSquares::default(), ExactSquares::default());
            terms.iter().for_each(|&x| there.add_square_of(x));
            terms.iter().rev().for_each(|&x| back.add_square_of(x));
            prop_assert_eq!(there, back);
            let exact: f64 = terms.iter().map(|x| x * x).sum();
            prop_assert!((there.value() / exact - 1.0).abs() < 1e-12, "{} {}", there.value(), exact);
            prop_assert_eq!(ExactSquares::from_le_bytes(there.to_le_bytes()), there);
        }
    }

    #[test]
    fn too_much_saturates() {
        let mut squares = ExactSquares::default();
        squares.add_square_of(1e200);
        assert_eq!(squares.0, [u64::MAX; LIMBS]);
        squares.add_square_of(1.0);
        assert_eq!(squares.0, [u64::MAX; LIMBS]);
        squares = ExactSquares::default();
        squares.add_square_of(1e-200);
        assert_eq!(squares.value(), 0.0);
    }
}
