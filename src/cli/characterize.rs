use std::path::PathBuf;

use clap::Args;

use super::{Call, CatalogPaths, Done, Failure, Html, Output};
use crate::ask::characterize::characterize;
use crate::measured::read;
use crate::output;
use crate::report::characterize as report;
use crate::report::plot::Format;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise characterize requirements/bench/motor_on_bench.toml\n  gearwise characterize bench.toml --write my_motor.csv --plot bench.svg\n  gearwise audit my_motor.csv\n  gearwise optimize robot.toml --catalog my_motor.csv\n\nExit status 1 if a row was to be written and is not complete."
)]
pub struct Arguments {
    /// Bench file (TOML): [motor], [terminals], [rotor] and the logs of stall, backdrive, random_torque, drag, thermal_step
    bench: PathBuf,
    /// Write the catalogue row, whole or not at all
    #[arg(long, value_name = "FILE.csv")]
    write: Option<PathBuf>,
    /// Draw torque on current, gain and coherence, drag and temperature with their fits
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    catalog: CatalogPaths,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    if let Some(path) = &arguments.plot {
        Format::of(path).map_err(Failure::Argument)?;
    }
    if let Some(path) = &arguments.write
        && path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("csv"))
    {
        return Err(Failure::Argument(format!("`--write {}`: a catalogue's name ends in .csv", path.display())));
    }
    let catalog = match arguments.catalog.catalog.as_slice() {
        [] => None,
        paths => Some(super::catalog(paths)?),
    };
    let bench = read::read_for_row(&arguments.bench, catalog, read::Logs::new())?;
    super::check_outputs(arguments.plot.iter().chain(&arguments.html.html).chain(&arguments.write))?;
    let answer = characterize(bench)?;
    let mut written = Vec::new();
    let mut satisfied = true;
    if let Some(path) = &arguments.plot {
        super::draw_plot(Some(path), &answer)?;
        written.push(format!("The tests are drawn in {}.", path.display()));
    }
    arguments.html.write_page(call, &answer)?;
    if let Some(path) = &arguments.write {
        match report::row_csv(&answer.result.row) {
            Ok(text) => {
                output::write_whole(path, text.as_bytes()).map_err(Failure::Argument)?;
                written.push(format!("The row is in {}.", path.display()));
            }
            Err(why) => {
                tell!("warning: {why}");
                satisfied = false;
            }
        }
    }
    let done = arguments.output.done(&answer, || answer.text_of(&written));
    Ok(Done { satisfied, ..done })
}
