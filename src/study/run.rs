//! The conductor of a study: references, then every experiment's rows, each render looked up or made.

use std::cell::OnceCell;
use std::path::Path;

use super::compare::{Judge, shown_error};
use super::error::StudyError;
use super::fit::power_law;
use super::method::{Method, Parameter};
use super::plan::{BandwidthPlan, Budget, Experiment, ExperimentMethod, ReferencePlan, Study, StudyScene};
use super::reference::{Reference, STEPS_A_PASS, Shelf, reference};
use super::render::{Finished, Order, Wanted, file_stem, program, write_pictures};
use super::results::{
    Bandwidth, COMPARED, Cell, Curve, CurvePoint, ExperimentResult, Mean, ReferenceResult, Results, Row, SCHEMA,
    SceneResult, Slope,
};
use super::search::{Goal, Range, Search};
use crate::film::Channel;
use crate::import::{self, Override};
use crate::render::photon_map;
use crate::render::progress::{Progress, Silent};
use crate::world::World;

/// A search ends this near to where the best bandwidth seems to be: the error is then within 0.5 % of the least one,
/// see the search's tests.
const TOLERANCE: f64 = 1.05;
/// Evaluations that a search is expected to take, for the time that is left.
const EXPECTED_EVALUATIONS: u64 = 10;

/// Photons that tell how many of them are stored: to a few in a thousand.
const PILOTS: u64 = 200_000;

/// Where a study puts its files and what it runs on.
pub struct Place<'a> {
    /// The report's folder.
    pub folder: &'a Path,
    pub references: Shelf<'a>,
    pub threads: usize,
    pub progress: &'a dyn Progress,
}

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
            budgets(e, &study.methods[m.method]).into_iter().map(|budget| steps(budget) * bandwidths).sum::<u64>()
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

/// The weight of one render among the others, roughly a tenth of a second: what is known before anything was measured.
fn steps(budget: Budget) -> u64 {
    match budget {
        Budget::Seconds { seconds, .. } => (10.0 * seconds).ceil() as u64,
        Budget::Photons(n) | Budget::Stored(n) => 10 + n / 4000,
    }
}

/// A scene with its reference.
struct Bench<'a> {
    study: &'a Study,
    scene: &'a StudyScene,
    place: &'a Place<'a>,
    reference: Reference,
    /// The part of the emitted photons that is stored, once it was measured.
    stored_share: OnceCell<f64>,
}

/// All seeds of a method at one bandwidth.
struct Evaluation {
    bandwidth: Option<f64>,
    settings: Vec<Override>,
    finished: Vec<Finished>,
    cells: Vec<Cell>,
}

