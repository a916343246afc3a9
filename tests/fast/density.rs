//! Media that vary: how much of them lies along rays, against closed forms, sums over many points, and an even twin.

use std::sync::Arc;

use pdembree::import::load_text;
use pdembree::math::{Dir3, Point3, Ray, Transform, Vec3};
use pdembree::medium::column::Reached;
use pdembree::medium::{Inside, Way};
use pdembree::radiometry::Spectrum;
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::Medium;
use pdembree::scene::density::{DensityGrid, Interpolation};
use pdembree::world::World;

/// Over [0, n] × [0, 1]² so that cells are 1 m long.
fn along_x(samples: &[f32], between: Interpolation) -> DensityGrid {
    let place = Transform::scale(Vec3::new(samples.len() as f64, 1.0, 1.0)).expect("no factor is zero");
    DensityGrid { place, counts: [samples.len(), 1, 1], samples: samples.to_vec(), between }
}

/// Of random numbers in a box that is turned and sheared.
fn random(between: Interpolation) -> DensityGrid {
    let counts = [5, 4, 3];
    let mut stream = Stream::new(11, Purpose::Test, 0, 0);
    let samples = (0..60).map(|i| if i % 7 == 0 { 0.0 } else { stream.uniform() as f32 }).collect();
    let columns = [Vec3::new(2.0, 0.3, -0.1), Vec3::new(-0.4, 1.5, 0.2), Vec3::new(0.1, 0.2, 1.0)];
    let place = Transform::new(columns, Vec3::new(-1.0, -0.8, -0.5)).expect("regular");
    DensityGrid { place, counts, samples, between }
}

fn random_ray(stream: &mut Stream) -> (Point3, Dir3) {
    let mut number = || 2.0 * stream.uniform() - 1.0;
    let (origin, w) = (Vec3::new(number(), number(), number()), Vec3::new(number(), number(), number()));
    (Point3::from_vec(origin * 2.0), Dir3::new(w).expect("a direction"))
}

/// ρ = x from the first centre to the last one, and level in the half cells outside: ∫ from a to b is (b² − a²)/2 divided by the
/// direction's x component; there and back again.
#[test]
fn the_column_through_a_ramp_is_its_closed_form() {
    let ramp = along_x(&[0.5, 1.5, 2.5, 3.5, 4.5], Interpolation::Linear);
    let whole = 0.5 * (4.5 * 4.5 - 0.25) + 0.5 * (0.5 + 4.5);
    for (slope, expected) in [(0.0, whole), (0.1, whole * 1.01f64.sqrt())] {
        let w = Dir3::new(Vec3::new(1.0, slope, 0.0)).expect("a direction");
        let start = Point3::new(-1.0, 0.2, 0.5);
        let column = ramp.column(start, w, [0.0, f64::INFINITY]);
        assert!((column / expected - 1.0).abs() < 1e-14, "{slope}: {column}, not {expected}");
        let back = ramp.column(start + w * 20.0, -w, [0.0, f64::INFINITY]);
        assert!((back / expected - 1.0).abs() < 1e-14, "{slope}: {back}, not {expected}");
    }
    // From x = 1.2 to x = 3.
    let part = ramp.column(Point3::new(0.0, 0.5, 0.5), Dir3::X, [1.2, 3.0]);
    assert!((part - 0.5 * (9.0 - 1.44)).abs() < 1e-14, "{part}");
    assert!((ramp.at(Point3::new(2.2, 0.1, 0.9)) - 2.2).abs() < 1e-14);
    assert_eq!(ramp.at(Point3::new(2.2, 1.1, 0.9)), 0.0);
}

/// Cells of 1 m: the sum of the densities times lengths; T = e^(−σ_t Σ ρ l) in every channel.
#[test]
fn light_gets_through_steps_as_beer_and_lambert_say() {
    let steps = along_x(&[1.0, 0.0, 3.0, 2.0], Interpolation::Cells);
    let medium = Medium {
        absorption: Spectrum::rgb(0.1, 0.2, 0.4),
        scattering: Spectrum::splat(0.3),
        asymmetry: 0.0,
        density: Some(Arc::new(steps)),
    };
    let (origin, w) = (Point3::new(-0.5, 0.3, 0.7), Dir3::X);
    for (from, to, column) in [(0.0, f64::INFINITY, 6.0), (0.0, 4.0, 5.0), (1.0, 3.0, 2.0), (2.0, 2.2, 0.0)] {
        let left = Way { medium: &medium, origin, w, from, to }.transmittance().to_array();
        for (left, sigma) in left.into_iter().zip([0.4, 0.5, 0.7f64]) {
            assert!((left - (-sigma * column).exp()).abs() < 1e-14, "{from} {to}: {left}");
        }
    }
}

