//! Shapes against dense sampling of their implicit functions, closed-form grazing rays, and the rules of rays.

use pdembree::math::{Point3, Ray, Vec3};
use pdembree::shape::Shape;

use crate::support::shapes::{self, Known, random, random_direction};

fn ray(origin: Point3, direction: Vec3) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY, time: 0.0 }
}

/// The first sign change of the implicit function over `steps` samples of (from, to) that lies on the shape itself,
/// bisected to the last bit.
fn sampled(known: &Known, ray: &Ray, from: f64, to: f64, steps: u32) -> Option<f64> {
    let f = |t: f64| (known.implicit)(ray.at(t));
    let place = |i: u32| from + (to - from) * f64::from(i) / f64::from(steps);
    (0..steps).find_map(|i| {
        let (mut lo, mut hi) = (place(i), place(i + 1));
        let positive = f(hi) > 0.0;
        if (f(lo) > 0.0) == positive {
            return None;
        }
        for _ in 0..80 {
            let middle = 0.5 * (lo + hi);
            if (f(middle) > 0.0) == positive { hi = middle } else { lo = middle }
        }
        (known.inside)(ray.at(lo)).then_some(lo)
    })
}

/// The interval of a ray inside the sphere around the shape.
fn around(known: &Known, ray: &Ray) -> Option<(f64, f64)> {
    let d = ray.direction.length();
    let middle = (known.centre - ray.origin).dot(ray.direction) / (d * d);
    let apart = ray.at(middle).distance(known.centre);
    let half = (known.reach * known.reach - apart * apart).max(0.0).sqrt() / d;
    (half > 0.0).then_some(((middle - half).max(ray.t_min), middle + half)).filter(|(a, b)| a < b)
}

/// `intersect` against sampling: a hit on the surface, none before it, none missed.
fn check(known: &Known, ray: &Ray, steps: u32, what: &str) -> bool {
    let hit = known.shape.intersect(ray);
    let dense = around(known, ray).and_then(|(from, to)| sampled(known, ray, from, to, steps));
    let name = known.name;
    let scale = ray.direction.length();
    let Some(t) = hit else {
        assert!(dense.is_none(), "{name}, {what}: {ray:?} misses the crossing at {dense:?}");
        return false;
    };
    assert!(t > ray.t_min && t < ray.t_max, "{name}, {what}: {ray:?} {t}");
    let residual = (known.implicit)(ray.at(t)).abs();
    // Each coordinate of a point so far from the origin is rounded by 2⁻⁵³ of its size, a few times.
    let rounding = 20.0 * f64::EPSILON * (1.0 + ray.origin.length() + scale * t);
    assert!(residual < rounding, "{name}, {what}: {ray:?} {t} is {residual:e} off the surface");
    if let Some(sampled) = dense {
        assert!(t * scale <= sampled * scale + 1e-12, "{name}, {what}: {ray:?} {t} is behind {sampled}");
    }
    true
}

#[test]
fn the_first_hit_agrees_with_dense_sampling() {
    for (index, known) in shapes::all().iter().enumerate() {
        let mut stream = random(index as u64);
        let mut hits = 0;
        for _ in 0..400 {
            let from = known.centre + random_direction(&mut stream) * (known.reach * 3.0 * stream.uniform());
            let to = known.point(&mut stream) + random_direction(&mut stream) * (0.3 * known.reach * stream.uniform());
            let length = 10f64.powf(4.0 * stream.uniform() - 2.0);
            hits += u32::from(check(known, &ray(from, (to - from).normalize() * length), 2000, "any ray"));
        }
        assert!(hits > 100, "{}: only {hits} of 400 rays hit", known.name);
    }
}

#[test]
fn a_ray_that_starts_just_off_the_surface_finds_the_next_hit_only() {
    for (index, known) in shapes::all().iter().enumerate() {
        let mut stream = random(100 + index as u64);
        for _ in 0..300 {
            let p = known.point(&mut stream);
            let n = known.shape.surface_at(p, 0.0).n;
            for offset in [1e-6, 1e-9] {
                let direction = random_direction(&mut stream);
                let side = 1f64.copysign(n.dot(direction));
                let ray = ray(p + n * (side * offset), direction);
                if check(known, &ray, 4000, "secondary ray") {
                    let t = known.shape.intersect(&ray).expect("checked");
                    // Going away from the surface by |cos|, it is met again where it has bent back by that much; no
                    // radius of curvature here is below 0.01.
                    assert!(t > 0.01 * n.dot(direction).abs(), "{}: {ray:?} meets its own start at {t}", known.name);
                }
            }
        }
    }
}

#[test]
fn a_ray_that_starts_on_the_torus_or_the_waves_leaves_them() {
    for (index, known) in shapes::all().iter().enumerate() {
        if !matches!(known.shape, Shape::Torus(_) | Shape::HeightField(_)) {
            continue;
        }
        let mut stream = random(200 + index as u64);
        for _ in 0..300 {
            let p = known.point(&mut stream);
            let direction = random_direction(&mut stream);
            let cos = known.shape.surface_at(p, 0.0).n.dot(direction).abs();
            if cos > 0.01
                && let Some(t) = known.shape.intersect(&ray(p, direction))
            {
                assert!(t > 0.01 * cos, "{}: {p:?} {direction} {t}", known.name);
            }
        }
    }
}

