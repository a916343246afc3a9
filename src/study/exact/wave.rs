//! The wave: light falls straight down on z = A cos kx of glass, a plane below catches it.
//! · irradiance in units of the beam's E⊥ · lengths in any one unit · z up
//!
//! A ray that enters at x with slope h′ = tan i is refracted to sin t = sin i / n, leans by i − t towards the crest, and
//! lands at X(x) = x + (h − z_r) tan(i − t). Flux is conserved, so E(X) = Σ T(x)/|dX/dx| over all x with X(x) = X: for
//! the scene of `[Schjoth07]` three sheets between the folds, where dX/dx = 0, and one outside.

use std::f64::consts::TAU;

use super::numerics::{bisect, roots, simpson, transmittance};

/// Steps a wavelength in which the folds are looked for; they are far apart, or meet where there is no caustic.
const FOLD_STEPS: f64 = 512.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    pub amplitude: f64,
    /// 2π over the wavelength.
    pub wave_number: f64,
    /// Index below the wave over that above.
    pub index: f64,
    /// Height of the receiver.
    pub receiver: f64,
    /// Whether light is lost by reflection.
    pub fresnel: bool,
}

impl Wave {
    fn height(&self, x: f64) -> f64 {
        self.amplitude * (self.wave_number * x).cos()
    }

    fn slope(&self, x: f64) -> f64 {
        -self.wave_number * self.amplitude * (self.wave_number * x).sin()
    }

    /// Angle of incidence, signed by the slope, and that of refraction.
    fn angles(&self, x: f64) -> (f64, f64) {
        let i = self.slope(x).atan();
        (i, (i.sin() / self.index).asin())
    }

    /// Where the light that enters at `x` lands.
    pub fn landing(&self, x: f64) -> f64 {
        x + (self.height(x) - self.receiver) * {
            let (i, t) = self.angles(x);
            (i - t).tan()
        }
    }

    /// dX/dx.
    pub fn stretch(&self, x: f64) -> f64 {
        let s = self.slope(x);
        let (i, t) = self.angles(x);
        let di = -self.wave_number * self.wave_number * self.height(x) / (1.0 + s * s);
        let dt = i.cos() * di / (self.index * t.cos());
        let lean = (i - t).tan();
        1.0 + s * lean + (self.height(x) - self.receiver) * (1.0 + lean * lean) * (di - dt)
    }

    /// Fraction of the light at `x` that passes the surface.
    fn passed(&self, x: f64) -> f64 {
        if self.fresnel { transmittance(1.0 / self.slope(x).hypot(1.0), self.index) } else { 1.0 }
    }

    /// The parts of `source` on which X(x) is monotone: the folds part them.
    pub fn branches(&self, source: [f64; 2]) -> Vec<[f64; 2]> {
        let [from, to] = source;
        if from >= to {
            return Vec::new();
        }
        let steps = ((to - from) * self.wave_number / TAU * FOLD_STEPS).ceil().max(1.0) as usize;
        let mut ends = vec![from];
        ends.extend(roots(|x| self.stretch(x), from, to, steps));
        ends.push(to);
        ends.windows(2).map(|w| [w[0], w[1]]).collect()
    }

    /// The source points of `target` within `source`, one for each sheet.
    pub fn sheets(&self, target: f64, source: [f64; 2]) -> Vec<f64> {
        let miss = |x: f64| self.landing(x) - target;
        let on = |&[a, b]: &[f64; 2]| miss(a).is_sign_positive() != miss(b).is_sign_positive();
        self.branches(source).into_iter().filter(on).map(|[a, b]| bisect(miss, a, b)).collect()
    }

    /// E/E⊥ at a point of the receiver under a beam over `source`.
    pub fn irradiance(&self, target: f64, source: [f64; 2]) -> f64 {
        self.sheets(target, source).into_iter().map(|x| self.passed(x) / self.stretch(x).abs()).sum()
    }

    /// E/E⊥ averaged over the parts of the receiver between neighbouring `borders` (ascending): the flux of the source
    /// intervals that land there, by Simpson's rule with `steps` double steps.
    pub fn averages(&self, borders: &[f64], source: [f64; 2], steps: usize) -> Vec<f64> {
        let mut means = vec![0.0; borders.len().saturating_sub(1)];
        for [lo, hi] in self.branches(source) {
            let sources: Vec<f64> = borders.iter().map(|&border| self.inverse(border, lo, hi)).collect();
            for (i, mean) in means.iter_mut().enumerate() {
                let (p, q) = (sources[i].min(sources[i + 1]), sources[i].max(sources[i + 1]));
                if p < q {
                    *mean += simpson(|x| self.passed(x), p, q, steps) / (borders[i + 1] - borders[i]);
                }
            }
        }
        means
    }

    /// Where on the branch [lo, hi] the light for `target` starts, or the branch's end nearest to it.
    fn inverse(&self, target: f64, lo: f64, hi: f64) -> f64 {
        let miss = |x: f64| self.landing(x) - target;
        match (miss(lo) < 0.0, miss(hi) < 0.0) {
            (true, false) | (false, true) => bisect(miss, lo, hi),
            (below, _) if below == (self.landing(lo) < self.landing(hi)) => hi,
            _ => lo,
        }
    }
}
