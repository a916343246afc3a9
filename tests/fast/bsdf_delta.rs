//! Delta lobes: Snell's and Fresnel's laws, conservation, sides, what `sample` makes of the branches.

use pdembree::math::{Normal3, Vec3};
use pdembree::radiometry::Spectrum;
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::Material;
use pdembree::surface::{Event, TransportMode};

use crate::support::bsdf::{
    bent, coated, direction, flat, glass, gold, holed, lambert, mirror, plastic, principled, rough_glass, rough_gold,
};

const WHITE: [f64; 3] = [1.0; 3];
const MODES: [TransportMode; 2] = [TransportMode::Radiance, TransportMode::Importance];

#[test]
fn a_bsdf_is_small() {
    assert!(std::mem::size_of::<pdembree::surface::Bsdf>() <= 200);
}

#[test]
fn lobes_are_what_the_models_say() {
    for (material, delta, scatter) in [
        (lambert([0.5; 3]), false, true),
        (mirror(0.9), true, false),
        (glass(1.5), true, false),
        (gold(), true, false),
        (rough_glass(1.5, 0.2), false, true),
        (rough_gold(0.2), false, true),
        (plastic([0.5; 3], 1.5), true, true),
        (principled(WHITE, [0.0, 0.0, 0.0, 1.5], false), true, true),
        (principled(WHITE, [0.0, 0.0, 0.3, 1.5], false), false, true),
        (principled(WHITE, [1.0, 0.0, 0.0, 1.5], false), true, false),
        (principled(WHITE, [0.0, 1.0, 0.0, 1.5], true), true, false),
        (principled(WHITE, [0.0, 1.0, 0.3, 1.5], true), false, true),
        (holed(principled(WHITE, [0.0, 0.0, 0.3, 1.5], false), 0.5), true, true),
        (coated(principled(WHITE, [0.0, 0.0, 0.3, 1.5], false), [0.5, 0.0, 1.5]), true, true),
        (coated(principled(WHITE, [1.0, 0.0, 0.0, 1.5], false), [0.5, 0.0, 1.5]), true, false),
        (coated(principled(WHITE, [1.0, 0.0, 0.3, 1.5], false), [0.5, 0.2, 1.5]), false, true),
        // The smooth limits.
        (rough_glass(1.5, 0.0), true, false),
        (rough_glass(1.0, 0.2), true, false),
        (rough_gold(0.0), true, false),
    ] {
        let bsdf = flat(&material);
        assert_eq!((bsdf.has_delta(), bsdf.has_scatter()), (delta, scatter), "{material:?}");
        let wo = direction(0.6, 1.0);
        assert_eq!(!bsdf.delta_branches(wo).is_empty(), delta, "{material:?}");
        if !scatter {
            assert!(bsdf.f(wo, direction(0.6, 1.0 + std::f64::consts::PI), TransportMode::Radiance).is_black());
            assert!(bsdf.sample_scatter(wo, 0.3, [0.4, 0.6], TransportMode::Radiance).is_none());
        }
    }
}

#[test]
fn materials_know_whether_they_can_focus() {
    for (material, expected) in [
        (lambert([0.5; 3]), false),
        (plastic([0.5; 3], 1.5), true),
        (glass(1.5), true),
        (rough_glass(1.5, 0.1), true),
        (rough_gold(0.9), true),
        (principled(WHITE, [0.0, 0.0, 0.3, 1.5], false), false),
        (principled(WHITE, [0.5, 0.0, 0.0, 1.5], false), true),
        (principled(WHITE, [1.0, 0.0, 0.3, 1.5], false), true),
        (holed(principled(WHITE, [0.0, 0.0, 0.3, 1.5], false), 0.5), true),
        (principled(WHITE, [0.0, 1.0, 0.3, 1.5], true), true),
        (coated(principled(WHITE, [0.0, 0.0, 0.3, 1.5], false), [0.5, 0.0, 1.5]), true),
        (coated(principled(WHITE, [0.0, 0.0, 0.3, 1.5], false), [0.5, 0.2, 1.5]), false),
    ] {
        assert_eq!(material.can_focus(), expected, "{material:?}");
    }
}

