//! Queries against brute force and closed forms, bad rays and bad scenes.

use embree4_sys::{CommittedScene, Device, InvalidRay, MAX_GEOMETRY_ID, Ray, SceneBuilder, SceneError};
use support::{Random, Vec3, add, corners, dot, icosphere, normalize, ray, scale, sub, triangle};

mod support;

const QUAD: ([[f32; 3]; 4], [[u32; 3]; 2]) =
    ([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]], [[0, 1, 2], [0, 2, 3]]);

fn quad(device: &Device) -> CommittedScene {
    let mut builder = SceneBuilder::new(device).unwrap();
    builder.add_mesh(5, &QUAD.0, &QUAD.1).unwrap();
    builder.commit().unwrap()
}

#[test]
fn a_hit_has_the_ids_and_barycentric_weights_of_the_closed_form() {
    let scene = quad(&support::device());
    // p = (1 − u − v) a + u b + v c on triangle (0, 1, 2): x = −1 + 2u + 2v, y = −1 + 2v.
    let down =
        Ray { origin: [0.25, -0.5, 3.0], direction: [0.0, 0.0, -2.0], t_near: 0.0, t_far: f64::INFINITY, time: 0.0 };
    let hit = scene.intersect(&down).unwrap().unwrap();
    assert_eq!((hit.geometry, hit.primitive, hit.instance), (5, 0, None));
    // A dozen f32 roundings, of numbers up to 8 (the edge functions), over a determinant of 8.
    for (value, expected) in [(hit.t, 1.5), (hit.u, 0.375), (hit.v, 0.25)] {
        assert!((value - expected).abs() < 12.0 * 2.0_f64.powi(-24) * 3.0, "{hit:?}");
    }
    assert!(scene.occluded(&down).unwrap());
    let up = Ray { direction: [0.0, 0.0, 2.0], ..down };
    assert_eq!(scene.intersect(&up), Ok(None));
    assert_eq!(scene.occluded(&up), Ok(false));
}

#[test]
fn the_interval_holds_in_f64() {
    let scene = quad(&support::device());
    let at = |t_near: f64, t_far: f64| {
        let ray = Ray { origin: [0.1, 0.2, 3.0], direction: [0.0, 0.0, -1.0], t_near, t_far, time: 0.0 };
        let hit = scene.intersect(&ray).unwrap().is_some();
        assert_eq!(scene.occluded(&ray), Ok(hit), "{ray:?}");
        hit
    };
    // The f32 number nearest to each of these ends is the hit's t itself: only rounding the right way decides.
    let t = scene.intersect(&ray([0.1, 0.2, 3.0], [0.0, 0.0, -1.0])).unwrap().unwrap().t;
    assert_eq!(f64::from((t - 1e-9) as f32), t);
    assert!(at(0.0, t) && at(t, t) && at(0.0, t + 1e-9) && at(t - 1e-9, 4.0));
    assert!(!at(0.0, t - 1e-9), "an end before the hit");
    assert!(!at(t + 1e-9, 4.0), "a start behind the hit");
    assert!(!at(4.0, 2.0), "an end before the start");
    assert!(!at(0.0, -1.0) && !at(0.0, f64::NEG_INFINITY));
}

