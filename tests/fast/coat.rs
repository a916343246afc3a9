//! The coat of principled surfaces and the strength of their reflectance, against closed forms and in white furnaces.

use std::f64::consts::FRAC_1_PI;

use pdembree::math::Dir3;
use pdembree::scene::Material;
use pdembree::surface::{Bsdf, TransportMode};

use crate::support::bsdf::{coated, direction, flat, principled, with_specular};
use crate::support::chi2::{Grid, sideways_direction};

const WHITE: [f64; 3] = [1.0; 3];
const COSINES: [f64; 3] = [0.1, 0.5, 1.0];

/// What the cubature aims at in a cell, and what all cells may be off by together.
const CELL_ERROR: f64 = 1e-7;
const FURNACE_ERROR: f64 = 256.0 * CELL_ERROR;

/// F₀ + (1 − F₀)(1 − c)⁵.
fn schlick(f0: f64, cos: f64) -> f64 {
    f0 + (1.0 - f0) * (1.0 - cos).powi(5)
}

fn deltas(bsdf: &Bsdf, wo: Dir3) -> f64 {
    bsdf.delta_branches(wo).iter().map(|b| b.weight.r()).sum()
}

/// Everything that a white surface sends on, of the flux.
fn furnace(material: &Material, wo: Dir3) -> f64 {
    let bsdf = flat(material);
    let value = |at: [f64; 2]| {
        let wi = sideways_direction(at);
        bsdf.f(wo, wi, TransportMode::Importance).r() * wi.z.abs()
    };
    deltas(&bsdf, wo) + Grid::sphere(16, 16).integrals(value, CELL_ERROR).iter().sum::<f64>()
}

/// Over metal, a diffuse base, thin and solid glass, smooth and rough, under coats of every roughness: a white surface
/// never gives more than it gets.
#[test]
fn coated_furnaces_never_gain() {
    let mut least = 1.0f64;
    for (metalness, transmission, thin) in
        [(0.0, 0.0, false), (1.0, 0.0, false), (0.0, 1.0, true), (0.0, 1.0, false), (0.4, 0.5, true)]
    {
        for alpha in [0.0, 0.3] {
            let base = principled(WHITE, [metalness, transmission, alpha, 1.5], thin);
            for coat in [0.0, 0.09, 0.36, 1.0] {
                for cos in [-0.6, 0.1, 1.0] {
                    let material = coated(base.clone(), [1.0, coat, 1.5]);
                    let total = furnace(&material, direction(cos, 0.4));
                    let context = format!("{material:?} at {cos}: {total}");
                    assert!(total < 1.0 + FURNACE_ERROR, "{context}");
                    least = least.min(total);
                }
            }
        }
    }
    println!("a coated white surface returns {least} at least");
    assert!(least > 0.94, "a coat takes no more of it than the guide says: {least}");
}

/// Both directions of a mirror, and of a sheet of glass, let the same through the coat: k F + (1 − k F) = 1.
#[test]
fn a_smooth_coat_takes_nothing_from_white_mirrors() {
    for (metalness, transmission) in [(1.0, 0.0), (0.0, 1.0), (0.5, 1.0)] {
        let base = principled(WHITE, [metalness, transmission, 0.0, 1.5], true);
        for (part, cos) in [0.25, 1.0].into_iter().flat_map(|part| COSINES.map(|cos| (part, cos))) {
            let total = deltas(&flat(&coated(base.clone(), [part, 0.0, 1.5])), direction(cos, 0.4));
            assert!((total - 1.0).abs() < 1e-15, "metal {metalness} coat {part} at {cos}: {total}");
        }
    }
}

/// Over black there is only the layer, over a diffuse base that reflects nothing itself min(T, T) of it.
#[test]
fn a_smooth_coat_is_schlicks_over_what_it_lets_through() {
    for (part, ior) in [(0.25, 1.5), (1.0, 2.0)] {
        let f0: f64 = ((ior - 1.0) / (ior + 1.0f64)).powi(2);
        let base = |colour| with_specular(principled(colour, [0.0, 0.0, 0.0, 1.5], false), 0.0, WHITE);
        for cos in COSINES {
            let wo = direction(cos, 0.4);
            let black = flat(&coated(base([0.0; 3]), [part, 0.0, ior]));
            assert!((deltas(&black, wo) - part * schlick(f0, cos)).abs() < 1e-15);
            let diffuse = flat(&coated(base([0.6; 3]), [part, 0.0, ior]));
            for cos_i in COSINES {
                let through = 1.0 - part * schlick(f0, cos).max(schlick(f0, cos_i));
                let found = diffuse.f(wo, direction(cos_i, 2.0), TransportMode::Radiance).r();
                assert!((found - 0.6 * FRAC_1_PI * through).abs() < 1e-15, "{cos} {cos_i}: {found}");
            }
        }
    }
}

/// The coat is on the outside of solid glass: within, the mirrored part is that of the glass alone.
#[test]
fn light_within_solid_glass_meets_no_coat() {
    let glass = principled(WHITE, [0.0, 1.0, 0.0, 1.5], false);
    let wo = direction(-0.9, 0.4);
    let (bare, under) =
        (flat(&glass).delta_branches(wo), flat(&coated(glass.clone(), [1.0, 0.0, 1.5])).delta_branches(wo));
    assert_eq!((under[0].weight, under[0].wi), (bare[0].weight, bare[0].wi));
    let through = 1.0 - schlick(0.04, bare[1].wi.z);
    assert!((under[1].weight.r() - bare[1].weight.r() * through).abs() < 1e-15, "{under:?}");
}

/// s Schlick(min(F₀ c, 1)) of each channel is mirrored, and the base takes what the brightest of them leaves.
#[test]
fn reflectance_over_the_base_is_multiplied() {
    let (part, tint) = (0.5, [30.0, 2.0, 0.0]);
    let material = with_specular(principled(WHITE, [0.0, 0.0, 0.0, 1.5], false), part, tint);
    let bsdf = flat(&material);
    for cos in COSINES {
        let wo = direction(cos, 0.4);
        let mirrored = bsdf.delta_branches(wo)[0].weight.to_array();
        for (found, f0) in mirrored.into_iter().zip([1.0, 0.08, 0.0]) {
            assert!((found - part * schlick(f0, cos)).abs() < 1e-15, "{mirrored:?}");
        }
        let total = furnace(&material, wo);
        assert!((total - 1.0).abs() < FURNACE_ERROR, "the brightest channel loses nothing: {total}");
        assert!((bsdf.albedo(wo).g() - (mirrored[1] + 1.0 - part)).abs() < 1e-12, "{:?}", bsdf.albedo(wo));
    }
}
