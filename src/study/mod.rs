//! Many robots in one go: every requirement of a list, at every point of a grid of parameters.
//!
//! The one idea of this room: a study is a numbered list of robots, and what is found for a robot depends
//! on its number alone. So robots may be worked on in any order, by any number of threads and machines
//! ([`run`](mod@run)), each finished one is a line in a [`journal`] that outlives whatever happens to the
//! process, and the results are [assembled](mod@assemble) from the journal in the order of the numbers: the
//! same bytes, however they came about. Robots are worked on in blocks, so that nothing grows with
//! their number.

pub mod answer;
pub mod asked;
pub mod assemble;
pub mod columns;
pub mod effects;
pub mod file;
pub mod grid;
pub mod journal;
pub mod output;
pub mod page;
#[cfg(feature = "parquet")]
mod parquet;
pub mod plan;
pub mod plot;
pub mod run;
pub mod summary;
pub mod text;
pub mod work;
pub mod worker;

use std::path::Path;

use crate::ask::Failure;
use crate::input::InputError;

pub use plan::{Plan, Settings, Shard};
pub use summary::Summary;

/// Why a study could not do its work.
#[derive(Debug)]
pub enum StudyError {
    /// Mistakes in input files.
    Input(Vec<InputError>),
    /// What was asked cannot be done, in words.
    Argument(String),
    /// The study was stopped; what is finished is kept.
    Stopped {
        /// Robots that are finished.
        done: u64,
        /// Robots that were to be done.
        of: u64,
    },
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Failure {
        match error {
            StudyError::Input(errors) => Failure::Input(errors),
            StudyError::Argument(message) => Failure::Argument(message),
            StudyError::Stopped { done, of } => Failure::Interrupted(format!(
                "stopped: {done} of {of} robots are finished and kept; the same command with `--resume` goes on"
            )),
        }
    }
}

impl From<Vec<InputError>> for StudyError {
    fn from(errors: Vec<InputError>) -> StudyError {
        StudyError::Input(errors)
    }
}

impl StudyError {
    /// A file that could not be written or read.
    pub fn file(what: &str, path: &Path, error: &std::io::Error) -> StudyError {
        StudyError::Argument(format!("cannot {what} `{}`: {}", path.display(), crate::words::reason(error)))
    }
}
