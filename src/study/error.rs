//! Why a study came to an end.

use std::path::PathBuf;

use super::exact::NotThisForm;
use super::metric::MetricError;
use crate::output::{ReadError, WriteError};
use crate::render::{BadCamera, RenderError};
use crate::scene::error::Problems;
use crate::world::WorldError;

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The study's file, or a scene under the settings of a row.
    #[error("{0}")]
    Problems(#[from] Problems),
    #[error(transparent)]
    World(#[from] WorldError),
    #[error(transparent)]
    Camera(#[from] BadCamera),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error("scene `{scene}` is not the closed form `{form}`: {source}")]
    NotThisForm { scene: String, form: &'static str, source: NotThisForm },
    #[error("scene `{scene}`, {which}: {source}")]
    Metric { scene: String, which: String, source: MetricError },
    #[error("{}: {reason}; remove the file, or choose another folder", path.display())]
    ReferenceRefused { path: PathBuf, reason: String },
    #[error("scene `{scene}`: {what} is not within the picture of {} x {} pixels", size[0], size[1])]
    OutsideThePicture { scene: String, what: &'static str, size: [u32; 2] },
    #[error("scene `{scene}`: the reference holds none of the pixels that are compared")]
    NothingToCompare { scene: String },
    #[error(
        "scene `{scene}`: no photon is stored, so that no number of them can be; give `photons` instead of `stored`"
    )]
    NothingStored { scene: String },
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Write(#[from] WriteError),
}
