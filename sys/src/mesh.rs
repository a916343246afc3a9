//! Geometries: triangle meshes in Embree's own buffers, and the handle all geometries share.
//!
//! Embree accepts NaN vertices and wild indices silently, and drops or reads what it likes; so they are refused here.

use crate::error::SceneError;
use crate::raw;
use crate::scene::{MAX_COORDINATE, SceneBuilder};

/// Frames that a moving mesh can have.
pub const MAX_TIME_STEPS: usize = raw::RTC_MAX_TIME_STEP_COUNT as usize;

/// A geometry under construction; attaching it to a scene makes the scene a second owner.
pub(crate) struct Geometry {
    geometry: raw::RTCGeometry,
    id: u32,
}

impl Geometry {
    /// A new geometry that answers every ray mask and is built with medium quality.
    pub(crate) fn new(builder: &SceneBuilder, kind: raw::RTCGeometryType, id: u32) -> Result<Self, SceneError> {
        // SAFETY: the device is alive, and `kind` is one of Embree's constants.
        let geometry = unsafe { raw::rtcNewGeometry(builder.device().raw(), kind) };
        if geometry.is_null() {
            return Err(builder.device().failure().into());
        }
        let geometry = Self { geometry, id };
        // SAFETY: the geometry is alive. The default mask is all ones in Embree 3, but 1 in Embree 4.
        unsafe {
            raw::rtcSetGeometryMask(geometry.raw(), u32::MAX);
            raw::rtcSetGeometryBuildQuality(geometry.raw(), raw::RTC_BUILD_QUALITY_MEDIUM);
        }
        Ok(geometry)
    }

    pub(crate) fn raw(&self) -> raw::RTCGeometry {
        self.geometry
    }

    /// Commits the geometry and hands it to the scene under its id.
    pub(crate) fn attach(self, builder: &SceneBuilder) -> Result<(), SceneError> {
        // SAFETY: geometry and scene are alive and of the same device; the builder is the scene's only user.
        unsafe {
            raw::rtcCommitGeometry(self.geometry);
            raw::rtcAttachGeometryByID(builder.raw(), self.geometry, self.id);
        }
        Ok(builder.device().check()?)
    }

    /// Fills a new buffer of Embree's, which is padded as its vector loads need it.
    fn fill<T: Copy>(
        &self,
        builder: &SceneBuilder,
        buffer: raw::RTCBufferType,
        slot: u32,
        format: raw::RTCFormat,
        items: &[[T; 3]],
    ) -> Result<(), SceneError> {
        const { assert!(size_of::<T>() == 4) };
        let stride = size_of::<[T; 3]>();
        // SAFETY: the geometry is alive; slot 0 exists for index and vertex buffers of a mesh, and further slots for the
        // vertices of as many time steps as it was given. Embree refuses other slots by an error and a null pointer.
        let target =
            unsafe { raw::rtcSetNewGeometryBuffer(self.geometry, buffer, slot, format, stride as _, items.len() as _) };
        if target.is_null() {
            return Err(builder.device().failure().into());
        }
        // SAFETY: Embree returned room for `items.len()` items of `stride` bytes, aligned to 4 at least, which
        // nobody else refers to before the commit. `T` is a plain 4-byte number without padding.
        unsafe { target.cast::<[T; 3]>().copy_from_nonoverlapping(items.as_ptr(), items.len()) };
        Ok(())
    }
}

impl Drop for Geometry {
    fn drop(&mut self) {
        // SAFETY: this handle's own reference; a scene it was attached to holds another.
        unsafe { raw::rtcReleaseGeometry(self.geometry) };
    }
}

