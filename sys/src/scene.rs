//! Scenes: a builder that collects geometries, and the committed scene that can only be traced.
//!
//! Embree wants modification, commit and tracing strictly one after the other. The types say so: `commit` consumes the
//! builder, and a [`CommittedScene`] has no method that changes it.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::fmt;
use std::marker::PhantomData;

use crate::device::Device;
use crate::error::SceneError;
use crate::mesh::Geometry;
use crate::raw;
use crate::user::{Callbacks, Pending, UserGeometry};

/// Largest coordinate of vertices, bounds and ray origins, in the scene's unit. Embree drops or asserts at 1.8e18, and
/// its robust triangle test multiplies three lengths, which must stay within f32.
pub const MAX_COORDINATE: f64 = 1e10;

/// Largest geometry id. Embree's tables are as long as the largest id of a scene.
pub const MAX_GEOMETRY_ID: u32 = (1 << 24) - 1;

/// Embree asserts on a transformed ray beyond 1.8e18.
const MAX_INSTANCE_COORDINATE: f64 = 1e18;

/// The scene's handle with everything that must outlive it.
struct Owned {
    scene: raw::RTCScene,
    // Embree's geometries point to these; dropped after the scene.
    users: Vec<Callbacks>,
    // Keeps the device and its error log alive.
    device: Device,
}

impl Drop for Owned {
    fn drop(&mut self) {
        // SAFETY: our own reference to a live scene. A scene that instances this one holds its own reference, and
        // then `users` is empty (`add_instance` refuses), so no callback data is freed too early.
        unsafe { raw::rtcReleaseScene(self.scene) };
    }
}

/// The time for which a scene is made, in the ray's unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    open: f64,
    /// 1/length; 0 for an instant.
    rate: f64,
}

impl Interval {
    /// Where in the interval a time is: 0 at its start, 1 at its end.
    pub(crate) fn place(self, time: f64) -> f64 {
        (time - self.open) * self.rate
    }

    /// As Embree takes it: in [0, 1], outside of which its assertions end the process. A NaN becomes 0.
    pub(crate) fn clamped(self, time: f64) -> f32 {
        let place = self.place(time);
        // False for a NaN.
        if place > 0.0 { place.min(1.0) as f32 } else { 0.0 }
    }
}

/// Collects geometries under ids that the caller chooses. `Send`, not `Sync`.
pub struct SceneBuilder {
    owned: Owned,
    ids: BTreeSet<u32>,
    pending: Vec<Pending>,
    // Largest coordinate so far: f32 rounding in the scene is relative to it.
    extent: f64,
    interval: Interval,
    has_instances: bool,
    // Embree's modifications are not thread-safe; this says so even where every method takes `&mut self`.
    not_sync: PhantomData<Cell<()>>,
}

// SAFETY: Embree's handles are not bound to a thread, the builder owns its scene alone until the commit, and the user
// geometries it holds are Send + Sync by their trait.
unsafe impl Send for SceneBuilder {}

impl SceneBuilder {
    /// An empty scene: robust, medium build quality.
    ///
    /// # Errors
    /// When Embree refuses (memory).
    pub fn new(device: &Device) -> Result<Self, SceneError> {
        // SAFETY: the device is alive.
        let scene = unsafe { raw::rtcNewScene(device.raw()) };
        if scene.is_null() {
            return Err(device.failure().into());
        }
        let owned = Owned { scene, users: Vec::new(), device: device.clone() };
        // SAFETY: the scene is alive and ours alone.
        unsafe {
            raw::rtcSetSceneFlags(scene, raw::RTC_SCENE_FLAG_ROBUST);
            raw::rtcSetSceneBuildQuality(scene, raw::RTC_BUILD_QUALITY_MEDIUM);
        }
        device.check()?;
        Ok(Self {
            owned,
            ids: BTreeSet::new(),
            pending: Vec::new(),
            extent: 0.0,
            interval: Interval { open: 0.0, rate: 0.0 },
            has_instances: false,
            not_sync: PhantomData,
        })
    }

    /// For rays whose times are from `open` to `close`, which moving meshes are asked about; nothing moves in an instant.
    #[must_use]
    pub fn over(mut self, open: f64, close: f64) -> Self {
        let rate = (close - open).recip();
        self.interval = Interval { open, rate: if rate.is_finite() && rate > 0.0 { rate } else { 0.0 } };
        self
    }

    /// Adds an instance of a committed scene. `transform` maps the instanced scene's points to this scene's, as three
    /// rows of an affine map (linear part, then translation); it is rounded to f32.
    ///
    /// The instanced scene is kept alive. `Hit::t` stays in multiples of the untransformed direction.
    ///
    /// # Errors
    /// A taken or too large id; a scene of another device, with instances, or with user geometries (these see the
    /// untransformed f64 ray, so they belong to the top level only); a transform that is not finite or not invertible
    /// within f32; an error of Embree's.
    pub fn add_instance(
        &mut self,
        id: u32,
        scene: &CommittedScene,
        transform: &[[f64; 4]; 3],
    ) -> Result<(), SceneError> {
        self.require_free(id)?;
        let refuse = |refused: bool, error: SceneError| if refused { Err(error) } else { Ok(()) };
        refuse(!scene.owned.device.is(&self.owned.device), SceneError::OtherDevice { geometry: id })?;
        refuse(scene.has_instances, SceneError::NestedInstance { geometry: id })?;
        refuse(!scene.owned.users.is_empty(), SceneError::InstancedUserGeometry { geometry: id })?;
        let rows = transform.map(|row| row.map(|entry| entry as f32));
        let extent = instance_extent(&rows, scene.extent).ok_or(SceneError::BadTransform { geometry: id })?;

        let geometry = Geometry::new(self, raw::RTC_GEOMETRY_TYPE_INSTANCE, id)?;
        // SAFETY: geometry and scene are alive and of one device; Embree takes its own reference to the scene and
        // reads twelve floats from `rows` during the call.
        unsafe {
            raw::rtcSetGeometryInstancedScene(geometry.raw(), scene.owned.scene);
            raw::rtcSetGeometryTransform(geometry.raw(), 0, raw::RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows.as_ptr().cast());
        }
        self.device().check()?;
        geometry.attach(self)?;
        self.has_instances = true;
        self.occupy(id, extent);
        Ok(())
    }

