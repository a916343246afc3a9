//! What `Interaction::from_hit` recomputes: places, normals and their derivatives, tangents, under any transform.

use pdembree::backend::RawHit;
use pdembree::differential::{Column, Differential};
use pdembree::math::{Dir3, Point3, Ray, Transform, Vec2, Vec3};
use pdembree::scene::settings::BackendKind;
use pdembree::scene::{MeshId, ObjectGeometry, ObjectId, Scene, TriangleMesh};
use pdembree::surface::{Interaction, Lookup};

use crate::support::scene::{geode, mesh_scene, ray_towards, scene, shape_scene};
use crate::support::shapes::{self, random, random_direction};

/// A mirrored, sheared and moved place.
fn oblique() -> Transform {
    let columns = [Vec3::new(1.3, 0.2, -0.1), Vec3::new(-0.4, 0.9, 0.3), Vec3::new(0.2, 0.1, -0.7)];
    let to_world = Transform::new(columns, Vec3::new(0.5, -1.0, 2.0)).expect("invertible");
    assert!(to_world.flips_handedness());
    to_world
}

fn raw(t: f64, uv: [f64; 2]) -> RawHit {
    RawHit { t, object: ObjectId(0), primitive: 0, uv }
}

/// The triangle of PHOTON_DIFFERENTIALS 1.4 G, with or without its normals.
fn bent_triangle(smooth: bool) -> TriangleMesh {
    let unit = |x: f32, y: f32, z: f32| {
        let l = (x * x + y * y + z * z).sqrt();
        [x / l, y / l, z / l]
    };
    TriangleMesh {
        colours: Vec::new(),
        deformation: None,
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [0.0, 1.0, -0.05]],
        normals: if smooth { vec![unit(-0.2, -0.1, 1.0), unit(0.25, 0.0, 1.0), unit(0.0, 0.3, 1.0)] } else { vec![] },
        uvs: vec![[0.1, 0.2], [0.9, 0.3], [0.2, 1.4]],
        triangles: vec![[0, 1, 2]],
    }
}

/// The hit of a world ray with the one shape of a scene, by the shape itself.
fn shape_hit(scene: &Scene, ray: &Ray) -> Option<RawHit> {
    let ObjectGeometry::Shape { shape, to_world } = &scene.objects[0].geometry else { panic!("a shape scene") };
    let own =
        Ray { origin: to_world.inverse_point(ray.origin), direction: to_world.inverse_vector(ray.direction), ..*ray };
    shape.intersect(&own).map(|t| raw(t, [0.0; 2]))
}

const STEP: f64 = 1e-5;

/// Differences of (p, ns, uv) between both ends of a tangent of length `step` either way of `at`, seen along its own
/// ray's direction and divided by 2 `step`.
fn difference(scene: &Scene, at: &Interaction, e: Vec3, step: f64, hit: &RawHit) -> (Vec3, Vec3, Vec2) {
    let [a, b] = [step, -step].map(|step| {
        let ray = Ray {
            origin: at.p + e * step + at.wo * at.t,
            direction: -at.wo.to_vec(),
            t_min: 0.0,
            t_max: f64::INFINITY,
            time: 0.0,
        };
        let near = if scene.meshes.is_empty() { shape_hit(scene, &ray).unwrap_or(*hit) } else { *hit };
        Interaction::from_hit(scene, &ray, &near)
    });
    let duv = a.parametrisation(scene).uv - b.parametrisation(scene).uv;
    // Around the seam of a closed parameter.
    let duv = duv - Vec2::new(duv.x.round(), duv.y.round());
    let scale = 1.0 / (2.0 * step);
    ((a.p - b.p) * scale, (a.ns.to_vec() - b.ns.to_vec()) * scale, duv * scale)
}

