//! What is not the same in two catalogues, row by row and column by column.

use super::filter::text_of;
use super::row::{MotorRow, Row};
use super::{Catalog, Gear, Printed};
use crate::input::Stated;
use crate::units::Kind;

/// What a cell says.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A text or a whole number.
    Text(String),
    /// A number, SI.
    Number {
        /// The number and its ±.
        printed: Printed,
        /// What it measures.
        kind: &'static Kind,
        /// What it states of itself.
        stated: Stated,
    },
}

/// A column that is not the same in two rows; `None` is blank.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The column.
    pub column: &'static str,
    /// In the first catalogue.
    pub before: Option<Cell>,
    /// In the second.
    pub after: Option<Cell>,
}

/// What became of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Became {
    /// The second catalogue alone has it.
    Added,
    /// The first alone has it.
    Removed,
    /// Both have it, and it is not the same.
    Changed(Vec<Change>),
}

/// A row that is not the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// `motor`, `gear` or `module`.
    pub kind: &'static str,
    /// Its id.
    pub id: String,
    /// What became of it.
    pub became: Became,
}

/// Numbers that differ by less (relative) are the same: what is left of a unit's conversion.
const SAME: f64 = 1e-12;

/// The differences of two catalogues by id: motors, then gears, then modules.
pub fn difference(before: &Catalog, after: &Catalog) -> Vec<Difference> {
    let rows = |catalog: &Catalog| -> Vec<MotorRow> { catalog.motors.iter().map(MotorRow::of).collect() };
    let motors = between("motor", &rows(before), &rows(after), |row| &row.id);
    let all = |catalog: &Catalog| -> Vec<Gear> { catalog.all_gears().cloned().collect() };
    let gears = between("gear", &all(before), &all(after), |row| &row.id);
    let modules = between("module", &before.modules, &after.modules, |row| &row.id);
    motors.into_iter().chain(gears).chain(modules).collect()
}

fn between<R: Row>(kind: &'static str, before: &[R], after: &[R], id: fn(&R) -> &String) -> Vec<Difference> {
    let find = |rows: &'_ [R], wanted: &String| rows.iter().position(|row| id(row) == wanted);
    let mut all: Vec<&String> = before.iter().chain(after).map(id).collect();
    all.sort_unstable();
    all.dedup();
    let of = |wanted: &String| {
        let became = match (find(before, wanted), find(after, wanted)) {
            (Some(a), Some(b)) => match changes(&before[a], &after[b]) {
                changes if changes.is_empty() => return None,
                changes => Became::Changed(changes),
            },
            (None, _) => Became::Added,
            (_, None) => Became::Removed,
        };
        Some(Difference { kind, id: wanted.clone(), became })
    };
    all.into_iter().filter_map(of).collect()
}

fn changes<R: Row>(before: &R, after: &R) -> Vec<Change> {
    let others = |columns: &'static [super::row::Column<R>]| {
        columns.iter().map(move |column| {
            let text = |row: &R| text_of(column, row).map(Cell::Text);
            (column.name, text(before), text(after))
        })
    };
    let numbers = R::fields().iter().map(|field| {
        let number = |row: &R| {
            let printed = (field.get)(row.numbers())?;
            Some(Cell::Number { printed, kind: field.kind, stated: row.states(field) })
        };
        (field.name, number(before), number(after))
    });
    let all = others(R::BEFORE).chain(numbers).chain(others(R::AFTER));
    let is_change = |(_, before, after): &(&str, Option<Cell>, Option<Cell>)| !same(before.as_ref(), after.as_ref());
    all.filter(is_change).map(|(column, before, after)| Change { column, before, after }).collect()
}

fn same(a: Option<&Cell>, b: Option<&Cell>) -> bool {
    let near = |a: f64, b: f64| a == b || (a - b).abs() <= SAME * a.abs().max(b.abs());
    match (a, b) {
        (Some(Cell::Number { printed: a, stated: of_a, .. }), Some(Cell::Number { printed: b, stated: of_b, .. })) => {
            let tolerances = match (a.tolerance, b.tolerance) {
                (Some(a), Some(b)) => near(a, b),
                (a, b) => a == b,
            };
            near(a.value, b.value) && tolerances && of_a == of_b
        }
        (a, b) => a == b,
    }
}
