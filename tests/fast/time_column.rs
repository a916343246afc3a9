//! The time column: closed forms of moving mirrors and waves, and central differences in time on every shape that moves.

use pdembree::backend::RawHit;
use pdembree::differential::{Column, Differential, Refraction, ShapeOperator, SurfaceMotion, reflect, refract, time};
use pdembree::math::{Dir3, Motion, Normal3, Point3, Ray, Transform, Vec2, Vec3};
use pdembree::scene::{MeshId, ObjectGeometry, ObjectId, Scene, TriangleMesh};
use pdembree::shape::{HeightField, Shape, Sphere, Wave};
use pdembree::surface::Interaction;

use crate::support::closed_form::wave;
use crate::support::optics::{Act, floor};
use crate::support::scene::scene;
use crate::support::shapes::{self, random, random_direction};
use crate::support::worlds::{Numbers, deforming, motion, moving, placements};

const START: Differential<1> = Differential::ZERO;

/// A ray of light at a time, and how it changes with that.
#[derive(Clone, Copy, Debug)]
struct Timed {
    p: Point3,
    w: Dir3,
    time: f64,
    column: Differential<1>,
}

impl Timed {
    fn new(p: Point3, w: Dir3, time: f64) -> Timed {
        Timed { p, w, time, column: START }
    }
    /// Where it meets an object after more than a millionth of a metre.
    fn meet(&self, scene: &Scene, object: usize) -> Option<Interaction> {
        let ray = Ray { t_min: 1e-6, ..Ray::new(self.p, self.w).at_time(self.time) };
        let it = &scene.objects[object];
        let to_world = it.to_world(self.time);
        let t = match &it.geometry {
            ObjectGeometry::Mesh { .. } => 1.0, // a plane is found from anywhere
            ObjectGeometry::Shape { shape, .. } => {
                let origin = to_world.inverse_point(ray.origin);
                shape.intersect(&Ray { origin, direction: to_world.inverse_vector(ray.direction), ..ray })?
            }
        };
        let hit = RawHit { t, object: ObjectId(object as u32), primitive: 0, uv: [1.0 / 3.0; 2] };
        Some(Interaction::from_hit(scene, &ray, &hit)).filter(|at| at.exact)
    }
    /// Flies to an object and acts there. Where it lands the column is relative to the object.
    fn leg(&self, scene: &Scene, object: usize, act: Act) -> Option<Timed> {
        let si = self.meet(scene, object)?;
        let surface = si.motion(scene);
        let arrived = time::arrive(&self.column, self.w, si.t, si.ng, &surface);
        let (w, column) = match act {
            Act::Land => (self.w, arrived),
            Act::Mirror => {
                let w = reflect(&arrived, self.w, si.ns, &si.shape).0;
                (w, time::reflect(&arrived, self.w, si.ns, &si.shape, &surface))
            }
            Act::Refract(eta) => match refract(&arrived, self.w, si.ns, &si.shape, eta) {
                Refraction::TotalReflection(..) => return None,
                Refraction::Transmitted(w, _) => (w, time::refract(&arrived, self.w, si.ns, &si.shape, eta, &surface)),
            },
        };
        Some(Timed { p: si.p, w, column, ..*self })
    }
    fn trace(&self, scene: &Scene, legs: &[(usize, Act)]) -> Option<Timed> {
        legs.iter().try_fold(*self, |ray, &(object, act)| ray.leg(scene, object, act))
    }
}

/// What a plane mirror through the origin does to a ray that lands on the still plane z = `screen`: point and D_t x.
fn mirrored(p: Point3, w: Dir3, n: Normal3, surface: &SurfaceMotion, screen: f64) -> (Point3, Vec3) {
    let s = -n.dot(p.to_vec()) / n.dot(w);
    let at = p + w * s;
    let arrived = time::arrive(&START, w, s, n, surface);
    let column = time::reflect(&arrived, w, n, &ShapeOperator::FLAT, surface);
    let w = reflect(&arrived, w, n, &ShapeOperator::FLAT).0;
    let s = (screen - at.z) / w.z;
    (at + w * s, time::arrive(&column, w, s, Normal3::Z, &SurfaceMotion::STILL).dx.get(0))
}

