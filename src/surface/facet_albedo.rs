//! What GGX facets of Schlick's reflectance return of the light from a direction, one bounce · dimensionless · `[Schlick94]`,
//! `[Heitz14]`, tabulated once.
//!
//! With F = F₀ + (1 − F₀)(1 − c)⁵ the albedo is F₀ (G − B) + B, where G is that of perfect mirrors and B that of the
//! reflectance (1 − c)⁵: two tables over roughness and direction serve every material.

use std::sync::LazyLock;

use super::microfacet::Ggx;
use crate::math::Vec3;
use crate::sampling::warp::Warp;

/// Cells along the cube root of the GGX width, and along that of the cosine: both bend most at their small ends.
pub(super) const CELLS: usize = 48;
/// Points of a Fibonacci lattice over the square that facets are drawn from, and its generator.
const LATTICE: [usize; 2] = [1597, 987];
/// By how much [`albedo`] may be too small: most at grazing on narrow facets.
pub const ERROR: f64 = 0.005;
/// What the choice of a lobe takes the reflectance of facets for at least: the mean facet may reflect nothing, others do.
pub const LEAST_REFLECTANCE: f64 = 0.02;

/// (1 − cos)⁵: what Schlick's approximation adds to the reflectance at normal incidence.
pub fn schlick_weight(cos: f64) -> f64 {
    (1.0 - cos.clamp(0.0, 1.0)).powi(5)
}

/// F₀ + (1 − F₀)(1 − cos)⁵ [Schlick94 (15)].
pub fn schlick(f0: f64, cos: f64) -> f64 {
    f0 + (1.0 - f0) * schlick_weight(cos)
}

/// G and B.
type Pair = [f64; 2];

struct Table {
    /// By cube root of the width, then by that of the cosine.
    nodes: Vec<[Pair; CELLS + 1]>,
    /// Over the hemisphere, 2∫ E(μ) μ dμ, of each row as it is interpolated.
    means: Vec<Pair>,
}

static TABLE: LazyLock<Table> = LazyLock::new(Table::new);

/// The part of the light from a direction of cosine `cos` that facets of the width `alpha` return.
pub fn albedo(f0: f64, cos: f64, alpha: f64) -> f64 {
    let (i, x) = cell(alpha.cbrt());
    let (j, y) = cell(cos.max(0.0).cbrt());
    let nodes = &TABLE.nodes;
    let along = |row: &[Pair; CELLS + 1]| mix(row[j], row[j + 1], y);
    of_pair(f0, mix(along(&nodes[i]), along(&nodes[i + 1]), x))
}

/// The part of perfectly diffuse light: the mean of [`albedo`], exactly.
pub fn diffuse_albedo(f0: f64, alpha: f64) -> f64 {
    let (i, x) = cell(alpha.cbrt());
    of_pair(f0, mix(TABLE.means[i], TABLE.means[i + 1], x))
}

/// The same of a smooth surface: 2∫ F(μ) μ dμ = F₀ + (1 − F₀)/21.
pub fn smooth_diffuse_albedo(f0: f64) -> f64 {
    f0 + (1.0 - f0) / 21.0
}

fn of_pair(f0: f64, [g, b]: Pair) -> f64 {
    f0 * (g - b) + b
}

fn mix(a: Pair, b: Pair, x: f64) -> Pair {
    std::array::from_fn(|k| a[k] + x * (b[k] - a[k]))
}

/// The cell of a root in [0, 1], and where in it.
fn cell(root: f64) -> (usize, f64) {
    cell_of(CELLS, root)
}

/// The same of so many cells.
pub(super) fn cell_of(cells: usize, root: f64) -> (usize, f64) {
    let x = root.min(1.0) * cells as f64;
    let i = (x as usize).min(cells - 1);
    (i, x - i as f64)
}

impl Table {
    fn new() -> Table {
        let root = |i: usize| i as f64 / CELLS as f64;
        let node = |i: usize, j: usize| {
            let cos = root(j).powi(3);
            if i == 0 {
                [1.0, schlick_weight(cos)]
            } else {
                pair(cos.max(1e-9), root(i).powi(3).max(Ggx::SMOOTH_BELOW), LATTICE)
            }
        };
        let nodes: Vec<[Pair; CELLS + 1]> = (0..=CELLS).map(|i| std::array::from_fn(|j| node(i, j))).collect();
        let means = nodes.iter().map(mean).collect();
        Table { nodes, means }
    }
}

