//! What GGX facets lose of the light from a direction when it may meet but one of them · dimensionless · `[Heitz14]`,
//! `[Walter07]`, tabulated.
//!
//! L(μ) = 1 − E(μ), E being what one event at facets that absorb nothing sends on: all of it reflected, or, at an interface,
//! partly transmitted. It is what a lobe of light that meets more facets has to give back. Here it is a
//! little too small, by [`ERROR`] at most times two from α = 0.01 on, and never too large, so that nothing returns more
//! light than it gets.
//!
//! An interface has one table for each of a few ratios of indices, made when it is first asked for.

use std::sync::{LazyLock, OnceLock};

use super::facet_albedo::{self, CELLS, cell_of, mean, mean_of_facets};
use super::fresnel;
use super::microfacet::Ggx;

/// By how much the interpolated E may be too small: most at grazing, on narrow facets and with an index near 1.
pub const ERROR: f64 = 0.008;

/// Cells along the cube root of the width.
const WIDTHS: usize = 24;
/// Rows of narrower facets, α < 0.005, are zero: these lose light in the last degree before grazing alone.
const LEAST_WIDTH: usize = 4;
/// Cells along ±√|x| on each side, x = (η − 1)/(η + 1) up to [`FARTHEST`].
const RATIOS: usize = 24;
const FARTHEST: f64 = 0.6;
/// Cells next to η = 1 that are left out: there the table would have to tell apart what is nearly nothing.
const NEAREST: f64 = 3.0;
/// Points of a Fibonacci lattice, and its generator.
const LATTICE: [usize; 2] = [610, 377];

/// The loss by the cube root of the cosine.
struct Row {
    nodes: [[f64; 1]; CELLS + 1],
    /// L̄ = 2∫ L(μ) μ dμ, as it is interpolated.
    mean: f64,
}

/// By the cube root of the width.
type Table = Vec<Row>;

static MIRRORS: LazyLock<Table> = LazyLock::new(|| table(|cos, alpha| facet_albedo::albedo(1.0, cos, alpha)));
static INTERFACES: [OnceLock<Table>; 2 * RATIOS + 1] = [const { OnceLock::new() }; 2 * RATIOS + 1];

/// The loss by direction, of facets of one width.
#[derive(Clone, Copy)]
pub struct Loss {
    rows: [(&'static Row, f64); 4],
}

impl Loss {
    /// Of perfect mirrors.
    pub fn of_mirrors(alpha: f64) -> Loss {
        let [(a, x), (b, y)] = between(&MIRRORS, alpha);
        Loss { rows: [(a, x), (b, y), (a, 0.0), (b, 0.0)] }
    }

    /// Of an interface that is met from the side whose index is `eta` times the other's. `None` where there is no table:
    /// indices within 2 % of each other, or more than four times as large.
    pub fn of_interface(eta: f64, alpha: f64) -> Option<Loss> {
        let x = (eta - 1.0) / (eta + 1.0);
        let at = x.signum() * (x.abs() / FARTHEST).sqrt() * RATIOS as f64;
        if at.is_nan() || at.abs() < NEAREST || at.abs() > RATIOS as f64 {
            return None;
        }
        let at = at + RATIOS as f64;
        let i = (at as usize).min(2 * RATIOS - 1);
        let x = at - i as f64;
        let [(a, p), (b, q)] = between(interface(i), alpha);
        let [(c, r), (d, s)] = between(interface(i + 1), alpha);
        Some(Loss { rows: [(a, (1.0 - x) * p), (b, (1.0 - x) * q), (c, x * r), (d, x * s)] })
    }

    pub fn at(&self, cos: f64) -> f64 {
        let (j, y) = cell_of(CELLS, cos.max(0.0).cbrt());
        let of = |row: &Row| row.nodes[j][0] + y * (row.nodes[j + 1][0] - row.nodes[j][0]);
        self.rows.iter().map(|(row, part)| part * of(row)).sum()
    }

    /// L̄ = 2∫ L(μ) μ dμ, exactly that of [`Loss::at`].
    pub fn mean(&self) -> f64 {
        self.rows.iter().map(|(row, part)| part * row.mean).sum()
    }
}

/// The two rows next to a width, and their parts.
fn between(table: &'static Table, alpha: f64) -> [(&'static Row, f64); 2] {
    let (i, x) = cell_of(WIDTHS, alpha.cbrt());
    [(&table[i], 1.0 - x), (&table[i + 1], x)]
}

fn interface(i: usize) -> &'static Table {
    INTERFACES[i].get_or_init(|| {
        let root = (i as f64 - RATIOS as f64) / RATIOS as f64;
        let x = FARTHEST * root * root.abs();
        let eta = (1.0 + x) / (1.0 - x);
        table(|cos, alpha| interface_albedo(eta, cos, alpha, LATTICE))
    })
}

