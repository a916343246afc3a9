//! Photons: emit → trace → map.

pub mod beam;
pub mod beam_map;
pub mod bounce;
pub mod collision;
pub mod collision_map;
mod columns;
mod edge;
pub mod emission_points;
pub mod emit;
pub mod footprint;
pub mod guide;
pub mod index;
pub mod kinds;
pub mod map;
pub mod order;
pub mod path;
pub mod plan;
pub mod record;
pub mod share;
pub mod survey;
pub mod sweep;
pub mod time_cells;
pub mod trace;

pub use beam::{Beam, BeamWidth};
pub use bounce::Bounces;
pub use collision::Collision;
pub use emission_points::EmissionPoints;
pub use emit::EmissionUnit;
pub use kinds::Kinds;
pub use map::{PhotonHarvest, PhotonMap};
pub use path::{FirstEvent, PathLimits, PhotonCounts};
pub use plan::{EmissionPlan, Population, Target};
pub use record::Photon;
pub use share::Share;
pub use time_cells::TimeCells;
pub use trace::PhotonTracer;
