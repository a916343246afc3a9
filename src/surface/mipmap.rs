//! An image pyramid and its elliptical lookups · texture coordinates outside, texels within · `[Heckbert89]`, `[Williams83]`.
//!
//! A lookup is the mean of the image under a Gaussian, the elliptical weighted average of `[Heckbert89]`. With J = ∂(i, j)/∂(x,
//! y) in texels of the finest level its covariance is J Jᵀ/4 + I/8: half a pixel's derivative is the standard deviation
//! of the pixel, and the image is reconstructed by a kernel so narrow that it keeps a magnified texel's value. Constant
//! images and linear ramps come out exactly, nothing leaves the range of the texels under the kernel.

use super::pyramid::{Level, wide};
use crate::math::{Vec2, Vec3};
use crate::radiometry::Spectrum;
use crate::scene::ImageTexture;
use crate::scene::texture::{Cursor, Placement, TextureMemory, Wrap};

/// Longest against shortest axis of a footprint; a longer one is widened, which blurs but bounds the work.
const MAX_ANISOTROPY: f64 = 16.0;

/// Variance of the reconstruction, squared texels of the finest level: about that of linear interpolation, and wide
/// enough for the cut kernel to reach three texels that are not in a line from anywhere.
const RECONSTRUCTION: f64 = 0.125;

/// The Gaussian is cut at this many of its standard deviations, lowered by its height there to end without a step.
const CUT: f64 = 3.0;

/// e^(−CUT²/2).
const CUT_HEIGHT: f64 = 0.011_108_996_538_242_306;

/// Variance of the cut and lowered Gaussian over that of the whole one, the same in every direction:
/// ½ ∫₀⁹ s k ds / ∫₀⁹ k ds with k(s) = e^(−s/2) − e^(−9/2), so (4 − 62.5 e^(−9/2)) / (4 − 22 e^(−9/2)).
const CUT_VARIANCE: f64 = (4.0 - 62.5 * CUT_HEIGHT) / (4.0 - 22.0 * CUT_HEIGHT);

/// An image with all of its coarser levels.
#[derive(Clone, Debug)]
pub struct MipMap {
    /// From the image itself to a single texel.
    levels: Vec<Level>,
    wrap: [Wrap; 2],
    /// Of the coarsest level.
    mean: Spectrum,
    /// `None` where it changes nothing.
    placement: Option<Placement>,
}

/// A symmetric 2×2 matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Symmetric {
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Symmetric {
    /// J Jᵀ for the columns of J.
    fn of_columns([a, b]: [Vec2; 2]) -> Symmetric {
        Symmetric { xx: a.x * a.x + b.x * b.x, xy: a.x * a.y + b.x * b.y, yy: a.y * a.y + b.y * b.y }
    }
    fn determinant(&self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }
    /// Larger and smaller eigenvalue.
    fn eigenvalues(&self) -> (f64, f64) {
        let major = 0.5 * (self.xx + self.yy) + (0.5 * (self.xx - self.yy)).hypot(self.xy);
        (major, if major > 0.0 { (self.determinant() / major).max(0.0) } else { 0.0 })
    }
    /// The same axes with the smaller eigenvalue raised by `d`, `major` being distinct from `minor`.
    fn widened(&self, major: f64, minor: f64, d: f64) -> Symmetric {
        // The projector on the minor axis is (major I − M)/(major − minor).
        let t = d / (major - minor);
        let raise = |diagonal: f64| diagonal + t * (major - diagonal);
        Symmetric { xx: raise(self.xx), xy: self.xy * (1.0 - t), yy: raise(self.yy) }
    }
    fn inverse(&self) -> Symmetric {
        let d = self.determinant();
        Symmetric { xx: self.yy / d, xy: -self.xy / d, yy: self.xx / d }
    }
}

impl MipMap {
    /// The image has at least one texel and `width` · `height` of them.
    pub fn new(image: &ImageTexture) -> MipMap {
        let mut levels = vec![Level::finest(&image.texels)];
        while let Some(coarser) = levels.last().and_then(Level::coarser) {
            levels.push(coarser);
        }
        let mean = Spectrum::from(levels[levels.len() - 1].mean());
        let placement = Some(image.placement).filter(|p| *p != Placement::IDENTITY);
        MipMap { levels, wrap: image.wrap, mean, placement }
    }

