//! The numeric vectors A to H of PHOTON_DIFFERENTIALS 1.4, through real shapes.

use pdembree::differential::{ShapeOperator, transfer};
use pdembree::math::{Normal3, Point3, Transform, Vec3};
use pdembree::scene::{MeshId, ObjectGeometry, TriangleMesh};
use pdembree::shape::{Cylinder, Shape, Torus};

use crate::support::optics::{Act, Beam, Bench, beam, floor, unit_ball};
use crate::support::scene::scene;

const AIR_TO_GLASS: f64 = 1.0 / 1.5;
/// Half a unit of the vectors' last printed digit, and rounding.
const PRINTED: f64 = 6e-11;

fn near(a: Vec3, b: [f64; 3], tolerance: f64, what: &str) {
    let off = (a - Vec3::from_array(b)).abs().max_element();
    assert!(off < tolerance, "{what}: {a} is {off:e} from {b:?}");
}

fn close(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() < tolerance, "{what}: {a} against {b}");
}

fn slanted() -> Beam {
    beam(Point3::new(0.1, 0.2, 2.0), Vec3::new(0.3, -0.2, -1.0))
}

fn downward() -> Beam {
    beam(Point3::new(0.3, 0.2, 4.0), -Vec3::Z)
}

#[test]
fn a_free_flight_to_a_plane() {
    let b = Bench::new(vec![floor(0.0)]).trace(&slanted(), &[(0, Act::Land)]).expect("hits");
    near(b.p.to_vec(), [0.7, -0.2, 0.0], 1e-15, "hit");
    near(b.dx(0), [-0.0588348405, 1.0198039027, 0.0], PRINTED, "P_u");
    near(b.dx(1), [1.0423715564, 0.0, 0.0], PRINTED, "P_v");
    near(b.dx(2), [-0.1250845868, 2.1681328373, 0.0], PRINTED, "P_th");
    near(b.dx(3), [2.2161123271, 0.0, 0.0], PRINTED, "P_ph");
    close(b.area(0, 1), 1.0630145813, PRINTED, "|Pu x Pv|");
    close(b.area(2, 3), 4.8048259074, PRINTED, "|Pth x Pph|");
}

#[test]
fn b_refraction_into_water() {
    let bench = Bench::new(vec![floor(0.0), floor(-1.0)]);
    let b = bench.trace(&slanted(), &[(0, Act::Refract(1.0 / 1.33)), (1, Act::Land)]).expect("hits");
    near(b.p.to_vec(), [0.9194488043, -0.3462992029, -1.0], PRINTED, "hit");
    near(b.w.to_vec(), [0.2121926771, -0.1414617847, -0.9669347606], PRINTED, "D");
    near(b.dx(2), [-0.1495644899, 2.9469434117, 0.0], PRINTED, "P_th");
    near(b.dx(3), [2.9966379510, 0.0200086956, 0.0], PRINTED, "P_ph");
    close(b.area(0, 1), 1.0630145813, PRINTED, "|Pu x Pv|");
    close(b.area(2, 3), 8.8339150574, PRINTED, "|Pth x Pph|");
}

#[test]
fn c_sphere_mirror() {
    let b = Bench::new(vec![unit_ball(), floor(2.0)]).trace(&downward(), &[(0, Act::Mirror), (1, Act::Land)]);
    let b = b.expect("hits");
    near(b.p.to_vec(), [1.1071425491, 0.7380950328, 2.0], PRINTED, "hit");
    near(b.w.to_vec(), [0.5596427432, 0.3730951621, 0.74], PRINTED, "D");
    near(b.dx(0), [0.8491986905, 4.2566076242, 0.0], PRINTED, "P_u");
    near(b.dx(1), [4.9642731996, 0.8491986905, 0.0], PRINTED, "P_v");
    close(b.area(0, 1), 20.4098247337, PRINTED, "|Pu x Pv|");
}

#[test]
fn d_glass_ball() {
    let bench = Bench::new(vec![unit_ball(), floor(-2.0)]);
    let legs = [(0, Act::Refract(AIR_TO_GLASS)), (0, Act::Refract(1.5)), (1, Act::Land)];
    let b = bench.trace(&downward(), &legs).expect("hits");
    near(b.p.to_vec(), [-0.1190701232, -0.0793800821, -2.0], PRINTED, "hit");
    near(b.w.to_vec(), [-0.2076512448, -0.1384341632, -0.9683578590], PRINTED, "D");
    near(b.dx(0), [-0.0646539496, -0.4400030438, 0.0], PRINTED, "P_u");
    near(b.dx(1), [-0.4938813351, -0.0646539496, 0.0], PRINTED, "P_v");
    close(b.area(0, 1), 0.2131291575, PRINTED, "|Pu x Pv|");
    close(b.area(2, 3), 0.0457988605, PRINTED, "|Pth x Pph|");
}