fn table(albedo: impl Fn(f64, f64) -> f64) -> Table {
    let row = |i: usize| {
        let alpha = (i as f64 / WIDTHS as f64).powi(3).max(Ggx::SMOOTH_BELOW);
        let node = |j: usize| match i {
            0..LEAST_WIDTH => [0.0],
            _ => {
                let cos = (j as f64 / CELLS as f64).powi(3).max(1e-9);
                [(1.0 - albedo(cos, alpha) - ERROR).max(0.0)]
            }
        };
        let nodes = std::array::from_fn(node);
        Row { nodes, mean: mean(&nodes)[0] }
    };
    (0..=WIDTHS).map(row).collect()
}

/// What one event at the facets of an interface sends on, to both sides together.
fn interface_albedo(eta: f64, cos: f64, alpha: f64, lattice: [usize; 2]) -> f64 {
    let facets = Ggx::new(alpha);
    let [albedo] = mean_of_facets(facets, cos, lattice, |w, m| {
        let across = w.dot(m).clamp(0.0, 1.0);
        let at = fresnel::dielectric(across, eta);
        let mirrored = 2.0 * across * m - w;
        let above = if mirrored.z > 0.0 { facets.g2_reflection(w, mirrored) / facets.g1(w) } else { 0.0 };
        let below = at.cos_t.map_or(0.0, |cos_t| {
            let refracted = -eta * w + (eta * across - cos_t) * m;
            if refracted.z < 0.0 { facets.g1(refracted) } else { 0.0 }
        });
        [at.reflectance * above + at.transmittance * below]
    });
    albedo
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Purpose, Stream};

    /// Against quadrature with eighteen times the points: of what is lost, all but twice the error is told from α = 0.01 on,
    /// and no more anywhere.
    #[test]
    fn no_more_is_given_back_than_is_lost_and_little_less() {
        let seed = 32;
        let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
        let fine = [10_946, 6765];
        for _ in 0..1500 {
            let ([r, s], t) = (stream.uniform2(), stream.uniform());
            let (alpha, cos) = ((r * r).max(Ggx::SMOOTH_BELOW), (s * s).max(1e-6));
            let eta = 1.03 * (2.4f64 / 1.03).powf(t);
            for eta in [eta, 1.0 / eta] {
                let lost = 1.0 - interface_albedo(eta, cos, alpha, fine);
                let told = Loss::of_interface(eta, alpha).expect("in the table").at(cos);
                let off = told - lost;
                assert!(
                    off < 1e-3 && (off > -2.0 * ERROR || alpha < 0.01),
                    "seed {seed} eta {eta} alpha {alpha} cos {cos}: {told} of {lost}"
                );
            }
            let [kept] = mean_of_facets(Ggx::new(alpha), cos, fine, |w, m| {
                let wi = 2.0 * w.dot(m) * m - w;
                let facets = Ggx::new(alpha);
                [if wi.z > 0.0 { facets.g2_reflection(w, wi) / facets.g1(w) } else { 0.0 }]
            });
            let off = Loss::of_mirrors(alpha).at(cos) - (1.0 - kept);
            assert!(
                off < 1e-3 && (off > -2.0 * ERROR || alpha < 0.01),
                "seed {seed} mirrors alpha {alpha} cos {cos}: {off}"
            );
        }
    }

    #[test]
    fn means_are_those_of_what_is_interpolated() {
        let cells = 20_000;
        for alpha in [0.01, 0.2, 0.7, 1.0] {
            for loss in [Some(Loss::of_mirrors(alpha)), Loss::of_interface(1.5, alpha), Loss::of_interface(0.4, alpha)]
            {
                let loss = loss.expect("in the table");
                let mu = (0..cells).map(|i| (f64::from(i) + 0.5) / f64::from(cells));
                let sum: f64 = mu.map(|mu| 2.0 * mu * loss.at(mu)).sum::<f64>() / f64::from(cells);
                assert!((sum - loss.mean()).abs() < 1e-6, "alpha {alpha}: {sum}, not {}", loss.mean());
            }
        }
    }

    #[test]
    fn indices_too_near_or_too_far_have_no_table() {
        for eta in [1.0, 1.01, 0.99, 4.1, 0.2] {
            assert!(Loss::of_interface(eta, 0.5).is_none(), "{eta}");
        }
        for eta in [1.03, 0.97, 3.9, 0.26] {
            assert!(Loss::of_interface(eta, 0.5).is_some(), "{eta}");
        }
    }
}
