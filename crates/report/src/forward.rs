//! The forward check as lines of the story.

use super::number;
use super::table::{Column, Table, paragraph_at};
use gearwise_identify::simulate::{Errors, ForwardCheck};

fn rows(check: &ForwardCheck) -> Vec<(&'static str, Errors)> {
    let mut rows = vec![("as declared", check.before), ("as fitted", check.after)];
    rows.extend(check.refitted.map(|e| ("fitted for simulation", e)));
    rows
}

/// Error of the simulated position before and after, and with the model fitted for simulation; as text of a width.
pub fn text_at(check: &ForwardCheck, width: usize) -> String {
    let held = rows(check).iter().any(|r| r.1.held_out.is_some());
    let mut columns = vec![Column::name("simulated"), Column::number("fit", check.unit)];
    columns.extend(held.then(|| Column::number("held out", check.unit)));
    let cells = rows(check).into_iter().map(|(label, errors)| {
        let mut row = vec![label.to_string(), number(errors.fit)];
        if held {
            row.push(errors.held_out.map_or_else(|| "–".into(), number));
        }
        row
    });
    let how = if check.closed_loop { "the goal through the declared controller" } else { "what was put in" };
    let say = |line: &str| paragraph_at(line, 0, 2, width);
    let mut text = say(&format!("Position simulated forward from {how}, error (rms):"));
    text += &Table::new(columns).rows(cells).text_at(width);
    if !check.without.is_empty() {
        let without = check.without.join(", ");
        text += &say(&format!("To simulate, the model is better without {without}: on left-out parts of the logs."));
    }
    if !check.not_simulated.is_empty() {
        text += &say(&format!("Not simulated: {}.", check.not_simulated.join(", ")));
    }
    text
}

/// [`text_at`] of the width that was decided.
pub fn text(check: &ForwardCheck) -> String {
    text_at(check, super::table::width())
}
