//! What a study found, as plain tables: `results.json` holds exactly this, and the page is drawn from nothing else.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Number of the layout of `results.json`.
pub const SCHEMA: u32 = 1;

/// Channel of a reference's EXR: 1 in pixels that are compared, 0 in others; all are without it.
pub const COMPARED: &str = "compared";

/// A finished study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    pub schema: u32,
    pub title: String,
    pub about: String,
    /// Program, version and commit that rendered.
    pub program: String,
    pub backend: String,
    pub threads: usize,
    pub scenes: Vec<SceneResult>,
    pub experiments: Vec<ExperimentResult>,
}

/// A scene, how its pictures are looked at, and what they are compared with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneResult {
    pub name: String,
    /// The scene file as the study names it.
    pub file: PathBuf,
    pub width: u32,
    pub height: u32,
    /// Layer that is compared; empty: the beauty.
    pub layer: String,
    /// The linear value that is shown as white: errors "shown" and SSIM see clamp(value / white, 0, 1).
    pub white: f64,
    /// How the display range is encoded for SSIM: `linear` or `srgb`.
    pub ssim_domain: String,
    pub reference: ReferenceResult,
}

/// The picture that a scene's renders are compared with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceResult {
    /// What it is, in words: the closed form's name, or methods and their work.
    pub about: String,
    /// Root mean square standard error (or, of a closed form, quadrature error) of its shown values over the pixels.
    pub standard_error: f64,
    /// Pixels that are compared; the others show what the reference cannot hold.
    pub pixels_compared: u64,
    /// Files below the report's folder, without ending: `.exr` and `.png` exist of each.
    pub image: PathBuf,
    pub seconds: f64,
}

/// Rows that belong together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExperimentResult {
    pub name: String,
    pub about: String,
    /// Part of the picture that the page shows enlarged: x0, y0, x1, y1.
    pub crop: Option<[u32; 4]>,
    /// Part of the picture that errors are measured in; whole if none.
    pub region: Option<[u32; 4]>,
    pub rows: Vec<Row>,
    pub curves: Vec<Curve>,
    pub slopes: Vec<Slope>,
}

/// The value of a method's one free parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bandwidth {
    /// `k`, `s` or `radius`.
    pub name: String,
    pub value: f64,
}

/// One method on one scene with one number of photons, over all seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub scene: String,
    pub method: String,
    /// Photons (or light paths) of all passes together that the experiment asks for, emitted or stored; under a time
    /// budget those that were emitted. Eye paths' methods have none.
    pub photons: Option<u64>,
    /// Photons (or light paths) that the first seed emitted.
    pub photons_emitted: Option<u64>,
    /// Those of them that the first seed's maps hold: light that missed the specular objects is in no map.
    pub photons_stored: Option<u64>,
    pub passes: u32,
    /// None for methods without one.
    pub bandwidth: Option<Bandwidth>,
    /// What the bandwidth is best for: `rmse`, `ssim`, or `given`.
    pub chosen_for: String,
    /// Every setting that makes the picture again, beside the seed: `render.k=70`.
    pub settings: Vec<String>,
    /// One entry a seed.
    pub cells: Vec<Cell>,
    /// Published values of the same row by metric name (`rmse`, `ssim`), if the study file gives some.
    pub published: BTreeMap<String, f64>,
    /// This row's mean `rmse` over that of the experiment's baseline row, with its standard error.
    pub rmse_ratio: Option<Mean>,
    /// Files of the first seed's picture below the report's folder, without ending: `.exr` and `.png` exist.
    pub image: PathBuf,
}

/// One render and its errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    pub seed: u64,
    /// Wall-clock time of the render without reading the scene and writing the picture.
    pub seconds: f64,
    pub passes: u32,
    pub metrics: Metrics,
}

/// Errors against the reference, over the compared pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Of the shown values clamp(v / white, 0, 1).
    pub rmse: f64,
    /// Of linear values in units of white.
    pub rmse_linear: f64,
    pub rel_mse: f64,
    /// Of linear values in units of white.
    pub mae: f64,
    pub ssim: Option<f64>,
    /// LDR FLIP of the shown values.
    pub flip: Option<f64>,
    /// HDR FLIP of linear values.
    pub flip_hdr: Option<f64>,
}

/// A mean and its standard error; a single value has none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mean {
    pub value: f64,
    pub standard_error: Option<f64>,
}

/// Error as a function of the bandwidth: everything that a search looked at, in order of the bandwidth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    pub scene: String,
    pub method: String,
    pub photons: Option<u64>,
    /// `k`, `s` or `radius`.
    pub parameter: String,
    pub points: Vec<CurvePoint>,
    /// Index of the smallest `rmse` and of the largest `ssim`.
    pub best_rmse: usize,
    pub best_ssim: Option<usize>,
    /// Whether the smallest RMSE lies inside the range that was searched, not at its end.
    pub rmse_bracketed: bool,
    pub ssim_bracketed: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    pub bandwidth: f64,
    /// Means over the seeds.
    pub rmse: f64,
    pub ssim: Option<f64>,
}

/// A power law fitted to `rmse_linear` over photons or seconds: error ∝ x^slope.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    pub scene: String,
    pub method: String,
    /// `photons` or `seconds`.
    pub over: String,
    pub slope: f64,
    /// Half width of the slope's 95 % interval; none with fewer than three points.
    pub half_width: Option<f64>,
    /// ln error at ln x = 0.
    pub intercept: f64,
}

impl Row {
    /// Mean over the seeds of a metric; `None` where a cell has none.
    pub fn mean(&self, metric: impl Fn(&Metrics) -> Option<f64>) -> Option<Mean> {
        let values: Option<Vec<f64>> = self.cells.iter().map(|cell| metric(&cell.metrics)).collect();
        values.filter(|v| !v.is_empty()).map(|v| Mean::of(&v))
    }
    pub fn seconds(&self) -> f64 {
        self.cells.iter().map(|cell| cell.seconds).sum::<f64>() / self.cells.len().max(1) as f64
    }
}

impl Mean {
    /// Mean and standard error of independent values.
    pub fn of(values: &[f64]) -> Mean {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let square = values.iter().map(|v| (v - value).powi(2)).sum::<f64>();
        Mean { value, standard_error: (values.len() > 1).then(|| (square / (n - 1.0) / n).sqrt()) }
    }

    /// The quotient of two independent means, errors to first order.
    pub fn over(self, other: Mean) -> Mean {
        let value = self.value / other.value;
        let relative = |m: Mean| m.standard_error.map(|e| e / m.value);
        let error = relative(self).zip(relative(other)).map(|(a, b)| value.abs() * a.hypot(b));
        Mean { value, standard_error: error }
    }
}
