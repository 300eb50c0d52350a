//! What joints and models say against each other.

use super::said::{alone, backing};
use crate::hardware::Hardware;
use crate::models::{ModelFacts, ModelJoint, within};
use crate::rule::{Backing, ModelRemark, Rule, Severity, Test};
use gearwise_model::mechanism::stated::Quantity;
use gearwise_model::words::{nearest, number, with_unit};

/// What numbers of two files, or of two sides, may differ by \[share\]: rounding.
const SAME: f64 = 1e-3;

pub const SAME_LIMITS: Rule = Rule {
    code: "GW409",
    name: "same-limits-behind-transmissions",
    summary: "joints behind different transmissions do not carry the same limits",
    severity: Severity::Error,
    what: "Finds joints that are driven by one row through transmissions of different r and carry the same effort and the same velocity. Torque is r times, speed 1/r times that of the actuator; their product is the same at every joint.",
    why: "A knee behind a crank or a belt has more torque and less speed than the hip with the same actuator. IsaacLab #7479: 23.7 N*m and 30.1 rad/s at all joints of a robot whose calf has r = 1.917, which is 45.43 N*m and 15.7 rad/s.",
    example: "Hip and calf with effort=\"23.7\" velocity=\"30.1\", and transmission = { ratio = 1.917 } at the calf.",
    fix: "Write r times the effort and 1/r times the velocity at the joint behind the transmission.",
    test: Test::Models(same_limits),
};

fn same_limits(facts: &ModelFacts) -> Vec<ModelRemark> {
    let remark = |(k, other): (usize, usize)| {
        let (joint, twin) = (&facts.joints[k], &facts.joints[other]);
        let (hardware, of_twin) = (joint.hardware?, twin.hardware?);
        let (effort, velocity) = (joint.get(Quantity::Effort)?, joint.get(Quantity::Velocity)?);
        let turns = hardware.transmission / of_twin.transmission;
        // What the row says counts before what the other joint carries.
        let right_effort = hardware.peak.as_ref().map_or(effort.value * turns, |fact| fact.value);
        let right_velocity = hardware.fastest().map_or(velocity.value / turns, |fact| fact.value);
        let by_row = hardware.peak.is_some() && hardware.largest_speed.is_some();
        let there = match by_row {
            true => {
                let product = effort.value * velocity.value;
                let same = if within(right_effort * right_velocity, product, 0.01) {
                    format!(", the same {} W", number(product))
                } else {
                    String::new()
                };
                format!(
                    "its hardware gives {} N*m and {} rad/s there{same}",
                    number(right_effort),
                    number(right_velocity)
                )
            }
            false => format!(
                "{} N*m and {} rad/s make the same {} W",
                number(effort.value * turns),
                number(velocity.value / turns),
                number(effort.value * velocity.value)
            ),
        };
        let message = format!(
            "carries effort {} N*m and velocity {} rad/s as {} does, behind r = {} in place of {}: {there}",
            number(effort.value),
            number(velocity.value),
            twin.joint.name,
            number(hardware.transmission),
            number(of_twin.transmission),
        );
        let mut remark = ModelRemark::new(message, "limits", joint.at(&effort.span));
        remark.joint = Some(k);
        remark.against = Some(twin.at(&twin.get(Quantity::Effort)?.span));
        (remark.value, remark.bound, remark.unit) = (Some(effort.value), Some(right_effort), "N*m");
        remark.backing = Some(match &hardware.peak {
            Some(fact) => backing(fact, "peak torque", "N*m"),
            None => Backing {
                allows: format!("effort {} N*m", number(effort.value * turns)),
                row: hardware.label.clone(),
                source: String::new(),
                conversion: format!("{} × effort of {}", number(turns), twin.joint.name),
            },
        });
        // Limits below those of the hardware may be meant: then nothing is beyond it, and nothing is raised.
        let above = |value: f64, right: f64| value > right * (1.0 + facts.file.tolerances.limits);
        let (strong, fast) = (above(effort.value, right_effort), above(velocity.value, right_velocity));
        if by_row && !strong && !fast {
            remark.severity = Some(Severity::Warning);
        }
        if fast {
            remark = remark.write(Quantity::Velocity, right_velocity);
        }
        if strong {
            remark = remark.write(Quantity::Effort, right_effort);
        }
        remark.help = Some(match (strong, fast, by_row) {
            (false, false, true) => "both limits are kept there; look whether less than it gives is meant".into(),
            (false, true, _) => format!(
                "write velocity {} rad/s; the effort may be {} N*m",
                number(right_velocity),
                number(right_effort)
            ),
            (true, false, _) => format!(
                "write effort {} N*m; the velocity may be {} rad/s",
                number(right_effort),
                number(right_velocity)
            ),
            _ => format!("write effort {} N*m and velocity {} rad/s", number(right_effort), number(right_velocity)),
        });
        Some(remark)
    };
    facts.same_limits.iter().copied().filter_map(remark).collect()
}

