//! From the film to rays and back: pixel → ray with its differential, point → pixel for light paths.
//!
//! Raster coordinates count pixels from the top left corner; the differential's two columns are derivatives by one
//! pixel in raster x and y.

mod filter;

use std::borrow::Cow;

use crate::differential::{Column, Differential};
use crate::math::{Dir3, Frame, Normal3, Point2, Point3, Ray, Vec2, Vec3};
use crate::scene::{CameraModel, CameraSettings};

pub use filter::filter_offset;

/// A ray from the film.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    pub ray: Ray,
    /// The unit direction of `ray`.
    pub direction: Dir3,
    pub differential: Differential<2>,
}

/// A point seen from the camera, for light tracing.
#[derive(Clone, Copy, Debug)]
pub struct Connection {
    pub raster: Point2,
    /// On the lens.
    pub origin: Point3,
    /// From the point towards the camera.
    pub w: Dir3,
    /// Radiance leaving the point along `w` times this times |cos| at the point, per watt arriving there, is the
    /// point's contribution to the mean over one pixel: We(x, w) · G without the point's cosine, 1/m².
    pub importance: f64,
}

/// A camera placed in the world.
#[derive(Clone, Debug)]
pub struct Camera {
    position: Point3,
    /// Right, down, forward.
    right: Vec3,
    down: Vec3,
    forward: Dir3,
    model: CameraModel,
    /// Width of a pixel: on the plane at distance 1 for perspective, in metres for orthographic.
    pixel: f64,
    half: Vec2,
    /// Of a camera that moves: this one is that of the middle of the shutter's interval.
    moving: Option<Box<CameraSettings>>,
}

impl Camera {
    /// `None` if position, target and up do not span a frame.
    pub fn new(settings: &CameraSettings) -> Option<Camera> {
        let forward = Dir3::new(settings.target - settings.position)?;
        let right = Dir3::new(forward.cross(settings.up))?.to_vec();
        let down = forward.cross(right);
        let [width, height] = settings.resolution.map(f64::from);
        let across = match settings.model {
            CameraModel::Perspective { fov_x } | CameraModel::ThinLens { fov_x, .. } => 2.0 * (0.5 * fov_x).tan(),
            CameraModel::Orthographic { width } => width,
        };
        let half = Vec2::new(0.5 * width, 0.5 * height);
        let (position, model) = (settings.position, settings.model);
        let moving = (!settings.motion.is_empty()).then(|| Box::new(settings.clone()));
        Some(Camera { position, right, down, forward, model, pixel: across / width, half, moving })
    }

