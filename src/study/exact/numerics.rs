//! Fresnel's equations, a root finder and a quadrature, as the closed forms need them.
//!
//! Written anew, not taken from `surface`: a reference must not share the code that it judges.

/// Fraction of unpolarised light that passes a smooth interface; `cos` of the incident angle, `n` = index behind over
/// index before. Fresnel's equations.
pub fn transmittance(cos: f64, n: f64) -> f64 {
    let sin2 = (1.0 - cos * cos) / (n * n);
    if sin2 >= 1.0 {
        return 0.0;
    }
    let cos_t = (1.0 - sin2).sqrt();
    let s = (cos - n * cos_t) / (cos + n * cos_t);
    let p = (n * cos - cos_t) / (n * cos + cos_t);
    1.0 - 0.5 * (s * s + p * p)
}

/// Fraction of unpolarised light that a smooth metal of index `eta` + i `k` reflects; `cos` of the incident angle.
/// Fresnel's equations with the complex index N: rₛ = (cos − C)/(cos + C), rₚ = (N² cos − C)/(N² cos + C), C² = N² − sin².
pub fn metal_reflectance(cos: f64, eta: f64, k: f64) -> f64 {
    let n2 = [eta * eta - k * k, 2.0 * eta * k];
    let c = root([n2[0] - (1.0 - cos * cos), n2[1]]);
    let ratio =
        |[a, b]: [f64; 2]| ((a - c[0]).powi(2) + (b - c[1]).powi(2)) / ((a + c[0]).powi(2) + (b + c[1]).powi(2));
    0.5 * (ratio([cos, 0.0]) + ratio(n2.map(|x| x * cos)))
}

/// The square root of a + ib in the first quadrant, for b ≥ 0.
fn root([a, b]: [f64; 2]) -> [f64; 2] {
    let modulus = a.hypot(b);
    [0.5 * (modulus + a), 0.5 * (modulus - a)].map(|x| x.max(0.0).sqrt())
}

/// A root of `f` between `a` and `b` to the last bit. Where `f` does not change sign between them it is the end where
/// `f` is smaller: the root that rounding moved out.
pub fn bisect(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let (at_a, at_b) = (f(a), f(b));
    let sign = at_a.is_sign_positive();
    if sign == at_b.is_sign_positive() {
        return if at_a.abs() <= at_b.abs() { a } else { b };
    }
    loop {
        let middle = 0.5 * (a + b);
        if middle == a || middle == b {
            return middle;
        }
        if f(middle).is_sign_positive() == sign { a = middle } else { b = middle }
    }
}

/// ∫ f over [a, b] by Simpson's rule with `n` double steps.
pub fn simpson(f: impl Fn(f64) -> f64, a: f64, b: f64, n: usize) -> f64 {
    let h = (b - a) / (2 * n) as f64;
    let inner: f64 = (1..2 * n).map(|i| if i % 2 == 1 { 4.0 } else { 2.0 } * f(a + h * i as f64)).sum();
    h / 3.0 * (f(a) + inner + f(b))
}

/// The roots of `f` in [a, b] that its signs at `steps` + 1 even places show, ascending.
pub fn roots(f: impl Fn(f64) -> f64, a: f64, b: f64, steps: usize) -> Vec<f64> {
    let at = |i: usize| a + (b - a) * i as f64 / steps as f64;
    let mut found = Vec::new();
    let mut before = f(a).is_sign_positive();
    for i in 0..steps {
        let after = f(at(i + 1)).is_sign_positive();
        if after != before {
            found.push(bisect(&f, at(i), at(i + 1)));
        }
        before = after;
    }
    found
}
