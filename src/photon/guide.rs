//! Which part of a light's emission map is of use: reaches specular surfaces and makes caustics, or goes on from others.
//!
//! A survey by pilot photons says so once for a render for the leading pair of the map, and on the way for the other pair:
//! which side of a lamp looks at the glass. The map is then filled more densely: all points are kept in cells that were
//! of use and in their neighbours, few elsewhere. One even set of points is thinned and not a set for each cell
//! laid out, so that a lattice has no seams; where pilots found nothing some photons still go, of more light and wider
//! footprints, so that nothing is lost that they missed.

use super::survey::{Cell, Survey, neighbours};

/// Cells along a side of the other pair's grid at most.
const MAX_CELLS: usize = 128;
/// What part of the photons that would be sent there unguided is still sent where the pilots found nothing.
const BACKGROUND: f64 = 1.0 / 8.0;
/// A map that is useful to more than this part is filled evenly.
const NOT_WORTH_IT: f64 = 0.85;

/// Hits that a cell of the other pair has on average if all are useful.
const HITS_PER_CELL: usize = 8;

/// A grid over the unit square, and the cells that are useful.
#[derive(Clone, Debug, PartialEq)]
pub struct Useful {
    side: usize,
    cells: Vec<bool>,
}

/// What of an emission map is useful: where both pairs are.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide {
    /// The leading pair and the other one.
    useful: [Useful; 2],
    /// With which probability a point outside is kept.
    keep: f64,
}

/// What the pilots of a light found.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// No photon was stored.
    Nothing,
    /// Nearly everything is useful.
    Everywhere,
    /// These cells of both pairs.
    Part([Useful; 2]),
}

/// What is useful when this is what pilots found. A source that `is_delta` has one pair only.
pub fn found(survey: &Survey, is_delta: bool) -> Found {
    if survey.others.is_empty() {
        return Found::Nothing;
    }
    let leading = Useful { side: survey.side, cells: survey.cells.iter().map(|&cell| cell == Cell::Hit).collect() };
    let other = if is_delta { Useful::everywhere() } else { Useful::around(&survey.others) };
    let useful = [leading.with_neighbours(), other];
    if area(&useful) > NOT_WORTH_IT { Found::Everywhere } else { Found::Part(useful) }
}

/// The part of the four-dimensional map.
fn area(useful: &[Useful; 2]) -> f64 {
    useful.iter().map(Useful::area).product()
}

impl Useful {
    fn everywhere() -> Useful {
        Useful { side: 1, cells: vec![true] }
    }
    /// Cells with one of the points and their neighbours, of a grid as fine as so many points allow.
    fn around(points: &[[f64; 2]]) -> Useful {
        let side = (points.len() / HITS_PER_CELL).isqrt().clamp(1, MAX_CELLS);
        let mut hit = Useful { side, cells: vec![false; side * side] };
        for &point in points {
            let cell = hit.cell(point);
            hit.cells[cell] = true;
        }
        hit.with_neighbours()
    }
    fn with_neighbours(self) -> Useful {
        let Useful { side, cells } = self;
        let any = |cell: usize| neighbours(cell, side).any(|other| cells[other]);
        Useful { side, cells: (0..side * side).map(any).collect() }
    }
    fn area(&self) -> f64 {
        self.cells.iter().filter(|&&useful| useful).count() as f64 / self.cells.len() as f64
    }
    fn cell(&self, u: [f64; 2]) -> usize {
        let [column, row] = u.map(|u| ((u * self.side as f64) as usize).min(self.side - 1));
        row * self.side + column
    }
    fn has(&self, u: [f64; 2]) -> bool {
        self.cells[self.cell(u)]
    }
}

impl Found {
    /// How many photons the light is worth, of those that it is due by what it sends.
    pub fn worth(&self) -> f64 {
        match self {
            Found::Nothing => BACKGROUND,
            Found::Everywhere => 1.0,
            Found::Part(useful) => area(useful).max(BACKGROUND),
        }
    }

    /// How many points fill the map so that about `n` are kept, and which.
    pub fn fill(self, n: u64) -> (u64, Option<Guide>) {
        let Found::Part(useful) = self else { return (n, None) };
        let area = area(&useful);
        let background = BACKGROUND * (1.0 - area);
        let points = (n as f64 * (1.0 - background) / area).round().max(1.0);
        let keep = BACKGROUND * n as f64 / points;
        (points as u64, Some(Guide { useful, keep }))
    }
}

impl Guide {
    /// With which probability the point with this leading pair and this other one is kept.
    pub fn keep(&self, [a, b, c, d]: [f64; 4]) -> f64 {
        if self.useful[0].has([a, b]) && self.useful[1].has([c, d]) { 1.0 } else { self.keep }
    }

    /// The mean of [`Guide::keep`] over the map.
    pub fn kept(&self) -> f64 {
        let useful = area(&self.useful);
        useful + self.keep * (1.0 - useful)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::qmc;

    fn survey(side: usize, hit: impl Fn(usize) -> bool, others: Vec<[f64; 2]>) -> Survey {
        Survey::of((0..side * side).map(|i| if hit(i) { Cell::Hit } else { Cell::Missed }).collect(), others)
    }

    /// Ten rows of ten cells with a hit in one.
    fn one_cell(cell: usize) -> Survey {
        survey(10, |i| i == cell, vec![[0.5, 0.5]])
    }

    #[test]
    fn cells_around_a_hit_are_useful() {
        let Found::Part([leading, other]) = found(&one_cell(0), false) else { panic!("a part") };
        assert_eq!((leading.area(), other.area()), (0.04, 1.0));
        let useful = leading.cells;
        assert!(useful[0] && useful[1] && useful[10] && useful[11] && !useful[2] && !useful[12]);
        assert_eq!(found(&survey(1, |_| false, Vec::new()), false), Found::Nothing);
        assert_eq!(found(&survey(1, |_| true, vec![[0.1, 0.2]]), false), Found::Everywhere);
    }

    /// A lamp whose lower half alone looks at the glass.
    #[test]
    fn the_other_pair_is_learnt_on_the_way() {
        let others: Vec<[f64; 2]> = (0..10_000).map(qmc::r2).filter(|u| u[1] < 0.5).collect();
        let hits = survey(1, |_| true, others);
        let Found::Part([_, other]) = found(&hits, false) else { panic!("a part") };
        assert!((other.area() - 0.5).abs() < 0.05, "{}", other.area());
        assert!(other.has([0.3, 0.49]) && !other.has([0.3, 0.6]));
        assert_eq!(found(&hits, true), Found::Everywhere);
    }

    /// Of N points about n are kept, and outside of the useful part an eighth of what n even ones would be.
    #[test]
    fn as_many_photons_are_kept_as_were_asked_for() {
        for cell in [0, 55] {
            let n = 100_000;
            let (points, guide) = found(&one_cell(cell), true).fill(n);
            let guide = guide.expect("a part");
            assert!((guide.kept() * points as f64 / n as f64 - 1.0).abs() < 1e-4);
            let elsewhere = guide.keep([0.95, 0.05, 0.0, 0.0]);
            assert!((elsewhere * points as f64 / (n as f64 / 8.0) - 1.0).abs() < 1e-12, "{elsewhere}");
        }
    }

    #[test]
    fn a_map_that_is_useful_everywhere_or_nowhere_is_filled_evenly() {
        assert_eq!(Found::Everywhere.fill(1000), (1000, None));
        assert_eq!(Found::Nothing.fill(1000), (1000, None));
    }
}
