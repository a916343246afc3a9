//! Queries: nearest hit and any hit of one ray.
//!
//! Interval `[t_near, t_far]` in multiples of the direction. Triangles are tested in f32: their `t` is an f32 number
//! that lies in the f64 interval. User geometries answer in f64 (see `user.rs`).

use crate::error::InvalidRay;
use crate::raw;
use crate::replay::Query;
use crate::scene::{CommittedScene, Interval, MAX_COORDINATE};
use crate::user::widened;

/// Largest component of a ray's direction.
pub const MAX_DIRECTION: f64 = 1e10;

/// Smallest magnitude of the largest component of a ray's direction: the f32 ray needs its reciprocal.
pub const MIN_DIRECTION: f64 = 1e-10;

/// A ray segment, in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin, in the scene's unit, each component at most [`MAX_COORDINATE`] from 0.
    pub origin: [f64; 3],
    /// Direction, of any length between [`MIN_DIRECTION`] and [`MAX_DIRECTION`].
    pub direction: [f64; 3],
    /// Start of the segment in multiples of `direction`, at least 0.
    pub t_near: f64,
    /// End of the segment in multiples of `direction`; infinity is allowed, an end before the start hits nothing.
    pub t_far: f64,
    /// When the ray flies. User geometries see it as it is; to moving meshes times outside of the scene's interval are its
    /// nearer end.
    pub time: f64,
}

/// The nearest hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in multiples of the ray's direction; an f32 number for triangles, full f64 for user geometries.
    pub t: f64,
    /// Barycentric weight of a triangle's second vertex, or the user geometry's own parameter.
    pub u: f64,
    /// Barycentric weight of a triangle's third vertex, or the user geometry's own parameter.
    pub v: f64,
    /// The caller's id of the geometry, within the instanced scene where `instance` is given.
    pub geometry: u32,
    /// Triangle or user primitive.
    pub primitive: u32,
    /// The user geometry's own number of what was hit in its primitive; 0 for triangles.
    pub part: u32,
    /// The caller's id of the instance, where the hit is in one.
    pub instance: Option<u32>,
}

impl Ray {
    /// Whether Embree can trace this ray.
    ///
    /// # Errors
    /// What is wrong with it; see the limits at the fields.
    pub fn validate(&self) -> Result<(), InvalidRay> {
        // Every comparison is written so that a NaN fails.
        if !self.origin.iter().all(|x| x.abs() <= MAX_COORDINATE) {
            return Err(InvalidRay::Origin);
        }
        if !self.direction.iter().all(|x| x.abs() <= MAX_DIRECTION) {
            return Err(InvalidRay::Direction);
        }
        if !self.direction.iter().any(|x| x.abs() >= MIN_DIRECTION) {
            return Err(InvalidRay::ShortDirection);
        }
        if !(self.t_near >= 0.0 && self.t_near <= f64::from(f32::MAX)) {
            return Err(InvalidRay::TNear);
        }
        if self.t_far.is_nan() {
            return Err(InvalidRay::TFar);
        }
        Ok(())
    }

    /// Whether it can be traced and is not empty.
    pub(crate) fn can_hit(&self) -> bool {
        self.validate().is_ok() && !self.is_empty()
    }

    /// What the library is given for a query.
    pub(crate) fn laid_out(&self, query: Query, interval: Interval) -> (raw::PdeRayHit, raw::PdeRecord) {
        let t_far = match query {
            // Widened for the culling of user geometries; a triangle in the slack is refused afterwards.
            Query::Intersect => widened(self.t_far),
            // Any triangle ends the query, so its end is exact: no f32 lies between the rounded and the f64 end.
            Query::Occluded => rounded_down(self.t_far),
        };
        (self.to_f32(t_far, interval.clamped(self.time)), self.to_record())
    }

    fn is_empty(&self) -> bool {
        self.t_near > self.t_far
    }

    /// The f32 ray, its end given. The start is rounded up: an f32 `t` behind it is behind the f64 start too.
    fn to_f32(self, t_far: f32, time: f32) -> raw::PdeRayHit {
        raw::PdeRayHit {
            org: self.origin.map(|x| x as f32),
            t_near: rounded_up(self.t_near),
            dir: self.direction.map(|x| x as f32),
            time,
            t_far,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            ng: [0.0; 3],
            u: 0.0,
            v: 0.0,
            prim_id: raw::PDE_INVALID_ID,
            geom_id: raw::PDE_INVALID_ID,
            inst_id: raw::PDE_INVALID_ID,
            inst_prim_id: raw::PDE_INVALID_ID,
        }
    }