pub(in crate::registry) const LEFT_RIGHT: Rule = Rule {
    code: "GW410",
    name: "left-right",
    summary: "joints of the left side carry the numbers of the right side",
    severity: Severity::Warning,
    what: "Finds joints whose names are mirrored (left/right, l/r, FL/FR, RL/RR, HL/HR, LF/RF, LH/RH) and whose effort, velocity, armature, friction, damping or gear differ. A number that is found wrong against its hardware already is not said again.",
    why: "Robots have two like sides; a number that was corrected at one of them only is a mistake at the other.",
    example: "effort=\"45\" at left_knee and effort=\"54\" at right_knee.",
    fix: "Write the same at both.",
    test: Test::Models(left_right),
};

/// Words of the left side with those of the right.
const SIDES: &[(&str, &str)] = &[
    ("left", "right"),
    ("l", "r"),
    ("fl", "fr"),
    ("rl", "rr"),
    ("hl", "hr"),
    ("bl", "br"),
    ("lf", "rf"),
    ("lh", "rh"),
    ("lb", "rb"),
];

/// The name of the joint of the right side for one of the left; `None` where the name has no side, or the right one.
fn mirrored(name: &str) -> Option<String> {
    let mut out = String::new();
    let mut changed = false;
    let mut word = String::new();
    let mut flush = |word: &mut String, out: &mut String| {
        let lower = word.to_lowercase();
        match SIDES.iter().find(|(left, _)| *left == lower).filter(|_| !changed) {
            Some((_, right)) => {
                changed = true;
                let upper = word.chars().all(char::is_uppercase);
                let capital = word.starts_with(char::is_uppercase);
                out.push_str(&match (upper, capital) {
                    (true, _) => right.to_uppercase(),
                    (false, true) => right[..1].to_uppercase() + &right[1..],
                    _ => (*right).to_string(),
                });
            }
            None => out.push_str(word),
        }
        word.clear();
    };
    let mut last_lower = false;
    for c in name.chars() {
        // A capital behind a small letter begins a word: LeftKnee.
        if c.is_alphabetic() && !(c.is_uppercase() && last_lower) {
            word.push(c);
        } else {
            flush(&mut word, &mut out);
            if c.is_alphabetic() { word.push(c) } else { out.push(c) }
        }
        last_lower = c.is_lowercase();
    }
    flush(&mut word, &mut out);
    changed.then_some(out)
}

