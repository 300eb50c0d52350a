use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::{Done, Failure, Output};
use crate::catalog::import::{IMPORTERS, files};
use crate::report::import::{self as report, Written};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise import mgdb ../MGDB --out my_catalog\n  gearwise import mgdb ../MGDB --out my_catalog --force --rows\n  gearwise optimize robot.toml --catalog my_catalog\n\nRows that cannot be taken, and everything that is assumed of the others, are listed: in the table by reason, with --rows, --json and --csv row by row."
)]
pub struct Arguments {
    /// Which database
    #[arg(value_parser = PossibleValuesParser::new(IMPORTERS.iter().map(|i| PossibleValue::new(i.name).help(i.about))))]
    database: String,
    /// The folder with the database's files
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// The folder for the catalogue files: they are put in motors and gears below it
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace catalogue files that are there already
    #[arg(long)]
    force: bool,
    /// List every row that something is assumed of
    #[arg(long)]
    rows: bool,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let importer = IMPORTERS.iter().find(|i| i.name == arguments.database);
    let importer = importer.ok_or_else(|| Failure::Argument(format!("`{}` is no importer", arguments.database)))?;
    let import = (importer.read)(&arguments.folder)?;
    let files = import.catalog_files()?;
    let paths = files::write(&arguments.out, &files, arguments.force).map_err(|e| Failure::Argument(e.to_string()))?;
    let written: Vec<Written> =
        paths.iter().zip(&files).map(|(path, file)| Written { path, rows: file.rows }).collect();
    let text = arguments.output.choose(
        || report::text(&import, &written, arguments.rows),
        || crate::report::json::import::json(&import, &written),
        || report::csv(&import),
    );
    Ok(Done { text, satisfied: true })
}
