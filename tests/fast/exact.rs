//! The exact pictures of closed forms against other derivations of them, and the scenes that are refused.

use std::f64::consts::PI;

use pdembree::import::Override;
use pdembree::study::exact::ball_lens::{BallLens, Passage};
use pdembree::study::exact::numerics::metal_reflectance;
use pdembree::study::exact::ring::{Ring, Wall};
use pdembree::study::exact::{self, ClosedForm, ExactPicture};
use pdembree::surface::fresnel::conductor;

use crate::support::closed_form::{ball, ring, simpson, wave};
use crate::support::data::root;

const RING: &str = "scenes/tests/ring_floor.toml";
const BALL: &str = "scenes/tests/ball_lens.toml";
const BALL_FLUX: &str = "scenes/tests/ball_flux.toml";

/// The picture of a scene with changes laid over it: settings as `-D` takes them, or texts, `old => new`.
fn try_picture(form: ClosedForm, file: &str, changes: &[&str]) -> Result<ExactPicture, exact::NotThisForm> {
    let mut text = std::fs::read_to_string(root().join(file)).expect("the scene");
    let mut overrides: Vec<Override> = Vec::new();
    for change in changes {
        match change.split_once(" => ") {
            Some((old, new)) => {
                assert!(text.contains(old), "{file}: {old}");
                text = text.replace(old, new);
            }
            None => overrides.push(change.parse().expect("an override")),
        }
    }
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).expect("a scene");
    let loaded = pdembree::import::load(&path, &overrides);
    exact::picture(form, &loaded.unwrap_or_else(|problems| panic!("{file}, {changes:?}: {problems}")).scene)
}

fn picture(form: ClosedForm, file: &str, changes: &[&str]) -> ExactPicture {
    try_picture(form, file, changes).unwrap_or_else(|error| panic!("{file}, {changes:?}: {error}"))
}

#[track_caller]
fn refused(form: ClosedForm, file: &str, scenes: &[(&[&str], &str)]) {
    for (changes, message) in scenes {
        let error = try_picture(form, file, changes).expect_err(message).to_string();
        assert!(error.contains(message), "{changes:?}: {error}");
    }
}

/// π times the radiance: the irradiance of a white receiver.
fn irradiance(picture: &ExactPicture, x: usize, y: usize) -> f64 {
    PI * picture.radiance[y * picture.width as usize + x][1]
}

/// Irradiance times area over the whole picture, `width` across.
fn flux(picture: &ExactPicture, width: f64, channel: usize) -> f64 {
    let area = (width / f64::from(picture.width)).powi(2);
    picture.radiance.iter().map(|rgb| PI * rgb[channel] * area).sum()
}

/// The mean over a square by Simpson's rule, and the largest difference between its nine points over their mean.
fn mean_and_spread(at: impl Fn(f64, f64) -> f64, centre: [f64; 2], side: f64) -> (f64, f64) {
    let (mut mean, mut low, mut high) = (0.0, f64::INFINITY, 0.0f64);
    for (i, wx) in [(-0.5, 1.0), (0.0, 4.0), (0.5, 1.0)] {
        for (j, wy) in [(-0.5, 1.0), (0.0, 4.0), (0.5, 1.0)] {
            let value = at(centre[0] + i * side, centre[1] + j * side);
            mean += value * wx * wy / 36.0;
            (low, high) = (low.min(value), high.max(value));
        }
    }
    (mean, if mean == 0.0 { 0.0 } else { (high - low) / mean })
}

/// The wave's picture from the scene file is that of the independent closed form, in every pixel.
#[test]
fn the_exact_wave_is_the_closed_form() {
    for (file, fresnel) in [("scenes/tests/wave.toml", false), ("scenes/refraction/refraction.toml", true)] {
        let picture = picture(ClosedForm::Wave, file, &[]);
        let row = wave::averaged_row(picture.width as usize, fresnel);
        for (i, radiance) in picture.radiance.iter().enumerate() {
            let e = PI * radiance[1];
            let expected = row[i % row.len()];
            assert!((e - expected).abs() < 1e-7 * expected, "{file}, pixel {i}: {e} is not {expected}");
        }
        assert!(picture.error.iter().all(|e| e[1] < 1e-6));
    }
}

