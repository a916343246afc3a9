//! Reflectance of smooth interfaces, unpolarised · dimensionless · cosines against the normal, on the side of arrival ·
//! [BornWolf99 1.5, 14.2], `[Duntley42]`.

/// What happens to light that arrives at a dielectric interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Fraction of the flux that is reflected; 1 beyond the critical angle.
    pub reflectance: f64,
    /// 1 − reflectance, without its cancellation at grazing.
    pub transmittance: f64,
    /// Cosine of the refracted direction against the normal of the far side, `None` at total internal reflection.
    pub cos_t: Option<f64>,
}

/// Snell's law and the mean of the two polarisations' Fresnel reflectances [BornWolf99 1.5]. `cos_i` in [0, 1] is the
/// arriving direction's cosine, `eta` = n_i/n_t. The decision for total reflection is the one that
/// `differential::refract` takes, bit for bit.
pub fn dielectric(cos_i: f64, eta: f64) -> Interface {
    let k = 1.0 - eta * eta * (1.0 - cos_i * cos_i);
    if k <= 0.0 {
        return Interface { reflectance: 1.0, transmittance: 0.0, cos_t: None };
    }
    let cos_t = k.sqrt();
    let r_s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let r_p = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let reflectance = 0.5 * (r_s * r_s + r_p * r_p);
    Interface { reflectance, transmittance: dielectric_transmittance(cos_i, cos_t, eta), cos_t: Some(cos_t) }
}

/// The part of the flux that goes through an interface between directions that are known to belong together, `eta` =
/// n_i/n_t. Near the critical angle it keeps digits that Snell's law loses in `cos_t`.
pub fn dielectric_transmittance(cos_i: f64, cos_t: f64, eta: f64) -> f64 {
    let sum_s = eta * cos_i + cos_t;
    let sum_p = cos_i + eta * cos_t;
    2.0 * eta * cos_i * cos_t * (1.0 / (sum_s * sum_s) + 1.0 / (sum_p * sum_p))
}

/// Reflectance of a metal of complex index `eta` + i `k` seen from a medium of index 1 [BornWolf99 14.2].
pub fn conductor(cos_i: f64, eta: f64, k: f64) -> f64 {
    let cos2 = cos_i * cos_i;
    let sin2 = 1.0 - cos2;
    // With N = eta + ik and N² − sin² = (a + ib)².
    let real = eta * eta - k * k - sin2;
    let modulus = (real * real + 4.0 * eta * eta * k * k).sqrt();
    let two_a_cos = 2.0 * cos_i * (0.5 * (modulus + real)).max(0.0).sqrt();
    let perpendicular = (modulus + cos2 - two_a_cos) / (modulus + cos2 + two_a_cos);
    // rₚ = rₛ · (a + ib − sin²/cos) / (a + ib + sin²/cos), both multiplied out with cos so that grazing stays finite.
    let base = cos2 * modulus + sin2 * sin2;
    let parallel = perpendicular * (base - two_a_cos * sin2) / (base + two_a_cos * sin2);
    0.5 * (perpendicular + parallel)
}

/// 2∫F(c) c dc: the part of perfectly diffuse light that a dielectric interface reflects, the far side being
/// `n` = n_t/n_i times as dense `[Duntley42]`. For n < 1 by the reciprocity 1 − F̄(n) = n² (1 − F̄(1/n)).
pub fn dielectric_diffuse(n: f64) -> f64 {
    if n < 1.0 {
        return 1.0 - n * n * (1.0 - dielectric_diffuse(1.0 / n));
    }
    let n2 = n * n;
    if n - 1.0 < 5e-5 {
        // The closed form cancels here, with an error of 2.5e-17/(n − 1)². To first order in ε = n² − 1,
        // F = ((√(c² + ε) − c)/(√(c² + ε) + c))², whose integral is ε/6 with an error of about ε². Where they change
        // places both are near 1e-8.
        return (n2 - 1.0) / 6.0;
    }
    let n4 = n2 * n2;
    let sum = n2 + 1.0;
    let difference = n4 - 1.0;
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
        + n2 * (n2 - 1.0) * (n2 - 1.0) / (sum * sum * sum) * ((n - 1.0) / (n + 1.0)).ln()
        - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / (sum * difference)
        + 8.0 * n4 * (n4 + 1.0) / (sum * difference * difference) * n.ln()
}

/// ((n − 1)/(n + 1))².
pub fn normal_reflectance(n: f64) -> f64 {
    let r = (n - 1.0) / (n + 1.0);
    r * r
}

#[cfg(test)]
mod tests {
    use super::*;

    const INDICES: [f64; 5] = [1.000_3, 1.33, 1.5, 1.8, 2.4];

    #[test]
    fn normal_incidence_is_the_squared_ratio() {
        for n in INDICES {
            let expected = ((n - 1.0) / (n + 1.0)).powi(2);
            assert!((dielectric(1.0, 1.0 / n).reflectance - expected).abs() < 1e-15, "{n}");
            assert!((dielectric(1.0, n).reflectance - expected).abs() < 1e-15, "{n}");
        }
    }

    #[test]
    fn at_brewster_angle_half_of_the_other_polarisation_is_left() {
        for n in INDICES {
            // tan θ_B = n; there rₛ = (1 − n²)/(1 + n²) and rₚ = 0.
            let cos = 1.0 / (1.0 + n * n).sqrt();
            let expected = 0.5 * ((1.0 - n * n) / (1.0 + n * n)).powi(2);
            assert!((dielectric(cos, 1.0 / n).reflectance - expected).abs() < 1e-15, "{n}");
        }
    }