#[test]
fn glass_obeys_snell_and_loses_nothing() {
    for ior in [0.8, 1.33, 1.5, 2.4] {
        let bsdf = flat(&glass(ior));
        for i in -49..=49 {
            let cos = (f64::from(i) + 0.5) / 50.0;
            let wo = direction(cos, 0.7);
            let eta = if cos > 0.0 { 1.0 / ior } else { ior };
            let branches = bsdf.delta_branches(wo);
            let total: Spectrum = branches.iter().map(|b| b.weight).sum();
            assert!((total - Spectrum::ONE).map(f64::abs).max_component() < 1e-15, "ior {ior} cos {cos}");

            let mirrored = branches[0];
            assert_eq!(mirrored.eta, None);
            assert!((mirrored.wi.to_vec() - Vec3::new(-wo.x, -wo.y, wo.z)).length() < 1e-15);
            let sin_t = eta * (1.0 - cos * cos).sqrt();
            assert_eq!(branches.len(), if sin_t < 1.0 { 2 } else { 1 }, "ior {ior} cos {cos}");
            if let Some(refracted) = branches.get(1) {
                assert_eq!(refracted.eta, Some(eta));
                let expected = Vec3::new(-eta * wo.x, -eta * wo.y, -cos.signum() * (1.0 - sin_t * sin_t).sqrt());
                assert!((refracted.wi.to_vec() - expected).length() < 1e-12, "ior {ior} cos {cos}");
                // The way back has the same reflectance and the inverse ratio.
                let back = bsdf.delta_branches(refracted.wi);
                assert!((back[0].weight.r() - mirrored.weight.r()).abs() < 1e-9, "ior {ior} cos {cos}");
                assert!((back[1].wi.to_vec() - wo.to_vec()).length() < 1e-9);
                assert!((back[1].eta.expect("refracted") * eta - 1.0).abs() < 1e-15);
            }
        }
    }
}

/// The differentials bend the ray that the BSDF bends.
#[test]
fn branches_point_where_the_differentials_say() {
    use pdembree::differential::{Differential, Refraction, ShapeOperator, reflect, refract};
    use pdembree::math::Dir3;
    let n = Normal3::new(Vec3::new(0.2, -0.5, 0.9)).expect("not zero");
    let seed = 3;
    let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
    let bsdf = bent(&glass(1.5), n, n);
    for _ in 0..2000 {
        let wo = direction(2.0 * stream.uniform() - 1.0, 6.0 * stream.uniform());
        let w = Dir3::from_unit(-wo.to_vec());
        let branches = bsdf.delta_branches(wo);
        let (mirrored, _) = reflect::<1>(&Differential::ZERO, w, n, &ShapeOperator::FLAT);
        assert!((mirrored.to_vec() - branches[0].wi.to_vec()).length() < 1e-14, "seed {seed} wo {wo:?}");
        let eta = if wo.dot(n) > 0.0 { 1.0 / 1.5 } else { 1.5 };
        match refract::<1>(&Differential::ZERO, w, n, &ShapeOperator::FLAT, eta) {
            Refraction::Transmitted(t, _) => {
                // Near the critical angle √k magnifies rounding.
                assert!((t.to_vec() - branches[1].wi.to_vec()).length() < 1e-7, "seed {seed} wo {wo:?}");
                assert_eq!(branches[1].eta, Some(eta));
            }
            Refraction::TotalReflection(..) => assert_eq!(branches.len(), 1, "seed {seed} wo {wo:?}"),
        }
    }
}

#[test]
fn without_fresnel_all_is_transmitted_that_can_be() {
    let bsdf = flat(&Material::Dielectric { ior: 1.5, exterior: 1.0, fresnel: false });
    let outside = bsdf.delta_branches(direction(0.3, 0.0));
    assert_eq!((outside.len(), outside[0].eta), (1, Some(1.0 / 1.5)));
    assert_eq!(outside[0].weight, Spectrum::ONE);
    let total = bsdf.delta_branches(direction(-0.3, 0.0));
    assert_eq!((total.len(), total[0].eta), (1, None));
    assert_eq!(total[0].weight, Spectrum::ONE);
}

/// A closed furnace of glass: radiance L outside everywhere means n² L inside everywhere. At each interface, seen from
/// either side, what the branches bring must be what is there already.
#[test]
fn radiance_inside_glass_is_n_squared_times_outside() {
    for ior in [1.33, 1.5, 2.0] {
        let bsdf = flat(&glass(ior));
        for i in -20..20 {
            let wo = direction((f64::from(i) + 0.5) / 20.0, 0.2);
            let here = |z: f64| if z > 0.0 { 1.0 } else { ior * ior };
            let arriving: f64 = bsdf
                .delta_branches(wo)
                .iter()
                .map(|b| b.transport_weight(TransportMode::Radiance).r() * here(b.wi.z))
                .sum();
            assert!((arriving - here(wo.z)).abs() < 1e-12, "ior {ior} wo {wo:?}: {arriving}");
        }
    }
}

