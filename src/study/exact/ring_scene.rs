//! Reads a [`Ring`] from a scene: an upright mirror cylinder on a floor, a beam that starts above the rim and comes down
//! at a slant, an orthographic camera straight above.

use super::pixels::Pixels;
use super::ring::{FloorPicture, Ring, Wall};
use super::scene_reading::{Beam, View, beam, brdf, ends_on_receiver, only, rectangle, require, same};
use super::{ExactPicture, NotThisForm};
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::scene::light::BeamExtent;
use crate::scene::{Material, Scene, Textured};
use crate::shape::{Cylinder, Rectangle, Shape};

/// Steps over φ. Neighbouring paths end 3 · 2.4e-5 apart after a bounce: a hundred of them in a 256th of the ring.
const STEPS: usize = 1 << 17;

const OBJECTS: &str = "a ring and its floor";

/// Unit vectors: the way of the light over the floor, the one across it, and up.
struct Axes {
    x: Vec3,
    y: Vec3,
    up: Vec3,
}

pub(super) fn picture(scene: &Scene) -> Result<ExactPicture, NotThisForm> {
    ends_on_receiver(scene)?;
    // The floor's edge is the last one.
    let most_bounces = scene.settings.max_depth - 1;
    require(most_bounces > 0, || "render.max_depth is 1; no light reaches the floor over the mirror".to_owned())?;
    let (cylinder, wall) = only(scene, OBJECTS, "cylinder", cylinder)?;
    let (floor, paint) = only(scene, OBJECTS, "rectangle", rectangle)?;
    let (brdf, beam) = (brdf(paint)?, beam(scene)?);
    let up = stands(cylinder, floor)?;
    let axes = axes(&beam, up)?;
    let (fall, level) = (-beam.direction.dot(up), beam.direction.dot(axes.x));
    let ring = Ring {
        travel: (cylinder.top() - cylinder.base()).length() / cylinder.radius() * level / fall,
        source: source(&beam, cylinder, &axes)?,
        most_bounces,
        wall: surface(wall, level)?,
    };
    let view = View::along(-up, scene, floor)?;
    view.shows_only(floor)?;
    let shown = shown(&view, cylinder, &axes);
    let colour = beam.irradiance * fall * brdf;
    let [fine, coarse] = [STEPS, STEPS / 2].map(|steps| coloured(ring.averages(&shown, steps), colour));
    Ok(ExactPicture::new(view.resolution, fine, &coarse))
}

fn coloured(values: Vec<[f64; 3]>, colour: Spectrum) -> Vec<[f64; 3]> {
    let colour = colour.to_array();
    values.into_iter().map(|value| [0, 1, 2].map(|i| value[i] * colour[i])).collect()
}

fn cylinder(shape: &Shape) -> Option<&Cylinder> {
    if let Shape::Cylinder(cylinder) = shape { Some(cylinder) } else { None }
}

/// The way up of a ring that stands on the floor.
fn stands(cylinder: &Cylinder, floor: &Rectangle) -> Result<Vec3, NotThisForm> {
    let axis = cylinder.top() - cylinder.base();
    let up = axis / axis.length();
    require(same(floor.normal().as_dir().dot(up).abs(), 1.0), || {
        "the ring's axis is not perpendicular to the floor".to_owned()
    })?;
    require(same((cylinder.base() - floor.centre()).dot(up), 0.0), || {
        "the ring's base is not on the floor".to_owned()
    })?;
    Ok(up)
}

fn axes(beam: &Beam, up: Vec3) -> Result<Axes, NotThisForm> {
    let fall = beam.direction.dot(up);
    let level = beam.direction - up * fall;
    require(fall < 0.0, || "the beam does not come down over the rim".to_owned())?;
    require(!same(level.length(), 0.0), || "the beam falls straight down, past the wall".to_owned())?;
    let x = level / level.length();
    Ok(Axes { x, y: up.cross(x), up })
}

/// The beam's part of the rim's plane.
fn source(beam: &Beam, cylinder: &Cylinder, axes: &Axes) -> Result<[[f64; 2]; 2], NotThisForm> {
    let (centre, a, b) = match *beam.extent {
        BeamExtent::Unbounded => return Ok([[f64::NEG_INFINITY, f64::INFINITY]; 2]),
        BeamExtent::Rectangle { centre, a, b } => (centre, a, b),
        BeamExtent::Disk { .. } => return Err(NotThisForm("the beam's extent is a disk".to_owned())),
    };
    let w = beam.direction;
    let lowest = (centre - cylinder.top()).dot(axes.up)
        - [a, b].map(|side| (side - w * side.dot(w)).dot(axes.up).abs()).iter().sum::<f64>();
    require(lowest >= 0.0, || "the beam starts below the rim".to_owned())?;
    // Along the beam into the rim's plane.
    let landed = |v: Vec3| {
        let v = v - w * (v.dot(axes.up) / w.dot(axes.up));
        [v.dot(axes.x), v.dot(axes.y)].map(|x| x / cylinder.radius())
    };
    let (middle, a, b) = (landed(centre - cylinder.top()), landed(a), landed(b));
    let straight = same(a[1], 0.0) && same(b[0], 0.0) || same(a[0], 0.0) && same(b[1], 0.0);
    require(straight, || "the beam's sides are not along its way over the floor and across it".to_owned())?;
    Ok([0, 1].map(|i| {
        let half = a[i].abs().max(b[i].abs());
        [middle[i] - half, middle[i] + half]
    }))
}

fn surface(wall: &Material, level: f64) -> Result<Wall, NotThisForm> {
    match wall {
        Material::Mirror { reflectance: Textured::Constant(reflectance) } => {
            Ok(Wall::Mirror { reflectance: reflectance.to_array() })
        }
        Material::Conductor { eta, k } => Ok(Wall::Metal { eta: eta.to_array(), k: k.to_array(), level }),
        _ => Err(NotThisForm("the ring is no mirror of one colour and no smooth metal".to_owned())),
    }
}

fn shown(view: &View, cylinder: &Cylinder, axes: &Axes) -> FloorPicture {
    let [width, height] = view.resolution;
    FloorPicture {
        pixels: Pixels { width, height },
        centre: view.raster(cylinder.base()),
        axes: [axes.x, axes.y].map(|axis| view.raster_vector(axis * cylinder.radius())),
    }
}
