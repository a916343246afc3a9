//! Flight through a medium of density one · metres, 1/m.
//!
//! Transmittance is Beer and Lambert's, T(d) = e^(−σ_t d). A place of the next event is drawn with the density
//! Σ_c p_c σ_t,c T_c(d) over the channels c, one of which is chosen in proportion to what it still carries: the weight
//! divides by the whole sum, not by the chosen channel's term, so that no channel's weight can get large.

use crate::radiometry::Spectrum;
use crate::scene::Medium;

impl Medium {
    /// σ_t, 1/m.
    pub fn extinction(&self) -> Spectrum {
        self.absorption + self.scattering
    }

    pub fn scatters(&self) -> bool {
        !self.scattering.is_black()
    }

    /// σ_s/σ_t, 0 where nothing happens.
    pub fn albedo(&self) -> Spectrum {
        let (s, t) = (self.scattering.to_array(), self.extinction().to_array());
        Spectrum::from(std::array::from_fn(|c| if t[c] > 0.0 { s[c] / t[c] } else { 0.0 }))
    }

    /// What of the light is left after `distance`, which may be infinite.
    pub fn transmittance(&self, distance: f64) -> Spectrum {
        self.extinction().map(|sigma| if sigma == 0.0 { 1.0 } else { (-sigma * distance).exp() })
    }

    /// How far light that carries `beta` gets before it meets the medium, perhaps infinitely. `u` chooses the channel and
    /// draws the distance.
    pub fn draw_column(&self, beta: Spectrum, u: [f64; 2]) -> f64 {
        let sigma = self.extinction().to_array();
        let sigma_drawn = sigma[chosen(&shares(beta), u[0])];
        if sigma_drawn > 0.0 { -(-u[1]).ln_1p() / sigma_drawn } else { f64::INFINITY }
    }

    /// What `beta` is to be multiplied by where it met the medium after this distance.
    pub fn weight_at(&self, beta: Spectrum, distance: f64) -> Spectrum {
        self.scattering * self.transmittance(distance) / self.density_at(beta, distance)
    }

    /// The density with which [`Medium::draw_column`] finds a distance, 1/m.
    pub fn density_at(&self, beta: Spectrum, distance: f64) -> f64 {
        sum(&shares(beta), &self.extinction().to_array(), self.transmittance(distance))
    }

    /// What `beta` is to be multiplied by where it met nothing over `length`.
    pub fn weight_past(&self, beta: Spectrum, length: f64) -> Spectrum {
        let left = self.transmittance(length);
        let chance = sum(&shares(beta), &[1.0; 3], left);
        if chance > 0.0 { left / chance } else { Spectrum::BLACK }
    }

    /// A distance within `length` for the next event of light that carries `beta`, and its density, 1/m. `None` where nothing
    /// can happen.
    pub fn draw_column_within(&self, beta: Spectrum, length: f64, u: [f64; 2]) -> Option<(f64, f64)> {
        let (shares, chances) = (shares(beta), self.chances(length));
        let drawn = chosen(&shares, u[0]);
        if chances[drawn] <= 0.0 {
            return None;
        }
        let sigma = self.extinction().to_array()[drawn];
        let distance = (-(-u[1] * chances[drawn]).ln_1p() / sigma).min(length);
        let density = self.density_within(beta, length, distance);
        (density > 0.0).then_some((distance, density))
    }

    /// The density with which [`Medium::draw_column_within`] finds a distance, 1/m.
    pub fn density_within(&self, beta: Spectrum, length: f64, distance: f64) -> f64 {
        let (shares, chances, sigma) = (shares(beta), self.chances(length), self.extinction().to_array());
        let left = self.transmittance(distance).to_array();
        let term = |c: usize| if chances[c] > 0.0 { shares[c] * sigma[c] / chances[c] * left[c] } else { 0.0 };
        (0..3).map(term).sum()
    }

    /// 1 − T_c(length).
    fn chances(&self, length: f64) -> [f64; 3] {
        self.extinction().to_array().map(|s| if s > 0.0 { -(-s * length).exp_m1() } else { 0.0 })
    }
}

/// How likely each channel is chosen.
fn shares(beta: Spectrum) -> [f64; 3] {
    let beta = beta.to_array();
    let total: f64 = beta.iter().sum();
    if total > 0.0 { beta.map(|b| b / total) } else { [1.0 / 3.0; 3] }
}

fn chosen(shares: &[f64; 3], u: f64) -> usize {
    let mut left = u;
    let found = shares.iter().position(|share| {
        left -= share;
        left < 0.0
    });
    // Rounding may leave a remainder behind the last channel that carries anything.
    found.or_else(|| shares.iter().rposition(|&share| share > 0.0)).unwrap_or(0)
}

