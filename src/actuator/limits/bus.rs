//! What the supply gives and takes back.

use super::limit::*;
use crate::actuator::waveform::Functional;
use crate::requirement::Regeneration;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "bus_power",
        unit: "W",
        formula: "max (R i² + K_B N ω i)/η_d ≤ P − P_standby, with R of the hottest winding and that of drive and leads",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Power,
        stated: |robot, _| robot.bus.power.is_some(),
        key: |_| Some(Key::Robot(&["bus", "power"])),
        prepare: |c| match c.robot.bus.power {
            Some(bound) => power(1.0 / c.robot.bus.drive_efficiency, bound - c.standby_power()),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "bus_current",
        unit: "A",
        formula: "max (R i² + K_B N ω i)/(η_d V_bus) ≤ I_bus − P_standby/V_bus, with R of the hottest winding and that of drive and leads",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Power,
        stated: |robot, _| robot.bus.current.is_some(),
        key: |_| Some(Key::Robot(&["bus", "current"])),
        prepare: |c| match c.robot.bus.current {
            Some(bound) => {
                let voltage = c.robot.bus.voltage;
                power(1.0 / (c.robot.bus.drive_efficiency * voltage), bound - c.standby_power() / voltage)
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "regeneration",
        unit: "W",
        formula: "max −η_d (R i² + K_B N ω i) ≤ P_regeneration, with R at its reference temperature",
        safety: false,
        of: Of::Other,
        class: Class::ReverseConvex,
        depends: Depends::PowerBack,
        stated: |robot, _| robot.bus.regeneration != Regeneration::Allowed,
        key: |_| Some(Key::Robot(&["bus", "regeneration"])),
        prepare: |c| match c.robot.bus.regeneration {
            Regeneration::Allowed => Prepared::NotAsked,
            Regeneration::Limited(bound) => {
                plain(Demand::Samples(Functional::PowerBack), c.robot.bus.drive_efficiency, bound, "bus")
            }
        },
    },
];

/// The largest power that a joint draws, by a factor to the unit of the bound.
fn power(factor: f64, bound: f64) -> Prepared {
    plain(Demand::Samples(Functional::Power), factor, bound, "bus")
}
