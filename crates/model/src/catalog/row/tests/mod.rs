//! Rows that are written and read back, and what is said of rows that cannot be read.

mod mistakes;
mod round;

use std::sync::Arc;

use crate::catalog::{Catalog, Gear, Motor};
use crate::input::{Problem, Source};

/// Reads a catalogue file.
fn read(name: &str, text: &str) -> Result<Catalog, Vec<Problem>> {
    Catalog::from_sources(vec![Arc::new(Source::new(name, text))])
        .map_err(|errors| errors.into_iter().flat_map(|error| error.problems).collect())
}

fn motors(name: &str, text: &str) -> Vec<Motor> {
    read(name, text).unwrap_or_else(|problems| panic!("{problems:?}\n{text}")).motors
}

fn gears(name: &str, text: &str) -> Vec<Gear> {
    read(name, text).unwrap_or_else(|problems| panic!("{problems:?}\n{text}")).gears
}