/// Tangents and shape operator of an interaction against the differences of its neighbours, extrapolated from two steps.
fn check_derivatives(scene: &Scene, at: &Interaction, hit: &RawHit, e: Vec3, name: &str) {
    let [(dp, dn, duv), (half_dp, half_dn, half_duv)] =
        [STEP, 0.5 * STEP].map(|step| difference(scene, at, e, step, hit));
    if dp.length() > 10.0 {
        return; // the neighbour is beyond a silhouette
    }
    // What two steps differ by is of second order; the error left after the extrapolation is of fourth, so a hundredth
    // is plenty. Rounding of positions up to 5 is 1e-15/STEP.
    let off = |full: Vec3, half: Vec3| {
        let extrapolated = (4.0 * half - full) / 3.0;
        (extrapolated.length(), 0.01 * (half - full).length())
    };
    let curvature = at.shape.matrix().to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    let (operator, allowed) = off(at.shape.apply(dp) - dn, at.shape.apply(half_dp) - half_dn);
    assert!(operator < allowed + 1e-9 * (1.0 + curvature), "{name}: S is off by {operator:e} at {at:?}");
    let place = at.parametrisation(scene);
    if place.dpdu.length() > 0.5 && place.dpdu.length() != 1.0 {
        let tangent = |dp: Vec3, duv: Vec2| place.dpdu * duv.x + place.dpdv * duv.y - dp;
        let (tangent, allowed) = off(tangent(dp, duv), tangent(half_dp, half_duv));
        assert!(tangent < allowed + 1e-9, "{name}: ∂p is off by {tangent:e} at {at:?}");
    }
}

#[test]
fn every_shape_in_an_oblique_place_has_the_derivatives_of_its_normals() {
    for (index, known) in shapes::all().into_iter().enumerate() {
        let scene = shape_scene(known.shape.clone(), oblique());
        let mut stream = random(800 + index as u64);
        for _ in 0..200 {
            let to = oblique().point(known.point(&mut stream));
            let from = to + random_direction(&mut stream) * (4.0 * known.reach);
            let ray = ray_towards(from, to);
            let Some(hit) = shape_hit(&scene, &ray) else { continue };
            let at = Interaction::from_hit(&scene, &ray, &hit);
            assert!(at.exact, "{}: {ray:?} {hit:?}", known.name);
            if at.ng.dot(at.wo).abs() < 0.2 {
                continue; // differences along a grazing ray are long
            }
            // The point is on the ray and on the surface.
            assert_eq!(at.t, hit.t);
            assert!(at.p.distance(ray.at(at.t)) < 1e-13 * (1.0 + at.t), "{}", known.name);
            assert!((known.implicit)(oblique().inverse_point(at.p)).abs() < 1e-14);
            // Outward stays outward although the place is mirrored.
            assert!((known.implicit)(oblique().inverse_point(at.p + at.ng * 1e-4)) > 0.0, "{}", known.name);
            assert_eq!(at.ng, at.ns);
            let e = at.ng.cross(random_direction(&mut stream)).normalize();
            check_derivatives(&scene, &at, &hit, e, known.name);
        }
    }
}

#[test]
fn a_triangle_in_an_oblique_place_has_the_derivatives_of_its_interpolated_normal() {
    let mesh = bent_triangle(true);
    let [a, b, c] = mesh.corners(0);
    let scene = mesh_scene(mesh, oblique());
    let mut stream = random(900);
    for _ in 0..300 {
        let [u, v] = stream.uniform2().map(|x| 0.5 * x);
        let to = oblique().point(a + (b - a) * u + (c - a) * v);
        let ray = ray_towards(to + random_direction(&mut stream) * 3.0, to);
        let at = Interaction::from_hit(&scene, &ray, &raw(3.0, [0.9, 0.9]));
        assert!(at.exact && at.p.distance(to) < 1e-14 / at.ng.dot(at.wo).abs() && (at.t - 3.0).abs() < 1e-11);
        assert!(at.ns.dot(at.ng) > 0.9 && at.ns != at.ng);
        // Counter-clockwise side in the object's space: +z there.
        assert!(oblique().inverse_point(at.p + at.ng * 1e-3).z > oblique().inverse_point(at.p).z);
        if at.ng.dot(at.wo).abs() < 0.2 {
            continue;
        }
        let e = at.ng.cross(random_direction(&mut stream)).normalize();
        check_derivatives(&scene, &at, &raw(3.0, [u, v]), e, "triangle");
    }
}

