//! The forward check as lines of the story, and for programs.

use serde_json::{Map, Value, json};

use super::number;
use super::table::{Column, Table, paragraph_at};
use crate::measured::simulate::{Errors, ForwardCheck};

fn rows(check: &ForwardCheck) -> Vec<(&'static str, &'static str, Errors)> {
    let mut rows = vec![("declared", "as declared", check.before), ("fitted", "as fitted", check.after)];
    rows.extend(check.refitted.map(|e| ("fitted_for_simulation", "fitted for simulation", e)));
    rows
}

/// Error of the simulated position before and after, and with the model fitted for simulation; as text of a width.
pub fn text_at(check: &ForwardCheck, width: usize) -> String {
    let held = rows(check).iter().any(|r| r.2.held_out.is_some());
    let mut columns = vec![Column::name("simulated"), Column::number("fit", check.unit)];
    columns.extend(held.then(|| Column::number("held out", check.unit)));
    let cells = rows(check).into_iter().map(|(_, label, errors)| {
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

/// The same for programs.
pub fn json(check: &ForwardCheck) -> Value {
    let mut map = Map::new();
    for (key, _, errors) in rows(check) {
        map.insert(key.into(), json!({ "fit": errors.fit, "held_out": errors.held_out }));
    }
    map.insert("unit".into(), json!(check.unit));
    map.insert("closed_loop".into(), json!(check.closed_loop));
    let parameters: Map<String, Value> =
        check.refitted_parameters.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
    map.insert("parameters_for_simulation".into(), Value::Object(parameters));
    map.insert("without".into(), json!(check.without));
    map.insert("not_simulated".into(), json!(check.not_simulated));
    Value::Object(map)
}