    /// The camera as it is at `time`; assembly refuses places that it cannot have.
    pub fn at(&self, time: f64) -> Cow<'_, Camera> {
        let moved = self.moving.as_ref().and_then(|settings| Camera::new(&settings.at(time)));
        moved.map_or(Cow::Borrowed(self), Cow::Owned)
    }

    /// The ray through `raster` from the point `lens` of the unit disc on the lens (ignored by pinholes).
    pub fn ray(&self, raster: Point2, lens: Vec2) -> CameraRay {
        let offset = (raster - self.half) * self.pixel;
        let across = self.right * offset.x + self.down * offset.y;
        let (dx, dy) = (self.right * self.pixel, self.down * self.pixel);
        match self.model {
            CameraModel::Orthographic { .. } => {
                let columns = [Column::position(dx), Column::position(dy)];
                self.assemble(self.position + across, self.forward.to_vec(), columns)
            }
            CameraModel::Perspective { .. } => self.assemble(
                self.position,
                self.forward.to_vec() + across,
                [Column::direction(dx), Column::direction(dy)],
            ),
            CameraModel::ThinLens { lens_radius, focus_distance, .. } => {
                let on_lens = (self.right * lens.x + self.down * lens.y) * lens_radius;
                let towards = self.forward.to_vec() + across - on_lens / focus_distance;
                self.assemble(self.position + on_lens, towards, [Column::direction(dx), Column::direction(dy)])
            }
        }
    }

    /// Normalises the direction, inside the derivative too [Igehy99 (8)].
    fn assemble(&self, origin: Point3, towards: Vec3, columns: [Column; 2]) -> CameraRay {
        let length = towards.length();
        let w = towards / length;
        let unit = |c: Column| Column { dx: c.dx, dw: (c.dw - w * w.dot(c.dw)) / length };
        let direction = Dir3::from_unit(w);
        CameraRay { ray: Ray::new(origin, direction), direction, differential: Differential::new(columns.map(unit)) }
    }

    /// How the camera sees `p` from the point `lens` of the unit disc, or `None` if it lies behind. The caller tests
    /// whether the raster point is on the film.
    pub fn connect(&self, p: Point3, lens: Vec2) -> Option<Connection> {
        let pixel_area = self.pixel * self.pixel;
        let origin = match self.model {
            CameraModel::Orthographic { .. } => {
                let depth = (p - self.position).dot(self.forward.to_vec());
                let raster = self.raster(p - self.position);
                return (depth > 0.0).then(|| Connection {
                    raster,
                    origin: p - self.forward * depth,
                    w: -self.forward,
                    importance: 1.0 / pixel_area,
                });
            }
            CameraModel::Perspective { .. } => self.position,
            CameraModel::ThinLens { lens_radius, .. } => {
                self.position + (self.right * lens.x + self.down * lens.y) * lens_radius
            }
        };
        let d = p - origin;
        let depth = d.dot(self.forward.to_vec());
        let w = Dir3::new(-d)?;
        if depth <= 0.0 {
            return None;
        }
        let cos = depth / d.length();
        // The plane at distance 1 in front of a pinhole; for a lens the point where the ray meets the plane of focus.
        let across = match self.model {
            CameraModel::ThinLens { focus_distance, .. } => {
                (origin - self.position) / focus_distance + d / depth - self.forward.to_vec()
            }
            _ => d / depth - self.forward.to_vec(),
        };
        // A pixel of area a on the plane at distance 1 subtends a cos³; the receiver's cosine is the caller's.
        let importance = 1.0 / (pixel_area * cos * cos * cos * d.length_squared());
        Some(Connection { raster: self.raster(across), origin, w, importance })
    }

    fn raster(&self, across: Vec3) -> Point2 {
        Vec2::new(across.dot(self.right), across.dot(self.down)) / self.pixel + self.half
    }

    /// Distance along the view axis.
    pub fn depth(&self, p: Point3) -> f64 {
        (p - self.position).dot(self.forward.to_vec())
    }

    /// Right, up, and backward axes: the frame in which camera-space normals are often wanted.
    pub fn frame(&self) -> Frame {
        Frame { t: self.right, b: -self.down, n: Normal3::from_unit(-self.forward.to_vec()).to_vec() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::PixelFilter;

    fn cameras() -> Vec<Camera> {
        [
            CameraModel::Perspective { fov_x: 0.7 },
            CameraModel::Orthographic { width: 3.0 },
            CameraModel::ThinLens { fov_x: 0.7, lens_radius: 0.1, focus_distance: 3.0 },
        ]
        .map(|model| {
            Camera::new(&CameraSettings {
                model,
                position: Point3::new(1.0, 2.0, 3.0),
                target: Point3::new(0.2, -0.3, 0.1),
                up: Vec3::Y,
                resolution: [64, 48],
                filter: PixelFilter::Box,
                motion: vec![],
            })
            .expect("a sound camera")
        })
        .into()
    }

    #[test]
    fn columns_are_the_rays_derivatives() {
        let lens = Vec2::new(0.3, -0.6);
        for camera in cameras() {
            let raster = Vec2::new(12.3, 40.7);
            let ray = camera.ray(raster, lens);
            for (k, step) in [Vec2::X, Vec2::Y].into_iter().enumerate() {
                let h = 1e-4;
                let (a, b) = (camera.ray(raster - step * h, lens), camera.ray(raster + step * h, lens));
                let dx = (b.ray.origin - a.ray.origin) / (2.0 * h);
                let dw = (b.direction.to_vec() - a.direction.to_vec()) / (2.0 * h);
                let column = ray.differential.column(k);
                assert!((column.dx - dx).length() < 1e-9 && (column.dw - dw).length() < 1e-9);
            }
        }
    }

    #[test]
    fn a_point_on_a_ray_connects_to_that_rays_raster_point() {
        let lens = Vec2::new(-0.4, 0.2);
        for camera in cameras() {
            let raster = Vec2::new(50.25, 3.5);
            let ray = camera.ray(raster, lens);
            let connection = camera.connect(ray.ray.at(2.5), lens).expect("in front");
            assert!((connection.raster - raster).length() < 1e-9);
            assert!((connection.w.to_vec() + ray.direction.to_vec()).length() < 1e-12);
            assert!(camera.connect(ray.ray.at(-1.0), lens).is_none());
        }
    }

    /// The picture's top is up and its right is right.
    #[test]
    fn the_picture_is_not_mirrored() {
        let camera = Camera::new(&CameraSettings {
            model: CameraModel::Perspective { fov_x: 1.0 },
            position: Point3::new(0.0, 0.0, 5.0),
            target: Point3::ORIGIN,
            up: Vec3::Y,
            resolution: [100, 100],
            filter: PixelFilter::Box,
            motion: vec![],
        })
        .expect("a sound camera");
        let seen = camera.connect(Point3::new(1.0, 1.0, 0.0), Vec2::ZERO).expect("in front");
        assert!(seen.raster.x > 50.0 && seen.raster.y < 50.0);
    }
}