#[test]
fn a_triangle_without_normals_is_flat() {
    let scene = mesh_scene(bent_triangle(false), oblique());
    let to = oblique().point(Point3::new(0.3, 0.3, 0.0));
    let at = Interaction::from_hit(&scene, &ray_towards(to + Vec3::new(0.3, 0.2, 4.0), to), &raw(4.0, [0.3, 0.3]));
    assert_eq!(at.ns, at.ng);
    assert_eq!(at.shape, pdembree::differential::ShapeOperator::FLAT);
}

#[test]
fn an_interpolated_normal_on_the_far_side_is_turned_over_with_its_derivative() {
    let upright = bent_triangle(true);
    let mut turned = upright.clone();
    for n in &mut turned.normals {
        *n = n.map(|x| -x);
    }
    let ray = ray_towards(Point3::new(0.4, 0.2, 3.0), Point3::new(0.3, 0.3, 0.0));
    let [a, b] = [upright, turned].map(|mesh| {
        let scene = mesh_scene(mesh, Transform::IDENTITY);
        Interaction::from_hit(&scene, &ray, &raw(3.0, [0.3, 0.3]))
    });
    assert!((a.ns.to_vec() - b.ns.to_vec()).length() < 1e-15);
    assert!((a.shape.apply(Vec3::X) - b.shape.apply(Vec3::X)).length() < 1e-15);
}

#[test]
fn the_origin_offset_covers_the_rounding_of_everything_that_enters() {
    let far = Transform::translate(Vec3::new(0.0, 1000.0, 0.0));
    let scene = mesh_scene(bent_triangle(false), far);
    let to = far.point(Point3::new(0.3, 0.3, 0.02));
    let at = Interaction::from_hit(&scene, &ray_towards(to + Vec3::Z, to), &raw(1.0, [0.3, 0.3]));
    let expected = pdembree::math::float::origin_offset(1001.0);
    assert!((at.error - expected).abs() < 1e-15 * expected, "{} against {expected}", at.error);
    let w = Dir3::new(Vec3::new(0.1, 0.0, -1.0)).expect("non-zero");
    assert!(((at.ray_origin(w) - at.p).dot(at.ng.to_vec()) + at.error).abs() < 1e-12, "to the side of w");
}

#[test]
fn degenerate_triangles_and_rays_in_the_plane_give_finite_numbers_and_say_so() {
    let flat = |positions: Vec<[f32; 3]>| TriangleMesh {
        colours: Vec::new(),
        deformation: None,
        positions,
        normals: vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0; 3]],
        uvs: vec![[0.5, 0.5]; 3],
        triangles: vec![[0, 1, 2]],
    };
    let point = vec![[0.2, 0.3, 0.4]; 3];
    let line = vec![[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]];
    let proper = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let in_plane = ray_towards(Point3::new(-1.0, 0.2, 0.0), Point3::new(0.0, 0.2, 0.0));
    for (positions, uv) in [(point, [0.2, 0.2]), (line, [0.5, f64::NAN]), (proper, [0.3, 0.2])] {
        let scene = mesh_scene(flat(positions), Transform::IDENTITY);
        let at = Interaction::from_hit(&scene, &in_plane, &raw(1.25, uv));
        assert!(!at.exact);
        assert!(at.p.is_finite() && at.t == 1.25 && at.error.is_finite(), "{at:?}");
        let place = at.parametrisation(&scene);
        for v in [at.ng.to_vec(), at.ns.to_vec(), place.dpdu, place.dpdv] {
            assert!(v.is_finite() && v.length() > 0.0, "{at:?}");
        }
        assert!(place.uv.is_finite() && at.shape.apply(Vec3::ONE).is_finite(), "{at:?}");
        assert!(place.dpdu.cross(place.dpdv).length() > 0.0, "{place:?}");
    }
}

#[test]
fn a_sphere_has_tangents_at_its_poles_too() {
    use pdembree::shape::{Shape, Sphere};
    let sphere = Shape::Sphere(Sphere::new(Point3::ORIGIN, 1.0).expect("valid"));
    let scene = shape_scene(sphere, Transform::IDENTITY);
    let ray = ray_towards(Point3::new(0.0, 0.0, 3.0), Point3::ORIGIN);
    let at = Interaction::from_hit(&scene, &ray, &raw(2.0, [0.0, 1.0]));
    let place = at.parametrisation(&scene);
    assert!((place.dpdu.cross(place.dpdv).length() - 1.0).abs() < 1e-15 && place.dpdu.dot(at.ng.to_vec()) == 0.0);
}