#[test]
fn a_scene_that_is_not_the_wave_is_refused_with_the_point() {
    refused(
        ClosedForm::Wave,
        "scenes/tests/wave.toml",
        &[
            (&["render.max_depth=4"], "max_depth"),
            (&["render.max_bounces=1"], "max_bounces"),
            (&["camera.filter=gaussian"], "filter"),
            (&["camera.width=3"], "more than the receiver"),
            (&["camera.position=[0, 0, 1]"], "between the wave and the receiver"),
            (&["camera.up=[1, 0, 0]"], "x to the right"),
            (&["lights.0.direction=[0.1, 0, -1]", "lights.0.extent.a=[0.5, 0, 0.05]"], "does not fall along -z"),
            (&["objects.0.waves=[{ amplitude = 0.25, wave_vector = [6.28, 0], phase = 0 }]"], "phase"),
            (&["objects.0.material=receiver"], "glass"),
        ],
    );
}

/// One ray at a time: where it lands, and how much an area of the rim's disc is stretched there
/// (PHOTON_DIFFERENTIALS 12, item 6).
#[test]
fn rays_of_the_ring_land_where_they_should() {
    let expected = [
        ((0.2, 0.3), [0.58816935, 0.04469107], 0.06480246),
        ((0.5, -0.4), [0.38374543, 0.17446059], 0.70970413),
        ((0.7, 0.1), [0.10807513, -0.08009522], 0.81914370),
    ];
    let wall = Wall::Mirror { reflectance: [1.0; 3] };
    for ((x, y), end, factor) in expected {
        let narrow = 1e-4;
        let ring = Ring { travel: 1.2, source: [[x - narrow, x + narrow], [-1.0, 1.0]], most_bounces: 9, wall };
        let line = |y: f64| match ring.lines(y.asin())[..] {
            [line] => line,
            ref lines => panic!("{} lines", lines.len()),
        };
        let middle = |y: f64| [0, 1].map(|i| 0.5 * (line(y).from[i] + line(y).to[i]));
        let along = [0, 1].map(|i| (line(y).to[i] - line(y).from[i]) / (2.0 * narrow));
        for i in 0..2 {
            assert!((middle(y)[i] - end[i]).abs() < 1.1e-8, "{:?} is not {end:?}", middle(y));
        }
        let step = 1e-5;
        let across = [0, 1].map(|i| (middle(y + step)[i] - middle(y - step)[i]) / (2.0 * step));
        let stretch = (along[0] * across[1] - along[1] * across[0]).abs();
        assert!((stretch - factor).abs() < 1e-7, "{stretch} is not {factor}");
    }
}

/// Every fifth pixel over which the irradiance changes by less than 2 % holds its mean.
#[test]
fn the_exact_ring_is_the_closed_form() {
    for reflectance in [1.0, 0.7] {
        let change = format!("materials.mirror.reflectance={reflectance}");
        let picture = picture(ClosedForm::Ring, RING, &[&change]);
        let side = 2.0 / f64::from(picture.width);
        let caustic = |x: f64, y: f64| {
            let all = ring::irradiance([x, y], ring::TRAVEL, reflectance);
            let unreflected = all > 0.0 && (x - ring::TRAVEL).powi(2) + y * y < 1.0;
            all - f64::from(u8::from(unreflected))
        };
        let mut compared = 0;
        for (i, j) in (0..52 * 52).map(|k| (k / 52 * 5, k % 52 * 5)) {
            let centre = [-1.0 + (i as f64 + 0.5) * side, -1.0 + (j as f64 + 0.5) * side];
            if centre[0].hypot(centre[1]) > 1.0 - side {
                continue;
            }
            let (mean, spread) = mean_and_spread(caustic, centre, side);
            if spread < 0.02 {
                compared += 1;
                let found = irradiance(&picture, i, j);
                assert!((found - mean).abs() <= 2e-4 * mean, "pixel {i}, {j}: {found} is not {mean}");
            }
        }
        assert!(compared > 1000, "only {compared} pixels");
        let worst = picture.error.iter().map(|e| PI * e[1]).fold(0.0, f64::max);
        assert!(worst < 0.02, "{worst}");
    }
}

/// All light over the rim that does not reach the floor at once, π less two discs' common part, and all that the outside
/// mirrors: x from -1.01 to the wall.
#[test]
fn the_ring_keeps_its_light() {
    let picture = picture(ClosedForm::Ring, RING, &["camera.width=6"]);
    let unreflected = 2.0 * (0.5 * ring::TRAVEL).acos() - 0.5 * ring::TRAVEL * (4.0 - ring::TRAVEL.powi(2)).sqrt();
    let outside = 2.02 - 0.5 * PI;
    let expected = PI - unreflected + outside;
    let found = flux(&picture, 6.0, 1);
    // Chords that are mirrored more than 31 times hold 1e-6 of the light.
    assert!((found - expected).abs() < 1e-5, "{found} is not {expected}");
}