    fn to_record(self) -> raw::PdeRecord {
        raw::PdeRecord {
            org: self.origin,
            dir: self.direction,
            t_near: self.t_near,
            time: self.time,
            t_far: self.t_far,
            u: 0.0,
            v: 0.0,
            geom_id: raw::PDE_INVALID_ID,
            prim_id: raw::PDE_INVALID_ID,
            part: 0,
            t_far_f32: 0.0,
        }
    }
}

impl CommittedScene {
    /// The nearest hit of a ray.
    ///
    /// # Errors
    /// When the ray cannot be traced: nothing was called, and the caller should count it.
    pub fn intersect(&self, ray: &Ray) -> Result<Option<Hit>, InvalidRay> {
        ray.validate()?;
        if ray.is_empty() {
            return Ok(None);
        }
        let (mut rayhit, mut record) = ray.laid_out(Query::Intersect, self.interval());
        // SAFETY: the scene is committed and alive. `rayhit` has the largest layout of all Embree versions and its
        // alignment. The ray is finite and bounded. `record` outlives the call, and only callbacks of this call use it.
        unsafe { raw::pde_intersect1(self.raw(), &raw mut rayhit, &raw mut record) };
        Ok(nearest(&rayhit, &record, ray.t_far))
    }

    /// Whether anything lies in the ray's segment.
    ///
    /// # Errors
    /// As [`CommittedScene::intersect`].
    pub fn occluded(&self, ray: &Ray) -> Result<bool, InvalidRay> {
        ray.validate()?;
        if ray.is_empty() {
            return Ok(false);
        }
        let (mut rayhit, mut record) = ray.laid_out(Query::Occluded, self.interval());
        // SAFETY: as in `intersect`; an occlusion query touches only the ray part.
        unsafe { raw::pde_occluded1(self.raw(), &raw mut rayhit, &raw mut record) };
        Ok(rayhit.t_far == f32::NEG_INFINITY)
    }
}

/// The nearer of Embree's last hit and the user record, compared in f64.
fn nearest(rayhit: &raw::PdeRayHit, record: &raw::PdeRecord, t_far: f64) -> Option<Hit> {
    // An accepted user hit sets the geometry too, so this is a miss of everything.
    if rayhit.geom_id == raw::PDE_INVALID_ID {
        return None;
    }
    let instance = (rayhit.inst_id != raw::PDE_INVALID_ID).then_some(rayhit.inst_id);
    let t = f64::from(rayhit.t_far);
    if record.geom_id != raw::PDE_INVALID_ID {
        let last_is_user = instance.is_none() && rayhit.geom_id == record.geom_id;
        // Embree may have taken a triangle from the slack behind the user hit.
        if last_is_user || record.t_far <= t {
            return Some(Hit {
                t: record.t_far,
                u: record.u,
                v: record.v,
                geometry: record.geom_id,
                primitive: record.prim_id,
                part: record.part,
                instance: None,
            });
        }
    }
    let hit = Hit {
        t,
        u: f64::from(rayhit.u),
        v: f64::from(rayhit.v),
        geometry: rayhit.geom_id,
        primitive: rayhit.prim_id,
        part: 0,
        instance,
    };
    (t <= t_far).then_some(hit)
}

/// The smallest f32 that is not below `x`.
fn rounded_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// The largest f32 that is not above `x`.
fn rounded_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

#[cfg(test)]
mod tests {
    use super::{rounded_down, rounded_up, widened};

    #[test]
    fn directed_rounding_brackets_every_f64() {
        for x in [0.0, 1.0, 0.1, 1.0 + f64::EPSILON, 1e-300, 3.5e38, 1e30 / 3.0, f64::INFINITY] {
            let (below, above) = (rounded_down(x), rounded_up(x));
            assert!(f64::from(below) <= x && x <= f64::from(above), "{below} <= {x} <= {above}");
            assert!(below == above || below.next_up() == above, "no f32 between {below} and {above} but they differ");
        }
    }

    #[test]
    fn a_widened_end_is_behind_the_hit() {
        for t in [0.0, 1e-300, 1e-12, 0.1, 1.0, 1e10, 1e300, f64::INFINITY] {
            let end = widened(t);
            assert!(f64::from(end) > t || end == f32::INFINITY, "{end} after {t}");
        }
    }
}
