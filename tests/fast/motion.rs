//! Motion through key frames: places at and between keys, boxes around all of them.

use std::path::Path;

use pdembree::import::load_text;
use pdembree::math::{Bounds3, Dir3, Motion, MotionError, Point3, Transform, Vec3};
use pdembree::scene::{ObjectGeometry, Scene, Shutter};
use pdembree::shape::Shape;

use crate::support::worlds::{Numbers, motion, placements};

const TOLERANCE: f64 = 1e-13;

/// The largest difference of what two maps do to the corners of a cube.
fn difference(a: &Transform, b: &Transform) -> f64 {
    let cube = Bounds3 { min: Point3::new(-1.0, -1.0, -1.0), max: Point3::new(1.0, 1.0, 1.0) };
    cube.corners()
        .map(|p| a.point(p).distance(b.point(p)).max(a.inverse_point(p).distance(b.inverse_point(p))))
        .into_iter()
        .fold(0.0, f64::max)
}

fn turned(axis: Dir3, degrees: f64) -> Transform {
    Transform::rotate(axis, degrees.to_radians())
}

#[test]
fn keys_are_met_exactly_and_hold_outside() {
    let keys: Vec<(f64, Transform)> =
        [0.3, 1.0, 1.2, 5.0].into_iter().zip(placements(3, 8).into_iter().step_by(2)).collect();
    let placed = placements(4, 2)[1];
    let motion = Motion::new(&keys, &placed).expect("a motion");
    for (time, map) in &keys {
        assert!(difference(&motion.at(*time), &map.compose(&placed)) < 30.0 * TOLERANCE, "at {time}");
    }
    assert_eq!(motion.at(-7.0), motion.at(0.3));
    assert_eq!(motion.at(99.0), motion.at(5.0));
    assert!(motion.is_still(6.0, 9.0) && motion.is_still(-1.0, 0.3) && !motion.is_still(0.2, 0.4));
}

/// Between keys: a turn at a constant rate, translation and scale that change linearly.
#[test]
fn half_way_is_half_the_turn_half_the_way_and_the_mean_scale() {
    let axis = Dir3::new(Vec3::new(1.0, -2.0, 0.5)).expect("non-zero");
    let key = |t: f64, degrees: f64, scale: f64| {
        let scale = Transform::scale(Vec3::new(scale, 1.0, 2.0)).expect("regular");
        Transform::translate(Vec3::new(t, 1.0, 0.0)).compose(&turned(axis, degrees)).compose(&scale)
    };
    let placed = Transform::translate(Vec3::new(0.1, 0.2, 0.3));
    let motion = Motion::new(&[(2.0, key(0.0, 10.0, 1.0)), (4.0, key(3.0, 130.0, 2.0))], &placed).expect("a motion");
    for s in [0.0, 0.25, 0.5, 0.9, 1.0] {
        let expected = key(3.0 * s, 10.0 + 120.0 * s, 1.0 + s).compose(&placed);
        assert!(difference(&motion.at(2.0 + 2.0 * s), &expected) < TOLERANCE, "{s}");
    }
}

#[test]
fn what_only_moves_needs_no_matrices() {
    let keys = [(0.0, Transform::IDENTITY), (1.0, Transform::translate(Vec3::X))];
    assert!(Motion::new(&keys, &Transform::translate(Vec3::Y)).expect("a motion").at(0.3).only_moves());
}

#[test]
fn what_is_no_motion_is_refused() {
    let still = Transform::IDENTITY;
    let mirrored = Transform::scale(Vec3::new(-1.0, 1.0, 1.0)).expect("regular");
    let of = |keys: &[(f64, Transform)]| Motion::new(keys, &still).map(|_| ());
    assert_eq!(of(&[(0.0, still)]), Err(MotionError::TooFewKeys));
    assert_eq!(of(&[(0.0, still), (1.0, still), (1.0, still)]), Err(MotionError::Order { later: 2 }));
    assert_eq!(of(&[(0.0, still), (f64::NAN, still)]), Err(MotionError::Order { later: 1 }));
    assert_eq!(of(&[(0.0, still), (1.0, mirrored)]), Err(MotionError::Mirrors { later: 1 }));
    assert_eq!(of(&[(0.0, still), (1.0, turned(Dir3::Y, 180.0))]), Err(MotionError::HalfTurn { earlier: 0 }));
    assert_eq!(of(&[(0.0, mirrored), (1.0, mirrored.compose(&turned(Dir3::Y, 170.0)))]), Ok(()));
}

