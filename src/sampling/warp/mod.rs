//! Maps from the unit square onto disks, spheres and flat patches · each a quartet: sample, pdf, inverse, Jacobian ·
//! local frames with z as the axis, metres where a shape has a size.
//!
//! The Jacobian's columns ∂out/∂u and ∂out/∂v are analytic; their cross product has the length 1/pdf everywhere. A
//! photon's initial differential is made of them, so every map here is chosen for low distortion: concentric and
//! octahedral maps rather than polar coordinates.

mod cylinder;
mod disk;
mod planar;
mod sphere;

pub use cylinder::CylinderSphere;
pub use disk::{ConcentricDisk, CosineHemisphere, UniformCone};
pub use planar::{Parallelogram, Triangle};
pub use sphere::{UniformHemisphere, UniformSphere};

use crate::radiometry::Pdf;

/// A map of the unit square with all that belongs to it.
pub trait Warp {
    /// What comes out: a point or a unit direction.
    type Out: Copy;
    /// Derivatives of it.
    type Tangent: Copy;
    /// What the density is per unit of.
    type Measure;

    /// The image of `u` in [0, 1)² with the columns ∂out/∂u₀, ∂out/∂u₁, which share most of their work. On the seams of a
    /// piecewise map one of the one-sided derivatives.
    fn sample_with_jacobian(&self, u: [f64; 2]) -> (Self::Out, [Self::Tangent; 2]);
    /// The image alone.
    fn sample(&self, u: [f64; 2]) -> Self::Out {
        self.sample_with_jacobian(u).0
    }
    /// The columns alone.
    fn jacobian(&self, u: [f64; 2]) -> [Self::Tangent; 2] {
        self.sample_with_jacobian(u).1
    }
    /// Density of `sample` at `x`, zero outside its range.
    fn pdf(&self, x: Self::Out) -> Pdf<Self::Measure>;
    /// The u in [0, 1]² with `sample(u) = x`; `None` outside the range.
    fn inverse(&self, x: Self::Out) -> Option<[f64; 2]>;
}
