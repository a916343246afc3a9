//! The maps that draw points of shapes by area: inverse, Jacobian, density.

use pdembree::shape::Shape;

use crate::support::shapes::{self, random};

const STEP: f64 = 1e-6;

fn emitters() -> impl Iterator<Item = (&'static str, Shape)> {
    shapes::all().into_iter().filter(|k| k.shape.area().is_some()).map(|k| (k.name, k.shape))
}

#[test]
fn only_the_height_field_cannot_be_sampled() {
    for known in shapes::all() {
        let can = known.name != "height_field";
        assert_eq!(known.shape.area().is_some(), can, "{}", known.name);
        assert_eq!(known.shape.sample_area([0.3, 0.7]).is_some(), can);
        assert_eq!(known.shape.pdf_area().is_some(), can);
        let on_it = known.point(&mut random(800));
        assert_eq!(known.shape.inverse_area(on_it).is_some(), can, "{}", known.name);
    }
}

#[test]
fn samples_lie_on_the_surface_and_their_inverse_gives_the_square_back() {
    for known in shapes::all() {
        let mut stream = random(600);
        for _ in 0..1000 {
            let u = stream.uniform2();
            let Some(sample) = known.shape.sample_area(u) else { continue };
            assert!((known.implicit)(sample.p).abs() < 1e-14 && (known.inside)(sample.p), "{} {u:?}", known.name);
            let back = known.shape.inverse_area(sample.p).expect("samplable");
            let error = (back[0] - u[0]).abs().max((back[1] - u[1]).abs());
            assert!(error < 1e-12, "{}: {u:?} comes back as {back:?}", known.name);
            let normal = known.shape.surface_at(sample.p, 0.0).n;
            assert!((normal.to_vec() - sample.n.to_vec()).length() < 1e-13, "{}", known.name);
        }
    }
}

#[test]
fn the_jacobian_is_the_central_difference_and_its_area_the_reciprocal_density() {
    for (name, shape) in emitters() {
        let mut stream = random(700);
        for _ in 0..1000 {
            // Inside every patch of the piecewise maps: away from the diagonals and the middle lines.
            let u = stream.uniform2();
            let near_crease = |x: f64| x.abs() < 10.0 * STEP;
            let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
            if [a, b, a - b, a + b, 1.0 - a.abs() - b.abs(), 1.0 - a.abs(), 1.0 - b.abs()].into_iter().any(near_crease)
            {
                continue;
            }
            let at = |du: f64, dv: f64| shape.sample_area([u[0] + du, u[1] + dv]).expect("samplable").p;
            let sample = shape.sample_area(u).expect("samplable");
            let differences = [at(STEP, 0.0) - at(-STEP, 0.0), at(0.0, STEP) - at(0.0, -STEP)];
            for (exact, difference) in [sample.dpdu, sample.dpdv].into_iter().zip(differences) {
                let error = (difference / (2.0 * STEP) - exact).length() / exact.length();
                // Near the corners of the octahedral map the second derivative grows like 1/r.
                assert!(error < 1e-7, "{name} at {u:?}: relative error {error:e}");
            }
            let density = shape.pdf_area().expect("samplable").get();
            let cross = sample.dpdu.cross(sample.dpdv);
            assert!((cross.dot(sample.n.to_vec()) * density - 1.0).abs() < 1e-12, "{name} at {u:?}");
        }
    }
}

#[test]
fn the_maps_of_disk_and_sphere_are_smooth_across_their_creases() {
    for (name, shape) in emitters() {
        // Points either side of diagonals, middle lines and the equator stay together.
        for (a, b) in [
            ([0.5, 0.3], [0.5, 0.3 + 1e-9]),
            ([0.7, 0.7 - 1e-9], [0.7, 0.7 + 1e-9]),
            ([0.25, 0.25], [0.25, 0.25 + 1e-9]),
        ] {
            let [p, q] = [a, b].map(|u| shape.sample_area(u).expect("samplable").p);
            assert!(p.distance(q) < 1e-7, "{name}: {a:?} and {b:?} are {} apart", p.distance(q));
        }
        for corner in [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [1.0, 1.0], [0.5, 1.0]] {
            let s = shape.sample_area(corner).expect("samplable");
            assert!(s.p.is_finite() && s.dpdu.is_finite() && s.dpdv.is_finite(), "{name} at {corner:?}: {s:?}");
        }
    }
}

#[test]
fn the_area_is_the_integral_of_the_parametrisation() {
    // Midpoint rule over (u, v); exact for periodic integrands, second order for the sphere's sine.
    for known in shapes::all() {
        let Some(area) = known.shape.area() else { continue };
        if matches!(known.shape, Shape::Disk(_)) {
            continue; // its (u, v) square is bigger than the disk
        }
        let n = 200;
        let mean = (0..n * n)
            .map(|i| {
                let u = [(f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n)];
                let at = known.shape.parametrisation_at(known.shape.sample_area(u).expect("samplable").p, 0.0);
                // Drawn uniformly by area, the mean of 1/|∂p/∂u × ∂p/∂v| is 1/area.
                1.0 / at.dpdu.cross(at.dpdv).length()
            })
            .sum::<f64>()
            / f64::from(n * n);
        let error = (mean * area - 1.0).abs();
        // The sphere's integrand 1/sin θ is singular at the poles; r⁻¹ over cells of 1/n costs about 1/n.
        let allowed = if known.name == "sphere" { 1.0 / f64::from(n) } else { 1e-5 };
        assert!(error < allowed, "{}: {error:e}", known.name);
    }
}
