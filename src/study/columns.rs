//! The columns of a study's results: the robot, the point of the grid, and those of [every design](columns).
//!
//! The one idea: a cell is its text in the CSV file, blank where unknown. Journal, CSV and Parquet hold the
//! same cells, so that no number is rounded on its way.

use std::collections::BTreeMap;

use super::plan::Plan;
use crate::design::answer::JointResult;
use crate::design::robot::{Choice, Combination};
use crate::report::columns::{self, Entry, State};
use crate::report::optimize::designs;
use crate::report::reason::reason_text;
use crate::report::robot::{no_combination, wanting_lines};
use crate::report::unjudged;
use crate::words::csv::csv_number;

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

/// What the combination of which a design is a part comes to, in the order of [`of_combination`]; blank where each joint is chosen by
/// itself.
const OF_ROBOT: [(&str, Kind); 6] = [
    ("robot_total", Kind::Number),
    ("robot_total_is", Kind::Text),
    ("robot_lower_bound", Kind::Number),
    ("robot_proof", Kind::Text),
    ("robot_actuators_kg", Kind::Number),
    ("robot_peak_power_w", Kind::Number),
];

/// The cells of a joint's rows: one row for each design, or one row that says why there is none.
pub fn rows(joint: &JointResult) -> Vec<Vec<String>> {
    let mut entries = designs(joint);
    if entries.is_empty() {
        entries.push(Entry::joint(joint.joint, because(joint)));
    }
    let alone: [String; OF_ROBOT.len()] = Default::default();
    entries.iter().map(|entry| row(entry, joint.unjudged.len(), &alone)).collect()
}

/// The cells of a joint's rows in the combinations of a whole robot: its design in each, or one row that says why there is none.
pub fn rows_of_robot(choice: &Choice, joint: usize) -> Vec<Vec<String>> {
    let of = &choice.robot.joints[joint];
    let unjudged = choice.unjudged.iter().filter(|apart| std::ptr::eq(apart.joint, of)).count();
    if choice.combinations.is_empty() {
        let mut because = vec![no_combination(choice).trim_end_matches('.').to_string()];
        because.extend(wanting_lines(choice));
        let none: [String; OF_ROBOT.len()] = Default::default();
        return vec![row(&Entry::joint(of, because.join("; ")), unjudged, &none)];
    }
    let ranked = choice.combinations.iter().enumerate();
    let row = |(k, combination): (usize, &Combination)| {
        let facts = combination.joints[joint].facts();
        let entry = Entry::design(of, State::Candidate, Some(k + 1), facts);
        row(&entry, unjudged, &of_combination(choice, k, combination))
    };
    ranked.map(row).collect()
}

fn row(entry: &Entry, unjudged: usize, of_robot: &[String]) -> Vec<String> {
    let cells = columns::columns().iter().map(|column| column.cell(entry));
    cells.chain([unjudged.to_string()]).chain(of_robot.iter().cloned()).collect()
}

/// The cells of the columns of a combination. Only the best one has a bound and a proof: the others are those met on the way.
fn of_combination(choice: &Choice, place: usize, combination: &Combination) -> [String; OF_ROBOT.len()] {
    let first = place == 0;
    let proof = match choice.proof.certified() {
        true => "proved".to_string(),
        false => format!("not proved: {}", choice.proof.not_proved.join("; ")),
    };
    [
        csv_number(Some(combination.objective)),
        format!("{} [{}]", choice.total.name, choice.total.unit),
        csv_number(choice.proof.lower_bound.filter(|_| first)),
        if first { proof } else { String::new() },
        csv_number(combination.mass),
        csv_number(Some(combination.peak_power)),
    ]
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
    all.extend(OF_ROBOT.iter().map(|(name, kind)| column(name, *kind)));
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
