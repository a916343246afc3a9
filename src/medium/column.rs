//! How much of a medium lies along a ray: ∫ ρ ds through a grid of densities · metres of density one.
//!
//! A ray is led from cell to cell. Within one, between eight samples, density along it is a polynomial of degree three, of
//! which Gauss and Legendre's rule of two points gives the exact integral: transmittance through a grid is a closed form, as
//! through fog, and so is the place up to which there is a given column. Nothing is estimated, so that nothing is noisy.

use std::ops::ControlFlow;

use crate::math::{Dir3, Point3};
use crate::scene::density::{DensityGrid, Interpolation};

/// Up to where a ray gets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reached {
    /// To this distance, at which the column was the one that was asked for.
    Place(f64),
    /// To the end, over this column.
    End(f64),
}

/// Steps towards a place within a cell at most; bisection alone would halve it below the numbers' spacing.
const MAX_STEPS: u32 = 60;

impl DensityGrid {
    /// The density at a point.
    pub fn at(&self, p: Point3) -> f64 {
        let q = self.lattice(p);
        let size = self.counts.map(|n| n as f64);
        let shift = self.shift();
        if (0..3).any(|k| q[k] < -shift || q[k] > size[k] - shift) {
            return 0.0;
        }
        let cell = q.map(|q| q.floor() as i64);
        Cell::new(self, cell).density(q)
    }

    /// ∫ ρ along a ray between two distances, the second of which may be infinite.
    pub fn column(&self, origin: Point3, w: Dir3, within: [f64; 2]) -> f64 {
        let mut sum = 0.0;
        let _ = self.walk(origin, w, within, |span| {
            sum += span.column();
            ControlFlow::<()>::Continue(())
        });
        sum
    }

    /// Where between two distances the column from the first one is `column`.
    pub fn reach(&self, origin: Point3, w: Dir3, within: [f64; 2], column: f64) -> Reached {
        let mut sum = 0.0;
        let reached = self.walk(origin, w, within, |span| {
            let whole = span.column();
            if sum + whole > column {
                return ControlFlow::Break(Reached::Place(span.place(column - sum)));
            }
            sum += whole;
            ControlFlow::Continue(())
        });
        match reached {
            ControlFlow::Break(reached) => reached,
            ControlFlow::Continue(()) => Reached::End(sum),
        }
    }

    /// The column from the first distance up to each border between cells: (distance, column), ascending.
    pub fn profile(&self, origin: Point3, w: Dir3, within: [f64; 2]) -> Vec<[f64; 2]> {
        let mut profile = Vec::new();
        let mut sum = 0.0;
        let _ = self.walk(origin, w, within, |span| {
            if profile.is_empty() {
                profile.push([span.from, 0.0]);
            }
            sum += span.column();
            profile.push([span.to, sum]);
            ControlFlow::<()>::Continue(())
        });
        profile
    }

    /// Cells are counted from the first sample to the second one, or from border to border.
    fn shift(&self) -> f64 {
        match self.between {
            Interpolation::Linear => 0.5,
            Interpolation::Cells => 0.0,
        }
    }

    /// Coordinates in which cells are unit cubes at integers.
    fn lattice(&self, p: Point3) -> [f64; 3] {
        let unit = self.place.inverse_point(p).to_array();
        std::array::from_fn(|k| unit[k] * self.counts[k] as f64 - self.shift())
    }

