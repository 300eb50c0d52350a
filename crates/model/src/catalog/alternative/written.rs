//! A table of alternatives as it is written: each line is of a row and a column that are there.

use std::ops::Range as Span;
use std::sync::Arc;

use super::{Alternative, words};
use crate::catalog::module::Module;
use crate::catalog::offer::wrong_day;
use crate::catalog::row::{Cells, Holds, MotorRow, Need, Row, Side, find};
use crate::catalog::sheet::{Printed, SourceKind};
use crate::catalog::{Catalog, Gear};
use crate::input::csv::{Column, Content};
use crate::input::{InputError, Problem, Source};
use crate::units::{self, Kind};
use crate::words::nearest;

/// What stands where a source does not say side or convention.
const NOT_SAID: &str = "not said";

/// A line of a file, before its row is known.
#[derive(Debug, Clone)]
pub(in crate::catalog) struct Written {
    /// Texts of the columns, in the order of [`COLUMNS`], each with its place.
    cells: Vec<(String, Span<usize>)>,
}

/// The columns, whether a line must have them, and what they are.
pub const COLUMNS: &[(&str, bool, &str)] = &[
    ("id", true, "id of a row of the catalogue"),
    ("column", true, "column of that row: a number, a curve or a table"),
    ("value", true, "as printed"),
    ("unit", false, "its unit"),
    ("side", false, "`motor`, `output`, or `not said`: at which side of the gear it is"),
    ("convention", false, "the word of its convention, or `not said`"),
    ("tolerance", false, "its ±, in the same unit"),
    ("source", true, "where it is from"),
    ("source_kind", true, "as of rows"),
    ("source_date", false, "the day of the source"),
    ("note", false, "what the reader should know"),
];

/// The columns of a table of alternatives.
pub(in crate::catalog) fn columns() -> Vec<Column> {
    let column = |(name, required, _): &(&str, bool, &str)| Column {
        name: (*name).into(),
        content: Content::Text,
        required: *required,
    };
    COLUMNS.iter().map(column).collect()
}

/// Reads a line.
pub(in crate::catalog) fn read(cells: &dyn Cells) -> Option<Written> {
    let before = cells.noted();
    let mut of = |(name, required, _): &(&'static str, bool, &str)| {
        let text = cells.text((*name).into()).unwrap_or_default();
        if text.is_empty() && *required {
            cells.blank(name, Need::Must("…"), &[]);
        }
        (text, cells.span(name))
    };
    let written = Written { cells: COLUMNS.iter().map(&mut of).collect() };
    (cells.noted() == before).then_some(written)
}

/// A column of some kind of row.
#[derive(Debug, Clone, Copy)]
enum Meant {
    Number(&'static Kind),
    Other,
}

/// The columns of a kind of row that an alternative may be of, each with its content.
fn meant<R: Row>() -> impl Iterator<Item = (&'static str, Meant)> {
    let others = R::BEFORE.iter().chain(R::AFTER);
    let others =
        others.filter(|c| matches!(c.holds, Holds::Pairs(..) | Holds::Count(..))).map(|c| (c.name, Meant::Other));
    R::fields().iter().map(|field| (field.name, Meant::Number(field.kind))).chain(others)
}

impl Written {
    fn get(&self, name: &str) -> (&str, Span<usize>) {
        let at = COLUMNS.iter().position(|(column, ..)| *column == name).expect("a column");
        let (text, span) = &self.cells[at];
        (text.as_str(), span.clone())
    }

