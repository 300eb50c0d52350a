//! Load cases: `[[joint.case]]` with `order`, and `[[case]]` of the robot.
//!
//! The one idea: each case is read as a joint's only motion would be, and all of them become one motion
//! ([`crate::motion::cases`]). How often each happens is stated in one of three ways, never assumed.

use std::collections::HashSet;
use std::sync::Arc;

use toml::Spanned;

use super::motions::{self, MotionReader, Scale};
use super::robot::{Joint, RobotCase, case_named};
use crate::input::{Key, Problem, Range, Section, key};
use crate::motion::{CarriedColumn, Case, Lasting, Motion, Often};
use crate::units;

/// The most cases of a joint, and the most steps of an order.
const MOST: usize = 100;

/// What shares may miss one by.
const SUMS_TO_ONE: f64 = 1e-6;

const CASE: Key =
    key("case", "load cases in place of one motion: each with a motion or points of its own").or("motion");
const ORDER: Key = key("order", "the sequence of load cases, in which heat is followed; it is made again and again");
const SHARE: Key = key("share", "of the time, its rest included; the shares of all cases sum to one").or("cycles");
const CYCLES: Key = key("cycles", "how many times it happens, for each time that the others happen theirs").or("share");

/// What one case says, before all are put together.
struct Read {
    name: Spanned<String>,
    motion: Option<(Arc<Motion>, Vec<CarriedColumn>)>,
    share: Option<f64>,
    cycles: Option<f64>,
    span: std::ops::Range<usize>,
}

/// Reads the load cases of a joint as one motion, with its columns of torque per mass.
pub(super) fn read(
    section: &Section,
    joints: &[String],
    name: Option<&String>,
    scale: Option<Scale>,
    reader: &mut MotionReader,
) -> Option<(Arc<Motion>, Vec<CarriedColumn>)> {
    for other in ["motion", "points", "mechanism_joint", "period"].into_iter().filter(|key| section.has(*key)) {
        let message = format!("a joint has load cases or `{other}`, not both");
        let help = format!("move `{other}` into a [[joint.case]], or remove it");
        section.note(Problem::at(section.span_of(other), message, "next to [[joint.case]]").help(help));
    }
    let tables = section.sections_at(CASE, "[[joint.case]]");
    if tables.is_empty() || tables.len() > MOST {
        let message = format!("a joint has 1 to {MOST} load cases, not {}", tables.len());
        section.note(Problem::at(section.span_of("case"), message, "expected a table [[joint.case]] for each"));
        return None;
    }
    let read: Vec<Option<Read>> = tables.into_iter().map(|t| read_case(t, joints, name, scale, reader)).collect();
    let steps = section.has("order").then(|| read_order(section, &read));
    let end = read_end(section, steps.is_some());
    let read: Vec<Read> = read.into_iter().collect::<Option<_>>()?;
    let mut names = HashSet::new();
    if let Some(twice) = read.iter().find(|r| !names.insert(r.name.get_ref().clone())) {
        let message = format!("two load cases of a joint are called `{}`", twice.name.get_ref());
        section.note(Problem::at(twice.name.span(), message, "second time"));
        return None;
    }
    let often = match steps {
        Some(steps) => {
            let steps = steps?;
            refuse_beside_an_order(section, &read, &steps)?;
            Often::Order(steps)
        }
        None => how_often(section, &read)?,
    };
    let spans: Vec<_> = read.iter().map(|r| r.span.clone()).collect();
    let mut cases = Vec::new();
    let mut columns = Vec::new();
    for Read { name, motion, .. } in read {
        let (motion, carried) = motion?;
        columns.push(carried);
        cases.push((name.into_inner(), Arc::unwrap_or_clone(motion)));
    }
    let columns = joined(section, &cases, columns, &spans)?;
    let mut motion = Motion::from_cases(cases, often, end != OrderEnd::Repeats);
    let cases = motion.cases.clone()?;
    if let Some(short) = cases.sequence.iter().find(|step| step.repetitions < 1.0 - 1e-9) {
        let case = &cases.list[short.case];
        let time = short.repetitions * case.cycle();
        let message = format!("`order` gives `{}` {time} s, but once takes {} s", case.name, case.cycle());
        section.note(Problem::at(section.span_of("order"), message, "shorter than one repetition"));
        return None;
    }
    if let OrderEnd::RepeatsEvery(every) = end {
        let lasts = cases.sequence_lasts().1;
        if every < lasts {
            let message = format!("the order lasts {lasts} s, but is to be made again after {every} s");
            section.note(Problem::at(section.span_of("repeat_every"), message, "before it ends"));
            return None;
        }
        motion.repeat_every = Some(every);
    }
    Some((Arc::new(motion), columns))
}