/// −2 tan i on a screen parallel to a mirror that rises along its normal at speed 1.
#[test]
fn a_rising_plane_mirror_moves_its_image_by_twice_the_tangent() {
    for degrees in [0.0, 30.0, 45.0, 60.0f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let w = Dir3::new(Vec3::new(sin, 0.0, -cos)).expect("a direction");
        let rising = SurfaceMotion::rigid(Vec3::Z, Vec3::ZERO);
        let (_, dx) = mirrored(Point3::new(0.0, 0.0, 3.0), w, Normal3::Z, &rising, 2.0);
        assert!((dx - Vec3::X * (-2.0 * sin / cos)).length() < 1e-14, "{degrees}: {dx:?}");
    }
}

/// 2 ω · distance at normal incidence.
#[test]
fn a_turning_plane_mirror_sweeps_twice_as_fast() {
    let turning = SurfaceMotion::rigid(Vec3::ZERO, Vec3::Y);
    let (_, dx) = mirrored(Point3::new(0.0, 0.0, 3.0), -Dir3::Z, Normal3::Z, &turning, 2.0);
    assert!((dx - Vec3::X * 4.0).length() < 1e-14, "{dx:?}");
}

/// A mirror that moves and turns in general, against numbers of an independent computation.
#[test]
fn a_mirror_that_moves_and_turns_is_the_known_vector() {
    let w = Dir3::new(Vec3::new(0.1, 0.05, -1.0)).expect("a direction");
    let n = Normal3::new(Vec3::new(0.2, -0.1, 1.0)).expect("a normal");
    let p = Point3::new(0.2, 0.0, 3.0);
    // The velocity is that of the point in the origin.
    let at = (p + w * (-n.dot(p.to_vec()) / n.dot(w))).to_vec();
    let omega = Vec3::new(0.2, 0.5, -0.1);
    let surface = SurfaceMotion::rigid(Vec3::new(0.3, 0.1, 0.7) + omega.cross(at), omega);
    let (x, dx) = mirrored(p, w, n, &surface, 2.0);
    assert!(x.distance(Point3::new(1.640_217_39, -0.173_369_57, 2.0)) < 1e-8, "{x:?}");
    assert!((dx - Vec3::new(2.383_169_66, -1.050_923_20, 0.0)).length() < 1e-8, "{dx:?}");
}

/// The wave of the closed form goes along x at speed c: the light that enters it at x lands at X(x − ct) + ct, so that
/// D_t X/c = 1 − dX/dx, 1 at the fold.
#[test]
fn a_travelling_wave_carries_its_folds_along() {
    const SPEED: f64 = 0.3;
    let tau = std::f64::consts::TAU;
    let of_rate = |rate: f64| {
        let (wave_vector, phase) = (Vec2::new(tau, 0.0), std::f64::consts::FRAC_PI_2);
        let waves = vec![Wave { amplitude: wave::AMPLITUDE, wave_vector, phase, rate }];
        let field = HeightField::new(Point3::ORIGIN, Vec3::X, Vec3::Z, Vec2::new(2.0, 1.0), waves).expect("a surface");
        let still = |shape| ObjectGeometry::Shape { shape, to_world: Transform::IDENTITY };
        scene(vec![still(Shape::HeightField(field)), still(floor(wave::RECEIVER))], vec![])
    };
    // The field as a whole is carried along; its wave travels.
    let mut carried = of_rate(0.0);
    let keys = [(-1.0, Transform::translate(Vec3::X * -SPEED)), (1.0, Transform::translate(Vec3::X * SPEED))];
    carried.objects[0].motion = Some(Motion::new(&keys, &Transform::IDENTITY).expect("a motion").into());
    for (how, scene) in [("carried", carried), ("travelling", of_rate(-tau * SPEED))] {
        for (x, known) in [(0.127_308, Some(1.000_007)), (0.05, Some(2.584_872)), (0.3, Some(-1.010_753)), (0.41, None)]
        {
            for time in [0.0, 0.2] {
                // The same place on the wave.
                let ray = Timed::new(Point3::new(x + SPEED * time, 0.1, 2.0), -Dir3::Z, time);
                let end = ray.trace(&scene, &[(0, Act::Refract(1.0 / wave::INDEX)), (1, Act::Land)]).expect("lands");
                let found = end.column.dx.get(0).x / SPEED;
                assert!((end.p.x - wave::landing(x) - SPEED * time).abs() < 1e-12, "{how}, {x}: {}", end.p.x);
                assert!((found - (1.0 - wave::stretch(x))).abs() < 1e-10, "{how}, {x}: {found}");
                assert!(known.is_none_or(|known| (found - known).abs() < 6e-6), "{how}, {x}: {found}");
            }
        }
    }
}

