//! Key frames: motions that there are, and what of them the shutter sees.

use std::sync::Arc;

use super::Report;
use super::geometry::transform;
use crate::math::{Motion, MotionError, Transform};
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
    let keys: Vec<Option<(f64, Transform)>> = object
        .motion
        .iter()
        .map(|key| transform(&object.name, &key.transform, &key.source, report).map(|map| (key.time, map)))
        .collect();
    let keys: Vec<(f64, Transform)> = keys.into_iter().collect::<Option<_>>()?;
    check_turns(object, report);
    let motion = match Motion::new(&keys, &placed) {
        Ok(motion) => motion,
        Err(error) => {
            let problem = Problem::new(format!("the motion of `{}` is none: {error}", object.name));
            report.problem(problem.help(help(&error)).at(source(object, &error)));
            return None;
        }
    };
    if shutter.is_instant() || motion.is_still(shutter.open, shutter.close) {
        return Some((motion.at(shutter.open), None));
    }
    if let Some(emission) = &object.emission {
        let problem = Problem::new(format!("`{}` emits and moves while the shutter is open", object.name));
        let help = "lights must stand still: take `motion` or `emission` away, or make the shutter an instant";
        report.problem(problem.help(help).at(&emission.source));
    }
    Some((motion.at(shutter.middle()), Some(Arc::new(motion))))
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
fn source<'a>(object: &'a ObjectDescription, error: &MotionError) -> &'a Source {
    match *error {
        MotionError::TooFewKeys => &object.motion[0].source,
        MotionError::Order { later } | MotionError::Mirrors { later } => &object.motion[later].source,
        MotionError::HalfTurn { earlier } => &object.motion[earlier + 1].source,
    }
}

/// A turn goes the short way between two keys, which is not what two angles further apart than half a turn say.
fn check_turns(object: &ObjectDescription, report: &mut Report) {
    for pair in object.motion.windows(2) {
        let [from, to] = pair else { continue };
        if let Some(degrees) = widest_turn(from, to).filter(|degrees| *degrees > 180.0) {
            let message = format!("`{}` turns by {degrees} degrees between two keys", object.name);
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
