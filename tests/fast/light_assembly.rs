//! A scene's lights: all built or all problems told, picked by power, environments added up.

use std::f64::consts::PI;

use pdembree::light::{Aim, LightError, Lights, Receiver};
use pdembree::math::{Point3, Transform, Vec2, Vec3};
use pdembree::radiometry::Spectrum;
use pdembree::scene::light::BeamExtent;
use pdembree::scene::{LightId, LightSource, MeshId, ObjectGeometry, ObjectId, Scene, TriangleMesh};
use pdembree::shape::{Disk, HeightField, Shape};

use crate::support::lights::{dir, tetrahedron};
use crate::support::scene::scene;

/// Of few lights it does not matter where they are looked for.
const NOWHERE: Receiver = Receiver { p: Point3::ORIGIN, n: None };

const GREY: Spectrum = Spectrum::splat(2.0);

fn area(object: u32) -> LightSource {
    LightSource::Area { object: ObjectId(object), radiance: GREY, two_sided: false }
}

/// A disk of radius 1, a mesh instanced at twice its size, a mesh of one point, a height field.
fn objects() -> Scene {
    let disk = Disk::new(Point3::ORIGIN, Vec3::Y, 1.0).expect("a disk");
    let field = HeightField::new(Point3::ORIGIN, Vec3::X, Vec3::Z, Vec2::ONE, vec![]).expect("a height field");
    let still = Transform::IDENTITY;
    let twice = Transform::scale(Vec3::splat(2.0)).expect("invertible");
    let point =
        TriangleMesh { positions: vec![[0.5, 0.5, 0.5]], triangles: vec![[0, 0, 0]], ..TriangleMesh::default() };
    let geometry = vec![
        ObjectGeometry::Shape { shape: Shape::Disk(disk), to_world: still },
        ObjectGeometry::Mesh { mesh: MeshId(0), to_world: twice },
        ObjectGeometry::Mesh { mesh: MeshId(1), to_world: still },
        ObjectGeometry::Shape { shape: Shape::HeightField(field), to_world: still },
    ];
    scene(geometry, vec![tetrahedron(), point])
}

#[test]
fn lights_are_picked_half_evenly_and_given_photons_by_power() {
    let mut scene = objects();
    scene.lights = vec![
        LightSource::Point { position: Point3::new(0.0, 3.0, 0.0), intensity: GREY },
        area(0),
        area(1),
        LightSource::Point { position: Point3::ORIGIN, intensity: Spectrum::BLACK },
    ];
    let lights = Lights::new(&scene).expect("all can emit");
    assert_eq!(lights.len(), 4);
    let powers = [4.0 * PI * 2.0, PI * PI * 2.0, PI * 2.0 * 4.0 * f64::from(tetrahedron_area()), 0.0];
    let total: f64 = powers.iter().sum();
    for (i, power) in powers.iter().enumerate() {
        // Corners are stored as f32.
        let close = |x: f64, y: f64| (x - y).abs() <= 8.0 * f64::from(f32::EPSILON) * y;
        let light = LightId(i as u32);
        assert!(close(lights.get(light).power().0.luminance(), *power), "light {i}");
        // Half by power, half evenly among the three that shine.
        let pick = if *power > 0.0 { 0.5 * power / total + 0.5 / 3.0 } else { 0.0 };
        assert!(close(lights.pick_pmf(&NOWHERE, light).0, pick), "light {i}");
    }
    let first = lights.pick(&NOWHERE, 0.0).expect("some shine");
    assert_eq!(first.light, LightId(0));
    let last = lights.pick(&NOWHERE, 1.0 - f64::EPSILON / 2.0).expect("some shine");
    assert_eq!(last.light, LightId(2), "a dark light is never picked");

    let photons = lights.allot(10_000, &Aim::Everywhere);
    assert_eq!(photons.iter().sum::<u64>(), 10_000);
    assert_eq!(photons[3], 0);
    for (count, power) in photons.iter().zip(powers) {
        assert!((*count as f64 - 10_000.0 * power / total).abs() <= 1.0, "{photons:?}");
    }
}

fn tetrahedron_area() -> f32 {
    tetrahedron().area() as f32
}

#[test]
fn environments_are_found_by_every_ray_that_leaves() {
    let mut scene = objects();
    let environment = |v: f64| LightSource::Environment { radiance: Spectrum::splat(v) };
    scene.lights = vec![environment(1.0), area(0), environment(0.25)];
    let lights = Lights::new(&scene).expect("all can emit");
    let wi = dir(0.3, 0.4, -0.5);
    let ids: Vec<LightId> = lights.environments().map(|(id, _)| id).collect();
    assert_eq!(ids, [LightId(0), LightId(2)]);
    for ((_, light), radiance) in lights.environments().zip([1.0, 0.25]) {
        assert_eq!(light.environment_radiance(wi).0, Spectrum::splat(radiance));
        assert!((light.environment_pdf(wi).get() - 1.0 / (4.0 * PI)).abs() < 1e-15);
    }
    // 4π² R² L through the sphere around the scene.
    let radius = lights.scene_sphere().radius;
    let power = lights.get(LightId(2)).power().0.luminance();
    assert!((power - PI * PI * radius * radius).abs() <= 1e-12 * power);
}

#[test]
fn a_scene_without_light_picks_none() {
    let lights = Lights::new(&objects()).expect("nothing to refuse");
    assert!(lights.is_empty() && lights.pick(&NOWHERE, 0.5).is_none());
    assert_eq!(lights.allot(100, &Aim::Everywhere), [0u64; 0]);
    assert_eq!(lights.pick_pmf(&NOWHERE, LightId(0)).0, 0.0);
}

#[test]
fn lights_that_cannot_emit_are_all_reported() {
    let mut scene = objects();
    let parallel = BeamExtent::Rectangle { centre: Point3::ORIGIN, a: Vec3::X, b: Vec3::X * 2.0 };
    scene.lights = vec![
        area(2),
        area(0),
        area(3),
        LightSource::Directional { direction: dir(0.0, -1.0, 0.0), irradiance: GREY, extent: parallel },
    ];
    let errors = Lights::new(&scene).expect_err("three of four cannot emit");
    assert!(
        matches!(
            errors[..],
            [
                LightError::MeshWithoutArea { .. },
                LightError::ShapeCannotEmit { kind: "height_field", .. },
                LightError::BeamWithoutArea { light: LightId(3) }
            ]
        ),
        "{errors:?}"
    );
    for (error, word) in errors.iter().zip(["no area", "cannot be a light", "parallel"]) {
        assert!(error.to_string().contains(word), "{error}");
    }
}

/// Unbounded light in a scene without objects has nothing to be aimed at, and says so without a NaN.
#[test]
fn an_empty_scene_takes_no_unbounded_light() {
    let mut scene = scene(vec![], vec![]);
    scene.lights = vec![
        LightSource::Environment { radiance: GREY },
        LightSource::Directional { direction: dir(0.0, -1.0, 0.0), irradiance: GREY, extent: BeamExtent::Unbounded },
    ];
    let lights = Lights::new(&scene).expect("both are sound");
    for (_, light) in lights.iter() {
        assert!(light.power().is_zero());
        let flux = light.emit([0.1, 0.2, 0.3, 0.4], &Aim::Everywhere).map_or(Spectrum::BLACK, |e| e.flux.0);
        assert!(flux.is_black(), "{flux:?}");
    }
    assert!(lights.pick(&NOWHERE, 0.5).is_none());
}
