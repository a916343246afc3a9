//! How wide footprints are made: the scale s, which plays the part of √k, or a radius.

use super::kernel;
use crate::math::Bounds3;
use crate::scene::settings::{Bandwidth, EmissionPattern, KernelShape, Radius};

/// The factor on every footprint's semi-axes.
///
/// A footprint of scale s overlaps s² others on average. What is left of the noise falls like s⁻¹ for random emission,
/// s⁻¹·⁹ for jittered and faster for lattices (PHOTON_DIFFERENTIALS 4.4, 9.2), so the more even the emission the
/// narrower the footprints may be. `Auto` fixes how far the kernel smooths, not its support: a flat irradiance is then
/// left with a ripple of about 2 % (lattice, triweight), 8 % (jittered) or 19 % (random).
pub fn scale(bandwidth: Bandwidth, emission: EmissionPattern, kernel: KernelShape) -> f64 {
    let epanechnikov = match (bandwidth, emission) {
        (Bandwidth::Scale(s), _) => return s,
        (Bandwidth::Auto, EmissionPattern::Random) => 6.0,
        (Bandwidth::Auto, EmissionPattern::Jittered) => 4.0,
        (Bandwidth::Auto, EmissionPattern::Lattice) => 2.0,
    };
    epanechnikov * (kernel::variance(KernelShape::Epanechnikov) / kernel::variance(kernel)).sqrt()
}

/// How many times the cell of a photon whose direction was drawn at random has to be as large as one of this pattern, since
/// its footprint is made wider by the pattern's scale.
pub fn random_overlap(emission: EmissionPattern) -> f64 {
    let scale = |emission| scale(Bandwidth::Auto, emission, KernelShape::Epanechnikov);
    (scale(EmissionPattern::Random) / scale(emission)).powi(2)
}

/// How much narrower than those of pass 0 all footprints of pass `pass` are: i^(−γ), i counted from 1.
///
/// The mean of the passes has a bias like the mean of their s², i^(−2γ), and noise like i^(−1/2) s^(−p), where p says
/// how fast a wider footprint takes noise away: 1 for random emission, 1.9 for jittered, 2.6 for lattices, measured
/// (PHOTON_DIFFERENTIALS 4.4). Both fall alike with γ = 1/(2(2 + p)), for random emission the 1/6 of progressive photon
/// mapping's α = 2/3.
pub fn narrowing(emission: EmissionPattern, pass: u32) -> f64 {
    let p = match emission {
        EmissionPattern::Random => 1.0,
        EmissionPattern::Jittered => 1.9,
        EmissionPattern::Lattice => 2.6,
    };
    f64::from(pass + 1).powf(-0.5 / (2.0 + p))
}

/// The same factor for photons that are beams which rays cross, n of them with `overlap` cells over each other: √(o/n) s².
///
/// A footprint of scale s lies over one of s² o photons, and a beam of that scale over a ray that crosses s √(o n) of them: the
/// blur goes along one line, on which the share of each is 1/n of the whole, and not 1/√n. With this factor a ray is left as
/// many of them as a point has of footprints. It is none above the footprints' own.
pub fn beam_scale(scale: f64, overlap: f64, beams: u64) -> f64 {
    scale * (scale * (overlap / beams.max(1) as f64).sqrt()).min(1.0)
}

/// How much narrower than those of pass 0 all beams of pass `pass` are: i^(−γ), as [`narrowing`] with p = 1/2: how beams lie on
/// a line is next to random, whatever pattern they set out in: the variance falls like s^(−0.8), measured (`src/doc/media.md`).
pub fn beam_narrowing(pass: u32) -> f64 {
    f64::from(pass + 1).powf(-0.5 / (2.0 + 0.5))
}

/// Neighbours that pass `pass` asks for when the first asks for `k`: their disc's area is narrowed like a footprint's.
/// Two at least, since a radius needs them.
pub fn neighbours(k: u32, emission: EmissionPattern, pass: u32) -> usize {
    let narrowed = f64::from(k) * narrowing(emission, pass).powi(2);
    (narrowed.round() as usize).max(2)
}

/// The share of variance and bias in the progressive radius: with 2/3 both parts of the mean square error fall alike,
/// like i^(-2/3) (PHOTON_DIFFERENTIALS 4.3).
const ALPHA: f64 = 2.0 / 3.0;

/// The automatic first radius of `sppm` in radii of the scene's bounding sphere.
const AUTO_RADIUS: f64 = 0.003;

/// The radius of `sppm` in pass `pass`, counted from 0: r²ᵢ₊₁/r²ᵢ = (i + α)/(i + 1), i counted from 1 `[Knaus11 (15)]`,
/// a pure function of the pass with no statistics kept `[Hachisuka09]`.
pub fn progressive_radius(first: Radius, scene: &Bounds3, pass: u32) -> f64 {
    let first = match first {
        Radius::Metres(radius) => radius,
        Radius::Auto => AUTO_RADIUS * scene.bounding_sphere().1,
    };
    let square: f64 = (1..=pass).map(|i| (f64::from(i) + ALPHA) / f64::from(i + 1)).product();
    first * square.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PHOTON_DIFFERENTIALS 4.4: s_i = s₁ i^((α − 1)/2), α = 2/3.
    #[test]
    fn random_photons_narrow_as_published() {
        for i in [1u32, 2, 10, 1000] {
            let published = f64::from(i).powf((ALPHA - 1.0) / 2.0);
            assert!((narrowing(EmissionPattern::Random, i - 1) - published).abs() < 1e-15);
        }
        assert_eq!(neighbours(70, EmissionPattern::Lattice, 0), 70);
        assert_eq!(neighbours(80, EmissionPattern::Random, 7), 40);
        assert_eq!(neighbours(2, EmissionPattern::Random, 999), 2);
    }

    /// With s as wide as all n beams together none is left out; a point's and a ray's number of photons are the same.
    #[test]
    fn as_many_beams_lie_over_a_ray_as_footprints_over_a_point() {
        for (s, overlap, n) in [(2.0, 1.0, 10_000), (2.6, 32.0, 5_000), (6.0, 1.0, 1_000)] {
            let beam = beam_scale(s, overlap, n);
            // Of a line of length one, cells of the width √(o/n).
            let over_a_ray = n as f64 * beam * (overlap / n as f64).sqrt();
            assert!((over_a_ray - s * s * overlap).abs() < 1e-9, "{over_a_ray}");
        }
        assert_eq!(beam_scale(2.0, 32.0, 4), 2.0);
        assert!((beam_narrowing(31) - 0.5).abs() < 1e-15);
    }

    /// r²₁₀₀₀/r²₁ = .11076 (PHOTON_DIFFERENTIALS 4.3).
    #[test]
    fn the_radius_shrinks_as_published() {
        let radius = |pass| progressive_radius(Radius::Metres(2.0), &Bounds3::EMPTY, pass);
        assert_eq!(radius(0), 2.0);
        assert!(((radius(1) / 2.0).powi(2) - (1.0 + ALPHA) / 2.0).abs() < 1e-15);
        assert!(((radius(999) / 2.0).powi(2) - 0.11076).abs() < 5e-6, "{}", (radius(999) / 2.0).powi(2));
    }
}
