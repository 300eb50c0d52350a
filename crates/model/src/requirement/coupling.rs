//! `[[coupling]]`: two joints that two equal actuators move together.
//!
//! The one idea: both joints become one, whose design both actuators have; its motion is what the two of them do at the same time.

use std::ops::Range as Span;

use toml::Spanned;

use super::carried;
use super::mechanism::Use;
use super::motions::MotionReader;
use super::prices::Money;
use super::robot::Joint;
use super::transmission::read_price;
use crate::input::{Problem, Section, key};
use crate::motion::Course;
use crate::transmission::read::read_coupling;
use crate::transmission::{Coupler, Coupling, Numbers, Passed};

/// What a coupling says.
pub(super) struct Asked {
    name: Spanned<String>,
    joints: Vec<Spanned<String>>,
    coupling: Option<Coupling>,
    span: Span<usize>,
}

/// Reads the couplings.
pub(super) fn read(root: &Section, money: &Money, reader: &mut MotionReader) -> Vec<Option<Asked>> {
    let about = "two joints that two equal actuators move together: differential, parallel ankle";
    let tables = root.sections(key("coupling", about));
    let one = |section: Section| {
        let span = section.span();
        let name = section.required_text(key("name", "of the two as one"), "\"ankle\"");
        let about = "names of the two joints; what they say next to their motions has to be the same";
        if !section.has("joints") {
            section.missing("joints", "[\"ankle_pitch\", \"ankle_roll\"]");
        }
        let joints = section.texts(key("joints", about).required());
        let coupling = reader.with_files(|files| read_coupling(&section, files));
        let price = read_price(&section, money);
        let coupling = coupling.map(|read| Coupling { numbers: Numbers { price, ..read.numbers }, ..read });
        section.finish();
        Some(Asked { name: name?, joints: joints?, coupling, span })
    };
    tables.into_iter().map(one).collect()
}

/// What is known of each joint beside itself.
pub(super) struct Beside<'b> {
    pub(super) uses: &'b mut Vec<Option<Use>>,
    pub(super) carried: &'b mut Vec<Vec<carried::Asked>>,
    pub(super) places: &'b mut Vec<Span<usize>>,
    /// Whether a description of the robot leaves the actuators out.
    pub(super) separate: bool,
}

/// Makes one joint of both joints of each coupling; `None` where that is a mistake, which is noted.
pub(super) fn resolve(
    root: &Section,
    asked: Vec<Option<Asked>>,
    joints: &mut Vec<Joint>,
    beside: &mut Beside,
) -> Option<()> {
    for one in asked {
        couple(root, one?, joints, beside)?;
    }
    Some(())
}

