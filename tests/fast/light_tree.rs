//! Many lights: each point looks at those that can light it, with the probability that is claimed.

use pdembree::light::{LightChoice, Lights, NormalCone, Receiver};
use pdembree::math::{Dir3, Normal3, Point3, Transform, Vec3};
use pdembree::radiometry::Spectrum;
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::{LightId, LightSource, MeshId, ObjectGeometry, ObjectId, Scene};
use pdembree::shape::{Disk, Shape, Sphere};

use crate::support::lights::tetrahedron;
use crate::support::scene::scene;
use crate::support::statistics::{assert_plausible, chi2_test};

const SEED: u64 = 61;

fn stream(i: u64) -> Stream {
    Stream::new(SEED, Purpose::Test, 0, i)
}

fn somewhere(stream: &mut Stream, within: f64) -> Point3 {
    let [x, y] = stream.uniform2();
    Point3::from_vec((Vec3::new(x, y, stream.uniform()) * 2.0 - Vec3::ONE) * within)
}

fn some_direction(stream: &mut Stream) -> Dir3 {
    loop {
        let v = somewhere(stream, 1.0).to_vec();
        if let Some(w) = Dir3::new(v).filter(|_| v.length() < 1.0) {
            return w;
        }
    }
}

/// `n` lights of all kinds that stand in a cube of 4 m, and one dark one; disks and spots look everywhere.
fn crowd(n: u32) -> Scene {
    let (mut geometry, mut lights) = (Vec::new(), Vec::new());
    for i in 0..n {
        let stream = &mut stream(i.into());
        let (p, w, size) = (somewhere(stream, 2.0), some_direction(stream), 0.02 + 0.2 * stream.uniform());
        let bright = Spectrum::splat(0.1 + 10.0 * stream.uniform().powi(4));
        let shape = match i % 5 {
            0 => Some(Shape::Disk(Disk::new(p, w.to_vec(), size).expect("a disk"))),
            1 => Some(Shape::Sphere(Sphere::new(p, size).expect("a sphere"))),
            _ => None,
        };
        let placed = match (shape, i % 5) {
            (Some(shape), _) => ObjectGeometry::Shape { shape, to_world: Transform::IDENTITY },
            (None, 2) => {
                let scale = Transform::scale(Vec3::splat(size)).expect("a scale");
                let to_world = Transform::translate(p.to_vec()).compose(&scale);
                ObjectGeometry::Mesh { mesh: MeshId(0), to_world }
            }
            (None, 3) => {
                let (cos_inner, cos_outer) = (0.9, 0.9 - stream.uniform());
                lights.push(LightSource::Spot { position: p, direction: w, intensity: bright, cos_inner, cos_outer });
                continue;
            }
            _ => {
                lights.push(LightSource::Point { position: p, intensity: bright });
                continue;
            }
        };
        lights.push(LightSource::Area {
            object: ObjectId(geometry.len() as u32),
            radiance: bright,
            two_sided: i % 10 == 0,
        });
        geometry.push(placed);
    }
    lights.push(LightSource::Point { position: Point3::ORIGIN, intensity: Spectrum::BLACK });
    let mut scene = scene(geometry, vec![tetrahedron()]);
    scene.lights = lights;
    scene
}

fn lights(scene: &Scene) -> Lights {
    Lights::new(scene).expect("all can emit")
}

/// Points among the lights and far from them, on surfaces and in media.
fn receivers(n: u64) -> impl Iterator<Item = Receiver> {
    (0..n).map(|i| {
        let stream = &mut stream(1_000_000 + i);
        let p = somewhere(stream, if i % 4 == 3 { 40.0 } else { 2.5 });
        let n = (i % 3 > 0).then(|| Normal3::from_unit(some_direction(stream).to_vec()));
        Receiver { p, n }
    })
}

fn pmfs(lights: &Lights, at: &Receiver) -> Vec<f64> {
    (0..lights.len() as u32).map(|i| lights.pick_pmf(at, LightId(i)).0).collect()
}

