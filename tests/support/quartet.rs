//! Central differences with a bound on their own error, for Jacobians.

use pdembree::math::Vec3;

/// df/dx at `x` and a bound on the error of this number: two steps extrapolated (Richardson), the bound being what the
/// extrapolation changed plus the rounding of values as large as `scale`.
pub fn difference(f: impl Fn(f64) -> Vec3, x: f64, scale: f64) -> (Vec3, f64) {
    let h = 1e-4;
    let central = |h: f64| (f(x + h) - f(x - h)) / (2.0 * h);
    let (coarse, fine) = (central(h), central(0.5 * h));
    (fine + (fine - coarse) / 3.0, (fine - coarse).length() + 16.0 * f64::EPSILON * scale / h)
}

/// `u` with one coordinate replaced.
pub fn with<const N: usize>(mut u: [f64; N], k: usize, x: f64) -> [f64; N] {
    u[k] = x;
    u
}

/// As [`difference`], `None` where `f` is not smooth near `x` or gives nothing: there the slopes to the two sides do
/// not come together in proportion to the step.
pub fn smooth_difference(f: impl Fn(f64) -> Option<Vec3>, x: f64, scale: f64) -> Option<(Vec3, f64)> {
    let h = 1e-4;
    let (below, middle, above) = (f(x - h)?, f(x)?, f(x + h)?);
    let bend = |h: f64| Some((f(x + h)? - middle * 2.0 + f(x - h)?) / h);
    let (coarse, fine) = (bend(h)?, bend(0.5 * h)?);
    let rounding = 16.0 * f64::EPSILON * scale / h;
    // A break within the step leaves a bend that does not shrink, one beyond half the step a bend that vanishes.
    if (coarse - fine * 2.0).length() > 0.1 * coarse.length() + rounding || !(above - below).is_finite() {
        return None;
    }
    let (_, _) = (f(x - 0.5 * h)?, f(x + 0.5 * h)?);
    Some(difference(|t| f(t).unwrap_or(Vec3::NAN), x, scale))
}
