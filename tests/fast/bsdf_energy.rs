//! Values of the non-delta lobes: reciprocity, weights, white furnaces by quadrature.

use pdembree::math::{Dir3, Normal3, Vec3};
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::{Material, Textured};
use pdembree::surface::facet_loss::Loss;
use pdembree::surface::{Bsdf, Event, TransportMode};

use crate::support::bsdf::{
    bent, direction, flat, glass, lambert, layered_mixtures, plastic, principled, principled_mixtures, rough_glass,
    rough_gold,
};
use crate::support::chi2::{Grid, sideways_direction};

const MODES: [TransportMode; 2] = [TransportMode::Radiance, TransportMode::Importance];

fn scattering() -> Vec<Material> {
    let mut all = principled_mixtures(0.0);
    all.retain(Material::has_diffuse_base);
    all.extend([lambert([0.2, 0.5, 1.0]), plastic([0.3, 0.6, 0.9], 1.5), plastic([1.0; 3], 2.0)]);
    all.extend(layered_mixtures());
    for alpha in [0.05, 0.3, 0.8] {
        all.push(rough_gold(alpha));
        all.extend([0.8, 1.5, 2.0].map(|ior| rough_glass(ior, alpha)));
        all.extend(principled_mixtures(alpha));
    }
    all
}

/// f(wo, wi)/n²(wi) is symmetric for radiance, f/n²(wo) for importance, and the two modes are each other's adjoints
/// [Veach97 5.2].
#[test]
fn values_are_reciprocal() {
    let seed = 21;
    let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
    for material in scattering() {
        let bsdf = flat(&material);
        let ior = match material {
            Material::RoughDielectric { ior, .. } | Material::Principled { ior, thin: false, .. } => ior,
            _ => 1.0,
        };
        let index = |w: Dir3| if w.z > 0.0 { 1.0 } else { ior };
        let mut lit = 0;
        for _ in 0..2000 {
            let wo = direction(2.0 * stream.uniform() - 1.0, 7.0 * stream.uniform());
            let wi = direction(2.0 * stream.uniform() - 1.0, 7.0 * stream.uniform());
            let radiance = bsdf.f(wo, wi, TransportMode::Radiance);
            let swapped = bsdf.f(wi, wo, TransportMode::Radiance);
            let importance = bsdf.f(wo, wi, TransportMode::Importance);
            let context = format!("seed {seed} {material:?} wo {wo:?} wi {wi:?}");
            lit += u32::from(!radiance.is_black());
            let scale = radiance.max_component();
            let adjoint = (importance - swapped).map(f64::abs).max_component();
            assert!(adjoint <= 1e-9 * importance.max_component(), "{context}: {importance:?} {swapped:?}");
            // f(wo, wi)/n²(wo) = f(wi, wo)/n²(wi)
            let ratio = (index(wo) / index(wi)).powi(2);
            let reciprocal = (radiance - swapped * ratio).map(f64::abs).max_component();
            assert!(reciprocal <= 1e-9 * scale, "{context}: {radiance:?} {swapped:?}");
        }
        assert!(lit > 400, "{material:?}: only {lit} pairs were not black");
    }
}

/// f·cos/pdf = weight, with `f` and `pdf` asked in the world, and the density that of the function that drew.
#[test]
fn weights_are_values_over_densities() {
    let seed = 22;
    let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
    let ns = Normal3::new(Vec3::new(0.2, 0.1, 1.0)).expect("not zero");
    for material in scattering() {
        let bsdf = bent(&material, Normal3::Z, ns);
        let mut drawn = 0;
        for i in 0..4000 {
            let wo = direction(2.0 * stream.uniform() - 1.0, 7.0 * stream.uniform());
            let mode = MODES[i % 2];
            let (uc, u) = (stream.uniform(), stream.uniform2());
            let both = [
                (bsdf.sample(wo, uc, u, mode), Bsdf::pdf as fn(&Bsdf, Dir3, Dir3, TransportMode) -> _),
                (bsdf.sample_scatter(wo, uc, u, mode), Bsdf::pdf_scatter),
            ];
            for (sample, density) in both {
                let Some(sample) = sample else { continue };
                let Event::Scatter { pdf } = sample.event else { continue };
                drawn += 1;
                let asked = density(&bsdf, wo, sample.wi, mode);
                let context = format!("seed {seed} {material:?} wo {wo:?} {sample:?}");
                // Narrow lobes magnify the rounding of wi by 1/α².
                assert!((asked.get() / pdf.get() - 1.0).abs() < 1e-8, "{context}: pdf {asked:?}");
                let expected = bsdf.f(wo, sample.wi, mode) * (sample.wi.dot(ns).abs() / asked.get());
                let error = (expected - sample.weight).map(f64::abs).max_component();
                assert!(error <= 1e-8 * sample.weight.max_component(), "{context}: {expected:?}");
            }
        }
        assert!(drawn > 2000, "{material:?}: {drawn}");
    }
}