    /// Adds a user geometry. Its primitives' bounds are asked for once, here.
    ///
    /// # Errors
    /// A taken or too large id, no primitives, or bounds that are not finite, not ordered or beyond [`MAX_COORDINATE`].
    pub fn add_user(&mut self, id: u32, geometry: impl UserGeometry) -> Result<(), SceneError> {
        self.require_free(id)?;
        let pending = Pending::new(id, Box::new(geometry))?;
        self.occupy(id, pending.extent());
        self.pending.push(pending);
        Ok(())
    }

    /// Builds the acceleration structure. Uses the device's threads and the calling one.
    ///
    /// # Errors
    /// When Embree fails (memory). An empty scene is no error: nothing is hit.
    pub fn commit(mut self) -> Result<CommittedScene, SceneError> {
        for pending in std::mem::take(&mut self.pending) {
            let (id, primitives) = (pending.id(), pending.primitives());
            let callbacks = pending.into_callbacks(self.extent);
            let geometry = Geometry::new(&self, raw::RTC_GEOMETRY_TYPE_USER, id)?;
            // SAFETY: the geometry is alive; `callbacks` is kept in `owned.users`, which is dropped after the scene
            // and never changed.
            unsafe { raw::pde_set_user(geometry.raw(), callbacks.as_ptr(), primitives) };
            // Kept before the scene can reach it, so that no early return frees it under Embree.
            self.owned.users.push(callbacks);
            geometry.attach(&self)?;
        }
        // SAFETY: the scene is alive and ours alone.
        unsafe { raw::rtcCommitScene(self.owned.scene) };
        self.device().check()?;
        let Self { owned, extent, interval, has_instances, .. } = self;
        Ok(CommittedScene { owned, extent, interval, has_instances })
    }

    pub(crate) fn device(&self) -> &Device {
        &self.owned.device
    }

    pub(crate) fn interval(&self) -> Interval {
        self.interval
    }

    pub(crate) fn raw(&self) -> raw::RTCScene {
        self.owned.scene
    }

    pub(crate) fn require_free(&self, id: u32) -> Result<(), SceneError> {
        if id > MAX_GEOMETRY_ID {
            return Err(SceneError::IdTooLarge { geometry: id });
        }
        if self.ids.contains(&id) { Err(SceneError::DuplicateId { geometry: id }) } else { Ok(()) }
    }

    pub(crate) fn occupy(&mut self, id: u32, extent: f64) {
        self.ids.insert(id);
        self.extent = self.extent.max(extent);
    }
}

/// A scene that can be traced, from any number of threads at once, and not changed any more.
pub struct CommittedScene {
    owned: Owned,
    extent: f64,
    interval: Interval,
    has_instances: bool,
}

// SAFETY: after the commit no call modifies the scene; Embree documents tracing a committed scene from several threads
// as safe, per-ray state lives on the caller's stack, and user geometries are Send + Sync by their trait. Releasing
// the last reference may happen on any thread.
unsafe impl Send for CommittedScene {}
// SAFETY: as for Send; `&CommittedScene` gives only tracing.
unsafe impl Sync for CommittedScene {}

impl CommittedScene {
    /// The handle, alive as long as `self`. For this crate's ABI tests.
    #[doc(hidden)]
    pub fn raw(&self) -> raw::RTCScene {
        self.owned.scene
    }

    pub(crate) fn interval(&self) -> Interval {
        self.interval
    }
}

impl fmt::Debug for SceneBuilder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SceneBuilder({} geometries)", self.ids.len())
    }
}

impl fmt::Debug for CommittedScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CommittedScene(within {:e} of 0)", self.extent)
    }
}

/// Largest coordinate of the transformed scene, or `None` where the scene or a ray transformed back leaves f32's range.
fn instance_extent(rows: &[[f32; 4]; 3], extent: f64) -> Option<f64> {
    let rows = rows.map(|row| row.map(f64::from));
    let [a, b, c] = rows.map(|[x, y, z, _]| [x, y, z]);
    let translation = rows.map(|row| row[3].abs()).into_iter().fold(0.0, f64::max);
    let cross =
        |p: [f64; 3], q: [f64; 3]| [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    // Columns of the adjugate; the inverse of the linear part is adjugate / determinant.
    let columns = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = a.iter().zip(&columns[0]).map(|(x, y)| x * y).sum::<f64>();
    let norm = |matrix: &[[f64; 3]; 3]| -> f64 { matrix.iter().flatten().map(|entry| entry.abs()).sum() };
    let inverse_norm = norm(&columns) / determinant.abs();
    let image = norm(&[a, b, c]) * extent + translation;
    // Comparisons written so that a NaN fails.
    let fits = determinant != 0.0
        && image <= MAX_COORDINATE
        && inverse_norm * (MAX_COORDINATE + translation) <= MAX_INSTANCE_COORDINATE;
    fits.then_some(image)
}
