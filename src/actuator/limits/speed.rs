//! How fast a motor may turn: what the voltage allows, and what its row does.

use super::limit::*;
use crate::numerics::laurent::Laurent;
use crate::requirement::Turns;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "voltage",
        unit: "V",
        formula: "max √(v_q² + v_d²) ≤ V, with R of the hottest winding allowed; with a resistance of the supply the open-circuit voltage that this takes",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Voltage,
        stated: the_supply,
        key: |_| Some(Key::Robot(&["bus", "voltage"])),
        prepare: |c| match c.joint.turns {
            Turns::AsWound => voltage(c, "voltage", Demand::Samples),
            Turns::Any => Prepared::NotAsked,
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
            None => Prepared::NotAsked,
        },
    },
];
