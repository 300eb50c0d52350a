use std::path::PathBuf;

use clap::Args;

use super::{Done, Failure, Output};
use crate::measured::{identify, read};
use crate::report::identify as report;
use crate::units;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Structure that no known effect explains is an answer, not a failure: exit status 0.\n\nExamples:\n  gearwise identify requirements/bench/leg_actuator.toml\n  gearwise identify bench.toml --plot residual.svg --write fitted.toml\n  gearwise identify bench.toml --band \"40 Hz\" --json"
)]
pub struct Arguments {
    /// Bench file (TOML)
    bench: PathBuf,
    /// Cut-off of the filter that everything goes through; chosen from the data if not given
    #[arg(long, value_name = "FREQUENCY")]
    band: Option<String>,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let band = match &arguments.band {
        None => None,
        Some(text) => Some(read_band(text)?),
    };
    let bench = read::read(&arguments.bench)?;
    let reports = identify::identify(&bench, &identify::Options { band })
        .map_err(|why| Failure::Argument(format!("{}: {why}", arguments.bench.display())))?;
    let text = arguments.output.choose(
        || report::text(&bench, &reports, &[]),
        || report::json(&bench, &reports),
        || report::csv(&bench, &reports),
    );
    Ok(Done { text, satisfied: true })
}

fn read_band(text: &str) -> Result<f64, Failure> {
    match units::quantity(text, &units::FREQUENCY) {
        Ok(band) if band > 0.0 => Ok(band),
        Ok(_) => Err(Failure::Argument(format!("`--band {text}` must be greater than zero"))),
        Err(error) => Err(Failure::Argument(format!(
            "`--band {text}`: {}; {}",
            error.message(&units::FREQUENCY),
            error.help(&units::FREQUENCY)
        ))),
    }
}
