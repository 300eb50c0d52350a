//! Rows of a catalogue: one reader and one writer for every kind of row, as a line of CSV or as a table of TOML.
//!
//! The one idea: a kind of row ([`Row`]) declares its columns, each once, with its name, what it is, and how it is taken
//! from a row and put into it. Reading (`read`), writing (`write`) and the documentation walk over these declarations.

mod alias;
mod cells;
mod gear;
mod module;
mod motor;
mod read;
mod write;

pub use alias::{ALIASES, aliases_of, column_of};
pub use cells::{Cells, CsvCells, TomlCells};
pub use motor::{Convention, MotorRow};
pub(super) use read::{check_gear, gear, module, motor, numbers, point};
pub use write::text;
pub use write::{csv_text, toml_text};
pub use write::{number_line, quoted, say};

use super::offer::Sold;
use super::sheet::{Printed, Sheet};
use crate::input::csv::{Column as CsvColumn, Content};
use crate::input::{Range, Stated, Words};
use crate::units::{self, Kind};

/// A kind of row and its columns. In files that the program writes the numbers stand between two groups of other columns.
pub trait Row: Sized + 'static {
    /// What holds the numbers.
    type Numbers: Sold + 'static;
    /// The columns before the numbers.
    const BEFORE: &'static [Column<Self>];
    /// The columns behind them.
    const AFTER: &'static [Column<Self>];
    /// Numeric columns that the header of a file must have.
    const REQUIRED: &'static [&'static str];

    /// The numbers.
    fn fields() -> &'static [Field<Self::Numbers>];

    /// Where they are.
    fn numbers(&self) -> &Self::Numbers;

    /// Where they are put.
    fn numbers_mut(&mut self) -> &mut Self::Numbers;

    /// Day, month or year of its source, empty where it is not said.
    fn source_date(&self) -> &str;

    /// Takes what a number states of itself; the number as the row keeps it.
    ///
    /// # Errors
    /// In words, where the row cannot have such a number: the message and what to do.
    fn take(
        &mut self,
        field: &Field<Self::Numbers>,
        stated: Stated,
        number: Printed,
    ) -> Result<Printed, (String, String)>;

    /// What a number states of itself where it is written.
    fn states(&self, field: &Field<Self::Numbers>) -> Stated;
}

/// A column that holds no number.
pub struct Column<R: 'static> {
    /// Its name.
    pub name: &'static str,
    /// What it is, in a few words; the words that may stand there are not repeated.
    pub about: &'static str,
    /// Whether a row must have it.
    pub need: Need,
    /// What it holds.
    pub holds: Holds<R>,
}