impl<'a> Bench<'a> {
    fn new(study: &'a Study, scene: &'a StudyScene, place: &'a Place<'a>) -> Result<Bench<'a>, StudyError> {
        let reference = reference(scene, &study.folder, &place.references, place.progress)?;
        Ok(Bench { study, scene, place, reference, stored_share: OnceCell::new() })
    }

    fn result(&self) -> Result<SceneResult, StudyError> {
        let image = &self.reference.image;
        let path = Path::new("references").join(file_stem(&self.scene.name));
        let mut kept = image.clone();
        if let Some(mask) = &self.reference.mask {
            let samples = mask.iter().map(|&compared| f32::from(u8::from(compared))).collect();
            kept.channels.push(Channel { name: COMPARED.to_owned(), samples });
        }
        write_pictures(&self.place.folder.join(&path), &kept, self.scene.white, &[])?;
        let compared = match &self.reference.mask {
            Some(mask) => mask.iter().filter(|&&compared| compared).count(),
            None => image.pixels(),
        };
        Ok(SceneResult {
            name: self.scene.name.clone(),
            file: self.scene.file.clone(),
            width: image.width,
            height: image.height,
            layer: self.scene.layer.clone(),
            white: self.scene.white,
            ssim_domain: super::compare::domain_name(self.scene.ssim).to_owned(),
            reference: ReferenceResult {
                about: self.reference.about.clone(),
                standard_error: shown_error(&self.reference, self.scene.white),
                pixels_compared: compared as u64,
                image: path,
                seconds: self.reference.seconds,
            },
        })
    }

    fn run(
        &self,
        experiment: &Experiment,
        result: &mut ExperimentResult,
        backend: &mut String,
    ) -> Result<(), StudyError> {
        let judge = Judge::new(self.scene, &self.reference, experiment)?;
        let first = result.rows.len();
        for entry in &experiment.methods {
            let method = &self.study.methods[entry.method];
            for budget in budgets(experiment, method) {
                let series = Series {
                    bench: self,
                    judge: &judge,
                    method,
                    asked: budget,
                    budget: self.emitted(budget)?,
                    seeds: &experiment.seeds,
                };
                let (rows, curve) = series.run(&entry.bandwidth)?;
                result.curves.extend(curve);
                for (chosen_for, evaluation) in rows {
                    if let Some(finished) = evaluation.finished.first() {
                        backend.clone_from(&finished.record.backend);
                    }
                    result.rows.push(series.row(chosen_for, evaluation, experiment, entry.method)?);
                }
            }
        }
        self.measure_against_baseline(experiment, &mut result.rows[first..]);
        Ok(())
    }

    /// The budget with photons that are to be stored turned into those that are to be emitted.
    fn emitted(&self, budget: Budget) -> Result<Budget, StudyError> {
        let Budget::Stored(n) = budget else { return Ok(budget) };
        let share = match self.stored_share.get() {
            Some(&share) => share,
            None => {
                let share = self.measure_stored_share()?;
                *self.stored_share.get_or_init(|| share)
            }
        };
        Ok(Budget::Photons((n as f64 / share).round() as u64))
    }

    fn measure_stored_share(&self) -> Result<f64, StudyError> {
        let photons = Override::new("render.photons", PILOTS.to_string());
        let overrides = [self.scene.overrides.clone(), vec![photons]].concat();
        let scene = import::load(&self.study.folder.join(&self.scene.file), &overrides)?.scene;
        let counts = photon_map::shoot(&World::new(scene)?, 0, &Silent).counts;
        match counts.photons_stored {
            0 => Err(StudyError::NothingStored { scene: self.scene.name.clone() }),
            stored => Ok(stored as f64 / counts.photons_emitted as f64),
        }
    }

    fn measure_against_baseline(&self, experiment: &Experiment, rows: &mut [Row]) {
        let Some(baseline) = experiment.baseline else { return };
        let name = &self.study.methods[baseline.method].name;
        let is_baseline = |row: &&Row| {
            row.method == *name
                && row.chosen_for != "ssim"
                && baseline.photons.is_none_or(|wanted| row.photons == Some(wanted))
        };
        let rmse = |row: &Row| row.mean(|m| Some(m.rmse));
        // Of several bandwidths the baseline has its best, too.
        let of = rows.iter().filter(is_baseline).filter_map(rmse).min_by(|a, b| a.value.total_cmp(&b.value));
        let Some(of) = of else { return };
        for row in rows {
            row.rmse_ratio = rmse(row).map(|mean: Mean| mean.over(of));
        }
    }
}

/// The budgets of an experiment that differ for `method`: eye paths do without photons.
fn budgets(experiment: &Experiment, method: &Method) -> Vec<Budget> {
    let mut budgets = experiment.budgets.clone();
    if method.traces_eye_paths_only() {
        for budget in &mut budgets {
            if let Budget::Seconds { photons, .. } = budget {
                *photons = None;
            }
        }
        budgets.dedup();
    }
    budgets
}

fn count(budget: Budget) -> Option<u64> {
    match budget {
        Budget::Photons(n) | Budget::Stored(n) => Some(n),
        Budget::Seconds { photons, .. } => photons,
    }
}

/// A method with one budget on one scene: the bandwidths are what is turned.
struct Series<'a> {
    bench: &'a Bench<'a>,
    judge: &'a Judge<'a>,
    method: &'a Method,
    /// As the experiment has it.
    asked: Budget,
    /// In photons to emit, or seconds.
    budget: Budget,
    seeds: &'a [u64],
}

