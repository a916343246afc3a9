//! Pictures are compared with references, and methods with each other.

pub mod metric;
pub mod results;
pub mod ssim;

pub use metric::{Comparison, MetricError, Options, SsimDomain, compare};
