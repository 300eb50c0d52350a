//! One log file: which format it has, and the rows that each log takes of it.
//!
//! The one idea: whatever the format, a log is gathered row by row by the same rules ([`gather`]); a format only says what
//! stands in a row ([`record`]), and where.

mod arrays;
mod bag;
mod format;
mod gather;
mod lines;
mod npy;
mod npz;
#[cfg(feature = "parquet")]
mod parquet;
mod record;
mod wanted;

use std::path::Path;
use std::sync::Arc;

use self::format::Format;
pub use self::wanted::{Condition, Rows, Wanted};
use gearwise_model::input::{InputError, Opened, Problem, Source, limits};

/// Whether a file can be opened at all.
///
/// # Errors
/// Why not, and what stands beside it.
pub(crate) fn probe(path: &Path) -> Result<(), (String, Option<String>)> {
    match Opened::new(path, limits::LOG_BYTES) {
        Ok(_) => Ok(()),
        // The message of a file that is not there, with its neighbour.
        Err(_) if !path.exists() => {
            let first = Source::read(path).err().and_then(|e| e.problems.into_iter().next());
            Err(first.map_or_else(|| ("cannot read the file".into(), None), |p| (p.message, p.help)))
        }
        Err(problem) => Err((problem.message, problem.help)),
    }
}

/// Reads the logs that come from one file, which messages call by a name. What is wrong with the bench file (a column that is not there, a selection
/// without rows) goes to `note`.
///
/// # Errors
/// What is wrong with the log file.
pub fn read(
    (path, name): (&Path, &str),
    wanted: &[Wanted],
    note: &mut dyn FnMut(Problem),
) -> Result<Option<(String, Vec<Rows>)>, InputError> {
    let wrong = |problem: Problem| InputError { source: Arc::new(Source::new(name, "")), problems: vec![problem] };
    let mut opened = Opened::new(path, limits::LOG_BYTES).map_err(wrong)?;
    match Format::of(path, &mut opened.file).map_err(wrong)? {
        Format::Lines => lines::read((path, name), opened, wanted, note),
        Format::Arrays(reader) => arrays::read((path, name), opened, reader, wanted, note),
    }
}
