//! What is said of a joint's motion: its load cases, and whether it may be larger between its samples than at any of them.

use super::number;
use gearwise_model::motion::{Case, Cases, Often};
use gearwise_model::requirement::{Between, Course, Joint, Peaks};
use gearwise_model::transmission::Ways;

/// For people, each a sentence without its full stop: the cases, the sequence in which heat is followed, and what is not
/// known between samples.
pub(super) fn notes(joint: &Joint) -> Vec<String> {
    let cases = joint.motion.cases.as_ref().filter(|cases| !cases.together);
    let list = cases.iter().flat_map(|cases| &cases.list).map(|case| of_case(joint, case));
    let list = list.chain(cases.map(|cases| sequence(joint, cases)));
    transmission(joint).into_iter().chain(list).chain(between(joint)).chain(overshoots(joint)).collect()
}

/// The same without what is only told to whoever asks for more.
pub(super) fn warnings(joint: &Joint) -> Vec<String> {
    let unordered =
        joint.motion.cases.as_ref().filter(|cases| !cases.is_ordered() && cases.sequence.len() > 1 && !cases.together);
    let sequence = unordered.map(|cases| sequence(joint, cases));
    transmission(joint).into_iter().chain(sequence).chain(between(joint)).chain(overshoots(joint)).collect()
}

/// What is between actuator and joint, and what it makes of the motion.
fn transmission(joint: &Joint) -> Option<String> {
    let passed = joint.passed.as_deref()?;
    let range = match &passed.ways {
        Ways::One { ratio, .. } => match passed.constant() {
            Some(ratio) => format!("r = {}", number(ratio)),
            None => format!(
                "r = {} to {}, least at {}",
                number(ratio.least.0),
                number(ratio.most.0),
                passed.motion().name_sample(ratio.least.1)
            ),
        },
        Ways::Two(both) => format!(
            "two equal actuators move both joints; det J = {} to {}, least at {}",
            number(both.determinant.least.0),
            number(both.determinant.most.0),
            passed.motion().name_sample(both.determinant.least.1)
        ),
    };
    let peak = |Peaks { of, torque, speed }: &Peaks, alone: &str| {
        let of = if of.is_empty() { alone } else { of };
        format!("{} N·m and {} rad/s at {of}", number(*torque), number(*speed))
    };
    let [joints, actuators] = joint.peaks();
    let joints = joints.iter().map(|peaks| peak(peaks, "the joint"));
    let actuators = actuators.iter().map(|peaks| peak(peaks, "the actuator"));
    let peaks = joints.chain(actuators).collect::<Vec<_>>().join(", ");
    let loss = match passed.numbers.says_loss {
        true => format!("it loses {} W, which are not in the loss shown here", number(passed.loss)),
        false => "its loss is not known: no `efficiency` is given".into(),
    };
    Some(format!(
        "Transmission ({}): {range}; at most {peaks}. Torques, speeds and gear ratios here are those of the actuator; inertia \
         is that at the joint; {loss}",
        passed.word()
    ))
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

/// By what share of their range torque or speed may go beyond the samples between them before it is said.
const OVERSHOOT: f64 = 0.05;

/// Where the spline through the samples goes far beyond them: at a step, mostly.
fn overshoots(joint: &Joint) -> Vec<String> {
    let motion = &joint.motion;
    if matches!(motion.between, Between::Given(_)) || motion.given.len() == motion.len() {
        return Vec::new();
    }
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let of = |(name, unit, rate, values): (&str, &str, &str, &Vec<f64>)| {
        let all = ends(&mut values.iter().copied());
        let at = ends(&mut motion.given.iter().map(|k| values[*k]));
        let beyond = (all.1 - at.1).max(at.0 - all.0);
        (beyond > OVERSHOOT * (at.1 - at.0)).then(|| {
            format!(
                "Between its samples the {name} goes from {} to {} {unit}, at them from {} to {}: it steps, and limits are kept at \
                 what the spline makes of the step; give more samples there, or the `{rate}` that is meant",
                number(all.0),
                number(all.1),
                number(at.0),
                number(at.1)
            )
        })
    };
    let all = [("torque", "N*m", "torque_rate", &motion.torque), ("speed", "rad/s", "acceleration", &motion.velocity)];
    all.into_iter().filter_map(of).collect()
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
