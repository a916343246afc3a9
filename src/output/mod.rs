//! Finished pictures and reports become files: whole or not at all.

pub mod atomic;
pub mod channel_names;
pub mod cryptomatte;
pub mod denoise;
pub mod error;
pub mod exr;
pub mod lock;
pub mod part;
pub mod photon_dump;
pub mod png;
pub mod sidecar;
pub mod target;
pub mod tev;

pub use channel_names::ChannelNames;
pub use error::{PartError, ReadError, WriteError};
pub use part::{Identity, Part, PartInfo};
pub use photon_dump::DumpedPhoton;
pub use sidecar::BirthCertificate;
pub use target::{Format, Target};
