//! From photons to radiance at points.

pub mod bandwidth;
pub mod beams;
pub mod collisions;
pub mod gather;
pub mod kernel;
pub mod nearest;
pub mod pair;
mod receivers;
pub mod select;
mod splat;

pub use gather::{Asks, GatherPoint, Gathered, Turn};
pub use select::Estimate;
