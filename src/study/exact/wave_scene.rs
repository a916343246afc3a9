//! Reads a [`Wave`] from a scene: z up, light falling straight down on a wave along x, an orthographic camera below it
//! that looks straight down on the receiver.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, TAU};

use super::wave::Wave;
use super::{ExactPicture, NotThisForm};
use crate::camera::Camera;
use crate::math::{Point2, Transform, Vec2, Vec3};
use crate::radiometry::Spectrum;
use crate::scene::camera::PixelFilter;
use crate::scene::light::BeamExtent;
use crate::scene::{CameraModel, LightSource, Material, Object, ObjectGeometry, Scene, Textured};
use crate::shape::{HeightField, Rectangle, Shape};

/// Numbers of the scene that agree to this part of themselves are the same.
const SAME: f64 = 1e-9;

/// A part of the plane: [from, to] in x and in y, metres.
type Window = [[f64; 2]; 2];

pub(super) fn picture(scene: &Scene) -> Result<ExactPicture, NotThisForm> {
    limits(scene)?;
    let (field, material) = only(scene, "height field", height_field)?;
    let (receiver, paint) = only(scene, "rectangle", rectangle)?;
    let albedo = albedo(scene, paint)?;
    let (irradiance, beam) = beam(scene)?;
    let wave = wave(field, receiver, &scene.materials[material.material.index()])?;
    let view = view(scene, field, receiver)?;
    let (half, centre) = (field.half_size(), field.centre());
    let lit = [beam[0][0].max(centre.x - half.x), beam[0][1].min(centre.x + half.x)];
    let covers = |[from, to]: [f64; 2], [a, b]: [f64; 2]| from <= a && to >= b;
    require(covers(beam[1], view[1]), || "the beam does not cover the whole height of the picture".to_owned())?;
    require(covers([centre.y - half.y, centre.y + half.y], view[1]), || {
        "the wave does not cover the whole height of the picture".to_owned()
    })?;
    let [width, height] = scene.camera.resolution;
    let source = lit.map(|x| x - centre.x);
    let across = view[0].map(|x| x - centre.x);
    let border = |i: u32| across[0] + (across[1] - across[0]) * f64::from(i) / f64::from(width);
    let borders: Vec<f64> = (0..=width).map(border).collect();
    let [fine, coarse] = [16, 8].map(|steps| wave.averages(&borders, source, steps));
    let colour = (irradiance * albedo * FRAC_1_PI).to_array();
    let rows = |values: Vec<f64>| -> Vec<[f64; 3]> {
        let row: Vec<[f64; 3]> = values.iter().map(|e| colour.map(|c| c * e)).collect();
        std::iter::repeat_n(row, height as usize).flatten().collect()
    };
    let error = fine.iter().zip(&coarse).map(|(a, b)| (a - b).abs()).collect();
    Ok(ExactPicture { width, height, radiance: rows(fine), error: rows(error) })
}

fn require(holds: bool, otherwise: impl Fn() -> String) -> Result<(), NotThisForm> {
    if holds { Ok(()) } else { Err(NotThisForm(otherwise())) }
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs()).max(1.0)
}

/// The closed form holds sun → wave → receiver and nothing after it.
fn limits(scene: &Scene) -> Result<(), NotThisForm> {
    let settings = &scene.settings;
    require(settings.max_depth == 2, || {
        format!("render.max_depth is {}; the closed form holds paths of 2 edges", settings.max_depth)
    })?;
    require(settings.max_bounces == 0, || {
        format!("render.max_bounces is {}; the closed form holds none", settings.max_bounces)
    })?;
    require(scene.camera.filter == PixelFilter::Box, || "the pixel filter is not the box".to_owned())
}

fn height_field(shape: &Shape) -> Option<&HeightField> {
    if let Shape::HeightField(field) = shape { Some(field) } else { None }
}

fn rectangle(shape: &Shape) -> Option<&Rectangle> {
    if let Shape::Rectangle(rectangle) = shape { Some(rectangle) } else { None }
}

/// The one object of a kind.
fn only<'s, T>(
    scene: &'s Scene,
    kind: &str,
    of: impl Fn(&'s Shape) -> Option<&'s T>,
) -> Result<(&'s T, &'s Object), NotThisForm> {
    require(scene.objects.len() == 2, || {
        format!("there are {} objects instead of a wave and its receiver", scene.objects.len())
    })?;
    let in_place = |object: &'s Object| match &object.geometry {
        ObjectGeometry::Shape { shape, to_world } if *to_world == Transform::IDENTITY => Some((of(shape)?, object)),
        _ => None,
    };
    let mut found = scene.objects.iter().filter_map(in_place);
    found.next().ok_or_else(|| NotThisForm(format!("there is no {kind} without a transform")))
}

