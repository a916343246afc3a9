//! Where surfaces look for light, against the densities that lights claim.

use pdembree::light::{AreaLight, EnvironmentLight, Light, LightSample};
use pdembree::math::{Dir3, Frame, Normal3, Point3, Ray, Transform, Vec2, Vec3};
use pdembree::radiometry::Radiance;
use pdembree::sampling::warp::{UniformCone, Warp};
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::TriangleMesh;
use pdembree::shape::{Disk, Rectangle, Shape, Sphere};

use crate::support::evenness::{evenness, in_cone, on_disk};
use crate::support::lights::{COLOUR, SCENE, shapes, skewed, tetrahedron};
use crate::support::statistics::{Moments, assert_plausible, welch};

const SEED: u64 = 31;
const LIFT: Vec3 = Vec3::new(0.2, 2.0, 0.0);

/// All crossings of a ray with a surface: point and outward normal.
type Crossings = Box<dyn Fn(Point3, Dir3) -> Vec<(Point3, Normal3)>>;

fn shape_crossings(shape: Shape, to_world: Transform) -> Crossings {
    Box::new(move |p, w| {
        let mut ray = Ray {
            origin: to_world.inverse_point(p),
            direction: to_world.inverse_vector(w.to_vec()),
            t_min: 0.0,
            t_max: f64::INFINITY,
            time: 0.0,
        };
        let mut found = Vec::new();
        while let Some(t) = shape.intersect(&ray) {
            let local = shape.surface_at(ray.at(t), 0.0);
            found.push((to_world.point(local.p), to_world.normal(local.n)));
            ray.t_min = t * (1.0 + 1e-9);
        }
        found
    })
}

fn mesh_crossings(mesh: TriangleMesh, to_world: Transform) -> Crossings {
    let outward = if to_world.flips_handedness() { -1.0 } else { 1.0 };
    Box::new(move |p, w| {
        let crossing = |prim: u32| {
            let [a, b, c] = mesh.corners(prim).map(|x| to_world.point(x));
            let n = (b - a).cross(c - a);
            let t = n.dot(a - p) / n.dot(w.to_vec());
            let x = p + w * t;
            let inside = [(a, b), (b, c), (c, a)].iter().all(|(i, j)| n.dot((*j - *i).cross(x - *i)) >= 0.0);
            (t > 0.0 && inside).then(|| Some((x, Normal3::new(n * outward)?))).flatten()
        };
        (0..mesh.triangles.len() as u32).filter_map(crossing).collect()
    })
}

/// Every surface as a light, and what a ray finds of it.
fn seen_surfaces() -> Vec<(String, AreaLight, Crossings)> {
    let mut all = Vec::new();
    for two_sided in [false, true] {
        for (moved, to_world) in [("", Transform::translate(LIFT)), ("skewed ", skewed())] {
            let radiance = Radiance(COLOUR);
            for (name, shape) in shapes() {
                let light = AreaLight::from_shape(&shape, &to_world, radiance, two_sided).expect("has area");
                let name = format!("{moved}{name}, two-sided {two_sided}");
                all.push((name, light, shape_crossings(shape, to_world)));
            }
            let light = AreaLight::from_mesh(&tetrahedron(), &to_world, radiance, two_sided).expect("has area");
            let name = format!("{moved}mesh, two-sided {two_sided}");
            all.push((name, light, mesh_crossings(tetrahedron(), to_world)));
        }
    }
    all
}

/// Directions from one point: E[1/pdf in a cell] over samples of the light is the solid angle of what is lit in the
/// cell, counted with every crossing that the light can be sampled at. That solid angle is measured independently by
/// rays in all directions. (Densities have poles along the silhouettes of curved lights, so cell integrals of the
/// density itself would not be exact enough for a chi² test; their inverse has none.)
#[test]
fn light_samples_follow_the_density_that_pdf_li_claims() {
    const DRAWS: usize = 20_000;
    const TURNS: usize = 4;
    const RINGS: usize = 4;
    /// One cell more, for everything.
    const TOTAL: usize = TURNS * RINGS;
    /// Rays that must have met a cell's share of the light before its mean is nearly normal.
    const ENOUGH: u64 = 100;
    let p = Point3::new(-0.9, 0.3, 1.2);
    let axis = Dir3::new(Point3::new(0.3, 2.0, 0.0) - p).expect("not zero");
    // Wide enough for all of them.
    let cone = UniformCone::from_cos(0.75);
    let frame = Frame::from_unit(axis);
    let cell = |w: Dir3| {
        let [turn, ring] = in_cone(axis, w, cone.height());
        assert!(ring <= 1.0, "a light beyond the cone of the test");
        ((turn * TURNS as f64) as usize).min(TURNS - 1) * RINGS + ((ring * RINGS as f64) as usize).min(RINGS - 1)
    };
    let all = seen_surfaces();
    for (i, (name, light, crossings)) in all.iter().enumerate() {
        let mut stream = Stream::new(SEED, Purpose::Test, 2, i as u64);
        let mut sampled = vec![Moments::default(); TOTAL + 1];
        let mut counted = sampled.clone();
        let mut met = [0u64; TOTAL + 1];
        let push = |cells: &mut Vec<Moments>, at: Option<(usize, f64)>| {
            for (c, m) in cells.iter_mut().enumerate() {
                m.push(at.filter(|(own, _)| c == *own || c == TOTAL).map_or(0.0, |(_, x)| x));
            }
        };
        for _ in 0..DRAWS {
            let sample = light.sample_li(p, stream.uniform2());
            push(&mut sampled, sample.map(|s| (cell(s.wi), 1.0 / s.pdf.expect("not a delta source").get())));
            if let Some(s) = sample {
                check_sample(name, light, p, &s, &crossings(p, s.wi));
            }
            let w = frame.to_world_dir(cone.sample(stream.uniform2()).to_vec());
            let sampleable = |(x, n): &&(Point3, Normal3)| light.pdf_li(p, w, *x, *n).get() > 0.0;
            let hits = crossings(p, w).iter().filter(sampleable).count() as f64;
            push(&mut counted, Some((cell(w), hits * cone.solid_angle())));
            if hits > 0.0 {
                met[cell(w)] += 1;
                met[TOTAL] += 1;
            }
        }
        for (c, (s, k)) in sampled.iter().zip(&counted).enumerate() {
            if met[c] >= ENOUGH {
                let what = format!("{name}, cell {c}: {s} sr sampled, {k} sr seen, seed {SEED}");
                assert_plausible(welch(s, k), all.len() * (TOTAL + 1), what);
            }
        }
        assert!(met[TOTAL] >= ENOUGH, "{name} is hardly seen: {} sr, {} sr", sampled[TOTAL], counted[TOTAL]);
    }
}

