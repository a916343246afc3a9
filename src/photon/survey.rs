//! Pilot photons find out which parts of a light's emission map are of use.
//!
//! First from every cell of a grid over the leading pair of the map; then cells are cut in four again and again, as in a
//! quadtree, and pilots go where hits and misses meet: the edge of what is useful gets sharp, the rest costs nothing more.

use super::emission_points::leading;
use super::trace::PhotonTracer;
use crate::light::{Aim, Lights};
use crate::sampling::{Purpose, Stream, qmc};
use crate::scene::LightId;

/// Cells along a side of the first grid at most.
const MAX_FIRST: usize = 128;
/// Below so many there is nothing to be learnt.
const MIN_FIRST: usize = 8;
/// Cells along a side at most.
const MAX_CELLS: usize = 1024;
/// Pilots in a cell, at the points of a golden lattice.
const PILOTS_PER_CELL: u64 = 4;
/// Pilots of the first grid are this part of a pass's photons at most, and all of them twice that, once for a render.
const FIRST_SHARE: f64 = 0.25;

/// What the pilots found in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// None was there yet.
    Open,
    /// None was of use.
    Missed,
    /// Some did.
    Hit,
}

/// A row of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub cells: Vec<Cell>,
    /// The other pair of each pilot that was of use.
    pub others: Vec<[f64; 2]>,
}

/// A square of cells, row after row.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    pub side: usize,
    pub cells: Vec<Cell>,
    /// The other pair of each pilot that was of use, of all levels.
    pub others: Vec<[f64; 2]>,
    /// How often the first cells were cut.
    level: u64,
    /// Pilots that may still be sent.
    left: u64,
}

impl Survey {
    /// The first grid for a light that is due `n` photons; `None` if that is too few to learn from.
    pub fn new(n: u64) -> Option<Survey> {
        let first = FIRST_SHARE * n as f64;
        let side = ((first / PILOTS_PER_CELL as f64).sqrt() as usize).min(MAX_FIRST);
        let left = (2.0 * first) as u64;
        let cells = vec![Cell::Open; side * side];
        (side >= MIN_FIRST).then_some(Survey { side, cells, others: Vec::new(), level: 0, left })
    }

    /// What was found, with no pilots left.
    #[cfg(test)]
    pub fn of(cells: Vec<Cell>, others: Vec<[f64; 2]>) -> Survey {
        Survey { side: cells.len().isqrt(), cells, others, level: 0, left: 0 }
    }

    /// Sends pilots from the open cells of a row. `tracer` is a fresh one; what it stores is thrown away by the caller.
    pub fn explore(&self, lights: &Lights, light: LightId, aim: &Aim, row: usize, tracer: &mut PhotonTracer<0>) -> Row {
        let source = lights.get(light);
        let mut found = Row { cells: self.cells[row * self.side..][..self.side].to_vec(), others: Vec::new() };
        for (column, cell) in found.cells.iter_mut().enumerate().filter(|(_, cell)| **cell == Cell::Open) {
            let mut useful = |k: u64| {
                // The sample points are fixed ones, so that what is found is a property of the scene.
                let number = (row * self.side + column) as u64;
                let i = number * PILOTS_PER_CELL + k;
                let within = qmc::shifted(qmc::golden_lattice(k, PILOTS_PER_CELL), qmc::r2(number));
                let [x, y] = [(column, within[0]), (row, within[1])].map(|(at, u)| (at as f64 + u) / self.side as f64);
                let other = qmc::r2(i);
                let path = u64::from(light.0) << 44 | self.level << 36 | i;
                let mut stream = Stream::new(0, Purpose::Guide, 0, path);
                let time = tracer.draw_time(&mut stream);
                let u = leading(source.is_collimated(), [x, y, other[0], other[1]]);
                let emission = lights.emit(light, u, aim, time)?;
                tracer.is_useful(&emission, time, &mut stream).then_some(other)
            };
            let others: Vec<[f64; 2]> = (0..PILOTS_PER_CELL).filter_map(&mut useful).collect();
            *cell = if others.is_empty() { Cell::Missed } else { Cell::Hit };
            found.others.extend(others);
        }
        found
    }

    /// Takes in what all rows found.
    pub fn learn(&mut self, rows: Vec<Row>) {
        self.left = self.left.saturating_sub(self.open(&self.cells));
        self.cells.clear();
        for row in rows {
            self.cells.extend(row.cells);
            self.others.extend(row.others);
        }
    }

