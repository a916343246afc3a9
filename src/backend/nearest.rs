//! What the pure-Rust backends share: which of two hits comes first, and which rays are refused.

use std::sync::atomic::{AtomicU64, Ordering};

use super::RawHit;
use super::geometry::MAX_COORDINATE;
use crate::math::Ray;
use crate::scene::ObjectId;

/// Largest component of a direction; the same limits as `embree4_sys`, so that all backends refuse the same rays.
pub const MAX_DIRECTION: f64 = 1e10;
/// The largest component of a direction is at least this.
pub const MIN_DIRECTION: f64 = 1e-10;

/// The first of the hits offered: smallest t, then smallest object, then smallest primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub hit: Option<RawHit>,
    /// Candidates at or beyond this t cannot win any more. One step behind the best hit, so that ties are seen.
    pub end: f64,
}

impl Nearest {
    pub fn before(t_max: f64) -> Nearest {
        Nearest { hit: None, end: t_max }
    }
    /// Takes a hit with t < `end`.
    pub fn offer(&mut self, hit: RawHit) {
        let wins = self.hit.is_none_or(|best| order(&hit) < order(&best));
        if wins {
            self.hit = Some(hit);
            self.end = hit.t.next_up();
        }
    }
}

fn order(hit: &RawHit) -> (f64, ObjectId, u32) {
    (hit.t, hit.object, hit.primitive)
}

/// Lets the rays through that every backend can take, and counts the others.
#[derive(Debug, Default)]
pub(super) struct Gate {
    refused: AtomicU64,
}

impl Gate {
    pub fn admits(&self, ray: &Ray) -> bool {
        let sound = is_valid(ray);
        if !sound {
            self.refuse();
        }
        sound
    }
    pub fn refuse(&self) {
        self.refused.fetch_add(1, Ordering::Relaxed);
    }
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }
}

/// Whether a ray is finite and bounded and its interval starts at 0 or later. An empty interval is valid: it misses.
pub fn is_valid(ray: &Ray) -> bool {
    // Every comparison is written so that a NaN fails.
    let direction = ray.direction.abs();
    ray.origin.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE)
        && direction.to_array().iter().all(|&x| x <= MAX_DIRECTION)
        && direction.max_element() >= MIN_DIRECTION
        && ray.t_min >= 0.0
        && ray.t_min <= f64::from(f32::MAX)
        && !ray.t_max.is_nan()
}