/// Random points of a box, at random times of random intervals, never leave the box around all places; and that box is
/// little wider than it must be.
#[test]
fn bounds_hold_all_places_tightly() {
    let own = Bounds3 { min: Point3::new(-1.0, 0.5, -0.2), max: Point3::new(0.3, 0.8, 0.7) };
    let mut numbers = Numbers::new(17);
    for case in 0..200 {
        let motion = motion(&mut numbers, &placements(40 + case, 2)[case as usize % 2]);
        let [a, b] = [numbers.between(-0.2, 1.2), numbers.between(-0.2, 1.2)];
        let (open, close) = (a.min(b), a.max(b));
        let bounds = motion.bounds(&own, open, close);
        let mut seen = Bounds3::EMPTY;
        for k in 0..=200 {
            let place = motion.at(open + (close - open) * f64::from(k) / 200.0);
            seen = seen.union(own.transformed(&place));
            let inside = own.min + (own.max - own.min) * (Vec3::splat(0.5) + numbers.in_cube(0.5));
            assert!(bounds.union(Bounds3::EMPTY.including(place.point(inside))) == bounds, "{case} {k}");
        }
        assert!(bounds.union(seen) == bounds, "{case}: {seen:?} is not in {bounds:?}");
        let (outer, inner) = (bounds.diagonal().length(), seen.diagonal().length());
        assert!(outer < 1.02 * inner, "{case}: {outer} around {inner}");
    }
    assert!(motion(&mut numbers, &Transform::IDENTITY).bounds(&Bounds3::EMPTY, 0.0, 1.0).is_empty());
}

/// A ball that goes one metre a second to the right from 0 to 2 s, seen by a camera that rises as fast.
const MOVING: &str = r#"
format = 1
[camera]
type = "perspective"
position = [0, 1, 5]
target = [0, 0, 0]
fov_degrees = 40
resolution = [16, 16]
shutter = [0.5, 1.5]
motion = [{ time = 0 }, { time = 2, position = [0, 3, 5], target = [0, 2, 0] }]
[materials.glass]
type = "dielectric"
ior = 1.5
[[objects]]
name = "ball"
shape = "sphere"
centre = [0, 0, 0]
radius = 0.5
material = "glass"
transform = [{ translate = [0, 0, 7] }]
motion = [{ time = 0, transform = [] }, { time = 2, transform = [{ translate = [2, 0, 0] }] }]
[[lights]]
type = "point"
position = [0, 3, 0]
intensity = 10
"#;

fn scene(text: &str) -> Scene {
    load_text(Path::new("moving.toml"), text, &[]).unwrap_or_else(|problems| panic!("{problems}")).scene
}

#[test]
fn scenes_know_where_things_are_while_the_shutter_is_open() {
    let scene = scene(MOVING);
    let ball = &scene.objects[0];
    let at = |time: f64| ball.to_world(time).point(Point3::ORIGIN);
    assert_eq!(scene.shutter, Shutter { open: 0.5, close: 1.5 });
    for time in [0.0, 0.5, 1.1, 2.0] {
        assert!(at(time).distance(Point3::new(time, 0.0, 7.0)) < TOLERANCE, "{time}");
    }
    assert!(ball.geometry.to_world().translation().abs_diff_eq(Vec3::new(1.0, 0.0, 7.0), TOLERANCE));
    let expected = Bounds3 { min: Point3::new(0.0, -0.5, 6.5), max: Point3::new(2.0, 0.5, 7.5) };
    assert!(ball.bounds.min.distance(expected.min) < TOLERANCE && ball.bounds.max.distance(expected.max) < TOLERANCE);
    let (camera, later) = (scene.camera.at(0.5), scene.camera.at(1.5));
    assert!(camera.position.distance(Point3::new(0.0, 1.5, 5.0)) < TOLERANCE);
    assert!(later.target.distance(Point3::new(0.0, 1.5, 0.0)) < TOLERANCE);
    assert!(scene.camera.position.distance(Point3::new(0.0, 2.0, 5.0)) < TOLERANCE);
}

#[test]
fn an_instant_and_what_stands_still_meanwhile_are_no_motion() {
    for (shutter, x) in [("[0.25, 0.25]", 0.25), ("[2, 3]", 2.0), ("[-1, 0]", 0.0)] {
        let scene = scene(&MOVING.replace("[0.5, 1.5]", shutter));
        assert!(scene.shutter.is_instant(), "{shutter}");
        assert!(scene.objects[0].motion.is_none() && scene.camera.motion.is_empty(), "{shutter}");
        let at = scene.objects[0].geometry.to_world().point(Point3::ORIGIN);
        assert!(at.distance(Point3::new(x, 0.0, 7.0)) < TOLERANCE, "{shutter}");
        assert!(scene.camera.position.distance(Point3::new(0.0, 1.0 + x, 5.0)) < TOLERANCE, "{shutter}");
    }
}

