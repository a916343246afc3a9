//! The committed tables of the studies: what is cheap in them is rendered again with other seeds, and means are
//! compared by Welch's t-test.

use std::path::Path;

use pdembree::render::progress::Silent;
use pdembree::study::file;
use pdembree::study::method::Method;
use pdembree::study::place::Place;
use pdembree::study::plan::{BandwidthPlan, Budget, Experiment, ExperimentMethod, Study};
use pdembree::study::reference::Shelf;
use pdembree::study::results::{Metrics, Results, Row};
use pdembree::study::run::run;

use crate::support::data::root;
use crate::support::statistics::{Moments, assert_plausible, welch};

/// Seeds that no study uses.
const SEEDS: [u64; 3] = [101, 102, 103];
/// Rows that took longer than this in the study are not made again here, seconds.
const CHEAP: f64 = 2.5;
/// The numbers of photons that are made again, but of studies of fewer.
const PHOTONS: u64 = 20_000;

type Metric = fn(&Metrics) -> Option<f64>;

/// Name of a study file below scenes, without ending; its results stand beside it.
fn tables_hold(study: &str) {
    tables_hold_of(study, PHOTONS);
}

/// The same of a study whose rows of that many photons are made again.
fn tables_hold_of(study: &str, photons: u64) {
    let path = root().join("scenes").join(study).with_extension("toml");
    let plan = file::read(&path).unwrap_or_else(|problems| panic!("{problems}"));
    let committed = results(&path);
    let mut again = plan.clone();
    again.experiments = committed
        .experiments
        .iter()
        .zip(&plan.experiments)
        .flat_map(|(results, experiment)| {
            assert_eq!(results.name, experiment.name, "{study}: the table is of another study");
            results
                .rows
                .iter()
                .filter(|row| is_cheap(row, photons))
                .map(|row| repeated(&plan, experiment, row, photons))
        })
        .collect();
    assert!(!again.experiments.is_empty(), "{study}: no row is cheap enough");
    let folder = tempfile::tempdir().expect("temporary folder");
    let (published, own) = (plan.folder.join("references"), folder.path().join("own"));
    let references = Shelf { published: &published, own: &own };
    let place = Place { folder: folder.path(), references, threads: 2, progress: &Silent };
    let found = run(&again, &place, |_| true).unwrap_or_else(|error| panic!("{study}: {error}")).results;
    assert!(!own.exists(), "{study}: the reference beside it is missing or too short");

    let rows: Vec<&Row> =
        committed.experiments.iter().flat_map(|e| &e.rows).filter(|row| is_cheap(row, photons)).collect();
    let renewed: Vec<&Row> = found.experiments.iter().flat_map(|e| &e.rows).collect();
    assert_eq!(rows.len(), renewed.len());
    let tests = 2 * rows.len();
    for (row, renewed) in rows.into_iter().zip(renewed) {
        assert_eq!((&row.method, &row.bandwidth, row.photons), (&renewed.method, &renewed.bandwidth, renewed.photons));
        let metrics: [(&str, Metric); 2] = [("RMSE", |m| Some(m.rmse)), ("SSIM", |m| m.ssim)];
        for (name, metric) in metrics {
            let [was, is] = [row, renewed].map(|row| moments(row, metric));
            let what = format!("{study}, {}, {:?}, {name}: {was} in the table, {is} now", row.method, row.bandwidth);
            println!("{what}");
            assert_plausible(welch(&was, &is), tests, what);
        }
    }
}

fn results(study: &Path) -> Results {
    let path = study.with_extension("json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Several seeds, few photons, not timed, and quick: of the bandwidths that were looked at only the best.
fn is_cheap(row: &Row, photons: u64) -> bool {
    row.cells.len() > 2 && row.photons == Some(photons) && row.chosen_for != "ssim" && row.seconds() < CHEAP
}

/// The row of an experiment with its bandwidth and other seeds.
fn repeated(study: &Study, experiment: &Experiment, row: &Row, photons: u64) -> Experiment {
    let place = |method: &Method| method.name == row.method;
    let method = study.methods.iter().position(place).unwrap_or_else(|| panic!("no method {}", row.method));
    let bandwidth = match &row.bandwidth {
        Some(bandwidth) => BandwidthPlan::Each(vec![bandwidth.value]),
        None => BandwidthPlan::AsSet,
    };
    Experiment {
        methods: vec![ExperimentMethod { method, bandwidth }],
        budgets: experiment
            .budgets
            .iter()
            .copied()
            .filter(|b| matches!(b, Budget::Photons(n) | Budget::Stored(n) if *n == photons))
            .collect(),
        seeds: SEEDS.to_vec(),
        baseline: None,
        scenes: study.scenes.iter().enumerate().filter(|(_, s)| s.name == row.scene).map(|(i, _)| i).collect(),
        ..experiment.clone()
    }
}

fn moments(row: &Row, metric: Metric) -> Moments {
    row.cells.iter().filter_map(|cell| metric(&cell.metrics)).collect()
}

#[test]
fn effect_of_bandwidth() {
    tables_hold("refraction/bandwidth_study");
}

#[test]
fn refraction() {
    tables_hold("refraction/study");
}

#[test]
fn reflection() {
    tables_hold("reflection/study");
}

#[test]
fn ring() {
    tables_hold("ring/study");
}

#[test]
fn ring_floor() {
    tables_hold("ring/floor_study");
}

#[test]
fn ball_lens() {
    tables_hold("refraction/ball_study");
}

#[test]
fn the_room_s_table_holds() {
    tables_hold("room/study");
}

#[test]
fn travelling_wave() {
    tables_hold_of("blur/wave_study", 1_000);
}

#[test]
fn turning_rod() {
    tables_hold_of("blur/rod_study", 5_000);
}