/// A golden wall takes its share at each bounce: the sum over all rays of an even grid.
#[test]
fn a_metal_ring_colours_its_light() {
    for (eta, k) in [(0.18, 3.4), (1.4, 1.9), (1.5, 0.0), (0.05, 4.2)] {
        for cos in (0..=20).map(|i| f64::from(i) / 20.0) {
            let (found, expected) = (metal_reflectance(cos, eta, k), conductor(cos, eta, k));
            assert!((found - expected).abs() < 1e-13, "{eta} + {k}i, {cos}: {found} is not {expected}");
        }
    }
    let gold = [
        "camera.width=6",
        "type = \"mirror\" => type = \"conductor\"",
        "reflectance = 1 => eta = [0.18, 0.42, 1.37]\nk = [3.4, 2.3, 1.8]",
    ];
    let picture = picture(ClosedForm::Ring, RING, &gold);
    for (channel, (eta, k)) in [(0.18, 3.4), (0.42, 2.3), (1.37, 1.8)].into_iter().enumerate() {
        let level = 0.5f64.sqrt();
        let over_y = |phi: f64| {
            let half = phi.cos();
            let left = conductor(level * half, eta, k);
            // The lengths of the rim's chord whose rays bounce once, twice …
            let (first, last) = (ring::TRAVEL, ring::TRAVEL + 2.0 * half);
            let bounced = (1..60).map(|n| {
                let (from, to) = (2.0 * half * f64::from(n), 2.0 * half * f64::from(n + 1));
                (to.min(last) - from.max(first)).max(0.0) * left.powi(n)
            });
            half * (bounced.sum::<f64>() + (1.01 - half) * left)
        };
        let expected = simpson(over_y, -0.5 * PI, 0.5 * PI, 20000);
        let found = flux(&picture, 6.0, channel);
        assert!((found - expected).abs() < 1e-4 * expected, "{channel}: {found} is not {expected}");
    }
}

/// A camera that is turned by 90 degrees shows the same light elsewhere.
#[test]
fn the_ring_may_lie_askew_in_its_picture() {
    let small = "camera.resolution=[32, 32]";
    let upright = picture(ClosedForm::Ring, RING, &[small]);
    let turned = picture(ClosedForm::Ring, RING, &[small, "camera.up=[1, 0, 0]"]);
    for (x, y) in (0..32 * 32).map(|i| (i % 32, i / 32)) {
        // x is up, z is to the right.
        let (a, b) = (irradiance(&upright, x, y), irradiance(&turned, y, 31 - x));
        assert!((a - b).abs() < 1e-9 * (1.0 + a), "{x}, {y}: {a} is not {b}");
    }
}

#[test]
fn a_scene_that_is_not_the_ring_is_refused_with_the_point() {
    refused(
        ClosedForm::Ring,
        RING,
        &[
            (&["render.max_depth=1"], "max_depth is 1"),
            (&["render.max_bounces=1"], "max_bounces"),
            (&["camera.filter=gaussian"], "filter"),
            (&["camera.width=6.1"], "more than the receiver"),
            (&["camera.position=[0, -3, 0]"], "straight on the receiver's lit side"),
            (&["camera.position=[0.5, 3, 0]"], "straight on the receiver's lit side"),
            (&["camera.position=[0, -1, 0]", "camera.target=[0, -2, 0]"], "looks away"),
            (&["objects.1.base=[0, 0.1, 0]"], "base is not on the floor"),
            (&["objects.1.top=[0.1, 1.2, 0]"], "not perpendicular to the floor"),
            (&["objects.1.transform=[{ translate = [0.1, 0, 0] }]"], "no cylinder without a transform"),
            (&["objects.1.material=white"], "no mirror of one colour"),
            (
                &[
                    "[[lights]] => [[objects]]\nshape = \"sphere\"\ncentre = [0, 9, 0]\nradius = 1\nmaterial = \"white\"\n[[lights]]",
                ],
                "3 objects instead of a ring and its floor",
            ),
            (&["objects.0.material=mirror"], "one matt colour"),
            (&["lights.0.direction=[0, -1, 0]", "lights.0.extent.a=[1, 0, 0]"], "straight down"),
            (
                &["lights.0.direction=[0.7071067811865476, 0.7071067811865476, 0]", "lights.0.extent.a=[-0.5, 0.5, 0]"],
                "does not come down",
            ),
            (&["a = [0.505, 0.505, 0], b = [0, 0, 1.01] => radius = 1"], "is a disk"),
            (&["lights.0.extent.centre=[-0.4, 1.6, 0]"], "below the rim"),
            (
                &[
                    "lights.0.extent.a=[0.5, 0.5, 0.7071067811865476]",
                    "lights.0.extent.b=[-0.5, -0.5, 0.7071067811865476]",
                ],
                "sides are not along",
            ),
            (
                &["[expect] => [[lights]]\ntype = \"point\"\nposition = [0, 3, 0]\nintensity = 1\n[expect]"],
                "not one beam",
            ),
        ],
    );
}

