//! The conductor of a study: references, then every experiment's rows, each render looked up or made.

use super::bench::Bench;
use super::error::StudyError;
use super::fit::power_law;
use super::place::Place;
use super::plan::{BandwidthPlan, Experiment, ExperimentMethod, ReferencePlan, Study};
use super::reference::STEPS_A_PASS;
use super::render::program;
use super::results::{ExperimentResult, Results, Row, SCHEMA, Slope};
use super::series::{EXPECTED_EVALUATIONS, steps};

/// A finished study and what its reader should know.
pub struct Studied {
    pub results: Results,
    pub notes: Vec<String>,
}

/// Runs what is not on disk yet. Experiments that `wanted` refuses are left out.
pub fn run(study: &Study, place: &Place, wanted: impl Fn(&Experiment) -> bool) -> Result<Studied, StudyError> {
    let experiments: Vec<&Experiment> = study.experiments.iter().filter(|e| wanted(e)).collect();
    let used = |i: usize| experiments.iter().any(|e| e.scenes.contains(&i));
    let (mut notes, mut scenes, mut tables) = (Vec::new(), Vec::new(), Vec::new());
    for (i, scene) in study.scenes.iter().enumerate() {
        scenes.push(if used(i) { Some(Bench::new(study, scene, place)?) } else { None });
    }
    for bench in scenes.iter().flatten() {
        tables.push(bench.result()?);
        notes.extend(bench.reference.notes.iter().cloned());
    }
    let mut found = Vec::new();
    let mut backend = String::new();
    for experiment in experiments {
        let mut result = ExperimentResult {
            name: experiment.name.clone(),
            about: experiment.about.clone(),
            crop: experiment.crop,
            region: experiment.region,
            rows: Vec::new(),
            curves: Vec::new(),
            slopes: Vec::new(),
        };
        for bench in experiment.scenes.iter().filter_map(|&i| scenes[i].as_ref()) {
            bench.run(experiment, &mut result, &mut backend)?;
        }
        result.slopes = slopes(&result.rows);
        found.push(result);
    }
    let results = Results {
        schema: SCHEMA,
        title: study.title.clone(),
        about: study.about.clone(),
        program: program(),
        backend,
        threads: place.threads,
        scenes: tables,
        experiments: found,
    };
    Ok(Studied { results, notes })
}

/// How many steps `Progress` will be told of, in about the unit of an eye sample's gathering.
pub fn expected_steps(study: &Study, wanted: impl Fn(&Experiment) -> bool) -> u64 {
    let rows = |e: &Experiment| -> u64 {
        let of = |m: &ExperimentMethod| -> u64 {
            let bandwidths = match &m.bandwidth {
                BandwidthPlan::Best { .. } => EXPECTED_EVALUATIONS,
                BandwidthPlan::Each(list) => list.len() as u64,
                BandwidthPlan::AsSet | BandwidthPlan::Schedule { .. } => 1,
            };
            e.budgets_of(&study.methods[m.method]).into_iter().map(|budget| steps(budget) * bandwidths).sum::<u64>()
        };
        e.methods.iter().map(of).sum::<u64>() * e.scenes.len() as u64 * e.seeds.len() as u64
    };
    let experiments: Vec<&Experiment> = study.experiments.iter().filter(|e| wanted(e)).collect();
    let used = |i: &usize| experiments.iter().any(|e| e.scenes.contains(i));
    let references = (0..study.scenes.len()).filter(used).map(|i| match &study.scenes[i].reference {
        ReferencePlan::Exact(_) => 0,
        ReferencePlan::Rendered(parts) => parts.iter().map(|part| u64::from(part.passes) * STEPS_A_PASS).sum(),
    });
    references.sum::<u64>() + experiments.iter().map(|e| rows(e)).sum::<u64>()
}

/// Power laws of every scene and method with three numbers of photons or more, over photons and over seconds.
fn slopes(rows: &[Row]) -> Vec<Slope> {
    let mut series: Vec<(&str, &str)> = rows.iter().map(|row| (row.scene.as_str(), row.method.as_str())).collect();
    series.sort_unstable();
    series.dedup();
    let of = |&(scene, method): &(&str, &str), over: &str, x: &dyn Fn(&Row) -> Option<f64>| {
        let mine = |row: &&Row| row.scene == scene && row.method == method && row.chosen_for != "ssim";
        let point = |row: &Row| Some((x(row)?, row.mean(|m| Some(m.rmse_linear))?.value));
        let points: Vec<(f64, f64)> = rows.iter().filter(mine).filter_map(point).collect();
        // Three bandwidths of the same photons are no law.
        let work = |row: &Row| row.photons.map_or(row.seconds(), |n| n as f64);
        let mut amounts: Vec<f64> = rows.iter().filter(mine).map(work).collect();
        amounts.sort_by(f64::total_cmp);
        amounts.dedup();
        let law = power_law(&points).filter(|_| amounts.len() > 2)?;
        let (scene, method, over) = (scene.to_owned(), method.to_owned(), over.to_owned());
        Some(Slope { scene, method, over, slope: law.slope, half_width: law.half_width, intercept: law.intercept })
    };
    let photons = |row: &Row| row.photons.map(|n| n as f64);
    let seconds = |row: &Row| Some(row.seconds());
    series.iter().flat_map(|s| [of(s, "photons", &photons), of(s, "seconds", &seconds)]).flatten().collect()
}
