use std::path::PathBuf;

use clap::Args;

use super::{Done, Failure, Output};
use crate::catalog::difference::difference;
use crate::report::catalog::diff as report;
use crate::report::json;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise catalog diff builtin my_motors.csv\n  gearwise catalog diff my_motors.csv my_motors.csv\n\nExit status 0 if there is no difference, 1 if there is one, 2 if a catalogue cannot be read."
)]
pub struct Arguments {
    /// A catalogue file or folder, or the word `builtin` or `user`
    #[arg(value_name = "A")]
    before: PathBuf,
    /// Another one
    #[arg(value_name = "B")]
    after: PathBuf,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let read = |path: &PathBuf| super::super::catalog(std::slice::from_ref(path));
    let differences = difference(&read(&arguments.before)?, &read(&arguments.after)?);
    let text = arguments.output.choose(
        || report::text(&differences),
        || json::catalog::differ(&differences),
        || report::csv(&differences),
    );
    Ok(Done { text, satisfied: differences.is_empty() })
}
