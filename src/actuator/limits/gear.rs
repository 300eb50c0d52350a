//! What a gear may carry.

use super::limit::*;
use crate::numerics::laurent::Laurent;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "gear_input_speed",
        unit: "rad/s",
        formula: "N max |ω| ≤ ω_gear",
        safety: false,
        of: Of::Gear,
        class: Class::UpperBound,
        depends: Depends::Rating,
        stated: |_, joint| described(joint, joint.gear.max_input_speed),
        key: |_| Some(Key::Joint(&["gear", "max_input_speed"])),
        prepare: |c| match c.gear.max_input_speed {
            Some(bound) => {
                let (speed, sample) = c.load.peak_speed;
                plain(Demand::Polynomial(Laurent::monomial(speed, 1), Some(sample)), 1.0, bound, "gear")
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_peak_torque",
        unit: "N*m",
        formula: "safety · max |τ| ≤ τ_gear peak",
        safety: true,
        of: Of::Gear,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| described(joint, joint.gear.peak_torque),
        key: |_| Some(Key::Joint(&["gear", "peak_torque"])),
        prepare: |c| match c.gear.peak_torque {
            Some(bound) => {
                let (torque, sample) = c.load.peak_torque;
                plain(Demand::Fixed(torque, Some(sample)), c.joint.limits.safety, bound, "gear")
            }
            None if c.catalog_gear.is_some() => Prepared::Unknown("the gear's peak torque is not known"),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_continuous_torque",
        unit: "N*m",
        formula: "√mean(τ²) ≤ τ_gear continuous",
        safety: false,
        of: Of::Gear,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| described(joint, joint.gear.continuous_torque),
        key: |_| Some(Key::Joint(&["gear", "continuous_torque"])),
        prepare: |c| match c.gear.continuous_torque {
            Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            Some(bound) => plain(Demand::Fixed(c.load.rms_torque, None), 1.0, bound, "gear"),
            None if c.catalog_gear.is_some() => Prepared::Unknown("the gear's continuous torque is not known"),
            None => Prepared::NotAsked,
        },
    },
];
