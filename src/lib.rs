//! Gearwise chooses the motor and the gear ratio of a robot joint and proves the choice.

pub mod actuator;
pub mod catalog;
pub mod input;
pub mod report;
pub mod requirement;
pub mod units;

