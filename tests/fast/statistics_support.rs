//! The measuring tools are measured: p-values against tables, tests that must accept and tests that must reject.

use crate::support::special::{beta_i, gamma_q, ln_gamma};
use crate::support::statistics::{
    Moments, chi2_test, chi2_upper, normal_two_sided, student_two_sided, t_test, welch, z_test,
};

fn close(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b}");
}

#[test]
fn special_functions_at_points_with_closed_forms() {
    close(ln_gamma(0.5), 0.5 * std::f64::consts::PI.ln(), 1e-13);
    close(ln_gamma(10.0), 362_880f64.ln(), 1e-13);
    for x in [0.1f64, 1.0, 5.0, 30.0] {
        close(gamma_q(1.0, x), (-x).exp(), 1e-12);
        // Γ(3, x)/2 = e⁻ˣ (1 + x + x²/2)
        close(gamma_q(3.0, x), (-x).exp() * (1.0 + x + 0.5 * x * x), 1e-12);
    }
    for x in [0.05f64, 0.4, 0.6, 0.95] {
        close(beta_i(1.0, 3.0, x), 1.0 - (1.0 - x).powi(3), 1e-12);
        close(beta_i(2.0, 2.0, x), x * x * (3.0 - 2.0 * x), 1e-12);
    }
}

/// Quantiles as printed in every table: z = 1.959964, t₅ = 2.570582, χ²₁₀ = 18.307038 at 5 %.
#[test]
fn tails_at_tabulated_quantiles() {
    close(normal_two_sided(1.959_963_984_540_054), 0.05, 1e-12);
    close(normal_two_sided(-6.0), 1.973_175_290_075_396e-9, 1e-9);
    close(student_two_sided(2.570_581_835_636_314, 5.0), 0.05, 1e-11);
    // One degree of freedom is Cauchy's distribution: P(|T| ≥ 1) = 1/2.
    close(student_two_sided(1.0, 1.0), 0.5, 1e-12);
    close(chi2_upper(18.307_038_053_275_146, 10), 0.05, 1e-11);
}

#[test]
fn moments_are_those_of_the_sample() {
    let m: Moments = [1e9 + 4.0, 1e9 + 7.0, 1e9 + 13.0, 1e9 + 16.0].into_iter().collect();
    assert_eq!(m.mean, 1e9 + 10.0);
    close(m.variance(), 30.0, 1e-12);
    close(m.standard_error(), 7.5f64.sqrt(), 1e-12);
}

/// Sleep data of Student's paper of 1908: t = −1.8608, Welch dof 17.776, p = 0.0794; one sample against 0: p = 0.2176.
#[test]
fn t_tests_on_students_own_data() {
    let a: Moments = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0].into_iter().collect();
    let b: Moments = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4].into_iter().collect();
    close(welch(&a, &b), 0.079_394_14, 1e-6);
    close(t_test(&a, 0.0), 0.217_597_7, 1e-6);
    assert!(z_test(1.0, 1.1, 0.01) < 1e-20 && z_test(1.0, 1.0, 0.01) == 1.0);
}

#[test]
fn chi2_accepts_what_is_expected_and_rejects_what_is_not() {
    // Mendel's peas: 315, 108, 101, 32 of 556 at 9:3:3:1, χ² = 0.470, p = 0.925.
    let expected = [9.0, 3.0, 3.0, 1.0].map(|r| r * 556.0 / 16.0);
    close(chi2_test(&[315, 108, 101, 32], &expected), 0.925_4, 1e-3);
    assert!(chi2_test(&[300, 130, 70, 56], &expected) < 1e-4);
    assert_eq!(chi2_test(&[10, 10, 1], &[10.5, 10.5, 0.0]), 0.0, "a count where none can be");
}
