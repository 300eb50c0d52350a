//! Whole robots: joints that share a bus, a mass, a mechanism.

mod mechanism;
mod robots;
mod separate_actuators;
