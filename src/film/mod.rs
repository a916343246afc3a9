//! What the eye samples and the splatted light paths add up to: exact sums per pixel and layer, so that any number of
//! threads, any order of work and any split over machines gives the same bits.
//!
//! The way through: an [`EyeSample`] goes into a [`Tile`], a unit returns its tile (or its [`SplatBuffer`]), the [`Film`]
//! adds them as they come, [`Film::resolve`] makes an [`Image`]. Films of other passes and other parts of the picture
//! add up to the film of all.

pub mod error;
pub mod exact;
pub mod image;
pub mod layer;
pub mod layout;
pub mod light;
pub mod matte;
pub mod refused;
pub mod splat;
pub mod stored;
pub mod sums;
pub mod tile;
pub mod under_way;

pub use error::{MeanError, Noise};
pub use image::{Channel, Image};
pub use layer::{EyeSample, Met};
pub use layout::Layout;
pub use light::{Arrival, LightKind, Part};
pub use refused::{Cause, Refused, RefusedSample};
pub use splat::{Splat, SplatBuffer};
pub use stored::FilmShape;
pub use sums::Film;
pub use tile::{PixelBounds, Tile};
pub use under_way::{Exposure, UnitSet};