#[test]
fn e_paraboloid_mirror() {
    // z = (x² + y²)/4 is no shape of the renderer: its numbers are put in by hand.
    let start = beam(Point3::new(0.5, 0.4, 5.0), -Vec3::Z);
    let height = (0.25 + 0.16) / 4.0;
    let gradient = Vec3::new(-0.25, -0.2, 1.0);
    let n = gradient.normalize();
    let hessian = glam::DMat3::from_diagonal(Vec3::new(-0.5, -0.5, 0.0));
    let tangent = glam::DMat3::IDENTITY - glam::DMat3::from_cols(n * n.x, n * n.y, n * n.z);
    let shape = ShapeOperator::from_matrix(tangent * hessian * (1.0 / gradient.length()));
    let ng = Normal3::from_unit(n);
    let landed = Beam {
        p: Point3::new(0.5, 0.4, height),
        columns: transfer(&start.columns, start.w, 5.0 - height, ng),
        ..start
    };
    let mirrored = landed.turned(ng, &shape, Act::Mirror).expect("a mirror");
    let b = Bench::new(vec![floor(0.5)]).trace(&mirrored, &[(0, Act::Land)]).expect("hits");
    near(b.p.to_vec(), [0.2785515320, 0.2228412256, 0.5], PRINTED, "hit");
    near(b.dx(0), [0.0620727648, 0.6067612759, 0.0], PRINTED, "P_u");
    near(b.dx(1), [0.6346940201, 0.0620727648, 0.0], PRINTED, "P_v");
    close(b.area(0, 1), 0.3812547253, PRINTED, "|Pu x Pv|");
}

#[test]
fn f_torus_mirror() {
    let torus = Shape::Torus(Torus::new(Point3::ORIGIN, Vec3::Z, 1.0, 0.4).expect("valid"));
    let start = beam(Point3::new(1.02, 0.05, 4.0), Vec3::new(0.02, -0.01, -1.0));
    let b = Bench::new(vec![torus, floor(3.0)]).trace(&start, &[(0, Act::Mirror), (1, Act::Land)]).expect("hits");
    near(b.p.to_vec(), [2.4702932348, 0.0011545205, 3.0], PRINTED, "hit");
    near(b.dx(0), [0.1981995449, 2.2093272847, 0.0], PRINTED, "P_u");
    near(b.dx(1), [18.3664481443, 0.1148859884, 0.0], PRINTED, "P_v");
    close(b.area(0, 1), 40.5547246582, PRINTED, "|Pu x Pv|");
}

#[test]
fn g_interpolated_normals() {
    let unit = |x: f64, y: f64, z: f64| Vec3::new(x, y, z).normalize().to_array().map(|c| c as f32);
    let mesh = TriangleMesh {
        colours: Vec::new(),
        deformation: None,
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [0.0, 1.0, -0.05]],
        normals: vec![unit(-0.2, -0.1, 1.0), unit(0.25, 0.0, 1.0), unit(0.0, 0.3, 1.0)],
        uvs: vec![],
        triangles: vec![[0, 1, 2]],
    };
    let still = |shape| ObjectGeometry::Shape { shape, to_world: Transform::IDENTITY };
    let triangle = ObjectGeometry::Mesh { mesh: MeshId(0), to_world: Transform::IDENTITY };
    let bench = Bench { scene: scene(vec![triangle, still(floor(1.0)), still(floor(-1.0))], vec![mesh]) };
    let start = beam(Point3::new(0.3, 0.35, 2.0), Vec3::new(0.05, -0.1, -1.0));
    // Vertices and normals are stored in f32, 6e-8 of each number; normals are turned by that much and the columns,
    // gradients of them, by a few times more.
    let stored = 1e-6;
    let b = bench.trace(&start, &[(0, Act::Mirror), (1, Act::Land)]).expect("hits");
    near(b.p.to_vec(), [0.4650006281, 0.0568683302, 1.0], stored, "mirrored hit");
    near(b.dx(0), [0.3855678976, 1.7673156377, 0.0], stored, "mirrored P_u");
    near(b.dx(1), [1.8657357448, 0.2173519398, 0.0], stored, "mirrored P_v");
    close(b.area(0, 1), 3.2135400273, stored, "mirrored |Pu x Pv|");
    let b = bench.trace(&start, &[(0, Act::Refract(AIR_TO_GLASS)), (2, Act::Land)]).expect("hits");
    near(b.p.to_vec(), [0.4294245898, 0.0845542749, -1.0], stored, "refracted hit");
    near(b.dx(0), [-0.0730300949, 0.8655397351, 0.0], stored, "refracted P_u");
    near(b.dx(1), [0.8428160494, -0.0325925352, 0.0], stored, "refracted P_v");
    close(b.area(0, 1), 0.7271105441, stored, "refracted |Pu x Pv|");
}

#[test]
fn h_glass_cylinder() {
    let (base, top) = (Point3::new(0.0, -5.0, 0.0), Point3::new(0.0, 5.0, 0.0));
    let rod = Shape::Cylinder(Cylinder::new(base, top, 1.0).expect("valid"));
    let start = beam(Point3::new(0.3, 0.2, 4.0), Vec3::new(0.0, 0.1, -1.0));
    let legs = [(0, Act::Refract(AIR_TO_GLASS)), (0, Act::Refract(1.5)), (1, Act::Land)];
    let b = Bench::new(vec![rod, floor(-2.0)]).trace(&start, &legs).expect("hits");
    near(b.p.to_vec(), [-0.1150888124, 0.7375770661, -2.0], PRINTED, "hit");
    close(b.area(0, 1), 0.4776585509, PRINTED, "|Pu x Pv|");
}
