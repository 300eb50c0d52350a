#![doc = include_str!("../README.md")]

pub mod actuator;
pub mod catalog;
pub mod effects;
pub mod input;
pub mod mechanism;
pub mod motion;
#[doc(hidden)]
pub mod numerics;
#[doc(hidden)]
pub mod output;
pub mod requirement;
pub mod transmission;
pub mod units;
#[doc(hidden)]
pub mod words;