/// Along random rays through a turned grid the column is the sum over 20 000 points by the midpoint rule, whose error is
/// at most half a step for each jump of at most 1; and the place up to a part of it has that column.
#[test]
fn columns_are_sums_over_many_points_and_places_their_inverse() {
    for (between, jumps) in [(Interpolation::Linear, 2.0), (Interpolation::Cells, 13.0)] {
        let grid = random(between);
        let mut stream = Stream::new(12, Purpose::Test, 0, 0);
        let mut met = 0;
        for ray in 0..150 {
            let (origin, w) = random_ray(&mut stream);
            let (length, points) = (4.0, 20_000);
            let step = length / f64::from(points);
            let sum: f64 = (0..points).map(|i| grid.at(origin + w * ((f64::from(i) + 0.5) * step)) * step).sum();
            let column = grid.column(origin, w, [0.0, length]);
            assert!((sum - column).abs() <= 0.5 * jumps * step + 1e-6, "{between:?} ray {ray}: {column}, not {sum}");
            assert_eq!(grid.reach(origin, w, [0.0, length], column * 1.01 + 1e-9), Reached::End(column));
            if column == 0.0 {
                continue;
            }
            met += 1;
            let part = stream.uniform() * column;
            let Reached::Place(t) = grid.reach(origin, w, [0.0, length], part) else { panic!("ray {ray} ends early") };
            let there = grid.column(origin, w, [0.0, t]);
            assert!((there - part).abs() < 1e-13, "{between:?} ray {ray}: {there}, not {part}");
            let profile = grid.profile(origin, w, [0.0, length]);
            assert!(profile.windows(2).all(|p| p[0][0] < p[1][0] && p[0][1] <= p[1][1]));
            assert!((profile.last().expect("met")[1] - column).abs() < 1e-13);
        }
        assert!(met > 20, "only {met} rays meet the grid");
    }
}

fn transmittance(density: &str) -> [f64; 3] {
    let text = format!(
        r#"
format = 1
atmosphere = "smoke"
[camera]
type = "perspective"
position = [0, 0, 9]
target = [0, 0, 0]
fov_degrees = 40
resolution = [4, 4]
[media.smoke]
sigma_a = [0.1, 0.2, 0.3]
sigma_s = 0.2
{density}
[materials.wall]
type = "lambert"
albedo = 0.5
[[objects]]
shape = "sphere"
centre = [0, 0, 0]
radius = 0.5
material = "wall"
[[objects]]
shape = "sphere"
centre = [0, 6, 0]
radius = 0.5
material = "wall"
[[lights]]
type = "point"
position = [0, 5, 0]
intensity = 1
"#
    );
    let loaded = load_text("density.toml".as_ref(), &text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let world = World::new(loaded.scene).expect("a world");
    let (a, b) = (Point3::new(-0.6, 2.0, 0.7), Point3::new(1.0, 4.0, -0.8));
    let ray = Ray { t_max: a.distance(b), ..Ray::new(a, Dir3::new(b - a).expect("two points")) };
    let regions = world.regions.as_ref().expect("media");
    world.transmittance(regions, &ray, Inside::NOTHING).expect("nothing in between").to_array()
}

/// A grid of ones is as no grid, and one of twos as twice the medium.
#[test]
fn an_even_grid_is_its_even_twin() {
    let of = |value: &str| {
        format!("density = {{ values = [{value}, {value}], counts = [1, 2, 1], min = [-9, -9, -9], max = [9, 9, 9] }}")
    };
    let even = transmittance("");
    for (one, two) in transmittance(&of("1"))
        .into_iter()
        .zip(transmittance(&of("2")))
        .zip(even)
        .map(|((a, b), e)| (a / e, b / (e * e)))
    {
        assert!((one - 1.0).abs() < 1e-14 && (two - 1.0).abs() < 1e-14, "{one} {two}");
    }
}
