//! One log file, read as a stream: only the cells that a log needs are parsed, and the text is not kept.
//! A mistake is shown with its line all the same; the line is fetched again from the file.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::ops::Range as Span;
use std::path::Path;
use std::sync::Arc;

use csv::{ByteRecord, Position};
use hmac_sha256::Hash as Sha256;

use super::columns::{Column, Target};
use super::remark::Remark;
use crate::input::csv::other_separator;
use crate::input::{InputError, Opened, Problem, Source, limits, utf_16};
use crate::measured::bench::Channel;
use crate::units;
use crate::words::nearest;

/// At most this many mistakes of a log are collected: its rows tend to share them.
const MAX_PROBLEMS: usize = 20;
/// At most this much of a line is shown in a report \[bytes\].
const MAX_LINE: u64 = 1 << 16;
/// At most this many values of a column are listed where none is the one asked for.
const MAX_VALUES: usize = 30;
/// Fewer rows teach nothing.
const MIN_ROWS: usize = 3;

/// What the cells of a column must be for a row to belong to a log.
#[derive(Debug, Clone)]
pub(crate) struct Condition {
    /// Its name in the header.
    pub column: String,
    /// Where the bench file names the column.
    pub column_span: Span<usize>,
    /// One of these (empty: any).
    pub equals: Vec<String>,
    /// At least this, in the unit of the file.
    pub min: Option<f64>,
    /// At most this, in the unit of the file.
    pub max: Option<f64>,
    /// Where the bench file says which.
    pub span: Span<usize>,
}

/// What a log needs of its file.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// Which rows; all must hold.
    pub select: Vec<Condition>,
    /// Which columns.
    pub columns: Vec<Column>,
    /// Where the bench file names the log, for what is wrong with it as a whole.
    pub span: Span<usize>,
    /// Whether its rows may not be used to fit.
    pub held_out: bool,
}

/// The rows of a log.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    /// Time \[s\], or row number.
    pub time: Vec<f64>,
    /// The channels.
    pub channels: BTreeMap<Channel, Vec<f64>>,
    /// What was left out, counted.
    pub remarks: Vec<Remark>,
}

/// Feeds all bytes that are read through the hash.
struct Hashing {
    opened: Opened,
    hash: Sha256,
    count: u64,
}

impl Read for Hashing {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.opened.file.read(buffer)?;
        self.hash.update(&buffer[..count]);
        self.count += count as u64;
        // It was smaller when it was opened.
        if self.count > limits::LOG_BYTES {
            return Err(io::Error::other("it grows faster than it can be read"));
        }
        Ok(count)
    }
}

impl Hashing {
    /// The hash of all that was read, where the file is still what it was.
    fn finish(self) -> Result<String, Problem> {
        let hash = self.hash.finalize();
        let again = |file: &mut File| {
            let mut hash_again = Sha256::new();
            let mut buffer = vec![0; 1 << 16];
            loop {
                match file.read(&mut buffer)? {
                    0 => return Ok(hash_again.finalize() == hash),
                    count => hash_again.update(&buffer[..count]),
                }
            }
        };
        self.opened.unchanged(again).map(|()| crate::input::hex(&hash))
    }
}

/// Whether a file can be opened at all.
///
/// # Errors
/// Why not, and what stands beside it.
pub(crate) fn probe(path: &Path) -> Result<(), (String, Option<String>)> {
    match Opened::new(path, limits::LOG_BYTES) {
        Ok(_) => Ok(()),
        // The message of a file that is not there, with its neighbour.
        Err(_) if !path.exists() => {
            let first = Source::read(path).err().and_then(|e| e.problems.into_iter().next());
            Err(first.map_or_else(|| ("cannot read the file".into(), None), |p| (p.message, p.help)))
        }
        Err(problem) => Err((problem.message, problem.help)),
    }
}

