//! Input files: read once, then every mistake in them is collected with its place and shown
//! together.
//!
//! The one idea of this room: a reader never stops at the first mistake. It asks a [`Form`] (TOML)
//! or a [`Table`](csv::Table) (CSV) for what it expects; whatever is missing, misspelt, of the wrong dimension or out
//! of range becomes a [`Problem`] with the span of text that caused it, and the reader goes on.

mod change;
pub mod csv;
mod describe;
mod file;
mod form;
pub mod json;
mod key_path;
pub mod kind;
pub mod limits;
mod locate;
mod source;
mod stated;

pub use change::Change;
pub use describe::{Description, Key, KeyAsked, TableAsked, key};
pub use file::{Opened, utf_16};
pub use form::{Form, Section};
pub use key_path::key_path;
pub use locate::{Step, locate};
pub use source::{InputError, InputFile, Problem, Source, hex, sha256};
pub use source::{printable, tame};
pub use stated::{Stated, Words};

/// What values a number may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Any finite number.
    Any,
    /// Greater than zero.
    Positive,
    /// Zero or more.
    NonNegative,
    /// Greater than zero, at most one.
    Fraction,
    /// Zero or more, less than one.
    Share,
    /// From one to 10⁶.
    AtLeastOne,
}

impl Range {
    /// Whether `value` (SI) lies in the range.
    pub fn contains(self, value: f64) -> bool {
        match self {
            Range::Any => value.is_finite(),
            Range::Positive => value >= crate::units::SMALLEST,
            Range::NonNegative => value >= 0.0,
            Range::Fraction => (1e-6..=1.0).contains(&value),
            Range::Share => (0.0..1.0).contains(&value),
            Range::AtLeastOne => (1.0..=1e6).contains(&value),
        }
    }

    /// What was expected, in words.
    pub fn expected(self) -> &'static str {
        match self {
            Range::Any => "a finite number",
            Range::Positive => "a number greater than zero",
            Range::NonNegative => "a number that is not negative",
            Range::Fraction => "a number greater than 0 and at most 1",
            Range::Share => "a number from 0 to less than 1",
            Range::AtLeastOne => "a number from 1 to 1e6",
        }
    }

    /// The values, in few words.
    pub fn words(self) -> &'static str {
        match self {
            Range::Any => "any",
            Range::Positive => "above zero",
            Range::NonNegative => "from zero",
            Range::Fraction => "above 0, at most 1",
            Range::Share => "0 or more, less than 1",
            Range::AtLeastOne => "from 1 to 1e6",
        }
    }

    /// What was probably meant by a value outside: a fraction given in per cent.
    fn help(self, value: f64) -> Option<String> {
        let percent = matches!(self, Range::Fraction | Range::Share) && value > 2.0 && value <= 100.0;
        percent.then(|| format!("for {value} % write {}", crate::words::number(value / 100.0)))
    }
}
