//! The model simulated forward in time: what position it predicts from what was put in.
//!
//! The one idea: one machine and one step in time serve three questions. How far is the simulated from the
//! measured position, before and after identification ([`forward_check`])? Which parameters make that
//! error least ([`least_squares`](gearwise_model::numerics::least_squares))? And, where a servo's logs have no current and no torque, which effect does
//! the model lack ([`identify_servo`])? Effects are those of the library; what jumps with the direction of
//! motion is a force with a set of values at standstill, so that a machine can stick.

mod check;
mod machine;
mod model;
mod servo;
mod track;

pub use check::{Errors, ForwardCheck, forward_check};
pub use machine::{Machine, Sample, State, Term};
pub use servo::{identify_servo, lacks_supply, serves};
pub use track::{Input, Track};
