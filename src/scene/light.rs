//! Light sources as the scene file names them.

use std::sync::Arc;

use super::ids::ObjectId;
use super::panorama::Panorama;
use crate::math::{Dir3, Point3, Vec3};
use crate::radiometry::Spectrum;

/// The cross-section of a collimated beam, perpendicular to its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BeamExtent {
    /// As wide as the scene.
    Unbounded,
    /// Half axes `a` ⟂ `b` about `centre`, metres.
    Rectangle {
        centre: Point3,
        a: Vec3,
        b: Vec3,
    },
    Disk {
        centre: Point3,
        radius: f64,
    },
}

/// A light source.
#[derive(Clone, Debug, PartialEq)]
pub enum LightSource {
    /// `intensity` in W/sr, the same in all directions.
    Point { position: Point3, intensity: Spectrum },
    /// `intensity` W/sr inside `cos_inner`, falling smoothly to 0 at `cos_outer` (both cosines of half angles).
    Spot { position: Point3, direction: Dir3, intensity: Spectrum, cos_inner: f64, cos_outer: f64 },
    /// Parallel light travelling along `direction`; `irradiance` in W/m² on a plane perpendicular to it.
    Directional { direction: Dir3, irradiance: Spectrum, extent: BeamExtent },
    /// A diffuse emitter: `radiance` in W/(m²·sr) on the side of the geometric normal, or on both sides.
    Area { object: ObjectId, radiance: Spectrum, two_sided: bool },
    /// The same `radiance` in W/(m²·sr) from everywhere.
    Environment { radiance: Spectrum },
    /// From everywhere, by an image.
    Panorama(Arc<Panorama>),
}
