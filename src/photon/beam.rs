//! A photon beam: a photon's way through a medium, with what its columns make of its width.
//!
//! Carried a distance s along the beam onto planes across it, columns are P + sD, so that the transverse form is quadratic in
//! s: Q(s) = A + s B + s² C with A = ¼ Σ P Pᵀ, B = ¼ Σ (P Dᵀ + D Pᵀ), C = ¼ Σ D Dᵀ, of the components across the beam
//! (PHOTON_DIFFERENTIALS 8, 2.4). World frame, metres, W.

use super::columns::Columns;
use super::footprint::{Spread, TangentForm};
use super::time_cells::TimeCells;
use crate::math::{Dir3, Frame, Point3, Vec2, Vec3};
use crate::radiometry::Flux;
use crate::scene::MediumId;
use crate::scene::settings::FootprintRule;

/// Light on its way through one medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    pub origin: Point3,
    pub w: Dir3,
    pub length: f64,
    /// At the origin; the medium takes from it on the way.
    pub flux: Flux,
    pub medium: MediumId,
    /// How often the photon was scattered, D, before.
    pub bounces: u32,
    pub width: BeamWidth,
}

/// Q(s) in the axes (t, b) of the frame about the beam's direction, widened by the scale of the spread.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct BeamWidth {
    constant: TangentForm,
    linear: TangentForm,
    square: TangentForm,
}

impl BeamWidth {
    /// Of columns on a plane across the beam, or of a disc of the same radius everywhere.
    pub(super) fn of<const N: usize, const T: usize>(
        columns: &Columns<N, T>,
        spread: Spread,
        cells: &TimeCells,
        frame: &Frame,
    ) -> BeamWidth {
        let (rule, scale) = match spread {
            Spread::Disc { .. } => {
                return BeamWidth { constant: spread.footprint(&columns.cell, frame), ..BeamWidth::default() };
            }
            Spread::Columns { rule, scale } => (rule, 0.5 * scale),
        };
        let (dx, dw) = (columns.cell.dx.to_array(), columns.cell.dw.to_array());
        let mut width = BeamWidth::default();
        for k in 0..N {
            let (p, d) = match rule {
                FootprintRule::Quadratic => (dx[k], dw[k]),
                // The slides' sums of pairs.
                FootprintRule::Parallelogram if k < N / 2 => (dx[k] + dx[k + N / 2], dw[k] + dw[k + N / 2]),
                FootprintRule::Parallelogram => break,
            };
            width.add(frame.project(p * scale), frame.project(d * scale));
        }
        for (dx, dw) in columns.time.dx.to_array().into_iter().zip(columns.time.dw.to_array()) {
            let (constant, square) = (cells.swept(dx, frame), cells.swept(dw, frame));
            let linear = cells.swept(dx + dw, frame).plus(constant.plus(square).scaled(-1.0));
            width.constant = width.constant.plus(constant);
            width.linear = width.linear.plus(linear);
            width.square = width.square.plus(square);
        }
        width
    }

    fn add(&mut self, p: Vec2, d: Vec2) {
        let square = |a: Vec2| TangentForm { xx: a.x * a.x, xy: a.x * a.y, yy: a.y * a.y };
        self.constant = self.constant.plus(square(p));
        self.linear =
            self.linear.plus(TangentForm { xx: 2.0 * p.x * d.x, xy: p.x * d.y + p.y * d.x, yy: 2.0 * p.y * d.y });
        self.square = self.square.plus(square(d));
    }

    /// The same everywhere, of this radius, m.
    pub fn disc(radius: f64) -> BeamWidth {
        let square = radius * radius;
        BeamWidth { constant: TangentForm { xx: square, xy: 0.0, yy: square }, ..BeamWidth::default() }
    }

    /// Q(s), m².
    pub fn at(&self, s: f64) -> TangentForm {
        self.constant.plus(self.linear.scaled(s)).plus(self.square.scaled(s * s))
    }
}

impl Beam {
    pub fn at(&self, s: f64) -> Point3 {
        self.origin + self.w * s
    }

    /// The axes of its width.
    pub fn frame(&self) -> Frame {
        Frame::from_unit(self.w)
    }

    /// Half extents along the world's axes of all its cross-sections between two distances: each is convex in s.
    pub fn half_extents(&self, from: f64, to: f64) -> Vec3 {
        let frame = self.frame();
        let [a, b] = [from, to].map(|s| self.width.at(s).world_half_extents(&frame));
        a.max(b)
    }

    /// What tells it from all others.
    pub fn bits(&self) -> [u64; 13] {
        let [x, y, z] = self.origin.to_vec().to_array().map(f64::to_bits);
        let [u, v, w] = self.w.to_vec().to_array().map(f64::to_bits);
        let [r, g, b] = self.flux.0.to_array().map(f64::to_bits);
        let form = self.width.at(1.0);
        [x, y, z, u, v, w, r, g, b, self.length.to_bits(), form.xx.to_bits(), form.yy.to_bits(), self.bounces.into()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::differential::{Column, Differential, transfer};
    use crate::math::Normal3;
    use crate::scene::Shutter;

    /// Q(s) is the footprint of the columns that are transferred onto a plane across the beam.
    #[test]
    fn the_width_is_the_footprint_on_planes_across() {
        let w = Dir3::new(Vec3::new(0.3, -0.5, 0.7)).expect("not zero");
        let frame = Frame::from_unit(w);
        let column = |a: f64, b: f64, c: f64, d: f64, e: f64| Column {
            dx: frame.t * a + frame.b * b + w * c,
            dw: frame.t * d + frame.b * e,
        };
        let cell = Differential::new([
            column(0.1, 0.02, 0.3, -0.3, 0.1),
            column(0.0, 0.2, -0.1, 0.1, 0.4),
            column(0.3, -0.1, 0.0, 0.0, 0.2),
            column(0.01, 0.0, 0.5, 0.5, 0.5),
        ]);
        let columns = Columns::<4, 0> { cell, time: Differential::ZERO };
        let cells = TimeCells::one(Shutter::instant(0.0));
        for rule in [FootprintRule::Quadratic, FootprintRule::Parallelogram] {
            let spread = Spread::Columns { rule, scale: 2.5 };
            let width = BeamWidth::of(&columns, spread, &cells, &frame);
            for s in [0.0, 0.4, 3.0] {
                let there = transfer(&cell, w, s, Normal3::from_unit(w.to_vec()));
                let (expected, found) = (spread.footprint(&there, &frame), width.at(s));
                for (a, b) in [(expected.xx, found.xx), (expected.xy, found.xy), (expected.yy, found.yy)] {
                    assert!((a - b).abs() < 1e-13, "{s}: {expected:?} {found:?}");
                }
            }
        }
        assert_eq!(BeamWidth::of(&columns, Spread::Disc { radius: 0.3 }, &cells, &frame), BeamWidth::disc(0.3));
    }
}