/// What the cubature aims at in a cell.
const CELL_ERROR: f64 = 1e-7;
/// What all cells of a furnace may be off by together.
const FURNACE_ERROR: f64 = 256.0 * CELL_ERROR;

/// ∫ f |cos| dwi of the first component over all directions.
fn furnace(bsdf: &Bsdf, wo: Dir3, mode: TransportMode) -> f64 {
    let value = |at: [f64; 2]| {
        let wi = sideways_direction(at);
        bsdf.f(wo, wi, mode).r() * wi.z.abs()
    };
    Grid::sphere(16, 16).integrals(value, CELL_ERROR).iter().sum()
}

#[test]
fn smooth_and_diffuse_furnaces_close_exactly() {
    for cos in [-0.9, 0.05, 0.3, 0.7, 1.0] {
        let wo = direction(cos, 0.4);
        for mode in MODES {
            let white = furnace(&flat(&lambert([1.0; 3])), wo, mode);
            assert!((white - 1.0).abs() < FURNACE_ERROR, "lambert at {cos}: {white}");
            for ior in [1.1, 1.5, 2.0] {
                for albedo in [0.4, 1.0] {
                    let bsdf = flat(&plastic([albedo; 3], ior));
                    let coat = bsdf.delta_branches(wo)[0].weight.r();
                    let total = coat + furnace(&bsdf, wo, mode);
                    assert!((total - bsdf.albedo(wo).r()).abs() < FURNACE_ERROR, "ior {ior} at {cos}: {total}");
                    if albedo == 1.0 {
                        assert!((total - 1.0).abs() < FURNACE_ERROR, "white plastic, ior {ior} at {cos}: {total}");
                    }
                }
            }
        }
    }
}

/// With light that meets more than one facet a white furnace closes at every roughness, but for what the tables keep back.
#[test]
fn rough_furnaces_close() {
    let white =
        |metalness, transmission, alpha, thin| principled([1.0; 3], [metalness, transmission, alpha, 1.5], thin);
    for roughness in [0.1f64, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0] {
        let alpha = roughness * roughness;
        let all = [
            rough_glass(1.5, alpha),
            rough_glass(0.7, alpha),
            perfect_metal(alpha),
            white(1.0, 0.0, alpha, false),
            white(0.0, 1.0, alpha, true),
        ];
        for cos in [-1.0, -0.6, -0.1, 0.3, 0.8] {
            let wo = direction(cos, 0.4);
            for material in &all {
                let total = furnace(&flat(material), wo, TransportMode::Importance);
                assert!(total > 0.98 && total < 1.0 + FURNACE_ERROR, "{material:?} at {cos}: {total}");
            }
        }
    }
}

/// Everything white: smooth facets over a base lose nothing, and rough ones only what the tables keep back.
#[test]
fn principled_furnaces_close() {
    let white = [1.0; 3];
    for (metalness, transmission, thin) in
        [(0.0, 0.0, false), (1.0, 0.0, false), (0.0, 1.0, true), (0.0, 1.0, false), (0.4, 0.5, true), (0.3, 0.0, false)]
    {
        for ior in [1.0, 2.0] {
            for cos in [-0.7, 0.05, 0.4, 1.0] {
                let wo = direction(cos, 0.4);
                let total = |alpha: f64| {
                    let bsdf = flat(&principled(white, [metalness, transmission, alpha, ior], thin));
                    let deltas: f64 = bsdf.delta_branches(wo).iter().map(|b| b.weight.r()).sum();
                    assert!(bsdf.albedo(wo).r() < 1.0 + 1e-12, "{:?}", bsdf.albedo(wo));
                    deltas + furnace(&bsdf, wo, TransportMode::Importance)
                };
                let context = format!("metal {metalness} glass {transmission} thin {thin} ior {ior} cos {cos}");
                let smooth = total(0.0);
                assert!((smooth - 1.0).abs() < FURNACE_ERROR, "{context}: {smooth}");
                for alpha in [0.1, 1.0] {
                    let rough = total(alpha);
                    assert!(rough > 0.98 && rough < 1.0 + FURNACE_ERROR, "{context} alpha {alpha}: {rough}");
                }
            }
        }
    }
}

