//! Ray queries. A backend returns ids, t and (u, v); all shading geometry is computed once, in `surface`.

pub mod brute;
pub mod crosscheck;
#[cfg(feature = "embree")]
pub mod embree;
pub mod geometry;
mod nearest;
pub mod obvhs;
pub mod record;
pub mod triangle;

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub use brute::BruteBackend;
#[cfg(feature = "embree")]
pub use embree::EmbreeBackend;
pub use geometry::Geometry;
pub use nearest::is_valid;
pub use obvhs::ObvhsBackend;
pub use record::{Recorded, RecordingBackend};

use crate::math::Ray;
use crate::scene::settings::BackendKind;
use crate::scene::{ObjectId, Scene};

/// What a ray library knows of a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawHit {
    /// Along the ray, in units of its direction; for an exact shape all of an `f64`, the same in every backend.
    pub t: f64,
    pub object: ObjectId,
    /// Triangle of a mesh; 0 for an exact shape.
    pub primitive: u32,
    /// Barycentric (u, v) of a triangle, p = (1−u−v) p0 + u p1 + v p2; zero for an exact shape.
    pub uv: [f64; 2],
}

/// One committed scene in a ray library. A ray that the library cannot take (NaN, beyond its bounds) misses and is
/// counted in [`Backend::invalid_rays`].
pub trait Backend: Send + Sync {
    /// The first hit with t in (t_min, t_max).
    fn intersect(&self, ray: &Ray) -> Option<RawHit>;
    /// Whether anything lies in (t_min, t_max).
    fn occluded(&self, ray: &Ray) -> bool;
    /// Name and version, for the birth certificate.
    fn describe(&self) -> String;
    /// Rays refused so far.
    fn invalid_rays(&self) -> u64;

    /// How long the library itself takes to answer for all `rays` one after the other.
    fn time(&self, query: Query, rays: &[Ray]) -> Duration {
        let start = Instant::now();
        for ray in rays {
            match query {
                Query::Intersect => drop(black_box(self.intersect(ray))),
                Query::Occluded => drop(black_box(self.occluded(ray))),
            }
        }
        start.elapsed()
    }
}

/// What is asked along a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// The first hit.
    Intersect,
    /// Whether there is one.
    Occluded,
}

/// Why no backend could be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BackendError {
    /// This binary has no Embree.
    #[error(
        "the backend \"embree\" is not in this binary: build it with the feature `embree` (on by default), or choose \
         backend = \"obvhs\""
    )]
    EmbreeNotCompiledIn,
    /// Embree refused the scene or its own start.
    #[error("Embree: {message}; the backend \"obvhs\" may take this scene")]
    Embree { message: String },
    /// An object that rays in f32 cannot reach.
    #[error(
        "the object \"{object}\" reaches beyond {max:e} m in world space or is not finite there: scale or move it",
        max = geometry::MAX_COORDINATE
    )]
    OutOfBounds { object: String },
}

/// Builds the backend of that name over the scene.
///
/// # Errors
/// When the binary lacks it, or the scene is too large for it.
pub fn build(kind: BackendKind, scene: &Scene) -> Result<Box<dyn Backend>, BackendError> {
    build_over(kind, Arc::new(Geometry::new(scene)?))
}

/// As [`build`], over a description that several backends share.
///
/// # Errors
/// As [`build`].
pub fn build_over(kind: BackendKind, geometry: Arc<Geometry>) -> Result<Box<dyn Backend>, BackendError> {
    match kind {
        #[cfg(feature = "embree")]
        BackendKind::Embree => Ok(Box::new(EmbreeBackend::new(&geometry)?)),
        #[cfg(not(feature = "embree"))]
        BackendKind::Embree => Err(BackendError::EmbreeNotCompiledIn),
        BackendKind::Obvhs => Ok(Box::new(ObvhsBackend::new(geometry))),
        BackendKind::Brute => Ok(Box::new(BruteBackend::new(geometry))),
    }
}
