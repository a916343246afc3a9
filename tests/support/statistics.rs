//! Hypothesis tests: samples in, p-values out.

use super::special::{beta_i, gamma_q};

/// The chance that a whole test fails although nothing is wrong. With fixed seeds a test that passes stays so.
pub const LEVEL: f64 = 1e-3;

/// The level of one of `n` independent hypotheses so that all of them together keep [`LEVEL`] (Šidák).
pub fn sidak(n: usize) -> f64 {
    -(f64::ln_1p(-LEVEL) / n as f64).exp_m1()
}

/// Count, mean and variance of a sample, gathered one by one (Welford).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    pub n: u64,
    pub mean: f64,
    /// Sum of squared deviations from the mean.
    m2: f64,
}

impl Moments {
    pub fn push(&mut self, x: f64) {
        self.n += 1;
        let delta = x - self.mean;
        self.mean += delta / self.n as f64;
        self.m2 += delta * (x - self.mean);
    }
    /// Unbiased variance of one sample.
    pub fn variance(&self) -> f64 {
        if self.n < 2 { f64::NAN } else { self.m2 / (self.n - 1) as f64 }
    }
    /// Standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.n as f64).sqrt()
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(samples: I) -> Moments {
        let mut m = Moments::default();
        samples.into_iter().for_each(|x| m.push(x));
        m
    }
}

impl std::fmt::Display for Moments {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.6e} ± {:.2e} (n = {})", self.mean, self.standard_error(), self.n)
    }
}

/// P(|Z| ≥ |z|) of the standard normal distribution.
pub fn normal_two_sided(z: f64) -> f64 {
    if z.is_nan() { 0.0 } else { gamma_q(0.5, (0.5 * z * z).min(700.0)) }
}

/// P(|T| ≥ |t|) of Student's distribution with `dof` degrees of freedom.
pub fn student_two_sided(t: f64, dof: f64) -> f64 {
    if t.is_nan() { 0.0 } else { beta_i(0.5 * dof, 0.5, dof / (dof + t * t)) }
}

/// P(X ≥ chi2) of the chi² distribution.
pub fn chi2_upper(chi2: f64, dof: usize) -> f64 {
    gamma_q(0.5 * dof as f64, 0.5 * chi2)
}

/// p-value of "the sample's mean is `expected`" (one-sample t-test). A sample without spread has p = 1 where its mean
/// is within rounding of the expected value and p = 0 elsewhere.
pub fn t_test(sample: &Moments, expected: f64) -> f64 {
    let error = sample.standard_error();
    if error == 0.0 {
        return constant_agrees(sample.mean, expected);
    }
    student_two_sided((sample.mean - expected) / error, (sample.n - 1) as f64)
}

/// p-value of "both samples have the same mean" (Welch's t-test).
pub fn welch(a: &Moments, b: &Moments) -> f64 {
    let (va, vb) = (a.standard_error().powi(2), b.standard_error().powi(2));
    let v = va + vb;
    if v == 0.0 {
        return constant_agrees(a.mean, b.mean);
    }
    let dof = v * v / (va * va / (a.n - 1) as f64 + vb * vb / (b.n - 1) as f64);
    student_two_sided((a.mean - b.mean) / v.sqrt(), dof)
}

/// p-value of "`mean` was drawn about `expected` with this standard error" (z-test, error known).
pub fn z_test(mean: f64, expected: f64, standard_error: f64) -> f64 {
    if standard_error == 0.0 {
        return constant_agrees(mean, expected);
    }
    normal_two_sided((mean - expected) / standard_error)
}

fn constant_agrees(a: f64, b: f64) -> f64 {
    if (a - b).abs() <= 8.0 * f64::EPSILON * a.abs().max(b.abs()) { 1.0 } else { 0.0 }
}

/// Fewest expected counts in a cell of a chi² test; smaller cells are pooled.
const MIN_EXPECTED: f64 = 5.0;

/// Pearson's chi² test of counts against expected counts: p-value. Cells that expect less than five are pooled; a
/// count where nothing is expected gives p = 0. `expected` must add up to the number of draws.
pub fn chi2_test(observed: &[u64], expected: &[f64]) -> f64 {
    assert_eq!(observed.len(), expected.len());
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&i, &j| expected[i].total_cmp(&expected[j]));
    let (mut chi2, mut cells) = (0.0, 0usize);
    let (mut pooled_observed, mut pooled_expected) = (0u64, 0.0);
    for i in order {
        if expected[i] <= 0.0 {
            if observed[i] > 0 {
                return 0.0;
            }
            continue;
        }
        pooled_observed += observed[i];
        pooled_expected += expected[i];
        if pooled_expected >= MIN_EXPECTED {
            chi2 += (pooled_observed as f64 - pooled_expected).powi(2) / pooled_expected;
            cells += 1;
            (pooled_observed, pooled_expected) = (0, 0.0);
        }
    }
    assert!(cells > 1, "a chi² test needs two cells that expect {MIN_EXPECTED} or more");
    chi2_upper(chi2, cells - 1)
}

/// Fails when p is below the level of one of `n` hypotheses; `what` names the quantity and the seed.
#[track_caller]
pub fn assert_plausible(p: f64, n: usize, what: impl std::fmt::Display) {
    let level = sidak(n);
    assert!(p >= level, "{what}: p = {p:.3e} is below {level:.3e}");
}