fn left_right(facts: &ModelFacts) -> Vec<ModelRemark> {
    let mut remarks = Vec::new();
    for (k, joint) in facts.joints.iter().enumerate() {
        let Some(name) = mirrored(&joint.joint.name) else { continue };
        let Some((other, twin)) = facts.of_model(joint.model).find(|(_, twin)| twin.joint.name == name) else {
            continue;
        };
        for (word, quantity) in Quantity::NAMES.iter().filter(|(_, q)| *q != Quantity::Saturation) {
            let pair = [(k, joint), (other, twin)];
            let stated = pair.map(|(_, joint)| joint.get(*quantity));
            let value = |k: usize| stated[k].map(|s| s.value);
            if value(0) == value(1) || value(0).zip(value(1)).is_some_and(|(a, b)| within(a, b, SAME)) {
                continue;
            }
            if pair.iter().any(|(k, _)| facts.is_wrong(*k, *quantity)) {
                continue;
            }
            let say = |k: usize| value(k).map_or("nothing".into(), |v| with_unit(v, quantity.unit()));
            let message = format!("{word} is {}, that of {name} {}", say(0), say(1));
            let span = stated[0].map_or(&joint.joint.span, |s| &s.span);
            let mut remark = ModelRemark::new(message, word, joint.at(span));
            remark.joint = Some(k);
            remark.against = Some(twin.at(stated[1].map_or(&twin.joint.span, |s| &s.span)));
            (remark.value, remark.bound, remark.unit) = (value(0), value(1), quantity.unit());
            remark.help = Some("write the same at both sides".into());
            remarks.push(remark);
        }
    }
    remarks
}

pub(in crate::registry) const SCALED_COPY: Rule = Rule {
    code: "GW411",
    name: "scaled-copy",
    summary: "the efforts of a model are not those of another one times a factor",
    severity: Severity::Warning,
    what: "Compares the efforts of two models joint by joint, by their names: at least three, all with one quotient within 1 %, which is not 1.",
    why: "Efforts of real hardware do not scale all by one factor: such a file was multiplied to make a policy work, or two files mean different torques. GR00T #259: 3.00 times at every joint.",
    example: "A model for training with 3.00 times the efforts of the maker's.",
    fix: "Write the efforts of the hardware into both; scale in the controller if a policy needs it.",
    test: Test::Models(scaled_copy),
};

/// Every model with every one before it.
fn pairs(facts: &ModelFacts) -> impl Iterator<Item = (usize, usize)> + use<> {
    let count = facts.models.len();
    (0..count).flat_map(move |second| (0..second).map(move |first| (first, second)))
}

/// Joints of two models that have one name.
fn twins<'f, 'a>(
    facts: &'f ModelFacts<'a>,
    (first, second): (usize, usize),
) -> impl Iterator<Item = (&'f ModelJoint<'a>, usize, &'f ModelJoint<'a>)> {
    facts.of_model(second).filter_map(move |(k, joint)| {
        let (_, twin) = facts.of_model(first).find(|(_, twin)| twin.joint.name == joint.joint.name)?;
        Some((twin, k, joint))
    })
}

fn scaled_copy(facts: &ModelFacts) -> Vec<ModelRemark> {
    let remark = |(first, second): (usize, usize)| {
        let (factor, count) = facts.scale(second, first)?;
        let name = |model: usize| facts.models[model].source.name();
        let message = format!(
            "the efforts of all {count} joints are {} times those of {}",
            gearwise_model::words::number((factor * 1000.0).round() / 1000.0),
            name(first)
        );
        let efforts = |(twin, _, joint): (&ModelJoint, usize, &ModelJoint)| {
            Some((twin.at(&twin.get(Quantity::Effort)?.span), joint.at(&joint.get(Quantity::Effort)?.span)))
        };
        let (there, here) = twins(facts, (first, second)).find_map(efforts)?;
        let mut remark = ModelRemark::new(message, "efforts", here);
        remark.against = Some(there);
        (remark.value, remark.bound) = (Some(factor), Some(1.0));
        remark.help = Some("write the efforts of the hardware into both".into());
        Some(remark)
    };
    pairs(facts).filter_map(remark).collect()
}

