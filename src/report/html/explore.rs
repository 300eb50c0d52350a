//! What a page that goes on asking shows of a joint: the same tables and diagrams as the pages of `optimize` and `explain`.

use super::optimize::{asked_of, candidates, none_text};
use super::{Part, Table, explain};
use crate::design::answer::{Design, JointResult};
use crate::design::explain::Explanation;
use crate::design::program::Certificate;
use crate::report::explain::quantities;
use crate::report::optimize::without_choice;
use crate::report::plot::{Figure, Group, design as plot, trade};
use crate::report::said::{joint_notes, per_cent, with_gear};
use crate::report::{design_ratio, number};
use crate::requirement::{Joint, Robot};

/// The first choice of a joint as facts, to be compared with that of another state.
#[derive(Debug, Clone, PartialEq)]
pub struct First {
    /// The design in words.
    pub words: String,
    /// Its loss \[W\].
    pub loss: f64,
    /// Its mass \[kg\].
    pub mass: Option<f64>,
}

impl First {
    /// Of a design.
    pub fn of(design: &Design) -> First {
        First { words: named(design), loss: design.evaluation.loss, mass: design.evaluation.mass }
    }
}

/// A design by its names and its ratio.
fn named(design: &Design) -> String {
    let gear = with_gear(design).map_or_else(String::new, |gear| format!(" {gear}"));
    format!("{}{gear} at N = {}", design.motor.id, design_ratio(design))
}

/// What the first choice is of, as far as it is known.
fn proved(design: &Design) -> &'static str {
    match design.optimum.certificate {
        Certificate::Certified { .. } => "proved to be the best ratio of this motor",
        Certificate::NotCertified(_) => "not proved to be the best ratio of this motor",
    }
}

/// What is not known of a design: limits that were not checked, numbers that are estimated, what was taken to hold.
fn open_of(design: &Design) -> Option<String> {
    let names = |all: &[crate::actuator::limits::Remark]| {
        let mut names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        names.dedup();
        names.join(", ")
    };
    let mut all = Vec::new();
    if !design.unchecked.is_empty() {
        all.push(format!("not checked: {}", names(&design.unchecked)));
    }
    if !design.assumed.is_empty() {
        all.push(format!("assumed: {}", names(&design.assumed)));
    }
    let estimated = crate::report::estimated::text(design.motor);
    if !estimated.is_empty() {
        all.push(estimated.trim_start_matches([';', ',', ' ']).to_string());
    }
    (!all.is_empty()).then(|| format!("Open: {}.", all.join("; ")))
}

/// The objective of a design, with its unit.
fn objective(joint: &Joint, value: f64) -> String {
    match joint.objective.unit() {
        "1" => format!("{} {}", joint.goal(), number(value)),
        unit => format!("{} {} {unit}", joint.goal(), number(value)),
    }
}

/// The answer in short; `before` is what is chosen by the file as it is, where something is set.
pub fn headline(robot: &Robot, result: &JointResult, before: Option<Option<&First>>) -> Vec<Part> {
    let joint = result.joint;
    let mut parts = Vec::new();
    let first = result.candidates.first();
    parts.push(Part::Text(match first {
        Some(design) => {
            let value = objective(joint, design.optimum.objective);
            format!("Take {}: {value}; {}.", named(design), proved(design))
        }
        None => {
            let alone = crate::design::answer::RobotResult { robot, joints: vec![result.clone()] };
            without_choice(&alone, "No").join(". ") + "."
        }
    }));
    parts.extend(first.and_then(open_of).map(Part::Text));
    parts.push(Part::Text(asked_of(result)));
    match (first, before) {
        (Some(now), Some(Some(before))) => parts.push(Part::Text(against(now, before))),
        (Some(_), Some(None)) => parts.push(Part::Text("By the file as it is no motor can do it.".into())),
        (None, Some(Some(before))) => parts.push(Part::Text(format!("By the file as it is: {}.", before.words))),
        _ => {}
    }
    let notes = joint_notes(joint, false);
    if !notes.is_empty() {
        parts.push(Part::List(notes));
    }
    parts
}

