//! What motor and drive may carry: currents and torques.

use super::limit::*;
use crate::actuator::waveform::Functional;

/// What a drive gives for ever.
pub const DRIVE_CONTINUOUS_CURRENT: &str = "drive_continuous_current";

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "peak_current",
        unit: "A",
        formula: "safety · max √((T/K_T)² + i_d²) ≤ I_peak",
        safety: true,
        of: Of::QAxis,
        class: Class::Convex,
        depends: Depends::Current,
        stated: |robot, joint| joint.drive_current.or(robot.bus.drive_current).is_some(),
        key: by_drive,
        prepare: |c| match c.peak_current() {
            Some((bound, owner)) => peak(c, Demand::Samples(c.load.waveform.of_current()), bound, owner),
            None if c.drive_current().is_some() => Prepared::NotAsked,
            None => Prepared::Unknown("neither motor nor drive says a largest current"),
        },
    },
    Limit {
        name: "peak_torque",
        unit: "N*m",
        formula: "safety · max |T| ≤ T_peak, and no more than the saturated iron gives at any current",
        safety: true,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Torque,
        stated: by_data_sheets,
        key: by_nobody,
        prepare: |c| match c.motor.peak_torque.into_iter().chain(c.actuator.shortfall.largest_torque()).reduce(f64::min)
        {
            Some(bound) => {
                let safety = c.joint.limits.safety;
                let bound = c.actuator.shortfall.left_of_torque(bound, safety);
                torque(Demand::Samples(Functional::TorqueSquared), safety, bound, "motor")
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "continuous_current",
        unit: "A",
        formula: "√mean(T²)/K_T ≤ I_continuous",
        safety: false,
        of: Of::QAxis,
        class: Class::Convex,
        depends: Depends::Current,
        stated: always,
        key: by_nobody,
        prepare: |c| match c.continuous_current() {
            // Heat without durations is looked at over the motion, as of the hottest point for ever.
            Some(bound) if c.load.has_steady_heat => heating(c, 0.0, bound, "motor"),
            _ => Prepared::NotAsked,
        },
    },
    Limit {
        name: DRIVE_CONTINUOUS_CURRENT,
        unit: "A",
        formula: "√mean(T²)/K_T ≤ I_drive continuous",
        safety: false,
        of: Of::QAxis,
        class: Class::Convex,
        depends: Depends::Current,
        stated: |robot, joint| joint.drive.or(robot.bus.drive).continuous_current.is_some(),
        key: |_| Some(Key::Robot(&["bus", "drive_continuous_current"])),
        prepare: |c| match c.drive_continuous_current().zip(c.joint.turns.of_current()) {
            None => Prepared::NotAsked,
            Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            Some((bound, times)) => heating(c, 0.0, bound * times, "drive"),
        },
    },
    Limit {
        name: "continuous_torque",
        unit: "N*m",
        formula: "√mean(T²) ≤ T_continuous",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Torque,
        stated: always,
        key: by_nobody,
        prepare: |c| match c.continuous_torque() {
            Some(bound) if c.load.has_steady_heat => {
                let mean = c.load.mean_torque_squared(&c.actuator) * c.load.share_of_time;
                torque(Demand::Polynomial(mean, None), 1.0, bound, "motor")
            }
            _ => Prepared::NotAsked,
        },
    },
];
