//! Lights that move: what they emit at a time is what a light that stands there emits, and their time columns are central
//! differences.

use std::sync::Arc;

use pdembree::light::{Aim, Lights};
use pdembree::math::{Motion, Point3, Transform, Vec3};
use pdembree::radiometry::Spectrum;
use pdembree::scene::light::BeamExtent;
use pdembree::scene::{LightId, LightSource, ObjectGeometry, ObjectId, Scene, Shutter};
use pdembree::shape::Shape;

use crate::support::lights::{dir, shapes, tetrahedron};
use crate::support::scene::scene;
use crate::support::shapes::random;
use crate::support::worlds::placed;

const SHUTTER: Shutter = Shutter { open: 1.0, close: 2.0 };
const LIGHT: LightId = LightId(0);

/// By 1.2 m and some 50 degrees, in all directions.
fn motion(placed: &Transform) -> Motion {
    let turned = Transform::rotate(dir(1.0, 2.0, -0.5), 0.9);
    let there = Transform::translate(Vec3::new(0.6, -0.4, 0.9)).compose(&turned);
    Motion::new(&[(1.0, Transform::IDENTITY), (2.0, there)], placed).expect("less than half a turn")
}

/// A light as it says of itself, and how it moves.
struct Case {
    name: &'static str,
    scene: Scene,
}

