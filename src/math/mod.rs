//! Points, directions, frames and the small linear algebra under everything else. All `f64`, right-handed, metres.

pub mod bounds;
pub mod float;
pub mod frame;
pub mod linalg;
pub mod motion;
pub mod ray;
pub mod student;
pub mod transform;
pub mod vector;

pub use bounds::Bounds3;
pub use frame::Frame;
pub use motion::{Motion, MotionError};
pub use ray::Ray;
pub use transform::Transform;
pub use vector::{Dir3, Normal3, Point2, Point3, Vec2, Vec3};
