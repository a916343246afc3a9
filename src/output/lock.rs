//! One process at a time on a file: an advisory lock on `FILE.lock`, which the system takes back when its holder dies.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// A lock that could not be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LockError {
    #[error("{}: in use by {holder}; wait for it, or use another file", path.display())]
    Held { path: PathBuf, holder: String },
    #[error("{}: cannot lock: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
}

/// Held until it is dropped.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    file: File,
}

/// Times that the lock's file may vanish under us before we give up: each is another process that just ended.
const ATTEMPTS: usize = 16;

impl Lock {
    /// Locks `path`, which itself need not exist and is not touched.
    ///
    /// # Errors
    /// Another process holds it (the message says which), or the folder takes no file.
    pub fn of(path: &Path) -> Result<Lock, LockError> {
        let failed = |source| LockError::Io { path: path.to_owned(), source };
        let mut name = path.as_os_str().to_owned();
        name.push(".lock");
        let lock_path = PathBuf::from(name);
        for _ in 0..ATTEMPTS {
            let mut file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&lock_path)
                .map_err(failed)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(LockError::Held { path: path.to_owned(), holder: holder(&mut file) });
                }
                Err(TryLockError::Error(source)) => return Err(failed(source)),
            }
            // The last holder may have removed the file between our opening and locking it.
            if is_still_there(&file, &lock_path) {
                file.set_len(0).map_err(failed)?;
                file.rewind().map_err(failed)?;
                write!(file, "process {} on {}", std::process::id(), host()).map_err(failed)?;
                return Ok(Lock { path: lock_path, file });
            }
        }
        Err(failed(io::Error::other("its lock changes hands all the time")))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Removed while still held, so that nobody's new lock is taken away. A file that stays is no harm.
        let _ = fs::remove_file(&self.path);
        let _ = self.file.unlock();
    }
}

fn is_still_there(file: &File, path: &Path) -> bool {
    let same = |a: fs::Metadata, b: fs::Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
    file.metadata().ok().zip(fs::metadata(path).ok()).is_some_and(|(a, b)| same(a, b))
}

fn holder(file: &mut File) -> String {
    let mut text = String::new();
    match file.read_to_string(&mut text) {
        Ok(n) if n > 0 => text,
        _ => "another process".to_owned(),
    }
}

fn host() -> String {
    fs::read_to_string("/proc/sys/kernel/hostname").map_or_else(|_| "this machine".to_owned(), |s| s.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_is_told_who_holds_it_and_the_third_gets_it() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("a.pdpart");
        let first = Lock::of(&path).expect("free");
        let refused = Lock::of(&path).expect_err("held").to_string();
        assert!(refused.contains(&format!("process {}", std::process::id())), "{refused}");
        drop(first);
        assert_eq!(fs::read_dir(folder.path()).expect("folder").count(), 0, "nothing stays");
        Lock::of(&path).expect("free again");
        // What a killed process leaves behind does not lock.
        fs::write(folder.path().join("a.pdpart.lock"), "process 1 on mars").expect("a file");
        Lock::of(&path).expect("its holder is gone");
    }
}
