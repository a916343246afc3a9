//! Where a picture will go: checked before the rendering starts, so that no hour is lost to a typing error.

use std::path::{Path, PathBuf};

use super::atomic::{folder_of, temporary_beside};
use super::error::WriteError;

/// File formats of pictures, chosen by the name's ending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Exr,
    Png,
}

impl Format {
    /// The format that the ending of `path` names.
    pub fn of(path: &Path) -> Result<Format, WriteError> {
        match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
            Some("exr") => Ok(Format::Exr),
            Some("png") => Ok(Format::Png),
            _ => Err(WriteError::UnknownExtension { path: path.to_owned() }),
        }
    }
}

/// A file that can be written, as far as one can know before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    path: PathBuf,
    format: Format,
}

impl Target {
    /// Checks the ending, the folder (made if `make_path`) and that a file can be created in it.
    pub fn picture(path: &Path, make_path: bool) -> Result<Target, WriteError> {
        let format = Format::of(path)?;
        probe(path, make_path)?;
        Ok(Target { path: path.to_owned(), format })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
    pub fn format(&self) -> Format {
        self.format
    }
}

/// Checks that a file `path` can be created.
///
/// # Errors
/// The folder is missing (it is made if `make_path`), `path` is a folder, or the folder takes no new file.
pub fn probe(path: &Path, make_path: bool) -> Result<(), WriteError> {
    let cannot = |source| WriteError::CannotCreate { path: path.to_owned(), source };
    let folder = folder_of(path);
    if path.is_dir() || path.file_name().is_none() {
        return Err(WriteError::IsFolder { path: path.to_owned() });
    }
    if !folder.exists() {
        if !make_path {
            return Err(WriteError::FolderMissing { path: path.to_owned(), folder });
        }
        std::fs::create_dir_all(&folder).map_err(cannot)?;
    }
    temporary_beside(path).and_then(|file| file.close()).map_err(cannot)
}
