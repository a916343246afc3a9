//! Discrete choices: probabilities, reuse of the number, inverses, weights that leave nothing to choose.

use pdembree::sampling::discrete::{DiscreteTable, Mosaic};
use pdembree::sampling::{Purpose, Stream};

use crate::support::statistics::{assert_plausible, chi2_test};

const SEED: u64 = 1993;
const WEIGHTS: [f64; 7] = [0.0, 3.0, 0.5, 0.0, 10.0, 1e-3, 0.0];

#[test]
fn entries_are_chosen_by_weight_and_numbers_are_reused_uniformly() {
    const DRAWS: usize = 200_000;
    let table = DiscreteTable::new(&WEIGHTS).expect("weights are sound");
    let mosaic = Mosaic::new(&WEIGHTS).expect("weights are sound");
    let total: f64 = WEIGHTS.iter().sum();
    let mut stream = Stream::new(SEED, Purpose::Test, 0, 0);
    // Entries × tenths of the reused number(s).
    let mut by_table = vec![0u64; WEIGHTS.len() * 10];
    let mut by_mosaic = vec![0u64; WEIGHTS.len() * 100];
    for _ in 0..DRAWS {
        let s = table.sample(stream.uniform());
        by_table[s.index * 10 + (s.reused * 10.0) as usize] += 1;
        let s = mosaic.sample(stream.uniform2());
        by_mosaic[s.index * 100 + (s.reused[0] * 10.0) as usize * 10 + (s.reused[1] * 10.0) as usize] += 1;
    }
    let expect = |parts: usize| -> Vec<f64> {
        (0..WEIGHTS.len() * parts).map(|c| WEIGHTS[c / parts] / total * DRAWS as f64 / parts as f64).collect()
    };
    assert_plausible(chi2_test(&by_table, &expect(10)), 2, format!("table, seed {SEED}"));
    assert_plausible(chi2_test(&by_mosaic, &expect(100)), 2, format!("mosaic, seed {SEED}"));
}

#[test]
fn probabilities_add_up_and_inverses_return() {
    let table = DiscreteTable::new(&WEIGHTS).expect("weights are sound");
    let mosaic = Mosaic::new(&WEIGHTS).expect("weights are sound");
    let total: f64 = WEIGHTS.iter().sum();
    for (i, w) in WEIGHTS.iter().enumerate() {
        assert!((table.pmf(i).0 - w / total).abs() <= 4.0 * f64::EPSILON);
        assert!((mosaic.pmf(i).0 - w / total).abs() <= 4.0 * f64::EPSILON);
        assert_eq!(table.inverse(i, 0.5).is_some(), *w > 0.0);
        assert_eq!(mosaic.inverse(i, [0.5; 2]).is_some(), *w > 0.0);
    }
    assert_eq!(table.pmf(99).0, 0.0);
    assert_eq!(mosaic.pmf(99).0, 0.0);
    let mut stream = Stream::new(SEED, Purpose::Test, 1, 0);
    for _ in 0..1000 {
        let u = stream.uniform2();
        let s = table.sample(u[0]);
        let back = table.inverse(s.index, s.reused).expect("a chosen entry");
        assert!((back - u[0]).abs() <= 4.0 * f64::EPSILON, "{u:?} of seed {SEED}");
        assert_eq!(s.pmf, table.pmf(s.index));
        let s = mosaic.sample(u);
        let back = mosaic.inverse(s.index, s.reused).expect("a chosen entry");
        assert!((0..2).all(|k| (back[k] - u[k]).abs() <= 4.0 * f64::EPSILON), "{u:?} of seed {SEED}");
        assert!((s.stretch[0] * s.stretch[1] * s.pmf.0 - 1.0).abs() <= 4.0 * f64::EPSILON);
    }
}

#[test]
fn both_ends_of_the_unit_interval_choose_entries_that_have_weight() {
    let top = 1.0 - f64::EPSILON / 2.0;
    let table = DiscreteTable::new(&WEIGHTS).expect("weights are sound");
    let mosaic = Mosaic::new(&WEIGHTS).expect("weights are sound");
    for u in [0.0, top] {
        let s = table.sample(u);
        assert!(WEIGHTS[s.index] > 0.0 && (0.0..1.0).contains(&s.reused));
        for v in [0.0, top] {
            let s = mosaic.sample([u, v]);
            assert!(WEIGHTS[s.index] > 0.0 && s.reused.iter().all(|r| (0.0..1.0).contains(r)));
        }
    }
}

#[test]
fn weights_without_a_choice_are_refused() {
    for weights in [&[][..], &[0.0, 0.0], &[1.0, -1.0], &[f64::NAN], &[f64::INFINITY, 1.0]] {
        assert!(DiscreteTable::new(weights).is_none(), "{weights:?}");
        assert!(Mosaic::new(weights).is_none(), "{weights:?}");
    }
}

/// Many equal entries get compact tiles; a table would stretch one side alone, by 1000. Cutting one entry off three
/// makes 3 : 1 of a square at worst, the unequal halves before it a little more.
#[test]
fn tiles_of_equal_entries_are_nearly_square() {
    let mosaic = Mosaic::new(&[1.0; 1000]).expect("weights are sound");
    let mut stream = Stream::new(SEED, Purpose::Test, 2, 0);
    for _ in 0..1000 {
        let [a, b] = mosaic.sample(stream.uniform2()).stretch;
        assert!(a.max(b) / a.min(b) < 4.0, "stretch {a} × {b}");
    }
}

/// Weights over 200 orders of magnitude neither overflow the stack nor lose the large entries.
#[test]
fn a_mosaic_takes_extreme_weights() {
    let weights: Vec<f64> = (0..400).map(|i| 10f64.powf(-f64::from(i) / 2.0)).collect();
    let mosaic = Mosaic::new(&weights).expect("weights are sound");
    let total: f64 = weights.iter().sum();
    for (i, w) in weights.iter().enumerate() {
        let p = mosaic.pmf(i).0;
        // A product of one rounded share for each cut.
        assert!((p / (w / total) - 1.0).abs() <= 4.0 * 400.0 * f64::EPSILON, "entry {i}: {p:e}");
    }
}