#[test]
fn nearest_triangles_agree_with_brute_force() {
    const SEED: u64 = 0x5eed_0001;
    let mut random = Random(SEED);
    let soup: Vec<[f32; 3]> = (0..300).map(|_| random.in_cube().map(|x| x as f32)).collect();
    let faces: Vec<[u32; 3]> = (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut builder = SceneBuilder::new(&support::device()).unwrap();
    builder.add_mesh(0, &soup, &faces).unwrap();
    let scene = builder.commit().unwrap();
    let mut hits = 0;
    for case in 0..20_000 {
        // f32 numbers, so that both sides trace the same ray.
        let origin = scale(random.in_cube(), 2.0).map(|x| f64::from(x as f32));
        let direction = random.direction().map(|x| f64::from(x as f32));
        let found: Vec<(f64, f64, f64, u32)> = (0_u32..)
            .zip(&faces)
            .filter_map(|(prim, face)| {
                triangle(corners(&soup, *face), origin, direction).map(|(t, u, v)| (t, u, v, prim))
            })
            .collect();
        let Some(&(t, u, v, prim)) = found.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else {
            continue;
        };
        // Where f32 may decide otherwise there is nothing to compare: silhouettes, near ties, grazing incidence, the
        // ray's start.
        let edge = u.min(v).min(1.0 - u - v);
        let [a, b, c] = corners(&soup, faces[prim as usize]);
        let normal = support::cross(sub(b, a), sub(c, a));
        let grazing = dot(normal, direction).abs();
        let tied = found.iter().any(|other| other.3 != prim && other.0 - t < 1e-3);
        if edge < 1e-3 || tied || grazing < 1e-2 || t < 1e-3 {
            continue;
        }
        hits += 1;
        let hit = scene.intersect(&ray(origin, direction)).unwrap();
        let hit = hit.unwrap_or_else(|| panic!("seed {SEED:#x}, ray {case}: lost a hit at {t}"));
        // An f32 determinant of edges up to 2√3 long errs by some 10 roundings of its largest term, about 10² units
        // of 2⁻²⁴ over the determinant.
        let bound = 200.0 * 2.0_f64.powi(-24) / grazing * 4.0;
        let error = (hit.t - t).abs().max((hit.u - u).abs()).max((hit.v - v).abs());
        assert!(hit.primitive == prim && error <= bound, "seed {SEED:#x}, ray {case}: {hit:?}, not {t} {u} {v} {prim}");
    }
    assert!(hits > 2_000, "only {hits} rays could be compared");
}

#[test]
fn an_instance_is_hit_where_its_transform_puts_it() {
    let device = support::device();
    let (vertices, faces) = icosphere(3);
    let mut builder = SceneBuilder::new(&device).unwrap();
    builder.add_mesh(2, &vertices, &faces).unwrap();
    let sphere = builder.commit().unwrap();
    // A rotation by the 3-4-5 angle, a stretch and a translation; a second instance is only moved.
    let transform = [[1.8, -0.8, 0.0, 4.0], [2.4, 0.6, 0.0, -1.0], [0.0, 0.0, 0.5, 2.0]];
    let mut builder = SceneBuilder::new(&device).unwrap();
    builder.add_instance(11, &sphere, &transform).unwrap();
    let moved = [[1.0, 0.0, 0.0, -20.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    builder.add_instance(12, &sphere, &moved).unwrap();
    builder.add_mesh(13, &QUAD.0, &QUAD.1).unwrap();
    let scene = builder.commit().unwrap();
    drop(sphere);

    let apply = |p: Vec3, w: f64| transform.map(|[x, y, z, t]| x * p[0] + y * p[1] + z * p[2] + w * t);
    const SEED: u64 = 0x5eed_0002;
    let mut random = Random(SEED);
    for case in 0..2_000 {
        // Aim at a point inside a facet, from outside along its normal as the instanced scene sees it.
        let prim = (random.bits() % faces.len() as u64) as u32;
        let [a, b, c] = corners(&vertices, faces[prim as usize]);
        let (u, v) = (0.2 + 0.2 * random.unit(), 0.2 + 0.2 * random.unit());
        let point = add(scale(a, 1.0 - u - v), add(scale(b, u), scale(c, v)));
        let outside = add(point, scale(normalize(point), 0.5));
        let origin = apply(outside, 1.0);
        let direction = sub(apply(point, 1.0), origin);
        let hit = scene.intersect(&ray(origin, direction)).unwrap();
        let hit = hit.unwrap_or_else(|| panic!("seed {SEED:#x}, ray {case}: lost"));
        assert_eq!((hit.geometry, hit.instance, hit.primitive), (2, Some(11), prim), "seed {SEED:#x}, ray {case}");
        // t = 1 at the point; coordinates up to 8, the step 0.15 at least (0.5 times the transform's 0.5, less the
        // angle), and about ten roundings on the way: 8 · 10 · 2⁻²⁴ / 0.15.
        assert!((hit.t - 1.0).abs() < 4e-5, "seed {SEED:#x}, ray {case}: t = {}", hit.t);
        assert!((hit.u - u).abs() < 1e-3 && (hit.v - v).abs() < 1e-3, "seed {SEED:#x}, ray {case}: {hit:?}");
    }
    let at_second = scene.intersect(&ray([-20.0, 0.1, 9.0], [0.0, 0.0, -1.0])).unwrap().unwrap();
    assert_eq!((at_second.geometry, at_second.instance), (2, Some(12)));
    let at_quad = scene.intersect(&ray([0.1, 0.2, 9.0], [0.0, 0.0, -1.0])).unwrap().unwrap();
    assert_eq!((at_quad.geometry, at_quad.instance), (13, None));
}

#[test]
fn invalid_rays_are_refused_and_do_not_end_the_process() {
    let scene = quad(&support::device());
    let good =
        Ray { origin: [0.1, 0.2, 3.0], direction: [0.0, 0.0, -1.0], t_near: 0.0, t_far: f64::INFINITY, time: 0.0 };
    let mut cases = vec![
        (Ray { t_near: -1e-9, ..good }, InvalidRay::TNear),
        (Ray { t_near: f64::NAN, ..good }, InvalidRay::TNear),
        (Ray { t_near: f64::INFINITY, ..good }, InvalidRay::TNear),
        (Ray { t_near: 1e39, ..good }, InvalidRay::TNear),
        (Ray { t_far: f64::NAN, ..good }, InvalidRay::TFar),
        (Ray { direction: [0.0; 3], ..good }, InvalidRay::ShortDirection),
        (Ray { direction: [0.0, -0.0, 1e-46], ..good }, InvalidRay::ShortDirection),
    ];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e19, -1e19, 1e39, f64::MAX] {
        for axis in 0..3 {
            let (mut origin, mut direction) = (good.origin, good.direction);
            origin[axis] = bad;
            direction[axis] = bad;
            cases.push((Ray { origin, ..good }, InvalidRay::Origin));
            cases.push((Ray { direction, ..good }, InvalidRay::Direction));
        }
    }
    for (ray, why) in cases {
        assert_eq!(scene.intersect(&ray), Err(why), "{ray:?}");
        assert_eq!(scene.occluded(&ray), Err(why), "{ray:?}");
    }
    assert!(scene.intersect(&good).unwrap().is_some(), "the valid ray that the others were made of");
}

/// Every valid ray is traced, at the limits too: nothing in Embree asserts.
#[test]
fn rays_at_the_limits_are_traced() {
    use embree4_sys::{MAX_COORDINATE, MAX_DIRECTION, MIN_DIRECTION};
    let device = support::device();
    let mesh = quad(&device);
    let mut builder = SceneBuilder::new(&device).unwrap();
    builder.add_mesh(0, &QUAD.0, &QUAD.1).unwrap();
    let tiny = [[1e-7, 0.0, 0.0, 0.0], [0.0, 1e-7, 0.0, 0.0], [0.0, 0.0, 1e-7, 0.0]];
    builder.add_instance(1, &mesh, &tiny).unwrap();
    builder.add_user(2, support::Spheres(vec![([0.0; 3], 2.0)])).unwrap();
    let scene = builder.commit().unwrap();
    for origin in [0.0, MAX_COORDINATE, -MAX_COORDINATE, 1e-300] {
        for component in [MAX_DIRECTION, -MAX_DIRECTION, MIN_DIRECTION, -MIN_DIRECTION] {
            for (t_near, t_far) in [(0.0, f64::INFINITY), (0.0, 0.0), (0.0, f64::MAX), (3e38, f64::MAX)] {
                for direction in [[component; 3], [component, 0.0, 0.0], [0.0, 1e-300, component]] {
                    let ray = Ray { origin: [origin; 3], direction, t_near, t_far, time: 0.0 };
                    assert!(scene.intersect(&ray).is_ok() && scene.occluded(&ray).is_ok(), "{ray:?}");
                }
            }
        }
    }
    // At this distance f32 cannot tell the scene's parts apart, but it does not lose them all.
    let far = ray([0.0, 0.0, MAX_COORDINATE], [0.0, 0.0, -MAX_DIRECTION]);
    assert!(scene.intersect(&far).unwrap().is_some() && scene.occluded(&far).unwrap());
}

#[test]
fn an_empty_scene_hits_nothing() {
    let scene = SceneBuilder::new(&support::device()).unwrap().commit().unwrap();
    assert_eq!(scene.intersect(&ray([0.0; 3], [0.0, 0.0, 1.0])), Ok(None));
    assert_eq!(scene.occluded(&ray([0.0; 3], [0.0, 0.0, 1.0])), Ok(false));
}

#[test]
fn bad_geometry_is_refused_and_the_builder_stays_usable() {
    let device = support::device();
    let mut builder = SceneBuilder::new(&device).unwrap();
    let (vertices, faces) = QUAD;
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e10, -f32::MAX] {
        let mut broken = vertices;
        broken[2][1] = bad;
        let error = builder.add_mesh(0, &broken, &faces).unwrap_err();
        assert!(matches!(error, SceneError::BadVertex { geometry: 0, vertex: 2, .. }), "{error}");
    }
    let error = builder.add_mesh(0, &vertices, &[[0, 1, 2], [0, 4, 1]]).unwrap_err();
    assert_eq!(error, SceneError::BadIndex { geometry: 0, triangle: 1, index: 4, vertices: 4 });
    assert_eq!(builder.add_mesh(0, &vertices, &[]), Err(SceneError::Empty { geometry: 0 }));
    assert_eq!(builder.add_mesh(0, &[], &faces), Err(SceneError::Empty { geometry: 0 }));
    let huge = MAX_GEOMETRY_ID + 1;
    assert_eq!(builder.add_mesh(huge, &vertices, &faces), Err(SceneError::IdTooLarge { geometry: huge }));
    builder.add_mesh(0, &vertices, &faces).unwrap();
    assert_eq!(builder.add_mesh(0, &vertices, &faces), Err(SceneError::DuplicateId { geometry: 0 }));
    let spheres = |center, radius| support::Spheres(vec![(center, radius)]);
    assert_eq!(builder.add_user(0, spheres([0.0; 3], 1.0)), Err(SceneError::DuplicateId { geometry: 0 }));
    assert_eq!(builder.add_user(1, support::Spheres(vec![])), Err(SceneError::Empty { geometry: 1 }));
    for (center, radius) in [([f64::NAN, 0.0, 0.0], 1.0), ([0.0; 3], -1.0), ([0.0; 3], 1e11)] {
        let error = builder.add_user(1, spheres(center, radius)).unwrap_err();
        assert!(matches!(error, SceneError::BadBounds { geometry: 1, primitive: 0, .. }), "{error}");
    }
    let scene = builder.commit().unwrap();
    assert!(scene.intersect(&ray([0.1, 0.2, 3.0], [0.0, 0.0, -1.0])).unwrap().is_some());
}

#[test]
fn bad_instances_are_refused() {
    let device = support::device();
    let mesh = quad(&device);
    let one = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let mut builder = SceneBuilder::new(&device).unwrap();
    for (entry, value) in [(0, 0.0), (0, f64::NAN), (0, 1e39), (3, f64::INFINITY), (3, 1e11), (0, 1e-9), (0, 1e11)] {
        let mut transform = one;
        transform[0][entry] = value;
        let error = builder.add_instance(4, &mesh, &transform).unwrap_err();
        assert_eq!(error, SceneError::BadTransform { geometry: 4 }, "{value}");
    }
    let foreign = quad(&support::device());
    assert_eq!(builder.add_instance(4, &foreign, &one), Err(SceneError::OtherDevice { geometry: 4 }));
    let mut user = SceneBuilder::new(&device).unwrap();
    user.add_user(0, support::Spheres(vec![([0.0; 3], 1.0)])).unwrap();
    let user = user.commit().unwrap();
    assert_eq!(builder.add_instance(4, &user, &one), Err(SceneError::InstancedUserGeometry { geometry: 4 }));
    builder.add_instance(4, &mesh, &one).unwrap();
    let nested = builder.commit().unwrap();
    let mut builder = SceneBuilder::new(&device).unwrap();
    assert_eq!(builder.add_instance(4, &nested, &one), Err(SceneError::NestedInstance { geometry: 4 }));
}

/// A quad that goes from z = 0 to 1 and back to 0, from 2 to 4 of the ray's unit of time, alone and instanced.
#[test]
fn a_moving_mesh_is_hit_where_it_is_at_the_rays_time() {
    let device = support::device();
    let raised = |z: f32| QUAD.0.map(|[x, y, _]| [x, y, z]);
    let frames = [0.0, 1.0, 0.0].map(raised);
    let frames: Vec<&[[f32; 3]]> = frames.iter().map(<[[f32; 3]; 4]>::as_slice).collect();
    let moving = |start: f64, end: f64| {
        let mut builder = SceneBuilder::new(&device).unwrap().over(2.0, 4.0);
        builder.add_moving_mesh(3, &frames, [start, end], &QUAD.1).unwrap();
        builder.commit().unwrap()
    };
    let (whole, beyond) = (moving(2.0, 4.0), moving(1.0, 5.0));
    let mut builder = SceneBuilder::new(&device).unwrap().over(2.0, 4.0);
    let same = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    builder.add_instance(9, &whole, &same).unwrap();
    let instanced = builder.commit().unwrap();
    for i in 0..=40 {
        let time = 2.0 + f64::from(i) / 20.0;
        let down = Ray { time, ..ray([0.25, -0.5, 3.0], [0.0, 0.0, -1.0]) };
        let height = |start: f64, end: f64| 1.0 - ((time - start) / (end - start) * 2.0 - 1.0).abs();
        for (scene, z) in [(&whole, height(2.0, 4.0)), (&instanced, height(2.0, 4.0)), (&beyond, height(1.0, 5.0))] {
            let hit = scene.intersect(&down).unwrap().unwrap();
            // A few f32 roundings of numbers up to 4.
            assert!((hit.t - (3.0 - z)).abs() < 16.0 * 2.0_f64.powi(-24) * 4.0, "at {time}: {hit:?}");
            assert!(scene.occluded(&down).unwrap());
        }
    }
    // Other times are the ends.
    for time in [-1e300, 0.0, 9.0, f64::INFINITY, f64::NAN] {
        let hit = whole.intersect(&Ray { time, ..ray([0.25, -0.5, 3.0], [0.0, 0.0, -1.0]) }).unwrap().unwrap();
        assert!((hit.t - 3.0).abs() < 1e-6, "at {time}: {hit:?}");
    }
}

/// Vertices of each frame.
type Frames<'a> = &'a [&'a [[f32; 3]]];

#[test]
fn frames_that_do_not_fit_are_refused() {
    let device = support::device();
    let mut builder = SceneBuilder::new(&device).unwrap().over(0.0, 1.0);
    let (four, three): (&[[f32; 3]], &[[f32; 3]]) = (&QUAD.0, &QUAD.0[..3]);
    let many = vec![four; embree4_sys::MAX_TIME_STEPS + 1];
    let bad: [(Frames, [f64; 2]); 6] = [
        (&[four], [0.0, 1.0]),
        (&[four, three], [0.0, 1.0]),
        (&many, [0.0, 1.0]),
        (&[four, four], [1.0, 0.0]),
        (&[four, four], [0.0, f64::NAN]),
        (&[four, four], [0.0, f64::INFINITY]),
    ];
    for (frames, times) in bad {
        let refused = builder.add_moving_mesh(1, frames, times, &QUAD.1);
        assert_eq!(refused, Err(SceneError::BadFrames { geometry: 1 }), "{times:?}");
    }
    let lost = builder.add_moving_mesh(1, &[four, &[[f32::NAN; 3]; 4]], [0.0, 1.0], &QUAD.1);
    assert!(matches!(lost, Err(SceneError::BadVertex { geometry: 1, vertex: 0, .. })));
    builder.add_moving_mesh(1, &vec![four; embree4_sys::MAX_TIME_STEPS], [0.0, 1.0], &QUAD.1).unwrap();
    builder.commit().unwrap();
}
