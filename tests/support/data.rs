//! Where test input is found.

use std::path::{Path, PathBuf};

/// The workspace's root.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A file of the optional shared data, `None` with a note when it is not there.
pub fn shared(relative: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("PDEMBREE_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from);
    let path = folder.join(relative);
    if path.exists() {
        Some(path)
    } else {
        eprintln!("skipped: {} is not there (PDEMBREE_DATA names the folder of the shared data)", path.display());
        None
    }
}
