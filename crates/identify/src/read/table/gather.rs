//! A log while its rows are gathered: which belong to it, in which order, and what is left out.

use std::collections::BTreeSet;
use std::ops::Range as Span;

use super::record::{Mistakes, Record, short};
use super::wanted::{Condition, Rows, Wanted};
use crate::bench::Channel;
use crate::read::columns::{Column, Target};
use crate::read::remark::Remark;
use gearwise_model::input::Problem;
use gearwise_model::units;
use gearwise_model::words::nearest;

/// At most this many values of a column are listed where none is the one asked for.
const MAX_VALUES: usize = 30;
/// Fewer rows teach nothing.
const MIN_ROWS: usize = 3;

/// A log while its rows are gathered.
pub struct Gather<'a> {
    /// What the log asks for.
    pub wanted: &'a Wanted,
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
    /// Numbers that a row of it holds.
    pub fn width(&self) -> usize {
        self.cells.len() + 1
    }

    /// Finds the columns in the header.
    pub fn new(
        wanted: &'a Wanted,
        header: &[String],
        record: Record,
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
                let mut problem = Problem::at(span.clone(), message, record.nowhere());
                let shown: Vec<String> = header.iter().take(40).map(|h| h.chars().take(60).collect()).collect();
                let shown = format!("its columns: {}", shown.join(", "));
                problem = match nearest(name, header.iter().map(String::as_str).filter(|h| !h.is_empty())) {
                    // Names of one letter are all alike.
                    Some(near) if name.len() > 1 => problem.help(match record {
                        Record::Line(_) => format!("did you mean `{near}`?"),
                        // There is no header to look at.
                        Record::Values { .. } => format!("did you mean `{near}`? {shown}"),
                    }),
                    _ => problem.help(shown),
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

    /// Whether a row belongs to the log.
    pub fn selects(&mut self, record: Record, mistakes: &mut Mistakes) -> bool {
        let mut all = true;
        for test in &mut self.tests {
            all &= test.holds(record, mistakes);
        }
        all
    }

    /// Takes a row that belongs to the log.
    pub fn take(&mut self, record: Record, mistakes: &mut Mistakes) {
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
    pub fn finish(self, file: &str, note: &mut dyn FnMut(Problem)) -> Option<Rows> {
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
    fn holds(&mut self, record: Record, mistakes: &mut Mistakes) -> bool {
        let cell = record.text(self.position);
        let cell = cell.as_ref();
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
fn parse(record: Record, cell: &Cell, mistakes: &mut Mistakes) -> Option<f64> {
    let column = cell.column;
    let raw = match record.number(cell.position) {
        Ok(raw) => raw,
        Err(text) => {
            let help = if text.contains(&b',') {
                "numbers have a decimal point, not a comma"
            } else if text.first().is_some_and(u8::is_ascii_digit) {
                "a cell is a bare number; its unit is `unit` of the column in the bench file"
            } else {
                "a value that is missing is a blank cell, or nan"
            };
            let message = format!("`{}` is not a number: `{}`", column.name, short(text));
            mistakes.add(record, Some(cell.position), message, "expected a number", help);
            return None;
        }
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
    let is_temperature =
        matches!(column.target, Target::Channel(Channel::WindingTemperature | Channel::HousingTemperature));
    if !units::is_sane(value) || is_temperature && !units::TEMPERATURE.holds(value) {
        let message = format!("`{}` is out of range: `{}`", column.name, short(&record.text(cell.position)));
        mistakes.add(
            record,
            Some(cell.position),
            message,
            "no quantity of its kind is that large or small",
            "leave the cell blank",
        );
        return None;
    }
    Some(value)
}