/// One light of each kind. `at`: None, moving, at rest in the middle of the interval; or standing where it is then.
fn cases(at: Option<f64>) -> Vec<Case> {
    let floor = || vec![placed(0, Transform::IDENTITY)];
    let map = motion(&Transform::IDENTITY).at(at.unwrap_or(SHUTTER.middle()));
    let turned = |w: Vec3| dir(map.vector(w).x, map.vector(w).y, map.vector(w).z);
    let power = Spectrum::rgb(3.0, 2.0, 1.0);
    let position = map.point(Point3::new(0.3, 3.0, 0.2));
    let [a, b] = [Vec3::new(0.4, 0.0, 0.0), Vec3::new(0.0, 0.0, 0.3)].map(|v| map.vector(v));
    let beam = |extent| LightSource::Directional { direction: turned(-Vec3::Y), irradiance: power, extent };
    let spot = |cos_outer: f64| LightSource::Spot {
        position,
        direction: turned(Vec3::new(0.1, -1.0, 0.0)),
        intensity: power,
        cos_inner: 0.5 + 0.5 * cos_outer,
        cos_outer,
    };
    let sources = [
        ("point", LightSource::Point { position, intensity: power }),
        ("wide spot", spot(0.2)),
        ("narrow spot", spot(0.999)),
        ("beam", beam(BeamExtent::Rectangle { centre: position, a, b })),
        ("narrow beam", beam(BeamExtent::Disk { centre: position, radius: 0.05 })),
    ];
    let mut all: Vec<Case> = Vec::new();
    for (name, source) in sources {
        let motions = if at.is_none() { vec![Some(Arc::new(motion(&Transform::IDENTITY)))] } else { vec![] };
        let scene = Scene {
            lights: vec![source],
            light_motions: motions,
            shutter: SHUTTER,
            ..scene(floor(), vec![tetrahedron()])
        };
        all.push(Case { name, scene });
    }
    let stood = Transform::translate(Vec3::new(0.2, 2.5, 0.1)).compose(&Transform::rotate(dir(0.2, 1.0, 0.4), 0.7));
    let moving = motion(&stood);
    let to_world = moving.at(at.unwrap_or(SHUTTER.middle()));
    let mut bodies: Vec<(&'static str, ObjectGeometry)> = vec![("mesh", placed(0, to_world))];
    bodies.extend(
        shapes().into_iter().map(|(name, shape): (_, Shape)| (name, ObjectGeometry::Shape { shape, to_world })),
    );
    for (name, body) in bodies {
        let mut scene = scene(vec![body, placed(0, Transform::IDENTITY)], vec![tetrahedron()]);
        scene.lights = vec![LightSource::Area { object: ObjectId(0), radiance: power, two_sided: false }];
        scene.shutter = SHUTTER;
        scene.objects[0].motion = at.is_none().then(|| Arc::new(moving.clone()));
        all.push(Case { name, scene });
    }
    all
}

fn lights(scene: &Scene) -> Lights {
    Lights::new(scene).unwrap_or_else(|errors| panic!("{errors:?}"))
}

const NEAR: Aim = Aim::Sphere { centre: Point3::new(0.4, 0.3, 0.2), radius: 0.5 };

/// What falls on a point from the light at a time, for the same random numbers: the light that stands there says the same.
#[test]
fn a_moving_light_lights_as_one_that_stands_where_it_is() {
    for time in [1.0, 1.3, 1.5, 2.0] {
        for (moving, standing) in cases(None).iter().zip(cases(Some(time))) {
            let (there, here) = (lights(&moving.scene), lights(&standing.scene));
            // A sphere's cone has axes of its own.
            let same_numbers = moving.name != "sphere";
            for k in 0..50 {
                let mut stream = random(100 + k);
                let p = Point3::new(stream.uniform(), stream.uniform() - 1.0, stream.uniform());
                let u = stream.uniform2();
                let found = [there.sample_li(LIGHT, p, u, time), here.sample_li(LIGHT, p, u, time)];
                let name = moving.name;
                match found {
                    [Some(a), Some(b)] if same_numbers => {
                        assert!((a.wi.to_vec() - b.wi.to_vec()).length() < 1e-9, "{name} at {time}: {a:?} {b:?}");
                        assert!((a.distance - b.distance).abs() < 1e-9, "{name} at {time}: {a:?} {b:?}");
                        let scale = b.weight.0.max_component();
                        assert!((a.weight.0.r() - b.weight.0.r()).abs() < 1e-9 * scale, "{name} at {time}");
                    }
                    [Some(a), Some(b)] => {
                        let (a, b) = (a.pdf.expect("a sphere").get(), b.pdf.expect("a sphere").get());
                        assert!((a - b).abs() < 1e-9 * b, "{name} at {time}: {a} {b}");
                    }
                    [None, None] => {}
                    _ => assert!(!same_numbers, "{name} at {time}: {found:?}"),
                }
            }
            let [a, b] = [&there, &here].map(|lights| lights.get(LIGHT).power().0.r());
            assert!((a - b).abs() < 1e-9 * b, "{}: {a} {b}", moving.name);
        }
    }
}

/// A ray that a light emits at a time is one that the light standing there emits, with the same density and flux.
#[test]
fn a_moving_light_emits_as_one_that_stands_where_it_is() {
    for time in [1.0, 1.3, 2.0] {
        for (moving, standing) in cases(None).iter().zip(cases(Some(time))) {
            let (there, here) = (lights(&moving.scene), lights(&standing.scene));
            for aim in [Aim::Everywhere, NEAR] {
                let mut checked = 0;
                for k in 0..100 {
                    let mut stream = random(300 + k);
                    let ([u, v], [s, t]) = (stream.uniform2(), stream.uniform2());
                    let Some(found) = there.emit(LIGHT, [u, v, s, t], &aim, time) else { continue };
                    let name = moving.name;
                    let still = here.get(LIGHT);
                    // A beam's disk has axes of its own, and a mesh is searched to rounding.
                    let Some(same) = still.emission_inverse(found.origin, found.direction, &aim) else {
                        assert!(name.ends_with("beam") || name == "mesh", "{name} at {time}: {found:?}");
                        continue;
                    };
                    let same = still.emit(same, &aim).unwrap_or_else(|| panic!("{name} at {time}: {found:?}"));
                    assert!((same.direction.to_vec() - found.direction.to_vec()).length() < 1e-6, "{name} at {time}");
                    let (a, b) = (found.flux.0.r(), same.flux.0.r());
                    assert!((a - b).abs() < 1e-6 * b, "{name} at {time}: {a} {b}");
                    checked += 1;
                }
                let by_chance = moving.name.ends_with("beam") || moving.name == "narrow spot";
                assert!(checked > 10 || by_chance, "{}: {checked}", moving.name);
            }
        }
    }
}

#[test]
fn emission_time_columns_are_central_differences() {
    const STEP: f64 = 1e-5;
    for Case { name, scene } in cases(None) {
        let lights = lights(&scene);
        for aim in [Aim::Everywhere, NEAR] {
            let mut checked = 0;
            for k in 0..200 {
                let mut stream = random(500 + k);
                let ([a, b], [c, d]) = (stream.uniform2(), stream.uniform2());
                let time = 1.1 + 0.8 * stream.uniform();
                let at = |time: f64| lights.emit(LIGHT, [a, b, c, d], &aim, time);
                let (Some(now), Some(later), Some(sooner)) = (at(time), at(time + STEP), at(time - STEP)) else {
                    continue;
                };
                let dx = (later.origin - sooner.origin) / (2.0 * STEP);
                let dw = (later.direction.to_vec() - sooner.direction.to_vec()) / (2.0 * STEP);
                let size = 1.0 + now.motion.dx.length() + now.motion.dw.length();
                let off = (dx - now.motion.dx).length() + (dw - now.motion.dw).length();
                assert!(off < 1e-7 * size, "{name}, {aim:?}, {k}: {:?}, not {dx:?} {dw:?}", now.motion);
                checked += 1;
            }
            let hits_by_chance = name.ends_with("beam") || name == "narrow spot";
            assert!(checked >= 20 || hits_by_chance, "{name}, {aim:?}: only {checked}");
        }
    }
}
