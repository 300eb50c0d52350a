//! The files of a finished study: written beside their place, moved there when all are whole, the manifest
//! last.

use std::collections::HashMap;
use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use hmac_sha256::Hash as Sha256;
use serde::{Deserialize, Serialize};

use super::StudyError;
use super::journal::{Journal, Lock};
use super::plan::{Hashed, Plan};
use crate::input::{Source, hex};
use crate::output::{self, Beside, Place};
use crate::words::csv::unguarded;
use crate::words::reason;

/// Name of the manifest.
pub const MANIFEST: &str = "manifest.json";
/// Every file that a study writes, the manifest last.
pub const FILES: [&str; 7] =
    ["results.csv", "results.parquet", "errors.csv", "inputs.csv", "summary.json", "summary.svg", MANIFEST];
/// Most files whose hash is remembered.
const KEPT: usize = 4096;

/// What a finished study was made of, and what it has written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// What was studied.
    pub plan: Plan,
    /// Robots that could not be worked on.
    pub broken: u64,
    /// Rows of the results.
    pub rows: u64,
    /// The files written, with their hashes; `inputs.csv` has the hash of every requirement and motion.
    pub outputs: Vec<Hashed>,
}

/// The plan of the finished study in a folder, where there is one.
///
/// # Errors
/// There is a manifest that is not one of a study.
pub fn manifest_of(out: &Path) -> Result<Option<Plan>, StudyError> {
    read_manifest(out).map(|m| m.map(|m| m.plan))
}

/// The manifest in a folder, where there is one.
///
/// # Errors
/// It cannot be read, or is not one of a study of this version.
pub fn read_manifest(out: &Path) -> Result<Option<Manifest>, StudyError> {
    let path = out.join(MANIFEST);
    match fs::read_to_string(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(StudyError::file("read", &path, &error)),
        Ok(text) => serde_json::from_str(&text).map(Some).map_err(|_| {
            StudyError::Argument(format!("`{}` is not the manifest of a study of this version", path.display()))
        }),
    }
}

/// Whether every file that the results were made of is what it was.
///
/// # Errors
/// One is not.
pub fn inputs_unchanged(out: &Path, base: &Path) -> Result<(), StudyError> {
    let path = out.join("inputs.csv");
    let fail = |e: csv::Error| StudyError::Argument(format!("cannot read `{}`: {e}", path.display()));
    let mut reader = csv::Reader::from_path(&path).map_err(fail)?;
    let mut hashes: HashMap<String, Option<String>> = HashMap::new();
    for row in reader.records() {
        let row = row.map_err(fail)?;
        let (file, hash) = (unguarded(row.get(1).unwrap_or_default()), row.get(2).unwrap_or_default());
        if hashes.len() >= KEPT {
            hashes.clear();
        }
        let read = || Source::read(&base.join(file)).ok().map(|s| s.sha256());
        if hashes.entry(file.to_string()).or_insert_with(read).as_deref() != Some(hash) {
            return Err(StudyError::Argument(format!(
                "the results are finished, but `{file}` has changed since; start again with `--force`"
            )));
        }
    }
    Ok(())
}

/// The first file in a folder that has the name of a result.
pub fn there(out: &Path) -> Option<&'static str> {
    FILES.into_iter().find(|name| out.join(name).symlink_metadata().is_ok())
}

/// That results may be replaced: a study has written what is there.
///
/// # Errors
/// It has not: somebody else's file would be lost.
pub fn check_own(out: &Path) -> Result<(), StudyError> {
    let Some(name) = there(out) else { return Ok(()) };
    // Of an earlier version the manifest alone says so.
    let of_study = |text: Vec<u8>| {
        let manifest: Option<serde_json::Value> = serde_json::from_slice(&text).ok();
        manifest
            .is_some_and(|m| m.get("outputs").is_some() && m.get("plan").is_some_and(|p| p.get("gearwise").is_some()))
    };
    if Lock::is_marked(out) || Journal::is_in(out) || fs::read(out.join(MANIFEST)).is_ok_and(of_study) {
        return Ok(());
    }
    Err(StudyError::Argument(format!(
        "`{}` was not written by a study and is left as it is: a study writes a file of this name; \
         name another folder for the results, or move it away",
        out.join(name).display()
    )))
}

/// Takes the files of a study away, the manifest first.
///
/// # Errors
/// One cannot be removed.
pub fn remove(out: &Path) -> Result<(), StudyError> {
    FILES.iter().rev().try_for_each(|name| output::remove(&out.join(name))).map_err(StudyError::Argument)
}

/// A file beside its place. Unless it is [placed](place), it goes.
pub struct Part {
    name: &'static str,
    target: PathBuf,
    file: BufWriter<Beside>,
    hash: Sha256,
}

impl Part {
    /// Begins a file of a folder.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn new(out: &Path, name: &'static str) -> Result<Part, StudyError> {
        let target = out.join(name);
        let file = Place::of(&target).and_then(|place| Beside::alone(&place));
        let file = file.map_err(|why| StudyError::Argument(format!("cannot write `{}`: {why}", target.display())))?;
        Ok(Part { name, target, file: BufWriter::with_capacity(1 << 16, file), hash: Sha256::new() })
    }

    /// An error of writing it.
    pub fn fail(&self, error: impl std::fmt::Display) -> StudyError {
        StudyError::Argument(format!("cannot write `{}`: {error}", self.target.display()))
    }
}

impl Write for Part {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.file.write(bytes).map_err(worded)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush().map_err(worded)
    }
}

/// An error of the system in our words, for writers that tell it on.
fn worded(error: std::io::Error) -> std::io::Error {
    std::io::Error::new(error.kind(), reason(&error))
}

/// Writes all parts to the disk; their names and hashes.
///
/// # Errors
/// The disk is full, or fails.
pub fn seal(parts: &mut [Part]) -> Result<Vec<Hashed>, StudyError> {
    let mut sealed = Vec::new();
    for part in parts {
        let done = part.file.flush().and_then(|()| part.file.get_mut().sync());
        done.map_err(|e| part.fail(reason(&e)))?;
        sealed.push(Hashed { file: part.name.into(), sha256: hex(&part.hash.finalize()) });
    }
    Ok(sealed)
}

/// Takes an old manifest away: what is written next is not what it says.
///
/// # Errors
/// It cannot be removed.
pub fn unsettle(out: &Path) -> Result<(), StudyError> {
    output::remove(&out.join(MANIFEST)).map_err(StudyError::Argument)
}

/// Moves sealed parts to their places, in order.
///
/// # Errors
/// One cannot be moved.
pub fn place(parts: &mut [Part]) -> Result<(), StudyError> {
    for part in parts {
        part.file.get_mut().place().map_err(|e| part.fail(reason(&e)))?;
    }
    Ok(())
}
