//! Limits that a model states: torque, speed, gear.

use super::said::{NO_TORQUE, about, alone, asked, factors, is_explained, percent, stated_as};
use crate::hardware::{Fact, Holds};
use crate::models::{ModelFacts, explained, within};
use crate::rule::{Judgement, ModelRemark, Rule, Severity, Test};
use gearwise_model::catalog::module::on_curve;
use gearwise_model::mechanism::stated::Quantity;
use gearwise_model::words::number;

pub(in crate::registry) const EFFORT_ABOVE_PEAK: Rule = Rule {
    code: "GW401",
    name: "effort-above-peak",
    summary: "no joint of a model gives more torque than its hardware",
    severity: Severity::Error,
    what: "Compares the effort of each joint (URDF `effort`; MJCF `actuatorfrcrange`, `forcerange`, `ctrlrange` of a motor, with `gear`) with the peak torque of the hardware at the joint: r times that of a module, N η r times that of a motor. One that is N r times the motor's, before the gear's loss, is a note: simulators' joints have no such loss.",
    why: "A controller that was trained or tuned with torque that nobody can buy falls over on the robot. Interbotix #253: effort 20 N*m on a servo of 4.1 N*m.",
    example: "effort=\"20\" at a joint driven by a servo with a stall torque of 4.1 N*m.",
    fix: "Write the peak torque at the joint; or name the hardware that is really there.",
    test: Test::ModelJoint(effort_above_peak),
};

const NO_GEAR_PEAK: &str = "its gear's peak torque is not known: the effort is not above what the motor gives";

/// No finding for a value up to a fact; not judged if the fact is an upper bound only.
fn not_above(fact: &Fact, gear_is_unknown: &'static str) -> Judgement {
    match fact.holds {
        Holds::AtMost => Judgement::NotJudged(gear_is_unknown),
        Holds::Exactly | Holds::AtLeast => Judgement::Judged(Vec::new()),
    }
}

fn effort_above_peak(facts: &ModelFacts, k: usize) -> Judgement {
    let (hardware, effort) = match asked(facts, k, Quantity::Effort) {
        Ok(asked) => asked,
        Err(judgement) => return judgement,
    };
    let Some(peak) = hardware.strongest() else { return Judgement::NotJudged(NO_TORQUE) };
    if effort.by_gear && !facts.wrong_gears(k).is_empty() {
        return Judgement::NotJudged("its gear is wrong, and the effort is a multiple of it");
    }
    let above = effort.value > peak.value * (1.0 + facts.file.tolerances.limits);
    if is_explained(facts, k) {
        return Judgement::Judged(Vec::new());
    }
    if !above {
        return not_above(peak, NO_GEAR_PEAK);
    }
    let share = facts.file.tolerances.limits;
    if let Some(before) = hardware.before_loss.as_ref().filter(|b| within(effort.value, b.value, share)) {
        let message = format!(
            "{} is, within the tolerance, the peak torque before the gear's loss; {} N*m reach a load that the motor drives",
            stated_as(effort),
            number(peak.value)
        );
        let mut remark = about(k, facts, effort, message).against(before, "peak torque before the gear's loss");
        remark.severity = Some(Severity::Note);
        remark.help = Some(format!("a joint without loss is nearest with {} N*m while it drives", number(peak.value)));
        return Judgement::Judged(vec![remark]);
    }
    let why =
        explained(effort.value / peak.value, &factors(hardware, 1)).map_or(String::new(), |why| format!("; {why}"));
    let message = format!("{} is above the peak torque, {} N*m{why}", stated_as(effort), number(peak.value));
    let remark = about(k, facts, effort, message).against(peak, "peak torque");
    Judgement::Judged(vec![remark.write(Quantity::Effort, peak.value)])
}

