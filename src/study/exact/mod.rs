//! Pictures that no renderer made: the exact radiance of scenes whose light has a closed form.
//!
//! All numbers are read from the scene, and a scene that is not the closed form in some point is refused with that point.

pub mod numerics;
pub mod wave;
mod wave_scene;

use crate::scene::Scene;

/// A kind of scene with a closed form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosedForm {
    /// Parallel light through a sine wave of glass onto a plane: [`wave`].
    Wave,
}

impl ClosedForm {
    pub const NAMES: &'static [&'static str] = &["wave"];

    pub const fn name(self) -> &'static str {
        match self {
            ClosedForm::Wave => "wave",
        }
    }
    pub fn from_name(text: &str) -> Option<ClosedForm> {
        (text == "wave").then_some(ClosedForm::Wave)
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

/// The exact picture of `scene`.
///
/// # Errors
/// Says in which point the scene is not `form`.
pub fn picture(form: ClosedForm, scene: &Scene) -> Result<ExactPicture, NotThisForm> {
    match form {
        ClosedForm::Wave => wave_scene::picture(scene),
    }
}