fn albedo(scene: &Scene, receiver: &Object) -> Result<Spectrum, NotThisForm> {
    match &scene.materials[receiver.material.index()] {
        Material::Lambert { albedo: Textured::Constant(albedo) } => Ok(*albedo),
        _ => Err(NotThisForm("the receiver is not of one matt colour".to_owned())),
    }
}

/// Irradiance across the beam and its part of the plane.
fn beam(scene: &Scene) -> Result<(Spectrum, Window), NotThisForm> {
    let [LightSource::Directional { direction, irradiance, extent }] = scene.lights.as_slice() else {
        return Err(NotThisForm("the light is not one beam".to_owned()));
    };
    require(same(direction.to_vec().dot(Vec3::Z), -1.0), || "the beam does not fall along -z".to_owned())?;
    let BeamExtent::Rectangle { centre, a, b } = extent else {
        return Err(NotThisForm("the beam's extent is not a rectangle".to_owned()));
    };
    require(same(a.y, 0.0) && same(b.x, 0.0), || "the beam's sides are not along x and y".to_owned())?;
    let along = |centre: f64, half: f64| [centre - half.abs(), centre + half.abs()];
    Ok((*irradiance, [along(centre.x, a.x), along(centre.y, b.y)]))
}

fn wave(field: &HeightField, receiver: &Rectangle, material: &Material) -> Result<Wave, NotThisForm> {
    let &Material::Dielectric { ior, exterior, fresnel } = material else {
        return Err(NotThisForm("the wave is not of smooth glass".to_owned()));
    };
    let frame = field.frame();
    require(same(frame.n.dot(Vec3::Z), 1.0) && same(frame.t.dot(Vec3::X), 1.0), || {
        "the wave's axes are not x and z".to_owned()
    })?;
    let [wave] = field.waves() else {
        return Err(NotThisForm(format!("there are {} waves instead of one", field.waves().len())));
    };
    require(same(wave.wave_vector.y, 0.0) && wave.wave_vector.x > 0.0, || "the wave does not run along +x".to_owned())?;
    require(same((wave.phase - FRAC_PI_2).rem_euclid(TAU), 0.0), || {
        "the wave's phase is not π/2: its crest is not at its centre".to_owned()
    })?;
    require(same(receiver.normal().as_dir().to_vec().dot(Vec3::Z).abs(), 1.0), || {
        "the receiver is not perpendicular to the beam".to_owned()
    })?;
    Ok(Wave {
        amplitude: wave.amplitude,
        wave_number: wave.wave_vector.x,
        index: ior / exterior,
        receiver: receiver.centre().z - field.centre().z,
        fresnel,
    })
}

/// What the picture shows of the receiver; x to the right.
fn view(scene: &Scene, field: &HeightField, receiver: &Rectangle) -> Result<Window, NotThisForm> {
    let askew = || "the camera is not orthographic along -z with x to the right".to_owned();
    require(matches!(scene.camera.model, CameraModel::Orthographic { .. }), askew)?;
    let camera = Camera::new(&scene.camera).ok_or_else(|| NotThisForm(askew()))?;
    let [width, height] = scene.camera.resolution.map(f64::from);
    let corner = |x: f64, y: f64| camera.ray(Point2::new(x, y), Vec2::ZERO);
    let (first, last, right) = (corner(0.0, 0.0), corner(width, height), corner(width, 0.0));
    require(same(first.direction.to_vec().dot(Vec3::Z), -1.0), askew)?;
    let (from, to) = (first.ray.origin, last.ray.origin);
    require(right.ray.origin.x > from.x && same(right.ray.origin.y, from.y), askew)?;
    let lowest = field.centre().z - field.waves().iter().map(|w| w.amplitude.abs()).sum::<f64>();
    let between = from.z < lowest && from.z > receiver.centre().z;
    require(between, || "the camera does not stand between the wave and the receiver".to_owned())?;
    let window = [[from.x, to.x], [from.y.min(to.y), from.y.max(to.y)]];
    let [a, b] = receiver.half_axes();
    let half = [a.x.abs() + b.x.abs(), a.y.abs() + b.y.abs()];
    let centre = [receiver.centre().x, receiver.centre().y];
    let inside = (0..2).all(|i| window[i][0] >= centre[i] - half[i] && window[i][1] <= centre[i] + half[i]);
    require(inside, || "the picture shows more than the receiver".to_owned())?;
    Ok(window)
}
