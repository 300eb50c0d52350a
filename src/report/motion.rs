//! What is said of a joint's motion: its load cases, and whether it may be larger between its samples than at any of them.

use super::number;
use crate::motion::{Case, Cases, Often};
use crate::requirement::{Between, Course, Joint};

/// For people, each a sentence without its full stop: the cases, the sequence in which heat is followed, and what is not
/// known between samples.
pub(super) fn notes(joint: &Joint) -> Vec<String> {
    let cases = joint.motion.cases.as_ref();
    let list = cases.iter().flat_map(|cases| &cases.list).map(|case| of_case(joint, case));
    list.chain(cases.map(|cases| sequence(joint, cases))).chain(between(joint)).collect()
}

/// The same without what is only told to whoever asks for more.
pub(super) fn warnings(joint: &Joint) -> Vec<String> {
    let unordered = joint.motion.cases.as_ref().filter(|cases| !cases.is_ordered() && cases.sequence.len() > 1);
    unordered.map(|cases| sequence(joint, cases)).into_iter().chain(between(joint)).collect()
}

fn between(joint: &Joint) -> Option<String> {
    let share = joint.motion.between.unresolved()?;
    let percent = format!("{:.1} %", 100.0 * share);
    Some(match joint.motion.between {
        Between::Given(_) => format!(
            "Not resolved between samples: the motion gives its own rates, so that limits are kept at its samples \
             alone; by estimate torque, speed or acceleration are up to {percent} larger between two of them"
        ),
        _ => format!(
            "Resolved between samples to {percent} of the largest values only: the motion changes too much from \
             sample to sample"
        ),
    })
}

/// In which sequence heat is followed.
fn sequence(joint: &Joint, cases: &Cases) -> String {
    let sequence = cases.sequence_words();
    match (&cases.often, cases.once, joint.motion.repeat_every) {
        (Often::Order(_), false, _) => format!("Heat is followed over the order, again and again: {sequence}"),
        (Often::Order(_), true, None) => format!("Heat is followed over the order, once from cold: {sequence}"),
        (Often::Order(_), true, Some(every)) => {
            format!("Heat is followed over the order, made again every {} s: {sequence}", number(every))
        }
        _ if cases.sequence.len() == 1 => format!("Heat is followed over {sequence}, again and again"),
        _ => format!(
            "No order of the cases is stated: heat is followed over {sequence}, again and again. A case that goes on \
             for longer at a time may get hotter: `order` says so"
        ),
    }
}

fn of_case(joint: &Joint, case: &Case) -> String {
    let lasts = number(case.lasts());
    let course = match (case.course, case.repeat_every) {
        (Course::Periodic(_), _) => format!("repeats every {lasts} s"),
        (Course::Once(_), None) => format!("lasts {lasts} s"),
        (Course::Once(_), Some(every)) => format!("lasts {lasts} s, made again every {} s", number(every)),
        (Course::Points(_) | Course::Cases, _) => format!("operating points, {lasts} s in all"),
    };
    let share = match case.share {
        0.0 => "takes no time, so that its heat and loss do not count".into(),
        share => format!("{} % of the time", number(100.0 * share)),
    };
    let (torque, speed) = joint.motion.peaks(case);
    let (torque, speed) = (number(torque), number(speed));
    format!("Case {}: {share}; {course}; at most {torque} N·m, {speed} rad/s", case.name)
}