fn couple(root: &Section, asked: Asked, joints: &mut Vec<Joint>, beside: &mut Beside) -> Option<()> {
    let Asked { name, joints: names, coupling, span } = asked;
    let wrong = |span: Span<usize>, message: String, label: &str, help: &str| {
        let problem = Problem::at(span, message, label);
        root.note(if help.is_empty() { problem } else { problem.help(help.to_string()) });
    };
    let [first, second] = names.as_slice() else {
        let place = names.first().map_or(span, |n| n.span());
        wrong(place, format!("a coupling has two joints, not {}", names.len()), "two joints, two actuators", "");
        return None;
    };
    let coupling = coupling?;
    let mut found = Vec::new();
    for of in [first, second] {
        match joints.iter().position(|joint| joint.name == *of.get_ref()) {
            Some(k) if !found.contains(&k) => found.push(k),
            Some(_) => {
                wrong(of.span(), format!("the coupling names `{}` twice", of.get_ref()), "second time", "");
                return None;
            }
            None => {
                let message = format!("the coupling names a joint `{}`, but there is none", of.get_ref());
                let all: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
                root.note(Problem::at(of.span(), message, "not a joint").suggest(of.get_ref(), all));
                return None;
            }
        }
    }
    let [a, b] = [found[0], found[1]];
    if joints.iter().enumerate().any(|(k, joint)| joint.name == *name.get_ref() && k != a && k != b) {
        wrong(name.span(), format!("a joint is called `{}`, too", name.get_ref()), "second time", "");
        return None;
    }
    let [one, other] = [&joints[a], &joints[b]];
    let label = "coupled here";
    for (joint, k) in [(one, a), (other, b)] {
        let not = match () {
            () if joint.passed.is_some() => Some("has a `transmission` or a coupling of its own"),
            () if joint.gear_map.is_some() => Some("has a gear with a `map`"),
            () if joint.ratio.is_between() => Some("has ratios `between` the points of a family"),
            () if joint.limits.spring.is_some() => Some("has a `spring`"),
            () if !joint.phases.is_empty() => Some("has `phases`"),
            () if joint.motion.cases.is_some() => Some("has load cases"),
            () if !joint.motion.has_durations() => Some("has operating points without durations"),
            () if !beside.carried[k].is_empty() => Some("carries another actuator"),
            () if beside.separate && beside.uses[k].is_some() => {
                Some("is of a description that leaves the actuators out")
            }
            () => None,
        };
        if let Some(not) = not {
            let message = format!("`{}` {not}, and that does not go with a coupling", joint.name);
            wrong(span.clone(), message, label, "remove one of the two");
            return None;
        }
    }
    let differs = [
        ("count", one.count != other.count),
        ("ratio", one.ratio != other.ratio),
        ("gear", one.gear != other.gear),
        ("motors", one.motors != other.motors),
        ("objective", one.objective != other.objective || one.balancing != other.balancing),
        ("limits", one.limits != other.limits),
        ("drive", one.drive != other.drive || one.drive_current != other.drive_current),
        ("motor_drag", one.motor_drag != other.motor_drag),
    ];
    if let Some((key, _)) = differs.iter().find(|(_, differs)| *differs) {
        let message = format!("`{}` and `{}` are coupled, and their `{key}` differs", one.name, other.name);
        wrong(span, message, label, "both actuators are one design: write the same in both joints");
        return None;
    }
    let times = |joint: &Joint| joint.motion.given.iter().map(|k| joint.motion.time[*k]).collect::<Vec<f64>>();
    if one.motion.course != other.motion.course
        || times(one) != times(other)
        || one.motion.repeat_every != other.motion.repeat_every
    {
        let message = format!("the motions of `{}` and `{}` have not the same times", one.name, other.name);
        wrong(span, message, label, "coupled joints move together: give both motions at the same times");
        return None;
    }
    let unplaced = [one, other].into_iter().find(|joint| !joint.motion.placed);
    if let Some(joint) = unplaced.filter(|_| !matches!(coupling.coupler, Coupler::Matrix(_))) {
        let points = matches!(joint.motion.course, Course::Points(_));
        let has = if points { "operating points have none" } else { "its motion does not say it" };
        let message = format!("the coupling needs the position of `{}`, and {has}", joint.name);
        wrong(span, message, label, "give a `motion` with a column `position`, or a `matrix` in the coupling");
        return None;
    }
    let passed = Passed::coupled(&coupling, [(&one.name, &one.motion), (&other.name, &other.motion)]);
    let (motion, passed) = match passed {
        Ok(passed) => passed,
        Err(fault) => {
            let help = "compare the motions' positions with the coupling's: their zero, their unit, their direction";
            wrong(span, fault.to_string(), "not with these motions", help);
            return None;
        }
    };
    let pair = Joint {
        name: name.into_inner(),
        count: 2 * one.count,
        motion: motion.into(),
        passed: Some(passed.into()),
        ..one.clone()
    };
    joints[a] = pair;
    joints.remove(b);
    beside.uses.remove(b);
    beside.carried.remove(b);
    beside.places.remove(b);
    Some(())
}