pub(in crate::registry) const EFFORT_MEANING: Rule = Rule {
    code: "GW402",
    name: "effort-meaning",
    summary: "the effort of a model is the peak torque of its hardware",
    severity: Severity::Warning,
    what: "An effort below the peak torque is compared with the other torques of the row. Where it is one of them (rated, stall, continuous) within the tolerance, a note says which; where it is none, that is a warning. An effort that is the peak torque has no finding.",
    why: "A simulator clips torque at the effort: a rated torque in its place takes from the robot what it has for seconds, and nobody sees it. IsaacLab #2478: the effort of a humanoid was the rated torque.",
    example: "effort=\"60\" for an actuator of 60 N*m rated and 180 N*m peak torque.",
    fix: "Write the peak torque, or say in the model why less is meant and except the joint with [[allow]].",
    test: Test::ModelJoint(effort_meaning),
};

fn effort_meaning(facts: &ModelFacts, k: usize) -> Judgement {
    let (hardware, effort) = match asked(facts, k, Quantity::Effort) {
        Ok(asked) => asked,
        Err(judgement) => return judgement,
    };
    if effort.by_gear && !facts.wrong_gears(k).is_empty() {
        return Judgement::NotJudged("its gear is wrong, and the effort is a multiple of it");
    }
    let share = facts.file.tolerances.limits;
    let other = hardware.others.iter().find(|(_, fact)| within(effort.value, fact.value, share));
    let note = |(name, fact): &(&str, Fact)| {
        let message = format!("{} is the {name} of its hardware, not the peak torque", stated_as(effort));
        let mut remark = about(k, facts, effort, message).against(fact, name);
        remark.severity = Some(Severity::Note);
        remark.help = hardware.peak.as_ref().map(|peak| format!("the peak torque is {} N*m", number(peak.value)));
        Judgement::Judged(vec![remark])
    };
    let Some(peak) = &hardware.peak else {
        return other.map_or(Judgement::NotJudged(NO_TORQUE), note);
    };
    if effort.value >= peak.value * (1.0 - share) || is_explained(facts, k) {
        return Judgement::Judged(Vec::new());
    }
    if let Some(other) = other {
        return note(other);
    }
    if peak.holds == Holds::AtMost {
        return Judgement::NotJudged("its gear's peak torque is not known, and the effort may be that");
    }
    let why =
        explained(effort.value / peak.value, &factors(hardware, 1)).map_or(String::new(), |why| format!("; {why}"));
    let names: Vec<&str> = std::iter::once("peak").chain(hardware.others.iter().map(|(name, _)| *name)).collect();
    let message = format!("{} is none of the torques of its hardware ({}){why}", stated_as(effort), names.join(", "));
    let mut remark = about(k, facts, effort, message).against(peak, "peak torque");
    remark.help = Some(format!("write {} N*m if the peak torque is meant", number(peak.value)));
    Judgement::Judged(vec![remark])
}

pub(in crate::registry) const VELOCITY_ABOVE_NO_LOAD: Rule = Rule {
    code: "GW403",
    name: "velocity-above-no-load",
    summary: "no joint of a model is faster than its hardware",
    severity: Severity::Error,
    what: "Compares the velocity of each joint with the largest speed of the hardware, divided by r: the least of the no-load speed, the motor's `max_speed` and the gear's `max_input_speed`. The no-load speed of a module falls in proportion to a `voltage` below that of its row; that of a motor is the supply voltage over the back-EMF constant. A factor of 57.3 is degrees, one of 9.55 is rpm.",
    why: "Beyond its no-load speed an actuator gives no torque, and beyond the gear's input speed it fails early: a policy that uses it cannot run on the robot.",
    example: "velocity=\"1720\" for 30 rad/s in degrees.",
    fix: "Write the largest speed at the joint in rad/s.",
    test: Test::ModelJoint(velocity_above_no_load),
};

const AT_MORE_VOLTAGE: &str =
    "its row prints speeds at less voltage than it is driven with: what it does at more is not known";

const NO_GEAR_SPEED: &str =
    "its gear's largest input speed is not known: the velocity is not above what motor and voltage give";