fn sum(shares: &[f64; 3], sigma: &[f64; 3], left: Spectrum) -> f64 {
    let left = left.to_array();
    (0..3).map(|c| shares[c] * sigma[c] * left[c]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Dir3, Point3};
    use crate::medium::Way;
    use crate::sampling::{Purpose, Stream};

    const MEDIUM: Medium = Medium {
        absorption: Spectrum::rgb(0.2, 0.0, 1.0),
        scattering: Spectrum::rgb(0.5, 0.0, 3.0),
        asymmetry: 0.0,
        density: None,
    };

    fn way(length: f64) -> Way<'static> {
        Way { medium: &MEDIUM, origin: Point3::ORIGIN, w: Dir3::X, from: 0.0, to: length }
    }

    #[test]
    fn light_gets_as_far_as_beer_and_lambert_say() {
        let left = MEDIUM.transmittance(0.5).to_array();
        for (left, sigma) in left.into_iter().zip([0.7f64, 0.0, 4.0]) {
            assert!((left - (-0.5 * sigma).exp()).abs() < 1e-16);
        }
        assert_eq!(MEDIUM.transmittance(f64::INFINITY), Spectrum::rgb(0.0, 1.0, 0.0));
    }

    /// What happens within a length is ∫ σ_s T = σ_s (1 − T(length))/σ_t of the light, wherever it is drawn.
    #[test]
    fn places_within_a_length_stand_for_all_that_happens_there() {
        let length = 0.8;
        for (seed, beta) in [(4, Spectrum::ONE), (5, Spectrum::rgb(1.0, 0.0, 0.05))] {
            let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
            let n = 50_000;
            let mut sums = [[0.0; 2]; 3];
            for _ in 0..n {
                let Some((distance, weight)) = way(length).draw_within(beta, stream.uniform2()) else { continue };
                assert!((0.0..=length).contains(&distance));
                for (sum, x) in sums.iter_mut().zip((weight * beta).to_array()) {
                    *sum = [sum[0] + x, sum[1] + x * x];
                }
            }
            let expected = MEDIUM.albedo() * (Spectrum::ONE - MEDIUM.transmittance(length)) * beta;
            for (sum, expected) in sums.into_iter().zip(expected.to_array()) {
                let [mean, squares] = sum.map(|sum| sum / f64::from(n));
                let error = ((squares - mean * mean).max(0.0) / f64::from(n)).sqrt();
                // Five standard errors of six numbers.
                assert!((mean - expected).abs() <= 5.0 * error + 1e-12, "{seed}: {mean}, not {expected}");
            }
        }
    }

    /// E[weight; passed] = T and E[weight · f(distance)] = ∫ σ_s T f in every channel, whatever the light carries.
    #[test]
    fn drawn_distances_have_the_closed_form_moments() {
        let length = 0.8;
        for (seed, beta) in [(1, Spectrum::ONE), (2, Spectrum::rgb(1.0, 0.2, 0.01)), (3, Spectrum::rgb(0.0, 1.0, 0.5))]
        {
            let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
            let n = 200_000;
            let mut sums = [[[0.0; 2]; 3]; 2];
            for _ in 0..n {
                let (distance, weight) = way(length).draw(beta, stream.uniform2());
                let parts = match distance {
                    None => [weight, Spectrum::BLACK],
                    Some(d) => [Spectrum::BLACK, weight * d],
                };
                for (sum, part) in sums.iter_mut().zip(parts) {
                    for (sum, x) in sum.iter_mut().zip((part * beta).to_array()) {
                        *sum = [sum[0] + x, sum[1] + x * x];
                    }
                }
            }
            let (sigma_s, sigma_t) = (MEDIUM.scattering.to_array(), MEDIUM.extinction().to_array());
            for c in 0..3 {
                let (s, x) = (sigma_t[c], sigma_t[c] * length);
                // ∫₀^L σ_s e^(−σt) t dt
                let first = if s > 0.0 { sigma_s[c] / (s * s) * (1.0 - (-x).exp() * (1.0 + x)) } else { 0.0 };
                for (sum, expected) in sums.iter().zip([(-x).exp(), first]) {
                    let [mean, squares] = sum[c].map(|sum| sum / f64::from(n));
                    let error = ((squares - mean * mean).max(0.0) / f64::from(n)).sqrt();
                    let expected = expected * beta.to_array()[c];
                    // Five standard errors of 18 numbers: a chance of 1e-5.
                    assert!((mean - expected).abs() <= 5.0 * error + 1e-12, "{seed} {c}: {mean}, not {expected}");
                }
            }
        }
    }
}