/// Reads the logs that come from one file, in one pass. What is wrong with the bench file (a column
/// that is not there, a selection without rows) goes to `note`.
///
/// # Errors
/// What is wrong with the log file.
pub fn read(
    path: &Path,
    wanted: &[Wanted],
    note: &mut dyn FnMut(Problem),
) -> Result<Option<(String, Vec<Rows>)>, InputError> {
    let name = path.display().to_string();
    let mut mistakes = Mistakes { path, lines: Vec::new(), problems: Vec::new() };
    let wrong =
        |problem: Problem| InputError { source: Arc::new(Source::new(name.clone(), "")), problems: vec![problem] };
    let whole = |message: String| wrong(Problem::whole(message));
    let opened = Opened::new(path, limits::LOG_BYTES).map_err(wrong)?;
    let hashing = Hashing { opened, hash: Sha256::new(), count: 0 };
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .buffer_capacity(1 << 16)
        .from_reader(hashing);
    let failed = |e: csv::Error| whole(format!("cannot read the file: {e}"));
    let mut record = ByteRecord::new();
    if !reader.read_byte_record(&mut record).map_err(failed)? {
        return Err(whole("the file is empty: it has no header row".into()));
    }
    let Some(header) = read_header(&record, &mut mistakes) else { return Err(mistakes.into_error(&name)) };
    let logs: Vec<Option<Gather>> =
        wanted.iter().map(|w| Gather::new(w, &header, &record, &name, &mut mistakes, note)).collect();
    if !mistakes.problems.is_empty() {
        return Err(mistakes.into_error(&name));
    }
    let Some(mut logs) = logs.into_iter().collect::<Option<Vec<Gather>>>() else { return Ok(None) };

    let width = header.len();
    let mut shared = 0_usize;
    let mut numbers = 0_usize;
    while reader.read_byte_record(&mut record).map_err(failed)? {
        if record.len() != width {
            if record.len() == 1 && record[0].trim_ascii().is_empty() {
                continue;
            }
            let more = record.len() > width;
            let message = format!("this row has {} cells, the header has {width}", record.len());
            let help = if more {
                "numbers have a decimal point, not a comma; text with commas needs double quotes"
            } else {
                "was the recording cut off here? Remove the row"
            };
            mistakes.add(&record, None, message, "the cells do not match the header", help);
        } else {
            let (mut fit, mut held_out) = (false, false);
            for log in &mut logs {
                if log.selects(&record, &mut mistakes) {
                    *(if log.wanted.held_out { &mut held_out } else { &mut fit }) = true;
                    log.take(&record, &mut mistakes);
                    numbers += log.cells.len() + 1;
                }
            }
            shared += usize::from(fit && held_out);
        }
        if mistakes.problems.len() >= MAX_PROBLEMS {
            break;
        }
        if numbers > limits::LOG_NUMBERS {
            let rows = record.position().map_or(0, Position::record);
            let most = limits::LOG_NUMBERS;
            let problem = Problem::whole(format!("the log has more than {most} numbers, reached at its row {rows}"));
            return Err(wrong(
                problem.help("take part of it with `select`, keep every n-th row, or leave columns out of [columns]"),
            ));
        }
    }
    if !mistakes.problems.is_empty() {
        // The mistakes may be those of two texts that were taken for one.
        reader.into_inner().opened.unchanged(|_| Ok(true)).map_err(wrong)?;
        return Err(mistakes.into_error(&name));
    }
    if shared > 0 {
        let log = wanted.iter().find(|w| w.held_out).map_or(0..0, |w| w.span.clone());
        note(
            Problem::at(log, format!("{shared} rows of `{name}` are both to fit and held out"), "held out here")
                .help("what judges must not have been fitted: `select` says which rows belong to a log"),
        );
        return Ok(None);
    }
    let hash = reader.into_inner().finish().map_err(wrong)?;
    let rows: Vec<Option<Rows>> = logs.into_iter().map(|log| log.finish(&name, note)).collect();
    Ok(rows.into_iter().collect::<Option<Vec<Rows>>>().map(|rows| (hash, rows)))
}

