//! Camera and film as the scene file names them. Right-handed: the camera looks along `target − position`.

use crate::math::{Point3, Vec3};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraModel {
    /// `fov_x`: full horizontal angle in radians.
    Perspective { fov_x: f64 },
    /// `width`: metres across the picture.
    Orthographic { width: f64 },
    /// A perspective camera with a lens of `lens_radius` m, sharp at `focus_distance` m along the view axis.
    ThinLens { fov_x: f64, lens_radius: f64, focus_distance: f64 },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFilter {
    /// Plain average over the pixel.
    Box,
    /// Gaussian of standard deviation half a pixel, cut at 1.5 pixels, importance-sampled.
    Gaussian,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSettings {
    pub model: CameraModel,
    pub position: Point3,
    pub target: Point3,
    pub up: Vec3,
    /// Pixels (width, height); pixels are square.
    pub resolution: [u32; 2],
    pub filter: PixelFilter,
}
