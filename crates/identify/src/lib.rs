#![doc = include_str!("../README.md")]

pub mod answer;
pub mod bench;
#[cfg(test)]
#[path = "../../../tests/cases/mod.rs"]
pub(crate) mod cases;
pub mod characterize;
pub mod fitted;
pub mod identify;
pub mod read;
pub mod robot;
pub mod select;
pub mod signals;
pub mod simulate;

pub use bench::{Bench, BenchKind, Channel, Controller, Declared, KnownLoad, Log, Use};