fn read_header(record: &ByteRecord, mistakes: &mut Mistakes) -> Option<Vec<String>> {
    if let Some(problem) = utf_16(record.as_slice()) {
        mistakes.problems.push(problem);
        return None;
    }
    let mut header = Vec::new();
    for cell in record {
        match std::str::from_utf8(cell.trim_ascii()) {
            Ok(text) => header.push(text.to_string()),
            Err(_) => {
                mistakes.problems.push(
                    Problem::whole("not a text file: its header row is not UTF-8").help("save the log as CSV in UTF-8"),
                );
                return None;
            }
        }
    }
    if header.len() == 1 && header[0].is_empty() {
        mistakes.problems.push(Problem::whole("the file is empty: it has no header row"));
        return None;
    }
    if let Some((message, help)) = other_separator(header.iter().map(String::as_str)) {
        mistakes.add(record, None, message, "expected commas", help);
        return None;
    }
    Some(header)
}

/// A log while its rows are gathered.
struct Gather<'a> {
    wanted: &'a Wanted,
    tests: Vec<Test<'a>>,
    time: Option<Cell<'a>>,
    cells: Vec<Cell<'a>>,
    times: Vec<f64>,
    repeated: usize,
    timeless: usize,
    selected: usize,
    usable: usize,
    backwards: bool,
}

struct Cell<'a> {
    column: &'a Column,
    position: usize,
    values: Vec<f64>,
    missing: usize,
}

/// A condition with the outcome of the row before: runs stand together.
struct Test<'a> {
    condition: &'a Condition,
    position: usize,
    numbers: Vec<Option<f64>>,
    last: Vec<u8>,
    holds: bool,
    fresh: bool,
    seen: BTreeSet<String>,
}

