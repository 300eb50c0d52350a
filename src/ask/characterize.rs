//! Raw bench logs of a motor as a catalogue row.

use serde_json::Value;

use super::{Answer, Failure};
use crate::input::InputFile;
use crate::measured::bench::Bench;
use crate::measured::characterize::{self, Characterization};
use crate::report::html::{self, Page};
use crate::report::plot::{Figure, characterize as plot};
use crate::report::{characterize as report, json};

/// A motor as its logs say it.
#[derive(Debug)]
pub struct Characterized {
    /// The bench.
    pub bench: Bench,
    /// The row.
    pub result: Characterization,
}

/// Characterizes.
///
/// # Errors
/// Why the logs make no row.
pub fn characterize(bench: Bench) -> Result<Characterized, Failure> {
    let result = characterize::characterize(&bench)
        .map_err(|why| Failure::Argument(format!("{}: {why}", bench.path.display())))?;
    Ok(Characterized { bench, result })
}

impl Characterized {
    /// The text, with where something was written.
    pub fn text_of(&self, written: &[String]) -> String {
        report::text(&self.bench, &self.result, written)
    }
}

impl Answer for Characterized {
    fn is_satisfied(&self) -> bool {
        true
    }

    fn json(&self) -> Value {
        json::characterize::json(&self.bench, &self.result)
    }

    fn csv(&self) -> String {
        report::csv(&self.result)
    }

    fn text(&self) -> String {
        self.text_of(&[])
    }

    fn page(&self) -> Page {
        html::characterize::page(&self.bench, &self.result)
    }

    fn figure(&self) -> Option<Figure> {
        Some(plot::figure(&self.bench, &self.result))
    }

    fn files(&self) -> Vec<InputFile> {
        self.bench.files.clone()
    }
}
