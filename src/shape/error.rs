//! Why a shape cannot be built.

use crate::math::{Point3, Vec3};

/// A parameter that makes no shape. The message names the parameter and says what it must be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    #[error("the {what} is {value}; it must be a finite number greater than 0")]
    NotPositive { what: &'static str, value: f64 },
    #[error("the {what} holds a number that is infinite or not a number")]
    NotFinite { what: &'static str },
    #[error("the {what} has no length; it must point somewhere")]
    NoLength { what: &'static str },
    #[error("the {first} and the {second} are not perpendicular (the cosine of their angle is {cosine:.3e})")]
    NotPerpendicular { first: &'static str, second: &'static str, cosine: f64 },
    #[error("the {first} and the {second} are parallel; they must span a plane")]
    Parallel { first: &'static str, second: &'static str },
    #[error(
        "the minor radius {minor} is not less than the major radius {major}; such a torus would pass through itself"
    )]
    SelfIntersecting { major: f64, minor: f64 },
}

pub(super) fn positive(what: &'static str, value: f64) -> Result<f64, ShapeError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(ShapeError::NotPositive { what, value }) }
}

pub(super) fn finite_point(what: &'static str, p: Point3) -> Result<Point3, ShapeError> {
    if p.is_finite() { Ok(p) } else { Err(ShapeError::NotFinite { what }) }
}

/// Splits a vector into its unit direction and its length.
pub(super) fn direction(what: &'static str, v: Vec3) -> Result<(Vec3, f64), ShapeError> {
    if !v.is_finite() {
        return Err(ShapeError::NotFinite { what });
    }
    // Scaling by the largest coordinate first keeps the squares of very short and very long vectors representable.
    let scale = v.abs().max_element();
    if scale == 0.0 {
        return Err(ShapeError::NoLength { what });
    }
    let scaled = v / scale;
    Ok((scaled.normalize(), scaled.length() * scale))
}
