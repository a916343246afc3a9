//! What a BSDF gives back: sampled directions and delta branches.

use std::ops::Deref;

use crate::math::{Dir3, Normal3};
use crate::radiometry::{Pdf, SolidAngle, Spectrum};

/// What is transported along the path being built [Veach97 4.7].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportMode {
    /// From the eye: radiance, which refraction scales by (n_i/n_t)², n_i on the side of `wo`.
    Radiance,
    /// From a light: flux, which refraction leaves alone.
    Importance,
}

/// The kind of event a sampled direction is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// Drawn from a lobe with a density; the density is that of the function that drew it.
    Scatter { pdf: Pdf<SolidAngle> },
    /// A mirror's lobe; `probability` of having been chosen.
    DeltaReflection { probability: f64 },
    /// A refracted lobe; `eta` = n_i/n_t seen by a ray that arrives along −wo.
    DeltaTransmission { probability: f64, eta: f64 },
}

impl Event {
    pub fn is_delta(&self) -> bool {
        !matches!(self, Event::Scatter { .. })
    }
}

/// How a glossy surface sends light from one direction to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passage {
    /// Over one facet with this normal, which refracts if it has a ratio of indices `eta` = n_wo/n_wi.
    Facet { normal: Normal3, eta: Option<f64> },
    /// Mostly over more than one: whence the light came says no more about whither it goes than at a diffuse surface.
    Many,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    pub wi: Dir3,
    /// f·|cos|/pdf for a scattered direction, reflectance/probability for a delta one: what the path weight is
    /// multiplied by.
    pub weight: Spectrum,
    pub event: Event,
}

/// One delta lobe with all of its energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeltaBranch {
    pub wi: Dir3,
    /// Fraction of the arriving flux (no radiance scaling).
    pub weight: Spectrum,
    /// n_i/n_t of a refracted branch, `None` for a mirrored one.
    pub eta: Option<f64>,
}

impl DeltaBranch {
    /// The branch's weight on what is transported: (n_i/n_t)² on refracted radiance.
    pub fn transport_weight(&self, mode: TransportMode) -> Spectrum {
        match (self.eta, mode) {
            (Some(eta), TransportMode::Radiance) => self.weight * (eta * eta),
            _ => self.weight,
        }
    }
}

/// Up to two delta branches; a slice to its users.
#[derive(Clone, Copy, Debug)]
pub struct DeltaBranches {
    branches: [DeltaBranch; 2],
    count: usize,
    refused: u64,
}

impl DeltaBranches {
    /// No branch.
    pub(super) fn none() -> DeltaBranches {
        let unused = DeltaBranch { wi: Dir3::Z, weight: Spectrum::BLACK, eta: None };
        DeltaBranches { branches: [unused; 2], count: 0, refused: 0 }
    }
    /// A third branch is an error of the model.
    pub(super) fn push(&mut self, branch: DeltaBranch) {
        self.branches[self.count] = branch;
        self.count += 1;
    }
    pub(super) fn refuse(&mut self) {
        self.refused += 1;
    }
    /// Lobes that would carry light but for normals that disagree about `wo` or about the lobe's own direction: what
    /// falls on them is lost, and callers count it.
    pub fn refused(&self) -> u64 {
        self.refused
    }
}

impl Deref for DeltaBranches {
    type Target = [DeltaBranch];
    fn deref(&self) -> &[DeltaBranch] {
        &self.branches[..self.count]
    }
}

impl IntoIterator for DeltaBranches {
    type Item = DeltaBranch;
    type IntoIter = std::iter::Take<std::array::IntoIter<DeltaBranch, 2>>;
    fn into_iter(self) -> Self::IntoIter {
        self.branches.into_iter().take(self.count)
    }
}
