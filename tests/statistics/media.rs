//! Participating media: photons with beams, eye paths and light paths are three estimates of one picture, and light in a
//! medium without end is neither lost nor made.

use std::sync::Arc;

use pdembree::math::{Dir3, Point3, Transform, Vec3};
use pdembree::medium::{HenyeyGreenstein, Way};
use pdembree::radiometry::Spectrum;
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::Medium;
use pdembree::scene::density::{DensityGrid, Interpolation};

use crate::agreement::{BALL, LIGHT, PATH, PHOTON_MAP, Settings, assert_blocks_agree, means, pictures};
use crate::support::statistics::{Moments, assert_plausible, t_test, welch};

/// Blocks of 8 × 8 pixels: light that eye paths find seldom has no normal distribution in fewer.
const BLOCK: usize = 8;

/// The glass ball, its floor and its lamp in fog: the ball focuses into the fog as well as onto the floor.
/// With so many beams in a pass.
fn ball_in_fog(beams: u32) -> String {
    let fog = "[media.fog]\nsigma_a = [0.02, 0.04, 0.08]\nsigma_s = [0.1, 0.12, 0.15]\ng = 0.4\n";
    BALL.replace("format = 1\n", "format = 1\natmosphere = \"fog\"\n")
        .replace("[camera]", &format!("{fog}[camera]"))
        .replace("[render]", &format!("[render]\nbeams = {beams}"))
}

/// Every class of light is counted once, on surfaces and in the fog: straight light by eye paths with either method, what is
/// focused or sent back by photons, and by beams in the fog.
#[test]
fn photons_and_eye_paths_share_the_light_of_a_ball_in_fog_out() {
    let fog = ball_in_fog(2000);
    let both = [pictures(&fog, &PHOTON_MAP), pictures(&fog, &Settings { spp: 512, ..PATH })];
    for layer in ["focused", "sent_back", "straight", "scattered", "direct", "caustic", "indirect"] {
        println!("{layer} {}", means(&both, layer));
        assert!(assert_blocks_agree(&both, layer, BLOCK) > 0.0, "{layer}");
    }
}

/// What the ball focuses into the fog, by points on beams and from places on the eye's paths: as light paths find it.
#[test]
fn every_estimate_of_photons_in_media_agrees_with_light_paths() {
    let light = pictures(&ball_in_fog(1), &LIGHT);
    for estimator in ["ray_points", "place_beams", "place_points"] {
        let chosen = format!("media_estimator = \"{estimator}\"\nbeam_points = 8\nbeams =");
        let fog = ball_in_fog(500).replace("beams =", &chosen);
        let both = [pictures(&fog, &PHOTON_MAP), light.clone()];
        for layer in ["focused", "sent_back"] {
            println!("{estimator}, {layer} {}", means(&both, layer));
            assert!(assert_blocks_agree(&both, layer, BLOCK) > 0.0, "{estimator}, {layer}");
        }
    }
}

/// With photons for all light between vertices that scatter, and beams for it in the fog.
#[test]
fn global_photons_and_eye_paths_agree_in_fog() {
    let fog = ball_in_fog(500);
    let global = Settings { indirect: "global", spp: 4, photons: 160_000, ..PHOTON_MAP };
    // Eye paths know nothing of beams.
    let both = [pictures(&fog, &global), pictures(&ball_in_fog(1), &PATH)];
    for layer in ["scattered", "sent_back"] {
        println!("{layer} {}", means(&both, layer));
        assert!(assert_blocks_agree(&both, layer, 16) > 0.0, "{layer}");
    }
}

