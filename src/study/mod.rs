//! Pictures are compared with references, and methods with each other.
//!
//! The way through a study: a [`file`](mod@file) is read into a [`plan`], [`run`](mod@run) sets up each scene with its
//! [`reference`](mod@reference) (`bench`), renders what the plan names (`series`, [`render`], with the settings of a [`method`]), judges it
//! ([`compare`](mod@compare)) and fills the tables of [`results`]; [`search`] looks for the best bandwidth, [`fit`] for the order of convergence.

mod bench;
pub mod compare;
pub mod error;
pub mod exact;
pub mod file;
pub mod fit;
pub mod flip;
pub mod mask;
pub mod method;
pub mod metric;
pub mod place;
pub mod plan;
pub mod reference;
pub mod render;
pub mod results;
pub mod run;
pub mod search;
mod series;
pub mod ssim;

pub use error::StudyError;
pub use metric::{Comparison, MetricError, Options, SsimDomain, compare};
