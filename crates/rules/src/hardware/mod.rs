//! What is bought for the joints of a robot model, and what it can do there.
//!
//! The one idea: a number that hardware has at a joint is a [`Fact`]: it knows the row that it comes from, that row's source,
//! and how it was taken through gear and transmission. What no row says is `None`, and whoever asks for it says so.

mod file;
mod joint;

pub use file::{Coupling, HardwareFile, Mount, Tolerances, Turns, Which, describe, read};
pub use joint::{Fact, Hardware, Holds, of};
