//! The camera: that it looks somewhere, at a picture that fits into memory.

use super::Report;
use crate::math::{Point3, Vec3};
use crate::scene::camera::{CameraModel, CameraSettings};
use crate::scene::description::{CameraDescription, CameraModelDescription};
use crate::scene::error::{Problem, Source};

/// Pixels along one side.
const MAX_SIDE: u32 = 65_536;
/// Pixels of the whole picture; each takes about a hundred bytes while it is rendered.
const MAX_PIXELS: u64 = 1 << 28;
/// Sine of the least angle between `up` and the view.
const MIN_UP_SINE: f64 = 1e-6;

pub(super) fn assemble(
    described: Option<&CameraDescription>,
    file: &Source,
    report: &mut Report,
) -> Option<CameraSettings> {
    let Some(camera) = described else {
        let problem = Problem::new("the scene has no camera").at(file);
        report.problem(problem.help("add a [camera] table with type, position, target and resolution"));
        return None;
    };
    let mut refuse = |message: String, help: &str| {
        report.problem(Problem::new(message).help(help).at(&camera.source));
    };
    let (position, target, up) = (Point3::from(camera.position), Point3::from(camera.target), Vec3::from(camera.up));
    let view = target - position;
    let up_sine = view.normalize_or_zero().cross(up.normalize_or_zero()).length();
    if !(position.is_finite() && target.is_finite() && up.is_finite()) {
        refuse("the camera's position, target or up is not finite".to_owned(), "give finite numbers");
    } else if view.length() <= 1e-12 * (1.0 + position.length()) {
        refuse("the camera's position and target are the same point".to_owned(), "move one of them");
    } else if up_sine < MIN_UP_SINE {
        refuse("the camera's `up` is parallel to its view".to_owned(), "choose another `up`, as [0, 0, -1]");
    }
    let [width, height] = camera.resolution;
    let sides = 1..=MAX_SIDE;
    if !sides.contains(&width) || !sides.contains(&height) {
        refuse(format!("the resolution is {width} × {height}"), "each side takes 1 to 65536 pixels");
    } else if u64::from(width) * u64::from(height) > MAX_PIXELS {
        let help = format!("a picture has at most {MAX_PIXELS} pixels");
        refuse(format!("the resolution is {width} × {height}"), &help);
    }
    Some(CameraSettings {
        model: model(camera.model, &mut refuse),
        position,
        target,
        up,
        resolution: camera.resolution,
        filter: camera.filter,
    })
}

fn model(described: CameraModelDescription, refuse: &mut impl FnMut(String, &str)) -> CameraModel {
    let mut positive = |name: &str, value: f64| {
        if !(value > 0.0 && value.is_finite()) {
            refuse(format!("the camera's `{name}` is {value}"), "it must be a finite number > 0");
        }
    };
    let model = match described {
        CameraModelDescription::Perspective { fov_degrees } => {
            positive("fov_degrees", fov_degrees);
            CameraModel::Perspective { fov_x: fov_degrees.to_radians() }
        }
        CameraModelDescription::Orthographic { width } => {
            positive("width", width);
            CameraModel::Orthographic { width }
        }
        CameraModelDescription::ThinLens { fov_degrees, lens_radius, focus_distance } => {
            positive("fov_degrees", fov_degrees);
            positive("lens_radius", lens_radius);
            positive("focus_distance", focus_distance);
            CameraModel::ThinLens { fov_x: fov_degrees.to_radians(), lens_radius, focus_distance }
        }
    };
    if let CameraModel::Perspective { fov_x } | CameraModel::ThinLens { fov_x, .. } = model
        && fov_x >= std::f64::consts::PI
    {
        refuse("the camera sees 180 degrees or more".to_owned(), "a flat picture needs `fov_degrees` below 180");
    }
    model
}