#[test]
fn a_motions_velocity_is_its_central_difference() {
    let mut numbers = Numbers::new(23);
    for case in 0..100 {
        let motion = motion(&mut numbers, &placements(90 + case, 2)[case as usize % 2]);
        let time = [0.15, 0.5, 0.9][case as usize % 3] + numbers.between(-0.1, 0.09);
        let own = Point3::from_vec(numbers.in_cube(1.0));
        let (p, h) = (motion.at(time).point(own), 1e-5);
        let (v, gradient) = motion.velocity(time, p);
        let at = |time: f64, q: Point3| motion.at(time).point(q);
        let difference = |q: Point3| (at(time + h, q) - at(time - h, q)) / (2.0 * h);
        assert!((difference(own) - v).length() < 1e-8, "{case}: {v:?}");
        // The velocity of another of its points.
        let other = Point3::from_vec(numbers.in_cube(1.0));
        let far = v + gradient * (motion.at(time).point(other) - p);
        assert!((difference(other) - far).length() < 1e-8, "{case}: {far:?}");
    }
    let keys = [(0.0, Transform::IDENTITY), (1.0, Transform::translate(Vec3::X))];
    let motion = Motion::new(&keys, &Transform::IDENTITY).expect("a motion");
    assert_eq!(motion.velocity(-0.1, Point3::ORIGIN).0, Vec3::ZERO);
    assert_eq!(motion.velocity(1.1, Point3::ORIGIN).0, Vec3::ZERO);
}

/// A surface that moves inside a hollow ball that moves, mirror and receiver.
fn stand(geometry: ObjectGeometry, meshes: Vec<TriangleMesh>, seed: u64) -> Scene {
    let ball = Shape::Sphere(Sphere::new(Point3::ORIGIN, 20.0).expect("valid"));
    let hollow = ObjectGeometry::Shape { shape: ball, to_world: Transform::IDENTITY };
    moving(seed, scene(vec![geometry, hollow], meshes))
}

/// A triangle with interpolated normals.
fn bent_triangle() -> TriangleMesh {
    let unit = |x: f64, y: f64, z: f64| Vec3::new(x, y, z).normalize().to_array().map(|c| c as f32);
    TriangleMesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [0.0, 1.0, -0.05]],
        colours: Vec::new(),
        deformation: None,
        normals: vec![unit(-0.2, -0.1, 1.0), unit(0.25, 0.0, 1.0), unit(0.0, 0.3, 1.0)],
        uvs: vec![],
        triangles: vec![[0, 1, 2]],
    }
}

/// Points of an object in its own space.
type Points = Box<dyn Fn(u64) -> Point3>;

const CHAINS: [(&str, &[(usize, Act)]); 4] = [
    ("mirror", &[(0, Act::Mirror), (1, Act::Mirror), (1, Act::Land)]),
    ("glass", &[(0, Act::Refract(1.0 / 1.5)), (0, Act::Refract(1.5)), (1, Act::Land)]),
    ("inner mirror", &[(0, Act::Refract(1.0 / 1.5)), (0, Act::Mirror), (1, Act::Land)]),
    ("interface", &[(0, Act::Refract(1.0 / 1.5)), (1, Act::Mirror), (1, Act::Land)]),
];