/// Any number of reflections inside, and the one outside, as vectors find them.
#[test]
fn rays_through_the_ball_land_where_they_should() {
    for (index, receiver) in [(1.5, 2.0), (1.33, 1.2), (2.4, 1.0)] {
        let lens = BallLens { index, receiver, beam: 1.0, fresnel: true, most_inner: 5 };
        let passages = [(None, Passage::Outside)].into_iter();
        let mut landed = 0;
        for (inner, passage) in passages.chain((0..6).map(|inner| (Some(inner), Passage::Through { inner }))) {
            for h in (1..100).map(|i| f64::from(i) / 100.0) {
                let found = lens.landing(h.asin(), passage).map(|rho| (rho, lens.passed(h.asin(), passage)));
                let expected = ball::traced(h, receiver, index, inner);
                assert_eq!(found.is_some(), expected.is_some(), "{passage:?}, {h}");
                if let (Some(found), Some(expected)) = (found, expected) {
                    landed += usize::from(inner.is_some_and(|inner| inner > 0));
                    // Far landings magnify the rounding of the direction.
                    let close = |a: f64, b: f64| (a - b).abs() < 1e-8 * (1.0 + b * b);
                    assert!(close(found.0, expected.0) && close(found.1, expected.1), "{found:?} is not {expected:?}");
                }
            }
        }
        assert!(landed > 0, "no light of {index} that was reflected inside");
    }
    // PHOTON_DIFFERENTIALS 12, item 1: rays cross the axis where it says.
    for (h, axis) in [(0.1, 1.49582706), (0.5, 1.39157295), (0.9, 1.10444557)] {
        let lens = BallLens { index: 1.5, receiver: axis, beam: 1.0, fresnel: true, most_inner: 0 };
        let rho = lens.landing(f64::asin(h), Passage::Through { inner: 0 }).expect("lands");
        assert!(rho.abs() < 2e-8, "{h}: {rho}");
    }
}

/// Behind the focus one sheet covers the picture: every pixel holds its mean.
#[test]
fn the_exact_ball_lens_is_the_closed_form() {
    for (file, width, beam, tolerance) in [(BALL, 0.1, 0.5, 1e-4), (BALL_FLUX, 1.6, 0.8, 1e-3)] {
        let picture = picture(ClosedForm::BallLens, file, &[]);
        let (n, side) = (picture.width as usize, width / f64::from(picture.width));
        let at = |x: f64, y: f64| ball::irradiance(x.hypot(y).max(1e-6), 2.0, 1.5, beam);
        let mut compared = 0;
        for (i, j) in (0..n * n).map(|k| (k % n, k / n)).filter(|&(i, j)| (i + j) % 5 == 0) {
            let centre = [i, j].map(|k| (k as f64 + 0.5) * side - 0.5 * width);
            let (mean, spread) = mean_and_spread(at, centre, side);
            if spread < 0.1 {
                compared += 1;
                let found = irradiance(&picture, i, j);
                assert!((found - mean).abs() <= tolerance * mean, "{file}, pixel {i}, {j}: {found} is not {mean}");
            }
        }
        assert!(compared * 20 > n * n, "only {compared} pixels");
    }
    // On the axis, item 2 of PHOTON_DIFFERENTIALS 12.
    let narrow = picture(ClosedForm::BallLens, BALL, &["camera.width=0.001"]);
    let centre = irradiance(&narrow, 8, 8);
    assert!((centre - 8.2944).abs() < 1e-3, "{centre}");
}

