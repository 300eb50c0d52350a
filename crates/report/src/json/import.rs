//! `import --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::document;
use crate::import::Written;
use gearwise_model::catalog::import::{self, Place, RemarkKind};

/// What `import` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer<'a> {
    /// The database.
    pub database: &'static str,
    /// Number of motors that were taken.
    pub motors: usize,
    /// Number of gears that were taken.
    pub gears: usize,
    /// Number of motors with a gear that the database calls compatible.
    pub compatible_pairs: usize,
    /// The files that were read.
    pub files: Vec<Read<'a>>,
    /// The files that were written.
    pub written: Vec<WrittenFile>,
    /// What is assumed of every row.
    pub assumptions_of_every_row: &'a [&'static str],
    /// Rows that were not taken.
    pub refused: Vec<Remark<'a>>,
    /// What is assumed of single rows.
    pub assumed: Vec<Remark<'a>>,
    /// What of single rows was left out.
    pub left_out: Vec<Remark<'a>>,
    /// Every row that was taken.
    pub rows: Vec<Row<'a>>,
}

/// A file that was read.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Read<'a> {
    /// The file.
    pub file: &'a str,
    /// What it holds.
    pub holds: &'static str,
    /// Number of its rows.
    pub rows: usize,
    /// How many were taken.
    pub taken: usize,
    /// How many were not.
    pub refused: usize,
}

/// A file that was written.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct WrittenFile {
    /// The file.
    pub file: String,
    /// Number of its rows.
    pub rows: usize,
}

/// What is said of a row.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Remark<'a> {
    /// The file.
    pub file: &'a str,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1.
    pub column: usize,
    /// The row's name in the database.
    pub key: &'a str,
    /// What kind of remark it is.
    pub code: &'static str,
    /// What is said.
    pub because: &'a str,
}

/// A row that was taken.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Row<'a> {
    /// `motor` or `gear`.
    pub kind: &'static str,
    /// Its id in the catalogue.
    pub id: &'a str,
    /// Its name in the database.
    pub key: &'a str,
    /// Its file.
    pub file: Option<&'a str>,
    /// Its line.
    pub line: Option<usize>,
}

/// What was taken, and what was not.
pub fn json(of: &import::Import, written: &[Written]) -> Value {
    let remarks = |kind: RemarkKind| of.remarks_of(kind).map(remark).collect();
    let motors = of.motors.iter().map(|m| row("motor", &m.key, &m.item.id, m.place.as_ref()));
    let gears = of.gears.iter().map(|g| row("gear", &g.key, &g.item.id, g.place.as_ref()));
    let answer = Answer {
        database: of.database,
        motors: of.motors.len(),
        gears: of.gears.len(),
        compatible_pairs: of.compatible_pairs,
        files: of
            .files
            .iter()
            .map(|f| Read {
                file: &f.file,
                holds: f.holds.word(),
                rows: f.rows,
                taken: f.taken,
                refused: f.rows - f.taken,
            })
            .collect(),
        written: written.iter().map(|w| WrittenFile { file: w.path.display().to_string(), rows: w.rows }).collect(),
        assumptions_of_every_row: &of.assumptions,
        refused: remarks(RemarkKind::Refused),
        assumed: remarks(RemarkKind::Assumed),
        left_out: remarks(RemarkKind::LeftOut),
        rows: motors.chain(gears).collect(),
    };
    document("import", answer)
}

fn remark(of: &import::Remark) -> Remark<'_> {
    let Place { file, line, column } = &of.place;
    Remark { file, line: *line, column: *column, key: &of.key, code: of.code, because: &of.message }
}

fn row<'a>(kind: &'static str, key: &'a str, id: &'a str, place: Option<&'a Place>) -> Row<'a> {
    Row { kind, id, key, file: place.map(|p| p.file.as_str()), line: place.map(|p| p.line) }
}
