//! User geometries: f64 answers against closed forms, and the nearest of spheres and triangles against brute force.

use embree4_sys::{CommittedScene, Hit, Ray, SceneBuilder, UserGeometry, UserHit, UserRay};
use support::{Random, Spheres, Vec3, add, corners, icosphere, normalize, ray, scale, sub, triangle};

mod support;

/// The first root within the ray's interval, by the same closed form that the callback uses, on the same f64 ray:
/// whatever is lost between the two is lost in the crate.
fn nearest_sphere(spheres: &Spheres, ray: &Ray) -> Option<(f64, u32)> {
    (0..spheres.0.len() as u32)
        .filter_map(|prim| {
            let roots = spheres.roots(prim, ray.origin, ray.direction)?;
            Some((roots.into_iter().find(|t| (ray.t_near..=ray.t_far).contains(t))?, prim))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

fn scene_of(spheres: &Spheres) -> CommittedScene {
    let mut builder = SceneBuilder::new(&support::device()).unwrap();
    builder.add_user(9, Spheres(spheres.0.clone())).unwrap();
    builder.commit().unwrap()
}

/// Rays along the axis hit at exactly |o| − r and |o| + r: a closed form that shares no code with the callback.
#[test]
fn an_axial_ray_meets_a_sphere_in_f64() {
    let scene = scene_of(&Spheres(vec![([0.0; 3], 1.0 / 3.0)]));
    const SEED: u64 = 0x5eed_0003;
    let mut random = Random(SEED);
    for case in 0..10_000 {
        let axis = random.direction();
        let distance = 0.5 + 10.0 * random.unit();
        let outside = ray(scale(axis, distance), scale(axis, -1.0));
        let hit = scene.intersect(&outside).unwrap();
        let hit = hit.unwrap_or_else(|| panic!("seed {SEED:#x}, ray {case}: lost"));
        let expected = distance - 1.0 / 3.0;
        assert!((hit.t - expected).abs() < 1e-12, "seed {SEED:#x}, ray {case}: {} is not {expected}", hit.t);
        assert_eq!((hit.u, hit.v), (0.1, hit.t / 3.0), "the parameters are the callback's, in f64");
        // From the surface itself on, the far side.
        let beyond = Ray { t_near: hit.t + 1e-9, ..outside };
        let far = scene.intersect(&beyond).unwrap().unwrap();
        assert!((far.t - (distance + 1.0 / 3.0)).abs() < 1e-12, "seed {SEED:#x}, ray {case}: {}", far.t);
    }
}

/// An f64 interval that f32 cannot tell apart still decides.
#[test]
fn the_interval_of_a_user_geometry_is_f64() {
    let spheres = Spheres(vec![([0.0; 3], 1.0)]);
    let scene = scene_of(&spheres);
    const SEED: u64 = 0x5eed_0004;
    let mut random = Random(SEED);
    for case in 0..10_000 {
        let origin = scale(random.direction(), 1.5 + 5.0 * random.unit());
        let target = scale(random.in_cube(), 0.5);
        let through = ray(origin, normalize(sub(target, origin)));
        let [t0, t1] = spheres.roots(0, through.origin, through.direction).expect("aimed at the inside");
        for (t_near, t_far) in [(0.0, t0 - 1e-12), (0.0, t0), (t0, t0), (t0 + 1e-12, t1), (t0 + 1e-12, t1 - 1e-12)] {
            let segment = Ray { t_near, t_far, ..through };
            let expected = [t0, t1].into_iter().find(|t| (t_near..=t_far).contains(t));
            let hit = scene.intersect(&segment).unwrap().map(|hit| hit.t);
            assert_eq!(hit, expected, "seed {SEED:#x}, ray {case}: {segment:?}");
            assert_eq!(scene.occluded(&segment), Ok(expected.is_some()), "seed {SEED:#x}, ray {case}: {segment:?}");
        }
    }
}

/// Concentric spheres 1e-10 apart: f32 cannot order them, the record does, and nothing farther is ever preferred.
#[test]
fn hits_closer_than_f32_are_ordered_in_f64() {
    let spheres = Spheres((0..64).map(|i| ([0.25, -0.5, 0.125], 1.0 + 1e-10 * f64::from((i * 37) % 64))).collect());
    let scene = scene_of(&spheres);
    const SEED: u64 = 0x5eed_0005;
    let mut random = Random(SEED);
    for case in 0..5_000 {
        let origin = scale(random.direction(), 3.0 + 5.0 * random.unit());
        let target = scale(random.in_cube(), 0.25);
        let ray = ray(origin, normalize(sub(target, origin)));
        let (t, prim) = nearest_sphere(&spheres, &ray).expect("aimed at the inside");
        let hit = scene.intersect(&ray).unwrap().unwrap();
        assert_eq!((hit.t, hit.primitive), (t, prim), "seed {SEED:#x}, ray {case}");
    }
}

/// Two coincident spheres: the smaller id, whatever the order of traversal.
#[test]
fn a_tie_goes_to_the_smaller_id() {
    let mut builder = SceneBuilder::new(&support::device()).unwrap();
    let twin = || Spheres(vec![([0.0; 3], 1.0); 3]);
    builder.add_user(8, twin()).unwrap();
    builder.add_user(4, twin()).unwrap();
    let scene = builder.commit().unwrap();
    let mut random = Random(0x5eed_0006);
    for _ in 0..1_000 {
        let axis = random.direction();
        let hit = scene.intersect(&ray(scale(axis, 4.0), scale(axis, -1.0))).unwrap().unwrap();
        assert_eq!((hit.geometry, hit.primitive), (4, 0));
    }
}

struct Mixed {
    spheres: Spheres,
    vertices: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    scene: CommittedScene,
}

const SPHERES: u32 = 6;
const MESH: u32 = 2;

fn mixed(random: &mut Random) -> Mixed {
    let spheres = Spheres((0..40).map(|_| (random.in_cube(), 0.05 + 0.15 * random.unit())).collect());
    let vertices: Vec<[f32; 3]> = (0..60)
        .flat_map(|_| {
            let center = random.in_cube();
            [0; 3].map(|_| add(center, scale(random.in_cube(), 0.4)).map(|x| x as f32))
        })
        .collect();
    let faces: Vec<[u32; 3]> = (0..60).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut builder = SceneBuilder::new(&support::device()).unwrap();
    builder.add_user(SPHERES, Spheres(spheres.0.clone())).unwrap();
    builder.add_mesh(MESH, &vertices, &faces).unwrap();
    let scene = builder.commit().unwrap();
    Mixed { spheres, vertices, faces, scene }
}

/// All candidates of brute force: (t, how far the hit is from a triangle's edge, geometry, primitive).
fn candidates(mixed: &Mixed, ray: &Ray) -> Vec<(f64, f64, u32, u32)> {
    let triangles = (0_u32..).zip(&mixed.faces).filter_map(|(prim, face)| {
        // A slightly larger triangle shows where f32 may see a hit that f64 does not.
        let [a, b, c] = corners(&mixed.vertices, *face);
        let middle: Vec3 = scale(add(a, add(b, c)), 1.0 / 3.0);
        let grown = [a, b, c].map(|corner| add(middle, scale(sub(corner, middle), 1.01)));
        let (t, u, v) = triangle(grown, ray.origin, ray.direction)?;
        Some((t, u.min(v).min(1.0 - u - v) - 0.01, MESH, prim))
    });
    let sphere = nearest_sphere(&mixed.spheres, ray).map(|(t, prim)| (t, f64::INFINITY, SPHERES, prim));
    triangles.chain(sphere).collect()
}

#[test]
fn the_nearest_of_spheres_and_triangles_agrees_with_brute_force() {
    const SEED: u64 = 0x5eed_0007;
    let mut random = Random(SEED);
    let (mut on_spheres, mut on_triangles) = (0, 0);
    for round in 0..20 {
        let mixed = mixed(&mut random);
        for case in 0..2_000 {
            let origin = scale(random.in_cube(), 2.0).map(|x| f64::from(x as f32));
            let direction = random.direction().map(|x| f64::from(x as f32));
            let ray = ray(origin, direction);
            let mut found = candidates(&mixed, &ray);
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            let hit = mixed.scene.intersect(&ray).unwrap();
            assert_eq!(mixed.scene.occluded(&ray), Ok(hit.is_some()), "seed {SEED:#x}, {round}/{case}");
            let Some(&(t, _, geometry, prim)) = found.first() else {
                assert_eq!(hit, None, "seed {SEED:#x}, {round}/{case}");
                continue;
            };
            // f32 decides about triangles: leave out rays near an edge, near ties with one, and starting on one.
            let unsure = found.iter().any(|c| c.2 == MESH && (c.1 < 0.01 || c.0 < 1e-3))
                || found.get(1).is_some_and(|next| next.0 - t < 1e-3 && (next.2 == MESH || geometry == MESH));
            if unsure {
                continue;
            }
            let hit = hit.unwrap_or_else(|| panic!("seed {SEED:#x}, {round}/{case}: lost a hit at {t}"));
            assert_eq!((hit.geometry, hit.primitive), (geometry, prim), "seed {SEED:#x}, {round}/{case}: {found:?}");
            if geometry == SPHERES {
                on_spheres += 1;
                assert!((hit.t - t).abs() < 1e-12, "seed {SEED:#x}, {round}/{case}: {} is not {t}", hit.t);
            } else {
                on_triangles += 1;
                assert_eq!(f64::from(hit.t as f32), hit.t, "a triangle's t is an f32 number");
            }
        }
    }
    assert!(on_spheres > 2_000 && on_triangles > 2_000, "{on_spheres} on spheres, {on_triangles} on triangles");
}

/// A sphere inscribed in a facetted one, so that at the facets' middles the two nearly touch: whichever is nearer by
/// more than f32 can tell must win, and the f64 value is reported only for the sphere.
#[test]
fn a_triangle_that_is_nearer_overrides_an_accepted_user_hit() {
    let (vertices, faces) = icosphere(2);
    const SEED: u64 = 0x5eed_0008;
    let mut random = Random(SEED);
    for offset in [-1e-3, -1e-5, 1e-5, 1e-3] {
        for prim in 0..faces.len() as u32 {
            let [a, b, c] = corners(&vertices, faces[prim as usize]);
            let middle = scale(add(a, add(b, c)), 1.0 / 3.0);
            let away = normalize(middle);
            // A small sphere whose nearest point along the ray is `offset` beyond the facet.
            let radius = 0.2;
            let center = scale(away, support::dot(middle, away) - radius - offset);
            let mut builder = SceneBuilder::new(&support::device()).unwrap();
            builder.add_mesh(MESH, &vertices, &faces).unwrap();
            builder.add_user(SPHERES, Spheres(vec![(center, radius)])).unwrap();
            let scene = builder.commit().unwrap();
            let distance = 1.5 + random.unit();
            let hit = scene.intersect(&ray(scale(away, distance), scale(away, -1.0))).unwrap().unwrap();
            let nearer = if offset > 0.0 { MESH } else { SPHERES };
            assert_eq!(hit.geometry, nearer, "seed {SEED:#x}, facet {prim}, offset {offset}");
            if nearer == SPHERES {
                let expected = distance - support::dot(middle, away) + offset;
                assert!((hit.t - expected).abs() < 1e-12, "seed {SEED:#x}, facet {prim}: {} {expected}", hit.t);
            }
        }
    }
}

/// What a user geometry answers at each query, whatever the ray.
struct Stubborn<F>(F);

impl<F: Fn(&UserRay) -> Option<UserHit> + Send + Sync + 'static> UserGeometry for Stubborn<F> {
    fn primitives(&self) -> u32 {
        1
    }

    fn bounds(&self, _: u32) -> ([f32; 3], [f32; 3]) {
        ([-1.0; 3], [1.0; 3])
    }

    fn intersect(&self, _: u32, ray: &UserRay) -> Option<UserHit> {
        (self.0)(ray)
    }
}

fn ask(answer: fn(&UserRay) -> Option<UserHit>) -> (Option<Hit>, bool) {
    let mut builder = SceneBuilder::new(&support::device()).unwrap();
    builder.add_user(0, Stubborn(answer)).unwrap();
    let scene = builder.commit().unwrap();
    let ray = Ray { origin: [0.1, 0.2, 3.0], direction: [0.0, 0.0, -1.0], t_near: 1.0, t_far: 5.0, time: 0.0 };
    (scene.intersect(&ray).unwrap(), scene.occluded(&ray).unwrap())
}

#[test]
fn answers_outside_of_the_interval_count_as_none() {
    assert!(ask(|ray| Some(UserHit { t: 0.5 * (ray.t_near + ray.t_far), u: 0.0, v: 0.0, part: 0 })).0.is_some());
    assert_eq!(ask(|_| None), (None, false));
    let wrong: [fn(&UserRay) -> Option<UserHit>; 5] = [
        |_| Some(UserHit { t: f64::NAN, u: 0.0, v: 0.0, part: 0 }),
        |_| Some(UserHit { t: f64::INFINITY, u: 0.0, v: 0.0, part: 0 }),
        |_| Some(UserHit { t: -1.0, u: 0.0, v: 0.0, part: 0 }),
        |ray| Some(UserHit { t: ray.t_near - 1e-12, u: 0.0, v: 0.0, part: 0 }),
        |ray| Some(UserHit { t: ray.t_far + 1e-12, u: 0.0, v: 0.0, part: 0 }),
    ];
    for (case, answer) in wrong.into_iter().enumerate() {
        assert_eq!(ask(answer), (None, false), "case {case}");
    }
}

/// A ball that goes along x with time: it answers where it is when the ray flies, and names what it was asked.
#[test]
fn a_user_geometry_sees_the_rays_time_and_numbers_its_parts() {
    let answer = |ray: &UserRay| {
        let half = 1.0 - (ray.origin[0] - ray.time).powi(2);
        (half > 0.0).then(|| UserHit {
            t: ray.origin[2] - half.sqrt(),
            u: ray.time,
            v: 0.0,
            part: (4.0 * ray.time) as u32,
        })
    };
    let mut builder = SceneBuilder::new(&support::device()).unwrap();
    builder.add_user(0, Stubborn(answer)).unwrap();
    let scene = builder.commit().unwrap();
    for time in [0.0, 0.25, 0.5, 0.75] {
        let down = Ray { time, ..ray([time, 0.0, 3.0], [0.0, 0.0, -1.0]) };
        let hit = scene.intersect(&down).unwrap().unwrap();
        assert_eq!((hit.t, hit.u, hit.part), (2.0, time, (4.0 * time) as u32));
        let late = Ray { time: time + 1.5, ..down };
        assert_eq!((scene.intersect(&late), scene.occluded(&late)), (Ok(None), Ok(false)));
    }
}

/// A mesh in a scene of its own, asked from within a callback of another one.
#[test]
fn a_user_geometry_may_ask_another_scene() {
    let device = support::device();
    let mut builder = SceneBuilder::new(&device).unwrap();
    let (vertices, triangles) = icosphere(1);
    builder.add_mesh(MESH, &vertices, &triangles).unwrap();
    let inner = builder.commit().unwrap();
    let alone = {
        let mut builder = SceneBuilder::new(&device).unwrap();
        builder.add_mesh(MESH, &vertices, &triangles).unwrap();
        builder.commit().unwrap()
    };
    let answer = move |ray: &UserRay| {
        let UserRay { origin, direction, t_near, t_far, time } = *ray;
        let hit = inner.intersect(&Ray { origin, direction, t_near, t_far, time }).ok()??;
        Some(UserHit { t: hit.t, u: hit.u, v: hit.v, part: hit.primitive })
    };
    let mut builder = SceneBuilder::new(&device).unwrap();
    builder.add_user(0, Stubborn(answer)).unwrap();
    let scene = builder.commit().unwrap();
    const SEED: u64 = 0x5eed_0011;
    let mut random = Random(SEED);
    let mut hits = 0;
    for case in 0..10_000 {
        let origin = scale(random.direction(), 3.0);
        let towards = ray(origin, normalize(sub(scale(random.in_cube(), 1.2), origin)));
        let found = scene.intersect(&towards).unwrap().map(|hit| (hit.t, hit.u, hit.v, hit.part));
        let expected = alone.intersect(&towards).unwrap().map(|hit| (hit.t, hit.u, hit.v, hit.primitive));
        assert_eq!(found, expected, "seed {SEED:#x}, ray {case}");
        assert_eq!(scene.occluded(&towards).unwrap(), expected.is_some(), "seed {SEED:#x}, ray {case}");
        hits += u32::from(found.is_some());
    }
    assert!(hits > 2000, "only {hits} hits");
}

/// Unwinding through Embree's frames would be undefined behaviour; the process ends instead.
#[test]
fn a_panic_in_a_callback_aborts() {
    const CHILD: &str = "EMBREE4_SYS_TEST_PANIC";
    if std::env::var_os(CHILD).is_some() {
        let caught = std::panic::catch_unwind(|| ask(|_| panic!("from the callback")));
        unreachable!("the panic came through Embree: {}", caught.is_err());
    }
    let output = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "a_panic_in_a_callback_aborts", "--nocapture"])
        .env(CHILD, "1")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), None, "ended by a signal, not by itself: {text}");
    assert!(text.contains("from the callback") && !text.contains("came through Embree"), "{text}");
}