/// Over the strata of `uc`, every branch comes out as often as its probability says, and probability · weight is the
/// branch's whole weight.
#[test]
fn sampling_splits_as_the_branches_do() {
    for material in [mirror(0.7), glass(1.5), gold(), plastic([0.2, 0.5, 0.8], 1.5)] {
        let bsdf = flat(&material);
        for cos in [-0.95, -0.5, 0.1, 0.4, 0.9] {
            let wo = direction(cos, 2.0);
            let branches = bsdf.delta_branches(wo);
            for mode in MODES {
                let n = 4096;
                let mut seen = [0u32; 2];
                for i in 0..n {
                    let uc = (f64::from(i) + 0.5) / f64::from(n);
                    let Some(sample) = bsdf.sample(wo, uc, [0.3, 0.4], mode) else {
                        panic!("{material:?}: nothing for {uc}");
                    };
                    let probability = match sample.event {
                        Event::Scatter { .. } => continue,
                        Event::DeltaReflection { probability } => probability,
                        Event::DeltaTransmission { probability, .. } => probability,
                    };
                    let at = branches.iter().position(|b| b.wi == sample.wi).expect("one of the branches");
                    seen[at] += 1;
                    let whole = branches[at].transport_weight(mode);
                    let error = (sample.weight * probability - whole).map(f64::abs).max_component();
                    assert!(error < 1e-14, "{material:?} {cos} {mode:?}");
                    let first = bsdf.sample(wo, uc, [0.9, 0.1], mode);
                    assert_eq!(first, Some(sample), "a delta lobe does not look at u");
                }
                for (branch, count) in branches.iter().zip(seen) {
                    let all: f64 = branches.iter().map(|b| b.weight.mean()).sum();
                    let share = match bsdf.has_scatter() {
                        true => branch.weight.mean() / bsdf.albedo(wo).mean(),
                        false => branch.weight.mean() / all,
                    };
                    let error = (f64::from(count) / f64::from(n) - share).abs();
                    assert!(error <= 1.0 / f64::from(n), "{material:?} {cos}: {count} of {n} for {share}");
                }
            }
        }
    }
}

#[test]
fn nothing_passes_where_the_normals_disagree() {
    let ng = Normal3::Z;
    let ns = Normal3::new(Vec3::new(0.8, 0.0, 0.6)).expect("not zero");
    let seed = 9;
    let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
    let (mut agreed, mut refused) = (0, 0);
    for material in [
        lambert([0.5; 3]),
        mirror(0.9),
        glass(1.5),
        gold(),
        rough_glass(1.5, 0.4),
        rough_gold(0.4),
        plastic([0.5; 3], 1.5),
    ] {
        let bsdf = bent(&material, ng, ns);
        let opaque = !matches!(material, Material::Dielectric { .. } | Material::RoughDielectric { .. });
        for _ in 0..1000 {
            let wo = direction(2.0 * stream.uniform() - 1.0, 7.0 * stream.uniform());
            let wi = direction(2.0 * stream.uniform() - 1.0, 7.0 * stream.uniform());
            let context = format!("seed {seed} {material:?} wo {wo:?} wi {wi:?}");
            let both = bsdf.normals_agree(wo) && bsdf.normals_agree(wi);
            let crosses = wo.z * wi.z < 0.0;
            for mode in MODES {
                if !both || opaque && crosses {
                    refused += 1;
                    assert!(bsdf.f(wo, wi, mode).is_black(), "{context}");
                    assert_eq!(bsdf.pdf(wo, wi, mode).get(), 0.0, "{context}");
                    assert_eq!(bsdf.pdf_scatter(wo, wi, mode).get(), 0.0, "{context}");
                }
                let drawn = bsdf.sample(wo, stream.uniform(), stream.uniform2(), mode).map(|s| s.wi);
                if !bsdf.normals_agree(wo) {
                    assert_eq!(bsdf.delta_branches(wo).refused(), u64::from(bsdf.has_delta()), "{context}");
                }
                for w in drawn.into_iter().chain(bsdf.delta_branches(wo).iter().map(|b| b.wi)) {
                    agreed += 1;
                    assert!(bsdf.normals_agree(wo) && bsdf.normals_agree(w), "{context} gives {w:?}");
                    assert!(!opaque || w.z * wo.z > 0.0, "{context} leaks to {w:?}");
                }
            }
        }
    }
    assert!(agreed > 1000 && refused > 1000, "{agreed} {refused}");
}

