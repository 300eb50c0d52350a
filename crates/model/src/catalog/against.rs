//! A catalogue against a second source of the same rows: which numbers they do not have in common.

use std::collections::{BTreeMap, HashMap};

use super::difference::{Became, Cell, Change, Difference, difference};
use super::row::{MotorRow, Row};
use super::{Catalog, Gear, Module, Motor};

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
    /// Numbers that both give, whose electrical ones mean the same in both.
    pub compared: usize,
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
    let mut found = Against {
        both: 0,
        own: 0,
        second: 0,
        compared: 0,
        apart: Vec::new(),
        lacking: Vec::new(),
        conventions: Vec::new(),
    };
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
    found.compared = compared(catalog, &second, &found.conventions);
    // Points of families are gears, too.
    found.both = catalog.motors.len() + catalog.all_gears().count() + catalog.modules.len() - found.own;
    found
}

/// Numbers that rows of both give.
fn compared(catalog: &Catalog, second: &Catalog, conventions: &[String]) -> usize {
    fn shared<R: Row>(own: &R, second: &R, counts: bool) -> usize {
        let is_counted = |name: &str| counts || !ELECTRICAL.contains(&name);
        let fields = R::fields().iter().filter(|f| is_counted(f.name));
        fields.filter(|f| (f.get)(own.numbers()).is_some() && (f.get)(second.numbers()).is_some()).count()
    }
    let means_same = |id: &String| !conventions.contains(id);
    let motors: HashMap<&str, &Motor> = second.motors.iter().map(|m| (m.id.as_str(), m)).collect();
    let gears: HashMap<&str, &Gear> = second.all_gears().map(|g| (g.id.as_str(), g)).collect();
    let modules: HashMap<&str, &Module> = second.modules.iter().map(|m| (m.id.as_str(), m)).collect();
    let of_motors = catalog
        .motors
        .iter()
        .filter_map(|m| Some(shared(&MotorRow::of(m), &MotorRow::of(motors.get(m.id.as_str())?), means_same(&m.id))));
    let of_gears = catalog.all_gears().filter_map(|g| Some(shared(g, *gears.get(g.id.as_str())?, true)));
    let of_modules =
        catalog.modules.iter().filter_map(|m| Some(shared(m, *modules.get(m.id.as_str())?, means_same(&m.id))));
    of_motors.chain(of_gears).chain(of_modules).sum()
}

/// Columns that hold counts.
const COUNTS: &[&str] = &["pole_pairs", "stages", "encoder_bits_motor", "encoder_bits_output"];

/// A number or a count.
fn value(column: &str, cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Number { printed, .. } => Some(printed.value),
        Cell::Text(text) if COUNTS.contains(&column) => text.parse().ok(),
        Cell::Text(_) => None,
    }
}

/// By how much a number of the second differs, as a share of ours; `None` where either has none, or no number.
pub fn share(change: &Change) -> Option<f64> {
    let number = |cell: &Option<Cell>| value(change.column, cell.as_ref()?);
    let (a, b) = (number(&change.before)?, number(&change.after)?);
    Some(if a == 0.0 { f64::INFINITY } else { b / a - 1.0 })
}

fn is_apart(change: &Change) -> bool {
    share(change).is_some_and(|share| share.abs() > APART)
}

fn is_lacking(change: &Change) -> bool {
    let number = |cell: &Option<Cell>| cell.as_ref().is_some_and(|cell| value(change.column, cell).is_some());
    (number(&change.before) && change.after.is_none()) || (change.before.is_none() && number(&change.after))
}