/// The sum over all lights is 1; a light of which something arrives has its chance, the dark one has none.
#[test]
fn every_light_that_arrives_can_be_chosen() {
    for with_sky in [false, true] {
        let mut scene = crowd(60);
        if with_sky {
            scene.lights.push(LightSource::Environment { radiance: Spectrum::ONE });
        }
        let lights = lights(&scene);
        for (k, at) in receivers(300).enumerate() {
            let pmf = pmfs(&lights, &at);
            let sum: f64 = pmf.iter().sum();
            assert!((sum - 1.0).abs() < 1e-12, "{at:?}: the chances add up to {sum}");
            assert_eq!(pmf[60], 0.0, "the dark light");
            for ((id, light), &pmf) in lights.iter().zip(&pmf) {
                let mut stream = stream(2_000_000 + k as u64);
                let arrives = (0..16).filter_map(|_| light.sample_li(at.p, stream.uniform2()));
                if pmf == 0.0 && arrives.into_iter().any(|li| !li.weight.is_zero()) {
                    assert_eq!(id.index(), 60, "light {id:?} reaches {at:?} and is never chosen");
                }
            }
        }
    }
}

/// Choices, and the numbers that they leave, are spread as is claimed.
#[test]
fn lights_are_chosen_as_often_as_is_claimed() {
    let mut scene = crowd(40);
    scene.lights.push(LightSource::Environment { radiance: Spectrum::ONE });
    let lights = lights(&scene);
    let (places, draws, cells) = (6, 40_000, 16);
    for at in receivers(places) {
        let pmf = pmfs(&lights, &at);
        let (mut chosen, mut reused) = (vec![0; pmf.len()], vec![0; cells]);
        let mut stream = stream(3_000_000);
        for _ in 0..draws {
            let LightChoice { light, pmf: claimed, reused: left } = lights.pick(&at, stream.uniform()).expect("light");
            assert!((claimed.0 - pmf[light.index()]).abs() <= 1e-12 * claimed.0, "{light:?}: {claimed:?}");
            chosen[light.index()] += 1;
            reused[(left * cells as f64) as usize] += 1;
        }
        let n = f64::from(draws);
        let expected: Vec<f64> = pmf.iter().map(|pmf| pmf * n).collect();
        let what = |of: &str| format!("{of} at {at:?}, seed {SEED}");
        assert_plausible(chi2_test(&chosen, &expected), 2 * places as usize, what("lights"));
        assert_plausible(chi2_test(&reused, &vec![n / cells as f64; cells]), 2 * places as usize, what("numbers left"));
    }
}

/// Up to four lights each has the chance that it had, wherever light is looked for.
#[test]
fn few_lights_are_chosen_alike_everywhere() {
    let lights = lights(&crowd(4));
    let [here, there] = [Point3::ORIGIN, Point3::new(9.0, 0.0, 0.0)].map(|p| pmfs(&lights, &Receiver { p, n: None }));
    assert_eq!(here, there);
    let many = self::lights(&crowd(5));
    let [here, there] = [Point3::ORIGIN, Point3::new(9.0, 0.0, 0.0)].map(|p| pmfs(&many, &Receiver { p, n: None }));
    assert_ne!(here, there);
}

/// Of a hundred equal lamps in a row the nearest is chosen far more often than one in a hundred times.
#[test]
fn near_lights_are_preferred() {
    let mut scene = crowd(0);
    let lamp = |i: u32| LightSource::Point { position: Point3::new(f64::from(i), 1.0, 0.0), intensity: Spectrum::ONE };
    scene.lights = (0..100).map(lamp).collect();
    let lights = lights(&scene);
    for i in [0, 37, 99] {
        let at = Receiver { p: Point3::new(f64::from(i), 0.0, 0.0), n: Some(Normal3::Y) };
        // In the middle of the row half of all light comes from it: 1/(1 + 2 Σ (1 + k²)^(−3/2)), with the cosine.
        let pmf = lights.pick_pmf(&at, LightId(i)).0;
        assert!(pmf > 0.2, "lamp {i}: {pmf}");
    }
}

/// Every direction within either of two cones lies within their union.
#[test]
fn a_union_of_cones_holds_both() {
    for i in 0..2000 {
        let stream = &mut stream(4_000_000 + i);
        let mut cone = || NormalCone { axis: some_direction(stream), spread: 3.0 * stream.uniform().powi(2) };
        let (a, b) = (cone(), cone());
        let both = a.union(b);
        for cone in [a, b] {
            let w = some_direction(stream);
            let across = Dir3::new(w.to_vec() - cone.axis * w.dot(cone.axis)).expect("not along the axis");
            let (sin, cos) = cone.spread.sin_cos();
            let rim = Dir3::new(cone.axis * cos + across * sin).expect("a unit vector");
            let angle = rim.cross(both.axis).length().atan2(rim.dot(both.axis));
            assert!(angle <= both.spread + 1e-9, "{a:?} and {b:?} in {both:?}: {angle}");
        }
    }
}
