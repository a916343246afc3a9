//! Student's distribution, as far as 95 % intervals need it.

/// 97.5 % quantiles for 1, 2, … degrees of freedom.
const TABLE: [f64; 12] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179];

/// The normal distribution's.
const NORMAL: f64 = 1.959_964;

/// The 97.5 % quantile for `dof` ≥ 1 degrees of freedom: half the width of a 95 % interval in standard errors. Beyond the
/// table by the first two terms of its expansion in 1/dof, within 0.003.
pub fn quantile(dof: usize) -> f64 {
    let z = NORMAL;
    TABLE.get(dof.max(1) - 1).copied().unwrap_or_else(|| {
        let n = dof as f64;
        z + (z.powi(3) + z) / (4.0 * n) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
    })
}
