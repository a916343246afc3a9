//! A density on the unit square that is constant on rectangles · a quartet: sample · pdf · inverse · Jacobian.
//!
//! A grid of cells is halved again and again, along the side with more cells, until a rectangle's values are even; the square
//! that samples are drawn in is cut along in the same places of the tree, in proportion to what each half holds. So
//! neighbours stay neighbours, and in each rectangle the map is linear: it stretches either axis by a number, and a lattice
//! stays one. An even grid is one rectangle, and the map the identity.

/// Greatest value over the mean in a rectangle that is not cut: less than a bright cell's beside a dark one.
const EVEN: f64 = 1.25;
/// Nor is one cut that would hold less than that part of the whole if its greatest value were everywhere.
const NEGLIGIBLE: f64 = 1.0 / 65536.0;

/// An inner node: cut along `axis`, at `at_u` of the samples and at `at_x` of the square. The lower half is the next node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    axis: usize,
    at_u: f64,
    at_x: f64,
    upper: usize,
    /// Which halves hold anything.
    holds: [bool; 2],
}

/// The square, mapped to itself with a density that is constant on rectangles.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseConstant {
    /// `None` for what is not cut.
    nodes: Vec<Option<Cut>>,
}

/// An interval of samples and where it is mapped to.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    u: [f64; 2],
    x: [f64; 2],
}

impl Span {
    const WHOLE: Span = Span { u: [0.0, 1.0], x: [0.0, 1.0] };

    /// ∂x/∂u.
    fn stretch(&self) -> f64 {
        (self.x[1] - self.x[0]) / (self.u[1] - self.u[0])
    }
    fn map(&self, u: f64) -> f64 {
        if *self == Span::WHOLE { u } else { self.x[0] + (u - self.u[0]).max(0.0) * self.stretch() }
    }
    fn inverse(&self, x: f64) -> f64 {
        if *self == Span::WHOLE { x } else { self.u[0] + (x - self.x[0]).max(0.0) / self.stretch() }
    }
    fn cut(&mut self, cut: &Cut, half: usize) {
        self.u[1 - half] = cut.at_u;
        self.x[1 - half] = cut.at_x;
    }
}

/// A sample of a [`PiecewiseConstant`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PiecewiseSample {
    pub x: [f64; 2],
    /// Per unit of the square.
    pub pdf: f64,
    /// ∂x/∂u of the two axes.
    pub stretch: [f64; 2],
}

/// A grid of values over the unit square: columns of equal width, rows between `rows` edges that go up from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    pub columns: usize,
    pub rows: &'a [f64],
    /// Row by row.
    pub values: &'a [f32],
}

/// A rectangle of cells.
#[derive(Clone, Copy)]
struct Cells {
    from: [usize; 2],
    to: [usize; 2],
}

impl Grid<'_> {
    /// What a rectangle holds, and its greatest value.
    fn held(&self, cells: Cells) -> (f64, f64) {
        let (mut sum, mut greatest) = (0.0, 0.0f32);
        for row in cells.from[1]..cells.to[1] {
            let values = &self.values[row * self.columns..][cells.from[0]..cells.to[0]];
            let of_row: f64 = values.iter().map(|&v| f64::from(v)).sum();
            greatest = values.iter().fold(greatest, |greatest, &v| greatest.max(v));
            sum += of_row * (self.rows[row + 1] - self.rows[row]);
        }
        (sum / self.columns as f64, f64::from(greatest))
    }
    fn edge(&self, axis: usize, i: usize) -> f64 {
        if axis == 0 { i as f64 / self.columns as f64 } else { self.rows[i] }
    }
    fn area(&self, cells: Cells) -> f64 {
        let side = |axis: usize| self.edge(axis, cells.to[axis]) - self.edge(axis, cells.from[axis]);
        side(0) * side(1)
    }
}

