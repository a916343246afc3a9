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

/// E at the distance `rho` from the axis on the plane at `d` under a beam of radius `beam`, inner reflections left out:
/// the sum over all heights whose rays land there.
pub fn irradiance(rho: f64, d: f64, n: f64, beam: f64) -> f64 {
    const STEPS: u32 = 2000;
    let step = 1e-6;
    // Rays near the rim are turned by more than 90 degrees.
    let lands = |h: f64| turn(h, n) < std::f64::consts::FRAC_PI_2;
    let slope = |h: f64| (landing(h + step, d, n) - landing(h - step, d, n)) / (2.0 * step);
    let mut sum = 0.0;
    for side in [-rho, rho] {
        let miss = |h: f64| landing(h, d, n) - side;
        let at = |i: u32| beam * f64::from(i) / f64::from(STEPS);
        let brackets = (0..STEPS).map(|i| (at(i), at(i + 1))).filter(|&(_, b)| lands(b));
        for (a, b) in brackets.filter(|&(a, b)| miss(a).is_sign_positive() != miss(b).is_sign_positive()) {
            let h = bisect(miss, a, b);
            sum += passed(h, n) * h / (rho * slope(h).abs());
        }
    }
    sum
}

/// Where the ray at height `h` meets the plane at `d` after `inner` reflections inside the ball, and on its outside with
/// `None`: by vectors, from point to point. The second number is the fraction of the light that goes this way.
pub fn traced(h: f64, d: f64, n: f64, inner: Option<u32>) -> Option<(f64, f64)> {
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let along = |a: [f64; 2], t: f64, b: [f64; 2]| [a[0] + t * b[0], a[1] + t * b[1]];
    // Back to length 1, or rounding would grow from bounce to bounce.
    let unit = |a: [f64; 2]| a.map(|x| x / a[0].hypot(a[1]));
    let reflect = |w: [f64; 2], p: [f64; 2]| unit(along(w, -2.0 * dot(w, p), p));
    // Snell's law with the normal `m` against `w`.
    let refract = |w: [f64; 2], m: [f64; 2], eta: f64| {
        let cos = -dot(w, m);
        let cos_t = (1.0 - eta * eta * (1.0 - cos * cos)).sqrt();
        unit(along([eta * w[0], eta * w[1]], eta * cos - cos_t, m))
    };
    // Height and distance along the beam.
    let (mut p, mut w) = ([h, -(1.0 - h * h).sqrt()], [0.0, 1.0]);
    let t = transmittance(-dot(w, p), n);
    let passed = match inner {
        None => {
            w = reflect(w, p);
            1.0 - t
        }
        Some(inner) => {
            w = refract(w, p, 1.0 / n);
            p = unit(along(p, -2.0 * dot(p, w), w));
            for _ in 0..inner {
                w = reflect(w, p);
                p = unit(along(p, -2.0 * dot(p, w), w));
            }
            let inside = transmittance(dot(w, p), 1.0 / n);
            w = refract(w, [-p[0], -p[1]], n);
            t * inside * (1.0 - inside).powi(inner as i32)
        }
    };
    (w[1] > 0.0).then(|| (p[0] + (d - p[1]) / w[1] * w[0], passed))
}
