//! The list of rules. A new one is one item in a file here and one line in [`OTHERS`]; that of a limit is a row in
//! [`limits`] alone.

mod limits;
mod models;
mod practice;
mod robot;
mod rows;

use super::rule::Rule;

pub use models::between::SAME_LIMITS;
pub use robot::{SELECTS_NOTHING, UNUSED_ALLOW};

/// Every rule but those of the first limits, in the order of their codes.
const OTHERS: &[&Rule] = &[
    &limits::NOT_EVALUATED,
    &limits::UNCHECKED_LIMIT,
    &limits::FRICTION_UNKNOWN,
    &limits::UNJUDGED_LIMIT,
    &limits::OF_MORE_LIMITS[0],
    &limits::OF_MORE_LIMITS[1],
    &limits::OF_MORE_LIMITS[2],
    &limits::OF_PARTS[0],
    &limits::OF_PARTS[1],
    &robot::MASS_BUDGET,
    &robot::DISTINCT_MOTORS,
    &rows::GEAR_FIT,
    &robot::POWER_BUDGET,
    &robot::SUPPLY_SAG,
    &robot::REGENERATION_BUDGET,
    &limits::OF_MODULES[0],
    &limits::OF_MODULES[1],
    &limits::OF_MODULES[2],
    &limits::OF_MODULES[3],
    &limits::OF_TRANSMISSIONS[0],
    &limits::OF_TRANSMISSIONS[1],
    &limits::OF_TRANSMISSIONS[2],
    &practice::TORQUE_RESERVE,
    &practice::CURRENT_RESERVE,
    &practice::HEAT_RESERVE,
    &practice::SPEED_RESERVE,
    &practice::TEMPERATURE_RESERVE,
    &practice::VOLTAGE_HEADROOM,
    &practice::INERTIA_RATIO,
    &practice::BANDWIDTH_RESERVE,
    &practice::REVERSAL_TIME,
    &practice::GEAR_RATING_UNKNOWN,
    &practice::FAR_FROM_BEST,
    &rows::ROW_AUDIT,
    &rows::ROW_SECONDARY,
    &rows::LOCK_MISMATCH,
    &rows::LOCK_MISSING,
    &robot::UNUSED_ALLOW,
    &robot::SELECTS_NOTHING,
];

/// Every rule of designs, in the order of their codes: one for each limit of the model among them.
pub const RULES: &[&Rule] = &all();

const fn all() -> [&'static Rule; limits::OF_LIMITS.len() + OTHERS.len()] {
    let mut rules = [OTHERS[0]; limits::OF_LIMITS.len() + OTHERS.len()];
    let mut k = 0;
    while k < rules.len() {
        let limit = k < limits::OF_LIMITS.len();
        rules[k] = if limit { &limits::OF_LIMITS[k] } else { OTHERS[k - limits::OF_LIMITS.len()] };
        k += 1;
    }
    rules
}

/// Every rule of robot models, in the order of their codes.
pub const MODEL_RULES: &[&Rule] = &[
    &models::limits::EFFORT_ABOVE_PEAK,
    &models::limits::EFFORT_MEANING,
    &models::limits::VELOCITY_ABOVE_NO_LOAD,
    &models::limits::BOX,
    &models::inertia::ARMATURE_MISSING,
    &models::inertia::ARMATURE_DIFFERS,
    &models::inertia::FRICTION,
    &models::limits::GEAR,
    &models::between::SAME_LIMITS,
    &models::between::LEFT_RIGHT,
    &models::between::SCALED_COPY,
    &models::between::FILES_DISAGREE,
    &models::between::COUPLED,
    &models::inertia::LINK_MASS,
    &models::limits::SATURATION,
    &models::between::UNMATCHED,
];

/// The rules of designs, then those of robot models.
pub fn every_rule() -> impl Iterator<Item = &'static Rule> + Clone {
    RULES.iter().chain(MODEL_RULES).copied()
}

/// The rule of a code or name.
pub fn rule(code_or_name: &str) -> Option<&'static Rule> {
    every_rule().find(|r| r.code.eq_ignore_ascii_case(code_or_name) || r.name == code_or_name)
}
