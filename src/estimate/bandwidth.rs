//! How wide footprints are made: the scale s, which plays the part of √k.

use super::kernel;
use crate::scene::settings::{Bandwidth, EmissionPattern, KernelShape};

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
