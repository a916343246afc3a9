//! A scene with its reference: runs the rows of an experiment on it.

use std::cell::OnceCell;
use std::path::Path;

use super::compare::{self, Judge};
use super::error::StudyError;
use super::place::Place;
use super::plan::{Budget, Experiment, Study, StudyScene};
use super::reference::{Reference, reference};
use super::render::{file_stem, write_pictures};
use super::results::{COMPARED, ExperimentResult, Mean, ReferenceResult, Row, SceneResult};
use super::series::Series;
use crate::film::Channel;
use crate::import::{self, Override};
use crate::render::photon_map;
use crate::render::progress::Silent;
use crate::world::World;

/// Photons that tell how many of them are stored: to a few in a thousand.
const PILOTS: u64 = 200_000;
/// Fewer than that are guided otherwise: their number is corrected so often at most, until it stores what it should to this
/// part. With 20 000 photons the number itself is known to less than a hundredth.
const MAX_CORRECTIONS: u32 = 6;
const NEAR_ENOUGH: f64 = 0.01;

/// A scene with its reference.
pub(super) struct Bench<'a> {
    study: &'a Study,
    scene: &'a StudyScene,
    place: &'a Place<'a>,
    pub reference: Reference,
    /// The part of the emitted photons that each method stores, once it was measured: not all methods guide them.
    stored_shares: Vec<OnceCell<f64>>,
}

impl<'a> Bench<'a> {
    pub fn new(study: &'a Study, scene: &'a StudyScene, place: &'a Place<'a>) -> Result<Bench<'a>, StudyError> {
        let reference = reference(scene, &study.folder, &place.references, place.progress)?;
        let stored_shares = vec![OnceCell::new(); study.methods.len()];
        Ok(Bench { study, scene, place, reference, stored_shares })
    }

    pub fn result(&self) -> Result<SceneResult, StudyError> {
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
            ssim_domain: compare::domain_name(self.scene.ssim).to_owned(),
            reference: ReferenceResult {
                about: self.reference.about.clone(),
                standard_error: compare::shown_error(&self.reference, self.scene.white),
                pixels_compared: compared as u64,
                image: path,
                seconds: self.reference.seconds,
            },
        })
    }

    pub fn run(
        &self,
        experiment: &Experiment,
        result: &mut ExperimentResult,
        backend: &mut String,
    ) -> Result<(), StudyError> {
        let judge = Judge::new(self.scene, &self.reference, experiment)?;
        let first = result.rows.len();
        for entry in &experiment.methods {
            let method = &self.study.methods[entry.method];
            for budget in experiment.budgets_of(method) {
                let series = Series {
                    folder: &self.study.folder,
                    scene: self.scene,
                    place: self.place,
                    judge: &judge,
                    method,
                    asked: budget,
                    budget: self.emitted(budget, entry.method)?,
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

    /// The budget with photons that are to be stored turned into those that are to be emitted. How well a light is guided
    /// depends on how many photons it has, so what many of them tell is corrected by what about as many as are wanted store,
    /// until these are.
    fn emitted(&self, budget: Budget, method: usize) -> Result<Budget, StudyError> {
        let Budget::Stored(n) = budget else { return Ok(budget) };
        let mut share = match self.stored_shares[method].get() {
            Some(&share) => share,
            None => {
                let share = self.measure_stored_share(method, PILOTS)?;
                *self.stored_shares[method].get_or_init(|| share)
            }
        };
        let emitted = |share: f64| (n as f64 / share).round().max(1.0) as u64;
        for _ in 0..MAX_CORRECTIONS {
            let about = emitted(share);
            if about >= PILOTS {
                break;
            }
            share = self.measure_stored_share(method, about)?;
            if (share * about as f64 / n as f64 - 1.0).abs() < NEAR_ENOUGH {
                break;
            }
        }
        Ok(Budget::Photons(emitted(share)))
    }

    fn measure_stored_share(&self, method: usize, photons: u64) -> Result<f64, StudyError> {
        let photons = Override::new("render.photons", photons.to_string());
        let method = &self.study.methods[method].overrides;
        let overrides = [self.scene.overrides.clone(), method.clone(), vec![photons]].concat();
        let scene = import::load(&self.study.folder.join(&self.scene.file), &overrides)?.scene;
        let counts = photon_map::shoot_all(&World::new(scene)?, 0, &Silent).counts;
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