/// A wave travels along its wave vector while the shutter is open; an instant sees it where it is.
#[test]
fn waves_travel_and_are_frozen_by_an_instant() {
    let text = MOVING.replace(
        "shape = \"sphere\"",
        "shape = \"height_field\"\nhalf_size = [1, 1]\n\
         waves = [{ amplitude = 0.1, wave_vector = [3, 4], phase = 0.2, speed = 2 }]",
    );
    let text = text.replace("radius = 0.5\n", "");
    let field = |scene: &Scene| match &scene.objects[0].geometry {
        ObjectGeometry::Shape { shape: Shape::HeightField(field), .. } => field.waves()[0],
        _ => panic!("a height field"),
    };
    let still_there = text.lines().filter(|line| !line.starts_with("motion")).collect::<Vec<_>>().join("\n");
    let (moving, instant) = (scene(&still_there), scene(&still_there.replace("[0.5, 1.5]", "[0.5, 0.5]")));
    assert!(!moving.shutter.is_instant() && instant.shutter.is_instant());
    assert_eq!((field(&moving).rate, field(&moving).phase), (-10.0, 0.2));
    assert_eq!((field(&instant).rate, field(&instant).phase), (0.0, -4.8));
    assert_ne!(scene(&still_there.replace("speed = 2", "speed = 3")).hash, moving.hash);
}

#[test]
fn the_hash_covers_motion_and_shutter() {
    let mut hashes = vec![scene(MOVING).hash];
    for (from, to) in [
        ("shutter = [0.5, 1.5]", "shutter = [0.5, 1.6]"),
        ("shutter = [0.5, 1.5]", ""),
        ("translate = [2, 0, 0]", "translate = [2, 0, 1]"),
        ("{ time = 2, transform", "{ time = 3, transform"),
        ("position = [0, 3, 5]", "position = [0, 3, 6]"),
        ("{ time = 2, position", "{ time = 3, position"),
    ] {
        hashes.push(scene(&MOVING.replace(from, to)).hash);
    }
    let distinct: std::collections::HashSet<&String> = hashes.iter().collect();
    assert_eq!(distinct.len(), hashes.len());
}

/// A cube whose top edge goes out by half a metre from 0 to 1 s and comes back until 2 s.
#[test]
fn a_mesh_of_several_files_changes_its_shape() {
    let of_shutter = |shutter: &str| {
        let text = MOVING
            .replace(
                "shape = \"sphere\"",
                "shape = \"mesh\"\nfile = [\"cube.obj\", \"wide_cube.obj\", \"cube.obj\"]\ntimes = [0, 2]",
            )
            .replace("centre = [0, 0, 0]\nradius = 0.5\n", "")
            .replace("[0.5, 1.5]", shutter);
        let text: String =
            text.lines().filter(|line| !line.starts_with("motion")).map(|line| format!("{line}\n")).collect();
        let path = crate::support::data::root().join("tests/corpus/valid/frames.toml");
        load_text(&path, &text, &[]).unwrap_or_else(|problems| panic!("{problems}")).scene
    };
    let (moving, instant, still) = (of_shutter("[0.5, 1.5]"), of_shutter("[0.5, 0.5]"), of_shutter("[2, 3]"));
    let [there, here, after] = [&moving, &instant, &still].map(|scene| &scene.meshes[0]);
    // The middle of the interval is the widest, at 0.5 s it is half as wide.
    assert_eq!((there.bounds().max.x, here.bounds().max.x, after.bounds().max.x), (1.5, 1.25, 1.0));
    assert!(!moving.shutter.is_instant() && instant.shutter.is_instant() && still.shutter.is_instant());
    assert!(there.changes() && !here.changes() && !after.changes());
    let deformation = there.deformation.as_ref().expect("it changes");
    for (time, x) in [(0.5, 1.25), (0.75, 1.375), (1.0, 1.5), (1.5, 1.25)] {
        let positions = deformation.at(time).positions;
        assert_eq!(f64::from(positions.iter().map(|p| p[0]).fold(0.0, f32::max)), x, "at {time}");
        assert_eq!(positions.iter().filter(|p| f64::from(p[0]) == x).count(), 2, "at {time}");
    }
    assert_eq!(moving.objects[0].bounds.max.x, 1.5);
    let slower = of_shutter("[0.5, 1.6]");
    assert_ne!(moving.hash, slower.hash);
}
