//! Where a study puts its files and what it runs on.

use std::path::Path;

use super::reference::Shelf;
use crate::render::progress::Progress;

/// Where a study puts its files and what it runs on.
pub struct Place<'a> {
    /// The report's folder.
    pub folder: &'a Path,
    pub references: Shelf<'a>,
    pub threads: usize,
    pub progress: &'a dyn Progress,
}