    /// Cuts every cell in four and opens those at the edge of what is useful. `false`, and nothing is done, if none is to
    /// be opened or if it would take more pilots than there are.
    pub fn refine(&mut self) -> bool {
        let (side, fine) = (self.side, 2 * self.side);
        if fine > MAX_CELLS {
            return false;
        }
        let at_edge: Vec<bool> = (0..side * side).map(|cell| self.is_at_edge(cell)).collect();
        let child = |i: usize| {
            let cell = i / fine / 2 * side + i % fine / 2;
            if at_edge[cell] { Cell::Open } else { self.cells[cell] }
        };
        let cells: Vec<Cell> = (0..fine * fine).map(child).collect();
        let pilots = self.open(&cells);
        if pilots == 0 || pilots > self.left {
            return false;
        }
        (self.side, self.cells, self.level) = (fine, cells, self.level + 1);
        true
    }

    fn open(&self, cells: &[Cell]) -> u64 {
        cells.iter().filter(|&&cell| cell == Cell::Open).count() as u64 * PILOTS_PER_CELL
    }

    /// Whether a hit cell and a missed one meet here. A cell that both hits and misses, as most are for a lamp with area,
    /// is no edge.
    fn is_at_edge(&self, cell: usize) -> bool {
        neighbours(cell, self.side).any(|other| self.cells[other] != self.cells[cell])
    }
}

/// The cell and those that touch it, of a square of `side` × `side`.
pub fn neighbours(cell: usize, side: usize) -> impl Iterator<Item = usize> {
    let around = move |i: usize| i.saturating_sub(1)..(i + 2).min(side);
    around(cell / side).flat_map(move |row| around(cell % side).map(move |column| row * side + column))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pilots of a map of which a disc around (x, y) is useful.
    fn ask(survey: &mut Survey, [x, y]: [f64; 2], radius: f64) {
        let side = survey.side;
        let at = |i: usize| (i as f64 + 0.5) / side as f64;
        let one = |row: usize, column: usize| match survey.cells[row * side + column] {
            Cell::Open if (at(column) - x).hypot(at(row) - y) < radius => Cell::Hit,
            Cell::Open => Cell::Missed,
            known => known,
        };
        let row = |row: usize| Row { cells: (0..side).map(|column| one(row, column)).collect(), others: Vec::new() };
        let rows = (0..side).map(row).collect();
        survey.learn(rows);
    }

    /// A disc is found as finely as pilots last, and only its edge is looked at.
    #[test]
    fn edges_get_sharp() {
        let n = 200_000;
        let mut survey = Survey::new(n).expect("enough");
        let first = survey.side;
        let mut sent = 0;
        loop {
            let open = survey.open(&survey.cells);
            sent += open;
            if survey.side > first {
                let all = (survey.side * survey.side) as u64 * PILOTS_PER_CELL;
                assert!(open * (first as u64) < 20 * all / (survey.side / first) as u64, "{open} of {all}");
            }
            ask(&mut survey, [0.4, 0.6], 0.25);
            if !survey.refine() {
                break;
            }
        }
        assert!(sent <= n / 2 && survey.side >= 4 * first, "{sent} pilots, {} cells", survey.side);
        let hit =
            survey.cells.iter().filter(|&&cell| cell == Cell::Hit).count() as f64 / (survey.side * survey.side) as f64;
        let exact = std::f64::consts::PI * 0.25 * 0.25;
        assert!((hit / exact - 1.0).abs() < 0.01, "{hit}, not {exact}");
        assert!(!survey.cells.contains(&Cell::Open));
    }

    #[test]
    fn a_map_without_edges_is_not_looked_at_again() {
        for radius in [0.0, 2.0] {
            let mut survey = Survey::new(200_000).expect("enough");
            ask(&mut survey, [0.5, 0.5], radius);
            let before = survey.clone();
            assert!(!survey.refine() && survey == before);
        }
    }

    #[test]
    fn few_photons_are_not_guided() {
        assert_eq!(Survey::new(100), None);
        assert_eq!(Survey::new(1_000_000_000).map(|survey| survey.side), Some(MAX_FIRST));
        let side = Survey::new(20_000).expect("enough").side as u64;
        assert!(side * side * PILOTS_PER_CELL <= 5000);
    }
}
