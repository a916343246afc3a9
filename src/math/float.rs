//! Rounding at the door between `f64` shading and `f32` ray libraries.

use super::vector::{Normal3, Point3, Vec3};

/// Unit roundoff of `f32`.
const F32_ROUNDOFF: f64 = 5.960_464_477_539_063e-8;

/// How far a ray origin at `p` must be moved along the normal so that a library that rounds positions of size
/// `extent` (the largest |coordinate| of the geometry hit and of `p`) to `f32` cannot find the surface it left.
///
/// A vertex and the origin are each rounded by at most `extent`·2⁻²⁴ per coordinate, the robust triangle test adds a
/// few more of the same size; 16 covers the sum of three coordinates of both with a factor 2 to spare.
pub fn origin_offset(extent: f64) -> f64 {
    16.0 * F32_ROUNDOFF * extent
}

/// Moves `p` off its surface to the side of `w`.
pub fn offset_ray_origin(p: Point3, error: f64, ng: Normal3, w: impl Into<Vec3>) -> Point3 {
    let side = 1.0f64.copysign(ng.dot(w));
    p + ng * (side * error)
}
