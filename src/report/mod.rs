//! A study's tables and pictures become one page that needs nothing but a browser, and files for other programs.

mod csv;
mod page;
mod picture;
mod plot;
mod table;

use std::path::{Path, PathBuf};

use crate::output::atomic;
use crate::output::{ReadError, WriteError};
use crate::study::results::Results;

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("{}: cannot read: {source}; run the study again", path.display())]
    Picture { path: PathBuf, source: std::io::Error },
    #[error("{}: its size is not the reference's; remove it and run the study again", path.display())]
    SizesDiffer { path: PathBuf },
    #[error("the plot of {what} cannot be drawn: {reason}")]
    Plot { what: String, reason: String },
}

/// Writes `index.html`, `results.json` and `results.csv` into `folder`, and a map of the errors beside each picture
/// that the tables name; the pictures are found there.
pub fn write(folder: &Path, results: &Results) -> Result<(), ReportError> {
    let json = folder.join("results.json");
    let unfit = |error: serde_json::Error| WriteError::Unfit { path: json.clone(), reason: error.to_string() };
    let text = serde_json::to_string_pretty(results).map_err(unfit)? + "\n";
    atomic::write(&json, text.as_bytes())?;
    atomic::write(&folder.join("results.csv"), csv::table(results).as_bytes())?;
    let page = page::page(folder, results)?;
    Ok(atomic::write(&folder.join("index.html"), page.as_bytes())?)
}
