//! The shutter's interval in equal parts: what of it a photon stands for, and how its light is spread over that.
//!
//! A photon flies at one time t and stands for the light of its whole cell, of length τ about t_m. To first order the same
//! light lands at x + D_t x (t' − t) at the time t', evenly over the cell: its mean is x + D_t x (t_m − t), and its variance
//! along D_t x is τ²/12. A kernel of variance μ₂ per unit of Q has that of the sweep, too, with
//!
//!   Q += τ²/(12 μ₂) D_t x D_t xᵀ,
//!
//! τ²/3 for the uniform kernel (PHOTON_DIFFERENTIALS 7). Q is both in the kernel's shape and in its normalisation, so that no
//! light is lost or gained.
//!
//! The swept kernel of `[Schjoth11]` is there for comparison: K of the distance to the segment from x − τ/2 D_t x to
//! x + τ/2 D_t x, about the same middle, over the area that keeps it normalised (`estimate::pair`).

use super::footprint::TangentForm;
use crate::math::{Frame, Vec3};
use crate::scene::Shutter;
use crate::scene::settings::TimeKernel;

/// Equal parts of the shutter's interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeCells {
    shutter: Shutter,
    count: u32,
    /// 1/(12 μ₂).
    spread: f64,
    kernel: TimeKernel,
}

impl TimeCells {
    /// `count` > 0 of them, for a kernel of variance `kernel` per axis on the unit disc.
    pub fn new(shutter: Shutter, count: u32, kernel: f64) -> TimeCells {
        TimeCells { shutter, count, spread: 1.0 / (12.0 * kernel), kernel: TimeKernel::Variance }
    }
    /// With another kernel over time.
    pub fn with(self, kernel: TimeKernel) -> TimeCells {
        TimeCells { kernel, ..self }
    }
    /// One, which is an instant where nothing moves.
    pub fn one(shutter: Shutter) -> TimeCells {
        TimeCells { shutter, count: 1, spread: 0.0, kernel: TimeKernel::Variance }
    }
    /// The whole interval as one of them.
    pub fn together(self) -> TimeCells {
        TimeCells { count: 1, ..self }
    }
    pub fn count(&self) -> usize {
        self.count as usize
    }
    /// τ, s.
    pub fn length(&self) -> f64 {
        self.shutter.exposure() / f64::from(self.count)
    }
    /// The number of the cell of a time.
    pub fn cell(&self, time: f64) -> usize {
        (self.place(time) as usize).min(self.count() - 1)
    }
    /// (t_m − t)/τ, from −½ to ½.
    pub fn to_middle(&self, time: f64) -> f64 {
        self.cell(time) as f64 + 0.5 - self.place(time)
    }
    /// Whether footprints are swept instead of widened.
    pub fn sweeps(&self) -> bool {
        self.kernel == TimeKernel::Swept
    }
    /// What a time column, of the unit τ, adds to the form of a footprint.
    pub fn swept(&self, column: Vec3, frame: &Frame) -> TangentForm {
        TangentForm::from_axes(frame, [column]).scaled(self.spread)
    }
    /// In cells from the opening.
    fn place(&self, time: f64) -> f64 {
        self.shutter.share(time) * f64::from(self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Normal3;

    #[test]
    fn times_are_found_in_their_cells() {
        let cells = TimeCells::new(Shutter { open: 2.0, close: 4.0 }, 4, 0.25);
        assert_eq!((cells.length(), cells.count()), (0.5, 4));
        for (time, cell, to_middle) in [(2.0, 0, 0.5), (2.25, 0, 0.0), (2.5, 1, 0.5), (3.875, 3, -0.25), (4.0, 3, -0.5)]
        {
            assert_eq!((cells.cell(time), cells.to_middle(time)), (cell, to_middle), "{time}");
        }
        let instant = TimeCells::one(Shutter::instant(7.0));
        assert_eq!((instant.cell(7.0), instant.to_middle(7.0), instant.length()), (0, 0.0, 0.0));
    }

    /// The variance of a uniform sweep of unit length, 1/12, whatever the kernel.
    #[test]
    fn sweeps_have_the_variance_of_an_even_one() {
        let frame = Frame::from_unit(Normal3::Z);
        for variance in [0.25, 0.1, 1.0 / 6.0] {
            let cells = TimeCells::new(Shutter { open: 0.0, close: 1.0 }, 1, variance);
            let form = cells.swept(Vec3::new(3.0, 4.0, 0.0), &frame);
            assert!((form.trace() * variance - 25.0 / 12.0).abs() < 1e-14 && form.determinant().abs() < 1e-12);
        }
    }
}