#[test]
fn t_is_in_units_of_the_direction_and_inside_the_ray() {
    for (index, known) in shapes::all().iter().enumerate() {
        let mut stream = random(300 + index as u64);
        for _ in 0..100 {
            let p = known.point(&mut stream);
            let from = known.centre + random_direction(&mut stream) * (3.0 * known.reach);
            let unit = (p - from).normalize();
            let first = known.shape.intersect(&ray(from, unit)).expect("aimed at a point of it");
            let scaled = known.shape.intersect(&ray(from, unit * 0.125)).expect("the same ray");
            // Grazing rays move by the square root of rounding; measured on the surface instead.
            assert!((scaled * 0.125 - first).abs() < 1e-7, "{}", known.name);
            let before = Ray { t_max: first * (1.0 - 1e-9), ..ray(from, unit) };
            assert_eq!(known.shape.intersect(&before), None, "{}", known.name);
            let behind = Ray { t_min: first * (1.0 + 1e-9), ..ray(from, unit) };
            check(known, &behind, 2000, "past the first hit");
        }
    }
}

#[test]
fn grazing_rays_hit_the_torus_where_the_closed_form_says() {
    use pdembree::shape::Torus;
    let (major, minor) = (1.0f64, 0.25f64);
    let torus = Shape::Torus(Torus::new(Point3::ORIGIN, Vec3::Z, major, minor).expect("valid"));
    for exponent in 1..=13 {
        let depth = 10f64.powi(-exponent);
        // Along the outer equator: a chord of the circle of radius R + r.
        let reach = major + minor;
        let x = reach - depth;
        let half = ((reach - x) * (reach + x)).sqrt();
        // Over the top: |x| where the distance from the ring's circle is r again.
        let z = minor - depth;
        let width = ((minor - z) * (minor + z)).sqrt();
        let over = (2.0 * major * width + width * width).sqrt();
        let cases = [
            ("equator", Point3::new(x, -3.0, 0.0), Vec3::Y, 3.0 - half),
            ("top", Point3::new(-3.0, major, z), Vec3::X, 3.0 - over),
        ];
        for (name, origin, direction, expected) in cases {
            let hit = torus.intersect(&ray(origin, direction)).unwrap_or_else(|| panic!("{name} misses at {depth:e}"));
            // A change of 2⁻⁵² in the depth moves the hit by this much.
            let tolerance = 1e-15 * expected + 4.0 * f64::EPSILON / (2.0 * depth).sqrt().min(1.0) / depth.sqrt();
            assert!((hit - expected).abs() < tolerance, "{name} at {depth:e}: {hit} against {expected}");
        }
        let outside = Point3::new(reach + depth, -3.0, 0.0);
        assert_eq!(torus.intersect(&ray(outside, Vec3::Y)), None, "outside by {depth:e}");
    }
}

#[test]
fn grazing_rays_hit_the_crest_of_a_wave_where_it_stands_over_them() {
    use pdembree::math::Vec2;
    use pdembree::shape::{HeightField, Wave};
    let wave = Wave { amplitude: 0.25, wave_vector: Vec2::new(std::f64::consts::TAU, 0.0), phase: 0.0, rate: 0.0 };
    let half = Vec2::new(2.0, 1.0);
    let field = HeightField::new(Point3::ORIGIN, Vec3::X, Vec3::Z, half, vec![wave]).expect("valid");
    let field = Shape::HeightField(field);
    for exponent in 1..=13 {
        let depth = 10f64.powi(-exponent);
        // First crest at x = −1.75; the ray enters it where sin 2πx = 1 − 4 depth.
        let width = (1.0 - 4.0 * depth).acos() / std::f64::consts::TAU;
        let expected = 3.0 - 1.75 - width;
        let hit = field.intersect(&ray(Point3::new(-3.0, 0.3, 0.25 - depth), Vec3::X)).expect("below the crest");
        // Positions up to 3 and phases up to 4π are rounded by 2⁻⁵³ of their size, a few times.
        let tolerance = 16.0 * f64::EPSILON + f64::EPSILON / depth.sqrt();
        assert!((hit - expected).abs() < tolerance, "{depth:e}: {hit} against {expected}");
        assert_eq!(field.intersect(&ray(Point3::new(-3.0, 0.3, 0.25 + depth), Vec3::X)), None, "{depth:e} above");
    }
}

#[test]
fn a_ray_with_a_number_that_is_none_misses() {
    for known in shapes::all() {
        for bad in [f64::NAN, f64::INFINITY] {
            for axis in 0..3 {
                let mut v = Vec3::new(0.1, 0.2, 0.3);
                v[axis] = bad;
                assert_eq!(known.shape.intersect(&ray(Point3::from_vec(v), Vec3::X)), None, "{}", known.name);
                let hit = known.shape.intersect(&ray(known.centre, v));
                assert!(hit.is_none_or(f64::is_finite), "{} {hit:?}", known.name);
            }
        }
        assert_eq!(known.shape.intersect(&ray(known.centre, Vec3::ZERO)), None, "{}", known.name);
    }
}
