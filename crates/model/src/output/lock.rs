//! One process at a time at a file that is read, changed and written again.
//!
//! The one idea: a lock is a hidden file beside the one that it is of, which the system keeps for one process until that
//! ends, however it ends. The file itself cannot be the lock: writing it replaces it. The last one takes the lock file away.

use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use super::{folder_of, followed};
use crate::words::reason;

/// Most times that a lock is taken anew because the one before took its file away.
const MAX_TRIES: usize = 100_000;

/// Keeps other processes from files, until it is dropped.
#[derive(Debug, Default)]
pub struct Locks(Vec<Lock>);

#[derive(Debug)]
struct Lock {
    path: PathBuf,
    _file: File,
}

impl Locks {
    /// Waits until no other process has the lock of a file, in whose folder it can write. Where the file system knows no
    /// locks, nothing is kept away.
    ///
    /// # Errors
    /// The lock's file cannot be made, in words.
    pub fn take(&mut self, path: &Path) -> Result<(), String> {
        let fail = |why: String| format!("cannot lock `{}`: {why}", path.display());
        let target = followed(path).map_err(fail)?;
        let folder = folder_of(&target);
        let nowhere = |_| fail(format!("there is no folder `{}`", folder.display()));
        let name = target.file_name().ok_or_else(|| fail("it has no name".into()))?.to_string_lossy();
        let path = folder.canonicalize().map_err(nowhere)?.join(format!(".{name}.lock"));
        // Two names of one file have one lock, which would wait for itself.
        if self.0.iter().any(|lock| lock.path == path) {
            return Ok(());
        }
        for _ in 0..MAX_TRIES {
            let file = OpenOptions::new().create(true).truncate(false).write(true).open(&path);
            let file = file.map_err(|error| fail(reason(&error)))?;
            // A wait that is interrupted begins again.
            if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) && file.lock().is_err() {
                continue;
            }
            if is_at(&file, &path) {
                self.0.push(Lock { path, _file: file });
                return Ok(());
            }
        }
        Err(fail("other processes take it all the time".into()))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // It is still held: who waits for it sees that it is gone, and makes another.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// True if an open file is the one that a path leads to.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let same = |there: std::fs::Metadata| {
        file.metadata().is_ok_and(|own| (own.dev(), own.ino()) == (there.dev(), there.ino()))
    };
    std::fs::metadata(path).is_ok_and(same)
}

/// What is open is not taken away here.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}
