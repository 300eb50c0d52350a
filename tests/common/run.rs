//! The program, run as its users run it.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use super::repository;

/// The program with arguments, in the folder of the repository, not at a terminal.
pub fn gearwise(arguments: &[&str]) -> Output {
    gearwise_in(&repository(""), arguments)
}

/// The same in another folder.
pub fn gearwise_in(folder: &Path, arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_gearwise"));
    program.env_remove("COLUMNS").args(arguments).current_dir(folder).output().expect("the program starts")
}

/// What it printed.
pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// What it said of errors and progress.
pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Its answer.
pub fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", stderr(output)))
}
