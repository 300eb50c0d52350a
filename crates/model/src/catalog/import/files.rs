//! Imported rows as catalogue files: one for each maker, checked by the catalogue's own reader
//! before anything is written, and written whole or not at all.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Import;
use crate::catalog::row::{MotorRow, csv_text};
use crate::catalog::{Catalog, Gear};
use crate::input::{InputError, Source};
use crate::output::{Beside, Place};
use crate::words::reason;

/// A catalogue file to be written.
#[derive(Debug)]
pub struct CatalogFile {
    /// Its path below the output folder.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// How many rows it has.
    pub rows: usize,
}

impl Import {
    /// The rows as catalogue files: `motors/<database>-<maker>.csv` and `gears/<database>-<maker>.csv`.
    ///
    /// # Errors
    /// What the catalogue's reader would not accept: a mistake of the importer, found before the user's
    /// next command finds it.
    pub fn catalog_files(&self) -> Result<Vec<CatalogFile>, Vec<InputError>> {
        let mut motors: BTreeMap<String, Vec<MotorRow>> = BTreeMap::new();
        for row in &self.motors {
            motors.entry(file_name(&row.item.manufacturer)).or_default().push(safe_motor(&row.item));
        }
        let mut gears: BTreeMap<String, Vec<Gear>> = BTreeMap::new();
        for row in &self.gears {
            let maker = if row.place.is_none() { &row.item.id } else { &row.item.manufacturer };
            gears.entry(file_name(maker)).or_default().push(safe_gear(&row.item));
        }
        let database = self.database.to_lowercase();
        let path = |folder: &str, maker: &str| Path::new(folder).join(format!("{database}-{maker}.csv"));
        let heading = |what: &str| {
            format!("# {what} of the public database {}, imported by gearwise. {}\n", self.database, self.licence)
        };
        let mut files = Vec::new();
        for (maker, rows) in motors {
            let text = heading("Motors") + &csv_text(&rows, &["back_emf_convention", "note"]);
            files.push(CatalogFile { path: path("motors", &maker), text, rows: rows.len() });
        }
        for (maker, rows) in gears {
            let fits = "# In fits, mm-14* means every imported motor whose id begins so.\n";
            let text = heading("Gears") + fits + &csv_text(&rows, &["stages", "fits", "note"]);
            files.push(CatalogFile { path: path("gears", &maker), text, rows: rows.len() });
        }
        let source = |f: &CatalogFile| Arc::new(Source::new(f.path.display().to_string(), f.text.clone()));
        Catalog::from_sources(files.iter().map(source).collect())?;
        Ok(files)
    }
}

fn file_name(maker: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let name: String = maker.chars().take(60).map(safe).collect();
    let name = name.trim_matches('-');
    if name.is_empty() { "other".into() } else { name.into() }
}

/// Text as one line. That no spreadsheet runs it is seen to where CSV is written.
pub fn safe(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ").trim().into()
}

fn safe_motor(row: &MotorRow) -> MotorRow {
    MotorRow {
        manufacturer: safe(&row.manufacturer),
        model: safe(&row.model),
        source: safe(&row.source),
        note: safe(&row.note),
        ..row.clone()
    }
}

fn safe_gear(gear: &Gear) -> Gear {
    Gear {
        manufacturer: safe(&gear.manufacturer),
        model: safe(&gear.model),
        source: safe(&gear.source),
        note: safe(&gear.note),
        ..gear.clone()
    }
}

/// Why files were not written. None of them was.
#[derive(Debug)]
pub enum WriteError {
    /// Files that are there already.
    Exist(Vec<PathBuf>),
    /// What could not be done to which path.
    Io(&'static str, PathBuf, String),
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WriteError::Exist(paths) => {
                let names: Vec<String> = paths.iter().take(5).map(|p| format!("`{}`", p.display())).collect();
                let more = paths.len().saturating_sub(5);
                let more = if more > 0 { format!(" and {more} more") } else { String::new() };
                let are = if paths.len() == 1 { "is" } else { "are" };
                write!(f, "{}{more} {are} there already and nothing was written; `--force` replaces", names.join(", "))
            }
            WriteError::Io(doing, path, error) => {
                write!(f, "cannot {doing} `{}`, and nothing was written: {error}", path.display())
            }
        }
    }
}

