//! Motors that cannot be judged: what the requirement states and nobody knows of them. They stand apart from those
//! that can do it and from those that cannot.

use std::collections::BTreeMap;

use super::table::wrap;
use super::{losses, number};
use gearwise_model::actuator::limits::Remark;
use gearwise_select::answer::{JointResult, JointSweep, Reason, Says, Unjudged};
use gearwise_select::outlook::Outlook;
use gearwise_select::pareto::{Front, FrontPoint};
use gearwise_select::robot::Choice;

/// Why something cannot be judged, in a sentence.
pub fn sentence(because: &[Remark]) -> String {
    format!("cannot be judged: {}", causes(because))
}

/// Each cause once, with the limits that it leaves open.
fn causes(because: &[Remark]) -> String {
    let mut causes: Vec<(&str, Vec<&str>)> = Vec::new();
    for (limit, why) in because {
        match causes.iter_mut().find(|(cause, _)| cause == why) {
            Some((_, limits)) => limits.push(limit),
            None => causes.push((why, vec![limit])),
        }
    }
    let each: Vec<String> = causes.iter().map(|(why, limits)| format!("{why} ({})", limits.join(", "))).collect();
    each.join("; ")
}

/// The same in short: the limits alone.
pub fn class(because: &[Remark]) -> String {
    let limits: Vec<&str> = because.iter().map(|(limit, _)| *limit).collect();
    format!("{} cannot be judged", limits.join(", "))
}

/// What is said of a limit that could not be checked, and of one that counts as kept as far as something holds.
pub fn sentences(unchecked: &[Remark], assumed: &[Remark]) -> Vec<String> {
    let unchecked = unchecked.iter().map(|(limit, why)| format!("not checked: {limit}, because {why}"));
    unchecked.chain(assumed.iter().map(|(limit, what)| format!("assumed: {limit}: {what}"))).collect()
}

/// Names of limits for a cell.
pub fn names(remarks: &[Remark]) -> String {
    remarks.iter().map(|(limit, _)| *limit).collect::<Vec<_>>().join(" ")
}

/// Motors by what cannot be judged, the most frequent first.
fn by_reason<'m>(all: impl Iterator<Item = (&'m str, &'m [Remark])>) -> Vec<(String, Vec<&'m str>)> {
    let mut reasons: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for (motor, because) in all {
        let motors = reasons.entry(causes(because)).or_default();
        if !motors.contains(&motor) {
            motors.push(motor);
        }
    }
    let mut reasons: Vec<_> = reasons.into_iter().collect();
    reasons.sort_by(|a, b| b.1.len().cmp(&a.1.len()).then(a.0.cmp(&b.0)));
    reasons
}

const HEADING: &str =
    "Heat, or a limit or objective of the requirement, cannot be judged for these motors, so none of them is a choice";

/// A line for each reason, with how many motors have it and the first of them.
fn lines<'m>(all: impl Iterator<Item = (&'m str, &'m [Remark])>) -> Vec<String> {
    let line = |(why, motors): (String, Vec<&str>)| {
        let more = if motors.len() > 3 { ", …" } else { "" };
        format!("{:>3} × {why}: {}{more}", motors.len(), motors[..motors.len().min(3)].join(", "))
    };
    by_reason(all).into_iter().map(line).collect()
}

fn block(heading: &str, lines: Vec<String>) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let lines: String = lines.iter().map(|line| format!("    {}\n", wrap(line, 10))).collect();
    format!("\n  {}\n{lines}", wrap(&format!("{heading}:"), 4))
}

/// The block of a joint by reasons; `more` is said of them.
pub fn reasons(result: &JointResult, more: &str) -> String {
    let reasons = result.unjudged.iter().map(|u| (u.motor.id.as_str(), u.because.as_slice()));
    block(&format!("{HEADING}{more}"), lines(reasons))
}

/// The block of a joint; `each` lists every motor, with what is known of its best design.
pub fn text(result: &JointResult, outlook: Option<&Outlook>, each: bool) -> String {
    if !each {
        return reasons(result, " (`--rejected` lists each)");
    }
    let goal = &result.joint.objective;
    let line = |u: &Unjudged| {
        let gear = u.gear.map_or_else(String::new, |gear| format!(" with {gear}"));
        let even = outlook.and_then(|outlook| outlook.break_even(u.motor));
        let even = even.map_or_else(String::new, |even| format!("; {}", losses::break_even(even, u.motor)));
        let Some(design) = &u.design else { return format!("{}{gear}: {}", u.motor.id, causes(&u.because)) };
        let at = number(design.evaluation.ratio);
        let known = match design.optimum.objective {
            value if value.is_finite() => {
                format!("as far as is known {} {} at N = {at}", goal.name(), super::with_unit(value, goal.unit()))
            }
            _ => format!("as far as is known loss {} W at N = {at}", number(design.evaluation.loss)),
        };
        let estimated = super::estimated::text(u.motor);
        format!("{}{gear}: {}; {known}{even}{estimated}", u.motor.id, causes(&u.because))
    };
    block(HEADING, result.unjudged.iter().map(line).collect())
}

