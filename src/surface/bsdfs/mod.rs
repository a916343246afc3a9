//! The models, one a file · local frame: z along the shading normal on the side of `wo`, so `wo.z` > 0; a reflected `wi`
//! has z > 0, a transmitted one z < 0 · values in 1/sr without the cosine.
//!
//! The models know nothing of the geometric normal: [`super::Bsdf`] asks them only about directions that lie on the same
//! sides of both normals.

pub mod coat;
pub mod coated;
pub mod conductor;
pub mod dielectric;
pub mod lambert;
pub mod mirror;
pub mod multiple;
pub mod plastic;
pub mod principled;
pub mod rough_conductor;
pub mod rough_dielectric;
pub mod thin_glass;

use crate::math::Vec3;
use crate::radiometry::Spectrum;

/// Where the path to be continued stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Back along the path, wo.z > 0.
    pub wo: Vec3,
    /// Whether `wo` lies on the side of the surface's outward normal.
    pub outside: bool,
}

/// A delta lobe in the local frame, with all of its energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalDelta {
    pub wi: Vec3,
    /// Fraction of the arriving flux.
    pub weight: Spectrum,
    /// n_i/n_t of a refracted lobe.
    pub eta: Option<f64>,
}

/// At most a reflected and a refracted lobe.
pub type LocalDeltas = [Option<LocalDelta>; 2];

/// The mirror image of `w` about the local normal.
pub fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(-w.x, -w.y, w.z)
}