/// ∫ E 6 s⁵ ds over s = ∛μ with E linear in each cell.
pub(super) fn mean<const K: usize>(row: &[[f64; K]; CELLS + 1]) -> [f64; K] {
    let mut sum = [0.0; K];
    for j in 0..CELLS {
        let [a, b] = [j, j + 1].map(|j| j as f64 / CELLS as f64);
        let (sixth, seventh) = (b.powi(6) - a.powi(6), 6.0 / 7.0 * (b.powi(7) - a.powi(7)));
        let (left, right) = ((b * sixth - seventh) / (b - a), (seventh - a * sixth) / (b - a));
        sum = std::array::from_fn(|k| sum[k] + left * row[j][k] + right * row[j + 1][k]);
    }
    sum
}

/// Over visible facets: their weight is G₂/G₁, where what they send stays above.
fn pair(cos: f64, alpha: f64, lattice: [usize; 2]) -> Pair {
    let facets = Ggx::new(alpha);
    mean_of_facets(facets, cos, lattice, |w, m| {
        let across = w.dot(m);
        let wi = 2.0 * across * m - w;
        if wi.z <= 0.0 {
            return [0.0; 2];
        }
        let weight = facets.g2_reflection(w, wi) / facets.g1(w);
        [weight, weight * schlick_weight(across)]
    })
}

/// The mean of `g` over the facets that a direction `w` of cosine `cos` sees, by a lattice rule over the square that
/// they are drawn from.
pub(super) fn mean_of_facets<const K: usize>(
    facets: Ggx,
    cos: f64,
    [points, generator]: [usize; 2],
    g: impl Fn(Vec3, Vec3) -> [f64; K],
) -> [f64; K] {
    let w = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let visible = facets.visible(w);
    let mut sum = [0.0; K];
    for k in 0..points {
        let u = [k, k * generator % points].map(|i| (i as f64 + 0.5) / points as f64);
        let one = g(w, visible.sample(u).to_vec());
        sum = std::array::from_fn(|k| sum[k] + one[k]);
    }
    sum.map(|s| s / points as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Purpose, Stream};

    /// What a layer under the facets keeps clear of lies above what they return, by quadrature with eleven times the points.
    #[test]
    fn the_table_is_never_below_the_albedo_by_more_than_its_error() {
        let seed = 31;
        let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
        for _ in 0..1500 {
            let [r, s] = stream.uniform2();
            let (alpha, cos) = ((r * r).max(Ggx::SMOOTH_BELOW), (s * s).max(1e-6));
            let fine = pair(cos, alpha, [10_946, 6765]);
            for f0 in [0.0, 0.04, 0.2] {
                let off = of_pair(f0, fine) - albedo(f0, cos, alpha);
                assert!(off < ERROR && off > -2.0 * ERROR, "seed {seed} alpha {alpha} cos {cos} f0 {f0}: {off}");
            }
        }
    }

    #[test]
    fn means_are_those_of_the_table_and_of_a_smooth_surface() {
        let mean = |e: &dyn Fn(f64) -> f64| -> f64 {
            let cells = 20_000;
            (0..cells).map(|i| (f64::from(i) + 0.5) / f64::from(cells)).map(|mu| 2.0 * mu * e(mu)).sum::<f64>()
                / f64::from(cells)
        };
        for f0 in [0.0, 0.04, 0.5] {
            let smooth = mean(&|mu| schlick(f0, mu));
            assert!((smooth - smooth_diffuse_albedo(f0)).abs() < 1e-8, "{smooth}");
            for alpha in [1e-4, 0.01, 0.2, 0.7, 1.0] {
                let by_sum = mean(&|mu| albedo(f0, mu, alpha));
                let found = diffuse_albedo(f0, alpha);
                assert!((by_sum - found).abs() < 1e-6, "f0 {f0} alpha {alpha}: {by_sum}, not {found}");
            }
        }
    }

    /// Perfect mirrors seen from straight above at full width return 1 − ln 2.
    #[test]
    fn the_table_knows_the_closed_form_from_above() {
        assert!((albedo(1.0, 1.0, 1.0) - (1.0 - 2f64.ln())).abs() < 1e-3, "{}", albedo(1.0, 1.0, 1.0));
    }
}