    /// What bounds its place.
    pub fn memory(&self) -> &TextureMemory {
        self.levels[0].memory()
    }

    /// The mean over the ellipse about `uv` that `footprint` = (∂uv/∂x, ∂uv/∂y) spans. A footprint without bounds sees
    /// the mean of the image.
    pub fn filtered(&self, uv: Vec2, footprint: [Vec2; 2]) -> Spectrum {
        let (uv, footprint) = self.placed(uv, footprint);
        let finest = &self.levels[0];
        // Rows run downwards, v upwards.
        let texels = Vec2::new(finest.width as f64, -(finest.height as f64));
        let spread = Symmetric::of_columns(footprint.map(|d| d * texels));
        let (major, minor) = spread.eigenvalues();
        if !major.is_finite() || !minor.is_finite() {
            return self.mean;
        }
        let squared = MAX_ANISOTROPY * MAX_ANISOTROPY;
        // (major + 4 RECONSTRUCTION) / (floor + 4 RECONSTRUCTION) = squared
        let floor = (major + 4.0 * RECONSTRUCTION) / squared - 4.0 * RECONSTRUCTION;
        let (spread, minor) =
            if floor > minor { (spread.widened(major, minor, floor - minor), floor) } else { (spread, minor) };
        let level = self.level_for(minor);
        if level.width == 1 && level.height == 1 {
            return self.mean;
        }
        self.weighted_mean(level, self.reduced(uv), level_covariance(level, spread))
    }

    /// From the surface's texture coordinates to the image's.
    fn placed(&self, uv: Vec2, footprint: [Vec2; 2]) -> (Vec2, [Vec2; 2]) {
        let Some(Placement { rows: [u, v] }) = &self.placement else { return (uv, footprint) };
        let linear = |d: Vec2| Vec2::new(u[0] * d.x + u[1] * d.y, v[0] * d.x + v[1] * d.y);
        (linear(uv) + Vec2::new(u[2], v[2]), footprint.map(linear))
    }

    /// The steps of u and of v that move by a texel of the image.
    pub fn texel_steps(&self) -> Vec2 {
        let finest = &self.levels[0];
        let texels = Vec2::new(finest.width as f64, finest.height as f64);
        let [u, v] = self.placed(Vec2::ZERO, [Vec2::X, Vec2::Y]).1.map(|d| (d * texels).length());
        Vec2::new(1.0 / u, 1.0 / v)
    }

    /// The coarsest level on which the kernel still has a standard deviation of 1/√3 texels across: its covariance is
    /// minor/4 + RECONSTRUCTION − (r² − 1)/12 texels of the finest level, which must be r²/3 or more.
    fn level_for(&self, minor: f64) -> &Level {
        let limit = (3.0 * minor + 12.0 * RECONSTRUCTION + 1.0) / 5.0;
        let fits = |level: &&Level| level.scale.max_element().powi(2) <= limit;
        self.levels.iter().rev().find(fits).unwrap_or(&self.levels[0])
    }

    /// `uv` brought near the image, where texel indices are exact.
    fn reduced(&self, uv: Vec2) -> Vec2 {
        let axis = |x: f64, wrap| match wrap {
            Wrap::Repeat => x - x.floor(),
            Wrap::Mirror => x - 2.0 * (0.5 * x).floor(),
            // Farther out than this only the border is in reach.
            Wrap::Clamp => x.clamp(-1e6, 1e6),
        };
        Vec2::new(axis(uv.x, self.wrap[0]), axis(uv.y, self.wrap[1]))
    }

