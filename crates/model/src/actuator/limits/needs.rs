//! What is needed beside the limits.

use super::heat::{has_heat_of_drag, heat_of_drag};
use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::actuator::waveform::Functional;
use crate::actuator::weakening::{AlongD, Weakening};
use crate::catalog::Motor;
use crate::catalog::convention::Commutation;
use crate::catalog::module::Inside;
use crate::requirement::{Joint, MotorDrag, Quantity, Robot};

/// Whether all joints together have a budget or a supply that their power counts for.
fn shares_power(robot: &Robot) -> bool {
    robot.shared_power().is_some() || robot.shared_regeneration().is_some() || robot.shared_resistance().is_some()
}

/// What cannot be told without currents.
pub const ELECTRICAL: [Quantity; 5] =
    [Quantity::Loss, Quantity::CopperLoss, Quantity::Energy, Quantity::PeakCurrent, Quantity::PeakPower];

/// Something that is asked of a candidate and that no limit of the model asks for: a number without which a limit
/// says less, or one that the whole robot needs.
pub struct Need {
    /// Name, beside those of the limits.
    pub name: &'static str,
    /// What it is about.
    pub of: Of,
    /// Whether the requirement asks for what cannot be judged without it.
    pub stated: fn(&Robot, &Joint) -> bool,
    /// Where a requirement asks for it, by whose it is.
    pub key: fn(&str) -> Option<Key>,
    /// What is missing, if anything.
    pub missing: fn(&Candidate) -> Option<&'static str>,
    /// What can be said of it only at a ratio that was chosen; `None` of a candidate of which nothing can.
    pub at_ratio: fn(&Candidate) -> Option<Judge>,
}

impl std::fmt::Debug for Need {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// What is said of the rate of a current that weakens the field, which the voltage leaves out.
fn rate_along_d(candidate: &Candidate, ratio: f64) -> Verdict {
    let rate = candidate.at_ratio(ratio, |here| here.what_weakening_takes().and_then(|weakening| weakening.rate));
    match rate.is_some_and(|rate| rate >= Weakening::RATE_WORTH_A_WORD) {
        true => Verdict::Assumed(
            "the voltage of a changing i_d, L di_d/dt, is left out: at some instant it is 1 % of the voltage limit or more",
        ),
        false => Verdict::Kept,
    }
}

const NOT_BORNE: &str =
    "how much current the magnets bear is not known: the field weakening current of the requirement alone bounds it";
const NOT_BORNE_BURNING: &str =
    "how much current the magnets bear is not known: that of flux braking is bounded by the largest current alone";
const LESS_BORNE: &str =
    "the motor's peak current is not known: only the drive's is checked, and the magnets may bear less";

/// Whether only the drive bounds the current that the magnets have to bear.
fn only_by_drive(c: &Candidate) -> bool {
    c.motor.peak_current.is_none() && c.joint.drive_current.or(c.robot.bus.drive_current).is_some()
}

/// Whether it is known of the magnets that they bear the current along d at a ratio.
fn magnets(candidate: &Candidate, ratio: f64) -> Verdict {
    let largest = candidate.at_ratio(ratio, |here| here.what_weakening_takes().map_or(0.0, |taken| taken.largest));
    match candidate.along_d() {
        Some(AlongD::Weakening(_)) if largest > 0.0 => Verdict::Unknown(NOT_BORNE),
        Some(AlongD::Braking { .. }) if largest > 0.0 => Verdict::Unknown(NOT_BORNE_BURNING),
        _ if only_by_drive(candidate) => Verdict::Unknown(LESS_BORNE),
        _ => Verdict::Kept,
    }
}

/// Whether there is a current along d of which it is not known whether the magnets bear it.
fn may_harm_magnets(c: &Candidate) -> bool {
    c.along_d().is_some() && c.motor.demagnetization_current.is_none()
}

/// True if the row prints a peak torque, but neither the current there nor how far the torque is from K_T times the current.
fn lacks_saturation(motor: &Motor) -> bool {
    let measured = motor.fit.is_some() || !motor.effects.is_empty() || motor.inside.is_some();
    let sheet = &motor.sheet;
    sheet.peak_torque.is_some() && sheet.peak_current.is_none() && sheet.peak_torque_linearity.is_none() && !measured
}

/// Linearity T/(K_T i) at which makers print a peak torque: 20 % non-linearity.
const LEAST_LINEARITY: f64 = 0.8;

/// The x of tanh(x)/x = [`LEAST_LINEARITY`].
const LEAST_LINEARITY_AT: f64 = 0.888_014_7;

/// Relative excess of the current from which it is reported.
const EXCESS_WORTH_A_WORD: f64 = 0.02;

/// Verdict on the current at the largest torque if the iron saturates as T = K_T i_s tanh(i/i_s), with 80 % linearity at the printed peak torque.
fn saturated_current(candidate: &Candidate, ratio: f64) -> Verdict {
    let Some(peak) = candidate.motor.peak_torque else { return Verdict::Kept };
    let largest = candidate.at_ratio(ratio, |here| {
        here.load.waveform.largest(Functional::TorqueSquared, &here.actuator, ratio).value.max(0.0).sqrt()
    });
    let share = LEAST_LINEARITY * LEAST_LINEARITY_AT * (largest / peak).min(1.0);
    let excess = if share > 0.0 { share.atanh() / share } else { 1.0 };
    let linear = candidate.joint.limits.safety * largest / candidate.motor.torque_constant;
    let kept = candidate.joint.limits.left_of("peak_current");
    match candidate.peak_current().map(|(bound, owner)| (bound * kept, owner)) {
        _ if excess < 1.0 + EXCESS_WORTH_A_WORD => Verdict::Kept,
        Some((bound, _)) if linear <= bound && linear * excess > bound => Verdict::Unknown(
            "the row prints its peak torque without the current there: at 20 % non-linearity the current is up to 25 % higher, more than the drive's peak current",
        ),
        _ => Verdict::Assumed(
            "the row prints its peak torque without the current there: current is computed as T/K_T; at 20 % non-linearity it is up to 25 % higher near that torque, and copper loss up to 56 %",
        ),
    }
}

fn no_mass(candidate: &Candidate) -> Option<&'static str> {
    candidate.mass_at(1.0).is_none().then_some(NO_MASS)
}

