//! Cameras: they look along −z with +y upwards. The format knows no number of pixels.

use glam::{DMat4, DVec3};
use gltf::camera::Projection;

use super::nodes::{Placed, direction};
use crate::import::imported;
use crate::math::Bounds3;
use crate::scene::camera::PixelFilter;
use crate::scene::description::{CameraDescription, CameraModelDescription, Reference};
use crate::scene::error::{Problem, Source};

/// Pixels along the longer side.
const LONGER_SIDE: f64 = 960.0;
/// Width over height where a camera does not say.
const USUAL_ASPECT: f64 = 4.0 / 3.0;
/// Full horizontal angle of the camera that stands in.
const STAND_IN_FOV: f64 = 40.0;

/// Which of the nodes with a camera has that name, or a camera of that name.
pub(super) fn find(cameras: &[&Placed<'_>], wanted: &Reference, source: &Source) -> Result<usize, Problem> {
    let of_camera = |item: &&Placed<'_>| item.node.camera().and_then(|camera| camera.name().map(str::to_owned));
    let of_node = |item: &&Placed<'_>| item.node.name().map(str::to_owned);
    let names: Vec<String> = cameras.iter().filter_map(|item| of_node(item).or_else(|| of_camera(item))).collect();
    let is_wanted = |item: &&Placed<'_>| [of_node(item), of_camera(item)].contains(&Some(wanted.name.clone()));
    match cameras.iter().position(is_wanted) {
        Some(place) => Ok(place),
        None => imported::find("camera", wanted, &names.iter().map(String::as_str).collect::<Vec<_>>(), source),
    }
}

/// A camera of the file in the world.
pub(super) fn describe(
    camera: &gltf::Camera<'_>,
    to_world: &DMat4,
    source: &Source,
) -> Result<CameraDescription, String> {
    let (model, aspect) = match camera.projection() {
        Projection::Perspective(lens) => {
            let aspect = lens.aspect_ratio().map_or(USUAL_ASPECT, f64::from);
            // Of the two full angles the format gives the vertical one.
            let half = (0.5 * f64::from(lens.yfov())).tan() * aspect;
            (CameraModelDescription::Perspective { fov_degrees: 2.0 * half.atan().to_degrees() }, aspect)
        }
        Projection::Orthographic(box_) => {
            // Half of the width, half of the height.
            let (x, y) = (f64::from(box_.xmag()).abs(), f64::from(box_.ymag()).abs());
            (CameraModelDescription::Orthographic { width: 2.0 * x }, x / y)
        }
    };
    if !(aspect > 0.0 && aspect.is_finite()) {
        return Err(format!("cameras[{}] has no picture: its width over its height is {aspect}", camera.index()));
    }
    let position = to_world.w_axis.truncate();
    Ok(CameraDescription {
        source: source.clone(),
        model,
        position: position.to_array(),
        target: (position + direction(to_world, DVec3::NEG_Z)).to_array(),
        up: direction(to_world, DVec3::Y).to_array(),
        resolution: resolution(aspect),
        filter: PixelFilter::Box,
        shutter: None,
        motion: Vec::new(),
    })
}

fn resolution(aspect: f64) -> [u32; 2] {
    let [width, height] = if aspect > 1.0 { [1.0, 1.0 / aspect] } else { [aspect, 1.0] };
    [width, height].map(|side| (LONGER_SIDE * side).round().max(1.0) as u32)
}

/// A camera that has all of `bounds` in view, from the front (+z) and a little to the right and above.
pub(super) fn framing(bounds: Bounds3, source: &Source) -> CameraDescription {
    let (centre, radius) = if bounds.is_empty() { Default::default() } else { bounds.bounding_sphere() };
    let aspect = USUAL_ASPECT;
    // The ball touches the sides of the narrower angle.
    let half = ((0.5 * STAND_IN_FOV.to_radians()).tan() / aspect).atan();
    let distance = if radius > 0.0 { radius / half.sin() } else { 1.0 };
    let away = DVec3::new(0.25, 0.2, 1.0).normalize() * distance;
    let centre = DVec3::new(centre.x, centre.y, centre.z);
    CameraDescription {
        source: source.clone(),
        model: CameraModelDescription::Perspective { fov_degrees: STAND_IN_FOV },
        position: (centre + away).to_array(),
        target: centre.to_array(),
        up: [0.0, 1.0, 0.0],
        resolution: resolution(aspect),
        filter: PixelFilter::Box,
        shutter: None,
        motion: Vec::new(),
    }
}