fn velocity_above_no_load(facts: &ModelFacts, k: usize) -> Judgement {
    let (hardware, velocity) = match asked(facts, k, Quantity::Velocity) {
        Ok(asked) => asked,
        Err(judgement) => return judgement,
    };
    let Some(free) = &hardware.largest_speed else {
        return Judgement::NotJudged("neither a row of its hardware nor a `voltage` gives a largest speed");
    };
    if is_explained(facts, k) {
        return Judgement::Judged(Vec::new());
    }
    if velocity.value <= free.value * (1.0 + facts.file.tolerances.limits) {
        return not_above(free, NO_GEAR_SPEED);
    }
    let most = hardware.largest_speed_most.as_ref();
    let beyond = |most: &&Fact| velocity.value > most.value * (1.0 + facts.file.tolerances.limits);
    let free = match (free.holds, most.filter(beyond)) {
        (Holds::Exactly | Holds::AtMost, _) => free,
        (Holds::AtLeast, Some(most)) => most,
        (Holds::AtLeast, None) => return Judgement::NotJudged(AT_MORE_VOLTAGE),
    };
    let mut all = factors(hardware, 1);
    all.push((1.0_f64.to_degrees(), "degrees in place of radians (57.3)".into()));
    all.push((30.0 / std::f64::consts::PI, "rpm in place of rad/s (9.55)".into()));
    let why = explained(velocity.value / free.value, &all).map_or(String::new(), |why| format!("; {why}"));
    let message = format!(
        "{} is above the largest speed of its hardware, {} rad/s{why}",
        stated_as(velocity),
        number(free.value)
    );
    let remark = about(k, facts, velocity, message).against(free, "largest speed");
    Judgement::Judged(vec![remark.write(Quantity::Velocity, free.value)])
}

pub(in crate::registry) const BOX: Rule = Rule {
    code: "GW404",
    name: "torque-speed-box",
    summary: "the box of effort and velocity lies under the torque–speed curve",
    severity: Severity::Note,
    what: "Most simulators clip torque and speed one by one: a box. The rule says which share of the box lies above the torque–speed curve of the hardware, where more than 1 % does. A joint with a `saturation` has a curve of its own and is not asked.",
    why: "In the corner of the box the simulated robot is strong and fast at once, which no motor is; fast motions that need it do not transfer. IsaacLab #3410.",
    example: "Effort 71 N*m and velocity 35.5 rad/s for an actuator that gives 71 N*m up to 22.6 rad/s only: 18 % of the box.",
    fix: "Use an actuator model with a torque–speed curve, or limit the velocity to that at which the full torque ends.",
    test: Test::ModelJoint(outside_box),
};

fn outside_box(facts: &ModelFacts, k: usize) -> Judgement {
    let joint = &facts.joints[k];
    // What is not stated is said by the rules of effort and velocity.
    let both =
        asked(facts, k, Quantity::Effort).and_then(|(_, effort)| Ok((effort, asked(facts, k, Quantity::Velocity)?)));
    let Ok((effort, (hardware, velocity))) = both else { return Judgement::NotAsked };
    if joint.get(Quantity::Saturation).is_some() {
        return Judgement::NotAsked;
    }
    let Some((points, fact)) = &hardware.curve else {
        return Judgement::NotJudged("no row of its hardware gives a torque–speed curve");
    };
    if fact.holds == Holds::AtLeast {
        return Judgement::NotJudged(AT_MORE_VOLTAGE);
    }
    let share = facts.file.tolerances.limits;
    let beyond = |value: f64, fact: &Option<Fact>| fact.as_ref().is_some_and(|fact| value > fact.value * (1.0 + share));
    // What is beyond the curve altogether is found as such.
    if beyond(effort.value, &hardware.peak) || beyond(velocity.value, &hardware.largest_speed) || is_explained(facts, k)
    {
        return Judgement::Judged(Vec::new());
    }
    let (e, v) = (effort.value, velocity.value);
    if e <= 0.0 || v <= 0.0 {
        return Judgement::Judged(Vec::new());
    }
    let steps = 2000;
    let speed = |i: usize| v * (i as f64 + 0.5) / f64::from(steps);
    let under: f64 = (0..steps as usize).map(|i| on_curve(points, speed(i)).min(e)).sum();
    let outside = 1.0 - under / (e * f64::from(steps));
    if outside <= 0.01 {
        return Judgement::Judged(Vec::new());
    }
    let corner = (0..steps as usize).map(speed).take_while(|w| on_curve(points, *w) >= e * 0.999).last();
    let message = format!(
        "{} of the box of effort {} N*m and velocity {} rad/s is above the torque–speed curve of its hardware",
        percent(outside),
        number(e),
        number(v)
    );
    let mut remark = about(k, facts, velocity, message).against(fact, "torque–speed curve");
    if let Some(backing) = &mut remark.backing {
        backing.allows = format!("{} N*m at {} rad/s", number(on_curve(points, v)), number(v));
    }
    (remark.value, remark.bound, remark.unit) = (Some(outside), Some(0.01), "1");
    remark.help = Some(match corner {
        Some(corner) => format!(
            "use an actuator model with the curve; or write a velocity of {} rad/s, up to which it gives the whole effort",
            number(corner)
        ),
        None => "use an actuator model with the curve".into(),
    });
    Judgement::Judged(vec![remark])
}

