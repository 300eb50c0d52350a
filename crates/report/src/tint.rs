//! Colour of a terminal, for what a reader has to see first: limits that are exceeded or near, and what is not known.
//!
//! The one idea: a tinted text carries marks without width, so that whatever lays text out needs to know nothing of
//! colours; whoever prints it puts colours in their place ([`printed`]). Where there is no colour, there are no marks.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering};

use gearwise_rules::Severity;
use gearwise_select::evaluate::Margin;

static IS_ON: AtomicBool = AtomicBool::new(false);

/// Marks text from here on, or no more: what the command line does once, at its start.
pub fn set_on(on: bool) {
    IS_ON.store(on, Ordering::Relaxed);
}

/// Below this margin \[1\] a limit is near: the spread of a winding's resistance between two motors of one series is as much.
const NEAR: f64 = 0.05;

/// What a text says of a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tint {
    /// Kept, with a reserve.
    Kept,
    /// Kept by little, or not known.
    Doubtful,
    /// Exceeded, or impossible.
    Exceeded,
}

impl Tint {
    const ALL: [Tint; 3] = [Tint::Kept, Tint::Doubtful, Tint::Exceeded];

    /// What a margin says.
    pub fn of(margin: &Margin) -> Tint {
        match margin.margin {
            m if m < 0.0 => Tint::Exceeded,
            m if m < NEAR => Tint::Doubtful,
            _ => Tint::Kept,
        }
    }

    /// What a finding says.
    pub fn of_severity(severity: Severity) -> Option<Tint> {
        match severity {
            Severity::Error => Some(Tint::Exceeded),
            Severity::Warning => Some(Tint::Doubtful),
            Severity::Note | Severity::Off => None,
        }
    }

    /// The text with this tint.
    pub fn on(self, text: &str) -> String {
        match IS_ON.load(Ordering::Relaxed) {
            true if !text.is_empty() => self.marked(text),
            _ => text.to_string(),
        }
    }

    fn marked(self, text: &str) -> String {
        format!("{}{text}{END}", self.mark())
    }

    /// Characters that have no width and that no name has.
    fn mark(self) -> char {
        match self {
            Tint::Kept => '\u{2061}',
            Tint::Doubtful => '\u{2062}',
            Tint::Exceeded => '\u{2063}',
        }
    }

    /// Of the eight colours that every terminal has.
    fn code(self) -> &'static str {
        match self {
            Tint::Kept => "\u{1b}[32m",
            Tint::Doubtful => "\u{1b}[33m",
            Tint::Exceeded => "\u{1b}[31m",
        }
    }
}

/// Where a tint ends.
const END: char = '\u{2064}';

fn is_mark(c: char) -> bool {
    c == END || Tint::ALL.iter().any(|tint| tint.mark() == c)
}

/// The text without marks.
pub fn plain(text: &str) -> Cow<'_, str> {
    match text.contains(is_mark) {
        true => text.chars().filter(|c| !is_mark(*c)).collect(),
        false => text.into(),
    }
}

/// The text as it is printed: with colours where marks are, if there are colours.
pub fn printed(text: Cow<'_, str>) -> Cow<'_, str> {
    if IS_ON.load(Ordering::Relaxed) { coloured(&text).into() } else { text }
}

/// The text with colours where marks are.
fn coloured(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match Tint::ALL.into_iter().find(|tint| tint.mark() == c) {
            Some(tint) => out.push_str(tint.code()),
            None if c == END => out.push_str("\u{1b}[39m"),
            None => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Column, Table, wrap_at};

    #[test]
    fn marks_have_no_width_and_break_no_line() {
        let tinted = Tint::Doubtful.marked("3 %");
        assert_eq!(unicode_width::UnicodeWidthStr::width(tinted.as_str()), 3);
        let table = |cell: &str| {
            Table::new(vec![Column::number("margin", ""), Column::name("of")])
                .rows([vec![cell.to_string(), "voltage".into()], vec!["120 %".into(), "mass".into()]])
                .text_at(60)
        };
        assert_eq!(plain(&table(&tinted)), table("3 %"));
        for width in 20..60 {
            let text = |of: &str| wrap_at(&format!("smallest margin voltage {of}; a spring of 12.5 N·m/rad"), 4, width);
            assert_eq!(plain(&text(&tinted)), text("3 %"), "at {width}");
        }
        assert_eq!(coloured(&tinted), "\u{1b}[33m3 %\u{1b}[39m");
        assert_eq!(Tint::Doubtful.on("3 %"), "3 %", "without colour there are no marks");
    }
}
