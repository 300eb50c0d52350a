use std::path::PathBuf;

use clap::Args;

use super::{CatalogChoice, Done, Failure, Output};
use crate::design::optimize::{Options, optimize_with};
use crate::report::optimize as report;
use crate::requirement;

/// Examples:
///   gearwise optimize requirements/quadruped_mini_cheetah.toml
///   gearwise optimize robot.toml --top 20 --rejected
///   gearwise optimize robot.toml --json | jq '.joints[].candidates[0].motor'
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Requirement file (TOML)
    requirement: PathBuf,
    /// How many motors of each joint the table shows
    #[arg(long, default_value_t = 5, value_name = "N")]
    top: usize,
    /// List every rejected motor with its reason
    #[arg(long)]
    rejected: bool,
    /// Leave out motors whose rows do not say enough to check every limit
    #[arg(long)]
    only_checked: bool,
    #[command(flatten)]
    catalog: CatalogChoice,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let robot = requirement::read(&arguments.requirement)?;
    let catalog = super::motors(&arguments.catalog.catalog)?;
    let bar = super::progress(robot.joints.len() * catalog.motors.len(), "optimising");
    let options = Options { only_checked: arguments.only_checked, tick: &|| bar.inc(1) };
    let result = optimize_with(&robot, &catalog, options);
    bar.finish_and_clear();
    let shown = report::Shown { top: arguments.top, rejected: arguments.rejected };
    let text =
        arguments.output.choose(|| report::text(&result, shown), || report::json(&result), || report::csv(&result));
    Ok(Done { text, satisfied: result.satisfied() })
}
