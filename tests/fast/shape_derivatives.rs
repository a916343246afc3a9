//! Normals, shape operators and tangents of every shape against central differences; bounds; refused parameters.

use pdembree::math::{Bounds3, Point3, Vec2, Vec3};
use pdembree::shape::{Cylinder, Disk, HeightField, LocalSurface, Rectangle, ShapeError, Sphere, Torus, Wave};

use crate::support::shapes::{self, Known, random, random_direction};

const STEP: f64 = 1e-5;
/// Of a central difference with that step on surfaces whose third derivatives stay below 1e4: STEP²/6 · 1e4, and the
/// rounding 1e-15/STEP below it.
const ALLOWED: f64 = 1e-6;

/// The surface a little to both sides of `at` along the tangent `e`.
fn either_side(known: &Known, at: &LocalSurface, e: Vec3) -> [LocalSurface; 2] {
    [1.0, -1.0].map(|side| known.shape.surface_at(at.p + e * (side * STEP), 0.0))
}

#[test]
fn shape_operators_and_tangents_are_the_differences_of_the_surface() {
    for (index, known) in shapes::all().iter().enumerate() {
        let mut stream = random(400 + index as u64);
        for _ in 0..200 {
            let at = known.shape.surface_at(known.point(&mut stream), 0.0);
            let name = known.name;
            assert!((known.implicit)(at.p).abs() < 1e-14, "{name}: surface_at leaves the surface");
            let place = known.shape.parametrisation_at(at.p, 0.0);
            assert!((0.0..=1.0).contains(&place.uv.x) && (0.0..=1.0).contains(&place.uv.y), "{name}: {place:?}");
            let outward = place.dpdu.cross(place.dpdv);
            assert!(outward.dot(at.n.to_vec()) > 0.0, "{name}: ∂p/∂u × ∂p/∂v points inward at {at:?}");
            assert!(at.n.dot(place.dpdu).abs() < 1e-13 && at.n.dot(place.dpdv).abs() < 1e-13, "{name}");
            assert!((known.implicit)(at.p + at.n * 1e-4) > 0.0, "{name}: the normal points inward");

            let e = at.n.cross(random_direction(&mut stream)).normalize();
            let [a, b] = either_side(known, &at, e);
            let (dp, dn) = (a.p - b.p, a.n.to_vec() - b.n.to_vec());
            let uv = |at: &LocalSurface| known.shape.parametrisation_at(at.p, 0.0).uv;
            let mut duv = uv(&a) - uv(&b);
            // Around the seam of a closed parameter.
            duv -= Vec2::new(duv.x.round(), duv.y.round());
            assert!(dp.length() > STEP, "{name}");
            let operator = (at.shape.apply(dp) - dn).length() / (2.0 * STEP);
            assert!(operator < ALLOWED * (1.0 + dn.length() / STEP), "{name}: S is off by {operator:e} at {at:?}");
            // Close to a sphere's pole u runs wild.
            let steep = place.dpdu.length() < 0.3 && name == "sphere";
            let tangent = (place.dpdu * duv.x + place.dpdv * duv.y - dp).length() / (2.0 * STEP);
            assert!(steep || tangent < ALLOWED, "{name}: ∂p is off by {tangent:e} at {at:?}");
        }
    }
}

#[test]
fn a_sphere_has_a_finite_surface_at_its_poles_and_centre() {
    let sphere = pdembree::shape::Shape::Sphere(Sphere::new(Point3::ORIGIN, 2.0).expect("valid"));
    for p in [Point3::new(0.0, 0.0, 2.0), Point3::new(0.0, 0.0, -2.0), Point3::ORIGIN] {
        let at = sphere.surface_at(p, 0.0);
        assert!(at.p.is_finite() && at.n.is_finite(), "{at:?}");
        let place = sphere.parametrisation_at(p, 0.0);
        assert!(place.uv.is_finite() && place.dpdv.length() > 6.0, "{place:?}");
    }
}

#[test]
fn bounds_hold_the_shape_and_no_more() {
    for (index, known) in shapes::all().iter().enumerate() {
        let bounds = known.shape.bounds();
        let mut stream = random(500 + index as u64);
        let seen = Bounds3::from_points((0..20_000).map(|_| known.point(&mut stream)));
        let slack = [seen.min - bounds.min, bounds.max - seen.max];
        for gap in slack {
            assert!(gap.min_element() > -1e-14, "{}: {seen:?} leaves {bounds:?}", known.name);
            // A height field's box holds Σ |amplitude|, which the field need not reach.
            let most = if known.name == "height_field" { 0.2 } else { 0.02 * known.reach };
            assert!(gap.max_element() < most, "{}: {bounds:?} is too big for {seen:?}", known.name);
        }
    }
}

#[test]
fn parameters_that_make_no_shape_are_refused_with_a_reason() {
    let o = Point3::ORIGIN;
    let nan = Point3::new(f64::NAN, 0.0, 0.0);
    let wave = Wave { amplitude: f64::INFINITY, wave_vector: Vec2::X, phase: 0.0, rate: 0.0 };
    let refusals: [(Option<ShapeError>, &str); 14] = [
        (Sphere::new(o, 0.0).err(), "radius is 0"),
        (Sphere::new(o, -1.0).err(), "radius is -1"),
        (Sphere::new(o, f64::NAN).err(), "radius is NaN"),
        (Sphere::new(nan, 1.0).err(), "centre"),
        (Cylinder::new(o, o, 1.0).err(), "axis from base to top has no length"),
        (Cylinder::new(o, nan, 1.0).err(), "top"),
        (Torus::new(o, Vec3::Z, 1.0, 1.5).err(), "pass through itself"),
        (Torus::new(o, Vec3::ZERO, 1.0, 0.5).err(), "axis has no length"),
        (Disk::new(o, Vec3::ZERO, 1.0).err(), "normal has no length"),
        (Rectangle::new(o, Vec3::X, Vec3::new(0.1, 1.0, 0.0)).err(), "not perpendicular"),
        (Rectangle::new(o, Vec3::X, Vec3::ZERO).err(), "half axis b has no length"),
        (HeightField::new(o, Vec3::Z, Vec3::Z, Vec2::ONE, vec![]).err(), "parallel"),
        (HeightField::new(o, Vec3::X, Vec3::Z, Vec2::new(1.0, 0.0), vec![]).err(), "half size in y is 0"),
        (HeightField::new(o, Vec3::X, Vec3::Z, Vec2::ONE, vec![wave]).err(), "waves"),
    ];
    for (error, words) in refusals {
        let message = error.unwrap_or_else(|| panic!("'{words}' was accepted")).to_string();
        assert!(message.contains(words), "{message:?} does not say {words:?}");
    }
}

#[test]
fn a_rectangle_forgives_the_rounding_of_decimals() {
    let a = Vec3::new(0.866_025_4, 0.5, 0.0);
    let b = Vec3::new(-0.5, 0.866_025_4, 1e-7);
    let rectangle = Rectangle::new(Point3::ORIGIN, a, b).expect("perpendicular to 1e-7");
    let [a, b] = rectangle.half_axes();
    assert!(a.dot(b).abs() < 1e-16 && rectangle.normal().dot(a).abs() < 1e-16);
}
