//! A method with one budget on one scene: the bandwidths are what is turned, each render is looked up or made.

use std::path::Path;

use super::compare::Judge;
use super::error::StudyError;
use super::method::{Method, Parameter};
use super::place::Place;
use super::plan::{BandwidthPlan, Budget, Experiment, Published, StudyScene};
use super::render::{Finished, Order, Wanted};
use super::results::{Bandwidth, Cell, Curve, CurvePoint, Row};
use super::search::{Goal, Range, Search};
use crate::import::Override;

/// A search ends this near to where the best bandwidth seems to be: the error is then within 0.5 % of the least one,
/// see the search's tests.
const TOLERANCE: f64 = 1.05;
/// Evaluations that a search is expected to take, for the time that is left.
pub(super) const EXPECTED_EVALUATIONS: u64 = 10;

/// A method with one budget on one scene: the bandwidths are what is turned.
pub(super) struct Series<'a> {
    /// Of the study; scene files are found from there.
    pub folder: &'a Path,
    pub scene: &'a StudyScene,
    pub place: &'a Place<'a>,
    pub judge: &'a Judge<'a>,
    pub method: &'a Method,
    /// As the experiment has it.
    pub asked: Budget,
    /// In photons to emit, or seconds.
    pub budget: Budget,
    pub seeds: &'a [u64],
}

/// All seeds of a method at one bandwidth.
pub(super) struct Evaluation {
    bandwidth: Option<f64>,
    settings: Vec<Override>,
    pub finished: Vec<Finished>,
    cells: Vec<Cell>,
}

/// Rows, each with what its bandwidth is best for.
pub(super) type Chosen = Vec<(&'static str, Evaluation)>;

impl Series<'_> {
    pub fn run(&self, plan: &BandwidthPlan) -> Result<(Chosen, Option<Curve>), StudyError> {
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
        self.budget.photons()
    }

    /// The same as the experiment names it.
    fn asked_photons(&self) -> Option<u64> {
        self.asked.photons()
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
        self.place.progress.skip(unspent * self.seeds.len() as u64 * steps(self.asked));
        let best = |goal| search.best(goal);
        let curve = Curve {
            scene: self.scene.name.clone(),
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
        let mut settings = [self.scene.overrides.clone(), self.method.overrides.clone()].concat();
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
        let file = self.folder.join(&self.scene.file);
        let (mut all, mut cells) = (Vec::new(), Vec::new());
        for &seed in self.seeds {
            let mut overrides = settings.clone();
            overrides.push(Override::new("render.seed", seed.to_string()));
            let order = Order {
                scene: &file,
                overrides,
                layer: &self.scene.layer,
                seconds,
                white: self.scene.white,
                label: format!("{}-{}", self.scene.name, self.method.name),
            };
            let render = self.find_or_make(&order, &self.title(bandwidth, seed))?;
            let metrics = self.judge.quick_metrics(&render.image, &order.label)?;
            cells.push(Cell { seed, seconds: render.record.seconds, passes: render.record.passes, metrics });
            all.push(render);
        }
        Ok(Evaluation { bandwidth, settings, finished: all, cells })
    }

    fn find_or_make(&self, order: &Order, title: &str) -> Result<Finished, StudyError> {
        let Place { folder, threads, progress, .. } = *self.place;
        let wanted = Wanted::new(order, threads)?;
        if let Some(known) = wanted.find(folder) {
            progress.skip(steps(self.asked));
            return Ok(known);
        }
        progress.phase(title, steps(self.asked));
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
        format!("{}, {}, {budget}{parameter}, seed {seed}", self.scene.name, self.method.name)
    }

    pub fn row(
        &self,
        chosen_for: &'static str,
        evaluation: Evaluation,
        experiment: &Experiment,
        method: usize,
    ) -> Result<Row, StudyError> {
        let photons = self.asked_photons();
        let here = |p: &&Published| p.method == method && (p.photons.is_none() || p.photons == photons);
        let published = experiment.published.iter().find(here);
        let goal = |name: &str| chosen_for == "given" || chosen_for.contains(name);
        let metric = |name: &str, value: Option<f64>| Some((name.to_owned(), value.filter(|_| goal(name))?));
        let first = evaluation.finished.first();
        let mut cells = evaluation.cells;
        for (cell, render) in cells.iter_mut().zip(&evaluation.finished) {
            cell.metrics = self.judge.metrics(&render.image, &self.method.name)?;
        }
        Ok(Row {
            scene: self.scene.name.clone(),
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

/// The weight of one render among the others, roughly a tenth of a second: what is known before anything was measured.
pub(super) fn steps(budget: Budget) -> u64 {
    match budget {
        Budget::Seconds { seconds, .. } => (10.0 * seconds).ceil() as u64,
        Budget::Photons(n) | Budget::Stored(n) => 10 + n / 4000,
    }
}