impl<'a> Gather<'a> {
    /// Finds the columns in the header.
    fn new(
        wanted: &'a Wanted,
        header: &[String],
        record: &ByteRecord,
        file: &str,
        mistakes: &mut Mistakes,
        note: &mut dyn FnMut(Problem),
    ) -> Option<Gather<'a>> {
        let mut find = |name: &str, span: &Span<usize>| {
            let mut places = header.iter().enumerate().filter(|(_, cell)| *cell == name).map(|(at, _)| at);
            let first = places.next();
            if let Some(second) = places.next() {
                let message = format!("duplicate column `{name}` in the header");
                mistakes.add(record, Some(second), message, "second time", "rename one of the two");
                return None;
            }
            if first.is_none() {
                let message = format!("there is no column `{name}` in `{file}`");
                let mut problem = Problem::at(span.clone(), message, "not in its header");
                problem = match nearest(name, header.iter().map(String::as_str).filter(|h| !h.is_empty())) {
                    // Names of one letter are all alike.
                    Some(near) if name.len() > 1 => problem.help(format!("did you mean `{near}`?")),
                    _ => {
                        let shown: Vec<String> = header.iter().take(40).map(|h| h.chars().take(60).collect()).collect();
                        problem.help(format!("its columns: {}", shown.join(", ")))
                    }
                };
                note(problem);
            }
            first
        };
        let tests: Vec<Option<Test>> = wanted
            .select
            .iter()
            .map(|condition| {
                let position = find(&condition.column, &condition.column_span)?;
                let numbers = condition.equals.iter().map(|e| units::number_value(e).ok()).collect();
                let (last, seen) = (Vec::new(), BTreeSet::new());
                Some(Test { condition, position, numbers, last, holds: false, fresh: true, seen })
            })
            .collect();
        let cells: Vec<Option<Cell>> = wanted
            .columns
            .iter()
            .map(|column| {
                let position = find(&column.name, &column.span)?;
                Some(Cell { column, position, values: Vec::new(), missing: 0 })
            })
            .collect();
        let tests = tests.into_iter().collect::<Option<Vec<Test>>>()?;
        let (time, cells): (Vec<Cell>, Vec<Cell>) = cells
            .into_iter()
            .collect::<Option<Vec<Cell>>>()?
            .into_iter()
            .partition(|c| c.column.target == Target::Time);
        Some(Gather {
            wanted,
            tests,
            time: time.into_iter().next(),
            cells,
            times: Vec::new(),
            repeated: 0,
            timeless: 0,
            selected: 0,
            usable: 0,
            backwards: false,
        })
    }

    fn selects(&mut self, record: &ByteRecord, mistakes: &mut Mistakes) -> bool {
        let mut all = true;
        for test in &mut self.tests {
            all &= test.holds(record, mistakes);
        }
        all
    }

    /// Takes a row that belongs to the log.
    fn take(&mut self, record: &ByteRecord, mistakes: &mut Mistakes) {
        self.selected += 1;
        let time = match &self.time {
            None => self.times.len() as f64,
            Some(cell) => match parse(record, cell, mistakes) {
                Some(time) if time.is_finite() => time,
                Some(_) => {
                    self.timeless += 1;
                    return;
                }
                None => return,
            },
        };
        if let Some(last) = self.times.last() {
            if time == *last {
                self.repeated += 1;
                return;
            }
            if time < *last {
                // Once is enough: all that follows is earlier than what went before.
                if !self.backwards {
                    let position = self.time.as_ref().map(|c| c.position);
                    let message = format!("time goes backwards here, from {last} s to {time} s");
                    let help =
                        "several runs in one file are separated by select = { column = \"run\", equals = \"…\" }";
                    mistakes.add(record, position, message, "earlier than in the row before", help);
                    self.backwards = true;
                }
                return;
            }
        }
        self.times.push(time);
        let mut any = false;
        for cell in &mut self.cells {
            let value = parse(record, cell, mistakes).unwrap_or(f64::NAN);
            if value.is_finite() {
                any = true;
            } else {
                cell.missing += 1;
            }
            cell.values.push(value);
        }
        self.usable += usize::from(any);
    }

    /// The rows, with what was left out of them; notes a log that teaches nothing.
    fn finish(self, file: &str, note: &mut dyn FnMut(Problem)) -> Option<Rows> {
        if self.selected == 0 && !self.tests.is_empty() {
            for test in &self.tests {
                note(test.nothing(file));
            }
            return None;
        }
        if self.usable < MIN_ROWS {
            let rows = if self.usable == 1 { "1 row".into() } else { format!("{} rows", self.usable) };
            let mut problem = Problem::at(
                self.wanted.span.clone(),
                format!("nothing can be learnt from {rows}"),
                format!("`{file}` has no more for this log"),
            );
            let left_out = [(self.repeated, "repeat their time"), (self.timeless, "have no time")];
            let left_out: Vec<String> =
                left_out.iter().filter(|(n, _)| *n > 0).map(|(n, why)| format!("{n} rows {why}")).collect();
            if !left_out.is_empty() {
                problem = problem.help(left_out.join(", "));
            }
            note(problem);
            return None;
        }
        let mut rows = Rows { time: self.times, ..Rows::default() };
        rows.time.shrink_to_fit();
        if self.repeated > 0 {
            rows.remarks.push(Remark::Repeated(self.repeated));
        }
        if self.timeless > 0 {
            rows.remarks.push(Remark::Timeless(self.timeless));
        }
        for mut cell in self.cells {
            let Target::Channel(channel) = cell.column.target else { continue };
            let (key, cells) = (cell.column.key, cell.values.len());
            if cell.missing == cells {
                rows.remarks.push(Remark::Empty { key, cells });
                continue;
            }
            if cell.missing > 0 {
                rows.remarks.push(Remark::Missing { key, missing: cell.missing, cells });
            }
            cell.values.shrink_to_fit();
            rows.channels.insert(channel, cell.values);
        }
        Some(rows)
    }
}

