//! User geometries: shapes intersected by the caller's code, in f64.
//!
//! Embree culls with f32 boxes and an f32 ray; the callback sees the query's own f64 ray through the context that the
//! shim extends, and the best f64 hit is recorded there. So that f32 rounding can neither lose nor prefer a hit,
//!
//! - boxes are padded by 2⁻²⁰ of the scene's largest coordinate (Embree's traversal over user geometries is not the
//!   robust one, and rounds origin and box differently),
//! - after an accepted hit the f32 ray ends slightly *behind* it ([`widened`]): nearer candidates are all still
//!   visited, farther ones are refused in f64 against the record, and a triangle found in the slack is compared
//!   with the record at the end of the query.
//!
//! The padding knows the scene, not the ray: one that starts much farther out than the scene's largest coordinate loses
//! silhouettes to the f32 rounding of its own origin, as it does on triangles.
//!
//! A panic in a callback cannot unwind through Embree: it aborts the process (`extern "C"`).

use std::ffi::c_void;
use std::sync::Arc;

use crate::error::SceneError;
use crate::raw;
use crate::scene::MAX_COORDINATE;

/// A ray in f64 as a user geometry sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UserRay {
    /// Origin, in the scene's unit.
    pub origin: [f64; 3],
    /// Direction, of any length.
    pub direction: [f64; 3],
    /// Start of the interval, in multiples of `direction`; belongs to it.
    pub t_near: f64,
    /// End of the interval, not behind the nearest hit so far; belongs to it. May be infinite.
    pub t_far: f64,
    /// When it flies, as the query says.
    pub time: f64,
}

/// A hit that a user geometry reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UserHit {
    /// Distance in multiples of the ray's direction.
    pub t: f64,
    /// First surface parameter, the geometry's own.
    pub u: f64,
    /// Second surface parameter, the geometry's own.
    pub v: f64,
    /// The geometry's own number of what was hit in the primitive.
    pub part: u32,
}

/// Shapes that are intersected by code. Top level only: instances refuse scenes that hold them, so no transform
/// stands between the query's ray and theirs.
///
/// The methods are called from Embree's traversal, from many threads at once. A panic aborts the process. They may ask other
/// committed scenes.
pub trait UserGeometry: Send + Sync + 'static {
    /// Number of primitives, at least 1. Asked once.
    fn primitives(&self) -> u32;

    /// Lower and upper corner of a box around a primitive. Asked once each; padded by the scene.
    fn bounds(&self, prim: u32) -> ([f32; 3], [f32; 3]);

    /// The nearest hit with a primitive within `[ray.t_near, ray.t_far]`, or `None`.
    ///
    /// A hit outside of the interval, or with a `t` that is not finite, counts as none.
    fn intersect(&self, prim: u32, ray: &UserRay) -> Option<UserHit>;
}

/// A box, lower and upper corner.
type Bounds = ([f32; 3], [f32; 3]);

/// A validated user geometry that waits for the commit, when the scene's extent is known.
pub(crate) struct Pending {
    id: u32,
    geometry: Box<dyn UserGeometry>,
    bounds: Vec<Bounds>,
}

impl Pending {
    pub(crate) fn new(id: u32, geometry: Box<dyn UserGeometry>) -> Result<Self, SceneError> {
        let bounds: Vec<Bounds> = (0..geometry.primitives()).map(|primitive| geometry.bounds(primitive)).collect();
        if bounds.is_empty() {
            return Err(SceneError::Empty { geometry: id });
        }
        for (primitive, &(lower, upper)) in (0..).zip(&bounds) {
            let fits = |coordinate: &f32| f64::from(coordinate.abs()) <= MAX_COORDINATE;
            let ordered = lower.iter().zip(&upper).all(|(low, high)| low <= high);
            if !ordered || !lower.iter().chain(&upper).all(fits) {
                return Err(SceneError::BadBounds { geometry: id, primitive, bounds: (lower, upper) });
            }
        }
        Ok(Self { id, geometry, bounds })
    }

    pub(crate) fn id(&self) -> u32 {
        self.id
    }

    pub(crate) fn primitives(&self) -> u32 {
        u32::try_from(self.bounds.len()).expect("collected from a range of u32")
    }

    /// Magnitude of the largest coordinate.
    pub(crate) fn extent(&self) -> f64 {
        let corners = self.bounds.iter().flat_map(|(lower, upper)| lower.iter().chain(upper));
        corners.fold(0.0, |extent, coordinate| extent.max(f64::from(coordinate.abs())))
    }