pub(in crate::registry) const GEAR: Rule = Rule {
    code: "GW408",
    name: "model-gear",
    summary: "the gear of a model's actuator is that of its hardware",
    severity: Severity::Error,
    what: "In MJCF the torque at the joint is `gear` times the force of the actuator. A gear may be 1 (the force is the joint's torque), r (that of the actuator) or N r (that of the motor): anything else is none of the hardware, as N alone where a belt or a crank is behind it. Where the joint states `actuatorfrcrange` and its actuator `forcerange`, gear × forcerange must give the same.",
    why: "A gear that is squared, left out or that of another joint scales every torque of the policy. mini-cheetah-pybullet #2.",
    example: "gear=\"36\" for a gear of 6:1.",
    fix: "Write N r with the force range of the motor, or 1 with that of the joint.",
    test: Test::ModelJoint(gear),
};

fn gear(facts: &ModelFacts, k: usize) -> Judgement {
    let joint = &facts.joints[k];
    let Some(hardware) = alone(joint) else { return Judgement::NotAsked };
    let mut gears = joint.joint.all(Quantity::Gear).peekable();
    if gears.peek().is_none() {
        // Without a word it is 1.
        return torn(facts, k).map_or(Judgement::NotAsked, |remark| Judgement::Judged(vec![remark]));
    }
    let Some(n) = hardware.gear else {
        return Judgement::NotJudged("no row of its hardware gives the ratio of its gear");
    };
    if hardware.varies {
        return Judgement::NotJudged("the ratio of its transmission goes with the angle");
    }
    let whole = n * hardware.transmission;
    let mut remarks = Vec::new();
    for wrong in facts.wrong_gears(k) {
        let mut all = factors(hardware, 1);
        all.push((n, format!("N² (N = {}) in place of N", number(n))));
        let why = explained(wrong.value / whole, &all).map_or(String::new(), |why| format!("; {why}"));
        let r = hardware.transmission;
        let right = if r == 1.0 {
            format!("1 or N = {}", number(n))
        } else {
            format!("1, r = {} or N r = {}", number(r), number(whole))
        };
        let message = format!("gear {} is none of its hardware's: {right}{why}", number(wrong.value));
        let mut remark = about(k, facts, wrong, message);
        remark.bound = Some(whole);
        remark.backing = Some(crate::rule::Backing {
            allows: format!("ratio {}", number(whole)),
            row: hardware.label.clone(),
            source: String::new(),
            conversion: if r == 1.0 {
                format!("N = {}", number(n))
            } else {
                format!("N r, N = {}, r = {}", number(n), number(r))
            },
        });
        remark.help =
            Some(format!("write {} with the force range of the motor, or 1 with that of the joint", number(whole)));
        remarks.push(remark);
    }
    if remarks.is_empty() {
        remarks.extend(torn(facts, k));
    }
    Judgement::Judged(remarks)
}