    #[test]
    fn both_sides_of_a_refracted_ray_reflect_the_same() {
        for n in INDICES {
            for i in 1..50 {
                let cos_i = f64::from(i) / 50.0;
                let outside = dielectric(cos_i, 1.0 / n);
                let inside = dielectric(outside.cos_t.expect("into the denser side"), n);
                assert!((outside.reflectance - inside.reflectance).abs() < 1e-12, "n {n} cos {cos_i}");
                assert!((inside.cos_t.expect("not total") - cos_i).abs() < 1e-12);
                assert!((outside.reflectance + outside.transmittance - 1.0).abs() < 1e-15, "n {n} cos {cos_i}");
            }
        }
    }

    #[test]
    fn total_reflection_starts_at_the_critical_angle() {
        let n = 1.5f64;
        let critical = (1.0 - 1.0 / (n * n)).sqrt();
        assert_eq!(dielectric(critical - 1e-9, n), Interface { reflectance: 1.0, transmittance: 0.0, cos_t: None });
        let beside = dielectric(critical + 1e-9, n);
        // R ≈ 1 − O(√δ): the reflectance meets 1 with a vertical tangent.
        assert!(beside.cos_t.is_some() && beside.reflectance < 1.0 && beside.reflectance > 0.99);
        assert!((dielectric(0.0, 1.0 / n).reflectance - 1.0).abs() < 1e-15, "grazing");
    }

    #[test]
    fn a_metal_at_normal_incidence() {
        for (eta, k) in [(0.143, 3.983), (1.375, 7.617), (0.2, 0.0), (2.5, 0.1)] {
            let expected = ((eta - 1.0f64).powi(2) + k * k) / ((eta + 1.0f64).powi(2) + k * k);
            assert!((conductor(1.0, eta, k) - expected).abs() < 1e-15, "{eta} + i{k}");
            assert!((conductor(0.0, eta, k) - 1.0).abs() < 1e-15, "grazing");
        }
    }

    /// The textbook's complex amplitudes, multiplied out with pairs (re, im).
    fn conductor_by_amplitudes(cos: f64, eta: f64, k: f64) -> f64 {
        type Complex = (f64, f64);
        let mul = |a: Complex, b: Complex| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let norm2 = |a: Complex| a.0 * a.0 + a.1 * a.1;
        let n2 = mul((eta, k), (eta, k));
        // N cos θ_t = √(N² − sin²)
        let under: Complex = (n2.0 - (1.0 - cos * cos), n2.1);
        let (r, phase) = (norm2(under).sqrt().sqrt(), 0.5 * under.1.atan2(under.0));
        let n_cos_t: Complex = (r * phase.cos(), r * phase.sin());
        let s = norm2((cos - n_cos_t.0, -n_cos_t.1)) / norm2((cos + n_cos_t.0, n_cos_t.1));
        let p = norm2((n2.0 * cos - n_cos_t.0, n2.1 * cos - n_cos_t.1))
            / norm2((n2.0 * cos + n_cos_t.0, n2.1 * cos + n_cos_t.1));
        0.5 * (s + p)
    }

    #[test]
    fn a_metal_at_every_angle_is_its_complex_amplitudes() {
        for (eta, k) in [(0.143, 3.983), (0.05, 1.5), (1.375, 7.617), (3.0, 3.0)] {
            for i in 1..=40 {
                let cos = f64::from(i) / 40.0;
                let expected = conductor_by_amplitudes(cos, eta, k);
                assert!((conductor(cos, eta, k) - expected).abs() < 1e-13, "{eta} + i{k} at {cos}");
            }
        }
    }

    #[test]
    fn a_metal_without_absorption_is_a_dielectric() {
        for n in [0.5, 1.33, 2.0] {
            for i in 1..=40 {
                let cos = f64::from(i) / 40.0;
                let expected = dielectric(cos, 1.0 / n).reflectance;
                assert!((conductor(cos, n, 0.0) - expected).abs() < 1e-12, "{n} at {cos}");
            }
        }
    }

    #[test]
    fn the_diffuse_mean_is_the_integral() {
        for n in [1.000_049, 1.000_051, 1.001, 1.33, 1.5, 2.4, 1.0 / 1.000_049, 1.0 / 1.5, 1.0 / 2.4] {
            // c = s⁴ smooths the root at grazing; below the critical cosine F = 1 and the rest starts there.
            let critical = if n < 1.0 { (1.0f64 - n * n).sqrt() } else { 0.0 };
            let cells = 20_000;
            let sum: f64 = (0..cells)
                .map(|i| {
                    let s = (f64::from(i) + 0.5) / f64::from(cells);
                    let cos = critical + (1.0 - critical) * s.powi(4);
                    let dcos = (1.0 - critical) * 4.0 * s.powi(3) / f64::from(cells);
                    2.0 * dielectric(cos, 1.0 / n).reflectance * cos * dcos
                })
                .sum();
            let expected = critical * critical + sum;
            // The midpoint rule's error is O(cells⁻²) = 3e-9, the function's own is at most 1e-8 beside n = 1.
            let bound = 2e-8;
            let got = dielectric_diffuse(n);
            assert!((got - expected).abs() < bound, "n {n}: {got} against {expected}");
        }
        assert_eq!(dielectric_diffuse(1.0), 0.0);
    }
}
