//! Reads a [`Wave`] from a scene: z up, light falling straight down on a wave along x, an orthographic camera below it
//! that looks straight down on the receiver.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::scene_reading::{Beam, View, beam, brdf, ends_on_receiver, only, rectangle, require, same};
use super::wave::Wave;
use super::{ExactPicture, NotThisForm};
use crate::math::Vec3;
use crate::scene::light::BeamExtent;
use crate::scene::{Material, Scene};
use crate::shape::{HeightField, Rectangle, Shape};

const OBJECTS: &str = "a wave and its receiver";

/// A part of the plane: [from, to] in x and in y, metres.
type Window = [[f64; 2]; 2];

pub(super) fn picture(scene: &Scene) -> Result<ExactPicture, NotThisForm> {
    limits(scene)?;
    let (field, glass) = only(scene, OBJECTS, "height field", height_field)?;
    let (receiver, paint) = only(scene, OBJECTS, "rectangle", rectangle)?;
    let (brdf, light) = (brdf(paint)?, beam(scene)?);
    let beam = lit(&light)?;
    let wave = wave(field, receiver, glass)?;
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
    let colour = (light.irradiance * brdf).to_array();
    let [fine, coarse] = [16, 8].map(|steps| -> Vec<[f64; 3]> {
        let row = wave.averages(&borders, source, steps).into_iter().map(|e| colour.map(|c| c * e)).collect();
        std::iter::repeat_n::<Vec<[f64; 3]>>(row, height as usize).flatten().collect()
    });
    Ok(ExactPicture::new([width, height], fine, &coarse))
}

/// The closed form holds sun → wave → receiver and nothing after it.
fn limits(scene: &Scene) -> Result<(), NotThisForm> {
    require(scene.settings.max_depth == 2, || {
        format!("render.max_depth is {}; the closed form holds paths of 2 edges", scene.settings.max_depth)
    })?;
    ends_on_receiver(scene)
}

fn height_field(shape: &Shape) -> Option<&HeightField> {
    if let Shape::HeightField(field) = shape { Some(field) } else { None }
}

/// The beam's part of the plane.
fn lit(beam: &Beam) -> Result<Window, NotThisForm> {
    require(same(beam.direction.dot(Vec3::Z), -1.0), || "the beam does not fall along -z".to_owned())?;
    let BeamExtent::Rectangle { centre, a, b } = beam.extent else {
        return Err(NotThisForm("the beam's extent is not a rectangle".to_owned()));
    };
    require(same(a.y, 0.0) && same(b.x, 0.0), || "the beam's sides are not along x and y".to_owned())?;
    let along = |centre: f64, half: f64| [centre - half.abs(), centre + half.abs()];
    Ok([along(centre.x, a.x), along(centre.y, b.y)])
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
    let view = View::along(-Vec3::Z, scene, receiver)?;
    require(view.right.x > 0.0 && same(view.right.y, 0.0), || "the picture does not have x to the right".to_owned())?;
    view.shows_only(receiver)?;
    let lowest = field.centre().z - field.waves().iter().map(|w| w.amplitude.abs()).sum::<f64>();
    let camera = view.corner.z + view.distance;
    require(camera < lowest, || "the camera does not stand between the wave and the receiver".to_owned())?;
    let [width, height] = view.resolution.map(f64::from);
    let (from, to) = (view.corner, view.corner + view.right * width + view.down * height);
    Ok([[from.x, to.x], [from.y.min(to.y), from.y.max(to.y)]])
}
