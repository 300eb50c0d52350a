//! Actuators that carry actuators: `torque_per_mass` of a joint, by name, to indices of joints.
//!
//! The one idea: what is carried is decided before what carries it, so names must exist and the relation
//! must have no cycle. One that does is a mistake in the file, told with the way round.

use std::ops::Range as Span;

use toml::Spanned;

use super::robot::{Carried, Joint};
use super::transmission::passed_on;
use crate::input::{Key, Problem, Range, Section, key};
use crate::motion::CarriedColumn;
use crate::units;

/// What a joint says it carries.
pub(super) struct Asked {
    name: Spanned<String>,
    value: What,
}

enum What {
    Constant(f64),
    Course(Vec<f64>, Vec<f64>),
}

const TORQUE_PER_MASS: Key =
    key("torque_per_mass", "what a kilogram of the actuator of a joint, by its name, adds to this joint's torque");

/// Reads `torque_per_mass` of a joint, beside the columns of its motion.
pub(super) fn read(section: &Section, columns: Vec<CarriedColumn>) -> Vec<Asked> {
    let mut asked = Vec::new();
    for (name, value) in section.named_quantities(TORQUE_PER_MASS, &units::TORQUE_PER_MASS, Range::Any) {
        if columns.iter().any(|(column, ..)| column == name.get_ref()) {
            let message = format!("duplicate torque per mass of `{}`", name.get_ref());
            let help = "the motion has a column for it: remove the one or the other";
            section.note(Problem::at(name.span(), message, "here and in the motion").help(help));
        }
        asked.push(Asked { name, value: What::Constant(value) });
    }
    let place = section.span_of(if section.has("case") { "case" } else { "motion" });
    asked.extend(columns.into_iter().map(|(name, values, rates)| Asked {
        name: Spanned::new(place.clone(), name),
        value: What::Course(values, rates),
    }));
    asked
}

/// Finds the joints that are named, and the cycles; `spans` is where each joint says what a description of the
/// robot makes it carry.
pub(super) fn resolve(
    root: &Section,
    joints: &mut [Joint],
    asked: Vec<Vec<Asked>>,
    mut spans: Vec<Span<usize>>,
) -> Option<()> {
    let names: Vec<String> = joints.iter().map(|j| j.name.clone()).collect();
    let mut good = true;
    for (j, asked) in asked.into_iter().enumerate() {
        for Asked { name, value } in asked {
            let Some(joint) = names.iter().position(|n| n == name.get_ref()) else {
                let message = format!("`torque_per_mass` names a joint `{}`, but there is none", name.get_ref());
                let others = names.iter().enumerate().filter(|(i, _)| *i != j).map(|(_, n)| n.as_str());
                root.note(Problem::at(name.span(), message, "not a joint").suggest(name.get_ref(), others));
                good = false;
                continue;
            };
            if joint == j {
                let message = format!("joint `{}` carries its own actuator", names[j]);
                root.note(
                    Problem::at(name.span(), message, "itself").help(
                        "name the joints further out; what a joint's own actuator weighs rests on what carries it",
                    ),
                );
                good = false;
                continue;
            }
            spans[j] = name.span();
            let samples = joints[j].motion.len();
            if joints[j].passed.as_deref().is_some_and(|passed| passed.numbers.is_lossy()) {
                lossy(root, name.span(), &names[j]);
                good = false;
                continue;
            }
            let (torque_per_mass, rate, constant) = match (value, joints[j].passed.as_deref()) {
                (What::Constant(value), Some(passed)) => {
                    let per = (0..samples).map(|k| passed_on(passed, k, value, 0.0));
                    let (values, rates) = per.unzip();
                    (values, rates, passed.constant().is_some())
                }
                (What::Constant(value), None) => (vec![value; samples], vec![0.0; samples], true),
                (What::Course(values, rates), _) => (values, rates, false),
            };
            // What the requirement says itself goes before what a description of the robot says.
            joints[j].carries.retain(|carried| carried.joint != joint);
            joints[j].carries.push(Carried { joint, torque_per_mass, rate, constant });
        }
    }
    // What a description of the robot makes a joint carry.
    for j in 0..joints.len() {
        let is_lossy = joints[j].passed.as_deref().is_some_and(|passed| passed.numbers.is_lossy());
        if good && is_lossy && !joints[j].carries.is_empty() {
            lossy(root, spans[j].clone(), &names[j]);
            good = false;
        }
    }
    if !good {
        return None;
    }
    if let Some(cycle) = cycle(joints) {
        let way: Vec<&str> = cycle.iter().chain(cycle.first()).map(|j| names[*j].as_str()).collect();
        let message = format!("joints carry each other's actuators in a circle: {}", way.join(" carries "));
        let help = "a joint carries the joints further out, never one further in (`torque_per_mass`, `actuator_at`)";
        root.note(Problem::at(spans[cycle[0]].clone(), message, "one of them").help(help));
        return None;
    }
    Some(())
}

/// A joint cannot carry actuators behind a transmission that loses power.
fn lossy(root: &Section, span: Span<usize>, joint: &str) {
    let message = format!("joint `{joint}` carries an actuator, and its transmission has an `efficiency`");
    let label = "which way power goes through it depends on what is carried";
    let help = "put the loss into the gear (`gear.efficiency`), or let the motion's torque have the actuator in it";
    root.note(Problem::at(span, message, label).help(help));
}

/// The joints of a cycle, in the order in which they carry each other.
fn cycle(joints: &[Joint]) -> Option<Vec<usize>> {
    fn walk(joints: &[Joint], at: usize, way: &mut Vec<usize>, done: &mut [bool]) -> Option<Vec<usize>> {
        if let Some(start) = way.iter().position(|w| *w == at) {
            return Some(way[start..].to_vec());
        }
        if done[at] {
            return None;
        }
        way.push(at);
        let found = joints[at].carries.iter().find_map(|c| walk(joints, c.joint, way, done));
        way.pop();
        done[at] = true;
        found
    }
    let mut done = vec![false; joints.len()];
    (0..joints.len()).find_map(|j| walk(joints, j, &mut Vec::new(), &mut done))
}
