//! A CSV file read as a table: the header names each column and its unit, every cell knows its
//! place.

use crate::words::csv::unguarded;
use std::collections::HashMap;
use std::ops::Range as Span;
use std::sync::Arc;

mod cells;

use self::cells::Cells;
use super::{Problem, Range, Source, Stated, Words, limits};
use crate::units::{self, Kind, Unit};

/// What a column holds.
#[derive(Debug, Clone, Copy)]
pub enum Content {
    /// Text as it stands.
    Text,
    /// A number with a dimension; its unit stands in the header.
    Quantity(&'static Kind, Range),
    /// The same, of which the header may also state what it refers to. Such a column may stand more than once, each time
    /// with other words; a row fills one of them.
    Stated(&'static Kind, Range, Words),
    /// Pairs of numbers `7:120 10:18`; the header has the units of both, `[N*m : s]`.
    Pairs([(&'static Kind, Range); 2]),
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
    /// What its column states of it.
    pub stated: Stated,
}

#[derive(Debug)]
struct Head {
    // Its place in the file, and in the list of known columns.
    column: usize,
    known: usize,
    unit: Option<Unit>,
    // That of the second number of pairs.
    second: Option<Unit>,
    relative: bool,
    stated: Stated,
}

/// A CSV file with its header understood. Cells are read by (row, column name).
#[derive(Debug)]
pub struct Table {
    source: Arc<Source>,
    columns: Vec<Column>,
    // The columns of each name: more than one where each states something else.
    heads: HashMap<String, Vec<Head>>,
    records: Cells,
    starts: Vec<usize>,
    width: usize,
    header: usize,
}

/// Help for a cell whose value is not known.
const LEAVE_BLANK: &str = "leave the cell blank where the value is not known";
/// Mistakes of a file after which its columns are not read on.
const MOST_SHOWN: usize = 40;
/// So many rows with too many cells are a slip each; if there are more, they have one cause.
const FEW_RAGGED: usize = 3;

/// That the cells of a header are separated by something else than commas: what is wrong, and what to do.
pub fn other_separator<'a>(header: impl Iterator<Item = &'a str> + Clone) -> Option<(String, &'static str)> {
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
        Table::read_with(source, columns, &[], problems)
    }

    /// [`Table::read`] of a file that may head columns by other names: each alias with its column.
    pub fn read_with(
        source: &Arc<Source>,
        columns: Vec<Column>,
        aliases: &[(&str, &str)],
        problems: &mut Vec<Problem>,
    ) -> Option<Table> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(source.text().as_bytes());
        if let Some(problem) = oversized(source.text()) {
            problems.push(problem);
            return None;
        }
        let (mut records, mut starts) = (Cells::default(), Vec::new());
        let mut record = csv::StringRecord::new();
        loop {
            match reader.read_record(&mut record) {
                Ok(false) => break,
                Ok(true) => {
                    starts.push(past_comments(source.text(), record.position().map_or(0, |p| p.byte() as usize)));
                    records.push(&record);
                }
                Err(error) => {
                    problems.push(Problem::whole(format!("not a CSV file: {error}")));
                    return None;
                }
            }
        }
        let mut table =
            Table { source: source.clone(), columns, heads: HashMap::new(), records, starts, width: 0, header: 0 };
        if table.records.len() == 0 {
            let names: Vec<&str> = table.columns.iter().filter(|c| c.required).map(|c| c.name.as_str()).collect();
            problems.push(
                Problem::at(0..0, "the file is empty: it has no header row", "expected a header row")
                    .help(format!("the first row names the columns, at least: {}", names.join(", "))),
            );
            return None;
        }
        let before = problems.len();
        if let Some((message, help)) = other_separator(table.records.row(0)) {
            problems.push(Problem::at(table.record_span(0), message, "expected commas").help(help));
            return None;
        }
        table.read_header(aliases, problems);
        table.width = table.records.width(0);
        table.records.remove_first();
        let start = table.starts.remove(0);
        table.header = start;
        if problems.len() > before {
            return None;
        }
        if table.is_empty() {
            problems.push(Problem::at(start..start, "the file has a header but no rows", "no row follows this header"));
        }
        table.remove_ragged_rows(problems);
        Some(table)
    }

    /// Notes rows whose cells do not match the header and takes them away: what their cells mean
    /// cannot be known.
    fn remove_ragged_rows(&mut self, problems: &mut Vec<Problem>) {
        let width = self.width;
        let ragged = self.records.widths().filter(|w| *w != width).count();
        if ragged == 0 {
            return;
        }
        let one_cause = ragged > FEW_RAGGED && self.records.widths().all(|w| w >= width);
        if one_cause {
            let first = self.records.widths().position(|w| w != width).unwrap_or(0);
            let message = format!(
                "this row has {} cells, the header has {width}; {ragged} rows of {} have too many",
                self.records.width(first),
                self.records.len()
            );
            problems.push(
                Problem::at(line_span(self.source.text(), self.starts[first]), message, "the first of them")
                    .help("numbers have a decimal point, not a comma; text with commas needs double quotes"),
            );
        }
        let rows = self.records.widths().zip(&self.starts).filter(|(found, _)| !one_cause && *found != width);
        for (found, start) in rows.take(limits::PROBLEMS) {
            let message = format!("this row has {found} cells, the header has {width}");
            problems.push(
                Problem::at(line_span(self.source.text(), *start), message, "the cells do not match the header")
                    .help("a comma too many or too few? Text with commas needs double quotes"),
            );
        }
        let mut keep = self.records.widths().map(|w| w == width).collect::<Vec<bool>>().into_iter();
        self.starts.retain(|_| keep.next() == Some(true));
        self.records.keep_of_width(width);
    }

    fn read_header(&mut self, aliases: &[(&str, &str)], problems: &mut Vec<Problem>) {
        let mut written: HashMap<&str, &str> = HashMap::new();
        for (position, cell) in self.records.row(0).enumerate() {
            let span = self.cell_span_in(0, position);
            let (headed, unit) = split_unit(unguarded(cell));
            let name = aliases.iter().find(|(alias, _)| *alias == headed).map_or(headed, |(_, column)| *column);
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
            let unknown =
                Head { column: position, known, unit: None, second: None, relative: false, stated: Stated::default() };
            let head = match header_unit(&self.columns[known], unit) {
                Ok(units) => Head { column: position, known, ..units },
                Err((message, help)) => {
                    problems.push(
                        Problem::at(span, format!("column `{name}`: {message}"), "the unit is in brackets").help(help),
                    );
                    unknown
                }
            };
            let heads = self.heads.entry(name.to_string()).or_default();
            if let Some(other) = written.insert(name, headed).filter(|other| *other != headed) {
                let span = find_cell(self.source.text(), self.starts[0], position);
                let message = format!("`{other}` and `{headed}` are the same column, `{name}`");
                problems.push(Problem::at(span, message, "second time").help("leave one of the two out"));
            } else if heads.iter().any(|other| other.stated == head.stated) {
                problems.push(Problem::at(
                    find_cell(self.source.text(), self.starts[0], position),
                    format!("duplicate column `{name}`"),
                    "second time",
                ));
            }
            heads.push(head);
        }
        for column in self.columns.iter().filter(|c| c.required) {
            if !self.heads.contains_key(&column.name) {
                let example = match column.content {
                    Content::Quantity(kind, _) | Content::Stated(kind, ..) if kind.needs_unit() => {
                        format!("{} [{}]", column.name, kind.si)
                    }
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
        self.len() == 0
    }

    /// Whether the file has the column.
    pub fn has(&self, name: &str) -> bool {
        self.heads.contains_key(name)
    }

    /// The text of a cell, without the `'` that keeps a spreadsheet from running it; `None` where it is blank or the
    /// file does not have the column.
    pub fn text(&self, row: usize, name: &str) -> Option<&str> {
        let head = self.filled(row, name).next()?;
        self.records.get(row, head.column).map(unguarded).filter(|t| !t.is_empty())
    }

    /// The columns of a name that a row fills.
    fn filled(&self, row: usize, name: &str) -> impl Iterator<Item = &Head> {
        let heads = self.heads.get(name).map_or(&[][..], Vec::as_slice);
        heads.iter().filter(move |head| self.records.get(row, head.column).is_some_and(|t| !t.is_empty()))
    }

    /// The number in a cell, in SI; `None` where it is blank. What is not a number of the column's
    /// kind and range is noted.
    pub fn number(&self, row: usize, name: &str, problems: &mut Vec<Problem>) -> Option<Number> {
        let head = self.only_filled(row, name, problems)?;
        let text = self.records.get(row, head.column).filter(|t| !t.is_empty())?;
        let column = &self.columns[head.known];
        let (range, expected) = match column.content {
            Content::Quantity(_, range) | Content::Stated(_, range, _) => (range, range.expected()),
            Content::Tolerance(_) => (Range::NonNegative, Range::NonNegative.expected()),
            Content::Count => (Range::AtLeastOne, "a whole number from 1 to 1e6"),
            Content::Text | Content::Pairs(_) => return None,
        };
        let value = match (units::number_value(text), column.content, &head.unit) {
            (Ok(value), Content::Quantity(kind, _) | Content::Stated(kind, ..), Some(unit)) => unit.to_si(value, kind),
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
                    problem = problem.help("the unit is in the header, in brackets; an unknown value is a blank cell");
                } else {
                    problem = problem.help(LEAVE_BLANK);
                }
                problems.push(problem);
                return None;
            }
        };
        let whole = !matches!(column.content, Content::Count) || value.fract() == 0.0 && value <= f64::from(u32::MAX);
        let bounded = match column.content {
            Content::Quantity(kind, _) | Content::Stated(kind, ..) if !kind.holds(value) => Some(kind.bounds_words()),
            _ => None,
        };
        let is_in = range.contains(value) && whole && units::is_sane(value);
        if !is_in || bounded.is_some() {
            let expected = bounded.filter(|_| is_in).unwrap_or_else(|| expected.to_string());
            let mut problem = Problem::at(
                self.cell_span(row, name),
                format!("`{name}` is out of range"),
                format!("expected {expected}"),
            );
            problem.help = range.help(value);
            problems.push(problem);
            return None;
        }
        Some(Number { value, relative: head.relative, stated: head.stated })
    }

    /// The column of a name that a row fills; that it fills two is noted.
    fn only_filled(&self, row: usize, name: &str, problems: &mut Vec<Problem>) -> Option<&Head> {
        let mut filled = self.filled(row, name);
        let (first, second) = (filled.next()?, filled.next());
        if let Some(second) = second {
            let stated = |head: &Head| match head.stated.after("") {
                words if words.is_empty() => "the column that states nothing".to_string(),
                words => format!("`{words}`"),
            };
            let span = find_cell(self.source.text(), self.starts[row], second.column);
            let message = format!("`{name}` is given twice in this row");
            let label = format!("here as {}, before as {}", stated(second), stated(first));
            problems.push(Problem::at(span, message, label).help("leave one of the two cells blank"));
            return None;
        }
        Some(first)
    }

    /// The pairs of numbers in a cell, in SI; `None` where it is blank or has a mistake, which is noted with its place.
    pub fn pairs(&self, row: usize, name: &str, problems: &mut Vec<Problem>) -> Option<Vec<[f64; 2]>> {
        let head = self.filled(row, name).next()?;
        let Content::Pairs(kinds) = self.columns[head.known].content else { return None };
        let span = self.cell_span(row, name);
        let cell = &self.source.text()[span.clone()];
        let (mut pairs, before) = (Vec::new(), problems.len());
        for (at, text) in words_with_places(cell.trim_matches('"')) {
            let start = span.start + (cell.len() - cell.trim_start_matches('"').len()) + at;
            let span = start..start + text.len();
            let Some((first, second)) = text.split_once(':') else {
                problems.push(
                    Problem::at(
                        span,
                        format!("`{name}`: `{text}` is not a pair"),
                        "expected two numbers with `:` between them",
                    )
                    .help("pairs are separated by blanks, for example 7:120 10:18"),
                );
                continue;
            };
            let mut pair = [0.0; 2];
            let units = [&head.unit, &head.second];
            for (k, text) in [first, second].into_iter().enumerate() {
                let (kind, range) = kinds[k];
                match units::number_value(text).map(|value| units[k].as_ref().map_or(value, |u| u.to_si(value, kind))) {
                    Ok(value) if range.contains(value) && kind.holds(value) => pair[k] = value,
                    Ok(_) => problems.push(Problem::at(
                        span.clone(),
                        format!("`{name}`: `{text}` is out of range"),
                        format!("expected {}", range.expected()),
                    )),
                    Err(error) => problems.push(Problem::at(
                        span.clone(),
                        format!("`{name}`: {}", error.message(&units::RATIO)),
                        format!("expected {}", range.expected()),
                    )),
                }
            }
            pairs.push(pair);
        }
        (problems.len() == before).then_some(pairs)
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
                // A blank cell would be the next mistake.
                None => problems[before..].iter_mut().for_each(|problem| problem.replace_help(LEAVE_BLANK, gap)),
            }
            if problems.len() > MOST_SHOWN {
                break;
            }
        }
        Some(values)
    }

    /// The bytes of a cell, or of its row where the column is absent.
    pub fn cell_span(&self, row: usize, name: &str) -> Span<usize> {
        match self.filled(row, name).next().or_else(|| self.heads.get(name)?.first()) {
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

/// Rows beyond what is held, found before any of them is. A record ends with its line, or goes over several.
fn oversized(text: &str) -> Option<Problem> {
    let ends = || text.bytes().filter(|b| matches!(b, b'\n' | b'\r'));
    if ends().nth(limits::TABLE_ROWS).is_none() {
        return limits::bytes(text.len() as u64, limits::TABLE_BYTES);
    }
    let mut reader = csv::ReaderBuilder::new().flexible(true).comment(Some(b'#')).from_reader(text.as_bytes());
    let (mut record, mut rows) = (csv::ByteRecord::new(), 0);
    while rows <= limits::TABLE_ROWS && reader.read_byte_record(&mut record).unwrap_or(false) {
        rows += 1;
    }
    (rows > limits::TABLE_ROWS).then(|| {
        let message = format!("the table has more than {} rows", limits::TABLE_ROWS);
        Problem::whole(message).help("split the file, or leave rows out")
    })
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
pub fn find_cell(text: &str, start: usize, position: usize) -> Span<usize> {
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

/// The words of a text, each with the byte that it begins at.
fn words_with_places(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split_whitespace().map(move |word| (word.as_ptr() as usize - text.as_ptr() as usize, word))
}

type HeaderProblem = (String, String);

/// What the brackets behind a column's name say. The place of the column is the caller's.
fn header_unit(column: &Column, unit: Option<&str>) -> Result<Head, HeaderProblem> {
    let head = Head { column: 0, known: 0, unit: None, second: None, relative: false, stated: Stated::default() };
    match column.content {
        Content::Text | Content::Count => match unit {
            None => Ok(head),
            Some(unit) => Err((format!("has no unit, but `{unit}` is given"), format!("write `{}`", column.name))),
        },
        Content::Tolerance(_) if unit == Some("%") => {
            let percent = units::unit_of("%", &units::RATIO).expect("per cent is a unit");
            Ok(Head { unit: Some(percent), relative: true, ..head })
        }
        Content::Quantity(kind, _) | Content::Tolerance(kind) => {
            Ok(Head { unit: unit_in_header(column, kind, unit, Words::NONE)?, ..head })
        }
        Content::Stated(kind, _, words) => {
            let (rest, stated) = match unit.map(|text| words.split(text)) {
                None => (None, Stated::default()),
                Some(Ok((rest, stated))) => (Some(rest).filter(|r| !r.is_empty()), stated),
                Some(Err(message)) => return Err((message, format!("one of them: {}", example(column, kind, words)))),
            };
            Ok(Head { unit: unit_in_header(column, kind, rest, words)?, stated, ..head })
        }
        Content::Pairs([(first, _), (second, _)]) => {
            let help = || format!("write both units, `{} [{} : {}]`", column.name, first.si, second.si);
            let Some((a, b)) = unit.and_then(|unit| unit.split_once(':')) else {
                return Err(("its cells are pairs, which have two units".into(), help()));
            };
            let of = |kind: &'static Kind, text: &str| {
                let text = Some(text.trim()).filter(|t| !t.is_empty());
                unit_in_header(column, kind, text, Words::NONE).map_err(|(message, _)| (message, help()))
            };
            Ok(Head { unit: of(first, a)?, second: of(second, b)?, ..head })
        }
    }
}

/// How a column is written in a header.
fn example(column: &Column, kind: &Kind, words: Words) -> String {
    let unit = kind.example.split_once(' ').map_or("", |(_, unit)| unit);
    let stated = Stated { convention: words.convention.first().copied(), side: words.side.first().copied() };
    format!("`{} [{}]`", column.name, stated.after(unit))
}

fn unit_in_header(
    column: &Column,
    kind: &'static Kind,
    unit: Option<&str>,
    words: Words,
) -> Result<Option<Unit>, HeaderProblem> {
    match unit {
        None if kind.needs_unit() => Err((
            units::UnitError::MissingUnit.message(kind),
            format!("write the unit in brackets, for example {}", example(column, kind, Words::NONE)),
        )),
        None => Ok(None),
        Some(text) => units::unit_of(text, kind).map(Some).map_err(|error| {
            let help = match words.meant(text) {
                Some(near) => format!("did you mean `{near}`? For example {}", example(column, kind, words)),
                None => format!("for example {}", example(column, kind, Words::NONE)),
            };
            (error.message(kind), help)
        }),
    }
}

#[cfg(test)]
mod tests;
