//! The list of rules. A new one is one item in a file here and one line in [`RULES`].

mod limits;
mod practice;
mod robot;
mod rows;

use super::rule::Rule;

pub use robot::{SELECTS_NOTHING, UNUSED_ALLOW};

/// Every rule, in the order of their codes.
pub const RULES: &[&Rule] = &[
    &limits::PEAK_CURRENT,
    &limits::PEAK_TORQUE,
    &limits::CONTINUOUS_CURRENT,
    &limits::CONTINUOUS_TORQUE,
    &limits::WINDING_TEMPERATURE,
    &limits::WINDING_PEAK_TEMPERATURE,
    &limits::STANDSTILL_HOLDING,
    &limits::VOLTAGE,
    &limits::MAX_SPEED,
    &limits::GEAR_INPUT_SPEED,
    &limits::GEAR_PEAK_TORQUE,
    &limits::GEAR_CONTINUOUS_TORQUE,
    &limits::REFLECTED_INERTIA,
    &limits::TORQUE_BANDWIDTH_CURRENT,
    &limits::TORQUE_BANDWIDTH_VOLTAGE,
    &limits::BUS_POWER,
    &limits::BUS_CURRENT,
    &limits::REGENERATION,
    &limits::ACTUATOR_MASS,
    &limits::NOT_EVALUATED,
    &limits::UNCHECKED_LIMIT,
    &limits::FRICTION_UNKNOWN,
    &robot::MASS_BUDGET,
    &robot::DISTINCT_MOTORS,
    &rows::GEAR_FIT,
    &robot::POWER_BUDGET,
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

/// The rule of a code or name.
pub fn rule(code_or_name: &str) -> Option<&'static Rule> {
    RULES.iter().copied().find(|r| r.code.eq_ignore_ascii_case(code_or_name) || r.name == code_or_name)
}
