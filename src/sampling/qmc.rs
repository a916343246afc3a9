//! Point sets of the unit square for any number of points: golden lattices, the R2 sequence, stratified sets. The
//! lattices that photons start from are [`super::lattice`]'s.

/// 1/φ, the golden ratio's fractional part: the generator whose rank-1 lattices have no bad n.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// 1/ρ and 1/ρ² of the plastic number ρ³ = ρ + 1 `[Roberts18]`. Cubic, so no rational relation with `GOLDEN`.
const PLASTIC: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

/// Point `i` of the rank-1 golden lattice of `n` points.
pub fn golden_lattice(i: u64, n: u64) -> [f64; 2] {
    [(i as f64 + 0.5) / n as f64, multiple(i, GOLDEN)]
}

/// Point `i` of the R2 sequence, which needs no n `[Roberts18]`.
pub fn r2(i: u64) -> [f64; 2] {
    PLASTIC.map(|a| multiple(i, a))
}

/// Number `i` ≥ 1 of van der Corput's sequence in [0, 1): ½, ¼, ¾, ⅛, …; every run of them fills the interval evenly.
pub fn van_der_corput(i: u32) -> f64 {
    f64::from(i.reverse_bits()) / 2f64.powi(32)
}

/// Cranley–Patterson rotation: `x` moved by `shift` on the torus `[CranleyPatterson76]`.
pub fn shifted(x: [f64; 2], shift: [f64; 2]) -> [f64; 2] {
    std::array::from_fn(|k| {
        let y = (x[k] + shift[k]).fract();
        // A sum just below 2 may round to a fraction of 1.
        if y < 1.0 { y } else { 0.0 }
    })
}

/// frac(i · a), exact to 2⁻⁵³ for every i: the product is taken in 64-bit fixed point.
fn multiple(i: u64, a: f64) -> f64 {
    let fixed = (a * 2f64.powi(64)) as u64;
    (i.wrapping_mul(fixed) >> 11) as f64 * 2f64.powi(-53)
}

/// The point at `offset` in [0, 1]² within stratum `i` of `n` equal cells that are about as wide as high once the
/// square is stretched to `aspect` × 1: rows whose heights are in proportion to their counts.
pub fn stratum(i: u64, n: u64, aspect: f64, offset: [f64; 2]) -> [f64; 2] {
    let rows = ((n as f64 / aspect).sqrt().round() as u64).clamp(1, n);
    let row_start = |row: u64| (u128::from(row) * u128::from(n) / u128::from(rows)) as u64;
    let mut row = (u128::from(i) * u128::from(rows) / u128::from(n)) as u64;
    while row_start(row + 1) <= i {
        row += 1;
    }
    let (start, end) = (row_start(row), row_start(row + 1));
    let count = (end - start) as f64;
    let x = ((i - start) as f64 + offset[0]) / count;
    let y = (start as f64 + offset[1] * count) / n as f64;
    [x.min(1.0 - f64::EPSILON), y.min(1.0 - f64::EPSILON)]
}

/// A permutation of 0..n: multiplication by a unit of ℤ/n near n/φ, then a rotation.
pub fn permuted(i: u64, n: u64, rotation: u64) -> u64 {
    ((u128::from(reordered(i, n, 1)) + u128::from(rotation)) % u128::from(n)) as u64
}

/// The k-th of a family of permutations of 0..n: multiplication by a unit of ℤ/n near n · frac(k/φ). The 0th changes
/// nothing.
pub fn reordered(i: u64, n: u64, k: u64) -> u64 {
    (u128::from(i) * u128::from(unit(n, k)) % u128::from(n)) as u64
}

/// The unit of ℤ/n that [`reordered`] multiplies by.
pub fn unit(n: u64, k: u64) -> u64 {
    let mut factor = ((n as f64 * multiple(k, GOLDEN)) as u64).max(1);
    while gcd(factor, n) != 1 {
        factor += 1;
    }
    factor
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strata_are_equal_cells_that_tile_the_square() {
        for n in [1u64, 2, 5, 12, 97, 1000] {
            let cell = |i| {
                let (lo, hi) = (stratum(i, n, 3.0, [0.0, 0.0]), stratum(i, n, 3.0, [1.0, 1.0]));
                (hi[0] - lo[0]) * (hi[1] - lo[1])
            };
            for i in 0..n {
                assert!((cell(i) * n as f64 - 1.0).abs() < 1e-9, "n={n} i={i}");
            }
        }
    }

    #[test]
    fn a_permutation_hits_everything_once() {
        for n in [1u64, 2, 6, 100, 1009] {
            let mut seen = vec![false; n as usize];
            for i in 0..n {
                seen[permuted(i, n, 5) as usize] = true;
            }
            assert!(seen.iter().all(|&s| s), "{n}");
            for k in 0..5 {
                let mut places: Vec<u64> = (0..n).map(|i| reordered(i, n, k)).collect();
                places.sort_unstable();
                assert!(places.into_iter().eq(0..n), "{n} {k}");
            }
        }
    }

    /// By the three-distance theorem the gaps of {i/φ} are at most (1 + φ)/n.
    #[test]
    fn the_lattice_has_no_holes() {
        let n = 1000;
        let mut x: Vec<f64> = (0..n).map(|i| golden_lattice(i, n)[1]).collect();
        x.sort_by(f64::total_cmp);
        let largest = x.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        assert!(largest * (n as f64) < 1.0 + 1.0 / GOLDEN, "largest gap {largest}");
    }

    #[test]
    fn fixed_point_multiples_agree_with_floating_point_where_that_is_exact() {
        for i in [0u64, 1, 2, 1000, 1 << 20] {
            assert!((multiple(i, GOLDEN) - (i as f64 * GOLDEN).fract()).abs() < 1e-9, "{i}");
        }
    }

    #[test]
    fn a_shifted_point_stays_in_the_half_open_square() {
        let below_one = 1.0 - f64::EPSILON / 2.0;
        assert!(shifted([below_one; 2], [below_one; 2]).iter().all(|x| (0.0..1.0).contains(x)));
    }
}
