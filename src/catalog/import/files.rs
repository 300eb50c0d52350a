//! Imported rows as catalogue files: one for each maker, checked by the catalogue's own reader
//! before anything is written, and written whole or not at all.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Import, MotorSheet};
use crate::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention, Terminals, word};
use crate::catalog::{Catalog, FIELDS, GEAR_FIELDS, Gear, GearKind, SourceKind};
use crate::input::{InputError, Source};
use crate::output::{Beside, Place};
use crate::units;
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
        let mut motors: BTreeMap<String, Vec<&MotorSheet>> = BTreeMap::new();
        for row in &self.motors {
            motors.entry(file_name(&row.item.identity.manufacturer)).or_default().push(&row.item);
        }
        let mut gears: BTreeMap<String, Vec<&Gear>> = BTreeMap::new();
        for row in &self.gears {
            let maker = if row.place.is_none() { &row.item.id } else { &row.item.manufacturer };
            gears.entry(file_name(maker)).or_default().push(&row.item);
        }
        let database = self.database.to_lowercase();
        let path = |folder: &str, maker: &str| Path::new(folder).join(format!("{database}-{maker}.csv"));
        let heading = |what: &str| {
            format!("# {what} of the public database {}, imported by gearwise. {}\n", self.database, self.licence)
        };
        let mut files = Vec::new();
        for (maker, rows) in motors {
            let text = heading("Motors") + &motor_text(&rows);
            files.push(CatalogFile { path: path("motors", &maker), text, rows: rows.len() });
        }
        for (maker, rows) in gears {
            let fits = "# In fits, mm-14* stands for every imported motor whose id begins so.\n";
            let text = heading("Gears") + fits + &gear_text(&rows);
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

/// The shortest text that reads back as the same number.
pub(crate) fn cell(value: Option<f64>) -> String {
    match value {
        Some(v) if v != 0.0 && !(1e-4..1e7).contains(&v.abs()) => format!("{v:e}"),
        Some(v) => v.to_string(),
        None => String::new(),
    }
}

/// Text as one line. That no spreadsheet runs it is seen to where CSV is written.
pub(crate) fn safe(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ").trim().into()
}

pub(crate) fn head(name: &str, kind: &units::Kind) -> String {
    if kind.needs_unit() { format!("{name} [{}]", kind.si) } else { name.into() }
}

fn csv(header: &[String], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    crate::words::csv::csv_text(&header, rows)
}

fn motor_text(motors: &[&MotorSheet]) -> String {
    let fields: Vec<_> = FIELDS.iter().filter(|f| motors.iter().any(|m| (f.get)(&m.sheet).is_some())).collect();
    let texts = ["id", "manufacturer", "model", "commutation", "terminals", "current", "back_emf_convention"];
    let mut header: Vec<String> = texts.map(String::from).to_vec();
    header.extend(fields.iter().map(|f| head(f.name, f.kind)));
    // The reader wants the column even where no row has the number.
    if !fields.iter().any(|f| f.name == "resistance") {
        header.push("resistance [ohm]".into());
    }
    let width = header.len();
    header.extend(["source", "source_kind", "note"].map(String::from));
    let rows = motors.iter().map(|motor| {
        let (identity, conventions) = (&motor.identity, &motor.conventions);
        let mut row = vec![
            identity.id.clone(),
            safe(&identity.manufacturer),
            safe(&identity.model),
            word(Commutation::NAMES, &conventions.commutation).into(),
            word(Terminals::NAMES, &conventions.terminals).into(),
            word(CurrentConvention::NAMES, &conventions.current).into(),
            conventions.back_emf.map_or("", |c| word(BackEmfConvention::NAMES, &c)).into(),
        ];
        row.extend(fields.iter().map(|f| cell((f.get)(&motor.sheet).map(|p| p.value))));
        row.resize(width, String::new());
        row.extend([
            safe(&identity.source),
            word(SourceKind::NAMES, &identity.source_kind).into(),
            safe(&identity.note),
        ]);
        row
    });
    csv(&header, rows)
}

fn gear_text(gears: &[&Gear]) -> String {
    let columns: Vec<_> = GEAR_FIELDS.iter().filter(|f| gears.iter().any(|g| (f.get)(g).is_some())).collect();
    let mut header: Vec<String> = ["id", "manufacturer", "model", "kind", "stages"].map(String::from).to_vec();
    header.extend(columns.iter().map(|f| head(f.name, f.kind)));
    header.extend(["fits", "source", "source_kind", "note"].map(String::from));
    let rows = gears.iter().map(|gear| {
        let mut row = vec![
            gear.id.clone(),
            safe(&gear.manufacturer),
            safe(&gear.model),
            word(GearKind::NAMES, &gear.kind).into(),
            gear.stages.map_or_else(String::new, |s| s.to_string()),
        ];
        row.extend(columns.iter().map(|f| cell((f.get)(gear))));
        row.extend([
            gear.fits.join(";"),
            safe(&gear.source),
            word(SourceKind::NAMES, &gear.source_kind).into(),
            safe(&gear.note),
        ]);
        row
    });
    csv(&header, rows)
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
        file.write(bytes).map_err(|e| fail(reason(&e)))?;
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
        assert_eq!(csv(&["model".into()], [vec![safe("=1+1\n")]]), "model\n'=1+1\n");
        assert_eq!(safe("EC-4pole 22"), "EC-4pole 22");
        assert_eq!((file_name("Allied Motion").as_str(), file_name("../..").as_str()), ("allied-motion", "other"));
        for value in [0.28, 3e-10, 2.0000000000000003e-6, 1e17, 0.0, 65.7222222222222] {
            assert_eq!(cell(Some(value)).parse::<f64>(), Ok(value));
        }
    }
}
