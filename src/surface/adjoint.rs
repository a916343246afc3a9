//! Corrections for particles where the shading normal is not the geometric one [Veach97 5.3].

use crate::math::{Dir3, Normal3};

/// The factor on a particle's weight at a non-delta event: |wo·ns||wi·ng| / (|wo·ng||wi·ns|), `wo` towards where the
/// particle came from and `wi` where it goes. Zero where a cosine in the denominator vanishes.
pub fn shading_normal_factor(wo: Dir3, wi: Dir3, ns: Normal3, ng: Normal3) -> f64 {
    let denominator = (wo.dot(ng) * wi.dot(ns)).abs();
    if denominator > 0.0 { (wo.dot(ns) * wi.dot(ng)).abs() / denominator } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::sampling::{Purpose, Stream};

    /// Light from a seen along b: the eye weighs radiance with |a·ns|, per |a·ng| of the light's projected solid angle.
    /// A particle from a that leaves along b with |b·ns| and the factor, per |b·ng|, must weigh the same.
    #[test]
    fn particles_and_the_eye_weigh_a_path_alike() {
        let ng = Normal3::Z;
        let ns = Normal3::new(Vec3::new(0.4, -0.3, 1.0)).expect("not zero");
        assert_eq!(shading_normal_factor(Dir3::X, Dir3::Z, ns, ng), 0.0, "grazing");
        let seed = 12;
        let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
        let mut direction = || Dir3::new(Vec3::from_array([0; 3].map(|_: i32| stream.uniform() - 0.5)));
        for _ in 0..200 {
            let (Some(a), Some(b)) = (direction(), direction()) else { continue };
            let eye = a.dot(ns).abs() / a.dot(ng).abs();
            let particle = b.dot(ns).abs() * shading_normal_factor(a, b, ns, ng) / b.dot(ng).abs();
            assert!((particle / eye - 1.0).abs() < 1e-12, "seed {seed} {a:?} {b:?}");
            let flat = shading_normal_factor(a, b, ng, ng);
            assert!((flat - 1.0).abs() < 1e-12, "seed {seed} {a:?} {b:?}: one normal, no correction");
        }
    }
}
