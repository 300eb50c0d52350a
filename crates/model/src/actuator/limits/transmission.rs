//! What is between actuator and joint may bear.

use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::transmission::SpringAt;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "transmission_torque",
        unit: "N*m",
        formula: "safety · max |τ + J_j α| ≤ largest torque of the transmission, both at the joint",
        safety: true,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| states(joint, |t| t.peak_torque),
        key: |_| Some(Key::Joint(&["transmission", "peak_torque"])),
        prepare: |c| match c.joint.passed.as_deref().map(|passed| (passed, passed.numbers.peak_torque)) {
            Some((passed, Some(bound))) => at_joint(c, passed.largest_torque(), bound),
            _ => Prepared::NotAsked,
        },
    },
    Limit {
        name: "transmission_force",
        unit: "N",
        formula: "safety · max |τ + J_j α|/h ≤ largest force of rod or screw, h its moment arm about the joint",
        safety: true,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| states(joint, |t| t.max_force),
        key: |_| Some(Key::Joint(&["transmission", "max_force"])),
        prepare: |c| match c.joint.passed.as_deref().map(|passed| (passed, passed.numbers.max_force)) {
            Some((passed, Some(bound))) => match passed.largest_force() {
                Some(force) => at_joint(c, force, bound),
                None => Prepared::Unknown("no moment arm of the transmission is known"),
            },
            _ => Prepared::NotAsked,
        },
    },
    Limit {
        name: "transmission_speed",
        unit: "rad/s",
        formula: "max |r ω| ≤ largest speed of the transmission's input",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| states(joint, |t| t.max_input_speed),
        key: |_| Some(Key::Joint(&["transmission", "max_input_speed"])),
        prepare: |c| match c.joint.passed.as_deref().and_then(|passed| passed.numbers.max_input_speed) {
            Some(bound) => plain(fixed(c, c.load.peak_speed), 1.0, bound, "transmission"),
            None => Prepared::NotAsked,
        },
    },
];

fn states(joint: &crate::requirement::Joint, of: fn(&crate::transmission::Numbers) -> Option<f64>) -> bool {
    joint.passed.as_deref().is_some_and(|passed| of(&passed.numbers).is_some())
}

/// A demand with its sample that neither ratio nor motor changes. Where a spring is chosen, what is fixed has its torque in it, and this
/// has not.
fn fixed(c: &Candidate, (value, sample): (f64, usize)) -> Demand {
    match c.joint.limits.spring {
        Some(_) => Demand::Constant(value),
        None => Demand::Fixed(value, Some(sample)),
    }
}

/// A torque or force of the joint. A spring at the joint takes some of it, a spring at the actuator nothing.
fn at_joint(c: &Candidate, largest: (f64, usize), bound: f64) -> Prepared {
    match c.joint.limits.spring {
        Some(spring) if spring.at == SpringAt::Joint => {
            Prepared::Unknown("the torque that a spring at the joint takes from the transmission is not judged")
        }
        _ if !c.joint.carries.is_empty() => {
            Prepared::Unknown("the torque that carried actuators add to the transmission is not judged")
        }
        _ => plain(fixed(c, largest), c.joint.limits.safety, bound, "transmission"),
    }
}
