//! Mirrors against closed forms (PHOTON_DIFFERENTIALS 12, items 5 to 8).

use pdembree::differential::{Column, Differential, ShapeOperator, transfer};
use pdembree::math::{Dir3, Normal3, Point3, Transform, Vec2, Vec3};
use pdembree::scene::ObjectGeometry;
use pdembree::shape::{Cylinder, Shape};

use crate::support::optics::{Act, Beam, Bench, beam, floor, unit_ball};
use crate::support::scene::scene;

/// The unit circle as a tall mirror about z.
fn ring() -> Bench {
    let (base, top) = (Point3::new(0.0, 0.0, -5.0), Point3::new(0.0, 0.0, 5.0));
    Bench::new(vec![Shape::Cylinder(Cylinder::new(base, top, 1.0).expect("valid")), floor(0.0)])
}

/// A beam in the plane z = 0 with the in-plane position and direction as columns 0 and 2.
fn in_plane(from: Vec2, angle: f64) -> Beam {
    let w = Dir3::new(Vec3::new(angle.cos(), angle.sin(), 0.0)).expect("unit");
    let across = Vec3::Z.cross(w.to_vec());
    let columns = [Column::position(across), Column::ZERO, Column::direction(across), Column::ZERO];
    Beam { p: Point3::new(from.x, from.y, 0.0), w, columns: Differential::new(columns) }
}

fn caustic(start: &Beam, column: usize) -> Point3 {
    let mirrored = ring().trace(start, &[(0, Act::Mirror)]).expect("inside the ring");
    mirrored.p + mirrored.w * mirrored.focus(column)
}

#[test]
fn parallel_light_in_a_circle_mirror_makes_the_nephroid() {
    for (t, printed) in [(0.2, (0.52871603, 0.00784138)), (0.5, (0.64050262, 0.11019541))] {
        let exact = 0.25 * Vec2::new(3.0 * f64::cos(t) - f64::cos(3.0 * t), 3.0 * f64::sin(t) - f64::sin(3.0 * t));
        assert!((exact - Vec2::from(printed)).abs().max_element() < 5e-9, "the document's own closed form at {t}");
        let p = caustic(&in_plane(Vec2::new(-0.5, f64::sin(t)), 0.0), 0);
        assert!((p.truncate() - exact).length() < 1e-14, "t = {t}: {p:?}, not {exact}");
    }
    let cusp = caustic(&in_plane(Vec2::new(-0.5, 0.0), 0.0), 0);
    assert!(cusp.distance(Point3::new(0.5, 0.0, 0.0)) < 1e-15, "{cusp:?}");
}

#[test]
fn a_source_on_the_circle_makes_the_cardioid() {
    for (t, printed) in [(0.2, (0.34635739, 0.00264011)), (0.5, (0.40495427, 0.03912670))] {
        let exact = Vec2::new(2.0 * f64::cos(t) - f64::cos(2.0 * t), 2.0 * f64::sin(t) - f64::sin(2.0 * t)) / 3.0;
        assert!((exact - Vec2::from(printed)).abs().max_element() < 5e-9, "the document's own closed form at {t}");
        // From (−1, 0) to the mirror's point at the angle t: half of it, by the inscribed angle.
        let p = caustic(&in_plane(Vec2::new(-1.0, 0.0), 0.5 * t), 2);
        assert!((p.truncate() - exact).length() < 1e-14, "t = {t}: {p:?}, not {exact}");
    }
    let cusp = caustic(&in_plane(Vec2::new(-1.0, 0.0), 0.0), 2);
    assert!(cusp.distance(Point3::new(1.0 / 3.0, 0.0, 0.0)) < 1e-15, "{cusp:?}");
}

#[test]
fn a_hollow_sphere_mirror_crosses_the_axis_at_half_the_secant() {
    let bench = Bench::new(vec![unit_ball()]);
    let start = beam(Point3::new(0.0, 0.5, 0.0), -Vec3::Z);
    let b = bench.trace(&start, &[(0, Act::Mirror)]).expect("from inside");
    let crossing = b.p.z - b.p.y * b.w.z / b.w.y;
    assert!((crossing + 0.57735027).abs() < 5e-9 && (crossing + 1.0 / 3f64.sqrt()).abs() < 1e-15, "{crossing}");
}