    /// The Gaussian mean with `covariance` in texels of `level`.
    ///
    /// Weights at texels do not quite have their centre of mass at `uv`. A factor 1 + a·q on them, q being the distance
    /// from `uv`, puts it there; on the narrowest kernels this is linear interpolation.
    fn weighted_mean(&self, level: &Level, uv: Vec2, covariance: Symmetric) -> Spectrum {
        let centre = Vec2::new(uv.x * level.width as f64, (1.0 - uv.y) * level.height as f64) - 0.5;
        let widened = Symmetric {
            xx: covariance.xx / CUT_VARIANCE,
            xy: covariance.xy / CUT_VARIANCE,
            yy: covariance.yy / CUT_VARIANCE,
        };
        let form = widened.inverse();
        let reach = CUT * widened.yy.sqrt();
        // Differences to one texel keep constant images exact.
        let mut texels = level.cursor();
        let mut texel = |i: i64, j: i64| self.texel(level, &mut texels, i, j);
        let origin = texel(centre.x.round() as i64, centre.y.round() as i64);
        let mut sums = Sums::default();
        for j in (centre.y - reach).ceil() as i64..=(centre.y + reach).floor() as i64 {
            let dy = j as f64 - centre.y;
            // xx dx² + 2 xy dx dy + yy dy² = CUT²
            let middle = -form.xy / form.xx * dy;
            let half = ((CUT * CUT - dy * dy / widened.yy) / form.xx).max(0.0).sqrt();
            for i in (centre.x + middle - half).ceil() as i64..=(centre.x + middle + half).floor() as i64 {
                let dx = i as f64 - centre.x;
                let s = form.xx * dx * dx + 2.0 * form.xy * dx * dy + form.yy * dy * dy;
                // Rounding may put a texel of the row's ends just outside.
                let weight = ((-0.5 * s).exp() - CUT_HEIGHT).max(0.0);
                sums.add(weight, Vec2::new(dx, dy), texel(i, j) - origin);
            }
        }
        Spectrum::from((origin + sums.centred_mean()).to_array())
    }

    fn texel(&self, level: &Level, texels: &mut Cursor<'_>, i: i64, j: i64) -> Vec3 {
        let wrapped = |i: i64, n: usize, wrap| {
            let n = n as i64;
            let i = match wrap {
                Wrap::Repeat => i.rem_euclid(n),
                Wrap::Clamp => i.clamp(0, n - 1),
                Wrap::Mirror => {
                    let i = i.rem_euclid(2 * n);
                    i.min(2 * n - 1 - i)
                }
            };
            i as usize
        };
        wide(texels.texel(wrapped(i, level.width, self.wrap[0]), wrapped(j, level.height, self.wrap[1])))
    }
}

/// The covariance M/4 + RECONSTRUCTION I without what the level's own averaging has done, (r² − 1)/12 an axis, in its texels.
fn level_covariance(level: &Level, spread: Symmetric) -> Symmetric {
    let r = level.scale;
    let axis = |m: f64, r: f64| (0.25 * m + RECONSTRUCTION - (r * r - 1.0) / 12.0) / (r * r);
    Symmetric { xx: axis(spread.xx, r.x), xy: 0.25 * spread.xy / (r.x * r.y), yy: axis(spread.yy, r.y) }
}

/// Moments of weights and of weighted texels about the centre.
#[derive(Default)]
struct Sums {
    weight: f64,
    first: Vec2,
    second: [f64; 3],
    value: Vec3,
    value_x: Vec3,
    value_y: Vec3,
    /// Range of the texels, which holds the origin.
    least: Vec3,
    most: Vec3,
}

impl Sums {
    fn add(&mut self, weight: f64, q: Vec2, value: Vec3) {
        self.weight += weight;
        self.first += weight * q;
        let products = [q.x * q.x, q.x * q.y, q.y * q.y];
        self.second = std::array::from_fn(|k| self.second[k] + weight * products[k]);
        self.value += weight * value;
        self.value_x += weight * q.x * value;
        self.value_y += weight * q.y * value;
        self.least = self.least.min(value);
        self.most = self.most.max(value);
    }
    /// The mean with weights w (1 + a·q), a such that Σ w (1 + a·q) q = 0, kept in the range of the texels: far from the
    /// centre such a weight can be slightly negative.
    fn centred_mean(&self) -> Vec3 {
        let [xx, xy, yy] = self.second;
        let inverse = Symmetric { xx, xy, yy }.inverse();
        let a = -Vec2::new(
            inverse.xx * self.first.x + inverse.xy * self.first.y,
            inverse.xy * self.first.x + inverse.yy * self.first.y,
        );
        let mean = (self.value + a.x * self.value_x + a.y * self.value_y) / (self.weight + a.dot(self.first));
        mean.max(self.least).min(self.most)
    }
}