/// A force range that is not that of the joint.
fn torn(facts: &ModelFacts, k: usize) -> Option<ModelRemark> {
    let joint = &facts.joints[k];
    let own = joint.joint.all(Quantity::Effort).find(|s| s.called == "actuatorfrcrange")?;
    let share = facts.file.tolerances.limits;
    let mut forces = joint.joint.all(Quantity::Effort).filter(|s| s.called.starts_with("forcerange"));
    let force = forces.find(|s| !within(s.value, own.value, share))?;
    let message = format!(
        "{} is {} N*m and actuatorfrcrange {} N*m: the two limit one torque",
        force.called,
        number(force.value),
        number(own.value)
    );
    let mut remark = about(k, facts, force, message);
    remark.bound = Some(own.value);
    remark.against = Some(joint.at(&own.span));
    remark.help = Some("write the same torque at both, the force divided by `gear`".into());
    Some(remark)
}

pub(in crate::registry) const SATURATION: Rule = Rule {
    code: "GW415",
    name: "model-saturation",
    summary: "the effort of a model is below its saturation, and its torque–speed line ends where the hardware's does",
    severity: Severity::Error,
    what: "Of limits with a `saturation` (the torque at standstill of a torque–speed line that ends at `velocity`): the effort may not be above it, and the velocity must be no less than the largest speed of the hardware (GW403).",
    why: "The line is clipped by the effort. An effort above the saturation never acts, and a line that ends early takes torque at every speed. IsaacLab #2103.",
    example: "effort 33.5 N*m with saturation 23.7 N*m.",
    fix: "Write the stall torque of the line as saturation, the peak torque as effort, the largest speed of the hardware as velocity.",
    test: Test::ModelJoint(saturation),
};

fn saturation(facts: &ModelFacts, k: usize) -> Judgement {
    let joint = &facts.joints[k];
    let Some(saturation) = joint.get(Quantity::Saturation) else { return Judgement::NotAsked };
    let share = facts.file.tolerances.limits;
    if let Some(effort) = joint.get(Quantity::Effort)
        && effort.value > saturation.value * (1.0 + 1e-6)
    {
        let message =
            format!("{} is above the saturation, {} N*m: it never acts", stated_as(effort), number(saturation.value));
        let mut remark = about(k, facts, effort, message);
        remark.bound = Some(saturation.value);
        remark.against = Some(joint.at(&saturation.span));
        let is_right = |fact: &Fact| within(saturation.value, fact.value, share);
        remark.help = Some(match alone(joint).and_then(|hardware| hardware.peak.as_ref()).is_some_and(is_right) {
            true => format!("write an effort of {} N*m: its hardware gives no more", number(saturation.value)),
            false => "write the torque at standstill of the torque–speed line as saturation".into(),
        });
        return Judgement::Judged(vec![remark]);
    }
    let (Some(hardware), Some(velocity)) = (alone(joint), joint.get(Quantity::Velocity)) else {
        return Judgement::Judged(Vec::new());
    };
    let Some(largest) = &hardware.largest_speed else {
        return Judgement::NotJudged("neither a row of its hardware nor a `voltage` gives a largest speed");
    };
    if velocity.value >= largest.value * (1.0 - share) {
        return Judgement::Judged(Vec::new());
    }
    // Where motor or gear allow less than the no-load speed, a line up to that would break GW403.
    let name = if hardware.no_load.as_ref() == Some(largest) { "no-load speed" } else { "largest speed" };
    let message =
        format!("{} ends the torque–speed line below the {name}, {} rad/s", stated_as(velocity), number(largest.value));
    let remark = about(k, facts, velocity, message).against(largest, name);
    Judgement::Judged(vec![remark.write(Quantity::Velocity, largest.value)])
}