/// What the base is left with is what the facets do not return: together all, but for the table's error.
#[test]
fn a_white_coated_base_loses_no_more_than_its_table_errs() {
    for roughness in [0.1f64, 0.3, 0.5, 0.7, 0.85, 1.0] {
        for cos in [0.1, 0.4, 1.0] {
            let wo = direction(cos, 0.4);
            let material = principled([1.0; 3], [0.0, 0.0, roughness * roughness, 1.5], false);
            let total = furnace(&flat(&material), wo, TransportMode::Radiance);
            assert!(total > 0.98, "roughness {roughness} cos {cos}: {total}");
        }
    }
}

/// A metal that reflects everything: k → ∞.
fn perfect_metal(alpha: f64) -> Material {
    Material::RoughConductor { eta: [0.0; 3].into(), k: [1e6; 3].into(), alpha: Textured::Constant(alpha) }
}

/// From straight above all facets are visible, the part P = T²/(α² + T²) of them with a slope below T, and light that
/// meets a slope tan θ leaves at 2θ, where G₁ of it gets out. For α = 1 the integral of G₁ over P is 1 − ln 2. What comes
/// out after more bounces is the table's loss, all of it.
#[test]
fn a_rough_metal_from_above_returns_what_its_masking_lets_out() {
    for alpha in [0.05f64, 0.1, 0.4, 1.0] {
        let cells = 100_000;
        let expected: f64 = (0..cells)
            .map(|i| {
                let p = (f64::from(i) + 0.5) / f64::from(cells);
                let leaving = 2.0 * (alpha * (p / (1.0 - p)).sqrt()).atan();
                let seen = 2.0 / (1.0 + (alpha * leaving.tan()).hypot(1.0));
                if leaving.cos() > 0.0 { seen / f64::from(cells) } else { 0.0 }
            })
            .sum();
        let total = furnace(&flat(&perfect_metal(alpha)), direction(1.0, 0.0), TransportMode::Radiance)
            - Loss::of_mirrors(alpha).at(1.0);
        // k = 1e6 absorbs 4/k, and once more with each bounce.
        assert!((total - expected).abs() < FURNACE_ERROR + 2e-5, "alpha {alpha}: {total}, not {expected}");
        if alpha == 1.0 {
            assert!((total - (1.0 - 2f64.ln())).abs() < FURNACE_ERROR + 2e-5);
        }
    }
}

/// Narrow facets approach the smooth interface, on both sides and in both modes: the distance falls like α² ln(1/α) in
/// the end, and at least like α where terms of both signs meet.
#[test]
fn narrow_glass_tends_to_smooth_glass() {
    for cos in [-0.95, 0.5, 0.9] {
        let wo = direction(cos, 0.4);
        let branches = flat(&glass(1.5)).delta_branches(wo);
        for mode in MODES {
            // Over both sides together: one alone may pass through zero.
            let distance = |alpha: f64| {
                let rough = flat(&rough_glass(1.5, alpha));
                let off = branches.iter().map(|branch| {
                    let value = |at: [f64; 2]| {
                        let wi = sideways_direction(at);
                        let same_side = wi.z * branch.wi.z > 0.0;
                        if same_side { rough.f(wo, wi, mode).r() * wi.z.abs() } else { 0.0 }
                    };
                    let share: f64 = Grid::sphere(32, 32).integrals(value, 1e-7).iter().sum();
                    (share - branch.transport_weight(mode).r()).abs()
                });
                off.sum::<f64>()
            };
            let (wide, narrow) = (distance(0.08), distance(0.02));
            assert!(narrow < wide / 4.0, "at {cos} {mode:?}: {wide} {narrow}");
        }
    }
}