/// Facets without roughness: metal and coat by Schlick, solid glass as the dielectric coloured, thin glass straight on.
#[test]
fn a_smooth_principled_surface_is_the_sum_of_its_deltas() {
    let (colour, ior) = ([0.9, 0.5, 0.2], 1.5);
    for cos in [-0.9, -0.3, 0.1, 0.5, 1.0] {
        let wo = direction(cos, 0.7);
        let w = (1.0 - f64::abs(cos)).powi(5);
        let coat = 0.04 + 0.96 * w;
        let metal = flat(&principled(colour, [1.0, 0.0, 0.0, ior], false)).delta_branches(wo)[0];
        for (found, c) in metal.weight.to_array().into_iter().zip(colour) {
            assert!((found - (c + (1.0 - c) * w)).abs() < 1e-15, "{metal:?}");
        }
        let solid = flat(&principled(colour, [0.0, 1.0, 0.0, ior], false)).delta_branches(wo);
        let glass = flat(&glass(ior)).delta_branches(wo);
        assert_eq!(solid.len(), glass.len());
        for (solid, glass) in solid.iter().zip(&*glass) {
            assert_eq!((solid.wi, solid.eta), (glass.wi, glass.eta));
            let tint = if glass.eta.is_some() { Spectrum::from(colour) } else { Spectrum::ONE };
            assert!((solid.weight - glass.weight * tint).map(f64::abs).max_component() < 1e-15);
        }
        let thin = flat(&principled(colour, [0.5, 0.5, 0.0, ior], true)).delta_branches(wo);
        let [mirrored, through] = &*thin else { panic!("{thin:?}") };
        assert_eq!(through.eta, Some(1.0));
        assert!((through.wi.to_vec() + wo.to_vec()).length() < 1e-15);
        assert!((through.weight.g() - 0.25 * (1.0 - coat) * 0.5).abs() < 1e-15);
        let expected = 0.5 * (0.5 + 0.5 * w) + 0.5 * coat;
        assert!((mirrored.weight.g() - expected).abs() < 1e-15, "{mirrored:?}");
        for mode in MODES {
            assert!((through.transport_weight(mode) - through.weight).is_black(), "radiance goes through unchanged");
        }
    }
}

/// What is missing of a surface is a straight lobe, the same for both modes; the rest is the surface, as much as there is.
#[test]
fn light_goes_straight_on_through_holes() {
    let part = 0.7;
    for (material, branches) in [
        (principled(WHITE, [0.3, 0.0, 0.3, 1.5], false), 1),
        (principled(WHITE, [0.3, 0.0, 0.0, 1.5], false), 2),
        (principled(WHITE, [0.3, 0.5, 0.0, 1.5], true), 2),
    ] {
        let (whole, partial) = (flat(&material), flat(&holed(material, part)));
        for cos in [-0.8, 0.2, 1.0] {
            let wo = direction(cos, 0.7);
            let wi = direction(cos, 2.7);
            let mode = TransportMode::Radiance;
            assert_eq!(partial.f(wo, wi, mode), whole.f(wo, wi, mode) * part);
            let deltas = partial.delta_branches(wo);
            assert_eq!(deltas.len(), branches);
            let straight = deltas.last().expect("a straight branch");
            assert!((straight.wi.to_vec() + wo.to_vec()).length() < 1e-15 && straight.eta == Some(1.0));
            let sum =
                |bsdf: &pdembree::surface::Bsdf| bsdf.delta_branches(wo).iter().map(|b| b.weight.r()).sum::<f64>();
            assert!((sum(&partial) - (part * sum(&whole) + 1.0 - part)).abs() < 1e-15);
            // Everything is drawn as often as it must be: the weights of straight light are 1 where nothing else is a delta.
            if let (1, Some(sample)) = (branches, partial.sample(wo, 0.9, [0.3, 0.6], mode)) {
                assert_eq!(
                    (sample.weight, sample.event),
                    (Spectrum::ONE, Event::DeltaTransmission { probability: 1.0 - part, eta: 1.0 })
                );
            }
        }
    }
}
