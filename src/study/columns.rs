//! The columns of a study's results: the robot, the point of the grid, and those of [every design](columns).
//!
//! The one idea: a cell is its text in the CSV file, blank where unknown. Journal, CSV and Parquet hold the
//! same cells, so that no number is rounded on its way.

use std::collections::BTreeMap;

use super::plan::Plan;
use crate::design::answer::JointResult;
use crate::report::columns::{self, Entry};
use crate::report::optimize::designs;
use crate::report::reason::reason_text;
use crate::report::unjudged;

pub use crate::report::columns::Kind;

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: Kind,
}

/// How many motors of the joint cannot be judged: of the joint, not of a design.
const UNJUDGED: &str = "unjudged_motors";

/// The cells of a joint's rows: one row for each design, or one row that says why there is none.
pub fn rows(joint: &JointResult) -> Vec<Vec<String>> {
    let mut entries = designs(joint);
    if entries.is_empty() {
        entries.push(Entry::joint(joint.joint, because(joint)));
    }
    let row = |entry: &Entry| {
        let cells = columns::columns().iter().map(|column| column.cell(entry));
        cells.chain([joint.unjudged.len().to_string()]).collect()
    };
    entries.iter().map(row).collect()
}

/// Position of a column of [`rows`].
///
/// # Panics
/// There is no such column: the name is a literal of the program.
pub fn position(name: &str) -> usize {
    columns::columns().iter().position(|column| column.key == name).expect("a column of the results")
}

/// All columns: of the robot, of the grid, of the design.
pub fn all(plan: &Plan) -> Vec<Column> {
    let column = |name: &str, kind| Column { name: name.into(), kind };
    let mut all = vec![column("robot", Kind::Integer), column("requirement", Kind::Text), column("name", Kind::Text)];
    all.extend(of_grid(plan));
    all.extend(columns::columns().iter().map(|of| column(&of.key, of.kind)));
    all.push(column(UNJUDGED, Kind::Integer));
    all
}

/// The columns of the grid.
pub fn of_grid(plan: &Plan) -> impl Iterator<Item = Column> + '_ {
    plan.grid.iter().map(|p| Column { name: p.column.clone(), kind: if p.numeric { Kind::Number } else { Kind::Text } })
}

/// The cells of the grid at a point.
pub fn grid_cells(plan: &Plan, point: u64) -> impl Iterator<Item = &str> + '_ {
    (0..plan.grid.len()).map(move |k| plan.grid[k].cells[plan.value(k, point)].as_str())
}

/// Why a joint has no design: how many motors fail for which reason, the most frequent first.
fn because(joint: &JointResult) -> String {
    let mut classes: BTreeMap<String, usize> = BTreeMap::new();
    for unjudged in &joint.unjudged {
        *classes.entry(unjudged::class(&unjudged.because)).or_default() += 1;
    }
    for rejected in &joint.rejected {
        *classes.entry(reason_text(&rejected.reason, joint.joint).0).or_default() += 1;
    }
    let mut classes: Vec<(String, usize)> = classes.into_iter().collect();
    classes.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    let told: Vec<String> = classes.iter().take(3).map(|(why, n)| format!("{n} motors: {why}")).collect();
    told.join("; ")
}
