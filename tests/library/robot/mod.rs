//! Whole robots: joints that share a bus, a mass, a mechanism.

mod carrying;
mod effort;
mod robot_enumeration;
mod sag;
