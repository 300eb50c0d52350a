//! What the supply gives and takes back.

use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::actuator::supply::Drawn;
use crate::actuator::waveform::Functional;

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
            Some(bound) => power(c, 1.0, bound - c.standby_power()),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "bus_current",
        unit: "A",
        formula: "max (R i² + K_B N ω i)/(η_d V_bus) ≤ I_bus − P_standby/V_bus, with R of the hottest winding and that of drive and leads; with a resistance R_s of the supply I_bus (1 − R_s I_bus/V_bus)",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Power,
        stated: |robot, _| robot.bus.current.is_some(),
        key: |_| Some(Key::Robot(&["bus", "current"])),
        prepare: |c| match c.robot.bus.current {
            Some(bound) => {
                let voltage = c.robot.bus.voltage;
                // Power at so much current, over the open-circuit voltage; no supply gives more than at half of that.
                let resistance = c.supply_resistance();
                let bound = if resistance > 0.0 { bound.min(voltage / (2.0 * resistance)) } else { bound };
                let bound = bound * (1.0 - resistance * bound / voltage);
                power(c, voltage, bound - c.standby_power() / voltage)
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "regeneration",
        unit: "W",
        formula: "max −η_d (R i² + K_B N ω i) ≤ P_regeneration + P_brake, with R at ambient temperature",
        safety: false,
        of: Of::Other,
        class: Class::ReverseConvex,
        depends: Depends::PowerBack,
        stated: |robot, _| robot.bus.takes_back().is_some(),
        key: |_| Some(Key::Robot(&["bus", "regeneration"])),
        prepare: |c| back(c, c.robot.bus.takes_back()),
    },
    Limit {
        name: "bus_overvoltage",
        unit: "W",
        formula: "max −η_d (R i² + K_B N ω i) ≤ V_max (V_max − V_bus)/R_s + P_brake, with a resistance R_s of the supply: more would lift the bus above V_max",
        safety: false,
        of: Of::Other,
        class: Class::ReverseConvex,
        depends: Depends::PowerBack,
        stated: |robot, _| robot.bus.max_voltage.is_some(),
        key: |_| Some(Key::Robot(&["bus", "max_voltage"])),
        prepare: |c| back(c, lifting(c)),
    },
];

/// A limit on the power that comes back \[W\].
fn back(candidate: &Candidate, bound: Option<f64>) -> Prepared {
    let efficiency = Drawn::new(&candidate.robot.bus).arrives();
    bound.map_or(Prepared::NotAsked, |bound| plain(Demand::Samples(Functional::PowerBack), efficiency, bound, "bus"))
}

/// Power that lifts the bus to its highest voltage, with that of a brake on top \[W\]; `None` where `regeneration` allows no more
/// than that, each less its reserve, or nothing reaches the supply.
fn lifting(c: &Candidate) -> Option<f64> {
    let (bus, resistance) = (&c.robot.bus, c.supply_resistance());
    let most = bus.max_voltage.filter(|_| resistance > 0.0)?;
    let of_brake = bus.brake_power.unwrap_or(0.0);
    let (lifted, comes_back) = (most * (most - bus.voltage) / resistance + of_brake, bus.goes_back() + of_brake);
    let limits = &c.joint.limits;
    let is_less = comes_back * limits.left_of("regeneration") <= lifted * limits.left_of("bus_overvoltage");
    (bus.goes_back() > 0.0 && !is_less).then_some(lifted)
}

/// The largest power that a joint draws, over `per` in the unit of the bound. A bound below zero, where standby alone takes more than there
/// is, asks for power returned at every instant: of that the drive passes on a share.
fn power(candidate: &Candidate, per: f64, bound: f64) -> Prepared {
    let efficiency = candidate.robot.bus.drive_efficiency;
    let reaches = if bound < 0.0 { Drawn::new(&candidate.robot.bus).arrives() } else { 1.0 / efficiency };
    plain(Demand::Samples(Functional::Power), reaches / per, bound, "bus")
}