#[test]
fn texture_footprints_are_the_differences_of_the_texture_coordinates() {
    // A camera ray turned a little in two directions: the columns at the hit are the point's derivatives.
    let scene = mesh_scene(bent_triangle(true), oblique());
    let to = oblique().point(Point3::new(0.3, 0.3, 0.0));
    let origin = to + Vec3::new(0.3, 0.2, 4.0);
    let ray = ray_towards(origin, to);
    let hit = raw(4.0, [0.3, 0.3]);
    let at = Interaction::from_hit(&scene, &ray, &hit);
    let w = Dir3::new(ray.direction).expect("unit");
    let turns = [w.cross(Vec3::X), w.cross(Vec3::Y)];
    let columns = Differential::new(turns.map(Column::direction));
    let landed = pdembree::differential::transfer(&columns, w, at.t, at.ng);
    let exact = Lookup::filtered(&at.parametrisation(&scene), &landed).footprint;
    for (turn, exact) in turns.into_iter().zip(exact) {
        let [a, b] = [1e-6, -1e-6].map(|step| {
            let ray = Ray { direction: (ray.direction + turn * step).normalize(), ..ray };
            Interaction::from_hit(&scene, &ray, &hit).parametrisation(&scene).uv
        });
        let difference = (a - b) / 2e-6;
        assert!((difference - exact).length() < 1e-8 * exact.length(), "{difference} against {exact}");
    }
    let broken = Differential::new([Column::direction(Vec3::ZERO), Column::position(Vec3::NAN)]);
    assert_eq!(Lookup::filtered(&at.parametrisation(&scene), &broken).footprint, [Vec2::ZERO; 2]);
}

/// The backends that this build has.
fn backends(scene: &Scene) -> Vec<Box<dyn pdembree::backend::Backend>> {
    let kinds =
        [Some(BackendKind::Brute), Some(BackendKind::Obvhs), cfg!(feature = "embree").then_some(BackendKind::Embree)];
    let build = |kind| pdembree::backend::build(kind, scene).expect("a sound scene");
    kinds.into_iter().flatten().map(build).collect()
}

#[test]
fn a_ray_that_leaves_a_convex_body_never_meets_it_again_in_any_backend() {
    // Far from the origin, where f32 is coarse; once baked, once as an instance (a second use makes it one).
    let axis = Dir3::new(Vec3::new(1.0, 2.0, -0.5)).expect("non-zero");
    let far = Transform::translate(Vec3::new(120.0, -45.0, 80.0)).compose(&Transform::rotate(axis, 0.7));
    let elsewhere = Transform::translate(Vec3::new(1e4, 0.0, 0.0));
    let mesh = |to_world| ObjectGeometry::Mesh { mesh: MeshId(0), to_world };
    let baked = scene(vec![mesh(far)], vec![geode()]);
    let instanced = scene(vec![mesh(far), mesh(elsewhere)], vec![geode()]);
    for scene in [baked, instanced] {
        for backend in backends(&scene) {
            let name = backend.describe();
            let mut stream = random(950);
            for _ in 0..2000 {
                let to = far.point(Point3::from_vec(random_direction(&mut stream) * (0.9 * stream.uniform())));
                let ray = ray_towards(to + random_direction(&mut stream) * 3.0, to);
                let Some(hit) = backend.intersect(&ray) else { panic!("{name}: {ray:?} misses") };
                let at = Interaction::from_hit(&scene, &ray, &hit);
                let w = Dir3::new(random_direction(&mut stream)).expect("unit");
                let onward = Ray::new(at.ray_origin(w), w);
                let again = backend.intersect(&onward);
                if at.ng.dot(w) > 0.0 {
                    assert!(
                        again.is_none(),
                        "{name}: {onward:?} leaves triangle {} and meets {again:?}",
                        hit.primitive
                    );
                } else {
                    let met = again.unwrap_or_else(|| panic!("{name}: {onward:?} is lost inside"));
                    assert!(met.primitive != hit.primitive, "{name}: {onward:?} meets its own triangle at {}", met.t);
                }
            }
        }
    }
}
