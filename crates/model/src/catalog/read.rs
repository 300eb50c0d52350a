//! Catalogue files: which kind of rows a file holds, the version of its columns, and its rows.
//!
//! The one idea: kinds of files are one table, [`KINDS`]. A new kind of row is a [`Row`](super::row::Row) and one entry there.

use std::collections::HashMap;
use std::ops::Range as Span;
use std::sync::Arc;

use super::alternative::written;
use super::family::{self, Family};
use super::fitted;
use super::gear::Gear;
use super::module::Module;
use super::motor::Motor;
use super::row::{self, Cells, CsvCells, MotorRow, TomlCells};
use crate::input::csv::{Column, Table};
use crate::input::kind::{self, FileKind as Of};
use crate::input::{Form, InputError, Problem, Section, Source};

/// The version of the columns that this program reads. Within a version columns are only added.
pub const VERSION: u32 = 1;

/// The rows of a file, in its order.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub(super) motors: Vec<Motor>,
    pub(super) gears: Vec<Gear>,
    pub(super) families: Vec<Family>,
    pub(super) modules: Vec<Module>,
    pub(super) alternatives: Vec<written::Written>,
}

/// A kind of catalogue file.
pub(super) struct FileKind {
    /// The folder that such files stand in.
    pub(super) folder: &'static str,
    /// The list of tables that holds such rows in TOML.
    table: &'static str,
    /// Its header has all of these columns,
    with: &'static [&'static str],
    /// and none of these.
    without: &'static [&'static str],
    columns: fn() -> Vec<Column>,
    /// Reads a row; its id.
    read: fn(&dyn Cells, &mut Rows) -> Option<String>,
}

/// Every kind of file; the first whose header fits, so that the last takes what no other does.
pub(super) const KINDS: &[FileKind] = &[ALTERNATIVES, MODULES, GEARS, MOTORS];

const ALTERNATIVES: FileKind = FileKind {
    folder: "alternatives",
    table: "alternative",
    with: &["column", "value"],
    without: &[],
    columns: written::columns,
    read: |cells, rows| {
        rows.alternatives.extend(written::read(cells));
        // A row has as many as there are.
        None
    },
};

const MODULES: FileKind = FileKind {
    folder: "modules",
    table: "module",
    with: &["ratio", "drive"],
    without: &[],
    columns: module_columns,
    read: |cells, rows| {
        rows.modules.push(row::module(cells)?);
        rows.modules.last().map(|m| m.id.clone())
    },
};

const GEARS: FileKind = FileKind {
    folder: "gears",
    table: "gear",
    with: &["ratio"],
    without: &["torque_constant", "terminals"],
    columns: gear_columns,
    read: |cells, rows| {
        rows.gears.push(row::gear(cells)?);
        rows.gears.last().map(|g| g.id.clone())
    },
};

const MOTORS: FileKind = FileKind {
    folder: "motors",
    table: "motor",
    with: &[],
    without: &[],
    columns: motor_columns,
    read: |cells, rows| {
        rows.motors.push(row::motor(cells, MotorRow::default(), &[])?);
        rows.motors.last().map(|m| m.id.clone())
    },
};

/// The columns that a motor catalogue may have, in the order of the documentation.
pub fn motor_columns() -> Vec<Column> {
    row::csv_columns::<MotorRow>()
}

/// The columns that a gear catalogue may have.
pub fn gear_columns() -> Vec<Column> {
    row::csv_columns::<Gear>()
}

/// The columns that a catalogue of modules may have.
pub fn module_columns() -> Vec<Column> {
    row::csv_columns::<Module>()
}

/// Reads the motors of one CSV file.
///
/// # Errors
/// Every mistake of the file.
pub fn read_motors(source: &Arc<Source>) -> Result<Vec<Motor>, InputError> {
    read_table(source, &MOTORS).map(|rows| rows.motors)
}

/// Reads the gears of one CSV file.
///
/// # Errors
/// Every mistake of the file.
pub fn read_gears(source: &Arc<Source>) -> Result<Vec<Gear>, InputError> {
    read_table(source, &GEARS).map(|rows| rows.gears)
}

/// Reads the modules of one CSV file.
///
/// # Errors
/// Every mistake of the file.
pub fn read_modules(source: &Arc<Source>) -> Result<Vec<Module>, InputError> {
    read_table(source, &MODULES).map(|rows| rows.modules)
}

/// Reads the rows of one file: a table of CSV, or of TOML a fitted actuator, a family of gears, or lists of rows, `[[motor]]`
/// and `[[gear]]`.
///
/// # Errors
/// Every mistake of the file.
pub(super) fn read_rows(source: &Arc<Source>) -> Result<Rows, InputError> {
    const WANTED: [Of; 6] = [Of::Motors, Of::Gears, Of::Fitted, Of::Family, Of::Table, Of::Empty];
    rows_of(source).map_err(|error| kind::instead(error, &WANTED))
}

