//! Random streams, sample patterns and warps of the unit square.

pub mod discrete;
pub mod lattice;
pub mod piecewise;
pub mod pixel;
pub mod qmc;
pub mod stream;
pub mod warp;

pub use pixel::{PixelPattern, PixelSample, PixelSamples};
pub use stream::{Purpose, Stream};