    /// Pads the boxes for a scene of the given extent and fixes the addresses that Embree will keep.
    pub(crate) fn into_callbacks(mut self, extent: f64) -> Callbacks {
        // 16 rounding errors of the largest coordinate: one each for the ray's origin, the box and the slab test's
        // products, with room.
        let pad = (extent * 2.0_f64.powi(-20)) as f32 + f32::MIN_POSITIVE;
        for (lower, upper) in &mut self.bounds {
            *lower = lower.map(|low| (low - pad).next_down());
            *upper = upper.map(|high| (high + pad).next_up());
        }
        let object = Arc::new(Object { geometry: self.geometry, bounds: self.bounds });
        let table = Box::new(raw::PdeUser {
            object: Arc::as_ptr(&object).cast_mut().cast::<c_void>(),
            bounds: Some(on_bounds),
            intersect: Some(on_intersect),
        });
        Callbacks { table: Box::into_raw(table), _object: object }
    }
}

/// What the callbacks read.
struct Object {
    geometry: Box<dyn UserGeometry>,
    bounds: Vec<Bounds>,
}

/// Embree's user pointer and what it points to, at fixed addresses and never changed.
pub(crate) struct Callbacks {
    // From a Box; raw, since Embree keeps a copy of the pointer.
    table: *mut raw::PdeUser,
    // Pointed to by the table.
    _object: Arc<Object>,
}

impl Callbacks {
    /// Valid as long as `self`; for reading only.
    pub(crate) fn as_ptr(&self) -> *mut raw::PdeUser {
        self.table
    }
}

impl Drop for Callbacks {
    fn drop(&mut self) {
        // SAFETY: made by Box::into_raw and freed here only; the scene whose geometries point here is gone (`Owned`
        // releases it first), or never got the pointer.
        drop(unsafe { Box::from_raw(self.table) });
    }
}

/// Called by the shim during rtcCommitScene, possibly from several of Embree's threads.
unsafe extern "C" fn on_bounds(object: *const c_void, prim: u32, out: *mut raw::RTCBounds) {
    // SAFETY: `object` is the pointer in `Callbacks::table`, alive as long as the scene, and only ever shared.
    let object = unsafe { &*object.cast::<Object>() };
    let (lower, upper) = object.bounds[prim as usize];
    let bounds = raw::RTCBounds {
        lower_x: lower[0],
        lower_y: lower[1],
        lower_z: lower[2],
        align0: 0.0,
        upper_x: upper[0],
        upper_y: upper[1],
        upper_z: upper[2],
        align1: 0.0,
    };
    // SAFETY: Embree gives room for one RTCBounds, which may be uninitialised.
    unsafe { out.write(bounds) };
}

/// Called by the shim during a query, on the query's thread. See `PdeUser::intersect` in shim.h.
unsafe extern "C" fn on_intersect(
    object: *const c_void,
    prim: u32,
    geom: u32,
    t_far: f32,
    keep: bool,
    record: *mut raw::PdeRecord,
) -> bool {
    // SAFETY: `object` is the pointer in `Callbacks::table`, alive as long as the scene, and only ever shared.
    let object = unsafe { &*object.cast::<Object>() };
    // SAFETY: `record` is the one on the stack of the query that is running on this thread; the query itself does not
    // touch it before Embree returns, and callbacks of one query come one after the other.
    let record = unsafe { &mut *record };
    let ray = UserRay {
        origin: record.org,
        direction: record.dir,
        t_near: record.t_near,
        // The record ends at the nearest user hit; the f32 end is lower still only after a triangle's hit.
        t_far: record.t_far.min(f64::from(t_far)),
        time: record.time,
    };
    let Some(hit) = object.geometry.intersect(prim, &ray) else {
        return false;
    };
    if !(hit.t.is_finite() && hit.t >= ray.t_near && hit.t <= ray.t_far) {
        return false;
    }
    // A tie goes to the smaller ids, so that the answer does not hang on the order of traversal.
    let taken = record.geom_id != raw::PDE_INVALID_ID;
    if taken && hit.t == record.t_far && (geom, prim) > (record.geom_id, record.prim_id) {
        return false;
    }
    if keep {
        record.t_far = hit.t;
        record.u = hit.u;
        record.v = hit.v;
        record.part = hit.part;
        record.geom_id = geom;
        record.prim_id = prim;
        record.t_far_f32 = widened(hit.t);
    }
    true
}

/// An f32 a little above `t >= 0`: by more than the rounding of a slab test, relative to `t`.
pub(crate) fn widened(t: f64) -> f32 {
    ((t * (1.0 + 2.0_f64.powi(-20))) as f32).next_up()
}
