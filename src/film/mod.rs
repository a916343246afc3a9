//! What the eye samples and the splatted light paths add up to: `f64` sums per pixel and layer, merged in the order of
//! the work units and the passes, so that any number of threads gives the same bits.
//!
//! The way through: an [`EyeSample`] goes into a [`Tile`], a unit returns its tile (or its [`SplatBuffer`]), the [`Film`]
//! adds them in unit order, [`Film::resolve`] makes an [`Image`].

pub mod image;
pub mod layer;
pub mod refused;
pub mod splat;
pub mod sums;
pub mod tile;

pub use image::{Channel, Image};
pub use layer::{EyeSample, Layout};
pub use refused::{Cause, Refused, RefusedSample};
pub use splat::{Splat, SplatBuffer};
pub use sums::Film;
pub use tile::{PixelBounds, Tile};
