//! The one writer of rows: as a file of CSV, or as tables of TOML. What is written is read back as the same row.

use std::fmt::Write as _;

use super::{Column, Field, Holds, Need, Row};
use crate::catalog::fitted::settled_difference;
use crate::catalog::sheet::Printed;
use crate::input::Stated;
use crate::units::Kind;

/// The shortest text that reads back as the same number; blank where there is none.
pub fn cell(value: Option<f64>) -> String {
    match value {
        Some(v) if v != 0.0 && !(1e-4..1e7).contains(&v.abs()) => format!("{v:e}"),
        Some(v) => v.to_string(),
        None => String::new(),
    }
}

/// A column of the header: its name, with the SI unit that its cells have and what they state of themselves.
fn head(name: &str, kind: &Kind, stated: Stated) -> String {
    let brackets = stated.after(if kind.needs_unit() { kind.si } else { "" });
    if brackets.is_empty() { name.into() } else { format!("{name} [{brackets}]") }
}

/// What a column that holds no number has in a row.
pub fn text<R>(column: &Column<R>, row: &R) -> String {
    match column.holds {
        Holds::Text(get, _) => get(row),
        Holds::Choice(_, get, _) => get(row).unwrap_or_default().to_string(),
        Holds::Count(get, _) => get(row).map_or_else(String::new, |count| count.to_string()),
        Holds::Pairs(_, get, _) => {
            let pair = |[a, b]: &[f64; 2]| format!("{}:{}", cell(Some(*a)), cell(Some(*b)));
            get(row).iter().map(pair).collect::<Vec<_>>().join(" ")
        }
    }
}

/// A column of the file and its cells.
type Cells = (String, Vec<String>);

/// Rows as a file of CSV, in SI. Columns that no row fills are left out, but for those that must be there and those of
/// `always`.
pub fn csv_text<R: Row>(rows: &[R], always: &[&str]) -> String {
    let keep = |name: &str, need: Need, cells: &[String]| {
        need != Need::May || always.contains(&name) || cells.iter().any(|c| !c.is_empty())
    };
    let others = |columns: &'static [Column<R>]| {
        columns.iter().filter_map(move |column| {
            let cells: Vec<String> = rows.iter().map(|row| text(column, row)).collect();
            let name = match column.holds {
                Holds::Pairs([(first, _), (second, _)], ..) => {
                    format!("{} [{} : {}]", column.name, first.si, second.si)
                }
                _ => column.name.to_string(),
            };
            keep(column.name, column.need, &cells).then_some((name, cells))
        })
    };
    let mut columns: Vec<Cells> = others(R::BEFORE).collect();
    R::fields().iter().for_each(|field| columns.extend(number_columns(rows, field, always)));
    columns.extend(others(R::AFTER));
    let header: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let line = |k: usize| columns.iter().map(|(_, cells)| cells[k].clone()).collect();
    crate::words::csv::csv_text(&header, (0..rows.len()).map(line))
}

/// The columns of a number: one for each thing that rows state of it, and that of its ±.
fn number_columns<R: Row>(rows: &[R], field: &'static Field<R::Numbers>, always: &[&str]) -> Vec<Cells> {
    let printed: Vec<(Stated, Option<Printed>)> =
        rows.iter().map(|row| (row.states(field), (field.get)(row.numbers()))).collect();
    let mut stated: Vec<Stated> = Vec::new();
    for (states, _) in printed.iter().filter(|(_, number)| number.is_some()) {
        if !stated.contains(states) {
            stated.push(*states);
        }
    }
    if stated.is_empty() && (R::REQUIRED.contains(&field.name) || always.contains(&field.name)) {
        stated.push(Stated::default());
    }
    let of = |states: &Stated| {
        let own = |(of, number): &(Stated, Option<Printed>)| cell(number.filter(|_| of == states).map(|p| p.value));
        (head(field.name, field.kind, *states), printed.iter().map(own).collect())
    };
    let mut columns: Vec<Cells> = stated.iter().map(of).collect();
    if let Some(name) =
        field.tolerance.filter(|_| printed.iter().any(|(_, p)| p.is_some_and(|p| p.tolerance.is_some())))
    {
        let cells = printed.iter().map(|(_, p)| cell(p.and_then(|p| p.tolerance))).collect();
        columns.push((head(name, field.kind, Stated::default()), cells));
    }
    columns
}

/// A row as the lines of a table of TOML, without its header.
pub fn toml_text<R: Row>(row: &R) -> String {
    let mut out = String::new();
    let others = |out: &mut String, columns: &'static [Column<R>]| {
        for column in columns {
            let text = text(column, row);
            match column.holds {
                Holds::Count(..) if !text.is_empty() => {
                    let _ = writeln!(out, "{} = {text}", column.name);
                }
                Holds::Pairs([(first, _), (second, _)], get, _) if !text.is_empty() => {
                    let pair = |[a, b]: &[f64; 2]| {
                        format!("[\"{} {}\", \"{} {}\"]", digits(*a), first.si, digits(*b), second.si)
                    };
                    let pairs: Vec<String> = get(row).iter().map(pair).collect();
                    let _ = writeln!(out, "{} = [{}]", column.name, pairs.join(", "));
                }
                _ => say(out, column.name, &text),
            }
        }
    };
    others(&mut out, R::BEFORE);
    out.push_str(&numbers_text(row));
    others(&mut out, R::AFTER);
    out
}

/// Numbers of a row as the lines of a table of TOML.
fn numbers_text<R: Row>(row: &R) -> String {
    let mut out = String::new();
    for field in R::fields() {
        if let Some(number) = (field.get)(row.numbers()).filter(|n| n.value.is_finite()) {
            number_line(&mut out, field.name, field.tolerance, number, field.kind, row.states(field));
        }
    }
    out
}

/// A text in TOML; nothing where it is blank. Writing to a string does not fail.
pub fn say(out: &mut String, key: &str, value: &str) {
    if !value.is_empty() {
        let _ = writeln!(out, "{key} = {}", quoted(value));
    }
}

/// A text in quotes, as TOML has it.
pub fn quoted(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

/// A number and its ± in TOML.
pub fn number_line(
    out: &mut String,
    key: &str,
    tolerance_key: Option<&str>,
    number: Printed,
    kind: &Kind,
    stated: Stated,
) {
    let celsius = settled_difference(number.value - 273.15);
    match kind.si {
        // What is read is exactly this number, so the temperature that people know is written where it gives it back.
        "K" if celsius + 273.15 == number.value => line(out, key, celsius, &stated.after("degC")),
        si => line(out, key, number.value, &stated.after(si)),
    }
    if let (Some(tolerance), Some(key)) = (number.tolerance, tolerance_key) {
        line(out, key, tolerance, kind.si);
    }
}

/// A number with its unit in TOML.
fn line(out: &mut String, key: &str, value: f64, unit: &str) {
    let _ = match unit {
        "1" => writeln!(out, "{key} = {}", digits(value)),
        _ => writeln!(out, "{key} = \"{} {unit}\"", digits(value)),
    };
}

/// A number as it is, in the form that is shorter to read.
fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e7).contains(&size) { value.to_string() } else { format!("{value:e}") }
}
