//! All columns of a photon: those of its cell of the emission map, and, where surfaces move, that of time.
//!
//! A photon stands for a cell of rays at one time, and for a part of the shutter's interval, its time cell. Unit of time is
//! the length of that cell, so that the time column is the width of the cell as the others are of theirs. Losing photons at
//! roulette leaves fewer of them to share the rays, not the time; a surface that scatters draws a direction anew, not a time.

use crate::differential::health::MAX_SPREAD;
use crate::differential::{
    Column, Differential, Refraction, SurfaceMotion, narrowed, reflect, refract, time, transfer,
};
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
    /// Moved along `w` to the surface that it meets.
    pub fn transferred(&self, w: Dir3, si: &Interaction, surface: &SurfaceMotion) -> Self {
        Columns {
            cell: transfer(&self.cell, w, si.t, si.ng),
            time: if T == 0 { self.time } else { time::arrive(&self.time, w, si.t, si.ng, surface) },
        }
    }
    /// The direction and columns after a facet of a surface, on the outward side, that turns as the surface does: mirror if
    /// there is no `eta`, else interface.
    pub fn over_facet(
        &self,
        si: &Interaction,
        w: Dir3,
        (normal, eta): (Normal3, Option<f64>),
        surface: &SurfaceMotion,
    ) -> (Dir3, Self) {
        let shape = &si.shape;
        let (w_out, cell) = match eta {
            None => reflect(&self.cell, w, normal, shape),
            Some(eta) => match refract(&self.cell, w, normal, shape, eta) {
                Refraction::Transmitted(w, columns) | Refraction::TotalReflection(w, columns) => (w, columns),
            },
        };
        if T == 0 {
            return (w_out, Columns { cell, time: self.time });
        }
        let time = match eta {
            None => time::reflect(&self.time, w, normal, shape, surface),
            Some(eta) => time::refract(&self.time, w, normal, shape, eta, surface),
        };
        (w_out, Columns { cell, time })
    }
    /// After an event that draws the direction anew, with these columns of its cell.
    pub fn scattered(&self, cell: Differential<N>, surface: &SurfaceMotion) -> Self {
        Columns { cell, time: if T == 0 { self.time } else { time::scatter(&self.time, surface) } }
    }
    /// What survivors of roulette with the probability `q` stand for.
    pub fn survived(&self, q: f64) -> Self {
        Columns { cell: self.cell.scaled(q.sqrt().recip()), ..*self }
    }
    /// Without columns that turn too far to be followed, and how many were narrowed.
    pub fn narrowed(&self) -> (Self, u32) {
        let ((cell, narrow), (time, fast)) = (narrowed(&self.cell, MAX_SPREAD), narrowed(&self.time, MAX_SPREAD));
        (Columns { cell, time }, narrow + fast)
    }
    pub fn is_finite(&self) -> bool {
        self.cell.is_finite() && self.time.is_finite()
    }
}
