//! Lights as hypotheses: what they emit in total, where to, and what arrives, from both ends of the ray.

use std::f64::consts::PI;

use pdembree::light::{Aim, AreaLight, EnvironmentLight, Light, PointLight};
use pdembree::math::{Frame, Normal3, Point3, Transform, Vec3};
use pdembree::radiometry::{Intensity, Radiance};
use pdembree::sampling::warp::{ConcentricDisk, Warp};
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::TriangleMesh;
use pdembree::shape::{Disk, Rectangle, Shape, Sphere};

use crate::support::lights::{COLOUR, SCENE, cases, lights};
use crate::support::statistics::{Moments, assert_plausible, t_test, welch};

const SEED: u64 = 99;

fn uniform4(stream: &mut Stream) -> [f64; 4] {
    let ([a, b], [c, d]) = (stream.uniform2(), stream.uniform2());
    [a, b, c, d]
}

#[test]
fn the_mean_of_emissions_is_the_emitted_flux() {
    const DRAWS: usize = 20_000;
    let all = cases();
    for (i, case) in all.iter().enumerate() {
        let mut stream = Stream::new(SEED, Purpose::Test, 0, i as u64);
        let sample: Moments = (0..DRAWS)
            .map(|_| case.light.emit(uniform4(&mut stream), &case.aim).map_or(0.0, |e| e.flux.0.luminance()))
            .collect();
        let expected = case.light.emitted_flux(&case.aim).0.luminance();
        let what = format!("{}: {sample} against {expected:.6e}, seed {SEED}", case.name);
        if sample.variance().sqrt() <= 64.0 * f64::EPSILON * sample.mean {
            // The same flux from every sample but for rounding; the quadrature adds 64² terms.
            assert!((sample.mean - expected).abs() <= 4096.0 * f64::EPSILON * expected, "{what}");
        } else {
            assert_plausible(t_test(&sample, expected), all.len(), what);
        }
        if case.aim == Aim::Everywhere {
            assert_eq!(expected, case.light.power().0.luminance(), "{}", case.name);
        }
    }
}

/// A disk inside the small aim of the shared cases, where flux is measured from both ends.
struct Receiver {
    centre: Point3,
    normal: Normal3,
    radius: f64,
}

impl Receiver {
    /// Flux arriving on the lit side, from rays that the light sends.
    fn flux_by_emission(&self, light: &dyn Light, aim: &Aim, stream: &mut Stream, draws: usize) -> Moments {
        let received = |u| {
            let e = light.emit(u, aim)?;
            let cos = -self.normal.dot(e.direction);
            let t = -self.normal.dot(self.centre - e.origin) / cos;
            let hit = cos > 0.0 && t > 0.0 && (e.origin + e.direction * t).distance(self.centre) < self.radius;
            hit.then(|| e.flux.0.luminance())
        };
        (0..draws).map(|_| received(uniform4(stream)).unwrap_or(0.0)).collect()
    }

    /// The same by sampling the light from points of the disk. Shapes that hide themselves are not in this test: there
    /// is no occlusion in it.
    fn flux_by_light_samples(&self, light: &dyn Light, stream: &mut Stream, draws: usize) -> Moments {
        let frame = Frame::from_unit(self.normal);
        let area = PI * self.radius * self.radius;
        (0..draws)
            .map(|_| {
                let disk = ConcentricDisk.sample(stream.uniform2()) * self.radius;
                let p = self.centre + frame.to_world(disk.extend(0.0));
                let arriving = light.sample_li(p, stream.uniform2());
                arriving.map_or(0.0, |s| s.weight.0.luminance() * self.normal.dot(s.wi).max(0.0) * area)
            })
            .collect()
    }
}

