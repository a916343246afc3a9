//! All columns of a photon: those of its cell of the emission map, and, where surfaces move, that of time.
//!
//! A photon stands for a cell of rays at one time, and for a part of the shutter's interval, its time cell. Unit of time is
//! the length of that cell, so that the time column is the width of the cell as the others are of theirs. Losing photons at
//! roulette leaves fewer of them to share the rays, not the time; a surface that scatters draws a direction anew, not a time.

use crate::differential::health::MAX_SPREAD;
use crate::differential::{Column, Differential, Refraction, SurfaceMotion, narrow, reflect, refract, time, transfer};
use crate::light::Emission;
use crate::math::{Dir3, Normal3};
use crate::surface::Interaction;

/// N = 4 columns of the cell, or none for the estimates that have a width of their own, and T = 1 of time, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Columns<const N: usize, const T: usize> {
    pub cell: Differential<N>,
    /// Relative to the surface that it was transferred to, to the world on the way.
    pub time: Differential<T>,
}

impl<const N: usize, const T: usize> Columns<N, T> {
    /// Of a photon that stands for a time cell of this length, s.
    pub fn emitted(emission: &Emission, time_cell: f64) -> Self {
        let Column { dx, dw } = emission.motion;
        let time = Differential::new([Column { dx: dx * time_cell, dw: dw * time_cell }; T]);
        Columns { cell: emission.jacobian.first(), time }
    }
    /// Moves them along `w` to the surface that it meets.
    pub fn transfer(&mut self, w: Dir3, si: &Interaction, surface: &SurfaceMotion) {
        self.cell = transfer(&self.cell, w, si.t, si.ng);
        if T > 0 {
            self.time = time::arrive(&self.time, w, si.t, si.ng, surface);
        }
    }
    /// Takes them over a facet of a surface, on the outward side, that turns as the surface does: mirror if there is no
    /// `eta`, else interface. Returns the direction behind it.
    pub fn turn(
        &mut self,
        si: &Interaction,
        w: Dir3,
        (normal, eta): (Normal3, Option<f64>),
        surface: &SurfaceMotion,
    ) -> Dir3 {
        let shape = &si.shape;
        let (w_out, cell) = match eta {
            None => reflect(&self.cell, w, normal, shape),
            Some(eta) => match refract(&self.cell, w, normal, shape, eta) {
                Refraction::Transmitted(w, columns) | Refraction::TotalReflection(w, columns) => (w, columns),
            },
        };
        self.cell = cell;
        if T > 0 {
            self.time = match eta {
                None => time::reflect(&self.time, w, normal, shape, surface),
                Some(eta) => time::refract(&self.time, w, normal, shape, eta, surface),
            };
        }
        w_out
    }
    /// After an event that draws the direction anew, with these columns of its cell.
    pub fn scattered(&self, cell: Differential<N>, surface: &SurfaceMotion) -> Self {
        Columns { cell, time: if T == 0 { self.time } else { time::scatter(&self.time, surface) } }
    }
    /// Makes them what survivors of roulette with the probability `q` stand for.
    pub fn survive(&mut self, q: f64) {
        self.cell = self.cell.scaled(q.sqrt().recip());
    }
    /// Narrows those that turn too far to be followed, and returns how many these are.
    pub fn narrow(&mut self) -> u32 {
        narrow(&mut self.cell, MAX_SPREAD) + narrow(&mut self.time, MAX_SPREAD)
    }
    pub fn is_finite(&self) -> bool {
        self.cell.is_finite() && self.time.is_finite()
    }
}