#[test]
fn light_over_the_rim_of_a_ring_lands_where_the_billiard_does() {
    // Elevation 45°: a rim of 1.2 gives the horizontal travel 1.2.
    let w = Dir3::new(Vec3::new(1.0, 0.0, -1.0)).expect("unit");
    // The document prints 0.38374534 in the second row; 0.91651514 − 0.78348486 · 0.68 is 0.38374543. The others are cut, not
    // rounded, to eight digits.
    let table = [
        ((0.2, 0.3), (0.58816935, 0.04469107), 0.06480246),
        ((0.5, -0.4), (0.38374543, 0.17446059), 0.70970413),
        ((0.7, 0.1), (0.10807513, -0.08009522), 0.81914370),
    ];
    for ((x, y), printed, jacobian) in table {
        let columns = [Column::position(Vec3::X), Column::position(Vec3::Y), Column::ZERO, Column::ZERO];
        let start = Beam { p: Point3::new(x, y, 1.2), w, columns: Differential::new(columns) };
        let b = ring().trace(&start, &[(0, Act::Mirror), (1, Act::Land)]).expect("one bounce");
        assert!((b.p.truncate() - Vec2::from(printed)).abs().max_element() < 1e-8, "{:?}, not {printed:?}", b.p);
        let cos = (1.0 - y * y).sqrt();
        let exact = (1.0 - 2.0 * (1.2 - (cos - x)) / cos).abs();
        assert!((exact - jacobian).abs() < 6e-9, "({x}, {y}): the document has {jacobian}, the closed form {exact}");
        assert!((b.area(0, 1) - exact).abs() < 1e-14, "({x}, {y}): {}, not {exact}", b.area(0, 1));
    }
}

#[test]
fn a_paraboloid_gathers_the_light_along_its_axis_in_its_focus() {
    // z = r²/4f with f = 1 is no shape of the renderer: its numbers are put in by hand.
    for (x, y) in [(0.1, 0.0), (0.5, 0.4), (-1.3, 0.7), (2.5, -1.5)] {
        let height = 0.25 * (x * x + y * y);
        let gradient = Vec3::new(-0.5 * x, -0.5 * y, 1.0);
        let n = gradient.normalize();
        let hessian = glam::DMat3::from_diagonal(Vec3::new(-0.5, -0.5, 0.0));
        let tangent = glam::DMat3::IDENTITY - glam::DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        let shape = ShapeOperator::from_matrix(tangent * hessian * (1.0 / gradient.length()));
        let ng = Normal3::from_unit(n);
        let start = beam(Point3::new(x, y, 8.0), -Vec3::Z);
        let columns = transfer(&start.columns, start.w, 8.0 - height, ng);
        let landed = Beam { p: Point3::new(x, y, height), columns, ..start };
        let focus = Point3::new(0.0, 0.0, 1.0);
        let mirrored = landed.turned(ng, &shape, Act::Mirror).expect("a mirror");
        let b = mirrored.flown(mirrored.p.distance(focus));
        assert!(b.p.distance(focus) < 1e-14, "({x}, {y}) comes to {:?}", b.p);
        assert!(b.dx(0).length() < 1e-14 && b.dx(1).length() < 1e-14, "({x}, {y}): {} {}", b.dx(0), b.dx(1));
    }
}

#[test]
fn an_ellipsoid_gathers_the_light_of_one_focus_in_the_other() {
    // A stretched sphere: a = 2, b = √3, foci at ±1 on x.
    let to_world = Transform::scale(Vec3::new(2.0, 3f64.sqrt(), 3f64.sqrt())).expect("invertible");
    let bench = Bench { scene: scene(vec![ObjectGeometry::Shape { shape: unit_ball(), to_world }], vec![]) };
    let (from, to) = (Point3::new(-1.0, 0.0, 0.0), Point3::new(1.0, 0.0, 0.0));
    for direction in [Vec3::new(0.3, 0.5, 0.2), Vec3::new(-0.4, 1.0, 0.0), Vec3::new(0.1, -0.2, 0.9)] {
        let mirrored = bench.trace(&beam(from, direction), &[(0, Act::Mirror)]).expect("from inside");
        let b = mirrored.flown(mirrored.p.distance(to));
        assert!(b.p.distance(to) < 4e-15, "{direction} comes to {:?}", b.p);
        assert!(b.dx(2).length() < 4e-15 && b.dx(3).length() < 4e-15, "{direction}: {} {}", b.dx(2), b.dx(3));
    }
}

#[test]
fn a_plane_mirror_at_sixty_degrees_spreads_by_the_closed_factors() {
    let (sin, cos) = (0.75f64.sqrt(), 0.5);
    let bench = Bench::new(vec![floor(0.0), floor(2.0)]);
    let start = beam(Point3::new(0.0, 0.0, 1.0), Vec3::new(sin, 0.0, -cos));
    let b = bench.trace(&start, &[(0, Act::Mirror), (1, Act::Land)]).expect("hits");
    assert!((b.area(0, 1) - 2.0).abs() < 1e-14, "collimated: {}", b.area(0, 1));
    assert!((b.area(2, 3) - 72.0).abs() < 1e-12, "point source: {}", b.area(2, 3));
}