fn read_case(
    table: Section,
    joints: &[String],
    joint: Option<&String>,
    scale: Option<Scale>,
    reader: &mut MotionReader,
) -> Option<Read> {
    let name = table.required_text(key("name", "name of the load case"), "\"trot\"");
    let share = table.number(SHARE, Range::NonNegative);
    let cycles = table.number(CYCLES, Range::NonNegative);
    if table.has("share") && table.has("cycles") {
        let message = "a load case has `share` or `cycles`, not both";
        table.note(Problem::at(table.span_of("cycles"), message, "remove one of the two"));
    }
    // The joint's factors hold for all of its cases, and each may have some of its own.
    let own = motions::read_scale(&table);
    let scale = match (own, scale) {
        (Some(a), Some(b)) => Some(Scale { torque: a.torque * b.torque, speed: a.speed * b.speed }),
        (a, b) => a.or(b),
    };
    let motion = motions::read_motion(&table, joints, joint, scale, reader);
    let untimed = motion.as_ref().is_some_and(|(motion, _)| !motion.has_durations());
    if untimed {
        let message = "the operating points of a load case need durations: heat is that of all cases together";
        table.note(Problem::at(table.span_of("points"), message, "without `duration`"));
    }
    let span = table.span();
    table.finish();
    Some(Read { name: name?, motion: motion.filter(|_| !untimed), share, cycles, span })
}

/// Reads the steps of `order`; `None` where one of them is wrong.
fn read_order(section: &Section, read: &[Option<Read>]) -> Option<Vec<(usize, Lasting)>> {
    let tables = section.sections(ORDER);
    if tables.is_empty() || tables.len() > MOST {
        let message = format!("`order` has 1 to {MOST} steps, not {}", tables.len());
        let problem = Problem::at(section.span_of("order"), message, "expected a list of steps");
        section
            .note(problem.help("order = [{ case = \"trot\", duration = \"120 s\" }, { case = \"jump\", count = 5 }]"));
        return None;
    }
    let names: Vec<Option<&str>> = read.iter().map(|r| r.as_ref().map(|r: &Read| r.name.get_ref().as_str())).collect();
    let mut steps = Vec::new();
    let mut good = true;
    for table in tables {
        let case = table.required_text(key("case", "name of the load case"), "\"trot\"");
        let duration =
            table.quantity(key("duration", "how long it goes on").or("count"), &units::TIME, Range::Positive);
        let count = table.count(key("count", "how many times").or("duration"));
        let lasting = match (duration, count, table.has("duration") && table.has("count")) {
            (Some(duration), None, false) => Some(Lasting::Duration(duration)),
            (None, Some(count), false) => Some(Lasting::Count(f64::from(count))),
            (None, None, false) if !table.has("duration") && !table.has("count") => {
                let problem =
                    Problem::at(table.span(), "a step of `order` has no length", "neither `duration` nor `count`");
                table.note(problem.help("give duration = \"120 s\", or count = 5"));
                None
            }
            (.., true) => {
                let message = "a step of `order` has `duration` or `count`, not both";
                table.note(Problem::at(table.span_of("count"), message, "remove one of the two"));
                None
            }
            _ => None,
        };
        let place = case.as_ref().and_then(|case| {
            let place = names.iter().position(|name| *name == Some(case.get_ref().as_str()));
            if place.is_none() {
                let message = format!("`order` names a load case `{}`, but there is none", case.get_ref());
                let problem = Problem::at(case.span(), message, "not a case of this joint");
                table.note(problem.suggest(case.get_ref(), names.iter().flatten().copied()));
            }
            place
        });
        table.finish();
        match place.zip(lasting) {
            Some(step) => steps.push(step),
            None => good = false,
        }
    }
    good.then_some(steps)
}

