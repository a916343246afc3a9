//! What can go wrong with files; every message names the path and what to do.

use std::path::PathBuf;

/// A picture or report that could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    #[error("{}: the ending names no picture format; end the name in .exr or .png", path.display())]
    UnknownExtension { path: PathBuf },
    #[error("{}: the folder {} does not exist; make it, or add --make-path", path.display(), folder.display())]
    FolderMissing { path: PathBuf, folder: PathBuf },
    #[error("{}: this is a folder; name a file in it", path.display())]
    IsFolder { path: PathBuf },
    #[error("{}: cannot write here: {source}; choose another place or change its permissions", path.display())]
    CannotCreate { path: PathBuf, source: std::io::Error },
    #[error("{}: writing failed: {source}; nothing was left behind, free some space or choose another place", path.display())]
    Failed { path: PathBuf, source: std::io::Error },
    #[error("{}: the picture cannot be stored in this format: {reason}", path.display())]
    Unfit { path: PathBuf, reason: String },
}

/// A checkpoint or part that could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    #[error("{}: no such file; check the name", path.display())]
    Missing { path: PathBuf },
    #[error("{}: cannot read: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{}: not a checkpoint or part of pdembree", path.display())]
    NotAPart { path: PathBuf },
    #[error("{}: written by another version of pdembree, in a layout that this one does not read; render it anew", path.display())]
    OtherLayout { path: PathBuf },
    #[error("{}: this checkpoint or part is damaged: {reason}; delete it and render it anew", path.display())]
    Damaged { path: PathBuf, reason: String },
}

/// A picture that could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    #[error("{}: no such file; check the name", path.display())]
    Missing { path: PathBuf },
    #[error("{}: cannot read: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{}: not a readable EXR: {reason}; is the file whole?", path.display())]
    Malformed { path: PathBuf, reason: String },
    #[error("{}: {reason}; convert it to one flat part first, for example with oiiotool", path.display())]
    Unsupported { path: PathBuf, reason: String },
}
