//! The GGX distribution of microfacet normals with Smith's masking · local frame, z the macroscopic normal · densities in
//! 1/sr · `[Walter07]`, `[Heitz14]`, `[Dupuy23]`.

use crate::math::{Dir3, Vec3};
use crate::radiometry::{Pdf, SolidAngle};
use crate::sampling::warp::{UniformCone, Warp};

/// Isotropic GGX of width `alpha` > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    alpha: f64,
}

/// The map of the unit square to the normals that a direction sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleNormals {
    facets: Ggx,
    /// The direction, w.z > 0.
    w: Vec3,
    /// `w` in the space where the distribution is the unit hemisphere.
    stretched: Vec3,
    /// The cap z > −stretched.z, whose points and `stretched` have the normals half-way between them.
    cap: UniformCone,
}

impl Ggx {
    /// Narrower distributions are taken for smooth surfaces: at this width a highlight is some 10⁻⁴ rad across, far
    /// below what a pixel resolves.
    pub const SMOOTH_BELOW: f64 = 1e-4;

    /// `alpha` must be at least [`Ggx::SMOOTH_BELOW`].
    pub fn new(alpha: f64) -> Ggx {
        debug_assert!(alpha >= Ggx::SMOOTH_BELOW, "a GGX width below the smooth limit: {alpha}");
        Ggx { alpha }
    }
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Density of facets with normal `m`: area of facets a steradian and an area of the macroscopic surface,
    /// ∫ D(m) m.z dm = 1 [Walter07 (33)].
    pub fn d(&self, m: Vec3) -> f64 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let a2 = self.alpha * self.alpha;
        // cos⁴θ (α² + tan²θ)² without a division by the cosine.
        let t = a2 * m.z * m.z + m.x * m.x + m.y * m.y;
        a2 / (std::f64::consts::PI * t * t)
    }

    /// Smith's Λ of a direction of either side [Heitz14 (72)].
    pub fn lambda(&self, w: Vec3) -> f64 {
        let cos2 = w.z * w.z;
        if cos2 == 0.0 {
            return f64::INFINITY;
        }
        let a2_tan2 = self.alpha * self.alpha * (w.x * w.x + w.y * w.y) / cos2;
        0.5 * ((1.0 + a2_tan2).sqrt() - 1.0)
    }

    /// The part of the facets with a normal towards `w` that `w` sees [Heitz14 2].
    pub fn g1(&self, w: Vec3) -> f64 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// Seen from both of two directions on the same side, heights correlated [Heitz14 (99)].
    pub fn g2_reflection(&self, wo: Vec3, wi: Vec3) -> f64 {
        1.0 / (1.0 + self.lambda(wo) + self.lambda(wi))
    }

    /// Seen from two directions on opposite sides, taken to be independent [Walter07 (23)].
    pub fn g2_transmission(&self, wo: Vec3, wi: Vec3) -> f64 {
        self.g1(wo) * self.g1(wi)
    }

    /// Density, 1/sr, of the normals that `w` (w.z > 0) sees: G₁ max(0, w·m) D / w.z [Heitz14 2].
    pub fn visible_pdf(&self, w: Vec3, m: Vec3) -> f64 {
        let towards = w.dot(m);
        if towards <= 0.0 {
            return 0.0;
        }
        // G₁/w.z with the cosine inside: finite at grazing.
        let stretched = (w.z * w.z + self.alpha * self.alpha * (w.x * w.x + w.y * w.y)).sqrt();
        2.0 / (w.z + stretched) * towards * self.d(m)
    }

    /// The normals that `w` (w.z > 0) sees, with density [`Ggx::visible_pdf`].
    pub fn visible(&self, w: Vec3) -> VisibleNormals {
        let stretched = Vec3::new(self.alpha * w.x, self.alpha * w.y, w.z).normalize();
        VisibleNormals { facets: *self, w, stretched, cap: UniformCone::from_cos(-stretched.z) }
    }
}

impl VisibleNormals {
    /// Takes normals of the stretched space to ours, not normalised.
    fn squeezed(&self, h: Vec3) -> Vec3 {
        h * Vec3::new(self.facets.alpha, self.facets.alpha, 1.0)
    }
}