/// `scenes/shaft`: light that waves focus into the water under them, of a sun that no eye path finds. The camera looks down, not
/// at the surface from below: light paths are not connected over what it mirrors.
#[test]
fn shafts_of_light_under_water_are_as_light_paths_find_them() {
    let shaft = include_str!("../../scenes/shaft/shaft.toml");
    let looking_down = [
        ("[320, 240]", "[16, 16]"),
        ("target = [0, -1.5, 0]", "target = [0, -2.4, 0]"),
        ("fov_degrees = 48", "fov_degrees = 30"),
        ("passes = 16\n", ""),
    ];
    let shaft = looking_down.into_iter().fold(shaft.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    let both = [pictures(&shaft, &Settings { photons: 160_000, ..PHOTON_MAP }), pictures(&shaft, &LIGHT)];
    for layer in ["focused", "scattered"] {
        println!("{layer} {}", means(&both, layer));
        assert!(assert_blocks_agree(&both, layer, BLOCK) > 0.0, "{layer}");
    }
}

#[test]
fn eye_paths_and_light_paths_agree_in_fog() {
    let fog = ball_in_fog(1);
    let both = [pictures(&fog, &PATH), pictures(&fog, &LIGHT)];
    for layer in ["straight", "scattered", "focused", "sent_back"] {
        println!("{layer} {}", means(&both, layer));
        assert!(assert_blocks_agree(&both, layer, BLOCK) > 0.0, "{layer}");
    }
}

/// In a medium without end all light is absorbed at last. A photon of unit flux in each channel goes on from event to event;
/// what it leaves at each, 1 − σ_s/σ_t of its flux, adds up to 1, in channels with events as different as they come.
#[test]
fn light_in_a_medium_without_end_is_absorbed_once() {
    let medium = Medium {
        absorption: Spectrum::rgb(0.1, 0.5, 2.0),
        scattering: Spectrum::rgb(1.0, 1.5, 2.0),
        asymmetry: 0.6,
        density: None,
    };
    let way = Way { medium: &medium, origin: Point3::ORIGIN, w: Dir3::X, from: 0.0, to: f64::INFINITY };
    let (phase, albedo) = (HenyeyGreenstein::new(medium.asymmetry), medium.albedo().to_array());
    let (seed, photons) = (41, 20_000);
    let mut absorbed = [Moments::default(); 3];
    // Mean progress along the first direction between events: ∫ σ_t e^(−σ_t t) t dt = 1/σ_t in each channel.
    let mut progress = [Moments::default(); 3];
    for i in 0..photons {
        let mut stream = Stream::new(seed, Purpose::Test, 0, i);
        let (mut flux, mut w, mut sums) = (Spectrum::ONE, Dir3::Z, [0.0; 3]);
        let mut turned = None;
        while flux.max_component() > 1e-12 {
            let (Some(distance), weight) = way.draw(flux, stream.uniform2()) else {
                panic!("nothing leaves a medium without end");
            };
            let after = flux * weight;
            for (c, sum) in sums.iter_mut().enumerate() {
                *sum += after.to_array()[c] / albedo[c] * (1.0 - albedo[c]);
            }
            if turned.is_none() {
                for (c, progress) in progress.iter_mut().enumerate() {
                    progress.push(after.to_array()[c] / albedo[c] * distance);
                }
                turned = Some(());
            }
            flux = after;
            w = phase.turn(w, stream.uniform2()).0;
            // Roulette, so that paths end.
            let q = flux.max_component().min(1.0);
            if stream.uniform() >= q {
                break;
            }
            flux = flux / q;
        }
        assert!((w.length_squared() - 1.0).abs() < 1e-12, "directions stay unit vectors");
        absorbed.iter_mut().zip(sums).for_each(|(moments, sum)| moments.push(sum));
    }
    for c in 0..3 {
        let p = t_test(&absorbed[c], 1.0);
        assert_plausible(p, 6, format!("absorbed in channel {c}: {}, seed {seed}", absorbed[c]));
        let free_path = 1.0 / medium.extinction().to_array()[c];
        let p = t_test(&progress[c], free_path);
        assert_plausible(p, 6, format!("free path of channel {c}: {}, not {free_path}, seed {seed}", progress[c]));
    }
}

/// A grid of random densities, and the same light by two other ways: ratio tracking of what gets through and null-collision
/// tracking of where it is met [Novak18], with nothing in common but the density at a point.
#[test]
fn exact_tracking_and_null_collisions_agree() {
    let mut stream = Stream::new(43, Purpose::Test, 0, 0);
    let samples: Vec<f32> = (0..4 * 4 * 4).map(|_| stream.uniform() as f32).collect();
    let place = Transform::scale(Vec3::splat(4.0)).expect("no factor is zero");
    let grid = DensityGrid { place, counts: [4, 4, 4], samples, between: Interpolation::Linear };
    let (origin, w) = (Point3::new(-0.5, 0.7, 1.1), Dir3::new(Vec3::new(3.0, 1.0, 0.7)).expect("a direction"));
    let (length, majorant, n) = (5.0, 1.0, 40_000);
    let sigma = [0.5, 1.2, 2.0];
    let medium = Medium {
        absorption: Spectrum::BLACK,
        scattering: Spectrum::from(sigma),
        asymmetry: 0.0,
        density: Some(Arc::new(grid.clone())),
    };
    let way = Way { medium: &medium, origin, w, from: 0.0, to: length };
    for (c, sigma) in sigma.into_iter().enumerate() {
        let (mut left, mut met, mut drawn) = (Moments::default(), Moments::default(), Moments::default());
        for _ in 0..n {
            let mut step = || -(-stream.uniform()).ln_1p() / (sigma * majorant);
            let (mut t, mut weight) = (0.0, 1.0);
            loop {
                t += step();
                if t >= length {
                    break;
                }
                weight *= 1.0 - grid.at(origin + w * t) / majorant;
            }
            left.push(weight);
            // A function of the place where light is met, by null collisions and as it is drawn here.
            let place = |t: f64| t.sin();
            let mut t = 0.0;
            met.push(loop {
                t += -(-stream.uniform()).ln_1p() / (sigma * majorant);
                if t >= length {
                    break 0.0;
                }
                if stream.uniform() < grid.at(origin + w * t) / majorant {
                    break place(t);
                }
            });
            let (t, weight) = way.draw(Spectrum::ONE, stream.uniform2());
            drawn.push(t.map_or(0.0, |t| place(t) * weight.to_array()[c]));
        }
        let expected = way.transmittance().to_array()[c];
        assert_plausible(t_test(&left, expected), 6, format!("channel {c}: {left} of {expected}, seed 43"));
        assert_plausible(welch(&met, &drawn), 6, format!("channel {c}: {met} and {drawn}, seed 43"));
    }
}

/// Smoke of a grid around the ball in place of fog: photons with beams, eye paths and light paths see the same.
#[test]
fn photons_and_paths_agree_in_smoke_that_varies() {
    let density = "density = { values = [0.2, 2, 1, 0, 3, 0.5, 1.5, 0.1], counts = [2, 2, 2], min = [-1.5, 0, -1.5], max = [1.5, 3, 1.5] }\n";
    let smoke = ball_in_fog(2000).replace("g = 0.4\n", &format!("g = 0.4\n{density}"));
    let light = pictures(&smoke, &LIGHT);
    for settings in [PHOTON_MAP, Settings { spp: 256, ..PATH }] {
        let both = [pictures(&smoke, &settings), light.clone()];
        for layer in ["focused", "sent_back", "straight", "scattered"] {
            println!("{layer} {}", means(&both, layer));
            assert!(assert_blocks_agree(&both, layer, BLOCK) > 0.0, "{layer}");
        }
    }
}
