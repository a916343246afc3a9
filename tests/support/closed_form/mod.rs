//! Irradiance in closed form, for pictures that must not be compared with another renderer's.

pub mod ball;
pub mod ring;
pub mod wave;

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

/// A root of `f` between `a` and `b`, where `f` changes sign, to the last bit.
pub fn bisect(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let sign = f(a).is_sign_positive();
    assert_ne!(sign, f(b).is_sign_positive(), "no change of sign between {a} and {b}");
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
