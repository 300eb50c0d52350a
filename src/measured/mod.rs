//! Measured data: bench files and logs, and what they say about the declared model.
//!
//! The one idea: a log is brought to SI and canonical frames once, when it is read; what follows sees
//! arrays over time and a declared model, and never a file.

pub mod answer;
pub mod bench;
pub mod characterize;
pub mod fitted;
pub mod identify;
pub mod read;
pub mod robot;
pub mod select;
pub mod signals;
pub mod simulate;

pub use bench::{Bench, BenchKind, Channel, Controller, Declared, KnownLoad, Log, Use};
