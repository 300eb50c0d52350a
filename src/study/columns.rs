//! The columns of the results: name with unit, type, and where the cell comes from.
//!
//! The one idea: a cell is its text in the CSV file, blank where unknown. Journal, CSV and Parquet hold the
//! same cells, so that no number is rounded on its way.

use std::collections::BTreeMap;

use super::plan::Plan;
use crate::design::optimize::{Design, JointResult};
use crate::design::program::Certificate;
use crate::report::optimize::reason_text;
use crate::report::{currents, spring, unjudged};
use crate::words::csv::csv_number;

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers.
    Integer,
    /// Numbers, in the unit that the name says (SI).
    Number,
    /// Text.
    Text,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: Kind,
}

/// Cells of one joint with one of its designs, or with none.
type Cell = fn(&JointResult, Option<(usize, &Design)>) -> String;

/// Columns of a design, each with how its cell is found.
const OF_DESIGN: &[(&str, Kind, Cell)] = &[
    ("joint", Kind::Text, |j, _| j.joint.name.clone()),
    ("joint_count", Kind::Integer, |j, _| j.joint.count.to_string()),
    ("rank", Kind::Integer, |_, d| d.map_or_else(String::new, |(place, _)| (place + 1).to_string())),
    ("motor", Kind::Text, |_, d| text(d, |d| d.motor.id.clone())),
    ("gear", Kind::Text, |_, d| text(d, |d| d.gear.unwrap_or_default().into())),
    ("ratio", Kind::Number, |_, d| number(d, |d| Some(d.optimum.ratio))),
    ("ratio_min", Kind::Number, |_, d| number(d, |d| Some(d.optimum.window().min))),
    ("ratio_max", Kind::Number, |_, d| number(d, |d| Some(d.optimum.window().max))),
    ("bound_low", Kind::Text, |_, d| text(d, |d| d.optimum.window().low.limit.into())),
    ("bound_high", Kind::Text, |_, d| text(d, |d| d.optimum.window().high.limit.into())),
    ("objective_is", Kind::Text, |j, _| j.joint.objective.name()),
    ("objective", Kind::Number, |_, d| number(d, |d| Some(d.optimum.objective))),
    ("gap", Kind::Number, |_, d| {
        number(d, |d| match d.optimum.certificate {
            Certificate::Certified { gap, .. } => Some(gap),
            Certificate::NotCertified(_) => None,
        })
    }),
    ("loss_w", Kind::Number, |_, d| number(d, |d| Some(d.evaluation.loss))),
    ("mean_electrical_power_w", Kind::Number, |_, d| number(d, |d| Some(d.evaluation.mean_power))),
    (currents::NAMES[0], Kind::Number, |_, d| current(d, 0)),
    (currents::NAMES[1], Kind::Number, |_, d| current(d, 1)),
    (currents::NAMES[2], Kind::Number, |_, d| current(d, 2)),
    (currents::NAMES[3], Kind::Number, |_, d| current(d, 3)),
    ("reflected_inertia_kgm2", Kind::Number, |_, d| number(d, |d| Some(d.evaluation.reflected_inertia))),
    ("mass_kg", Kind::Number, |_, d| number(d, |d| d.evaluation.mass)),
    ("winding_temperature_k", Kind::Number, |_, d| number(d, |d| d.winding_temperature.flatten())),
    ("tightest_limit", Kind::Text, |_, d| text(d, |d| d.evaluation.tightest().map_or("", |m| m.limit).into())),
    ("tightest_margin", Kind::Number, |_, d| number(d, |d| d.evaluation.tightest().map(|m| m.margin))),
    ("not_checked", Kind::Text, |_, d| text(d, |d| unjudged::names(&d.unchecked))),
    ("assumed", Kind::Text, |_, d| text(d, |d| unjudged::names(&d.assumed))),
    ("unjudged_motors", Kind::Integer, |j, _| j.unjudged.len().to_string()),
    ("spring_stiffness_nm_per_rad", Kind::Number, |_, d| of_spring(d, 0)),
    ("spring_rest_angle_rad", Kind::Number, |_, d| of_spring(d, 1)),
    ("no_design_because", Kind::Text, |j, d| if d.is_some() { String::new() } else { because(j) }),
];

fn text(design: Option<(usize, &Design)>, of: impl Fn(&Design) -> String) -> String {
    design.map_or_else(String::new, |(_, d)| of(d))
}

fn number(design: Option<(usize, &Design)>, of: impl Fn(&Design) -> Option<f64>) -> String {
    csv_number(design.and_then(|(_, d)| of(d)))
}

fn current(design: Option<(usize, &Design)>, which: usize) -> String {
    number(design, |d| Some(currents::values(d.motor, &d.evaluation)[which]))
}

fn of_spring(design: Option<(usize, &Design)>, cell: usize) -> String {
    design.map_or_else(String::new, |(_, d)| spring::csv(d.spring.as_ref(), d.evaluation.loss)[cell].clone())
}

/// The cells of a joint's rows: one row for each design, or one row that says why there is none.
pub fn rows(joint: &JointResult) -> Vec<Vec<String>> {
    let row = |design: Option<(usize, &Design)>| OF_DESIGN.iter().map(|(_, _, cell)| cell(joint, design)).collect();
    if joint.candidates.is_empty() {
        return vec![row(None)];
    }
    joint.candidates.iter().enumerate().map(|design| row(Some(design))).collect()
}

/// Position of a column of [`rows`].
///
/// # Panics
/// There is no such column: the name is a literal of the program.
pub fn position(name: &str) -> usize {
    OF_DESIGN.iter().position(|(n, ..)| *n == name).expect("a column of the results")
}

/// All columns: of the robot, of the grid, of the design.
pub fn all(plan: &Plan) -> Vec<Column> {
    let column = |name: &str, kind| Column { name: name.into(), kind };
    let mut columns =
        vec![column("robot", Kind::Integer), column("requirement", Kind::Text), column("name", Kind::Text)];
    columns.extend(of_grid(plan));
    columns.extend(OF_DESIGN.iter().map(|(name, kind, _)| column(name, *kind)));
    columns
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