    /// The alternative, of the row that it names.
    ///
    /// # Errors
    /// What is wrong with the line.
    fn resolve(&self, catalog: &Catalog) -> Result<Alternative, Problem> {
        let (id, at) = self.get("id");
        let columns: Vec<(&'static str, Meant)> = match () {
            () if catalog.modules.iter().any(|m| m.id == id) => meant::<Module>().collect(),
            () if catalog.motors.iter().any(|m| m.id == id) => meant::<MotorRow>().collect(),
            () if catalog.gears.iter().any(|g| g.id == id) => meant::<Gear>().collect(),
            () => {
                let motors = catalog.motors.iter().map(|m| m.id.as_str());
                let all = motors.chain(catalog.gears.iter().map(|g| g.id.as_str()));
                let near = nearest(id, all.chain(catalog.modules.iter().map(|m| m.id.as_str())));
                let help = near.map_or_else(|| "an alternative is of a row".into(), |n| format!("did you mean `{n}`?"));
                return Err(
                    Problem::at(at, format!("there is no row `{id}` in the catalogue"), "no such id").help(help)
                );
            }
        };
        let (name, at) = self.get("column");
        let Some((column, meant)) = columns.iter().find(|(column, _)| *column == name).copied() else {
            let near = nearest(name, columns.iter().map(|(column, _)| *column));
            let help =
                near.map_or_else(|| "a column of numbers is expected".into(), |n| format!("did you mean `{n}`?"));
            return Err(Problem::at(at, format!("the row `{id}` has no number `{name}`"), "no such column").help(help));
        };
        let ((value, at), (unit, unit_at), (tolerance, tolerance_at)) =
            (self.get("value"), self.get("unit"), self.get("tolerance"));
        let wrong = |error: units::UnitError, kind: &Kind, at: Span<usize>| {
            Problem::at(at, error.message(kind), "in this line").help(error.help(kind))
        };
        let printed = match meant {
            Meant::Other => None,
            Meant::Number(kind) => {
                let with_unit = |text: &str| format!("{text} {unit}");
                let place = if unit.is_empty() || units::number_value(value).is_err() { at.clone() } else { unit_at };
                let value = units::quantity(&with_unit(value), kind).map_err(|error| wrong(error, kind, place))?;
                let tolerance = match tolerance {
                    "" => None,
                    text => {
                        Some(units::difference(&with_unit(text), kind).map_err(|e| wrong(e, kind, tolerance_at))?.abs())
                    }
                };
                Some(Printed { value, tolerance })
            }
        };
        let (side, at) = self.get("side");
        let side = match side {
            "" | NOT_SAID => None,
            word => Some(find(Side::NAMES, word).ok_or_else(|| {
                Problem::at(at, format!("`{word}` is no side of a gear"), "expected `motor`, `output` or blank")
            })?),
        };
        let (convention, at) = self.get("convention");
        let words = words(column);
        let convention = match convention {
            "" | NOT_SAID => None,
            word => Some(words.iter().find(|known| **known == word).copied().ok_or_else(|| {
                let expected = match words {
                    [] => "this column has no convention: leave it blank".to_string(),
                    words => format!("one of {}, or `{NOT_SAID}`", words.join(", ")),
                };
                Problem::at(at, format!("`{word}` is no convention of `{column}`"), "not known").help(expected)
            })?),
        };
        let (kind, at) = self.get("source_kind");
        let source_kind = find(SourceKind::NAMES, kind).ok_or_else(|| {
            let known: Vec<&str> = SourceKind::NAMES.iter().map(|(name, _)| *name).collect();
            Problem::at(at, format!("`{kind}` is no kind of source"), format!("expected one of {}", known.join(", ")))
        })?;
        let (day, at) = self.get("source_date");
        if let Some(wrong) = wrong_day("source_date", day) {
            return Err(Problem::at(at, wrong.message, "a date").help(wrong.help));
        }
        Ok(Alternative {
            id: id.into(),
            column,
            text: [value, unit].join(" ").trim().to_string(),
            value: printed,
            unit: if let Meant::Number(kind) = meant { kind.si } else { "" },
            side,
            convention,
            source: self.get("source").0.into(),
            source_date: day.into(),
            source_kind,
            note: self.get("note").0.into(),
        })
    }
}

/// The alternatives of files, each of a row that is there.
///
/// # Errors
/// The wrong lines.
pub(in crate::catalog) fn resolve(
    written: Vec<(Arc<Source>, Vec<Written>)>,
    catalog: &Catalog,
) -> Result<Vec<Alternative>, Vec<InputError>> {
    let (mut all, mut errors) = (Vec::new(), Vec::new());
    for (source, lines) in written {
        let mut problems = Vec::new();
        for line in &lines {
            match line.resolve(catalog) {
                Ok(alternative) => all.push(alternative),
                Err(problem) => problems.push(problem),
            }
        }
        if !problems.is_empty() {
            errors.push(InputError { source, problems });
        }
    }
    // Stable: what stands in a file stays in its order.
    all.sort_by(|a, b| (&a.id, a.column).cmp(&(&b.id, b.column)));
    if errors.is_empty() { Ok(all) } else { Err(errors) }
}

impl Catalog {
    /// What other sources say of a row.
    pub fn alternatives_of<'c>(&'c self, id: &'c str) -> impl Iterator<Item = &'c Alternative> {
        self.alternatives.iter().filter(move |a| a.id == id)
    }
}