/// Every need.
pub const NEEDS: &[Need] = &[
    Need {
        name: "inductance",
        of: Of::Other,
        stated: the_supply,
        key: by_nobody,
        // Where no voltage is computed, nothing is checked without it.
        missing: |c| match (c.motor.inductance, c.motor.pole_pairs) {
            _ if !c.motor.inside.as_deref().is_none_or(Inside::says_power) => None,
            (Some(_), Some(_)) => None,
            (None, _) => Some("the motor's inductance is not known: voltage is checked without it"),
            (Some(_), None) => Some(
                "the motor's pole pairs are not known: voltage is checked with L di/dt, but without p N ω L i across it",
            ),
        },
        at_ratio: |_| None,
    },
    Need {
        name: "module_constants",
        of: Of::Other,
        stated: |robot, joint| ELECTRICAL.iter().any(|q| joint.objective.weight(*q) > 0.0) || shares_power(robot),
        key: |_| Some(Key::Joint(&["objective"])),
        missing: |c| match c.motor.inside.as_deref() {
            Some(inside) if !inside.says_currents() => {
                Some("the module's row does not say what its currents are: neither current nor loss is known")
            }
            _ => None,
        },
        at_ratio: |_| None,
    },
    Need {
        name: "module_gear_loss",
        of: Of::Other,
        stated: |robot, joint| ELECTRICAL.iter().any(|q| joint.objective.weight(*q) > 0.0) || shares_power(robot),
        key: |_| Some(Key::Joint(&["objective"])),
        missing: |c| match c.motor.inside.as_deref() {
            Some(inside) if inside.says_currents() && !inside.says_loss() => Some(
                "the module's row does not say what its gear loses: currents and copper loss are at least what is computed",
            ),
            _ => None,
        },
        at_ratio: |_| None,
    },
    Need {
        name: "module_back_emf",
        of: Of::Other,
        stated: |robot, joint| {
            let asked = [Quantity::Energy, Quantity::PeakPower].iter().any(|q| joint.objective.weight(*q) > 0.0);
            asked || shares_power(robot)
        },
        key: |_| Some(Key::Joint(&["objective"])),
        missing: |c| match c.motor.inside.as_deref() {
            Some(inside) if inside.says_currents() && !inside.says_back_emf => {
                Some("the module's back-EMF constant is not known: power and energy are not")
            }
            _ => None,
        },
        at_ratio: |_| None,
    },
    Need {
        name: "module_curve",
        of: Of::Other,
        stated: by_data_sheets,
        key: by_nobody,
        missing: super::module::why_no_curve,
        at_ratio: |_| None,
    },
    Need {
        name: "module_curve_voltage",
        of: Of::Other,
        stated: by_data_sheets,
        key: by_nobody,
        missing: super::module::why_no_voltage,
        at_ratio: |_| None,
    },
    Need {
        name: "module_heat",
        of: Of::Other,
        stated: always,
        key: by_nobody,
        missing: |_| None,
        at_ratio: |c| super::module::is_judged_by_rating(c).then_some(super::module::heat_by_rating as Judge),
    },
    Need {
        name: "module_inertia",
        of: Of::Other,
        stated: |_, joint| {
            joint.objective.weight(Quantity::ReflectedInertia) > 0.0 || joint.limits.reflected_inertia.is_some()
        },
        key: by_nobody,
        missing: |c| match c.motor.inside.as_deref() {
            Some(inside) if !inside.says_inertia => {
                Some("the module's own inertia is not known: torques and currents are without it")
            }
            _ => None,
        },
        at_ratio: |_| None,
    },
    Need {
        name: "motor_drag",
        of: Of::Other,
        stated: |_, joint| [Quantity::Loss, Quantity::Energy].iter().any(|q| joint.objective.weight(*q) > 0.0),
        key: |_| Some(Key::Joint(&["objective"])),
        missing: |c| {
            // Of a module without constants there is no loss at all.
            let says_loss = c.motor.inside.as_deref().is_none_or(Inside::says_currents);
            let counts = c.joint.motor_drag == MotorDrag::Counted && c.drag_is_unknown() && says_loss;
            counts.then_some("the motor's drag is not known and left out: its row gives neither no-load current nor friction, and it is not estimated")
        },
        at_ratio: |_| None,
    },
    Need {
        name: "field_weakening",
        of: Of::Other,
        stated: by_data_sheets,
        key: by_nobody,
        missing: |c| c.why_not_weakened(),
        at_ratio: |c| matches!(c.along_d()?, AlongD::Weakening(_)).then_some(rate_along_d as Judge),
    },
    Need {
        name: "flux_braking",
        of: Of::Other,
        stated: by_data_sheets,
        key: by_nobody,
        missing: |c| c.why_not_braked(),
        at_ratio: |c| matches!(c.along_d()?, AlongD::Braking { .. }).then_some(rate_along_d as Judge),
    },
    Need {
        name: "demagnetisation",
        of: Of::Other,
        stated: by_data_sheets,
        key: by_nobody,
        missing: |c| (!may_harm_magnets(c) && only_by_drive(c)).then_some(LESS_BORNE),
        at_ratio: |c| may_harm_magnets(c).then_some(magnets as Judge),
    },
    Need {
        name: "torque_linearity",
        of: Of::Other,
        stated: by_data_sheets,
        key: by_nobody,
        missing: |_| None,
        at_ratio: |c| lacks_saturation(c.motor).then_some(saturated_current as Judge),
    },
    Need {
        name: "torque_bandwidth_voltage",
        of: Of::Other,
        stated: |_, joint| joint.limits.torque_bandwidth.is_some(),
        key: |_| Some(Key::Joint(&["limits", "torque_bandwidth"])),
        missing: |c| {
            let Motor { inductance, pole_pairs, conventions, .. } = c.motor;
            let brushless = conventions.commutation == Commutation::Brushless;
            let lacks = c.load.bandwidth.is_some() && inductance.is_some() && pole_pairs.is_none() && brushless;
            lacks.then_some(
                "the motor's pole pairs are not known: torque_bandwidth_voltage is checked without p N ω L i",
            )
        },
        at_ratio: |_| None,
    },
    Need {
        name: "gear_inertia",
        of: Of::Gear,
        stated: |_, joint| {
            joint.limits.reflected_inertia.is_some() || joint.objective.weight(Quantity::ReflectedInertia) > 0.0
        },
        key: |owner| (owner == "requirement").then_some(Key::Joint(&["limits", "reflected_inertia"])),
        missing: |c| {
            let unknown = match (c.catalog_gear, c.joint.family_map()) {
                (Some(gear), _) => gear.inertia.is_none(),
                (None, map) => map.is_some_and(|map| !map.says(|row| row.inertia)),
            };
            unknown.then_some("the gear's inertia is not known: it is left out")
        },
        at_ratio: |_| None,
    },
    Need {
        name: "drag_heat",
        of: Of::Other,
        stated: always,
        key: by_temperature,
        missing: |_| None,
        at_ratio: |c| has_heat_of_drag(c).then_some(heat_of_drag as Judge),
    },
    Need {
        name: "objective_mass",
        of: Of::Other,
        stated: |_, joint| joint.objective.weight(Quantity::Mass) > 0.0,
        key: |_| Some(Key::Joint(&["objective"])),
        missing: |c| if c.joint.objective.weight(Quantity::Mass) > 0.0 { no_mass(c) } else { None },
        at_ratio: |_| None,
    },
    Need {
        name: "mass_budget",
        of: Of::Other,
        stated: |robot, _| robot.budget.actuator_mass.is_some(),
        key: |_| Some(Key::Robot(&["budget", "actuator_mass"])),
        missing: |c| c.robot.budget.actuator_mass.and_then(|_| no_mass(c)),
        at_ratio: |_| None,
    },
    Need {
        name: "carried_mass",
        of: Of::Other,
        stated: |robot, joint| robot.carries(joint) || !joint.carries.is_empty(),
        key: by_nobody,
        missing: |c| if c.robot.carries(c.joint) { no_mass(c) } else { None },
        at_ratio: |_| None,
    },
];