/// Whether a row must have a column, and what is said where it does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// It may be blank.
    May,
    /// It must be there; an example, as in TOML.
    Must(&'static str),
    /// It says what the numbers of the row refer to.
    Convention(&'static str),
}

/// What a column holds, and how it is taken from a row and put into it.
pub enum Holds<R: 'static> {
    /// Text; blank where there is none.
    Text(fn(&R) -> String, fn(&mut R, String)),
    /// One of several words.
    Choice(&'static [&'static str], fn(&R) -> Option<&'static str>, fn(&mut R, &str)),
    /// A whole number from 1 on.
    Count(fn(&R) -> Option<u32>, fn(&mut R, u32)),
    /// Pairs of numbers, in SI; none where the cell is blank.
    Pairs([(&'static Kind, Range); 2], fn(&R) -> Vec<[f64; 2]>, fn(&mut R, Vec<[f64; 2]>)),
}

/// A numeric column.
pub struct Field<S: 'static = Sheet> {
    /// Column name.
    pub name: &'static str,
    /// Name of the column of its ±, where it may have one.
    pub tolerance: Option<&'static str>,
    /// What it is.
    pub about: &'static str,
    /// What it measures.
    pub kind: &'static Kind,
    /// What values it may have.
    pub range: Range,
    /// What may stand behind its unit.
    pub states: States,
    /// Reads it.
    pub get: fn(&S) -> Option<Printed>,
    /// Writes it.
    pub set: fn(&mut S, Printed),
}

/// The numbers of an offer: one declaration for every kind of row.
impl<S: Sold> Field<S> {
    /// Price.
    pub const PRICE: Field<S> = Field {
        name: "price",
        tolerance: None,
        about: "Of one, in `price_currency`.",
        kind: &units::RATIO,
        range: Range::Positive,
        states: States::Nothing,
        get: |s| s.offer().price.map(Printed::exact),
        set: |s, printed| s.offer_mut().price = Some(printed.value),
    };

    /// How many have to be bought at once for that.
    pub const PRICE_QUANTITY: Field<S> = Field {
        name: "price_quantity",
        tolerance: None,
        about: "So many have to be bought at once for that price; 1 where it is blank.",
        kind: &units::RATIO,
        range: Range::AtLeastOne,
        states: States::Nothing,
        get: |s| s.offer().price_quantity.map(Printed::exact),
        set: |s, printed| s.offer_mut().price_quantity = Some(printed.value),
    };

    /// Time until it is there.
    pub const LEAD_TIME: Field<S> = Field {
        name: "lead_time",
        tolerance: None,
        about: "Time until it is delivered.",
        kind: &units::TIME,
        range: Range::NonNegative,
        states: States::Nothing,
        get: |s| s.offer().lead_time.map(Printed::exact),
        set: |s, printed| s.offer_mut().lead_time = Some(printed.value),
    };
}

/// What a number may state of itself behind its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum States {
    /// Nothing.
    Nothing,
    /// The convention that it is given in.
    Convention(Convention),
    /// The side of the gear that it is given at. The row keeps it at `kept`; at the other side it is the same number times
    /// N to this power, or cannot be converted.
    Side {
        /// Where the row keeps it.
        kept: Side,
        /// The kept number is that at the other side times N to this power.
        power: Option<i32>,
    },
}

/// A side of a gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// That of the motor: the gear's input.
    Motor,
    /// That of the load.
    Output,
}

impl Side {
    /// The words of both.
    pub const WORDS: &'static [&'static str] = &["motor", "output"];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Side::Motor => "motor",
            Side::Output => "output",
        }
    }
}

impl States {
    /// The words that may stand behind the unit.
    pub fn words(self) -> Words {
        match self {
            States::Nothing => Words::NONE,
            States::Convention(convention) => Words { convention: convention.words(), side: &[] },
            States::Side { .. } => Words { convention: &[], side: Side::WORDS },
        }
    }
}

impl<R: 'static> Column<R> {
    fn in_csv(&self) -> CsvColumn {
        let content = match self.holds {
            Holds::Count(..) => Content::Count,
            Holds::Text(..) | Holds::Choice(..) => Content::Text,
            Holds::Pairs(kinds, ..) => Content::Pairs(kinds),
        };
        CsvColumn { name: self.name.into(), content, required: self.need != Need::May }
    }
}

/// The columns of a kind of row as a table of CSV has them, in the order of the documentation: what must be there first,
/// numbers last.
pub(crate) fn csv_columns<R: Row>() -> Vec<CsvColumn> {
    let others = || R::BEFORE.iter().chain(R::AFTER);
    let (mut columns, mut counts) = (Vec::new(), Vec::new());
    columns.extend(others().filter(|c| c.need != Need::May).map(Column::in_csv));
    for column in others().filter(|c| c.need == Need::May) {
        let place = if matches!(column.holds, Holds::Count(..)) { &mut counts } else { &mut columns };
        place.push(column.in_csv());
    }
    columns.append(&mut counts);
    for field in R::fields() {
        let content = match field.states {
            States::Nothing => Content::Quantity(field.kind, field.range),
            states => Content::Stated(field.kind, field.range, states.words()),
        };
        let required = R::REQUIRED.contains(&field.name);
        columns.push(CsvColumn { name: field.name.into(), content, required });
        if let Some(name) = field.tolerance {
            columns.push(CsvColumn { name: name.into(), content: Content::Tolerance(field.kind), required: false });
        }
    }
    columns
}

