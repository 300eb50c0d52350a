//! What a page that goes on asking shows of a joint: the same tables and diagrams as the pages of `optimize` and `explain`.

use super::optimize::{asked_of, candidates, near_gears, none_text};
use super::{Part, Table, explain};
use crate::answer::{binds, checked};
use crate::explain::{capitalised, quantities};
use crate::plot::{design as plot, trade};
use crate::said::{gear_of_ratio, joint_notes, margin_at, per_cent, windows_text, with_gear};
use crate::spring;
use crate::{design_ratio, number};
use gearwise_model::catalog::Catalog;
use gearwise_model::requirement::{Budget, Joint, Quantity, Robot};
use gearwise_select::answer::{Design, JointResult};
use gearwise_select::explain::Explanation;
use gearwise_select::nearby::nearby;
use gearwise_select::outlook::Outlook;
use gearwise_select::program::Certificate;

/// What is chosen in another state, to be compared with.
#[derive(Debug, Clone, PartialEq)]
pub enum Before {
    /// The first choice.
    First {
        /// The design in words.
        words: String,
        /// Its loss \[W\].
        loss: f64,
        /// Its mass \[kg\].
        mass: Option<f64>,
    },
    /// There is none: what is known.
    None(String),
}

impl Before {
    /// Of what was found for a joint.
    pub fn of(result: &JointResult) -> Before {
        match result.candidates.first() {
            Some(design) => {
                Before::First { words: named(design), loss: design.evaluation.loss, mass: design.evaluation.mass }
            }
            None => Before::None(none_text(result)),
        }
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
    let names = |all: &[gearwise_model::actuator::limits::Remark]| {
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
    let estimated = crate::estimated::text(design.motor);
    if !estimated.is_empty() {
        all.push(estimated.trim_start_matches([';', ',', ' ']).to_string());
    }
    (!all.is_empty()).then(|| format!("Open: {}.", all.join("; ")))
}

/// What a design comes to: loss and mass, and before them what is best where that is something else.
fn comes_to(joint: &Joint, design: &Design) -> String {
    let e = &design.evaluation;
    let value = number(design.optimum.objective);
    let goal = match (joint.objective.sole(), joint.objective.unit()) {
        (Some(Quantity::Loss | Quantity::Mass), _) => None,
        (_, "1") => Some(format!("{} {value}", joint.goal())),
        (_, unit) => Some(format!("{} {value} {unit}", joint.goal())),
    };
    let loss = e.loss.is_finite().then(|| format!("loss {} W", number(e.loss)));
    let mass = e.mass.map(|mass| format!("mass {} kg", number(mass)));
    let all: Vec<String> = [goal, loss, mass].into_iter().flatten().collect();
    all.join(", ")
}

/// Where the first choice stands: what keeps its ratio, between which ratios it is feasible, and what is tightest.
fn stands(joint: &Joint, design: &Design) -> String {
    let window = windows_text(&design.optimum, joint).filter(|_| design.gear.is_none());
    let tightest = design.evaluation.tightest().map(|margin| format!("tightest: {}", margin_at(margin, joint)));
    let all: Vec<String> = std::iter::once(binds(design, joint))
        .chain(window.map(|window| format!("feasible from {window}")))
        .chain(tightest)
        .collect();
    format!("What keeps its ratio: {}.", all.join("; "))
}

/// The answer in short; `nothing` is said where no motor is a choice, `before` is what is chosen by the file as it is, where something is set.
pub fn headline(result: &JointResult, nothing: Option<String>, before: Option<&Before>) -> Vec<Part> {
    let joint = result.joint;
    let mut parts = Vec::new();
    let first = result.candidates.first();
    parts.push(Part::Text(match first {
        Some(design) => format!("Take {}: {}; {}.", named(design), comes_to(joint, design), proved(design)),
        None => capitalised(&nothing.unwrap_or_else(|| none_text(result))),
    }));
    if let Some(design) = first {
        let spring = design.spring.as_ref();
        parts.extend(
            spring.map(|s| Part::Text(format!("Parallel spring: {}.", spring::text(s, design.evaluation.loss)))),
        );
        parts.push(Part::Text(stands(joint, design)));
        parts.extend(open_of(design).map(Part::Text));
        parts.extend(checked(result).map(|line| Part::Text(capitalised(&line))));
    }
    parts.push(Part::Text(asked_of(result)));
    let compared = before.map(|before| match (first, before) {
        (Some(now), Before::First { words, loss, mass }) => against(now, words, *loss, *mass),
        (None, Before::First { words, .. }) => words.clone(),
        (_, Before::None(words)) => words.clone(),
    });
    parts.extend(compared.map(|text| Part::Text(format!("By the file as it is: {text}."))));
    let notes = joint_notes(joint, false);
    if !notes.is_empty() {
        parts.push(Part::List(notes));
    }
    parts
}

/// A first choice against that of the file, in what can be compared whatever is best: loss and mass.
fn against(now: &Design, words: &str, was_loss: f64, was_mass: Option<f64>) -> String {
    let change = |value: f64, was: f64| match value.is_finite() && was.is_finite() && was > 0.0 {
        true if value == was => Some("the same".to_string()),
        true if value > 2.0 * was => Some(format!("{} times that", number(value / was))),
        true if value > was => Some(format!("{} more", per_cent(value / was - 1.0))),
        true => Some(format!("{} less", per_cent(1.0 - value / was))),
        false => None,
    };
    let loss = change(now.evaluation.loss, was_loss).map(|change| format!("loss {} W, now {change}", number(was_loss)));
    let mass = now
        .evaluation
        .mass
        .zip(was_mass)
        .and_then(|(now, was)| change(now, was).map(|change| format!("mass {} kg, now {change}", number(was))));
    let both: Vec<String> = std::iter::once(words.to_string()).chain(loss).chain(mass).collect();
    both.join("; ")
}

/// What stands of a joint in a row of all: the first choice, or that there is none.
pub fn in_short(result: &JointResult) -> String {
    let Some(design) = result.candidates.first() else { return none_text(result) };
    format!("{}, {}", named(design), comes_to(result.joint, design))
}

/// The designs of a joint, the best first.
pub fn ranking(result: &JointResult) -> Vec<Part> {
    let mut parts: Vec<Part> = crate::balance::sentences(result).into_iter().map(Part::Text).collect();
    parts.extend(candidates(result, &result.joint.name).part());
    parts
}

/// Gears that one can buy near the first choice's ratio, and a simple gear with its teeth.
pub fn near(robot: &Robot, result: &JointResult, catalog: &Catalog) -> Vec<Part> {
    let Some(design) = result.candidates.first() else { return Vec::new() };
    let outlook = Outlook { nearby: nearby(robot, result.joint, catalog, design), ..Outlook::default() };
    let teeth = gear_of_ratio(result.joint, design.optimum.ratio).filter(|_| design.gear.is_none());
    let teeth = teeth.map(|line| Part::Text(format!("{}: {line}.", named(design))));
    teeth.into_iter().chain(near_gears(result, &outlook, &result.joint.name)).collect()
}

/// What the first choices of all joints come to, with the budgets of the requirement.
pub fn whole(robot: &Robot, joints: Vec<JointResult>) -> Vec<Part> {
    let result = gearwise_select::answer::RobotResult { robot, joints };
    let mut parts = Vec::new();
    if result.joints.len() > 1 || robot.budget.actuator_mass.is_some() {
        let lines = crate::optimize::budget_lines(&result);
        parts.push(Part::Text(format!("All first choices together, each joint by itself: {}.", lines.join("; "))));
    }
    let Budget { power, current, regeneration, .. } = robot.budget;
    if [power, current, regeneration].iter().any(Option::is_some) || robot.shared_resistance().is_some() {
        let text = "What the whole robot may draw and give back is not looked at here: gearwise optimize does.";
        parts.push(Part::Text(text.into()));
    }
    parts
}

/// Why the other motors are no choice.
pub fn others(result: &JointResult) -> Vec<Part> {
    super::optimize::others(result, None, &result.joint.name)
}

/// Loss, inertia and mass of every design.
pub fn trade(result: &JointResult) -> Part {
    Part::Figure(trade::figure(result))
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
pub fn pinned(designs: &[(usize, &Robot, &Explanation)]) -> Vec<Part> {
    let name = |place: usize| NAMES.get(place).copied().unwrap_or("?");
    let mut header = vec!["quantity".to_string(), "unit".to_string()];
    header.extend(designs.iter().map(|(place, ..)| format!(">{}", name(*place))));
    if designs.len() == 2 {
        header.push(">difference".into());
    }
    let mut table = Table::new("Pinned designs, number by number", &header);
    let all: Vec<_> = designs.iter().map(|(.., story)| quantities(story)).collect();
    let Some((first, rest)) = all.split_first() else { return Vec::new() };
    for (what, value, unit) in first {
        // Two quantities may have one name, in two units.
        let same = |(name, _, of): &&(&str, Option<f64>, &str)| name == what && of == unit;
        let others = rest.iter().map(|of| of.iter().find(same).and_then(|(_, value, _)| *value));
        let values: Vec<Option<f64>> = std::iter::once(*value).chain(others).collect();
        let mut cells = vec![what.to_string(), unit.to_string()];
        cells.extend(values.iter().map(|value| crate::optional(*value)));
        if let [one, other] = values.as_slice() {
            cells.push(difference(*one, *other, *unit != "degC"));
        }
        table = table.rows([cells]);
    }
    let stands = designs.iter().map(|(place, _, story)| format!("{}: {}", name(*place), explain::headline(story)));
    let mut parts: Vec<Part> = vec![Part::List(stands.collect())];
    parts.push(Part::Table(table));
    let drawn: Vec<_> = designs.iter().map(|(_, robot, story)| (*robot, *story)).collect();
    parts.push(Part::Figure(plot::side_by_side(&drawn)));
    parts
}

/// By how much the second number is more than the first; `shares`: whether a share of it says something, as of no temperature.
fn difference(one: Option<f64>, other: Option<f64>, shares: bool) -> String {
    let (Some(one), Some(other)) = (one, other) else { return "–".into() };
    let more = other - one;
    match more.is_finite() {
        false => "–".into(),
        // What rounding leaves is no difference.
        true if more.abs() <= 1e-9 * one.abs().max(other.abs()) => "0".into(),
        true if one == 0.0 || !shares => number(more),
        true => {
            let share = (1000.0 * more / one).round() / 10.0;
            let share = if share == 0.0 { "less than 0.1 %".to_string() } else { format!("{share:+} %") };
            format!("{} ({share})", number(more))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_is_of_two_numbers_that_are_known() {
        let of = |one: f64, other: f64| difference(Some(one), Some(other), true);
        assert_eq!((of(2.0, 3.0).as_str(), of(4.0, 3.0).as_str()), ("1 (+50 %)", "-1 (-25 %)"));
        assert_eq!((of(0.1 + 0.2, 0.3).as_str(), of(0.0, 2.0).as_str()), ("0", "2"));
        assert_eq!(of(1000.0, 1000.1), "0.1 (less than 0.1 %)");
        assert_eq!(difference(Some(50.0), Some(30.0), false), "-20", "of a temperature there are no shares");
        assert_eq!((difference(None, Some(1.0), true), of(f64::NAN, 1.0)), ("–".into(), "–".into()));
    }
}