impl Test<'_> {
    fn holds(&mut self, record: &ByteRecord, mistakes: &mut Mistakes) -> bool {
        let cell = record[self.position].trim_ascii();
        if !self.fresh && cell == self.last {
            return self.holds;
        }
        self.fresh = false;
        self.last.clear();
        self.last.extend_from_slice(cell);
        let text = String::from_utf8_lossy(cell);
        let number = units::number_value(&text).ok();
        let condition = self.condition;
        let equal = condition.equals.is_empty()
            || condition.equals.iter().zip(&self.numbers).any(|(e, n)| *e == text || (n.is_some() && *n == number));
        let bounded = condition.min.is_some() || condition.max.is_some();
        let within = !bounded
            || number.is_some_and(|x| condition.min.is_none_or(|m| x >= m) && condition.max.is_none_or(|m| x <= m));
        if bounded && number.is_none() && !text.is_empty() && !text.eq_ignore_ascii_case("nan") {
            let message =
                format!("`{}` selects by size, but this is not a number: `{}`", condition.column, short(cell));
            mistakes.add(record, Some(self.position), message, "expected a number", "use `equals` to select a text");
        }
        if self.seen.len() <= MAX_VALUES {
            self.seen.insert(short(cell));
        }
        self.holds = equal && within;
        self.holds
    }

    /// No row has what was asked for.
    fn nothing(&self, file: &str) -> Problem {
        let seen: Vec<&str> = self.seen.iter().take(MAX_VALUES).map(String::as_str).collect();
        let more = if self.seen.len() > MAX_VALUES { ", …" } else { "" };
        let problem = Problem::at(
            self.condition.span.clone(),
            format!("no row of `{file}` is selected"),
            format!("looked for in column `{}`", self.condition.column),
        );
        if seen.is_empty() {
            return problem.help("the file has a header but no rows");
        }
        problem.help(format!("values of `{}`: {}{more}", self.condition.column, seen.join(", ")))
    }
}

/// The number of a cell in SI; NaN where it is blank or not finite, `None` (noted) where it is no number.
fn parse(record: &ByteRecord, cell: &Cell, mistakes: &mut Mistakes) -> Option<f64> {
    let bytes = record[cell.position].trim_ascii();
    if bytes.is_empty() {
        return Some(f64::NAN);
    }
    let raw = std::str::from_utf8(bytes).ok().and_then(|text| text.parse::<f64>().ok());
    let column = cell.column;
    let Some(raw) = raw else {
        let help = if bytes.contains(&b',') {
            "numbers have a decimal point, not a comma"
        } else if bytes.first().is_some_and(u8::is_ascii_digit) {
            "a cell is a bare number; its unit is `unit` of the column in the bench file"
        } else {
            "a value that is missing is a blank cell, or nan"
        };
        let message = format!("`{}` is not a number: `{}`", column.name, short(bytes));
        mistakes.add(record, Some(cell.position), message, "expected a number", help);
        return None;
    };
    if !raw.is_finite() {
        return Some(f64::NAN);
    }
    let raw = match column.bits {
        // Two's complement.
        Some(bits) if raw >= f64::from(bits - 1).exp2() => raw - f64::from(bits).exp2(),
        _ => raw,
    };
    let value = column.gain * raw + column.offset;
    if !units::is_sane(value) {
        let message = format!("`{}` is out of range: `{}`", column.name, short(bytes));
        mistakes.add(record, Some(cell.position), message, "no quantity is that large", "leave the cell blank");
        return None;
    }
    Some(value)
}

/// A cell for a message.
fn short(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let clean = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    match text.char_indices().nth(60) {
        Some((at, _)) => text[..at].chars().map(clean).chain(['…']).collect(),
        None => text.chars().map(clean).collect(),
    }
}

/// The mistakes of a log with the lines that they are in.
struct Mistakes<'a> {
    path: &'a Path,
    lines: Vec<(usize, String)>,
    problems: Vec<Problem>,
}

impl Mistakes<'_> {
    /// A mistake in a cell, or in the row as a whole.
    fn add(&mut self, record: &ByteRecord, cell: Option<usize>, message: String, label: &str, help: &str) {
        let Some((number, line)) = record.position().and_then(|p| fetch(self.path, p)) else {
            self.problems.push(Problem::whole(message).help(help));
            return;
        };
        if self.lines.last().is_none_or(|(n, _)| *n != number) {
            self.lines.push((number, line));
        }
        let before: usize = self.lines[..self.lines.len() - 1].iter().map(|(_, l)| l.len() + 1).sum();
        let line = &self.lines[self.lines.len() - 1].1;
        let span = match cell {
            Some(position) => crate::input::csv::find_cell(line, 0, position),
            None => 0..line.len(),
        };
        let problem = Problem::at(before + span.start..before + span.end, message, label).help(help);
        if !self.problems.contains(&problem) {
            self.problems.push(problem);
        }
    }

    fn into_error(self, name: &str) -> InputError {
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