/// What a column is, by its name.
pub fn about<R: Row>(name: &str) -> Option<&'static str> {
    let other = R::BEFORE.iter().chain(R::AFTER).find(|c| c.name == name).map(|c| c.about);
    other.or_else(|| R::fields().iter().find(|f| f.name == name).map(|f| f.about))
}

/// The words that may stand in a column, where it takes words.
pub fn choices<R: Row>(name: &str) -> &'static [&'static str] {
    let column = R::BEFORE.iter().chain(R::AFTER).find(|c| c.name == name);
    match column.map(|c| &c.holds) {
        Some(Holds::Choice(words, ..)) => words,
        _ => &[],
    }
}

/// The columns that every kind of row has: name and source, and what its price refers to.
macro_rules! identity {
    (id) => {
        Column {
            name: "id",
            about: "unique; lower-case letters, digits, `-`, `_`, `.`",
            need: Need::Must("\"t-motor-ri50-fitted\""),
            holds: Holds::Text(|r| r.id.clone(), |r, text| r.id = text),
        }
    };
    (manufacturer) => {
        Column {
            name: "manufacturer",
            about: "who makes it",
            need: Need::May,
            holds: Holds::Text(|r| r.manufacturer.clone(), |r, text| r.manufacturer = text),
        }
    };
    (model) => {
        Column {
            name: "model",
            about: "what its maker calls it",
            need: Need::May,
            holds: Holds::Text(|r| r.model.clone(), |r, text| r.model = text),
        }
    };
    (price_currency) => {
        Column {
            name: "price_currency",
            about: "currency of `price`, a code of ISO 4217; needed with it",
            need: Need::May,
            holds: Holds::Text(
                |r| r.numbers().offer().price_currency.clone(),
                |r, text| r.numbers_mut().offer_mut().price_currency = text,
            ),
        }
    };
    (price_date) => {
        Column {
            name: "price_date",
            about: "day of `price`, as 2026-11-01; needed with it",
            need: Need::May,
            holds: Holds::Text(
                |r| r.numbers().offer().price_date.clone(),
                |r, text| r.numbers_mut().offer_mut().price_date = text,
            ),
        }
    };
    (source) => {
        Column {
            name: "source",
            about: "where the numbers come from",
            need: Need::Must("\"data sheet RI50, 2024\""),
            holds: Holds::Text(|r| r.source.clone(), |r, text| r.source = text),
        }
    };
    (source_date) => {
        Column {
            name: "source_date",
            about: "day, month or year of the source, as 2026-11-01, 2026-11 or 2026; of a source without one the day on which it was read",
            need: Need::May,
            holds: Holds::Text(|r| r.source_date.clone(), |r, text| r.source_date = text),
        }
    };
    (source_kind) => {
        Column {
            name: "source_kind",
            about: "what kind of source that is",
            need: Need::Must("\"datasheet\""),
            holds: Holds::Choice(
                SourceKind::WORDS,
                |r| Some(word(SourceKind::NAMES, &r.source_kind)),
                |r, text| r.source_kind = find(SourceKind::NAMES, text).unwrap_or(r.source_kind),
            ),
        }
    };
    (note) => {
        Column {
            name: "note",
            about: "what the reader of the row should know",
            need: Need::May,
            holds: Holds::Text(|r| r.note.clone(), |r, text| r.note = text),
        }
    };
}
use identity;

/// The value of a word.
pub(super) fn find<T: Copy>(names: &[(&'static str, T)], word: &str) -> Option<T> {
    names.iter().find(|(name, _)| *name == word).map(|(_, value)| *value)
}

/// A text that is a list: separated by blanks or `;`.
pub(super) fn listed(text: &str) -> Vec<String> {
    text.split([';', ' ']).filter(|s| !s.is_empty()).map(str::to_string).collect()
}

#[cfg(test)]
mod tests;