/// Item 4: what passes both interfaces is in the picture, to the last ray.
#[test]
fn the_ball_lens_keeps_its_light() {
    let expected = ball::flux_fraction(0.8, 1.5) * PI * 0.64;
    let found = flux(&picture(ClosedForm::BallLens, BALL_FLUX, &[]), 1.6, 1);
    assert!((found - expected).abs() < 1e-7, "{found} is not {expected}");
    let mean = flux(&picture(ClosedForm::BallLens, BALL, &[]), 0.1, 1) / 0.01;
    assert!((mean - 7.702797).abs() < 1e-5, "{mean}");
    // All of the light that is turned by less than 90 degrees and lands within 2 of the axis, by vectors.
    let wide = ["render.max_depth=6", "camera.width=4", "radius = 0.8 => a = [1.2, 0, 0], b = [0, 0, 1.2]"];
    let found = flux(&picture(ClosedForm::BallLens, BALL_FLUX, &wide), 4.0, 1);
    let mut expected = 0.0;
    for inner in [None, Some(0), Some(1), Some(2), Some(3)] {
        const RAYS: u32 = 200_000;
        let step = 0.5 * PI / f64::from(RAYS);
        for i in (0..RAYS).map(|k| (f64::from(k) + 0.5) * step) {
            if let Some((rho, passed)) = ball::traced(i.sin(), 2.0, 1.5, inner) {
                expected += passed * 2.0 * PI * i.sin() * i.cos() * step * within_square(rho.abs(), 2.0);
            }
        }
    }
    assert!((found - expected).abs() < 1e-4, "{found} is not {expected}");
}

/// The part of the circle of radius `r` within a square of half side `a` about its centre.
fn within_square(r: f64, a: f64) -> f64 {
    if r <= a {
        1.0
    } else if r >= a * 2f64.sqrt() {
        0.0
    } else {
        1.0 - 4.0 / PI * (a / r).acos()
    }
}

/// Item 3: before the focus the picture is brightest at the fold.
#[test]
fn the_ball_lens_folds_where_it_should() {
    for (d, radius, width) in [(1.1, 0.120885, 0.4), (1.25, 0.054917, 0.2), (1.4, 0.013032, 0.05)] {
        let changes = [
            format!("objects.1.centre=[0, -{d}, 0]"),
            format!("camera.target=[0, -{d}, 0]"),
            "camera.position=[0, -1.05, 0]".to_owned(),
            "camera.resolution=[101, 101]".to_owned(),
            format!("camera.width={width}"),
        ];
        let changes = changes.each_ref().map(String::as_str);
        let picture = picture(ClosedForm::BallLens, BALL_FLUX, &changes);
        let pixel = |x: usize| (x as f64 - 50.0) * width / 101.0;
        // The axis itself is bright, too.
        let brightest = (56..101).max_by(|&a, &b| irradiance(&picture, a, 50).total_cmp(&irradiance(&picture, b, 50)));
        let found = pixel(brightest.expect("a pixel"));
        assert!((found - radius).abs() <= 1.01 * width / 101.0, "{d}: {found} is not {radius}");
    }
}

#[test]
fn a_scene_that_is_not_the_ball_lens_is_refused_with_the_point() {
    refused(
        ClosedForm::BallLens,
        BALL,
        &[
            (&["render.max_depth=2"], "max_depth is 2"),
            (&["render.max_bounces=1"], "max_bounces"),
            (&["camera.filter=gaussian"], "filter"),
            (&["camera.width=4.1"], "more than the receiver"),
            (&["camera.position=[0, -0.5, 0]"], "between the ball and the receiver"),
            (&["camera.position=[0, -3, 0]"], "straight on the receiver's lit side"),
            (&["camera.position=[0, -2.5, 0]", "camera.target=[0, -3, 0]"], "looks away"),
            (
                &["type = \"orthographic\" => type = \"perspective\"", "width = 0.1 => fov_degrees = 20"],
                "not orthographic",
            ),
            (&["materials.glass.ior=0.9"], "not denser"),
            (&["objects.0.material=white"], "not of smooth glass"),
            (&["objects.1.material=glass"], "one matt colour"),
            (&["objects.0.transform=[{ scale = 0.9 }]"], "no sphere without a transform"),
            (&["lights.0.direction=[0.1, -1, 0]"], "straight on the receiver's lit side"),
            (&["lights.0.extent.centre=[0.1, 2, 0]"], "neither round"),
            (&["radius = 0.5 => a = [1.1, 0, 0], b = [0, 0, 0.9]"], "neither round"),
            (&["lights.0.extent.centre=[0, 0.5, 0]"], "does not start before"),
            (
                &["[expect] => [[lights]]\ntype = \"point\"\nposition = [0, 3, 0]\nintensity = 1\n[expect]"],
                "not one beam",
            ),
        ],
    );
    // A beam beside the axis that is wider than the ball is one that is round about it.
    let round = picture(ClosedForm::BallLens, BALL, &["lights.0.extent.radius=1"]);
    let wide =
        picture(ClosedForm::BallLens, BALL, &["lights.0.extent.centre=[0.3, 2, 0]", "lights.0.extent.radius=1.4"]);
    assert_eq!(round, wide);
}
