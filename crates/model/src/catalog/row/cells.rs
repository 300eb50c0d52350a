//! Where a row is read from: a line of a CSV table, or a table of TOML.
//!
//! The one idea: the reader asks for columns and never sees the file. What a blank or wrong cell is called, and where it
//! stands, is known here alone.

use std::cell::RefCell;
use std::ops::Range as Span;

use super::{Need, aliases_of};
use crate::input::csv::{Number, Table};
use crate::input::{Key, Problem, Range, Section, Stated, Words, key};
use crate::units::{self, Kind};

/// The cells of one row.
pub trait Cells {
    /// Whether something stands in the column.
    fn is_given(&self, column: &'static str) -> bool;
    /// The text of a column.
    fn text(&self, column: Key) -> Option<String>;
    /// One of several words.
    fn choice(&self, column: Key, words: &'static [&'static str]) -> Option<&'static str>;
    /// A whole number from 1 on.
    fn count(&self, column: Key) -> Option<u32>;
    /// Pairs of numbers in SI.
    fn pairs(&self, column: Key, kinds: [(&'static Kind, Range); 2]) -> Option<Vec<[f64; 2]>>;
    /// A number in SI, and what it states of itself.
    fn number(&self, column: Key, kind: &'static Kind, range: Range, words: Words) -> Option<(f64, Stated)>;
    /// A ±: its number and whether that is a share of the value.
    fn tolerance(&self, column: Key, kind: &'static Kind) -> Option<(f64, bool)>;
    /// Where a column stands.
    fn span(&self, column: &'static str) -> Span<usize>;
    /// Notes that a column which the row must have is blank.
    fn blank(&self, column: &'static str, need: Need, words: &[&str]);
    /// Notes what is missing to make a motor of the row; `clean` where the row has no other mistake that may be its cause.
    fn incomplete(&self, missing: Missing, clean: bool);
    /// Notes a mistake that the reader found itself.
    fn note(&self, problem: Problem);
    /// How many mistakes were noted so far.
    fn noted(&self) -> usize;
}

/// What a row lacks, said for a file of either kind.
#[derive(Debug, Clone, Copy)]
pub struct Missing {
    /// The column.
    pub column: &'static str,
    /// Where to show it in a table.
    pub at: &'static str,
    /// What is wrong.
    pub message: &'static str,
    /// What to do.
    pub help: &'static str,
    /// An example as in TOML.
    pub example: &'static str,
}

/// A line of a CSV table.
pub struct CsvCells<'a> {
    table: &'a Table,
    row: usize,
    problems: RefCell<&'a mut Vec<Problem>>,
}

impl<'a> CsvCells<'a> {
    /// A row of a table; what is wrong is noted in `problems`.
    pub fn new(table: &'a Table, row: usize, problems: &'a mut Vec<Problem>) -> CsvCells<'a> {
        CsvCells { table, row, problems: RefCell::new(problems) }
    }

    fn read(&self, column: &str) -> Option<Number> {
        self.table.number(self.row, column, &mut self.problems.borrow_mut())
    }
}

impl Cells for CsvCells<'_> {
    fn is_given(&self, column: &'static str) -> bool {
        self.table.text(self.row, column).is_some()
    }

    fn text(&self, column: Key) -> Option<String> {
        self.table.text(self.row, column.name()).map(str::to_string)
    }

    fn choice(&self, column: Key, words: &'static [&'static str]) -> Option<&'static str> {
        let choices: Vec<_> = words.iter().map(|word| (*word, *word)).collect();
        self.table.choice(self.row, column.name(), &choices, &mut self.problems.borrow_mut())
    }

    fn count(&self, column: Key) -> Option<u32> {
        // The table has seen that it is a whole number that fits.
        self.read(column.name()).map(|n| n.value as u32)
    }

    fn pairs(&self, column: Key, _: [(&'static Kind, Range); 2]) -> Option<Vec<[f64; 2]>> {
        self.table.pairs(self.row, column.name(), &mut self.problems.borrow_mut())
    }

    fn number(&self, column: Key, _: &'static Kind, _: Range, _: Words) -> Option<(f64, Stated)> {
        self.read(column.name()).map(|n| (n.value, n.stated))
    }

    fn tolerance(&self, column: Key, _: &'static Kind) -> Option<(f64, bool)> {
        self.read(column.name()).map(|n| (n.value, n.relative))
    }

    fn span(&self, column: &'static str) -> Span<usize> {
        self.table.cell_span(self.row, column)
    }

    fn blank(&self, column: &'static str, need: Need, words: &[&str]) {
        // That the file does not have the column at all was said of its header.
        if !self.table.has(column) {
            return;
        }
        let row = self.table.row_span(self.row);
        self.note(match need {
            Need::Convention(_) => Problem::at(
                row,
                format!("`{column}` is blank: no convention given"),
                "the numbers of this row cannot be read without it",
            )
            .help(format!("one of {}; `audit` can suggest which fits", words.join(", "))),
            _ => Problem::at(row, format!("`{column}` is blank"), format!("this row needs its {column}")),
        });
    }

    fn incomplete(&self, missing: Missing, clean: bool) {
        if clean {
            let span = self.span(missing.at);
            self.note(Problem::at(span, missing.message, "in this row").help(missing.help));
        }
    }

    fn note(&self, problem: Problem) {
        self.problems.borrow_mut().push(problem);
    }

    fn noted(&self) -> usize {
        self.problems.borrow().len()
    }
}

/// A table of TOML.
pub struct TomlCells<'a, 's>(pub &'a Section<'s>);

impl TomlCells<'_, '_> {
    /// The key that a column stands under: its own name, or another one of it.
    fn key(&self, column: Key) -> Key {
        let other = aliases_of(column.name()).find(|alias| self.0.holds(alias));
        match other {
            Some(alias) if !self.0.holds(column.name()) => key(alias, ""),
            _ => column,
        }
    }

    /// Notes columns that stand there under two names.
    pub fn check_names(&self) {
        for (alias, column) in super::ALIASES.iter().filter(|(alias, _)| self.0.holds(alias)) {
            let others = std::iter::once(*column).chain(aliases_of(column));
            // Of two, the one that is met first is noted; both are asked for.
            if let Some(other) = others.take_while(|other| other != alias).find(|other| self.0.holds(other)) {
                let message = format!("`{other}` and `{alias}` are the same column, `{column}`");
                let problem = Problem::at(self.0.span_of(alias), message, "second time");
                self.0.note(problem.help("leave one of the two out"));
            }
        }
    }
}

impl Cells for TomlCells<'_, '_> {
    fn is_given(&self, column: &'static str) -> bool {
        self.0.has(self.key(column.into()))
    }

    fn text(&self, column: Key) -> Option<String> {
        let is_id = column.name() == "id";
        let column = self.key(column);
        if is_id {
            return self.0.required_text(column, "\"t-motor-ri50-fitted\"").map(toml::Spanned::into_inner);
        }
        self.0.text(column).map(|text| text.into_inner().trim().to_string())
    }

    fn choice(&self, column: Key, words: &'static [&'static str]) -> Option<&'static str> {
        let choices: Vec<_> = words.iter().map(|word| (*word, *word)).collect();
        self.0.choice(self.key(column), &choices)
    }

    fn count(&self, column: Key) -> Option<u32> {
        self.0.count(self.key(column))
    }

    fn pairs(&self, column: Key, kinds: [(&'static Kind, Range); 2]) -> Option<Vec<[f64; 2]>> {
        self.0.pairs(self.key(column), kinds)
    }

    fn number(&self, column: Key, kind: &'static Kind, range: Range, words: Words) -> Option<(f64, Stated)> {
        let column = self.key(column);
        match kind.needs_unit() {
            true => self.0.stated_quantity(column, kind, range, words),
            false => self.0.number(column, range).map(|number| (number, Stated::default())),
        }
    }

    /// In the unit of its number, or in per cent of it.
    fn tolerance(&self, column: Key, kind: &'static Kind) -> Option<(f64, bool)> {
        let column = self.key(column);
        let given = self.0.has(column.value("the same unit, or `%` of the value"));
        let column = column.name();
        if !given {
            return None;
        }
        if !kind.needs_unit() {
            return self.0.number(column, Range::NonNegative).map(|number| (number, false));
        }
        let text = self.0.is_text(column).then(|| self.0.text(column)).flatten();
        if let Some(text) = &text
            && text.get_ref().contains('%')
        {
            let share = units::quantity(text.get_ref(), &units::RATIO).ok().filter(|s| *s >= 0.0);
            if share.is_none() {
                let message = format!("`{column}` is no percentage");
                self.note(Problem::at(text.span(), message, "expected like \"2 %\""));
            }
            return share.map(|share| (share, true));
        }
        self.0.difference(column, kind).map(|number| (number, false))
    }

    fn span(&self, column: &'static str) -> Span<usize> {
        self.0.span_of(self.key(column.into()).name())
    }

    fn blank(&self, column: &'static str, need: Need, _: &[&str]) {
        if self.is_given(column) {
            let message = format!("`{column}` is blank");
            self.note(Problem::at(self.span(column), message, format!("this row needs its {column}")));
        } else if let Need::Must(example) | Need::Convention(example) = need {
            self.0.missing(column, example);
        }
    }

    fn incomplete(&self, missing: Missing, _: bool) {
        // What is there but wrong was said already.
        if !self.is_given(missing.column) {
            self.0.missing(missing.column, missing.example);
        }
    }

    fn note(&self, problem: Problem) {
        self.0.note(problem);
    }

    fn noted(&self) -> usize {
        self.0.noted()
    }
}