/// What comes after an order.
#[derive(Debug, Clone, Copy, PartialEq)]
enum OrderEnd {
    /// It begins again.
    Repeats,
    /// It is made once, from cold.
    Once,
    /// Rest, until it is made again after so long \[s\].
    RepeatsEvery(f64),
}

/// What comes after the order.
fn read_end(section: &Section, ordered: bool) -> OrderEnd {
    if !ordered {
        for other in ["periodic", "repeat_every"].into_iter().filter(|key| section.has(*key)) {
            let message = format!("`{other}` of a joint with load cases is about their `order`, and there is none");
            let help = format!("move `{other}` into the [[joint.case]] that it is about, or give `order`");
            section.note(Problem::at(section.span_of(other), message, "next to [[joint.case]]").help(help));
        }
        return OrderEnd::Repeats;
    }
    let periodic = section.boolean(key("periodic", "whether the motion repeats").default("true")).unwrap_or(true);
    let every = section.quantity(motions::REPEAT_EVERY, &units::TIME, Range::Positive);
    if periodic && every.is_some() {
        let message = "`repeat_every` needs an order that happens once";
        let problem = Problem::at(section.span_of("repeat_every"), message, "this one repeats without rest");
        section.note(problem.help("set `periodic = false`, or remove `repeat_every`"));
    }
    match (periodic, every) {
        (true, _) => OrderEnd::Repeats,
        (false, None) => OrderEnd::Once,
        (false, Some(every)) => OrderEnd::RepeatsEvery(every),
    }
}

/// Beside an order nothing else says how often a case happens, and every case has a step.
fn refuse_beside_an_order(section: &Section, read: &[Read], steps: &[(usize, Lasting)]) -> Option<()> {
    let mut good = true;
    for (place, case) in read.iter().enumerate() {
        if case.share.is_some() || case.cycles.is_some() {
            let message = format!("load case `{}` has a share, and `order` says it too", case.name.get_ref());
            section.note(Problem::at(case.span.clone(), message, "remove `share` or `cycles`, or `order`"));
            good = false;
        }
        if !steps.iter().any(|(step, _)| *step == place) {
            let message = format!("load case `{}` is not in `order`", case.name.get_ref());
            section.note(Problem::at(case.name.span(), message, "its heat would not count").help("give it a step"));
            good = false;
        }
    }
    good.then_some(())
}

/// Shares or cycles, of all cases alike.
fn how_often(section: &Section, read: &[Read]) -> Option<Often> {
    let (shares, cycles) =
        (read.iter().filter(|r| r.share.is_some()).count(), read.iter().filter(|r| r.cycles.is_some()).count());
    if shares == 0 && cycles == 0 {
        if let [only] = read {
            return only.motion.as_ref().map(|_| Often::Shares(vec![1.0]));
        }
        let message = "nothing says how often each load case happens: heat and loss are those of all of them together";
        let help = "give every case `share = 0.9` (of the time) or `cycles = 100`, or give the joint an `order`";
        section.note(Problem::at(section.span_of("case"), message, "no `share`, `cycles` or `order`").help(help));
        return None;
    }
    let (word, by_share) = if shares >= cycles { ("share", true) } else { ("cycles", false) };
    let value = |r: &Read| if by_share { r.share } else { r.cycles };
    let mut values = Vec::new();
    for case in read {
        match value(case) {
            Some(value) => values.push(value),
            None => {
                let message = format!("load case `{}` has no `{word}`, and others have", case.name.get_ref());
                let help = "all cases have `share`, or all have `cycles`; 0 is a case that takes no time";
                section.note(Problem::at(case.span.clone(), message, "in this table").help(help));
            }
        }
    }
    if values.len() < read.len() {
        return None;
    }
    let sum: f64 = values.iter().sum();
    if by_share && (sum - 1.0).abs() > SUMS_TO_ONE {
        let message = format!("the shares of the load cases sum to {}, not to 1", crate::words::number(sum));
        let help = "a joint that rests for part of the time has a case for it: \
            points = [{ torque = \"0 N*m\", speed = \"0 rad/s\", duration = \"1 s\" }]";
        section.note(Problem::at(section.span_of("case"), message, "expected 1").help(help));
        return None;
    }
    if sum == 0.0 {
        let message = "every load case has `cycles = 0`: nothing happens";
        section.note(Problem::at(section.span_of("case"), message, "expected at least one"));
        return None;
    }
    Some(if by_share { Often::Shares(values) } else { Often::Cycles(values) })
}

