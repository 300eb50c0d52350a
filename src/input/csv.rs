//! A CSV file read as a table: the header names each column and its unit, every cell knows its
//! place.

use crate::words::csv::unguarded;
use std::collections::HashMap;
use std::ops::Range as Span;
use std::sync::Arc;

use super::{Problem, Range, Source, limits};
use crate::units::{self, Kind, Unit};

/// What a column holds.
#[derive(Debug, Clone, Copy)]
pub enum Content {
    /// Text as it stands.
    Text,
    /// A number with a dimension; its unit stands in the header.
    Quantity(&'static Kind, Range),
    /// The ± of the named column: in a unit of the same kind, or in per cent of the value.
    Tolerance(&'static Kind),
    /// A whole number from 1 on.
    Count,
}

/// A column that a reader knows.
#[derive(Debug, Clone)]
pub struct Column {
    /// Its name in the header, without unit.
    pub name: String,
    /// What it holds.
    pub content: Content,
    /// Whether a file must have it.
    pub required: bool,
}

/// A cell that holds a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// The value in SI; for a tolerance in per cent, the fraction.
    pub value: f64,
    /// Whether it is a fraction of another value (a tolerance column in `%`).
    pub relative: bool,
}

#[derive(Debug)]
struct Head {
    // Its place in the file, and in the list of known columns.
    column: usize,
    known: usize,
    unit: Option<Unit>,
    relative: bool,
}

/// A CSV file with its header understood. Cells are read by (row, column name).
#[derive(Debug)]
pub struct Table {
    source: Arc<Source>,
    columns: Vec<Column>,
    // Index into `columns` by name, position in the file by column.
    heads: HashMap<String, Head>,
    records: Vec<csv::StringRecord>,
    starts: Vec<usize>,
    width: usize,
    header: usize,
}

/// Mistakes of a file after which its columns are not read on.
const MOST_SHOWN: usize = 40;
/// So many rows with too many cells are a slip each; if there are more, they have one cause.
const FEW_RAGGED: usize = 3;

/// That the cells of a header are separated by something else than commas: what is wrong, and what to do.
pub(crate) fn other_separator<'a>(header: impl Iterator<Item = &'a str> + Clone) -> Option<(String, &'static str)> {
    for (separator, word) in [(';', "semicolons"), ('\t', "tabs")] {
        let found: usize = header.clone().map(|cell| cell.matches(separator).count()).sum();
        if found > 0 && found >= header.clone().count() {
            return Some((
                format!("the cells of this file are separated by {word}"),
                "save it with commas between cells and points in numbers (a spreadsheet set to English does)",
            ));
        }
    }
    None
}

