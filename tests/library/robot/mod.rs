//! Whole robots: joints that share a bus, a mass, a mechanism.

mod robot_enumeration;
mod sag;