/// The half vector of the stretched direction and a point of the cap, uniform by area `[Dupuy23]`.
impl Warp for VisibleNormals {
    type Out = Dir3;
    type Tangent = Vec3;
    type Measure = SolidAngle;

    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        let (cap, columns) = self.cap.sample_with_jacobian(u);
        let h = self.squeezed(cap.to_vec() + self.stretched);
        let length = h.length();
        // Only a point of the cap's very rim can be opposite to the direction.
        let m = Dir3::new(h).unwrap_or(Dir3::Z);
        let column = |d: Vec3| {
            let dh = self.squeezed(d);
            (dh - m.to_vec() * m.dot(dh)) / length
        };
        (m, columns.map(column))
    }

    fn pdf(&self, m: Dir3) -> Pdf<SolidAngle> {
        Pdf::new(self.facets.visible_pdf(self.w, m.to_vec()))
    }

    fn inverse(&self, m: Dir3) -> Option<[f64; 2]> {
        if m.z <= 0.0 || self.w.dot(m.to_vec()) <= 0.0 {
            return None;
        }
        let h = Vec3::new(m.x / self.facets.alpha, m.y / self.facets.alpha, m.z).normalize();
        self.cap.inverse(Dir3::from_unit(2.0 * self.stretched.dot(h) * h - self.stretched))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Purpose, Stream};

    const ALPHAS: [f64; 4] = [0.01, 0.1, 0.4, 1.0];

    fn direction(cos: f64, phi: f64) -> Vec3 {
        let sin = (1.0 - cos * cos).sqrt();
        Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    }

    /// ∫ g(m) dm over the upper hemisphere, by the midpoint rule in φ and in t with tan θ = α t/(1 − t), which spreads
    /// GGX evenly.
    fn integrate(alpha: f64, g: impl Fn(Vec3) -> f64) -> f64 {
        let (rings, spokes) = (2000, 256);
        let mut sum = 0.0;
        for i in 0..rings {
            let t = (f64::from(i) + 0.5) / f64::from(rings);
            let tan = alpha * t / (1.0 - t);
            let cos = 1.0 / (1.0 + tan * tan).sqrt();
            // d cos θ = −sin θ cos² θ d tan θ
            let width = tan * cos * cos * cos * alpha / ((1.0 - t) * (1.0 - t)) / f64::from(rings);
            for j in 0..spokes {
                let phi = std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(spokes);
                sum += g(direction(cos, phi)) * width * std::f64::consts::TAU / f64::from(spokes);
            }
        }
        sum
    }

    #[test]
    fn the_facets_cover_the_surface_once() {
        for alpha in ALPHAS {
            let ggx = Ggx::new(alpha);
            let covered = integrate(alpha, |m| ggx.d(m) * m.z);
            assert!((covered - 1.0).abs() < 1e-6, "alpha {alpha}: {covered}");
        }
    }

    /// Smith's G₁ is the one masking for which the visible facets project to the whole [Heitz14 2].
    #[test]
    fn the_visible_normals_have_density_one() {
        for alpha in ALPHAS {
            let ggx = Ggx::new(alpha);
            for cos in [0.05, 0.3, 0.8, 1.0] {
                let w = direction(cos, 0.3);
                // The kink of max(0, w·m) costs the rule its second order; 1e-4 is its first-order error here.
                let total = integrate(alpha, |m| ggx.visible_pdf(w, m));
                assert!((total - 1.0).abs() < 1e-4, "alpha {alpha} cos {cos}: {total}");
                let m = direction(0.9, 2.0);
                let by_g1 = ggx.g1(w) * w.dot(m).max(0.0) * ggx.d(m) / w.z;
                assert!((ggx.visible_pdf(w, m) - by_g1).abs() <= 1e-12 * by_g1);
            }
        }
    }

    #[test]
    fn a_visible_normal_has_its_inverse_and_its_jacobian() {
        let seed = 11;
        for (case, alpha) in ALPHAS.into_iter().enumerate() {
            let mut stream = Stream::new(seed, Purpose::Test, 0, case as u64);
            for _ in 0..500 {
                let w = direction(0.02 + 0.98 * stream.uniform(), 6.0 * stream.uniform());
                let normals = Ggx::new(alpha).visible(w);
                let u = stream.uniform2().map(|x| 0.01 + 0.98 * x);
                // The concentric map has a seam on its diagonals.
                let [a, b] = u.map(|x| (x - 0.5f64).abs());
                if (a - b).abs() < 1e-3 {
                    continue;
                }
                let m = normals.sample(u);
                let context = format!("seed {seed} alpha {alpha} w {w} u {u:?}");
                assert!((m.length() - 1.0).abs() < 1e-12 && w.dot(m.to_vec()) >= 0.0, "{context}");
                let back = normals.inverse(m).expect("drawn from w, so seen from w");
                // For narrow lobes the inverse divides rounding by α.
                let error = (back[0] - u[0]).hypot(back[1] - u[1]);
                assert!(error < 1e-9, "{context}: {back:?}");
                let jacobian = normals.jacobian(u);
                for (k, column) in jacobian.into_iter().enumerate() {
                    let h = 1e-5;
                    let moved = |step: f64| {
                        let mut v = u;
                        v[k] += step;
                        normals.sample(v).to_vec()
                    };
                    // Fourth-order central difference.
                    let difference = (8.0 * (moved(h) - moved(-h)) - (moved(2.0 * h) - moved(-2.0 * h))) / (12.0 * h);
                    let error = (difference - column).length();
                    assert!(error < 1e-8 * (1.0 + difference.length()), "{context}: column {k} off by {error}");
                }
                let product = jacobian[0].cross(jacobian[1]).length() * normals.pdf(m).get();
                assert!((product - 1.0).abs() < 1e-9, "{context}: |det| pdf = {product}");
            }
        }
    }
}