    /// Leads `visit` from cell to cell.
    fn walk<T>(
        &self,
        origin: Point3,
        w: Dir3,
        within: [f64; 2],
        mut visit: impl FnMut(&Span) -> ControlFlow<T>,
    ) -> ControlFlow<T> {
        let unit = self.place.inverse_vector(w.to_vec()).to_array();
        let line = Line { q: self.lattice(origin), v: std::array::from_fn(|k| unit[k] * self.counts[k] as f64) };
        let Some([mut from, to]) = line.clipped(self, within) else { return ControlFlow::Continue(()) };
        let mut cell = line.at(from).map(|q| q.floor() as i64);
        while from < to {
            let next: [f64; 3] = std::array::from_fn(|k| line.leaves(k, cell[k]));
            let axis = (1..3).fold(0, |least, k| if next[k] < next[least] { k } else { least });
            let end = next[axis].clamp(from, to);
            if end > from {
                visit(&Span { cell: Cell::new(self, cell), line: &line, from, to: end })?;
            }
            from = end;
            if next[axis] >= to {
                break;
            }
            cell[axis] += if line.v[axis] > 0.0 { 1 } else { -1 };
        }
        ControlFlow::Continue(())
    }
}

/// A ray in the lattice's coordinates: q + t v at the distance t.
struct Line {
    q: [f64; 3],
    v: [f64; 3],
}

impl Line {
    fn at(&self, t: f64) -> [f64; 3] {
        std::array::from_fn(|k| self.q[k] + t * self.v[k])
    }

    /// The distance at which the ray leaves a cell along an axis.
    fn leaves(&self, k: usize, cell: i64) -> f64 {
        if self.v[k] == 0.0 {
            return f64::INFINITY;
        }
        let border = if self.v[k] > 0.0 { cell + 1 } else { cell } as f64;
        (border - self.q[k]) / self.v[k]
    }

    /// The part of `within` on which the ray is in the grid's box.
    fn clipped(&self, grid: &DensityGrid, [mut from, mut to]: [f64; 2]) -> Option<[f64; 2]> {
        let shift = grid.shift();
        for k in 0..3 {
            let (low, high) = (-shift - self.q[k], grid.counts[k] as f64 - shift - self.q[k]);
            if self.v[k] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / self.v[k], high / self.v[k]);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        (from < to).then_some([from, to])
    }
}

/// One cell with the samples at its corners.
struct Cell {
    at: [f64; 3],
    /// Bit k of the index: at the far end of axis k.
    corners: [f64; 8],
}

impl Cell {
    fn new(grid: &DensityGrid, cell: [i64; 3]) -> Cell {
        let far = match grid.between {
            Interpolation::Linear => 1,
            Interpolation::Cells => 0,
        };
        let corner = |i: i64| grid.sample([cell[0] + (i & far), cell[1] + (i >> 1 & far), cell[2] + (i >> 2 & far)]);
        Cell { at: cell.map(|c| c as f64), corners: std::array::from_fn(|i| corner(i as i64)) }
    }

    fn density(&self, q: [f64; 3]) -> f64 {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|k| q[k] - self.at[k]);
        let c = &self.corners;
        let between = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let near = between(between(c[0], c[1], x), between(c[2], c[3], x), y);
        let far = between(between(c[4], c[5], x), between(c[6], c[7], x), y);
        // Rounding beside a cell of nothing may not make less than nothing.
        between(near, far, z).max(0.0)
    }
}

/// A ray's way through one cell.
struct Span<'a> {
    cell: Cell,
    line: &'a Line,
    from: f64,
    to: f64,
}

impl Span<'_> {
    fn density(&self, t: f64) -> f64 {
        self.cell.density(self.line.at(t))
    }

    fn column(&self) -> f64 {
        self.column_to(self.to)
    }

    /// From the start of the span.
    fn column_to(&self, t: f64) -> f64 {
        let (middle, half) = (0.5 * (self.from + t), 0.5 * (t - self.from));
        let off = half / 3f64.sqrt();
        half * (self.density(middle - off) + self.density(middle + off))
    }

    /// Where in the span the column from its start is `column`: Newton's method, kept within bounds.
    fn place(&self, column: f64) -> f64 {
        let (mut low, mut high) = (self.from, self.to);
        let mut t = low + (high - low) * (column / self.column()).clamp(0.0, 1.0);
        for _ in 0..MAX_STEPS {
            let over = self.column_to(t) - column;
            if over > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - over / self.density(t);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if next == t || next == low || next == high {
                break;
            }
            t = next;
        }
        t
    }
}
