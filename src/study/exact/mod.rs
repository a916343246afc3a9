//! Pictures that no renderer made: the exact radiance of scenes whose light has a closed form.
//!
//! All numbers are read from the scene, and a scene that is not the closed form in some point is refused with that point.

pub mod ball_lens;
mod ball_lens_scene;
pub mod numerics;
pub mod pixels;
pub mod ring;
mod ring_scene;
mod scene_reading;
pub mod wave;
mod wave_scene;

use crate::scene::Scene;

/// A kind of scene with a closed form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosedForm {
    /// Parallel light through a sine wave of glass onto a plane: [`wave`].
    Wave,
    /// Parallel light over the rim of a mirror cylinder onto its floor: [`ring`].
    Ring,
    /// Parallel light through a glass ball onto a plane: [`ball_lens`].
    BallLens,
}

impl ClosedForm {
    pub const NAMES: &'static [&'static str] = &["wave", "ring", "ball_lens"];

    pub const fn name(self) -> &'static str {
        match self {
            ClosedForm::Wave => "wave",
            ClosedForm::Ring => "ring",
            ClosedForm::BallLens => "ball_lens",
        }
    }
    pub fn from_name(text: &str) -> Option<ClosedForm> {
        match text {
            "wave" => Some(ClosedForm::Wave),
            "ring" => Some(ClosedForm::Ring),
            "ball_lens" => Some(ClosedForm::BallLens),
            _ => None,
        }
    }
}

/// Why a scene is not the closed form.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct NotThisForm(pub String);

/// The caustic layer of a scene, L S⁺ D, without error.
#[derive(Clone, Debug, PartialEq)]
pub struct ExactPicture {
    pub width: u32,
    pub height: u32,
    /// Mean radiance over each pixel, linear Rec.709, row by row.
    pub radiance: Vec<[f64; 3]>,
    /// Change of each value against a quadrature of twice the step: more than its own error.
    pub error: Vec<[f64; 3]>,
}

impl ExactPicture {
    /// From two quadratures, `coarse` with twice the step of `fine`.
    fn new([width, height]: [u32; 2], fine: Vec<[f64; 3]>, coarse: &[[f64; 3]]) -> ExactPicture {
        let change = |(a, b): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|i| (a[i] - b[i]).abs());
        let error = fine.iter().zip(coarse).map(change).collect();
        ExactPicture { width, height, radiance: fine, error }
    }
}

/// The exact picture of `scene`.
///
/// # Errors
/// Says in which point the scene is not `form`.
pub fn picture(form: ClosedForm, scene: &Scene) -> Result<ExactPicture, NotThisForm> {
    match form {
        ClosedForm::Wave => wave_scene::picture(scene),
        ClosedForm::Ring => ring_scene::picture(scene),
        ClosedForm::BallLens => ball_lens_scene::picture(scene),
    }
}
