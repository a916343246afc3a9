//! Kernels over the unit disc · argument t = r² · ∫_{|y|<1} K(|y|²) dy = 1 · PHOTON_DIFFERENTIALS 3.1.

use std::f64::consts::PI;

use crate::scene::settings::KernelShape;

/// Standard deviation of the Gaussian, in disc radii; the kernel is cut at 1 and normalised there.
const GAUSSIAN_WIDTH: f64 = 1.0 / 3.0;

/// K(t), 0 for t ≥ 1.
pub fn evaluate(kernel: KernelShape, t: f64) -> f64 {
    if t >= 1.0 {
        return 0.0;
    }
    let rest = 1.0 - t;
    match kernel {
        KernelShape::Uniform => 1.0 / PI,
        KernelShape::Cone => 3.0 / PI * (1.0 - t.sqrt()),
        KernelShape::Epanechnikov => 2.0 / PI * rest,
        KernelShape::Biweight => 3.0 / PI * rest * rest,
        KernelShape::Triweight => 4.0 / PI * rest * rest * rest,
        KernelShape::Gaussian => {
            let inverse_variance = 1.0 / (GAUSSIAN_WIDTH * GAUSSIAN_WIDTH);
            let mass = 1.0 - (-0.5 * inverse_variance).exp();
            (-0.5 * t * inverse_variance).exp() * inverse_variance / (2.0 * PI * mass)
        }
    }
}

/// The kernel of the same shape over the line: k₁(t) of t = u², ∫_{−1}^{1} k₁ du = 1; 0 for t ≥ 1.
pub fn evaluate_line(kernel: KernelShape, t: f64) -> f64 {
    evaluate(kernel, t) / (2.0 * line_integral(kernel))
}

/// The kernel of the same shape over the ball: K₃(t) of t = r², ∫_{|y|<1} K₃(|y|²) d³y = 1; 0 for t ≥ 1.
pub fn evaluate_ball(kernel: KernelShape, t: f64) -> f64 {
    evaluate(kernel, t) / ball_integral(kernel)
}

/// [`evaluate`] of eight numbers ≥ 0 in single precision.
#[inline(always)]
pub fn evaluate_eight(kernel: KernelShape, t: &[f32; 8]) -> [f32; 8] {
    const PER_PI: f32 = std::f32::consts::FRAC_1_PI;
    let rest = t.map(|t| if t < 1.0 { 1.0 - t } else { 0.0 });
    match kernel {
        KernelShape::Epanechnikov => rest.map(|r| 2.0 * PER_PI * r),
        KernelShape::Biweight => rest.map(|r| 3.0 * PER_PI * (r * r)),
        KernelShape::Triweight => rest.map(|r| 4.0 * PER_PI * (r * r * r)),
        KernelShape::Uniform | KernelShape::Cone | KernelShape::Gaussian => {
            t.map(|t| evaluate(kernel, t.into()) as f32)
        }
    }
}

/// Variance per axis of the kernel's unit disc: how far it smooths. Equal smoothing by two kernels asks for scales in
/// the inverse ratio of the square roots.
pub fn variance(kernel: KernelShape) -> f64 {
    match kernel {
        KernelShape::Uniform => 1.0 / 4.0,
        KernelShape::Cone => 3.0 / 20.0,
        KernelShape::Epanechnikov => 1.0 / 6.0,
        KernelShape::Biweight => 1.0 / 8.0,
        KernelShape::Triweight => 1.0 / 10.0,
        KernelShape::Gaussian => {
            // σ² (1 − c e^{−c}/(1 − e^{−c})), c = 1/2σ²: the cut takes the tail's share away.
            let c = 0.5 / (GAUSSIAN_WIDTH * GAUSSIAN_WIDTH);
            GAUSSIAN_WIDTH * GAUSSIAN_WIDTH * (1.0 - c * (-c).exp() / (1.0 - (-c).exp()))
        }
    }
}

/// ∫₀¹ K(r²) dr: what a segment of unit length adds to the kernel's integral when it is swept along it, for each unit of its
/// width across. π times it is the c of the swept area A₀ + c l |D| (PHOTON_DIFFERENTIALS 7).
pub fn line_integral(kernel: KernelShape) -> f64 {
    match kernel {
        KernelShape::Uniform => 1.0 / PI,
        KernelShape::Cone => 3.0 / (2.0 * PI),
        KernelShape::Epanechnikov => 4.0 / (3.0 * PI),
        KernelShape::Biweight => 8.0 / (5.0 * PI),
        KernelShape::Triweight => 64.0 / (35.0 * PI),
        KernelShape::Gaussian => {
            // erf(1/(√2 σ)) of σ = 1/3.
            const ERF: f64 = 0.997_300_203_936_740;
            let mass = 1.0 - (-0.5 / (GAUSSIAN_WIDTH * GAUSSIAN_WIDTH)).exp();
            (0.5 * PI).sqrt() * ERF / (2.0 * PI * GAUSSIAN_WIDTH * mass)
        }
    }
}

