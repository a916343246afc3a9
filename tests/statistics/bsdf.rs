//! Every non-delta model draws with the density it claims, and its mean weight is its albedo.

use pdembree::math::{Dir3, Normal3, Vec3};
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::Material;
use pdembree::surface::{Bsdf, Event, TransportMode};

use crate::support::bsdf::{
    bent, coated, direction, lambert, layered_mixtures, plastic, principled, principled_mixtures, rough_glass,
    rough_gold,
};
use crate::support::chi2::{Grid, sideways_direction, sideways_point};
use crate::support::statistics::{Moments, assert_plausible, z_test};

const SEED: u64 = 2024;
const DRAWS: u64 = 100_000;
const COSINES: [f64; 5] = [-0.95, -0.4, 0.08, 0.6, 1.0];

/// Of `wo`, on the side to which the normals are bent: they agree about all of the cosines.
const AZIMUTH: f64 = -0.9;

/// A material on a point.
struct Case {
    material: Material,
    bsdf: Bsdf,
}

/// The materials on a flat point, then on one whose shading normal is bent by 15°: a column of the grid, so that jumps
/// of the density lie on borders of cells.
fn cases(flat_too: &[Material], bent_too: &[Material]) -> Vec<Case> {
    let bend = 15f64.to_radians();
    let ns = Normal3::new(Vec3::new(0.0, -bend.sin(), bend.cos())).expect("not zero");
    let on = |material: &Material, ns| Case { material: material.clone(), bsdf: bent(material, Normal3::Z, ns) };
    let flat = flat_too.iter().map(|m| on(m, Normal3::Z));
    flat.chain(bent_too.iter().map(|m| on(m, ns))).collect()
}

fn all_cases() -> Vec<Case> {
    let flat = [
        lambert([0.5; 3]),
        plastic([0.2, 0.5, 0.8], 1.5),
        rough_gold(0.05),
        rough_gold(0.3),
        rough_gold(1.0),
        rough_glass(1.5, 0.05),
        rough_glass(1.5, 0.3),
        rough_glass(1.33, 1.0),
        rough_glass(0.7, 0.3),
    ];
    let flat: Vec<Material> = flat
        .into_iter()
        .chain([0.05, 0.4].into_iter().flat_map(principled_mixtures))
        .chain(layered_mixtures())
        .collect();
    let bent = [lambert([0.5; 3]), plastic([0.2, 0.5, 0.8], 1.5), rough_gold(0.3), rough_glass(1.5, 0.3)];
    let bent: Vec<Material> =
        bent.into_iter().chain(principled_mixtures(0.3)).chain(layered_mixtures().into_iter().take(1)).collect();
    cases(&flat, &bent)
}

fn chi2_of_all(
    cases: Vec<Case>,
    pass: u32,
    draw: impl Fn(&Bsdf, Dir3, &mut Stream) -> Option<Dir3>,
    density: impl Fn(&Bsdf, Dir3, Dir3) -> f64,
) {
    let hypotheses = cases.len() * COSINES.len();
    for (i, Case { material, bsdf }) in cases.iter().enumerate() {
        for (j, cos) in COSINES.into_iter().enumerate() {
            let wo = direction(cos, AZIMUTH);
            let mut stream = Stream::new(SEED, Purpose::Test, pass, (i * COSINES.len() + j) as u64);
            let outcome = Grid::sphere(24, 24).test(
                DRAWS,
                || draw(bsdf, wo, &mut stream).map(sideways_point),
                |at| density(bsdf, wo, sideways_direction(at)),
            );
            let what = format!("seed {SEED} {material:?} case {i} cos {cos}: {outcome:?}");
            assert_plausible(outcome.p, hypotheses, what);
        }
    }
}

/// What is drawn from the lobes without deltas has the density `pdf_scatter`; where the density misses 1 (below the
/// horizon of a facet, on the wrong side of a normal), nothing is drawn as often.
#[test]
fn scattered_directions_have_their_density() {
    let mode = TransportMode::Radiance;
    chi2_of_all(
        all_cases(),
        1,
        |bsdf, wo, stream| bsdf.sample_scatter(wo, stream.uniform(), stream.uniform2(), mode).map(|s| s.wi),
        |bsdf, wo, wi| bsdf.pdf_scatter(wo, wi, mode).get(),
    );
}

/// The scattered part of what is drawn from all lobes has the density `pdf`; a delta event counts as nothing drawn.
#[test]
fn directions_of_all_lobes_have_their_density() {
    let mode = TransportMode::Importance;
    let draw = |bsdf: &Bsdf, wo, stream: &mut Stream| {
        let sample = bsdf.sample(wo, stream.uniform(), stream.uniform2(), mode)?;
        matches!(sample.event, Event::Scatter { .. }).then_some(sample.wi)
    };
    let plastics = [
        plastic([0.2, 0.5, 0.8], 1.5),
        plastic([0.9; 3], 1.1),
        principled([0.9, 0.5, 0.2], [0.3, 0.0, 0.0, 1.5], false),
        principled([0.9, 0.5, 0.2], [0.2, 0.5, 0.0, 1.5], true),
        coated(principled([0.9, 0.5, 0.2], [0.3, 0.0, 0.3, 1.5], false), [0.8, 0.0, 1.5]),
        coated(principled([0.9, 0.5, 0.2], [1.0, 0.0, 0.0, 1.5], false), [0.8, 0.3, 1.5]),
    ];
    chi2_of_all(cases(&plastics, &plastics), 2, draw, |bsdf, wo, wi| bsdf.pdf(wo, wi, mode).get());
}

/// What the cubature aims at in a cell.
const CELL_ERROR: f64 = 1e-7;

/// E[weight] = ∫ f cos over the sphere, by quadrature, in both modes.
#[test]
fn mean_weights_are_the_quadrature_of_the_value() {
    let cases = all_cases();
    let hypotheses = cases.len() * COSINES.len() * 2;
    for (i, Case { material, bsdf }) in cases.iter().enumerate() {
        for (j, cos) in COSINES.into_iter().enumerate() {
            for (k, mode) in [TransportMode::Radiance, TransportMode::Importance].into_iter().enumerate() {
                let wo = direction(cos, AZIMUTH);
                let index = ((i * COSINES.len() + j) * 2 + k) as u64;
                let mut stream = Stream::new(SEED, Purpose::Test, 3, index);
                let weights: Moments = (0..20_000)
                    .map(|_| {
                        let sample = bsdf.sample_scatter(wo, stream.uniform(), stream.uniform2(), mode);
                        sample.map_or(0.0, |s| s.weight.g())
                    })
                    .collect();
                let value = |at: [f64; 2]| {
                    let wi = sideways_direction(at);
                    bsdf.f(wo, wi, mode).g() * bsdf.shading_cosine(wi)
                };
                let expected: f64 = Grid::sphere(24, 24).integrals(value, CELL_ERROR).iter().sum();
                // The cubature's own error is taken off first; a weight without spread leaves nothing else.
                let distance = ((weights.mean - expected).abs() - 576.0 * CELL_ERROR).max(0.0);
                let what = format!("seed {SEED} {material:?} case {i} cos {cos} {mode:?}: {weights}, not {expected}");
                let p = z_test(distance, 0.0, weights.standard_error());
                assert_plausible(p, hypotheses, what);
            }
        }
    }
}