fn rows_of(source: &Arc<Source>) -> Result<Rows, InputError> {
    if !fitted::is_fitted_file(source) {
        return read_table(source, kind_of(source));
    }
    check_version(source)?;
    Form::read(source, |root| {
        if KINDS.iter().any(|kind| root.holds(kind.table) && root.is_list(kind.table)) {
            return Some(read_lists(root));
        }
        if family::is_family(root) {
            return family::read(root).map(|family| Rows { families: vec![family], ..Rows::default() });
        }
        let motor = fitted::read_choice(root)?;
        Some(Rows { motors: vec![motor], ..Rows::default() })
    })
}

/// The kind of a CSV file, by its header.
fn kind_of(source: &Source) -> &'static FileKind {
    let header = source.text().lines().find(|l| !l.starts_with('#') && !l.trim().is_empty()).unwrap_or("");
    let names: Vec<&str> = header
        .split(',')
        .map(|c| c.split('[').next().unwrap_or("").trim())
        .map(|n| row::column_of(n).unwrap_or(n))
        .collect();
    let fits = |kind: &&FileKind| {
        kind.with.iter().all(|c| names.contains(c)) && !kind.without.iter().any(|c| names.contains(c))
    };
    KINDS.iter().find(fits).unwrap_or(&MOTORS)
}

fn read_table(source: &Arc<Source>, kind: &FileKind) -> Result<Rows, InputError> {
    check_version(source)?;
    let (mut problems, mut rows) = (Vec::new(), Rows::default());
    if let Some(table) = Table::read_with(source, (kind.columns)(), row::ALIASES, &mut problems) {
        let mut seen = HashMap::new();
        for row in 0..table.len() {
            let id = (kind.read)(&CsvCells::new(&table, row, &mut problems), &mut rows);
            let Some(id) = id else { continue };
            let span = table.cell_span(row, "id");
            problems.extend(again(&mut seen, &id, row, span, "below the header"));
        }
    }
    InputError::unless_empty(source, problems)?;
    Ok(rows)
}

fn read_lists(root: &Section) -> Rows {
    let mut rows = Rows::default();
    for kind in KINDS {
        let mut seen = HashMap::new();
        for (k, section) in root.sections(kind.table).into_iter().enumerate() {
            TomlCells(&section).check_names();
            if let Some(id) = (kind.read)(&TomlCells(&section), &mut rows)
                && let Some(problem) = again(&mut seen, &id, k, TomlCells(&section).span("id"), "of this file")
            {
                root.note(problem);
            }
            section.finish();
        }
    }
    rows
}

/// That an id was there before.
fn again(seen: &mut HashMap<String, usize>, id: &str, row: usize, span: Span<usize>, of: &str) -> Option<Problem> {
    let first = seen.insert(id.to_string(), row)?;
    Some(Problem::at(span, format!("duplicate id `{id}`"), format!("first in row {} {of}", first + 1)))
}

/// Looks at the first line: `# gearwise catalogue 1`. A file without it is of version 1.
///
/// # Errors
/// The version is a later one, or is no number.
pub(super) fn check_version(source: &Arc<Source>) -> Result<(), InputError> {
    let problem = match stated_version(source.text()) {
        None => return Ok(()),
        Some((_, Some(version))) if (1..=VERSION).contains(&version) => return Ok(()),
        Some((span, Some(version @ 1..))) => Problem::at(
            span,
            format!("this catalogue is of version {version}; this gearwise reads version {VERSION}"),
            "a later version",
        )
        .help("use a newer gearwise: a later version may have columns that mean something else here"),
        Some((span, _)) => Problem::at(span, "the version of a catalogue is a whole number from 1 on", "not a version")
            .help(format!("for example # gearwise catalogue {VERSION}; without the line the version is 1")),
    };
    InputError::unless_empty(source, vec![problem])
}

/// The version in the first line and where it stands; inside, `None` where it is no number. Any other line is a comment.
fn stated_version(text: &str) -> Option<(Span<usize>, Option<u32>)> {
    let line = text.lines().next()?;
    let mut words = line.strip_prefix('#')?.split_whitespace();
    let is = |word: Option<&str>, names: &[&str]| word.is_some_and(|w| names.iter().any(|n| w.eq_ignore_ascii_case(n)));
    if !is(words.next(), &["gearwise"]) || !is(words.next(), &["catalogue", "catalog"]) {
        return None;
    }
    let word = words.next().filter(|w| w.contains(|c: char| c.is_ascii_digit()))?;
    let start = line.len() - line[line.find(word)?..].len();
    Some((start..start + word.len(), word.parse().ok()))
}
