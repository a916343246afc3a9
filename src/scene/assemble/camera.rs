//! The camera: that it looks somewhere, at a picture that fits into memory.

use super::Report;
use crate::math::{Point3, Vec3};
use crate::scene::camera::{CameraKey, CameraModel, CameraSettings, Shutter};
use crate::scene::description::{CameraDescription, CameraKeyDescription, CameraModelDescription};
use crate::scene::error::{Problem, Source};

/// Pixels along one side.
const MAX_SIDE: u32 = 65_536;
/// Pixels of the whole picture; each takes about a hundred bytes while it is rendered.
const MAX_PIXELS: u64 = 1 << 28;
/// Where a moving camera is looked at between two keys.
const PLACES_BETWEEN: u32 = 64;
/// Sine of the least angle between `up` and the view.
const MIN_UP_SINE: f64 = 1e-6;

pub(super) fn assemble(
    described: Option<&CameraDescription>,
    shutter: Shutter,
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
    let still = CameraKey {
        time: shutter.open,
        position: Point3::from(camera.position),
        target: Point3::from(camera.target),
        up: Vec3::from(camera.up),
    };
    if let Some((message, help)) = misplaced(&still) {
        refuse(message.to_owned(), help);
    }
    let [width, height] = camera.resolution;
    let sides = 1..=MAX_SIDE;
    if !sides.contains(&width) || !sides.contains(&height) {
        refuse(format!("the resolution is {width} × {height}"), "each side takes 1 to 65536 pixels");
    } else if u64::from(width) * u64::from(height) > MAX_PIXELS {
        let help = format!("a picture has at most {MAX_PIXELS} pixels");
        refuse(format!("the resolution is {width} × {height}"), &help);
    }
    let model = model(camera.model, &mut refuse);
    let motion = motion(&camera.motion, report);
    let CameraKey { position, target, up, .. } = CameraKey::at(&motion, shutter.middle()).unwrap_or(still);
    let moves = CameraKey::at(&motion, shutter.open).is_some_and(|open| {
        let seen = motion.iter().filter(|key| key.time > shutter.open && key.time < shutter.close).copied();
        seen.chain(CameraKey::at(&motion, shutter.close)).any(|key| CameraKey { time: open.time, ..key } != open)
    });
    let motion = if moves { motion } else { Vec::new() };
    let (resolution, filter) = (camera.resolution, camera.filter);
    Some(CameraSettings { model, position, target, up, resolution, filter, motion })
}

/// Why a camera cannot be there, and what to do.
fn misplaced(CameraKey { position, target, up, .. }: &CameraKey) -> Option<(&'static str, &'static str)> {
    let view = *target - *position;
    let up_sine = view.normalize_or_zero().cross(up.normalize_or_zero()).length();
    if !(position.is_finite() && target.is_finite() && up.is_finite()) {
        Some(("the camera's position, target or up is not finite", "give finite numbers"))
    } else if view.length() <= 1e-12 * (1.0 + position.length()) {
        Some(("the camera's position and target are the same point", "move one of them"))
    } else if up_sine < MIN_UP_SINE {
        Some(("the camera's `up` is parallel to its view", "choose another `up`, as [0, 0, -1]"))
    } else {
        None
    }
}

/// The keys of a camera that moves. The places between two keys must be sound as well.
fn motion(described: &[CameraKeyDescription], report: &mut Report) -> Vec<CameraKey> {
    let key = |key: &CameraKeyDescription| CameraKey {
        time: key.time,
        position: Point3::from(key.position),
        target: Point3::from(key.target),
        up: Vec3::from(key.up),
    };
    let keys: Vec<CameraKey> = described.iter().map(key).collect();
    if let [only] = described {
        let problem = Problem::new("the camera's `motion` has one key, it needs at least two");
        report.problem(problem.help("without `motion` the camera stands still").at(&only.source));
    }
    for (pair, later) in keys.windows(2).zip(described.iter().skip(1)) {
        if pair[1].time <= pair[0].time {
            let problem = Problem::new("a key of the camera's `motion` is not later than the one before it");
            report.problem(problem.help("keys stand in the order of their times").at(&later.source));
            continue;
        }
        let time = |i: u32| pair[0].time + (pair[1].time - pair[0].time) * f64::from(i) / f64::from(PLACES_BETWEEN);
        let bad = (0..=PLACES_BETWEEN).find_map(|i| misplaced(&CameraKey::at(pair, time(i))?));
        if let Some((message, help)) = bad {
            let problem = Problem::new(format!("on the way to a key of the camera's `motion` {message}"));
            report.problem(problem.help(help).at(&later.source));
        }
    }
    keys
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
