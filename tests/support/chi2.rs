//! Chi² tests of a sampler against the density it claims, over a grid of cells in two dimensions. Directions use
//! (φ, cos θ), in which solid angle is the plain area: a density in 1/sr integrates as it is.

use pdembree::math::{Dir3, Vec3};

use super::statistics::chi2_test;

/// A rectangle cut into columns × rows cells.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    pub x: [f64; 2],
    pub y: [f64; 2],
    pub columns: usize,
    pub rows: usize,
}

/// What came out of one test.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    pub p: f64,
    /// ∫ density over the grid.
    pub integral: f64,
    /// Part of the draws that gave nothing.
    pub invalid: f64,
}

impl Grid {
    /// The unit square.
    pub fn unit(cells: usize) -> Grid {
        Grid { x: [0.0, 1.0], y: [0.0, 1.0], columns: cells, rows: cells }
    }
    /// The sphere of directions; an even number of rows puts a border on the equator.
    pub fn sphere(columns: usize, rows: usize) -> Grid {
        let pi = std::f64::consts::PI;
        Grid { x: [-pi, pi], y: [-1.0, 1.0], columns, rows }
    }
    fn cell(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let index = |v: f64, [lo, hi]: [f64; 2], n: usize| {
            let t = (v - lo) / (hi - lo);
            // The far border belongs to the last cell: −1 and 1 are poles, π is a seam.
            (0.0..=1.0).contains(&t).then(|| ((t * n as f64) as usize).min(n - 1))
        };
        Some(index(y, self.y, self.rows)? * self.columns + index(x, self.x, self.columns)?)
    }
    /// ∫ density over every cell, each to an absolute error near `tolerance`.
    pub fn integrals(&self, density: impl Fn([f64; 2]) -> f64, tolerance: f64) -> Vec<f64> {
        let border = |[lo, hi]: [f64; 2], n: usize, i: usize| lo + (hi - lo) * i as f64 / n as f64;
        let mut cells = Vec::with_capacity(self.rows * self.columns);
        for j in 0..self.rows {
            for i in 0..self.columns {
                let x = [border(self.x, self.columns, i), border(self.x, self.columns, i + 1)];
                let y = [border(self.y, self.rows, j), border(self.y, self.rows, j + 1)];
                cells.push(integrate(&density, x, y, tolerance));
            }
        }
        cells
    }
    /// Draws `draws` times and compares the counts with the density. `None` from `draw` is counted too: it must happen
    /// as often as the density misses 1. A point outside the grid is an error of the caller.
    pub fn test(
        &self,
        draws: u64,
        mut draw: impl FnMut() -> Option<[f64; 2]>,
        density: impl Fn([f64; 2]) -> f64,
    ) -> Outcome {
        // The integration error of a cell stays well below the counting error of the cell, √(expected)/draws.
        let mut expected = self.integrals(density, 0.05 / draws as f64);
        let integral: f64 = expected.iter().sum();
        assert!(integral < 1.0 + 1e-3, "a density that integrates to {integral}");
        expected.push((1.0 - integral).max(0.0));
        expected.iter_mut().for_each(|e| *e *= draws as f64);
        let nothing = expected.len() - 1;
        let mut observed = vec![0u64; expected.len()];
        for _ in 0..draws {
            match draw() {
                Some(point) => {
                    observed[self.cell(point).unwrap_or_else(|| panic!("{point:?} outside of {self:?}"))] += 1
                }
                None => observed[nothing] += 1,
            }
        }
        let invalid = observed[nothing] as f64 / draws as f64;
        Outcome { p: chi2_test(&observed, &expected), integral, invalid }
    }
}

/// (φ, cos θ) about the x axis, φ from y towards z. A lobe about z is then no needle on a pole, which the cubature could
/// not see, and the horizons of normals in the yz plane are lines of constant φ, which cells can end on.
pub fn sideways_point(w: impl Into<Vec3>) -> [f64; 2] {
    let w = w.into();
    sphere_point(Vec3::new(w.y, w.z, w.x))
}

/// The unit vector at [`sideways_point`].
pub fn sideways_direction(at: [f64; 2]) -> Dir3 {
    let w = sphere_direction(at);
    Dir3::new(Vec3::new(w.z, w.x, w.y)).expect("unit")
}

/// (φ, cos θ) of a unit vector.
pub fn sphere_point(w: impl Into<Vec3>) -> [f64; 2] {
    let w = w.into();
    [w.y.atan2(w.x), w.z.clamp(-1.0, 1.0)]
}

/// The unit vector at (φ, cos θ).
pub fn sphere_direction([phi, z]: [f64; 2]) -> Vec3 {
    let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// Adaptive cubature: Gauss' 3 × 3 points against those of the four quarters.
pub fn integrate(f: &impl Fn([f64; 2]) -> f64, x: [f64; 2], y: [f64; 2], tolerance: f64) -> f64 {
    refine(f, x, y, gauss9(f, x, y), tolerance, 0)
}

/// Deep enough for a jump across a cell: each level halves the strip that is still wrong.
const MAX_DEPTH: u32 = 7;

fn refine(f: &impl Fn([f64; 2]) -> f64, x: [f64; 2], y: [f64; 2], whole: f64, tolerance: f64, depth: u32) -> f64 {
    let (mx, my) = (0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
    let quarters =
        [([x[0], mx], [y[0], my]), ([mx, x[1]], [y[0], my]), ([x[0], mx], [my, y[1]]), ([mx, x[1]], [my, y[1]])];
    let parts = quarters.map(|(qx, qy)| gauss9(f, qx, qy));
    let sum: f64 = parts.iter().sum();
    // Three levels always: a few points alone may miss a narrow lobe.
    if depth >= MAX_DEPTH || depth >= 2 && (sum - whole).abs() <= tolerance {
        return sum;
    }
    quarters.iter().zip(parts).map(|(&(qx, qy), part)| refine(f, qx, qy, part, 0.5 * tolerance, depth + 1)).sum()
}

fn gauss9(f: &impl Fn([f64; 2]) -> f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    const NODE: f64 = 0.774_596_669_241_483_4;
    const RULE: [(f64, f64); 3] = [(-NODE, 5.0 / 9.0), (0.0, 8.0 / 9.0), (NODE, 5.0 / 9.0)];
    let at = |[lo, hi]: [f64; 2], t: f64| 0.5 * (lo + hi) + 0.5 * (hi - lo) * t;
    let mut sum = 0.0;
    for (s, ws) in RULE {
        for (t, wt) in RULE {
            sum += ws * wt * f([at(x, s), at(y, t)]);
        }
    }
    0.25 * (x[1] - x[0]) * (y[1] - y[0]) * sum
}
