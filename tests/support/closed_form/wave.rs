//! The wave: light falls straight down on z = 0.25 cos 2πx of glass, a plane below catches it.
//! · irradiance in units of the beam's E⊥ · lengths in wavelengths · z up
//!
//! A ray that enters at x with slope h′ = tan i is refracted to sin t = sin i / n, leans by i − t towards the crest, and
//! lands at X(x) = x + (h − z_r) tan(i − t). Flux is conserved, so E(X) = Σ T(x)/|dX/dx| over all x with X(x) = X: three
//! sheets between the folds, where dX/dx = 0, and one outside.

use std::f64::consts::TAU;

use super::{bisect, simpson, transmittance};

pub const AMPLITUDE: f64 = 0.25;
/// The published figure gives 1.543; the reference numbers were computed with this.
pub const INDEX: f64 = 1.5433;
pub const RECEIVER: f64 = -0.6327;
/// Half width of the picture.
pub const HALF_VIEW: f64 = 0.6;

fn height(x: f64) -> f64 {
    AMPLITUDE * (TAU * x).cos()
}

fn slope(x: f64) -> f64 {
    -TAU * AMPLITUDE * (TAU * x).sin()
}

/// Where the light that enters at `x` lands.
pub fn landing(x: f64) -> f64 {
    let i = slope(x).atan();
    let t = (i.sin() / INDEX).asin();
    x + (height(x) - RECEIVER) * (i - t).tan()
}

/// dX/dx.
pub fn stretch(x: f64) -> f64 {
    let s = slope(x);
    let i = s.atan();
    let t = (i.sin() / INDEX).asin();
    let di = -TAU * TAU * height(x) / (1.0 + s * s);
    let dt = i.cos() * di / (INDEX * t.cos());
    let lean = (i - t).tan();
    1.0 + s * lean + (height(x) - RECEIVER) * (1.0 + lean * lean) * (di - dt)
}

/// Fresnel transmittance at `x`, or 1 without Fresnel.
fn passed(x: f64, fresnel: bool) -> f64 {
    if fresnel { transmittance(1.0 / slope(x).hypot(1.0), INDEX) } else { 1.0 }
}

/// Where the surface folds the beam: the positive x with dX/dx = 0 and its image.
pub fn fold() -> (f64, f64) {
    let x = bisect(stretch, 0.0, 0.25);
    (x, landing(x))
}

/// The largest x whose light can reach the picture.
pub fn source_edge() -> f64 {
    bisect(|x| landing(x) - HALF_VIEW, fold().0, 0.9)
}

/// The x intervals on which X(x) is monotone and that can reach the picture.
fn branches() -> [(f64, f64); 3] {
    let (fold, _) = fold();
    let end = source_edge() + 0.05;
    [(-end, -fold), (-fold, fold), (fold, end)]
}

/// The source points of `target`, one for each sheet.
pub fn sheets(target: f64) -> Vec<f64> {
    let miss = |x: f64| landing(x) - target;
    let on = |&(a, b): &(f64, f64)| miss(a).is_sign_positive() != miss(b).is_sign_positive();
    branches().iter().filter(|b| on(b)).map(|&(a, b)| bisect(miss, a, b)).collect()
}

/// E/E⊥ at a point of the receiver.
pub fn irradiance(target: f64, fresnel: bool) -> f64 {
    sheets(target).into_iter().map(|x| passed(x, fresnel) / stretch(x).abs()).sum()
}

/// E/E⊥ averaged over [a, b] of the receiver: the flux of the source intervals that land there.
pub fn mean_irradiance(a: f64, b: f64, fresnel: bool) -> f64 {
    let mut flux = 0.0;
    for (lo, hi) in branches() {
        let inverse = |target: f64| {
            let miss = |x: f64| landing(x) - target;
            match (miss(lo) < 0.0, miss(hi) < 0.0) {
                (true, false) | (false, true) => bisect(miss, lo, hi),
                // The branch lies wholly on one side: its end nearer to the target.
                (below, _) if below == (landing(lo) < landing(hi)) => hi,
                _ => lo,
            }
        };
        let (p, q) = (inverse(a), inverse(b));
        flux += simpson(|x| passed(x, fresnel), p.min(q), p.max(q), 16);
    }
    flux / (b - a)
}

/// One row of the picture (it is the same in every row): the mean of `samples` points at the centres of equal parts of
/// each pixel.
pub fn sampled_row(width: usize, samples: usize, fresnel: bool) -> Vec<f64> {
    let position = |k: usize| HALF_VIEW * (2.0 * (k as f64 + 0.5) / (width * samples) as f64 - 1.0);
    let pixel = |i: usize| (0..samples).map(|j| irradiance(position(i * samples + j), fresnel)).sum::<f64>();
    (0..width).map(|i| pixel(i) / samples as f64).collect()
}

/// One row of the picture, each pixel the average over its area.
pub fn averaged_row(width: usize, fresnel: bool) -> Vec<f64> {
    let border = |i: usize| HALF_VIEW * (2.0 * i as f64 / width as f64 - 1.0);
    (0..width).map(|i| mean_irradiance(border(i), border(i + 1), fresnel)).collect()
}
