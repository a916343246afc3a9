//! A straight way in one medium, even or not: what is left at its end, and where on it something happens.
//!
//! All of it is [`Medium`]'s own mathematics in terms of the column ∫ ρ ds, which in an even medium is the distance.

use super::chances::Chances;
use super::column::Reached;
use super::equiangular::Equiangular;
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

    /// A place on the way at which light that carries `beta` is scattered to a point, how likely it was drawn, and what `beta`
    /// is to be multiplied by for that: drawn in one half of all cases as [`Way::draw_within`] does and in the other over the angles that the point
    /// sees, if there is one; both densities are weighed `[Veach97 9.2.2]`. `None` where nothing can happen.
    pub fn draw_towards(&self, point: Option<Point3>, beta: Spectrum, u: [f64; 3]) -> Option<(Chances, Spectrum)> {
        let angles = point.and_then(|point| Equiangular::new(self.origin, self.w, self.within(), point));
        let t = match angles {
            Some(angles) if u[0] < 0.5 => angles.sample(u[2]).clamp(self.from, self.to),
            _ => self.place_within(beta, [u[1], u[2]])?.0,
        };
        let (column, density) = (Way { to: t, ..*self }.column(), self.density(t));
        if density == 0.0 {
            return None;
        }
        let chances = self.chances_of(beta, t, column, density);
        let pdf = chances.towards(point);
        Some((chances, self.medium.scattering * self.medium.transmittance(column) * (density / pdf)))
    }

    /// How likely a place is drawn for light that carries `beta`.
    pub fn chances(&self, beta: Spectrum, t: f64) -> Chances {
        self.chances_of(beta, t, Way { to: t, ..*self }.column(), self.density(t))
    }

    fn chances_of(&self, beta: Spectrum, t: f64, column: f64, density: f64) -> Chances {
        let event = self.medium.density_at(beta, column) * density;
        let on_the_way = self.medium.density_within(beta, self.column(), column) * density;
        Chances { origin: self.origin, w: self.w, within: self.within(), t, event, on_the_way }
    }

    /// ρ at a distance.
    fn density(&self, t: f64) -> f64 {
        self.medium.density.as_ref().map_or(1.0, |grid| grid.at(self.origin + self.w * t))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::sampling::{Purpose, Stream};
    use crate::scene::density::Interpolation;
    use std::sync::Arc;

    /// E[weight f(t)] = ∫ σ_s ρ T f dt of f = 1/r² from a point near the way, with fog and with a grid, whatever the light
    /// carries; the integral by the midpoint rule.
    #[test]
    fn places_towards_a_point_stand_for_the_whole_way() {
        let place = crate::math::Transform::scale(Vec3::splat(3.0)).expect("no factor is zero");
        let samples = vec![0.3, 1.0, 0.2, 0.7, 0.9, 0.1, 0.4, 0.8];
        let grid = DensityGrid { place, counts: [2, 2, 2], samples, between: Interpolation::Linear };
        let (origin, w) = (Point3::new(0.2, 0.4, 0.1), Dir3::new(Vec3::new(2.0, 1.0, 2.0)).expect("a direction"));
        let point = Point3::new(1.0, 0.9, 0.8);
        let near = |t: f64| 1.0 / (origin + w * t - point).length_squared();
        for (seed, density) in [(1, None), (2, Some(Arc::new(grid)))] {
            let scattering = Spectrum::rgb(0.5, 0.0, 3.0);
            let medium = Medium { absorption: Spectrum::rgb(0.2, 0.1, 1.0), scattering, asymmetry: 0.0, density };
            let way = Way { medium: &medium, origin, w, from: 0.3, to: 2.5 };
            let (steps, mut expected) = (4000, [0.0; 3]);
            for k in 0..steps {
                let width = (way.to - way.from) / f64::from(steps);
                let t = way.from + (f64::from(k) + 0.5) * width;
                let density = medium.density.as_ref().map_or(1.0, |grid| grid.at(origin + w * t));
                let there = medium.scattering * Way { to: t, ..way }.transmittance() * (density * near(t) * width);
                expected = std::array::from_fn(|c| expected[c] + there.to_array()[c]);
            }
            for (beta, point) in [(Spectrum::ONE, Some(point)), (Spectrum::rgb(1.0, 0.5, 0.1), None)] {
                let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
                let (n, mut sums) = (20_000, [[0.0; 2]; 3]);
                for _ in 0..n {
                    let u = [stream.uniform(), stream.uniform(), stream.uniform()];
                    let Some((place, weight)) = way.draw_towards(point, beta, u) else { continue };
                    for (sum, x) in sums.iter_mut().zip((weight * near(place.t)).to_array()) {
                        *sum = [sum[0] + x, sum[1] + x * x];
                    }
                }
                for (sum, expected) in sums.into_iter().zip(expected) {
                    let [mean, squares] = sum.map(|sum| sum / f64::from(n));
                    let error = ((squares - mean * mean).max(0.0) / f64::from(n)).sqrt();
                    // Five standard errors of twelve numbers, and the rule's own.
                    assert!((mean - expected).abs() <= 5.0 * error + 1e-6 * expected, "{seed}: {mean}, not {expected}");
                }
            }
        }
    }
}
