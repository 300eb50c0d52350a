//! What the requirement asks of a joint beyond its motion.

use super::limit::*;
use crate::requirement::Turns;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "reflected_inertia",
        unit: "kg*m^2",
        formula: "N² (J_m + J_g) ≤ J, behind a transmission max r² (N² (J_m + J_g) + J_t) + J_j",
        safety: false,
        of: Of::Other,
        class: Class::UpperBound,
        depends: Depends::Inertia,
        stated: |_, joint| joint.limits.reflected_inertia.is_some(),
        key: |_| Some(Key::Joint(&["limits", "reflected_inertia"])),
        prepare: |c| match c.joint.limits.reflected_inertia {
            Some(bound) => plain(Demand::Polynomial(c.reflected_inertia(), None), 1.0, bound, "requirement"),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "torque_bandwidth_current",
        unit: "A",
        formula: "safety · max |T + superposed|/K_T ≤ I_peak, at 32 phases",
        safety: true,
        of: Of::QAxis,
        class: Class::Convex,
        depends: Depends::Current,
        stated: |_, joint| joint.limits.torque_bandwidth.is_some(),
        key: |owner| by_drive(owner).or(Some(Key::Joint(&["limits", "torque_bandwidth"]))),
        prepare: |c| match (&c.load.bandwidth, c.peak_current()) {
            (None, _) => Prepared::NotAsked,
            (_, None) if c.joint.turns == Turns::Any => Prepared::NotAsked,
            (Some(_), Some((bound, owner))) => peak(c, Demand::Bandwidth(c.load.waveform.of_current()), bound, owner),
            (Some(_), None) => Prepared::Unknown("neither motor nor drive says a largest current"),
        },
    },
    Limit {
        name: "torque_bandwidth_voltage",
        unit: "V",
        formula: "max √(v_q² + v_d²) ≤ V with the superposed torque, at 32 phases and R of the hottest winding",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Voltage,
        stated: |_, joint| joint.limits.torque_bandwidth.is_some(),
        key: |_| Some(Key::Joint(&["limits", "torque_bandwidth"])),
        prepare: |c| match (&c.load.bandwidth, c.motor.inductance) {
            (None, _) => Prepared::NotAsked,
            _ if c.joint.turns == Turns::Any => Prepared::NotAsked,
            (Some(_), Some(_)) => voltage(c, "torque_bandwidth_voltage", Demand::Bandwidth),
            (Some(_), None) => Prepared::Unknown("the motor's inductance is not known"),
        },
    },
];
