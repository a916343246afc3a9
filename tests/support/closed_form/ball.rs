//! A ball lens in a beam: a glass sphere of radius 1, light along its axis, a plane behind it.
//! · irradiance in units of the beam's · lengths in radii · distances from the centre
//!
//! A ray at height h enters at the angle sin i = h, is refracted to sin r = h/n, and leaves turned by δ = 2(i − r)
//! towards the axis, which it crosses at f(h) = h / sin δ. On a plane at distance d it lands at ρ(h) = (f − d) tan δ,
//! beyond the axis where ρ < 0. Two interfaces pass T(h)², inner reflections are left out.

use super::{bisect, simpson, transmittance};

fn turn(h: f64, n: f64) -> f64 {
    2.0 * (h.asin() - (h / n).asin())
}

/// Where the ray at height `h` crosses the axis.
pub fn crossing(h: f64, n: f64) -> f64 {
    if h == 0.0 { n / (2.0 * (n - 1.0)) } else { h / turn(h, n).sin() }
}

/// Signed landing radius on the plane at `d`.
pub fn landing(h: f64, d: f64, n: f64) -> f64 {
    if h == 0.0 { 0.0 } else { (crossing(h, n) - d) * turn(h, n).tan() }
}

/// Fraction of the light at height `h` that passes both interfaces.
pub fn passed(h: f64, n: f64) -> f64 {
    transmittance((1.0 - h * h).sqrt(), n).powi(2)
}

/// E on the axis, Fresnel included; valid where only the paraxial rays meet it (`d` beyond the paraxial focus).
pub fn on_axis(d: f64, n: f64) -> f64 {
    passed(0.0, n) / (1.0 - d / crossing(0.0, n)).powi(2)
}

/// Fraction of the beam inside `radius` that goes through the ball.
pub fn flux_fraction(radius: f64, n: f64) -> f64 {
    // h = R sin a, so that the steep end at h = 1 is resolved.
    let f = |a: f64| {
        let h = (radius * a.sin()).min(1.0);
        passed(h, n) * 2.0 * a.sin() * a.cos()
    };
    simpson(f, 0.0, std::f64::consts::FRAC_PI_2, 2000)
}

/// The fold on the plane at `d` before the paraxial focus: (radius, height of the ray that makes it).
pub fn fold(d: f64, n: f64) -> (f64, f64) {
    let step = 1e-5;
    let slope = |h: f64| landing(h + step, d, n) - landing(h - step, d, n);
    let h = bisect(slope, 0.05, 0.95);
    (landing(h, d, n), h)
}

/// Mean E within `radius` of the axis on the plane at `d`, which lies so far behind the focus that ρ(h) falls
/// monotonically and one sheet covers the disc.
pub fn mean_within(radius: f64, d: f64, n: f64) -> f64 {
    let h = bisect(|h| landing(h, d, n) + radius, 1e-9, 0.9);
    flux_fraction(h, n) * h * h / (radius * radius)
}