pub(in crate::registry) const FILES_DISAGREE: Rule = Rule {
    code: "GW412",
    name: "files-disagree",
    summary: "two models of one robot state the same",
    severity: Severity::Warning,
    what: "Compares effort, velocity, armature, friction and damping of joints that have one name in two models; a quantity that one of the models does not state is not compared. Efforts that all differ by one factor are found by GW411 alone.",
    why: "A policy is trained on one file and run with the other. holosoma #47: 35 N*m and 30 rad/s in one, 50 and 37 in the other.",
    example: "URDF and MJCF of a humanoid with different ankle efforts.",
    fix: "Decide by the hardware which of the two is right, and write it into both.",
    test: Test::Models(files_disagree),
};

fn files_disagree(facts: &ModelFacts) -> Vec<ModelRemark> {
    let mut remarks = Vec::new();
    for pair in pairs(facts) {
        let scaled = facts.scale(pair.1, pair.0).is_some();
        for (twin, k, joint) in twins(facts, pair) {
            let compared =
                [Quantity::Effort, Quantity::Velocity, Quantity::Armature, Quantity::Friction, Quantity::Damping];
            let differ: Vec<_> = compared
                .into_iter()
                .filter(|quantity| !(scaled && *quantity == Quantity::Effort))
                .filter_map(|quantity| Some((quantity, twin.get(quantity)?, joint.get(quantity)?)))
                .filter(|(_, a, b)| !within(a.value, b.value, SAME))
                .collect();
            let Some((quantity, there, here)) = differ.first() else { continue };
            let rows: Vec<String> = differ
                .iter()
                .map(|(quantity, a, b)| {
                    format!("{} {} against {} {}", quantity.name(), number(b.value), number(a.value), quantity.unit())
                })
                .collect();
            let message = format!("{} in {}", rows.join(", "), facts.models[pair.0].source.name());
            let mut remark = ModelRemark::new(message, "files", joint.at(&here.span));
            remark.joint = Some(k);
            remark.against = Some(twin.at(&there.span));
            (remark.value, remark.bound, remark.unit) = (Some(here.value), Some(there.value), quantity.unit());
            remark.help = Some("decide by the hardware which of the two is right, and write it into both".into());
            remarks.push(remark);
        }
    }
    remarks
}

pub(in crate::registry) const COUPLED: Rule = Rule {
    code: "GW413",
    name: "coupled-efforts",
    summary: "two joints that two actuators drive together ask no more of them than they give",
    severity: Severity::Warning,
    what: "For a [[coupling]] with the matrix J (speeds of the actuators are J times those of the joints) the torques of the actuators are J⁻ᵀ times those of the joints. Their largest value at the corners of both efforts may not exceed the peak torque of either actuator. The hardware of the first joint is that of the first actuator.",
    why: "Both joints have their full effort at once in the box of a simulator, and the two actuators add up to one of the corners only. The ankles of many humanoids are built like this.",
    example: "Pitch 50 N*m and roll 50 N*m on two actuators of 25 N*m each.",
    fix: "Lower both efforts, or clip the torques of the actuators in the simulator.",
    test: Test::Models(coupled),
};

fn coupled(facts: &ModelFacts) -> Vec<ModelRemark> {
    let mut remarks = Vec::new();
    for coupling in &facts.file.couplings {
        for m in 0..facts.models.len() {
            let of = |name: &String| facts.of_model(m).find(|(_, joint)| joint.joint.name == *name);
            let [Some((k, first)), Some((_, second))] = [of(&coupling.joints[0]), of(&coupling.joints[1])] else {
                continue;
            };
            let [Some(a), Some(b)] = [first, second].map(|joint| joint.get(Quantity::Effort)) else { continue };
            let peaks = [first, second].map(|joint| alone(joint).and_then(Hardware::strongest));
            let [[p, q], [s, t]] = coupling.matrix;
            let determinant = p * t - q * s;
            // J⁻ᵀ of two by two.
            let inverse = [[t / determinant, -s / determinant], [-q / determinant, p / determinant]];
            for (row, peak) in inverse.iter().zip(peaks) {
                let Some(peak) = peak else { continue };
                let torque = row[0].abs() * a.value + row[1].abs() * b.value;
                if torque <= peak.value * (1.0 + facts.file.tolerances.limits) {
                    continue;
                }
                let message = format!(
                    "efforts {} and {} N*m together ask {} N*m of an actuator of {} N*m",
                    number(a.value),
                    number(b.value),
                    number(torque),
                    number(peak.value)
                );
                let mut remark = ModelRemark::new(message, "coupling", first.at(&a.span));
                remark.joint = Some(k);
                remark.against = Some((None, coupling.span.clone()));
                (remark.value, remark.bound, remark.unit) = (Some(torque), Some(peak.value), "N*m");
                remark.backing = Some(backing(peak, "peak torque", "N*m"));
                remark.help = Some(format!(
                    "lower both efforts by a factor of {}, or clip the torques of the actuators",
                    number(peak.value / torque)
                ));
                remarks.push(remark);
                break;
            }
        }
    }
    remarks
}