/// The columns of torque per mass of all cases, one after the other.
fn joined(
    section: &Section,
    cases: &[(String, Motion)],
    columns: Vec<Vec<CarriedColumn>>,
    spans: &[std::ops::Range<usize>],
) -> Option<Vec<CarriedColumn>> {
    let mut all: Vec<CarriedColumn> = Vec::new();
    for (name, ..) in columns.iter().flatten() {
        if all.iter().any(|(known, ..)| known == name) {
            continue;
        }
        let (mut values, mut rates) = (Vec::new(), Vec::new());
        for (place, of_case) in columns.iter().enumerate() {
            let Some((_, v, r)) = of_case.iter().find(|(other, ..)| other == name) else {
                let message =
                    format!("load case `{}` has no torque per mass of `{name}`, and another has", cases[place].0);
                let help = "what a joint carries in one case it carries in all: give every motion the column";
                section.note(Problem::at(spans[place].clone(), message, "in this table").help(help));
                return None;
            };
            values.extend(v);
            rates.extend(r);
        }
        all.push((name.clone(), values, rates));
    }
    Some(all)
}

/// A `[[case]]` of the robot as it is written: its name, and which case each joint is in.
pub(super) struct Told {
    name: Option<Spanned<String>>,
    joints: Vec<(Spanned<String>, Spanned<String>)>,
}

/// Reads `[[case]]` of the robot.
pub(super) fn told(root: &Section) -> Vec<Told> {
    let tables = root
        .sections(key("case", "load cases of the joints that happen together; what no [[case]] has happens by name"));
    let read = |table: Section| {
        let name = table.required_text(key("name", "name of the robot's load case"), "\"trot\"");
        let asked = key("joints", "for joints by name: which of their load cases it is").value("table of names");
        let joints = table.entries(asked);
        table.finish();
        Told { name, joints }
    };
    tables.into_iter().map(read).collect()
}

/// Which load cases of the joints happen together.
pub(super) fn resolve(root: &Section, told: Vec<Told>, joints: &[Joint]) -> Option<Vec<RobotCase>> {
    let mut cases = Vec::new();
    let mut good = true;
    let mut names = HashSet::new();
    for Told { name, joints: asked } in told {
        if let Some(twice) = name.as_ref().filter(|name| !names.insert(name.get_ref().clone())) {
            let message = format!("two load cases of the robot are called `{}`", twice.get_ref());
            root.note(Problem::at(twice.span(), message, "second time"));
            good = false;
        }
        // Whom it does not name, is in the case of its name.
        let own = name.as_ref().map_or("", |name| name.get_ref().as_str());
        let mut chosen: Vec<Option<usize>> = joints.iter().map(|joint| case_named(joint, own)).collect();
        for (joint, case) in asked {
            let Some(place) = joints.iter().position(|j| j.name == *joint.get_ref()) else {
                let message = format!("`joints` names a joint `{}`, but there is none", joint.get_ref());
                let names = joints.iter().map(|j| j.name.as_str());
                root.note(Problem::at(joint.span(), message, "not a joint").suggest(joint.get_ref(), names));
                good = false;
                continue;
            };
            chosen[place] = case_named(&joints[place], case.get_ref());
            if chosen[place].is_none() {
                let message = format!("joint `{}` has no load case `{}`", joint.get_ref(), case.get_ref());
                let of: &[Case] = joints[place].motion.cases.as_ref().map_or(&[], |cases| &cases.list);
                let names = of.iter().map(|case| case.name.as_str());
                root.note(Problem::at(case.span(), message, "not a case of it").suggest(case.get_ref(), names));
                good = false;
            }
        }
        match name.map(Spanned::into_inner) {
            Some(name) => cases.push(RobotCase { name, cases: chosen }),
            None => good = false,
        }
    }
    good.then_some(cases)
}