/// What photons bring to a surface is what next-event estimation finds there, for every light and aim.
#[test]
fn both_ends_agree_on_the_flux_through_a_disk() {
    const DRAWS: usize = 40_000;
    let receiver = Receiver {
        centre: Point3::new(0.3, 0.0, 0.1),
        normal: Normal3::new(Vec3::new(0.1, 1.0, -0.2)).expect("not zero"),
        radius: 0.5,
    };
    let aims = [
        Aim::Everywhere,
        Aim::Sphere { centre: receiver.centre, radius: receiver.radius },
        Aim::Sphere { centre: Point3::new(0.4, 0.5, 0.0), radius: 1.4 },
    ];
    // A torus hides parts of itself, and so does a sphere that shines inward too: its cone holds the near side only.
    // Other two-sided surfaces shine through themselves on either end alike.
    let hides_itself = |name: &str| name.contains("torus") || name == "two-sided sphere";
    let all: Vec<_> = lights().into_iter().filter(|(name, _)| !hides_itself(name)).collect();
    for (i, (name, light)) in all.iter().enumerate() {
        let mut stream = Stream::new(SEED, Purpose::Test, 1, i as u64);
        let received = receiver.flux_by_light_samples(light.as_ref(), &mut stream, DRAWS);
        assert!(received.mean > 0.0, "{name} does not reach the receiver");
        for aim in &aims {
            let emitted = receiver.flux_by_emission(light.as_ref(), aim, &mut stream, DRAWS);
            let what = format!("{name} aimed at {aim:?}: emitted {emitted}, received {received}, seed {SEED}");
            assert_plausible(welch(&emitted, &received), all.len() * aims.len(), what);
        }
    }
}

/// Irradiance at `p` on a surface with normal `n`, luminance of its samples.
fn irradiance(light: &dyn Light, p: Point3, n: Normal3, index: u64) -> Moments {
    let mut stream = Stream::new(SEED, Purpose::Test, 2, index);
    (0..50_000)
        .map(|_| {
            let arriving = light.sample_li(p, stream.uniform2());
            arriving.map_or(0.0, |s| s.weight.0.luminance() * n.dot(s.wi).max(0.0))
        })
        .collect()
}

/// Lambert's formula: E/L = ½ Σ θᵢ (n·Γᵢ) over the edges of a polygon above the horizon, θᵢ the angle that an edge
/// subtends and Γᵢ the unit normal of its plane with p.
fn lambert(p: Point3, n: Normal3, corners: &[Point3]) -> f64 {
    let sum: f64 = (0..corners.len())
        .map(|i| {
            let (a, b) = (corners[i] - p, corners[(i + 1) % corners.len()] - p);
            let (cross, dot) = (a.cross(b), a.dot(b));
            cross.length().atan2(dot) * n.dot(cross) / cross.length()
        })
        .sum();
    0.5 * sum.abs()
}