/// Rows, each with what its bandwidth is best for.
type Chosen = Vec<(&'static str, Evaluation)>;

impl Series<'_> {
    fn run(&self, plan: &BandwidthPlan) -> Result<(Chosen, Option<Curve>), StudyError> {
        let given = |evaluation| vec![("given", evaluation)];
        match (plan, self.method.parameter) {
            (BandwidthPlan::AsSet, _) | (_, None) => Ok((given(self.evaluate(None)?), None)),
            (BandwidthPlan::Each(list), Some(_)) => {
                let rows: Result<Chosen, StudyError> =
                    list.iter().map(|&value| Ok(("given", self.evaluate(Some(value))?))).collect();
                Ok((rows?, None))
            }
            (BandwidthPlan::Schedule { value, at, exponent }, Some(_)) => {
                let photons = self.photons().unwrap_or(1) as f64;
                Ok((given(self.evaluate(Some(value * (photons / at).powf(*exponent)))?), None))
            }
            (BandwidthPlan::Best { low, high }, Some(parameter)) => {
                self.search(parameter, *low, *high).map(|(rows, curve)| (rows, Some(curve)))
            }
        }
    }

    /// Photons that a schedule or a first guess goes by: all of them, or those of a pass under a time budget.
    fn photons(&self) -> Option<u64> {
        count(self.budget)
    }

    /// The same as the experiment names it.
    fn asked_photons(&self) -> Option<u64> {
        count(self.asked)
    }

    fn search(&self, parameter: Parameter, low: f64, high: f64) -> Result<(Chosen, Curve), StudyError> {
        let range = Range { low, high, whole: parameter == Parameter::Neighbours };
        let mut search = Search::new(range, TOLERANCE);
        let mut evaluations: Vec<Evaluation> = Vec::new();
        // The middle of the range; over a very wide one, what was best for 20 000 photons and goes with their number.
        let guess = match parameter {
            _ if high / low < 100.0 => (low * high).sqrt(),
            Parameter::Neighbours => 200.0 * (self.photons().unwrap_or(20_000) as f64 / 2e4).powf(2.0 / 3.0),
            Parameter::Scale => 4.0,
            Parameter::Radius => (low * high).sqrt(),
        };
        for goal in [Goal::Rmse, Goal::Ssim] {
            search.run(goal, guess, |bandwidth| {
                let evaluation = self.evaluate(Some(bandwidth))?;
                let point = evaluation.point(bandwidth);
                evaluations.push(evaluation);
                Ok::<_, StudyError>(point)
            })?;
        }
        let unspent = EXPECTED_EVALUATIONS.saturating_sub(evaluations.len() as u64);
        self.bench.place.progress.skip(unspent * self.seeds.len() as u64 * steps(self.budget));
        let best = |goal| search.best(goal);
        let curve = Curve {
            scene: self.bench.scene.name.clone(),
            method: self.method.name.clone(),
            photons: self.asked_photons(),
            parameter: parameter.name().to_owned(),
            points: search.points().to_vec(),
            best_rmse: best(Goal::Rmse).unwrap_or(0),
            best_ssim: best(Goal::Ssim),
            rmse_bracketed: search.is_bracketed(Goal::Rmse),
            ssim_bracketed: search.is_bracketed(Goal::Ssim),
        };
        let mut rows: Chosen = Vec::new();
        let goals: &[(&'static str, Option<usize>)] = if best(Goal::Rmse) == best(Goal::Ssim) {
            &[("rmse and ssim", best(Goal::Rmse))]
        } else {
            &[("rmse", best(Goal::Rmse)), ("ssim", best(Goal::Ssim))]
        };
        for (name, place) in goals {
            let Some(bandwidth) = place.map(|i| curve.points[i].bandwidth) else { continue };
            if let Some(i) = evaluations.iter().position(|e| e.bandwidth == Some(bandwidth)) {
                rows.push((name, evaluations.swap_remove(i)));
            }
        }
        Ok((rows, curve))
    }

    /// Renders all seeds at one bandwidth.
    fn evaluate(&self, bandwidth: Option<f64>) -> Result<Evaluation, StudyError> {
        let bench = self.bench;
        let mut settings = [bench.scene.overrides.clone(), self.method.overrides.clone()].concat();
        let mut seconds = None;
        match self.budget {
            Budget::Photons(n) | Budget::Stored(n) => settings.extend(self.share_of(n)),
            Budget::Seconds { seconds: limit, photons } => {
                seconds = Some(limit);
                settings.extend(photons.map(|n| Override::new("render.photons", n.to_string())));
            }
        }
        if let (Some(parameter), Some(value)) = (self.method.parameter, bandwidth) {
            settings.push(parameter.setting(value));
        }
        let file = bench.study.folder.join(&bench.scene.file);
        let (mut all, mut cells) = (Vec::new(), Vec::new());
        for &seed in self.seeds {
            let mut overrides = settings.clone();
            overrides.push(Override::new("render.seed", seed.to_string()));
            let order = Order {
                scene: &file,
                overrides,
                layer: &bench.scene.layer,
                seconds,
                white: bench.scene.white,
                label: format!("{}-{}", bench.scene.name, self.method.name),
            };
            let render = self.find_or_make(&order, &self.title(bandwidth, seed))?;
            let metrics = self.judge.quick_metrics(&render.image, &order.label)?;
            cells.push(Cell { seed, seconds: render.record.seconds, passes: render.record.passes, metrics });
            all.push(render);
        }
        Ok(Evaluation { bandwidth, settings, finished: all, cells })
    }

    fn find_or_make(&self, order: &Order, title: &str) -> Result<Finished, StudyError> {
        let Place { folder, threads, progress, .. } = *self.bench.place;
        let wanted = Wanted::new(order, threads)?;
        if let Some(known) = wanted.find(folder) {
            progress.skip(steps(self.budget));
            return Ok(known);
        }
        progress.phase(title, steps(self.budget));
        let made = wanted.make(folder)?;
        progress.finish();
        Ok(made)
    }

    /// Photons of each pass, so that all passes together emit `n`.
    fn share_of(&self, n: u64) -> Option<Override> {
        if self.method.traces_eye_paths_only() {
            return None;
        }
        let passes = self.method.setting("render.passes").and_then(|p| p.parse().ok()).unwrap_or(1u64);
        Some(Override::new("render.photons", n.div_ceil(passes.max(1)).to_string()))
    }

    fn title(&self, bandwidth: Option<f64>, seed: u64) -> String {
        let budget = match self.budget {
            Budget::Photons(n) | Budget::Stored(n) => format!("{n} photons"),
            Budget::Seconds { seconds, .. } => format!("{seconds} s"),
        };
        let parameter = match (self.method.parameter, bandwidth) {
            (Some(parameter), Some(value)) => format!(", {} = {value:.4}", parameter.name()),
            _ => String::new(),
        };
        format!("{}, {}, {budget}{parameter}, seed {seed}", self.bench.scene.name, self.method.name)
    }

    fn row(
        &self,
        chosen_for: &'static str,
        evaluation: Evaluation,
        experiment: &Experiment,
        method: usize,
    ) -> Result<Row, StudyError> {
        let photons = self.asked_photons();
        let here = |p: &&super::plan::Published| p.method == method && (p.photons.is_none() || p.photons == photons);
        let published = experiment.published.iter().find(here);
        let goal = |name: &str| chosen_for == "given" || chosen_for.contains(name);
        let metric = |name: &str, value: Option<f64>| Some((name.to_owned(), value.filter(|_| goal(name))?));
        let first = evaluation.finished.first();
        let mut cells = evaluation.cells;
        for (cell, render) in cells.iter_mut().zip(&evaluation.finished) {
            cell.metrics = self.judge.metrics(&render.image, &self.method.name)?;
        }
        Ok(Row {
            scene: self.bench.scene.name.clone(),
            method: self.method.name.clone(),
            photons: match self.asked {
                _ if self.method.traces_eye_paths_only() => None,
                Budget::Photons(n) | Budget::Stored(n) => Some(n),
                Budget::Seconds { .. } => first.and_then(|f| f.record.photons),
            },
            photons_emitted: first.and_then(|f| f.record.photons),
            photons_stored: first.and_then(|f| f.record.photons_stored),
            passes: first.map_or(0, |f| f.record.passes),
            bandwidth: self
                .method
                .parameter
                .zip(evaluation.bandwidth)
                .map(|(parameter, value)| Bandwidth { name: parameter.name().to_owned(), value }),
            chosen_for: chosen_for.to_owned(),
            settings: evaluation.settings.iter().map(ToString::to_string).collect(),
            published: published
                .into_iter()
                .flat_map(|p| [metric("rmse", p.rmse), metric("ssim", p.ssim)])
                .flatten()
                .collect(),
            rmse_ratio: None,
            image: first.map(|f| f.path.clone()).unwrap_or_default(),
            cells,
        })
    }
}

impl Evaluation {
    /// The means over the seeds.
    fn point(&self, bandwidth: f64) -> CurvePoint {
        let n = self.cells.len() as f64;
        let ssim: Option<Vec<f64>> = self.cells.iter().map(|cell| cell.metrics.ssim).collect();
        CurvePoint {
            bandwidth,
            rmse: self.cells.iter().map(|cell| cell.metrics.rmse).sum::<f64>() / n,
            ssim: ssim.map(|values| values.iter().sum::<f64>() / n),
        }
    }
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