impl std::error::Error for WriteError {}

/// Writes the files below `out`, all or none: each goes to a temporary file beside its place first, and
/// takes its place only when all are on the disk.
///
/// # Errors
/// A file is there already and `replace` is not set, or the disk refuses; then what was there before is
/// still there.
pub fn write(out: &Path, files: &[CatalogFile], replace: bool) -> Result<Vec<PathBuf>, WriteError> {
    let targets: Vec<PathBuf> = files.iter().map(|f| out.join(&f.path)).collect();
    let there: Vec<PathBuf> = targets.iter().filter(|t| t.symlink_metadata().is_ok()).cloned().collect();
    if !there.is_empty() && !replace {
        return Err(WriteError::Exist(there));
    }
    let mut staged = Staged::default();
    for (file, target) in files.iter().zip(&targets) {
        staged.add(target, file.text.as_bytes())?;
    }
    staged.commit()?;
    Ok(targets)
}

/// Files on their way: what is not committed is taken back when this is dropped.
#[derive(Debug, Default)]
struct Staged {
    waiting: Vec<Beside>,
    // What stood at a place before, under a second name, and its place.
    aside: Vec<(PathBuf, PathBuf)>,
    placed: Vec<PathBuf>,
}

impl Staged {
    fn add(&mut self, target: &Path, bytes: &[u8]) -> Result<(), WriteError> {
        let folder = target.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(folder).map_err(|e| WriteError::Io("create the folder", folder.into(), reason(&e)))?;
        let fail = |why| WriteError::Io("write", target.into(), why);
        let mut file = Place::of(target).and_then(|place| Beside::new(&place)).map_err(fail)?;
        file.write_all(bytes).and_then(|()| file.sync()).map_err(|e| fail(reason(&e)))?;
        self.waiting.push(file);
        Ok(())
    }

    fn commit(mut self) -> Result<(), WriteError> {
        for file in &mut self.waiting {
            let target = file.target().to_path_buf();
            let fail = |e: io::Error| WriteError::Io("write", target.clone(), reason(&e));
            if target.exists() {
                let old = second_name(&target);
                fs::hard_link(&target, &old).or_else(|_| fs::copy(&target, &old).map(|_| ())).map_err(fail)?;
                self.aside.push((old, target.clone()));
            }
            file.place().map_err(fail)?;
            self.placed.push(target);
        }
        self.placed.clear();
        for (old, _) in self.aside.drain(..) {
            let _ = fs::remove_file(old);
        }
        Ok(())
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        // After a success there is nothing to take back.
        for path in &self.placed {
            let _ = fs::remove_file(path);
        }
        for (old, target) in &self.aside {
            let _ = fs::rename(old, target);
        }
    }
}

/// A name in the same folder that nothing has and no catalogue reader takes for a catalogue.
fn second_name(target: &Path) -> PathBuf {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let numbered = |number: usize| target.with_file_name(format!(".{name}.{}-{number}.old", std::process::id()));
    let mut number = 0;
    while numbered(number).symlink_metadata().is_ok() {
        number += 1;
    }
    numbered(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_half_way_is_taken_back() {
        let folder = tempfile::tempdir().unwrap();
        let targets = ["a.csv", "b.csv", "c.csv"].map(|name| folder.path().join(name));
        fs::write(&targets[0], "old").unwrap();
        let mut staged = Staged::default();
        for target in &targets {
            staged.add(target, b"new").unwrap();
        }
        assert_eq!(fs::read_to_string(&targets[0]).unwrap(), "old");
        // Someone puts a folder where the last file should go.
        fs::create_dir(&targets[2]).unwrap();
        assert!(staged.commit().is_err());
        assert_eq!(fs::read_to_string(&targets[0]).unwrap(), "old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "neither new nor temporary files are left");
    }

    #[test]
    fn cells_and_names_are_safe() {
        assert_eq!(safe("=1+1\n"), "=1+1");
        assert_eq!(crate::words::csv::csv_text(&["model"], [vec![safe("=1+1\n")]]), "model\n'=1+1\n");
        assert_eq!(safe("EC-4pole 22"), "EC-4pole 22");
        assert_eq!((file_name("Allied Motion").as_str(), file_name("../..").as_str()), ("allied-motion", "other"));
    }
}
