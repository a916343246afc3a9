//! Photons: emit → trace → map.

pub mod emit;
pub mod footprint;
pub mod guide;
pub mod index;
pub mod map;
pub mod order;
pub mod path;
pub mod record;
pub mod share;
pub mod survey;
pub mod trace;

pub use emit::{EmissionPlan, EmissionPoints, EmissionUnit};
pub use map::{PhotonHarvest, PhotonMap};
pub use path::{PathLimits, PhotonCounts};
pub use record::Photon;
pub use share::Share;
pub use trace::PhotonTracer;
