use clap::Args;

use super::{Done, Failure};
use crate::catalog::{Catalog, user_catalog};
use crate::report::catalog::path::{self as report, Places, User};
use crate::report::{json, json_text};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(before_help = "Examples:\n  gearwise catalog path\n  gearwise catalog path --json")]
pub struct Arguments {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let rows = |catalog: &Catalog| [catalog.motors.len(), catalog.gears.len(), catalog.modules.len()];
    let builtin = Catalog::builtin()?;
    let user = user_catalog();
    let found = match user.exists() {
        false => User::Absent,
        true => match Catalog::read(std::slice::from_ref(&user)) {
            Ok(catalog) => User::Read(rows(&catalog)),
            Err(errors) => User::Wrong(errors.iter().map(|e| e.problems.len()).sum()),
        },
    };
    let places = Places {
        user,
        by_variable: std::env::var_os("GEARWISE_CATALOG").is_some_and(|value| !value.is_empty()),
        found,
        builtin: rows(&builtin),
        files: Catalog::builtin_sources().len(),
        sha256: builtin.files().first().map(|file| file.sha256.clone()).unwrap_or_default(),
    };
    let text = if arguments.json { json_text(&json::catalog::paths(&places)) } else { report::text(&places) };
    Ok(Done { text, satisfied: true })
}
