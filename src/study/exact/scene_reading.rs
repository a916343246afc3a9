//! What all closed forms read from a scene: two objects in place, a matt receiver, one beam, and an orthographic picture
//! straight on the receiver.

use std::f64::consts::FRAC_1_PI;

use super::NotThisForm;
use crate::camera::Camera;
use crate::math::{Dir3, Point2, Point3, Transform, Vec2, Vec3};
use crate::radiometry::Spectrum;
use crate::scene::camera::PixelFilter;
use crate::scene::light::BeamExtent;
use crate::scene::{CameraModel, LightSource, Material, Object, ObjectGeometry, Scene, Textured};
use crate::shape::{Rectangle, Shape};

/// Numbers of the scene that agree to this part of themselves are the same.
const SAME: f64 = 1e-9;

pub fn require(holds: bool, otherwise: impl Fn() -> String) -> Result<(), NotThisForm> {
    if holds { Ok(()) } else { Err(NotThisForm(otherwise())) }
}

pub fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs()).max(1.0)
}

/// The closed forms end on the receiver, and a pixel is its plain average.
pub fn ends_on_receiver(scene: &Scene) -> Result<(), NotThisForm> {
    require(scene.settings.max_bounces == 0, || {
        format!("render.max_bounces is {}; the closed form holds none", scene.settings.max_bounces)
    })?;
    require(scene.camera.filter == PixelFilter::Box, || "the pixel filter is not the box".to_owned())
}

pub fn rectangle(shape: &Shape) -> Option<&Rectangle> {
    if let Shape::Rectangle(rectangle) = shape { Some(rectangle) } else { None }
}

/// The one object of a kind, of the two that are `both`, and its material.
pub fn only<'s, T>(
    scene: &'s Scene,
    both: &str,
    kind: &str,
    of: impl Fn(&'s Shape) -> Option<&'s T>,
) -> Result<(&'s T, &'s Material), NotThisForm> {
    require(scene.shutter.is_instant(), || "something moves while the shutter is open".to_owned())?;
    require(scene.objects.len() == 2, || format!("there are {} objects instead of {both}", scene.objects.len()))?;
    let in_place = |object: &'s Object| match &object.geometry {
        ObjectGeometry::Shape { shape, to_world } if *to_world == Transform::IDENTITY => {
            Some((of(shape)?, &scene.materials[object.material.index()]))
        }
        _ => None,
    };
    let mut found = scene.objects.iter().filter_map(in_place);
    found.next().ok_or_else(|| NotThisForm(format!("there is no {kind} without a transform")))
}

/// Radiance of a matt receiver under the irradiance 1.
pub fn brdf(receiver: &Material) -> Result<Spectrum, NotThisForm> {
    match receiver {
        Material::Lambert { albedo: Textured::Constant(albedo) } => Ok(*albedo * FRAC_1_PI),
        _ => Err(NotThisForm("the receiver is not of one matt colour".to_owned())),
    }
}

/// Parallel light.
pub struct Beam<'s> {
    pub direction: Vec3,
    /// On a plane across the beam.
    pub irradiance: Spectrum,
    pub extent: &'s BeamExtent,
}

pub fn beam(scene: &Scene) -> Result<Beam<'_>, NotThisForm> {
    match scene.lights.as_slice() {
        [LightSource::Directional { direction, irradiance, extent }] => {
            Ok(Beam { direction: direction.to_vec(), irradiance: *irradiance, extent })
        }
        _ => Err(NotThisForm("the light is not one beam".to_owned())),
    }
}

/// What an orthographic picture shows of a plane that it looks straight on.
pub struct View {
    /// Where the camera looks.
    pub forward: Vec3,
    /// The picture's top left corner on the receiver.
    pub corner: Point3,
    /// One pixel.
    pub right: Vec3,
    pub down: Vec3,
    /// Metres from the camera to the receiver.
    pub distance: f64,
    pub resolution: [u32; 2],
}

impl View {
    /// The picture of `receiver` by a camera that looks along `forward`.
    pub fn along(forward: Vec3, scene: &Scene, receiver: &Rectangle) -> Result<View, NotThisForm> {
        let askew = || "the camera is not orthographic and straight on the receiver's lit side".to_owned();
        require(matches!(scene.camera.model, CameraModel::Orthographic { .. }), askew)?;
        let camera = Camera::new(&scene.camera).ok_or_else(|| NotThisForm(askew()))?;
        let ray = |x: f64, y: f64| camera.ray(Point2::new(x, y), Vec2::ZERO).ray;
        let from = ray(0.0, 0.0);
        let looks: Dir3 = receiver.normal().as_dir();
        require(same(from.direction.dot(forward), 1.0) && same(looks.dot(forward).abs(), 1.0), askew)?;
        let distance = (receiver.centre() - from.origin).dot(forward);
        let view = View {
            forward,
            corner: from.at(distance),
            right: ray(1.0, 0.0).origin - from.origin,
            down: ray(0.0, 1.0).origin - from.origin,
            distance,
            resolution: scene.camera.resolution,
        };
        require(distance > 0.0, || "the camera looks away from the receiver".to_owned())?;
        Ok(view)
    }

    pub fn shows_only(&self, receiver: &Rectangle) -> Result<(), NotThisForm> {
        let [width, height] = self.resolution.map(f64::from);
        let corners = [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)];
        let within = corners.into_iter().all(|(x, y)| {
            let p = self.corner + self.right * x + self.down * y - receiver.centre();
            receiver.half_axes().iter().all(|axis| p.dot(*axis).abs() <= axis.length_squared() * (1.0 + SAME))
        });
        require(within, || "the picture shows more than the receiver".to_owned())
    }

    /// Metres.
    pub fn pixel(&self) -> f64 {
        self.right.length()
    }

    /// A point of the receiver in pixels from the top left corner.
    pub fn raster(&self, p: Point3) -> [f64; 2] {
        self.raster_vector(p - self.corner)
    }

    pub fn raster_vector(&self, v: Vec3) -> [f64; 2] {
        [v.dot(self.right), v.dot(self.down)].map(|x| x / self.right.length_squared())
    }
}