/// Every shape in a stretched place, and a triangle with interpolated normals, all moving, turning and growing.
fn stands() -> Vec<(String, Scene, Points)> {
    let mut all: Vec<(String, Scene, Points)> = Vec::new();
    for (known, i) in shapes::all().into_iter().zip(50..) {
        let to_world = placements(i, 2)[i as usize % 2];
        let geometry = ObjectGeometry::Shape { shape: known.shape.clone(), to_world };
        let name = known.name.to_owned();
        all.push((name, stand(geometry, vec![], i), Box::new(move |i| known.point(&mut random(1000 + i)))));
    }
    let wave = |amplitude, x, y, rate| Wave { amplitude, wave_vector: Vec2::new(x, y), phase: 0.4, rate };
    let waves = vec![wave(0.1, 5.0, 1.0, 2.0), wave(0.05, -3.0, 7.0, -4.0)];
    let field = HeightField::new(Point3::ORIGIN, Vec3::X, Vec3::Y, Vec2::new(1.0, 0.7), waves).expect("a surface");
    let geometry = ObjectGeometry::Shape { shape: Shape::HeightField(field), to_world: placements(5, 1)[0] };
    let points = |i: u64| {
        let [u, v] = random(4000 + i).uniform2();
        Point3::new(u - 0.5, 0.0, 0.5 - v)
    };
    all.push(("travelling waves".to_owned(), stand(geometry, vec![], 9), Box::new(points)));
    let geometry = ObjectGeometry::Mesh { mesh: MeshId(0), to_world: placements(3, 1)[0] };
    let points = |i: u64| {
        let [u, v] = random(2000 + i).uniform2().map(|x| 0.5 * x);
        Point3::new(u, v, 0.1 * u - 0.05 * v)
    };
    all.push(("triangle".to_owned(), stand(geometry, vec![bent_triangle()], 7), Box::new(points)));
    let flat = TriangleMesh { normals: vec![], ..bent_triangle() };
    for (name, mesh) in [("deforming triangle", bent_triangle()), ("flat deforming triangle", flat)] {
        let geometry = ObjectGeometry::Mesh { mesh: MeshId(0), to_world: placements(3, 1)[0] };
        // The shape at rest tells only where to aim.
        let deforming = deforming(8, mesh);
        let corners = deforming.corners(0);
        let points = move |i: u64| {
            let [u, v] = random(2000 + i).uniform2().map(|x| 0.5 * x);
            corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v
        };
        all.push((name.to_owned(), stand(geometry, vec![deforming], 7), Box::new(points)));
    }
    all
}

/// The velocity of the receiver's own point and the column relative to it are the change of where the light lands.
#[test]
fn time_columns_are_central_differences_on_everything_that_moves() {
    const STEP: f64 = 2e-5;
    for (name, scene, points) in stands() {
        for (chain, legs) in CHAINS {
            let mut checked = 0;
            for index in 0..60 {
                let mut stream = random(3000 + index);
                let time = 0.4 + 0.5 * stream.uniform();
                let to = scene.objects[0].to_world(time).point(points(index));
                let from = to + random_direction(&mut stream) * 2.0;
                let w = Dir3::new(to - from).expect("apart");
                let Some(end) = Timed::new(from, w, time).trace(&scene, legs) else { continue };
                let end_at = |time: f64| Timed::new(from, w, time).trace(&scene, legs);
                let difference = |step: f64| {
                    let (a, b) = (end_at(time + step)?, end_at(time - step)?);
                    let scale = 1.0 / (2.0 * step);
                    Some(((a.p - b.p) * scale, (a.w.to_vec() - b.w.to_vec()) * scale))
                };
                let [Some(full), Some(half)] = [STEP, 0.5 * STEP].map(difference) else { continue };
                let own = scene.objects[1].motion.as_ref().expect("moves").velocity(time, end.p).0;
                let (dx, dw) = (end.column.dx.get(0) + own, end.column.dw.get(0));
                // Extrapolated from two steps; where they differ much (edges, near tangency) there is no derivative to
                // compare with.
                let size = dx.length() + 20.0 * dw.length();
                if (half.0 - full.0).length() + 20.0 * (half.1 - full.1).length() > 1e-5 * size {
                    continue;
                }
                let off = ((4.0 * half.0 - full.0) / 3.0 - dx).length()
                    + 20.0 * ((4.0 * half.1 - full.1) / 3.0 - dw).length();
                assert!(off < 1e-7 * size, "{name}, {chain}, ray {index}: relative error {:e}", off / size);
                checked += 1;
            }
            let twice = chain == "glass" || chain == "inner mirror";
            let closed = ["sphere", "cylinder", "torus", "ring"].iter().any(|kind| name.starts_with(kind));
            assert!(checked >= 10 || (twice && !closed), "{name}, {chain}: only {checked} rays compared");
        }
    }
}

/// What stays at rest relative to a surface lands on the same point of it, however both move.
#[test]
fn a_receivers_own_velocity_is_no_blur() {
    let omega = Vec3::new(0.3, -0.2, 0.9);
    let surface = SurfaceMotion::rigid(Vec3::new(1.0, 2.0, 3.0), omega);
    let w = Dir3::new(Vec3::new(0.2, 0.1, -1.0)).expect("a direction");
    // A ray that is carried along with the surface's body from 2 m away.
    let carried =
        Differential::new([Column { dx: surface.velocity - omega.cross(w * 2.0), dw: omega.cross(w.to_vec()) }]);
    let arrived = time::arrive(&carried, w, 2.0, Normal3::Z, &surface);
    assert!(arrived.dx.get(0).length() < 1e-14, "{arrived:?}");
}