impl PiecewiseConstant {
    /// With a density in proportion to the values, which are finite and not negative; `None` if all are zero.
    pub fn new(grid: &Grid<'_>) -> Option<PiecewiseConstant> {
        let all = Cells { from: [0, 0], to: [grid.columns, grid.rows.len() - 1] };
        let (total, greatest) = grid.held(all);
        let mut map = PiecewiseConstant { nodes: Vec::new() };
        (total > 0.0).then(|| {
            map.divide(grid, all, (total, greatest), Span::WHOLE, Span::WHOLE, total);
            map
        })
    }

    fn divide(
        &mut self,
        grid: &Grid<'_>,
        cells: Cells,
        (held, greatest): (f64, f64),
        across: Span,
        down: Span,
        total: f64,
    ) {
        let (area, sides) = (grid.area(cells), [0, 1].map(|k| cells.to[k] - cells.from[k]));
        if sides == [1, 1] || greatest * area <= EVEN * held || greatest * area <= NEGLIGIBLE * total {
            return self.nodes.push(None);
        }
        let axis = usize::from(sides[1] > sides[0]);
        let middle = cells.from[axis] + sides[axis] / 2;
        let (mut lower, mut upper) = (cells, cells);
        (lower.to[axis], upper.from[axis]) = (middle, middle);
        let (below, above) = (grid.held(lower), grid.held(upper));
        let mut spans = [across, down];
        let [low, high] = spans[axis].u;
        let share = below.0 / (below.0 + above.0);
        let at_u = low + (high - low) * share;
        // So little that no number lies between.
        let holds = [at_u > low, at_u < high];
        let (own, at_x) = (self.nodes.len(), grid.edge(axis, middle));
        let mut cut = Cut { axis, at_u, at_x, upper: 0, holds };
        self.nodes.push(Some(cut));
        for (half, cells, content) in [(0, lower, below), (1, upper, above)] {
            if half == 1 {
                cut.upper = self.nodes.len();
                self.nodes[own] = Some(cut);
            }
            if !holds[half] {
                self.nodes.push(None);
                continue;
            }
            spans = [across, down];
            spans[axis].cut(&cut, half);
            self.divide(grid, cells, content, spans[0], spans[1], total);
        }
    }

    /// The rectangle that `half` leads to from the root; `None` for one that holds nothing.
    fn descend(&self, half: impl Fn(&Cut) -> usize) -> Option<[Span; 2]> {
        let (mut at, mut spans) = (0, [Span::WHOLE; 2]);
        while let Some(cut) = &self.nodes[at] {
            let half = half(cut);
            if !cut.holds[half] {
                return None;
            }
            spans[cut.axis].cut(cut, half);
            at = if half == 0 { at + 1 } else { cut.upper };
        }
        Some(spans)
    }

    /// The point over `u` in [0, 1)².
    pub fn sample(&self, u: [f64; 2]) -> PiecewiseSample {
        let half = |cut: &Cut| {
            if cut.holds == [true; 2] { usize::from(u[cut.axis] >= cut.at_u) } else { usize::from(cut.holds[1]) }
        };
        let spans = self.descend(half).unwrap_or([Span::WHOLE; 2]);
        let stretch = spans.map(|span| span.stretch());
        let x = [spans[0].map(u[0]), spans[1].map(u[1])];
        PiecewiseSample { x, pdf: 1.0 / (stretch[0] * stretch[1]), stretch }
    }

    fn around(&self, x: [f64; 2]) -> Option<[Span; 2]> {
        self.descend(|cut| usize::from(x[cut.axis] >= cut.at_x))
    }

    /// Density of [`PiecewiseConstant::sample`] at `x`.
    pub fn pdf(&self, x: [f64; 2]) -> f64 {
        self.around(x).map_or(0.0, |spans| 1.0 / (spans[0].stretch() * spans[1].stretch()))
    }

    /// The sample that is mapped to `x`; `None` where there is none.
    pub fn inverse(&self, x: [f64; 2]) -> Option<[f64; 2]> {
        let spans = self.around(x)?;
        Some([spans[0].inverse(x[0]), spans[1].inverse(x[1])])
    }

    /// How many rectangles there are.
    pub fn rectangles(&self) -> usize {
        self.nodes.iter().filter(|node| node.is_none()).count()
    }
}
