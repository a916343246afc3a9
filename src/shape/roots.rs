//! Real roots of the polynomials that rays and quadrics or tori make · t in units of the ray's direction.

/// Both roots, ascending, of a t² + 2 b t + c = 0 with a > 0, given its discriminant over a, `disc` = b²/a − c, which the
/// caller computes without cancellation. Neither root loses digits [Press07 5.6].
pub(super) fn quadratic(a: f64, b: f64, c: f64, disc: f64) -> Option<[f64; 2]> {
    if disc < 0.0 || disc.is_nan() {
        return None;
    }
    let q = -(b + (disc * a).sqrt().copysign(b));
    let (r0, r1) = if q == 0.0 { (0.0, 0.0) } else { (q / a, c / q) };
    Some(if r0 < r1 { [r0, r1] } else { [r1, r0] })
}

/// The first of two ascending roots inside (t_min, t_max) that `accepts` takes.
pub(super) fn first_within(roots: [f64; 2], t_min: f64, t_max: f64, accepts: impl Fn(f64) -> bool) -> Option<f64> {
    roots.into_iter().find(|&t| t > t_min && t < t_max && accepts(t))
}

/// Bernstein coefficients on [0, 1] of the quartic Σ power[k] sᵏ `[Farouki12]`.
pub(super) fn bernstein4(power: [f64; 5]) -> [f64; 5] {
    let [a0, a1, a2, a3, a4] = power;
    [a0, a0 + a1 / 4.0, a0 + a1 / 2.0 + a2 / 6.0, a0 + 0.75 * a1 + a2 / 2.0 + a3 / 4.0, a0 + a1 + a2 + a3 + a4]
}

/// Halves the interval of a quartic in Bernstein form `[Farouki12]`.
fn split(b: [f64; 5]) -> ([f64; 5], [f64; 5]) {
    let mut left = [0.0; 5];
    let mut right = b;
    for (i, first) in left.iter_mut().enumerate() {
        *first = right[0];
        for j in 0..4 - i {
            right[j] = 0.5 * (right[j] + right[j + 1]);
        }
    }
    // `right` now holds the last points of each level, and those are the right half's coefficients in order.
    (left, right)
}

fn sign_changes(b: &[f64; 5]) -> usize {
    let mut changes = 0;
    let mut last = 0.0;
    for &x in b {
        if x != 0.0 {
            changes += usize::from(last * x.signum() < 0.0);
            last = x.signum();
        }
    }
    changes
}

/// A piece of [0, 1] that holds the first root of a quartic: exactly one simple root, or a cluster of roots closer than
/// rounding can part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bracket {
    pub lo: f64,
    pub hi: f64,
}

/// Brackets of the roots of a quartic in Bernstein form on [0, 1], first to last, each handed to `accept` until it
/// returns a value.
///
/// By Descartes' rule of signs the coefficients' sign changes bound the number of roots inside, and are of the same
/// parity: none means no root, one means one root. Intervals with more are halved, so that no root can be skipped,
/// down to pieces of width 2⁻⁴⁸, where what is left is a tangency as far as `f64` can tell `[Farouki12]`.
pub(super) fn first_bracket<T>(b: [f64; 5], accept: &mut impl FnMut(Bracket) -> Option<T>) -> Option<T> {
    const DEPTH: u32 = 48;
    // The pieces still to be looked at, nearest last.
    let mut pending = vec![(b, 0.0, 1.0, 0)];
    while let Some((b, lo, hi, depth)) = pending.pop() {
        let changes = sign_changes(&b);
        if changes == 0 {
            continue;
        }
        if changes == 1 || depth == DEPTH {
            if let Some(found) = accept(Bracket { lo, hi }) {
                return Some(found);
            }
            continue;
        }
        let middle = 0.5 * (lo + hi);
        let (left, right) = split(b);
        pending.push((right, middle, hi, depth + 1));
        pending.push((left, lo, middle, depth + 1));
    }
    None
}

/// A root of `f` (value and derivative) between `lo` and `hi`, where it changes sign: Newton's steps, halving wherever
/// one would leave the bracket or gains too little [Press07 9.4].
pub(super) fn polish(mut lo: f64, mut hi: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let rising = f(hi).0 > 0.0;
    let mut t = 0.5 * (lo + hi);
    let mut last_step = (hi - lo).abs();
    for _ in 0..200 {
        let (value, slope) = f(t);
        if value == 0.0 {
            return t;
        }
        if (value > 0.0) == rising {
            hi = t
        } else {
            lo = t
        }
        let newton = t - value / slope;
        let next =
            if newton > lo && newton < hi && (newton - t).abs() < 0.5 * last_step { newton } else { 0.5 * (lo + hi) };
        last_step = (next - t).abs();
        if last_step <= f64::EPSILON * t.abs() || next == lo || next == hi {
            return next;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power coefficients of Π (s − rᵢ).
    fn from_roots(roots: [f64; 4]) -> [f64; 5] {
        let mut p = [0.0; 5];
        p[0] = 1.0;
        for r in roots {
            for k in (0..5).rev() {
                p[k] = if k > 0 { p[k - 1] } else { 0.0 } - r * p[k];
            }
        }
        p
    }

    fn roots_of(power: [f64; 5]) -> Vec<Bracket> {
        let mut found = Vec::new();
        first_bracket::<()>(bernstein4(power), &mut |b| {
            found.push(b);
            None
        });
        found
    }

    #[test]
    fn every_simple_root_in_the_interval_gets_its_own_bracket_in_order() {
        let found = roots_of(from_roots([0.9, -0.5, 0.2, 0.55]));
        assert_eq!(found.len(), 3);
        for (b, r) in found.iter().zip([0.2, 0.55, 0.9]) {
            assert!(b.lo <= r && r <= b.hi, "{r} outside {b:?}");
        }
    }

    #[test]
    fn a_nearly_double_root_is_parted() {
        let found = roots_of(from_roots([0.3, 0.3 + 1e-6, 2.0, 3.0]));
        assert_eq!(found.len(), 2);
        assert!((found[0].lo - 0.3).abs() < 1e-6 && (found[1].hi - 0.3 - 1e-6).abs() < 1e-6);
    }

    #[test]
    fn a_quartic_without_real_roots_has_no_bracket() {
        // (s² − s + 1)(s² + 1)
        assert!(roots_of([1.0, -1.0, 2.0, -1.0, 1.0]).is_empty());
    }

    #[test]
    fn polishing_a_flat_cubic_converges_where_newton_alone_would_jump() {
        let root = polish(-1.0, 2.0, |t| (t.powi(3) - 1e-9, 3.0 * t * t));
        assert!((root - 1e-3).abs() < 1e-15, "{root}");
    }

    #[test]
    fn the_quadratic_keeps_the_small_root() {
        // (t − 1e-9)(t − 1e9)
        let b = -0.5 * (1e9 + 1e-9);
        let [r0, r1] = quadratic(1.0, b, 1.0, b * b - 1.0).expect("two roots");
        assert!((r0 / 1e-9 - 1.0).abs() < 1e-15 && (r1 / 1e9 - 1.0).abs() < 1e-15);
        assert!(quadratic(1.0, 0.0, 1.0, f64::NAN).is_none());
    }
}