/// Rays that touch a sphere's pole from inside by 1e-12 to 1e-7 of its radius: in f32 they run in the box's face or
/// outside of it. The padding of the boxes must let all of them reach the callback.
#[test]
fn grazing_rays_are_not_lost() {
    const SEED: u64 = 0x5eed_000b;
    let mut random = Random(SEED);
    let spheres =
        Spheres((0..30).map(|_| (scale(random.in_cube(), 8.0), 0.05 + 0.4 * random.unit())).collect::<Vec<_>>());
    let scene = scene_of(&spheres);
    let mut touched = 0;
    for case in 0..30_000 {
        let prim = (random.bits() % 30) as u32;
        let (center, radius) = spheres.0[prim as usize];
        let axis = (random.bits() % 3) as usize;
        let depth = 10.0_f64.powf(-12.0 + 5.0 * random.unit());
        let mut point = center;
        point[axis] += radius * (1.0 - depth) * if random.unit() < 0.5 { 1.0 } else { -1.0 };
        // Within the plane that touches the pole; sometimes along another axis of the box.
        let mut direction = random.direction();
        direction[axis] = 0.0;
        if case % 3 == 0 {
            direction[(axis + 1) % 3] = 0.0;
        }
        let direction = normalize(direction);
        let ray = ray(sub(point, scale(direction, 10.0 * random.unit())), direction);
        let Some((t, prim)) = nearest_sphere(&spheres, &ray) else { continue };
        touched += 1;
        let hit = scene.intersect(&ray).unwrap().map(|hit| (hit.t, hit.primitive));
        assert_eq!(hit, Some((t, prim)), "seed {SEED:#x}, ray {case}: {ray:?}");
        assert_eq!(scene.occluded(&ray), Ok(true), "seed {SEED:#x}, ray {case}: {ray:?}");
    }
    assert!(touched > 20_000, "only {touched} rays have a hit in f64");
}