/// ∫₀¹ K(r²) 4π r² dr.
fn ball_integral(kernel: KernelShape) -> f64 {
    match kernel {
        KernelShape::Uniform => 4.0 / 3.0,
        KernelShape::Cone => 1.0,
        KernelShape::Epanechnikov => 16.0 / 15.0,
        KernelShape::Biweight => 32.0 / 35.0,
        KernelShape::Triweight => 256.0 / 315.0,
        KernelShape::Gaussian => {
            // 2/m (I − e^{−1/2σ²}), I = ∫₀¹ e^{−r²/2σ²} dr, which is 2π σ² m times the line's integral.
            let variance = GAUSSIAN_WIDTH * GAUSSIAN_WIDTH;
            let edge = (-0.5 / variance).exp();
            let mass = 1.0 - edge;
            let line = line_integral(kernel) * 2.0 * PI * variance * mass;
            2.0 / mass * (line - edge)
        }
    }
}

/// Whether the kernel vanishes at the edge of its support; a k-nearest estimate with one that does not must leave out
/// the k-th photon itself.
pub fn vanishes_at_edge(kernel: KernelShape) -> bool {
    !matches!(kernel, KernelShape::Uniform | KernelShape::Gaussian)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [KernelShape; 6] = [
        KernelShape::Uniform,
        KernelShape::Cone,
        KernelShape::Epanechnikov,
        KernelShape::Biweight,
        KernelShape::Triweight,
        KernelShape::Gaussian,
    ];

    /// ∫ K(r²) g(r) 2πr dr by the midpoint rule.
    fn radial_integral(kernel: KernelShape, g: impl Fn(f64) -> f64) -> f64 {
        let n = 200_000;
        (0..n)
            .map(|i| {
                let r = (f64::from(i) + 0.5) / f64::from(n);
                evaluate(kernel, r * r) * g(r) * 2.0 * PI * r / f64::from(n)
            })
            .sum()
    }

    #[test]
    fn every_kernel_integrates_to_one() {
        for kernel in ALL {
            assert!((radial_integral(kernel, |_| 1.0) - 1.0).abs() < 1e-9, "{}", kernel.name());
        }
    }

    #[test]
    fn every_line_kernel_integrates_to_one() {
        let n = 200_000;
        for kernel in ALL {
            let u = |i: i32| 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
            let sum: f64 = (0..n).map(|i| evaluate_line(kernel, u(i) * u(i)) * 2.0 / f64::from(n)).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{}: {sum}", kernel.name());
            assert_eq!(evaluate_line(kernel, 1.0), 0.0);
        }
    }

    #[test]
    fn every_ball_kernel_integrates_to_one() {
        for kernel in ALL {
            // 4π r² dr is 2 r times 2π r dr.
            let sum = radial_integral(kernel, |r| 2.0 * r) / ball_integral(kernel);
            assert!((sum - 1.0).abs() < 1e-9, "{}: {sum}", kernel.name());
            assert_eq!(evaluate_ball(kernel, 1.0), 0.0);
        }
    }

    #[test]
    fn heights_and_second_moments_are_those_of_the_table() {
        let heights = [1.0, 3.0, 2.0, 3.0, 4.0, 4.5506];
        for (kernel, height) in ALL.into_iter().zip(heights) {
            assert!((PI * evaluate(kernel, 0.0) - height).abs() < 1e-4, "{}", kernel.name());
            // Per axis: half of the mean of r².
            let moment = 0.5 * radial_integral(kernel, |r| r * r);
            assert!((moment - variance(kernel)).abs() < 1e-9, "{}", kernel.name());
            let line = radial_integral(kernel, |r| 0.5 / (PI * r));
            assert!((line - line_integral(kernel)).abs() < 1e-9, "{}", kernel.name());
        }
    }

    #[test]
    fn eight_at_once_are_the_same_but_for_rounding() {
        for kernel in ALL {
            for k in 0..200 {
                let t: [f32; 8] = std::array::from_fn(|i| (8 * k + i) as f32 / 1500.0);
                for (t, weight) in t.into_iter().zip(evaluate_eight(kernel, &t)) {
                    assert!((f64::from(weight) - evaluate(kernel, t.into())).abs() < 3e-7, "{} {t}", kernel.name());
                }
            }
        }
    }

    #[test]
    fn nothing_lies_beyond_the_edge() {
        for kernel in ALL {
            assert_eq!(evaluate(kernel, 1.0), 0.0);
            assert_eq!(evaluate(kernel, 1e9), 0.0);
        }
    }
}
