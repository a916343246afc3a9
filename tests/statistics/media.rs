//! Participating media: photons with beams, eye paths and light paths are three estimates of one picture, and light in a
//! medium without end is neither lost nor made.

use pdembree::math::Dir3;
use pdembree::medium::HenyeyGreenstein;
use pdembree::radiometry::Spectrum;
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::Medium;

use crate::agreement::{BALL, LIGHT, PATH, PHOTON_MAP, Settings, assert_blocks_agree, means, pictures};
use crate::support::statistics::{Moments, assert_plausible, t_test};

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

/// With photons for all light between vertices that scatter, and beams for it in the fog.
#[test]
fn global_photons_and_eye_paths_agree_in_fog() {
    let fog = ball_in_fog(500);
    let global = Settings { indirect: "global", spp: 4, photons: 160_000, ..PHOTON_MAP };
    let both = [pictures(&fog, &global), pictures(&fog, &PATH)];
    for layer in ["scattered", "sent_back"] {
        println!("{layer} {}", means(&both, layer));
        assert!(assert_blocks_agree(&both, layer, 16) > 0.0, "{layer}");
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
    let medium =
        Medium { absorption: Spectrum::rgb(0.1, 0.5, 2.0), scattering: Spectrum::rgb(1.0, 1.5, 2.0), asymmetry: 0.6 };
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
            let (Some(distance), weight) = medium.draw(flux, f64::INFINITY, stream.uniform2()) else {
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
