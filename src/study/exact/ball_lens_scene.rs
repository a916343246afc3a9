//! Reads a [`BallLens`] from a scene: a glass ball, a beam that is round about its axis or wider than the ball, a
//! receiver behind it and an orthographic camera between them that looks along the beam.

use super::ball_lens::{BallLens, ReceiverPicture};
use super::pixels::Pixels;
use super::scene_reading::{Beam, View, beam, brdf, ends_on_receiver, only, rectangle, require, same};
use super::{ExactPicture, NotThisForm};
use crate::math::{Point3, Vec3};
use crate::scene::light::BeamExtent;
use crate::scene::{Material, Scene};
use crate::shape::{Shape, Sphere};

/// Steps over the angles of incidence whose light is in the picture: a hundred circles a pixel in one of 512².
const STEPS: usize = 1 << 15;

const OBJECTS: &str = "a ball and its receiver";

pub(super) fn picture(scene: &Scene) -> Result<ExactPicture, NotThisForm> {
    ends_on_receiver(scene)?;
    let depth = scene.settings.max_depth;
    // Into the ball, out of it, onto the receiver; each reflection inside is one edge more.
    require(depth >= 3, || format!("render.max_depth is {depth}; light through the ball has 3 edges"))?;
    let (ball, glass) = only(scene, OBJECTS, "sphere", sphere)?;
    let (receiver, paint) = only(scene, OBJECTS, "rectangle", rectangle)?;
    let (brdf, beam) = (brdf(paint)?, beam(scene)?);
    let &Material::Dielectric { ior, exterior, fresnel } = glass else {
        return Err(NotThisForm("the ball is not of smooth glass".to_owned()));
    };
    require(ior > exterior, || "the ball is not denser than what is around it".to_owned())?;
    let view = View::along(beam.direction, scene, receiver)?;
    view.shows_only(receiver)?;
    let ahead = |p: Point3| (p - ball.centre()).dot(beam.direction) / ball.radius();
    let plane = ahead(receiver.centre());
    let camera = plane - view.distance / ball.radius();
    require(camera > 1.0, || "the camera does not stand between the ball and the receiver".to_owned())?;
    let most_inner = depth - 3;
    let lens = BallLens { index: ior / exterior, receiver: plane, beam: radius(&beam, ball)?, fresnel, most_inner };
    let [width, height] = view.resolution;
    let axis = ball.centre() + view.forward * (plane * ball.radius());
    let shown = ReceiverPicture {
        pixels: Pixels { width, height },
        centre: view.raster(axis),
        scale: ball.radius() / view.pixel(),
    };
    let colour = (beam.irradiance * brdf).to_array();
    let [fine, coarse] = [STEPS, STEPS / 2].map(|steps| -> Vec<[f64; 3]> {
        lens.averages(&shown, steps).into_iter().map(|e| colour.map(|c| c * e)).collect()
    });
    Ok(ExactPicture::new(view.resolution, fine, &coarse))
}

fn sphere(shape: &Shape) -> Option<&Sphere> {
    if let Shape::Sphere(sphere) = shape { Some(sphere) } else { None }
}

/// Of the part of the beam that meets the ball, in radii.
fn radius(beam: &Beam, ball: &Sphere) -> Result<f64, NotThisForm> {
    let w = beam.direction;
    let across = |v: Vec3| v - w * v.dot(w);
    let (start, covered) = match *beam.extent {
        BeamExtent::Unbounded => return Ok(1.0),
        BeamExtent::Disk { centre, radius } => {
            let aside = across(centre - ball.centre()).length();
            let within = if same(aside, 0.0) { (radius / ball.radius()).min(1.0) } else { 1.0 };
            (centre, (aside + within * ball.radius() <= radius).then_some(within))
        }
        BeamExtent::Rectangle { centre, a, b } => {
            let aside = across(ball.centre() - centre);
            let reaches = |side: Vec3| aside.dot(side).abs() / side.length() + ball.radius() <= side.length();
            (centre, (reaches(across(a)) && reaches(across(b))).then_some(1.0))
        }
    };
    require((ball.centre() - start).dot(w) >= ball.radius(), || "the beam does not start before the ball".to_owned())?;
    covered.ok_or_else(|| {
        NotThisForm("the beam is neither round about the ball's axis nor wider than the ball".to_owned())
    })
}
