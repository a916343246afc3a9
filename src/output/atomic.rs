//! Files that are there whole or not at all: written under a temporary name in the same folder, synced, renamed.

use std::ffi::OsString;
use std::fs::{File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::error::WriteError;

/// Folder that holds `path`; `.` for a bare name.
pub(super) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn temporary_prefix(path: &Path) -> OsString {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".tmp-");
    name
}

/// An empty file beside `path`, named after it, that removes itself unless it is persisted.
pub(super) fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    let name = temporary_prefix(path);
    // The user's umask decides who may read a picture; temporary files are private by default.
    tempfile::Builder::new().prefix(&name).permissions(Permissions::from_mode(0o666)).tempfile_in(folder_of(path))
}

/// Removes what writers of `path` that were killed left beside it. Only for whoever may be sure to be its only writer.
pub fn sweep(path: &Path) {
    let prefix = temporary_prefix(path);
    let Ok(entries) = std::fs::read_dir(folder_of(path)) else { return };
    for entry in entries.flatten() {
        if entry.file_name().as_encoded_bytes().starts_with(prefix.as_encoded_bytes()) {
            // Rubbish that stays is no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Puts `bytes` into the file `path`. Whoever looks sees the old file or the new one, never a part, also after a
/// crash; on error the old file stays and nothing else is left behind.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_with(path, |file| file.write_all(bytes))
}

/// The same for what `fill` writes.
pub fn write_with(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), WriteError> {
    let failed = |source| WriteError::Failed { path: path.to_owned(), source };
    let mut file =
        temporary_beside(path).map_err(|source| WriteError::CannotCreate { path: path.to_owned(), source })?;
    fill(file.as_file_mut()).map_err(failed)?;
    file.as_file().sync_all().map_err(failed)?;
    file.persist(path).map_err(|e| failed(e.error))?;
    // The rename itself is on disk once the folder is.
    File::open(folder_of(path)).and_then(|folder| folder.sync_all()).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(folder)
            .expect("test folder")
            .map(|e| e.expect("entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_replaces_the_old_one_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("a.exr");
        write(&path, b"old").expect("first write");
        write(&path, b"new").expect("second write");
        assert_eq!(std::fs::read(&path).expect("readable"), b"new");
        assert_eq!(names(folder.path()), ["a.exr"]);
    }

    /// A rename onto a folder fails after everything was written: the temporary file must go.
    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("taken");
        std::fs::create_dir(&path).expect("folder in the way");
        assert!(matches!(write(&path, b"x"), Err(WriteError::Failed { .. })));
        assert_eq!(names(folder.path()), ["taken"]);
        let missing = folder.path().join("no/such/folder.exr");
        assert!(matches!(write(&missing, b"x"), Err(WriteError::CannotCreate { .. })));
    }

    /// Two writers of the same name: a reader sees one of the two files whole, at any time.
    #[test]
    fn readers_never_see_a_part() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("shared");
        let size = 1 << 16;
        write(&path, &vec![0u8; size]).expect("first write");
        std::thread::scope(|scope| {
            for value in 1..=2u8 {
                let path = &path;
                scope.spawn(move || (0..20).for_each(|_| write(path, &vec![value; size]).expect("write")));
            }
            for _ in 0..200 {
                let bytes = std::fs::read(&path).expect("always there");
                assert_eq!(bytes.len(), size);
                assert!(bytes.iter().all(|&b| b == bytes[0]));
            }
        });
        assert_eq!(names(folder.path()), ["shared"]);
    }
}
