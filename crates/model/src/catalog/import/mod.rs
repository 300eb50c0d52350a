//! Public databases turned into catalogue files.
//!
//! The one idea of this room: an importer reads a foreign format and hands over rows in the
//! catalogue's own terms, together with a remark for everything that was refused, assumed or left
//! out; [`files`] makes catalogue files of any importer's rows. A new importer is one file here and
//! one line in [`IMPORTERS`].

pub mod files;
pub use files::safe;
pub mod mgdb;

use std::path::Path;

use super::Gear;
use super::row::MotorRow;
use crate::input::{InputError, Problem, Source};

/// A foreign format that can be read.
pub struct Importer {
    /// What a user calls it.
    pub name: &'static str,
    /// What it reads, in one line.
    pub about: &'static str,
    /// Reads a folder. Fails with every mistake that leaves a whole file unread; a row that cannot be
    /// taken is a remark.
    pub read: fn(&Path) -> Result<Import, Vec<InputError>>,
}

/// Every importer.
pub const IMPORTERS: &[Importer] = &[Importer {
    name: "mgdb",
    about: "Motor-Gearbox Database (github.com/ekrimsk/MGDB): *_motors.csv, *_gearboxes.csv, *_compatibility.csv",
    read: mgdb::read,
}];

/// What a database holds, in the catalogue's terms.
#[derive(Debug)]
pub struct Import {
    /// What the database is called.
    pub database: &'static str,
    /// What its licence lets one do with the rows, in a sentence for the head of each file.
    pub licence: &'static str,
    /// The files that were read, in their order.
    pub files: Vec<FileRead>,
    /// The motors that were taken.
    pub motors: Vec<Row<MotorRow>>,
    /// The gears that were taken.
    pub gears: Vec<Row<Gear>>,
    /// How many pairs of motor and gear the database calls compatible.
    pub compatible_pairs: usize,
    /// What was assumed of every row.
    pub assumptions: Vec<&'static str>,
    /// What was refused, assumed or left out, file by file and line by line.
    pub remarks: Vec<Remark>,
}

impl Import {
    /// The remarks of one kind, in their order.
    pub fn remarks_of(&self, kind: RemarkKind) -> impl Iterator<Item = &Remark> {
        self.remarks.iter().filter(move |r| r.kind == kind)
    }
}

/// A file of the database.
#[derive(Debug)]
pub struct FileRead {
    /// Its path as it was opened.
    pub file: String,
    /// What its rows are.
    pub holds: Holds,
    /// Rows below the header.
    pub rows: usize,
    /// Rows that were taken.
    pub taken: usize,
}

/// What the rows of a file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// Motors.
    Motors,
    /// Gears.
    Gears,
    /// Which gears go with which motors.
    Compatibility,
}

impl Holds {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Holds::Motors => "motors",
            Holds::Gears => "gears",
            Holds::Compatibility => "compatibility",
        }
    }
}

/// A row that was taken.
#[derive(Debug)]
pub struct Row<T> {
    /// What the database calls it.
    pub key: String,
    /// Where it stands; `None` for a row that the importer adds.
    pub place: Option<Place>,
    /// What it says.
    pub item: T,
}

/// A place in a file of the database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file's path as it was opened.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

/// What became of something in the database.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RemarkKind {
    /// A row or an entry that was not taken.
    Refused,
    /// Something that the database does not say was assumed.
    Assumed,
    /// Something that the catalogue has no place for.
    LeftOut,
}

/// Something that the user of the imported rows should know.
#[derive(Debug, Clone)]
pub struct Remark {
    /// What became of it.
    pub kind: RemarkKind,
    /// Code of the reason, the same for all remarks of one reason.
    pub code: &'static str,
    /// Where it stands.
    pub place: Place,
    /// Key of the row, where there is one.
    pub key: String,
    /// The reason, with numbers.
    pub message: String,
}

/// Where the lines of a file begin, so that a place is found without reading the text again.
#[derive(Debug)]
pub(super) struct Lines<'s> {
    source: &'s Source,
    starts: Vec<usize>,
}

impl<'s> Lines<'s> {
    pub(super) fn new(source: &'s Source) -> Lines<'s> {
        let starts = std::iter::once(0).chain(source.text().match_indices('\n').map(|(at, _)| at + 1)).collect();
        Lines { source, starts }
    }

    /// The place of a byte of the text.
    pub(super) fn place(&self, byte: usize) -> Place {
        let byte = byte.min(self.source.text().len());
        let line = self.starts.partition_point(|start| *start <= byte);
        let column = self.source.text()[self.starts[line - 1]..byte].chars().count() + 1;
        Place { file: self.source.name().to_string(), line, column }
    }

    /// One remark that refuses what all the problems are about, at the first of them.
    pub(super) fn refused(&self, code: &'static str, key: &str, problems: &[Problem]) -> Remark {
        let at = problems.iter().filter_map(|p| p.span.as_ref()).map(|s| s.start).min().unwrap_or(0);
        let said = |p: &Problem| match p.label.is_empty() {
            true => p.message.clone(),
            false => format!("{} ({})", p.message, p.label),
        };
        let message = problems.iter().map(said).collect::<Vec<_>>().join("; ");
        let key = key.chars().take(100).collect();
        Remark { kind: RemarkKind::Refused, code, place: self.place(at), key, message }
    }
}

/// An error about a folder as a whole.
fn folder_error(folder: &Path, problem: Problem) -> InputError {
    let source = std::sync::Arc::new(Source::new(folder.display().to_string(), ""));
    InputError { source, problems: vec![problem] }
}
