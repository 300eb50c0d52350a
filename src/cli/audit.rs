use std::path::PathBuf;

use clap::Args;

use super::{Call, Done, Failure, Html, Output};
use crate::catalog::audit::audit;
use crate::report::audit as report;
use crate::report::html;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise audit\n  gearwise audit my_motors.csv\n\nExit status 1 if a row contradicts itself and its note does not say why."
)]
pub struct Arguments {
    /// Catalogue files or folders; the built-in catalogue if none is given
    catalog: Vec<PathBuf>,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    let catalog = super::catalog(&arguments.catalog)?;
    let findings = audit(&catalog);
    arguments.html.write(call, || catalog.files(), || html::audit::page(&catalog, &findings))?;
    let text = arguments.output.choose(
        || report::text(&catalog, &findings),
        || crate::report::json::motors::audited(&catalog, &findings),
        || report::csv(&findings),
    );
    Ok(Done { text, satisfied: report::broken(&findings) == 0 })
}
