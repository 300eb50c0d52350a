//! How fast a motor may turn: what the voltage allows, and what its row does.

use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::numerics::laurent::Laurent;
use crate::requirement::Turns;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "voltage",
        unit: "V",
        formula: "max √(v_q² + v_d²) ≤ V, with R of the hottest winding allowed; where the field may be weakened the least that i_d makes of it; with a resistance of the supply the open-circuit voltage that this takes",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Voltage,
        stated: the_supply,
        key: |_| Some(Key::Robot(&["bus", "voltage"])),
        prepare: |c| match c.joint.turns {
            Turns::Any => Prepared::NotAsked,
            Turns::AsWound | Turns::UpTo(_) => voltage(c, "voltage", Demand::Samples),
        },
    },
    Limit {
        name: "open_circuit_voltage",
        unit: "V",
        formula: "√2 K_B N max |ω| ≤ V_max: between two phases at the top speed, when the drive lets go (of a brushed motor K_B N max |ω|)",
        safety: false,
        of: Of::Other,
        class: Class::UpperBound,
        depends: Depends::BackEmf,
        stated: |robot, _| robot.bus.max_voltage.is_some(),
        key: |_| Some(Key::Robot(&["bus", "max_voltage"])),
        prepare: |c| match c.robot.bus.max_voltage {
            Some(_) if c.joint.turns == Turns::Any => Prepared::NotAsked,
            Some(bound) => {
                let (speed, sample) = c.load.peak_speed;
                let demand = Laurent::monomial(c.open_circuit_per_speed() * speed, 1);
                plain(Demand::Polynomial(demand, Some(sample)), 1.0, bound, "bus")
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "max_speed",
        unit: "rad/s",
        formula: "N max |ω| ≤ ω_max",
        safety: false,
        of: Of::Other,
        class: Class::UpperBound,
        depends: Depends::Rating,
        stated: by_data_sheets,
        key: by_nobody,
        prepare: |c| match c.motor.max_speed {
            Some(bound) => {
                let (speed, sample) = c.load.peak_speed;
                plain(Demand::Polynomial(Laurent::monomial(speed, 1), Some(sample)), 1.0, bound, "motor")
            }
            None => match c.motor.sheet.no_load_speed {
                Some(_) if exceeds_no_load_speed(c) => Prepared::Unknown(
                    "the motor's maximum speed is not known, and it may turn faster than its printed no-load speed",
                ),
                None if exceeds_rated_voltage(c) => {
                    Prepared::Unknown("neither the motor's maximum speed nor its no-load speed is known")
                }
                _ => Prepared::NotAsked,
            },
        },
    },
];

/// True if the motor may turn faster than the no-load speed that its row prints: at the largest ratio that is open, and no faster than the
/// bus voltage drives it. Up to that speed its maker runs it.
fn exceeds_no_load_speed(candidate: &Candidate) -> bool {
    let sheet = &candidate.motor.sheet;
    let Some(known) = sheet.no_load_speed else { return false };
    let own = candidate.catalog_gear.map(|gear| gear.ratio);
    let most = own.or_else(|| candidate.joint.ratio.range().map(|(_, most)| most)).unwrap_or(f64::INFINITY);
    let asked = most * candidate.load.peak_speed.0;
    asked > known.value && exceeds_rated_voltage(candidate)
}

/// True if the bus has more than the voltage that the motor's row prints, or the row prints none.
fn exceeds_rated_voltage(candidate: &Candidate) -> bool {
    let rated = candidate.motor.sheet.voltage;
    rated.is_none_or(|rated| candidate.robot.bus.voltage > rated.value * (1.0 + 1e-9))
}
