//! The files that a run has read and written, so that none of them is written over by the same run.
//!
//! The one idea: a file is known by its identity (device, number and time of birth), not by its name, so that a link, a
//! second hard link or a name in other letters is no way around. Every reader opens files in one place and notes them here,
//! every writer asks here; a command need not remember to. Nothing is noted unless a [`Run`] is open: a library user writes
//! where he says.

use std::collections::{HashMap, hash_map::DefaultHasher};
use std::fs::Metadata;
use std::hash::{Hash, Hasher};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Use that a run has made of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Read,
    Written,
}

/// Files that the open runs have read and written, by a hash of the file's identity: a study reads millions of files.
#[derive(Debug, Default)]
struct Known {
    runs: usize,
    files: Option<HashMap<u64, Use>>,
}

static KNOWN: Mutex<Known> = Mutex::new(Known { runs: 0, files: None });

fn known() -> MutexGuard<'static, Known> {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A run of the program, while it lasts: the files that are read and written meanwhile are noted.
#[derive(Debug)]
pub struct Run(());

impl Run {
    /// Begins one.
    pub fn begin() -> Run {
        let mut known = known();
        known.runs += 1;
        known.files.get_or_insert_default();
        Run(())
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let mut known = known();
        known.runs -= 1;
        if known.runs == 0 {
            known.files = None;
        }
    }
}

/// Hash of the identity of a file; `None` of what is no file.
fn identity(path: &Path, meta: &Metadata) -> Option<u64> {
    if !meta.is_file() {
        return None;
    }
    let mut hash = DefaultHasher::new();
    place(path, meta)?.hash(&mut hash);
    // Where the file system knows it, a file that takes the number of one that is gone is another.
    meta.created().ok().hash(&mut hash);
    Some(hash.finish())
}

#[cfg(unix)]
fn place(_: &Path, meta: &Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    Some((meta.dev(), meta.ino()))
}

/// The path that the system has for it: links and letters of either case are one, hard links are not.
#[cfg(not(unix))]
fn place(path: &Path, _: &Metadata) -> Option<std::path::PathBuf> {
    path.canonicalize().ok()
}

fn note(path: &Path, meta: &Metadata, used: Use) {
    if let Some(files) = &mut known().files
        && let Some(identity) = identity(path, meta)
    {
        files.insert(identity, used);
    }
}

/// Notes a file that has been opened to be read.
pub(crate) fn read(path: &Path, meta: &Metadata) {
    note(path, meta, Use::Read);
}

/// Notes the file behind standard input, where there is one.
#[cfg(unix)]
pub(crate) fn read_stdin() {
    use std::os::fd::AsFd;
    let file = std::io::stdin().as_fd().try_clone_to_owned().map(std::fs::File::from);
    if let Ok(meta) = file.and_then(|file| file.metadata()) {
        read(Path::new(""), &meta);
    }
}

#[cfg(not(unix))]
pub(crate) fn read_stdin() {}

/// Notes a file that has been written.
pub(super) fn written(path: &Path) {
    if let Ok(meta) = std::fs::metadata(path) {
        note(path, &meta, Use::Written);
    }
}

/// Why a file may not be written over, where it may not.
pub(super) fn keeps(path: &Path, meta: &Metadata) -> Option<&'static str> {
    let used = known().files.as_ref().and_then(|files| files.get(&identity(path, meta)?).copied());
    used.map(|used| match used {
        Use::Read => "this command reads it, and does not write over its own input; name another file",
        Use::Written => "this command has written another result there; name a file for each",
    })
}
