//! What two catalogues do not have in common.

use super::unit_for;
use crate::table::paragraph;
use crate::{counted, number};
use gearwise_model::catalog::difference::{Became, Cell, Change, Difference};
use gearwise_model::units::in_unit;
use gearwise_model::words::csv::{csv_number, csv_text};

/// Both sides of a change in words, numbers in one unit.
pub(crate) fn sides(change: &Change) -> [String; 2] {
    let cells = [&change.before, &change.after];
    let unit = cells.iter().find_map(|cell| match cell {
        Some(Cell::Number { printed, kind, .. }) => Some(unit_for(kind, printed.value)),
        _ => None,
    });
    let write = |digits: fn(f64) -> String| {
        cells.map(|cell| match cell {
            None => "blank".to_string(),
            Some(Cell::Text(text)) => format!("\"{text}\""),
            Some(Cell::Number { printed, stated, .. }) => {
                let unit = unit.unwrap_or("1");
                // A difference of temperatures has no offset.
                let tolerance = printed.tolerance.map(|t| {
                    let scaled = if unit == "degC" { t } else { in_unit(t, unit) };
                    format!(" ±{}", digits(scaled))
                });
                let after = stated.after(if unit == "1" { "" } else { unit });
                let text = format!("{}{} {after}", digits(in_unit(printed.value, unit)), tolerance.unwrap_or_default());
                text.trim_end().to_string()
            }
        })
    };
    // Four digits, unless they do not show what is different.
    match write(number) {
        [a, b] if a != b => [a, b],
        _ => write(|value| value.to_string()),
    }
}

/// How many rows were added, removed and changed.
pub fn counts(differences: &[Difference]) -> [usize; 3] {
    let count = |is: fn(&Became) -> bool| differences.iter().filter(|d| is(&d.became)).count();
    [count(|b| *b == Became::Added), count(|b| *b == Became::Removed), count(|b| matches!(b, Became::Changed(_)))]
}

/// For people.
pub fn text(differences: &[Difference]) -> String {
    if differences.is_empty() {
        return paragraph("No difference.", 0, 2);
    }
    let mut out = String::new();
    for difference in differences {
        let (sign, what) = match &difference.became {
            Became::Added => ("+", "added"),
            Became::Removed => ("-", "removed"),
            Became::Changed(_) => ("~", "changed"),
        };
        out.push_str(&paragraph(&format!("{sign} {} {}: {what}", difference.kind, difference.id), 0, 4));
        if let Became::Changed(changes) = &difference.became {
            for change in changes {
                let [before, after] = sides(change);
                out.push_str(&paragraph(&format!("{}: {before} → {after}", change.column), 4, 6));
            }
        }
    }
    let [added, removed, changed] = counts(differences);
    out.push('\n');
    let line = format!("{}: {added} added, {removed} removed, {changed} changed.", counted(differences.len(), "row"));
    out + &paragraph(&line, 0, 2)
}

/// As rows: one for each row that one catalogue alone has, one for each column that is not the same.
pub fn csv(differences: &[Difference]) -> String {
    let header = ["kind", "id", "became", "column", "unit", "before", "after", "before_states", "after_states"];
    let cell = |cell: &Option<Cell>| match cell {
        None => [String::new(), String::new(), String::new()],
        Some(Cell::Text(text)) => [text.clone(), String::new(), String::new()],
        Some(Cell::Number { printed, kind, stated }) => {
            [csv_number(Some(printed.value)), kind.si.into(), stated.after("")]
        }
    };
    let rows = differences.iter().flat_map(|d| {
        let row = |became: &str, rest: [String; 6]| {
            let mut row = vec![d.kind.to_string(), d.id.clone(), became.to_string()];
            row.extend(rest);
            row
        };
        match &d.became {
            Became::Added => vec![row("added", Default::default())],
            Became::Removed => vec![row("removed", Default::default())],
            Became::Changed(changes) => {
                let line = |change: &Change| {
                    let [before, unit, stated] = cell(&change.before);
                    let [after, other, also] = cell(&change.after);
                    let unit = if unit.is_empty() { other } else { unit };
                    row("changed", [change.column.to_string(), unit, before, after, stated, also])
                };
                changes.iter().map(line).collect()
            }
        }
    });
    csv_text(&header, rows)
}
