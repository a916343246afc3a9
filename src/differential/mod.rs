//! The heart: how a ray's derivatives change along its path.
//!
//! A [`Differential`] is a set of columns (∂x/∂k, ∂ω/∂k), one for each parameter k that the ray was made from. Every
//! event acts on each column alone, so a further parameter (time, wavelength) is one more column; they are kept side by
//! side ([`lanes`]), so that it is one more lane of the same instructions. Where surfaces move, the time column takes their
//! motion into account ([`time`]). This module knows
//! no scene, no BSDF and no backend: its functions take a normal, a shape operator, an index ratio, a distance.

pub mod diffuse;
pub mod health;
pub mod lanes;
pub mod reflect;
pub mod refract;
pub mod state;
pub mod time;
pub mod transfer;

pub use diffuse::{blurred, bounced};
pub use health::narrow;
pub use reflect::reflect;
pub use refract::{Refraction, refract};
pub use state::{Column, Differential, ShapeOperator};
pub use time::SurfaceMotion;
pub use transfer::transfer;