/// A sample's density is what `pdf_li` says of the point it points at.
fn check_sample(name: &str, light: &AreaLight, p: Point3, s: &LightSample, crossings: &[(Point3, Normal3)]) {
    let claimed = s.pdf.expect("not a delta source").get();
    let nearest = crossings.iter().min_by(|a, b| {
        let off = |c: &(Point3, Normal3)| (c.0.distance(p) - s.distance).abs();
        off(a).total_cmp(&off(b))
    });
    // A ray at the very rim may pass the surface by rounding.
    let Some((x, n)) = nearest else { return };
    let cos = n.dot(s.wi).abs();
    if cos < 1e-3 {
        return;
    }
    let pdf = light.pdf_li(p, s.wi, *x, *n).get();
    // Both points agree to about 1e-12 m; the density has a factor 1/cos, whose slope is 1/cos².
    assert!((pdf / claimed - 1.0).abs() <= 1e-10 / (cos * cos), "{name}: pdf_li {pdf}, sample {claimed}, cos {cos}");
    assert!((x.distance(p) - s.distance).abs() <= 1e-9 / cos, "{name}: at {}, not {}", s.distance, x.distance(p));
    let radiance = s.weight.0 * claimed;
    assert!((radiance.luminance() / COLOUR.luminance() - 1.0).abs() <= 1e-12, "{name}: weight times density");
}

/// Coordinates of the sample over `u` that are even over the unit square.
type Coordinates<'a> = Box<dyn Fn([f64; 2]) -> Vec<f64> + 'a>;

/// The samples themselves, where their density is even in known coordinates.
#[test]
fn light_samples_are_even_where_they_should_be() {
    let p = Point3::new(0.5, -0.3, 0.1);
    let lifted = Transform::translate(LIFT);
    let area = |shape: Shape| AreaLight::from_shape(&shape, &lifted, Radiance(COLOUR), false).expect("has area");
    let sphere = area(Shape::Sphere(Sphere::new(Point3::ORIGIN, 0.5).expect("a sphere")));
    let disk = area(Shape::Disk(Disk::new(Point3::ORIGIN, -Vec3::Y, 0.6).expect("a disk")));
    let (a, b) = (Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.0, 0.0, 0.3));
    let rectangle = area(Shape::Rectangle(Rectangle::new(Point3::ORIGIN, a, b).expect("a rectangle")));
    let environment = EnvironmentLight { radiance: Radiance(COLOUR), scene: SCENE };
    let to_centre = Point3::ORIGIN + LIFT - p;
    let height = 1.0 - (1.0 - 0.25 / to_centre.length_squared()).sqrt();
    let hit = |light: &dyn Light, u| {
        let s = light.sample_li(p, u).expect("the lit side is below");
        p + s.wi * s.distance - (Point3::ORIGIN + LIFT)
    };
    let cases: [(&str, Coordinates<'_>); 4] = [
        (
            "sphere",
            Box::new(|u| {
                let wi = sphere.sample_li(p, u).expect("seen from outside").wi;
                in_cone(to_centre.normalize(), wi, height).to_vec()
            }),
        ),
        ("disk", Box::new(|u| on_disk(&Frame::from_unit(-Vec3::Y), hit(&disk, u), 0.6).to_vec())),
        (
            "rectangle",
            Box::new(|u| {
                let x = hit(&rectangle, u);
                let c = Vec2::new(x.dot(a) / a.length_squared(), x.dot(b) / b.length_squared());
                vec![0.5 * (1.0 + c.x), 0.5 * (1.0 + c.y)]
            }),
        ),
        (
            "environment",
            Box::new(|u| in_cone(Vec3::Z, environment.sample_li(p, u).expect("from everywhere").wi, 2.0).to_vec()),
        ),
    ];
    for (i, (name, coordinates)) in cases.iter().enumerate() {
        let mut stream = Stream::new(SEED, Purpose::Test, 3, i as u64);
        let p = evenness(20, 60_000, || coordinates(stream.uniform2()));
        assert_plausible(p, cases.len(), format!("{name}, seed {SEED}"));
    }
}