pub(in crate::registry) const UNMATCHED: Rule = Rule {
    code: "GW416",
    name: "unmatched",
    summary: "every joint of a model has hardware, and every pattern a joint",
    severity: Severity::Warning,
    what: "Notes joints that are driven and that no entry of the file of hardware names; warns of patterns and couplings that name no joint of any model. Joints that follow another one, or that no actuator of an MJCF model drives, are passed over.",
    why: "What nobody names is not checked, silently.",
    example: "names = [\"*_clf_joint\"] for joints that end in _calf_joint.",
    fix: "Correct the pattern, or add a [[joint]] for the rest.",
    test: Test::Models(unmatched),
};

fn unmatched(facts: &ModelFacts) -> Vec<ModelRemark> {
    let mut remarks = Vec::new();
    let names = || facts.joints.iter().map(|joint| joint.joint.name.as_str());
    let warn = |what: String, name: &str, span: &std::ops::Range<usize>| {
        let mut remark = ModelRemark::new(what, "names", (None, span.clone()));
        remark.help = Some(match nearest(&name.replace('*', ""), names()) {
            Some(near) => format!("`{near}` is near"),
            None => {
                let all: Vec<&str> = names().take(12).collect();
                format!("the joints are {}", all.join(", "))
            }
        });
        remark
    };
    for (pattern, span) in facts.file.mounts.iter().flat_map(|mount| &mount.names) {
        if !names().any(|name| gearwise_model::catalog::matches_pattern(pattern, name)) {
            remarks.push(warn(format!("`{pattern}` names no joint of the model"), pattern, span));
        }
    }
    for coupling in &facts.file.couplings {
        for name in coupling.joints.iter().filter(|joint| !names().any(|name| name == joint.as_str())) {
            remarks.push(warn(format!("`{name}` of a coupling is no joint of the model"), name, &coupling.span));
        }
    }
    for (k, joint) in facts.joints.iter().enumerate() {
        if joint.hardware.is_some() || joint.joint.is_passive {
            continue;
        }
        let mut remark =
            ModelRemark::new("has no hardware: nothing of it is checked", "hardware", joint.at(&joint.joint.span));
        remark.joint = Some(k);
        remark.severity = Some(Severity::Note);
        remark.help = Some("name it in a [[joint]] of the file of hardware".into());
        remarks.push(remark);
    }
    remarks
}

#[cfg(test)]
mod tests {
    use super::mirrored;

    #[test]
    fn names_are_mirrored() {
        for (left, right) in [
            ("left_knee_joint", Some("right_knee_joint")),
            ("LeftKnee", Some("RightKnee")),
            ("FL_calf_joint", Some("FR_calf_joint")),
            ("RL_calf", Some("RR_calf")),
            ("leg_l1_joint", Some("leg_r1_joint")),
            ("lf_haa", Some("rf_haa")),
            ("knee_L", Some("knee_R")),
            ("LH_KFE", Some("RH_KFE")),
            ("calf", None),
            ("right_knee", None),
            ("FR_calf", None),
            ("elbow_roll", None),
        ] {
            assert_eq!(mirrored(left).as_deref(), right, "{left}");
        }
    }
}
