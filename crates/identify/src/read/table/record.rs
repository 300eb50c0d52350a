//! One row of a log file, of whatever format, and the mistakes that rows have.
//!
//! A mistake in a line of text is shown with the line, which is fetched again from the file; one in an array, with the number of
//! its row.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use csv::{ByteRecord, Position};

use gearwise_model::input::{InputError, Problem, Source};
use gearwise_model::words::shorten;

/// At most this many mistakes of a log are collected: its rows tend to share them.
const MAX_PROBLEMS: usize = 20;
/// At most this much of a line is shown in a report \[bytes\].
const MAX_LINE: u64 = 1 << 16;

/// Numbers that take the memory of a short text.
pub const TEXT_NUMBERS: usize = 4;

/// The values of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Series {
    /// Numbers; NaN is missing.
    Numbers(Vec<f64>),
    /// Time stamps, counted from the first one \[s\]; NaN is missing.
    Stamps(Vec<f64>),
    /// Texts, which can select rows; blank is missing.
    Texts(Vec<String>),
}

#[cfg(feature = "parquet")]
impl Series {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Series::Numbers(values) | Series::Stamps(values) => values.len(),
            Series::Texts(texts) => texts.len(),
        }
    }
}

/// One row.
#[derive(Debug, Clone, Copy)]
pub enum Record<'a> {
    /// A line of a text.
    Line(&'a ByteRecord),
    /// A row of arrays, counted from 0; those that no log needs are not there.
    Values {
        /// Its number.
        row: usize,
        /// The columns.
        series: &'a [Option<Series>],
    },
}

impl<'a> Record<'a> {
    /// What stands in a cell, as text; blank where nothing does.
    pub fn text(&self, at: usize) -> Cow<'a, [u8]> {
        match self {
            Record::Line(record) => Cow::Borrowed(record[at].trim_ascii()),
            Record::Values { row, series } => match &series[at] {
                Some(Series::Texts(texts)) => Cow::Borrowed(texts[*row].as_bytes().trim_ascii()),
                Some(Series::Numbers(values) | Series::Stamps(values)) if !values[*row].is_nan() => {
                    Cow::Owned(values[*row].to_string().into_bytes())
                }
                _ => Cow::Borrowed(b""),
            },
        }
    }

    /// The number in a cell; NaN where it is blank.
    ///
    /// # Errors
    /// What stands there in place of a number.
    pub fn number(&self, at: usize) -> Result<f64, &'a [u8]> {
        let text = match self {
            Record::Line(record) => record[at].trim_ascii(),
            Record::Values { row, series } => match &series[at] {
                Some(Series::Numbers(values) | Series::Stamps(values)) => return Ok(values[*row]),
                Some(Series::Texts(texts)) => texts[*row].as_bytes().trim_ascii(),
                None => b"",
            },
        };
        if text.is_empty() {
            return Ok(f64::NAN);
        }
        std::str::from_utf8(text).ok().and_then(|text| text.parse().ok()).ok_or(text)
    }

    /// Where a column is not, that is not in the file.
    pub fn nowhere(&self) -> &'static str {
        match self {
            Record::Line(_) => "not in its header",
            Record::Values { .. } => "not in this file",
        }
    }
}

/// A cell for a message.
pub fn short(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    shorten(&text).chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// The mistakes of a log with the lines that they are in.
pub struct Mistakes<'a> {
    path: &'a Path,
    lines: Vec<(usize, String)>,
    /// What is wrong.
    pub problems: Vec<Problem>,
}

impl Mistakes<'_> {
    /// None yet.
    pub fn new(path: &Path) -> Mistakes<'_> {
        Mistakes { path, lines: Vec::new(), problems: Vec::new() }
    }

    /// Whether more of them would not help.
    pub fn are_enough(&self) -> bool {
        self.problems.len() >= MAX_PROBLEMS
    }

    /// A mistake in a cell, or in the row as a whole.
    pub fn add(&mut self, record: Record, cell: Option<usize>, message: String, label: &str, help: &str) {
        let record = match record {
            Record::Line(record) => record,
            Record::Values { row, .. } => {
                let problem = Problem { label: label.into(), ..Problem::whole(format!("row {}: {message}", row + 1)) };
                return self.note(problem.help(help));
            }
        };
        let Some((number, line)) = record.position().and_then(|p| fetch(self.path, p)) else {
            return self.note(Problem::whole(message).help(help));
        };
        if self.lines.last().is_none_or(|(n, _)| *n != number) {
            self.lines.push((number, line));
        }
        let before: usize = self.lines[..self.lines.len() - 1].iter().map(|(_, l)| l.len() + 1).sum();
        let line = &self.lines[self.lines.len() - 1].1;
        let span = match cell {
            Some(position) => gearwise_model::input::csv::find_cell(line, 0, position),
            None => 0..line.len(),
        };
        self.note(Problem::at(before + span.start..before + span.end, message, label).help(help));
    }

    /// A mistake of the file, once.
    pub fn note(&mut self, problem: Problem) {
        if !self.problems.contains(&problem) {
            self.problems.push(problem);
        }
    }

    /// All of them.
    pub fn into_error(self, name: &str) -> InputError {
        InputError { source: Arc::new(Source::excerpt(name, &self.lines)), problems: self.problems }
    }
}

/// Number and text of the line in which a record starts. The position of the CSV reader is that before
/// comments and blank lines.
fn fetch(path: &Path, position: &Position) -> Option<(usize, String)> {
    let mut file = File::open(path).ok()?;
    file.seek(SeekFrom::Start(position.byte())).ok()?;
    let mut lines = BufReader::new(file);
    let mut number = usize::try_from(position.line()).ok()?;
    loop {
        let mut bytes = Vec::new();
        let count = lines.by_ref().take(MAX_LINE).read_until(b'\n', &mut bytes).ok()?;
        if count == 0 {
            return None;
        }
        let line = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        let end = line.iter().rposition(|b| !matches!(b, b'\n' | b'\r')).map_or(0, |p| p + 1);
        if end > 0 && line[0] != b'#' {
            return Some((number, String::from_utf8_lossy(&line[..end]).into_owned()));
        }
        number += 1;
    }
}
