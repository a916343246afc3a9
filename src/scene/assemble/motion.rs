//! Key frames: motions that there are, and what of them the shutter sees.

use std::sync::Arc;

use super::Report;
use super::geometry::transform;
use crate::math::{Motion, MotionError, Transform, Vec3};
use crate::scene::camera::Shutter;
use crate::scene::description::{MotionKey, ObjectDescription, TransformMap};
use crate::scene::error::{Problem, Source};

/// The shutter's interval as a camera says it; an instant at 0 without one.
pub(super) fn shutter(described: Option<[f64; 2]>, source: &Source, report: &mut Report) -> Shutter {
    let [open, close] = described.unwrap_or([0.0; 2]);
    // Written so that a NaN fails.
    if open <= close && (close - open).is_finite() {
        return Shutter { open, close };
    }
    let problem = Problem::new(format!("the shutter closes at {close} s, before it opens at {open} s"));
    report.problem(problem.help("write shutter = [open, close], in seconds").at(source));
    Shutter::instant(0.0)
}

/// Where an object is that `placed` has put into the world, in the middle of the shutter's interval, and how it moves
/// meanwhile. `None` after reporting why not.
pub(super) fn moving(
    object: &ObjectDescription,
    placed: Transform,
    shutter: Shutter,
    report: &mut Report,
) -> Option<(Transform, Option<Arc<Motion>>)> {
    if object.motion.is_empty() {
        return Some((placed, None));
    }
    let subject = Subject { name: &object.name, keys: &object.motion, is_light: object.emission.is_some() };
    through_keys(&subject, &placed, shutter, report)
}

/// Where a light is in the middle of the shutter's interval, as a map of what it says of itself, and how it moves meanwhile.
pub(super) fn moving_light(
    name: &str,
    keys: &[MotionKey],
    shutter: Shutter,
    report: &mut Report,
) -> Option<(Transform, Option<Arc<Motion>>)> {
    if keys.is_empty() {
        return Some((Transform::IDENTITY, None));
    }
    through_keys(&Subject { name, keys, is_light: true }, &Transform::IDENTITY, shutter, report)
}

/// What moves.
struct Subject<'a> {
    name: &'a str,
    keys: &'a [MotionKey],
    is_light: bool,
}

fn through_keys(
    subject: &Subject<'_>,
    placed: &Transform,
    shutter: Shutter,
    report: &mut Report,
) -> Option<(Transform, Option<Arc<Motion>>)> {
    let Subject { name, keys: described, is_light } = *subject;
    let keys = described.iter().map(|key| Some((key.time, transform(name, &key.transform, &key.source, report)?)));
    let keys: Vec<Option<(f64, Transform)>> = keys.collect();
    let keys: Vec<(f64, Transform)> = keys.into_iter().collect::<Option<_>>()?;
    check_turns(subject, report);
    let motion = match Motion::new(&keys, placed) {
        Ok(motion) => motion,
        Err(error) => {
            let problem = Problem::new(format!("the motion of `{name}` is none: {error}"));
            report.problem(problem.help(help(&error)).at(source(described, &error)));
            return None;
        }
    };
    if shutter.is_instant() || motion.is_still(shutter.open, shutter.close) {
        return Some((motion.at(shutter.open), None));
    }
    let stretches = |(_, map): &(f64, Transform)| !is_rigid(map);
    if let Some(key) = keys.iter().position(stretches).filter(|_| is_light) {
        let problem = Problem::new(format!("`{name}` is a light, and this key of its motion changes its size"));
        let help = "lights move as rigid bodies, by `translate` and `rotate`; a scale may stand in `transform`";
        report.problem(problem.help(help).at(&described[key].source));
    }
    Some((motion.at(shutter.middle()), Some(Arc::new(motion))))
}

/// Whether lengths and angles stay what they are, but for rounding, and right-handed frames right-handed.
fn is_rigid(map: &Transform) -> bool {
    const ROUNDING: f64 = 1e-9;
    let [x, y, z] = map.columns();
    let unit = |v: Vec3| (v.length_squared() - 1.0).abs() < ROUNDING;
    let right = |a: Vec3, b: Vec3| a.dot(b).abs() < ROUNDING;
    [x, y, z].into_iter().all(unit) && right(x, y) && right(y, z) && right(z, x) && !map.flips_handedness()
}

fn help(error: &MotionError) -> &'static str {
    match error {
        MotionError::TooFewKeys => {
            "write motion = [{ time, transform }, { time, transform }], or give `transform` alone"
        }
        MotionError::Order { .. } => "keys stand in the order of their times, each at a time of its own",
        MotionError::Mirrors { .. } => "let all keys have scales of the same signs",
        MotionError::HalfTurn { .. } => "give a key in between",
    }
}

/// The key that an error is about.
fn source<'a>(keys: &'a [MotionKey], error: &MotionError) -> &'a Source {
    match *error {
        MotionError::TooFewKeys => &keys[0].source,
        MotionError::Order { later } | MotionError::Mirrors { later } => &keys[later].source,
        MotionError::HalfTurn { earlier } => &keys[earlier + 1].source,
    }
}

/// A turn goes the short way between two keys, which is not what two angles further apart than half a turn say.
fn check_turns(subject: &Subject<'_>, report: &mut Report) {
    for pair in subject.keys.windows(2) {
        let [from, to] = pair else { continue };
        if let Some(degrees) = widest_turn(from, to).filter(|degrees| *degrees > 180.0) {
            let message = format!("`{}` turns by {degrees} degrees between two keys", subject.name);
            let help = "between keys it turns the short way, by less than 180 degrees: give keys in between";
            report.problem(Problem::new(message).help(help).at(&to.source));
        }
    }
}

/// The largest difference of angles of rotations that stand at the same place and have the same axis.
fn widest_turn(from: &MotionKey, to: &MotionKey) -> Option<f64> {
    let steps = from.transform.iter().zip(&to.transform);
    let turns = steps.filter_map(|(a, b)| match (a.map, b.map) {
        (TransformMap::Rotate { axis: a, degrees: from }, TransformMap::Rotate { axis: b, degrees: to }) if a == b => {
            Some((to - from).abs())
        }
        _ => None,
    });
    turns.max_by(f64::total_cmp)
}
