//! Pixel filters by importance sampling: samples of equal weight, so pixels and tiles never share one.

use crate::math::Vec2;
use crate::scene::camera::PixelFilter;

/// Standard deviation of the Gaussian filter and where it is cut, pixels.
const GAUSSIAN_SIGMA: f64 = 0.5;
const GAUSSIAN_RADIUS: f64 = 1.5;

/// Where in raster space around the pixel's centre a sample `u` in [0, 1)² falls.
pub fn filter_offset(filter: PixelFilter, u: [f64; 2]) -> Vec2 {
    match filter {
        PixelFilter::Box => Vec2::new(u[0] - 0.5, u[1] - 0.5),
        PixelFilter::Gaussian => {
            // The radius of a 2D Gaussian cut at R is σ √(−2 ln(1 − u (1 − e^{−R²/2σ²}))) [BoxMuller58].
            let cut = 1.0 - (-0.5 * (GAUSSIAN_RADIUS / GAUSSIAN_SIGMA).powi(2)).exp();
            let r = GAUSSIAN_SIGMA * (-2.0 * (1.0 - u[0] * cut).ln()).sqrt();
            let (s, c) = (std::f64::consts::TAU * u[1]).sin_cos();
            Vec2::new(r * c, r * s)
        }
    }
}