/// The block of a sweep.
pub fn sweep_text(sweep: &JointSweep) -> String {
    let count = sweep.designs.iter().filter(|d| d.is_unjudged()).count();
    let apart = sweep.designs.iter().filter(|d| d.is_unjudged());
    let reasons = apart.map(|d| (d.motor.id.as_str(), &*d.unjudged));
    let heading = format!(
        "Heat, or a limit or objective of the requirement, cannot be judged for {}, so none of them is a choice; by motor",
        gearwise_model::words::counted(count, "design")
    );
    block(&heading, lines(reasons))
}

/// The block of a front.
pub fn front_text(front: &Front) -> String {
    block(HEADING, lines(front.unjudged.iter().map(|(motor, why)| (motor.id.as_str(), why.as_slice()))))
}

/// What could not be checked and what was assumed of the designs on a front: each with the motors it is true of.
pub fn front_remarks(front: &Front) -> Vec<String> {
    let kinds: [fn(&FrontPoint) -> Vec<String>; 2] = [|p| sentences(&p.unchecked, &[]), |p| sentences(&[], &p.assumed)];
    let mut told = Vec::new();
    for said in kinds {
        let mut all: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        for point in &front.points {
            for what in said(point) {
                let motors = all.entry(what).or_default();
                if !motors.contains(&point.motor.id.as_str()) {
                    motors.push(&point.motor.id);
                }
            }
        }
        told.extend(all.into_iter().map(|(what, motors)| format!("{what}: {}", motors.join(", "))));
    }
    told
}

/// The block of a whole robot: what is the same at several joints is said once.
pub fn robot_text(choice: &Choice) -> String {
    let mut told: Vec<(String, Vec<&str>)> = Vec::new();
    for apart in choice.unjudged.chunk_by(|a, b| std::ptr::eq(a.joint, b.joint)) {
        for line in lines(apart.iter().map(|a| (a.motor.id.as_str(), a.because.as_slice()))) {
            let name = apart[0].joint.name.as_str();
            match told.iter_mut().find(|(of, _)| *of == line) {
                Some((_, joints)) => joints.push(name),
                None => told.push((line, vec![name])),
            }
        }
    }
    block(HEADING, told.iter().map(|(line, joints)| format!("{}: {}", joints.join(", "), line.trim_start())).collect())
}

/// How many motors cannot be judged, to go on a sentence that counts the others.
pub(super) fn counted(unjudged: usize) -> String {
    if unjudged == 0 { String::new() } else { format!(", {unjudged} cannot be judged") }
}

/// A joint without a choice: how many motors of it cannot be judged, and how many were left out unsolved, because
/// only designs with every limit checked were wanted.
#[derive(Debug, Clone, Copy)]
pub struct Without<'j> {
    /// Name of the joint.
    pub joint: &'j str,
    /// Motors that cannot be judged.
    pub unjudged: usize,
    /// Motors that were left out.
    pub unchecked: usize,
}

/// What is said of joints without a choice: that nothing can do them, or that nothing judged or checked can; behind
/// the word *no* as each reading writes it.
pub fn without_choice<'j>(joints: impl Iterator<Item = Without<'j>>, no: &str) -> Vec<String> {
    let [mut none, mut unjudged, mut unchecked] = [const { Vec::new() }; 3];
    for Without { joint, unjudged: apart, unchecked: left_out } in joints {
        match (apart, left_out) {
            (0, 0) => none.push(joint.to_string()),
            (0, count) => unchecked.push(format!("{joint} ({count} cannot be checked in full)")),
            (count, _) => unjudged.push(format!("{joint} ({count} cannot be judged)")),
        }
    }
    let lines = [
        ("motor of the catalogue can do", none),
        ("motor that can be judged can do", unjudged),
        ("motor that can be checked in full can do", unchecked),
    ];
    let told = lines.into_iter().filter(|(_, joints)| !joints.is_empty());
    told.map(|(what, joints)| format!("{no} {what}: {}", joints.join(", "))).collect()
}

/// How many were left out because a limit of them cannot be checked.
pub fn left_out<'r>(reasons: impl Iterator<Item = &'r Reason>) -> usize {
    reasons.filter(|reason| reason.says() == Says::NotKnown).count()
}
