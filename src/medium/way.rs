//! A straight way in one medium, even or not: what is left at its end, and where on it something happens.
//!
//! All of it is [`Medium`]'s own mathematics in terms of the column ∫ ρ ds, which in an even medium is the distance.

use super::column::Reached;
use crate::math::{Dir3, Point3};
use crate::radiometry::Spectrum;
use crate::scene::Medium;
use crate::scene::density::DensityGrid;

/// The part of a ray between two distances, m, of which the second may be infinite.
#[derive(Clone, Copy, Debug)]
pub struct Way<'a> {
    pub medium: &'a Medium,
    pub origin: Point3,
    pub w: Dir3,
    pub from: f64,
    pub to: f64,
}

impl<'a> Way<'a> {
    fn within(&self) -> [f64; 2] {
        [self.from, self.to]
    }

    /// ∫ ρ ds, m.
    pub fn column(&self) -> f64 {
        match &self.medium.density {
            None => self.to - self.from,
            Some(grid) => grid.column(self.origin, self.w, self.within()),
        }
    }

    /// What of the light is left at the end.
    pub fn transmittance(&self) -> Spectrum {
        self.medium.transmittance(self.column())
    }

    /// Whether and where light that carries `beta` meets the medium: the distance from the ray's origin or none, and what
    /// `beta` is to be multiplied by. `u` chooses the channel and draws the place.
    pub fn draw(&self, beta: Spectrum, u: [f64; 2]) -> (Option<f64>, Spectrum) {
        let column = self.medium.draw_column(beta, u);
        match self.reach(column) {
            Reached::Place(t) => (Some(t), self.medium.weight_at(beta, column)),
            Reached::End(column) => (None, self.medium.weight_past(beta, column)),
        }
    }

    /// A place on the way for the next event of light that carries `beta`, and what `beta` is to be multiplied by for what
    /// happens there; the rest of the light goes on. `None` where nothing can happen.
    pub fn draw_within(&self, beta: Spectrum, u: [f64; 2]) -> Option<(f64, Spectrum)> {
        let (t, left, density) = self.place_within(beta, u)?;
        Some((t, self.medium.scattering * left / density))
    }

    /// The same with what of the light gets there and with the density of the place, per metre of column.
    pub fn place_within(&self, beta: Spectrum, u: [f64; 2]) -> Option<(f64, Spectrum, f64)> {
        let whole = self.column();
        let (column, density) = self.medium.draw_column_within(beta, whole, u)?;
        let t = match self.reach(column) {
            Reached::Place(t) => t,
            // Rounding.
            Reached::End(_) => self.to,
        };
        Some((t, self.medium.transmittance(column), density))
    }

    fn reach(&self, column: f64) -> Reached {
        match &self.medium.density {
            None if column < self.to - self.from => Reached::Place(self.from + column),
            None => Reached::End(self.to - self.from),
            Some(grid) => grid.reach(self.origin, self.w, self.within(), column),
        }
    }

    /// What the column is up to each of its places, to be asked often.
    pub fn profile(&self) -> Profile<'a> {
        match &self.medium.density {
            None => Profile::Even,
            Some(grid) => {
                let borders = grid.profile(self.origin, self.w, self.within());
                Profile::Grid { grid, origin: self.origin, w: self.w, borders }
            }
        }
    }
}

/// The column from the start of a way to any place on it, in distances from its ray's origin.
#[derive(Clone, Debug)]
pub enum Profile<'a> {
    /// The distance from the start.
    Even,
    Grid {
        grid: &'a DensityGrid,
        origin: Point3,
        w: Dir3,
        /// Distances and columns of the borders between cells.
        borders: Vec<[f64; 2]>,
    },
}

impl Profile<'_> {
    /// The density at a distance, and the column up to there of a way that starts at the ray's origin.
    pub fn at(&self, t: f64) -> (f64, f64) {
        match self {
            Profile::Even => (1.0, t),
            Profile::Grid { grid, origin, w, borders } => {
                let i = borders.partition_point(|border| border[0] <= t);
                let Some([from, column]) = i.checked_sub(1).map(|before| borders[before]) else { return (0.0, 0.0) };
                (grid.at(*origin + *w * t), column + grid.column(*origin, *w, [from, t]))
            }
        }
    }
}