#[test]
fn irradiances_have_their_closed_forms() {
    let radiance = Radiance(COLOUR);
    let lift = Transform::translate(Vec3::new(0.0, 1.5, 0.0));
    let area = |shape: Shape| AreaLight::from_shape(&shape, &lift, radiance, false).expect("has area");
    let up = Normal3::Y;
    let leaning = Normal3::new(Vec3::new(0.4, 1.0, 0.3)).expect("not zero");

    let disk = area(Shape::Disk(Disk::new(Point3::ORIGIN, -Vec3::Y, 0.8).expect("a disk")));
    let sphere = area(Shape::Sphere(Sphere::new(Point3::new(0.0, 0.5, 0.0), 0.5).expect("a sphere")));
    // a × b looks down.
    let (a, b) = (Vec3::new(0.6, 0.0, 0.0), Vec3::new(0.0, 0.1, 0.4));
    let rectangle = area(Shape::Rectangle(Rectangle::new(Point3::ORIGIN, a, b).expect("a rectangle")));
    let corners =
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(s, t)| lift.point(Point3::ORIGIN) + a * s + b * t);
    let quad = TriangleMesh {
        positions: corners.map(|c| c.to_array().map(|x| x as f32)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    };
    let polygon = AreaLight::from_mesh(&quad, &Transform::IDENTITY, radiance, false).expect("has area");
    let environment = EnvironmentLight { radiance, scene: SCENE };
    let point = PointLight { position: Point3::new(1.0, 2.0, 0.0), intensity: Intensity(COLOUR) };

    let aside = Point3::new(0.7, 0.2, -0.3);
    let to_sphere = Point3::new(0.0, 2.0, 0.0) - aside;
    let expected: Vec<(&str, &dyn Light, Point3, Normal3, f64)> = vec![
        // π r²/(r² + h²)
        ("disk overhead", &disk, Point3::ORIGIN, up, PI * 0.64 / (0.64 + 2.25)),
        // π (r/d)² cos θ
        (
            "sphere",
            &sphere,
            aside,
            leaning,
            PI * 0.25 / to_sphere.length_squared() * leaning.dot(to_sphere) / to_sphere.length(),
        ),
        ("rectangle", &rectangle, Point3::ORIGIN, up, lambert(Point3::ORIGIN, up, &corners)),
        ("rectangle aside", &rectangle, aside, leaning, lambert(aside, leaning, &corners)),
        ("quad of triangles", &polygon, aside, leaning, lambert(aside, leaning, &corners)),
        ("environment", &environment, aside, leaning, PI),
        // I cos/d²: (1, 2, 0)/√5 from the origin.
        ("point", &point, Point3::ORIGIN, up, 2.0 / 5.0f64.powf(1.5)),
    ];
    for (i, (name, light, p, n, factor)) in expected.iter().enumerate() {
        let sample = irradiance(*light, *p, *n, i as u64);
        let closed = COLOUR.luminance() * factor;
        let what = format!("{name}: {sample} against {closed:.6e}, seed {SEED}");
        assert_plausible(t_test(&sample, closed), expected.len(), what);
    }
}

/// The formula for a sphere that the horizon cuts, against the same sphere as a light.
#[test]
fn flux_towards_a_sphere_that_the_horizon_cuts() {
    let patch = Shape::Disk(Disk::new(Point3::ORIGIN, Vec3::Y, 1e-3).expect("a disk"));
    let light =
        |two_sided| AreaLight::from_shape(&patch, &Transform::IDENTITY, Radiance(COLOUR), two_sided).expect("has area");
    let ball = |centre: Point3| {
        let shape = Shape::Sphere(Sphere::new(centre, 0.7).expect("a sphere"));
        AreaLight::from_shape(&shape, &Transform::IDENTITY, Radiance(COLOUR), false).expect("has area")
    };
    let centres = [(0.9, 0.6), (0.9, 0.1), (0.9, 0.0), (0.9, -0.4), (0.1, 0.8)].map(|(x, y)| Point3::new(x, y, 0.0));
    for (i, centre) in centres.into_iter().enumerate() {
        let aim = Aim::Sphere { centre, radius: 0.7 };
        for (two_sided, normals) in [(false, vec![Normal3::Y]), (true, vec![Normal3::Y, -Normal3::Y])] {
            // By reciprocity π r² E of the sphere on the patch is what the patch sends to the sphere.
            let per_area = light(two_sided).emitted_flux(&aim).0.luminance() / (PI * 1e-6);
            let mut stream = Stream::new(SEED, Purpose::Test, 3, i as u64);
            let ball = ball(centre);
            let sample: Moments = (0..100_000)
                .map(|_| {
                    let s = ball.sample_li(Point3::ORIGIN, stream.uniform2()).expect("seen from outside");
                    let cos: f64 = normals.iter().map(|n| n.dot(s.wi).max(0.0)).sum();
                    s.weight.0.luminance() * cos
                })
                .collect();
            let what =
                format!("sphere at {centre:?}, two-sided {two_sided}: {sample} against {per_area:.6e}, seed {SEED}");
            assert_plausible(t_test(&sample, per_area), 2 * centres.len(), what);
        }
    }
}
