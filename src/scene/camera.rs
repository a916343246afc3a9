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

/// When light falls on the film, s. An instant where nothing moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    pub open: f64,
    /// Not before `open`.
    pub close: f64,
}

impl Shutter {
    pub fn instant(time: f64) -> Shutter {
        Shutter { open: time, close: time }
    }
    pub fn is_instant(&self) -> bool {
        self.open == self.close
    }
    /// The time at the share `u` of the interval.
    pub fn time(&self, u: f64) -> f64 {
        self.open + u * self.exposure()
    }
    /// Which share of the interval lies before `time`; a half for an instant.
    pub fn share(&self, time: f64) -> f64 {
        if self.is_instant() { 0.5 } else { (time - self.open) / self.exposure() }
    }
    pub fn middle(&self) -> f64 {
        self.time(0.5)
    }
    /// How long it is open.
    pub fn exposure(&self) -> f64 {
        self.close - self.open
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct CameraSettings {
    pub model: CameraModel,
    pub position: Point3,
    pub target: Point3,
    pub up: Vec3,
    /// Pixels (width, height); pixels are square.
    pub resolution: [u32; 2],
    pub filter: PixelFilter,
    /// Two or more in the order of time, if it moves while the shutter is open: then the place above is that in the middle.
    pub motion: Vec<CameraKey>,
}

/// A camera's place at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraKey {
    /// s.
    pub time: f64,
    pub position: Point3,
    pub target: Point3,
    pub up: Vec3,
}

impl CameraKey {
    /// Between the keys that stand in the order of time every number changes linearly; before the first and after the last
    /// of them it stays.
    pub fn at(keys: &[CameraKey], time: f64) -> Option<CameraKey> {
        let later = keys.iter().take_while(|key| key.time <= time).count();
        let (Some(from), Some(to)) = (keys.get(later.saturating_sub(1)), keys.get(later).or(keys.last())) else {
            return None;
        };
        let span = to.time - from.time;
        let s = if span > 0.0 { (time - from.time) / span } else { 0.0 };
        let between = |a: Vec3, b: Vec3| a + (b - a) * s;
        Some(CameraKey {
            time,
            position: Point3::from_vec(between(from.position.to_vec(), to.position.to_vec())),
            target: Point3::from_vec(between(from.target.to_vec(), to.target.to_vec())),
            up: between(from.up, to.up),
        })
    }
}

impl CameraSettings {
    /// The camera as it is at `time`.
    pub fn at(&self, time: f64) -> CameraSettings {
        match CameraKey::at(&self.motion, time) {
            None => self.clone(),
            Some(CameraKey { position, target, up, .. }) => {
                CameraSettings { position, target, up, motion: Vec::new(), ..*self }
            }
        }
    }
}