/// A first choice against that of the file, in what can be compared whatever is best: loss and mass.
fn against(now: &Design, before: &First) -> String {
    let change = |value: f64, was: f64| match value.is_finite() && was.is_finite() && was > 0.0 {
        true if value == was => Some("the same".to_string()),
        true if value > was => Some(format!("{} more", per_cent(value / was - 1.0))),
        true => Some(format!("{} less", per_cent(1.0 - value / was))),
        false => None,
    };
    let loss =
        change(now.evaluation.loss, before.loss).map(|change| format!("loss {} W, now {change}", number(before.loss)));
    let mass = now
        .evaluation
        .mass
        .zip(before.mass)
        .and_then(|(now, was)| change(now, was).map(|change| format!("mass {} kg, now {change}", number(was))));
    let both: Vec<String> = std::iter::once(before.words.clone()).chain(loss).chain(mass).collect();
    format!("By the file as it is: {}.", both.join("; "))
}

/// What stands of a joint in a row of all: the first choice, or that there is none.
pub fn in_short(result: &JointResult) -> String {
    let Some(design) = result.candidates.first() else { return none_text(result) };
    format!("{}, {}", named(design), objective(result.joint, design.optimum.objective))
}

/// The designs of a joint, the best first.
pub fn ranking(result: &JointResult) -> Vec<Part> {
    let mut parts: Vec<Part> = crate::report::balance::sentences(result).into_iter().map(Part::Text).collect();
    parts.extend(candidates(result, &result.joint.name).part());
    parts
}

/// Why the other motors are no choice.
pub fn others(result: &JointResult) -> Vec<Part> {
    super::optimize::others(result, None, &result.joint.name)
}

/// Loss, inertia and mass of every design.
pub fn trade(result: &JointResult) -> Part {
    let group = Group { panels: vec![trade::panel(result)], ..Group::default() };
    Part::Figure(Figure { groups: vec![group], columns: 1, panel: (560.0, 400.0), ..Figure::default() })
}

/// A design that is looked at: how it stands, in a sentence, and all that is known of it.
pub fn design(robot: &Robot, story: &Explanation) -> Vec<Part> {
    let mut parts = vec![Part::Text(explain::headline(story))];
    parts.extend(explain::looked_at(robot, story));
    parts
}

/// What pinned designs are called.
const NAMES: [&str; 2] = ["A", "B"];

/// Designs that were pinned, number by number, and the envelopes of both.
pub fn pinned(designs: &[(&Robot, &Explanation)]) -> Vec<Part> {
    let mut header = vec!["quantity".to_string(), "unit".to_string()];
    header.extend(NAMES.iter().take(designs.len()).map(|name| format!(">{name}")));
    if designs.len() == 2 {
        header.push(">difference".into());
    }
    let mut table = Table::new("Pinned designs", &header);
    let all: Vec<_> = designs.iter().map(|(_, story)| quantities(story)).collect();
    let Some((first, rest)) = all.split_first() else { return Vec::new() };
    for (what, value, unit) in first {
        let others = rest.iter().map(|of| of.iter().find(|(name, ..)| name == what).and_then(|(_, value, _)| *value));
        let values: Vec<Option<f64>> = std::iter::once(*value).chain(others).collect();
        let mut cells = vec![what.to_string(), unit.to_string()];
        cells.extend(values.iter().map(|value| crate::report::optional(*value)));
        if let [one, other] = values.as_slice() {
            cells.push(difference(*one, *other));
        }
        table = table.rows([cells]);
    }
    let stands = designs.iter().zip(NAMES).map(|((_, story), name)| format!("{name}: {}", explain::headline(story)));
    let mut parts: Vec<Part> = vec![Part::List(stands.collect())];
    parts.push(Part::Table(table));
    parts.push(Part::Figure(plot::side_by_side(designs)));
    parts
}

/// By how much the second number is more than the first.
fn difference(one: Option<f64>, other: Option<f64>) -> String {
    match (one, other) {
        (Some(one), Some(other)) if one.is_finite() && other.is_finite() => match other - one {
            0.0 => "0".into(),
            more if one != 0.0 => {
                format!("{} ({}{})", number(more), if more > 0.0 { "+" } else { "−" }, per_cent((more / one).abs()))
            }
            more => number(more),
        },
        _ => "–".into(),
    }
}
