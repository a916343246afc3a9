//! Probability densities that carry their measure.

use std::marker::PhantomData;
use std::ops::Mul;

/// Surface area, m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area;
/// Solid angle, sr.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidAngle;

/// A density per unit of the measure `M`: 1/m² or 1/sr.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pdf<M>(f64, PhantomData<M>);

impl<M> Pdf<M> {
    pub const ZERO: Pdf<M> = Pdf(0.0, PhantomData);
    pub const fn new(density: f64) -> Self {
        Pdf(density, PhantomData)
    }
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl Pdf<Area> {
    /// The density per solid angle of the same event seen from a point `distance_squared` away, `cos` being the
    /// cosine at the sampled surface [Veach97 (8.10)]. Zero where the surface is seen edge-on.
    pub fn to_solid_angle(self, distance_squared: f64, cos: f64) -> Pdf<SolidAngle> {
        let cos = cos.abs();
        Pdf::new(if cos > 0.0 { self.0 * distance_squared / cos } else { 0.0 })
    }
}

/// Probability of a discrete choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pmf(pub f64);

impl<M> Mul<Pmf> for Pdf<M> {
    type Output = Pdf<M>;
    fn mul(self, p: Pmf) -> Pdf<M> {
        Pdf(self.0 * p.0, PhantomData)
    }
}

/// Weight of a sample drawn with density `f` against another technique's density `g`, power heuristic with β = 2
/// [Veach97 9.2.4].
pub fn power_heuristic(f: f64, g: f64) -> f64 {
    // Dividing first keeps the squares of delta-like densities finite.
    if f <= 0.0 {
        return 0.0;
    }
    let ratio = g / f;
    1.0 / (1.0 + ratio * ratio)
}
