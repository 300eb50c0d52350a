//! A catalogue against a second source of the same rows: which numbers they do not have in common.

use std::collections::BTreeMap;

use super::Catalog;
use super::difference::{Became, Cell, Change, Difference, difference};

/// Share by which two sources may differ: what rounding to three digits leaves.
pub const APART: f64 = 0.01;

/// What a second source says otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Against {
    /// Rows that both have.
    pub both: usize,
    /// Rows that the catalogue alone has.
    pub own: usize,
    /// Rows that the second source alone has.
    pub second: usize,
    /// Numbers of both that are more than [`APART`] apart, row by row.
    pub apart: Vec<Difference>,
    /// Numbers that one of them lacks, row by row.
    pub lacking: Vec<Difference>,
    /// Rows of which ampere, terminals or winding mean something else in the two: their electrical numbers are not compared.
    pub conventions: Vec<String>,
}

/// Columns that say what other numbers mean.
const CONVENTIONS: &[&str] =
    &["terminals", "current", "winding", "commutation", "back_emf_convention", "speed_constant_convention"];
/// Numbers that mean what those say.
const ELECTRICAL: &[&str] = &[
    "resistance",
    "inductance",
    "torque_constant",
    "back_emf_constant",
    "speed_constant",
    "continuous_current",
    "peak_current",
    "no_load_current",
    "motor_constant",
];

/// Compares a catalogue with a second one, whose ids may be others: `names` has theirs to ours.
pub fn against(catalog: &Catalog, second: &Catalog, names: &BTreeMap<String, String>) -> Against {
    let mut second = second.clone();
    let rename = |id: &mut String| {
        if let Some(ours) = names.get(id) {
            id.clone_from(ours);
        }
    };
    second.motors.iter_mut().for_each(|m| rename(&mut m.id));
    second.gears.iter_mut().for_each(|g| rename(&mut g.id));
    second.modules.iter_mut().for_each(|m| rename(&mut m.id));
    let mut found =
        Against { both: 0, own: 0, second: 0, apart: Vec::new(), lacking: Vec::new(), conventions: Vec::new() };
    for Difference { kind, id, became } in difference(catalog, &second) {
        let changes = match became {
            Became::Removed => {
                found.own += 1;
                continue;
            }
            Became::Added => {
                found.second += 1;
                continue;
            }
            Became::Changed(changes) => changes,
        };
        let means_else =
            changes.iter().any(|c| CONVENTIONS.contains(&c.column) && c.before.is_some() && c.after.is_some());
        if means_else {
            found.conventions.push(id.clone());
        }
        let is_compared = |c: &Change| !(means_else && ELECTRICAL.contains(&c.column));
        let of = |is: fn(&Change) -> bool| -> Vec<Change> {
            changes.iter().filter(|c| is_compared(c) && is(c)).cloned().collect()
        };
        let difference = |changes| Difference { kind, id: id.clone(), became: Became::Changed(changes) };
        let (apart, lacking) = (of(is_apart), of(is_lacking));
        found.apart.extend((!apart.is_empty()).then(|| difference(apart)));
        found.lacking.extend((!lacking.is_empty()).then(|| difference(lacking)));
    }
    // Points of families are gears, too.
    found.both = catalog.motors.len() + catalog.all_gears().count() + catalog.modules.len() - found.own;
    found
}

/// By how much a number of the second differs, as a share of ours; `None` where either has none, or no number.
pub fn share(change: &Change) -> Option<f64> {
    let (Some(Cell::Number { printed: a, .. }), Some(Cell::Number { printed: b, .. })) =
        (&change.before, &change.after)
    else {
        return None;
    };
    Some(if a.value == 0.0 { f64::INFINITY } else { b.value / a.value - 1.0 })
}

fn is_apart(change: &Change) -> bool {
    share(change).is_some_and(|share| share.abs() > APART)
}

fn is_lacking(change: &Change) -> bool {
    let number = |cell: &Option<Cell>| matches!(cell, Some(Cell::Number { .. }));
    (number(&change.before) && change.after.is_none()) || (change.before.is_none() && number(&change.after))
}
