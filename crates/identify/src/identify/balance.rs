//! One equation of the actuator, made of logs: target, the terms that the declared model has, and the
//! operating points that further effects are functions of.
//!
//! The one idea: whatever the bench, the equation reads `target = Σ known parameter · column + Σ effect`,
//! each term through the same filter. What differs between benches is only which channel is the target
//! and which sign an effect has: a torque sensor sees friction as missing, a drive that moves a known load
//! as needed.

mod columns;
mod equation;
mod grid;
mod layout;
mod model;
mod motion;
mod stretch;
mod targets;
mod visible;

pub use equation::{Balance, Setting};
pub use model::Weight;
pub use stretch::Corrections;
pub use targets::targets;
pub use visible::{applies, visible};

#[cfg(test)]
mod tests;