/// Embree visits instances after user geometries, and its f32 end lies a little behind an accepted user hit: the
/// triangle in the slack is found, and must not win.
#[test]
fn a_triangle_in_the_slack_behind_a_user_hit_does_not_win() {
    let device = support::device();
    let mut builder = SceneBuilder::new(&device).unwrap();
    builder.add_mesh(MESH, &[[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]], &[[0, 1, 2]]).unwrap();
    let mesh = builder.commit().unwrap();
    let down = ray([0.1, 0.2, 3.0], [0.0, 0.0, -1.0]);
    let triangle = mesh.intersect(&down).unwrap().unwrap().t;
    // One unit in the last place of 3 is 2.4e-7 in f32.
    for offset in [-1e-6, -1e-10, 1e-10, 1e-6] {
        let (t, geometry) = if offset < 0.0 { (triangle + offset, SPHERES) } else { (triangle, MESH) };
        let answer = move |ray: &UserRay| {
            let t = triangle + offset;
            (t <= ray.t_far).then_some(UserHit { t, u: 0.5, v: 0.25, part: 0 })
        };
        let mut builder = SceneBuilder::new(&device).unwrap();
        let one = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        builder.add_instance(1, &mesh, &one).unwrap();
        builder.add_user(SPHERES, Stubborn(answer)).unwrap();
        let scene = builder.commit().unwrap();
        let hit = scene.intersect(&down).unwrap().unwrap();
        assert_eq!((hit.t, hit.geometry, hit.instance.is_some()), (t, geometry, geometry == MESH));
        if geometry == SPHERES {
            assert_eq!((hit.u, hit.v), (0.5, 0.25));
        }
    }
}
