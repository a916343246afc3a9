//! Participating media: where they are, how far light gets in them, whither they scatter · metres, 1/m, 1/sr · world frame ·
//! PHOTON_DIFFERENTIALS 8.

mod chances;
pub mod column;
mod equiangular;
pub mod homogeneous;
mod inside;
mod lost;
mod phase;
mod regions;
mod way;

pub use chances::Chances;
pub use inside::Inside;
pub use lost::LostCount;
pub use phase::HenyeyGreenstein;
pub use regions::{Regions, Stretch};
pub use way::{Profile, Way};
