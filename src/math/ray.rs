//! Rays.

use super::vector::{Dir3, Point3, Vec3};

/// The points `origin + t · direction` for t in (t_min, t_max). World rays have unit directions, so t is metres there;
/// in an object's own space the direction keeps the length that the inverse transform gives it, so t is the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: Point3,
    pub direction: Vec3,
    pub t_min: f64,
    pub t_max: f64,
    /// When it flies, s: where things are that move. All times are the same where nothing does.
    pub time: f64,
}

impl Ray {
    pub fn new(origin: Point3, direction: Dir3) -> Ray {
        Ray { origin, direction: direction.to_vec(), t_min: 0.0, t_max: f64::INFINITY, time: 0.0 }
    }
    /// The same at another time.
    pub fn at_time(self, time: f64) -> Ray {
        Ray { time, ..self }
    }
    /// The open segment between two points, the far end pulled in by the relative `margin`, for visibility tests.
    pub fn between(from: Point3, to: Point3, margin: f64) -> Option<Ray> {
        let distance = from.distance(to);
        let direction = Dir3::new(to - from)?;
        Some(Ray { t_max: distance * (1.0 - margin), ..Ray::new(from, direction) })
    }
    pub fn at(&self, t: f64) -> Point3 {
        self.origin + self.direction * t
    }
}
