//! What a study is to find out: scenes × methods × numbers of photons × bandwidths × seeds, and the references.

use std::path::PathBuf;

use super::exact::ClosedForm;
use super::method::Method;
use super::metric::SsimDomain;
use crate::import::Override;

/// A study as its file tells it. Scenes and methods are named by their place in the lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    pub title: String,
    pub about: String,
    /// Where the study file is; scene files are found from there.
    pub folder: PathBuf,
    pub scenes: Vec<StudyScene>,
    pub methods: Vec<Method>,
    pub experiments: Vec<Experiment>,
}

/// A scene, how its pictures are looked at, and what they are compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyScene {
    pub name: String,
    /// As the study names it, from its own folder.
    pub file: PathBuf,
    pub overrides: Vec<Override>,
    /// Layer that is compared; empty: the beauty.
    pub layer: String,
    /// The linear value that is shown as white.
    pub white: f64,
    pub ssim: SsimDomain,
    pub reference: ReferencePlan,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ReferencePlan {
    /// The exact irradiance of the closed form that the scene is.
    Exact(ClosedForm),
    /// A sum of parts, each rendered by what finds it best.
    Rendered(Vec<ReferencePart>),
}

/// `passes` passes of a layer under these settings.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferencePart {
    pub layer: String,
    pub overrides: Vec<Override>,
    pub passes: u32,
}

/// Rows of a table that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    pub name: String,
    pub about: String,
    pub scenes: Vec<usize>,
    pub methods: Vec<ExperimentMethod>,
    /// How much work a row is given.
    pub budgets: Vec<Budget>,
    pub seeds: Vec<u64>,
    pub baseline: Option<Baseline>,
    pub published: Vec<Published>,
    /// Part of the picture that is shown enlarged: x0, y0, x1, y1.
    pub crop: Option<[u32; 4]>,
    /// Part of the picture that errors are measured in.
    pub region: Option<[u32; 4]>,
}

/// A method in an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct ExperimentMethod {
    pub method: usize,
    pub bandwidth: BandwidthPlan,
}

/// Work of one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Photons or light paths of all passes together; eye paths take what the scene's settings say.
    Photons(u64),
    /// As many photons as it takes for the maps to hold so many: what misses the specular objects does not count.
    Stored(u64),
    /// Passes until so many seconds are over. `photons` is the number in each pass.
    Seconds { seconds: f64, photons: Option<u64> },
}

impl Budget {
    /// Photons of the row, under a time budget those of a pass.
    pub fn photons(self) -> Option<u64> {
        match self {
            Budget::Photons(n) | Budget::Stored(n) => Some(n),
            Budget::Seconds { photons, .. } => photons,
        }
    }
}

impl Experiment {
    /// The budgets that differ for `method`: eye paths do without photons.
    pub fn budgets_of(&self, method: &Method) -> Vec<Budget> {
        let mut budgets = self.budgets.clone();
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
}

/// Which bandwidths a method is given.
#[derive(Clone, Debug, PartialEq)]
pub enum BandwidthPlan {
    /// What the settings say.
    AsSet,
    /// The best ones, searched between these ends.
    Best { low: f64, high: f64 },
    /// Each of these.
    Each(Vec<f64>),
    /// value · (photons / at)^exponent.
    Schedule { value: f64, at: f64, exponent: f64 },
}

/// The row that an experiment's other rows are measured against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baseline {
    pub method: usize,
    /// Where there are several numbers of photons.
    pub photons: Option<u64>,
}

/// A published result of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Published {
    pub method: usize,
    pub photons: Option<u64>,
    pub rmse: Option<f64>,
    pub ssim: Option<f64>,
}