impl SceneBuilder {
    /// Adds a triangle mesh under the caller's id. `vertices` are positions, `triangles` index them.
    ///
    /// Degenerate triangles are kept and never hit. The data are copied.
    ///
    /// # Errors
    /// A taken or too large id, an empty mesh, a vertex that is not finite or beyond [`MAX_COORDINATE`], an index out
    /// of range, or an error of Embree's (memory).
    pub fn add_mesh(&mut self, id: u32, vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<(), SceneError> {
        self.require_free(id)?;
        let extent = validate(id, vertices, triangles)?;
        let geometry = Geometry::new(self, raw::RTC_GEOMETRY_TYPE_TRIANGLE, id)?;
        geometry.fill(self, raw::RTC_BUFFER_TYPE_VERTEX, 0, raw::RTC_FORMAT_FLOAT3, vertices)?;
        geometry.fill(self, raw::RTC_BUFFER_TYPE_INDEX, 0, raw::RTC_FORMAT_UINT3, triangles)?;
        geometry.attach(self)?;
        self.occupy(id, extent);
        Ok(())
    }

    /// Adds a mesh whose vertices move on straight lines from each of `frames` to the next, which are at equal intervals
    /// from `start` to `end` in the ray's unit of time. At other times the mesh is not there: the frames should cover the
    /// scene's interval ([`SceneBuilder::over`]).
    ///
    /// # Errors
    /// As [`SceneBuilder::add_mesh`], and frames that do not fit together.
    pub fn add_moving_mesh(
        &mut self,
        id: u32,
        frames: &[&[[f32; 3]]],
        [start, end]: [f64; 2],
        triangles: &[[u32; 3]],
    ) -> Result<(), SceneError> {
        self.require_free(id)?;
        let [start, end] = [start, end].map(|time| self.interval().place(time) as f32);
        // Comparisons written so that a NaN fails.
        let fit = (2..=MAX_TIME_STEPS).contains(&frames.len())
            && frames.iter().all(|frame| frame.len() == frames[0].len())
            && start.is_finite()
            && end.is_finite()
            && start < end;
        if !fit {
            return Err(SceneError::BadFrames { geometry: id });
        }
        let mut extent = 0.0_f64;
        for frame in frames {
            extent = extent.max(validate(id, frame, triangles)?);
        }
        let geometry = Geometry::new(self, raw::RTC_GEOMETRY_TYPE_TRIANGLE, id)?;
        // SAFETY: the geometry is alive and nobody else's yet; the count is from 2 to Embree's largest, and the range is
        // finite and not empty, which is all that Embree asks of it.
        unsafe {
            raw::rtcSetGeometryTimeStepCount(geometry.raw(), frames.len() as u32);
            raw::rtcSetGeometryTimeRange(geometry.raw(), start, end);
        }
        self.device().check()?;
        for (slot, frame) in (0..).zip(frames) {
            geometry.fill(self, raw::RTC_BUFFER_TYPE_VERTEX, slot, raw::RTC_FORMAT_FLOAT3, frame)?;
        }
        geometry.fill(self, raw::RTC_BUFFER_TYPE_INDEX, 0, raw::RTC_FORMAT_UINT3, triangles)?;
        geometry.attach(self)?;
        self.occupy(id, extent);
        Ok(())
    }
}

/// The largest coordinate's magnitude of a mesh that Embree can take.
fn validate(geometry: u32, vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<f64, SceneError> {
    if vertices.is_empty() || triangles.is_empty() {
        return Err(SceneError::Empty { geometry });
    }
    let countable = |length: usize| u32::try_from(length).is_ok();
    if !countable(vertices.len()) || !countable(triangles.len()) {
        return Err(SceneError::TooLarge { geometry });
    }
    let mut extent = 0.0_f64;
    for (vertex, &position) in vertices.iter().enumerate() {
        for coordinate in position.map(f64::from) {
            if coordinate.is_nan() || coordinate.abs() > MAX_COORDINATE {
                return Err(SceneError::BadVertex { geometry, vertex, position });
            }
            extent = extent.max(coordinate.abs());
        }
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertices.len()) {
            return Err(SceneError::BadIndex { geometry, triangle, index, vertices: vertices.len() });
        }
    }
    Ok(extent)
}
