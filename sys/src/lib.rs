//! Ray queries on the installed Embree, 3.13 or 4.x: the project's only crate with `unsafe`.
//!
//! ```text
//! Device ─ SceneBuilder (Send)  ─ commit(self) ─▶  CommittedScene (Send + Sync)  ─ intersect, occluded
//!          meshes, instances, user geometries      nothing can be changed any more
//! ```
//!
//! What · units · frame: lengths in the caller's unit, right- or left-handed alike, `t` in multiples of the ray's
//! direction (which need not be a unit vector), barycentric `u`, `v` of a triangle (a, b, c) as in
//! `p = (1 − u − v) a + u b + v c`. Rays come in f64; Embree's own arithmetic is f32, user geometries see f64.
//!
//! Fixed on purpose: robust scenes (the fast mode leaks rays through the edges of closed meshes), medium build
//! quality, all mask bits, one instance level, single rays. Every ray is validated before Embree sees it, since
//! Debian 12's build keeps its assertions and ends the process on a bad one. No error is queried per ray: Embree's
//! traversal reports none.
//!
//! An uncommitted scene cannot be traced:
//!
//! ```compile_fail,E0599
//! # use embree4_sys::{Device, Ray, SceneBuilder};
//! let device = Device::new().unwrap();
//! let builder = SceneBuilder::new(&device).unwrap();
//! let ray = Ray { origin: [0.0; 3], direction: [0.0, 0.0, 1.0], t_near: 0.0, t_far: f64::INFINITY, time: 0.0 };
//! builder.intersect(&ray);
//! ```
//!
//! a committed one cannot be changed, nor the builder used again:
//!
//! ```compile_fail,E0382
//! # use embree4_sys::{Device, SceneBuilder};
//! let device = Device::new().unwrap();
//! let mut builder = SceneBuilder::new(&device).unwrap();
//! let scene = builder.commit().unwrap();
//! builder.add_mesh(0, &[[0.0; 3]; 3], &[[0, 1, 2]]);
//! ```
//!
//! and a builder is not shared between threads, though it may move to another:
//!
//! ```compile_fail,E0277
//! fn shared<T: Sync>() {}
//! shared::<embree4_sys::SceneBuilder>();
//! ```
//!
//! ```
//! fn moved<T: Send>() {}
//! fn shared<T: Send + Sync>() {}
//! moved::<embree4_sys::SceneBuilder>();
//! shared::<embree4_sys::CommittedScene>();
//! shared::<embree4_sys::Device>();
//! ```

#![deny(unsafe_op_in_unsafe_fn, clippy::undocumented_unsafe_blocks, missing_docs)]

mod device;
mod error;
mod mesh;
mod query;
#[doc(hidden)]
pub mod raw;
mod replay;
mod scene;
mod user;

pub use device::{Device, HEADER_VERSION, Version, version};
pub use error::{DeviceError, ErrorCode, InvalidRay, SceneError};
pub use mesh::MAX_TIME_STEPS;
pub use query::{Hit, MAX_DIRECTION, MIN_DIRECTION, Ray};
pub use replay::Query;
pub use scene::{CommittedScene, MAX_COORDINATE, MAX_GEOMETRY_ID, SceneBuilder};
pub use user::{UserGeometry, UserHit, UserRay};