impl Table {
    /// Reads the header and splits the records. Columns must be among `columns`.
    pub fn read(source: &Arc<Source>, columns: Vec<Column>, problems: &mut Vec<Problem>) -> Option<Table> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(source.text().as_bytes());
        let (mut records, mut starts) = (Vec::new(), Vec::new());
        let mut record = csv::StringRecord::new();
        loop {
            match reader.read_record(&mut record) {
                Ok(false) => break,
                Ok(true) => {
                    starts.push(past_comments(source.text(), record.position().map_or(0, |p| p.byte() as usize)));
                    records.push(record.clone());
                    if records.len() > limits::TABLE_ROWS + 1 {
                        let message = format!("the table has more than {} rows", limits::TABLE_ROWS);
                        problems.push(Problem::whole(message).help("split the file, or leave rows out"));
                        return None;
                    }
                }
                Err(error) => {
                    problems.push(Problem::whole(format!("not a CSV file: {error}")));
                    return None;
                }
            }
        }
        let mut table =
            Table { source: source.clone(), columns, heads: HashMap::new(), records, starts, width: 0, header: 0 };
        if table.records.is_empty() {
            let names: Vec<&str> = table.columns.iter().filter(|c| c.required).map(|c| c.name.as_str()).collect();
            problems.push(
                Problem::at(0..0, "the file is empty: it has no header row", "expected a header row")
                    .help(format!("the first row names the columns, at least: {}", names.join(", "))),
            );
            return None;
        }
        let before = problems.len();
        if let Some((message, help)) = other_separator(table.records[0].iter()) {
            problems.push(Problem::at(table.record_span(0), message, "expected commas").help(help));
            return None;
        }
        table.read_header(problems);
        let header = table.records.remove(0);
        let start = table.starts.remove(0);
        table.width = header.len();
        table.header = start;
        if problems.len() > before {
            return None;
        }
        if table.records.is_empty() {
            problems.push(Problem::at(start..start, "the file has a header but no rows", "no row follows this header"));
        }
        table.remove_ragged_rows(problems);
        Some(table)
    }

    /// Notes rows whose cells do not match the header and takes them away: what their cells mean
    /// cannot be known.
    fn remove_ragged_rows(&mut self, problems: &mut Vec<Problem>) {
        let width = self.width;
        let ragged = self.records.iter().filter(|r| r.len() != width).count();
        let one_cause = ragged > FEW_RAGGED && self.records.iter().all(|r| r.len() >= width);
        if one_cause {
            let first = self.records.iter().position(|r| r.len() != width).unwrap_or(0);
            let message = format!(
                "this row has {} cells, the header has {width}; {ragged} rows of {} have too many",
                self.records[first].len(),
                self.records.len()
            );
            problems.push(
                Problem::at(line_span(self.source.text(), self.starts[first]), message, "the first of them")
                    .help("numbers have a decimal point, not a comma; text with commas needs double quotes"),
            );
        }
        for (record, start) in self.records.iter().zip(&self.starts).filter(|_| !one_cause) {
            if record.len() != width {
                let message = format!("this row has {} cells, the header has {width}", record.len());
                problems.push(
                    Problem::at(line_span(self.source.text(), *start), message, "the cells do not match the header")
                        .help("a comma too many or too few? Text with commas needs double quotes"),
                );
            }
        }
        let good: Vec<bool> = self.records.iter().map(|r| r.len() == width).collect();
        let mut keep = good.iter();
        self.starts.retain(|_| *keep.next().unwrap_or(&false));
        self.records.retain(|r| r.len() == width);
    }

    fn read_header(&mut self, problems: &mut Vec<Problem>) {
        let header = self.records[0].clone();
        for (position, cell) in header.iter().enumerate() {
            let span = self.cell_span_in(0, position);
            let (name, unit) = split_unit(unguarded(cell));
            let Some(known) = self.columns.iter().position(|c| c.name == name) else {
                let shown: String = name.chars().take(60).collect();
                problems.push(
                    Problem::at(span, format!("unknown column `{shown}`"), "not a column of this kind of file")
                        .suggest(&shown, self.columns.iter().map(|c| c.name.as_str())),
                );
                if problems.len() > 20 {
                    return;
                }
                continue;
            };
            let head = match header_unit(&self.columns[known], unit) {
                Ok((unit, relative)) => Head { column: position, known, unit, relative },
                Err((message, help)) => {
                    problems.push(
                        Problem::at(span, format!("column `{name}`: {message}"), "the unit stands in brackets")
                            .help(help),
                    );
                    Head { column: position, known, unit: None, relative: false }
                }
            };
            if self.heads.insert(name.to_string(), head).is_some() {
                problems.push(Problem::at(
                    self.cell_span_in(0, position),
                    format!("column `{name}` stands twice"),
                    "second time",
                ));
            }
        }
        for column in self.columns.iter().filter(|c| c.required) {
            if !self.heads.contains_key(&column.name) {
                let example = match column.content {
                    Content::Quantity(kind, _) if kind.needs_unit() => format!("{} [{}]", column.name, kind.si),
                    _ => column.name.clone(),
                };
                let span = self.record_span(0);
                problems.push(
                    Problem::at(span, format!("column `{}` is missing", column.name), "not in this header")
                        .help(format!("add a column `{example}`")),
                );
            }
        }
    }

    /// The span of the header row.
    pub fn header_span(&self) -> std::ops::Range<usize> {
        line_span(self.source.text(), self.header)
    }

    /// Number of rows below the header.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Whether the file has the column.
    pub fn has(&self, name: &str) -> bool {
        self.heads.contains_key(name)
    }

    /// The text of a cell, without the `'` that keeps a spreadsheet from running it; `None` where it is blank or the
    /// file does not have the column.
    pub fn text(&self, row: usize, name: &str) -> Option<&str> {
        let head = self.heads.get(name)?;
        self.records[row].get(head.column).map(unguarded).filter(|t| !t.is_empty())
    }

    /// The number in a cell, in SI; `None` where it is blank. What is not a number of the column's
    /// kind and range is noted.
    pub fn number(&self, row: usize, name: &str, problems: &mut Vec<Problem>) -> Option<Number> {
        let head = self.heads.get(name)?;
        let text = self.records[row].get(head.column).filter(|t| !t.is_empty())?;
        let column = &self.columns[head.known];
        let (range, expected) = match column.content {
            Content::Quantity(_, range) => (range, range.expected()),
            Content::Tolerance(_) => (Range::NonNegative, Range::NonNegative.expected()),
            Content::Count => (Range::AtLeastOne, "a whole number, at least 1"),
            Content::Text => return None,
        };
        let value = match (units::number_value(text), column.content, &head.unit) {
            (Ok(value), Content::Quantity(kind, _), Some(unit)) => unit.to_si(value, kind),
            (Ok(value), Content::Tolerance(_), Some(unit)) => value * unit.scale(),
            (Ok(value), _, _) => value,
            (Err(error), ..) => {
                let mut problem = Problem::at(
                    self.cell_span(row, name),
                    format!("`{name}`: {}", error.message(&units::RATIO)),
                    format!("expected {expected}"),
                );
                if text.contains(',') {
                    problem = problem.help("numbers have a decimal point, not a comma");
                } else if text.contains(char::is_alphabetic)
                    && !text.to_lowercase().contains("nan")
                    && !text.to_lowercase().contains("inf")
                {
                    problem =
                        problem.help("the unit stands in the header, in brackets; an unknown value is a blank cell");
                } else {
                    problem = problem.help("leave the cell blank where the value is not known");
                }
                problems.push(problem);
                return None;
            }
        };
        let whole = !matches!(column.content, Content::Count) || value.fract() == 0.0;
        if !range.contains(value) || !whole || !units::is_sane(value) {
            let mut problem = Problem::at(
                self.cell_span(row, name),
                format!("`{name}` is out of range"),
                format!("expected {expected}"),
            );
            problem.help = range.help(value);
            problems.push(problem);
            return None;
        }
        Some(Number { value, relative: head.relative })
    }

    /// One of several words; `None` where the cell is blank.
    pub fn choice<T: Copy>(
        &self,
        row: usize,
        name: &str,
        choices: &[(&'static str, T)],
        problems: &mut Vec<Problem>,
    ) -> Option<T> {
        let text = self.text(row, name)?;
        let found = choices.iter().find(|(word, _)| *word == text);
        if found.is_none() {
            let text = text.chars().take(60).collect::<String>();
            problems.push(
                Problem::at(
                    self.cell_span(row, name),
                    format!("`{name}` cannot be `{text}`"),
                    "not one of the choices",
                )
                .suggest(&text, choices.iter().map(|(word, _)| *word)),
            );
        }
        found.map(|(_, value)| *value)
    }

    /// The numbers of a column without gaps, in SI; `None` where the file does not have the column. A blank cell is
    /// noted with `gap`, which says what has none.
    pub fn whole_column(&self, name: &str, gap: &str, problems: &mut Vec<Problem>) -> Option<Vec<f64>> {
        if !self.has(name) {
            return None;
        }
        let mut values = Vec::with_capacity(self.len());
        for row in 0..self.len() {
            let before = problems.len();
            match self.number(row, name, problems) {
                Some(number) => values.push(number.value),
                None if problems.len() == before => {
                    problems.push(Problem::at(self.cell_span(row, name), format!("`{name}` is blank"), gap));
                }
                None => {}
            }
            if problems.len() > MOST_SHOWN {
                break;
            }
        }
        Some(values)
    }

    /// The bytes of a cell, or of its row where the column is absent.
    pub fn cell_span(&self, row: usize, name: &str) -> Span<usize> {
        match self.heads.get(name) {
            Some(head) => find_cell(self.source.text(), self.starts[row], head.column),
            None => self.row_span(row),
        }
    }

    /// The bytes of a row, without its line end.
    pub fn row_span(&self, row: usize) -> Span<usize> {
        line_span(self.source.text(), self.starts[row])
    }

    fn cell_span_in(&self, record: usize, position: usize) -> Span<usize> {
        find_cell(self.source.text(), self.starts[record], position)
    }

    fn record_span(&self, record: usize) -> Span<usize> {
        line_span(self.source.text(), self.starts[record])
    }
}

/// The csv reader's position is that before comments and blank lines: the record starts after them.
fn past_comments(text: &str, mut at: usize) -> usize {
    let bytes = text.as_bytes();
    loop {
        match bytes.get(at) {
            Some(b'\n' | b'\r') => at += 1,
            Some(b'#') => at += text[at..].find('\n').unwrap_or(text.len() - at),
            _ => return at,
        }
    }
}

fn line_span(text: &str, start: usize) -> Span<usize> {
    let end = text[start..].find(['\n', '\r']).map_or(text.len(), |p| start + p);
    start..end
}

/// The span of the `position`-th cell of the record that starts at `start`, quotes respected.
pub(crate) fn find_cell(text: &str, start: usize, position: usize) -> Span<usize> {
    let bytes = text.as_bytes();
    let (mut at, mut cell, mut begin, mut quoted) = (start, 0, start, false);
    while at < bytes.len() {
        match bytes[at] {
            b'"' => quoted = !quoted,
            b',' | b'\n' | b'\r' if !quoted => {
                if cell == position || bytes[at] != b',' {
                    break;
                }
                cell += 1;
                begin = at + 1;
            }
            _ => {}
        }
        at += 1;
    }
    let raw = &text[begin..at];
    let lead = raw.len() - raw.trim_start().len();
    begin + lead..begin + raw.trim_end().len().max(lead)
}

fn split_unit(cell: &str) -> (&str, Option<&str>) {
    match cell.split_once('[') {
        Some((name, rest)) => (name.trim(), Some(rest.trim().trim_end_matches(']').trim())),
        None => (cell.trim(), None),
    }
}

type HeaderProblem = (String, String);

fn header_unit(column: &Column, unit: Option<&str>) -> Result<(Option<Unit>, bool), HeaderProblem> {
    let (kind, tolerance) = match column.content {
        Content::Text | Content::Count => {
            return match unit {
                None => Ok((None, false)),
                Some(unit) => Err((format!("has no unit, but `{unit}` is given"), format!("write `{}`", column.name))),
            };
        }
        Content::Quantity(kind, _) => (kind, false),
        Content::Tolerance(kind) => (kind, true),
    };
    let example = kind.example.split_once(' ').map_or("", |(_, unit)| unit);
    match unit {
        Some("%") if tolerance => Ok((Some(units::unit_of("%", &units::RATIO).expect("per cent is a unit")), true)),
        None if kind.needs_unit() => Err((
            units::UnitError::MissingUnit.message(kind),
            format!("write the unit in brackets, for example `{} [{example}]`", column.name),
        )),
        None => Ok((None, false)),
        Some(unit) => match units::unit_of(unit, kind) {
            Ok(unit) => Ok((Some(unit), false)),
            Err(error) => Err((error.message(kind), format!("for example `{} [{example}]`", column.name))),
        },
    }
}
