use std::path::PathBuf;

use clap::Args;

use super::{Call, CatalogChoice, Done, Failure, Html, Set};
use crate::ask::explain::explain;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise explain t-motor-ri50 requirements/quadruped_mini_cheetah.toml --joint knee\n  gearwise explain t-motor-ri50@9 requirements/quadruped_mini_cheetah.toml --joint hip\n  gearwise explain tq-robodrive-ilm-85x26@planetary-apex-af042-20 robot.toml\n\nExit status 1 if the design is not feasible, or a limit that the requirement states cannot be judged."
)]
pub struct Arguments {
    /// Motor id, with `@RATIO` or `@GEAR` for a certain design; else the best ratio
    design: String,
    /// Requirement file (TOML); `-` is standard input
    requirement: PathBuf,
    /// Joint; may be left out where the requirement has only one
    #[arg(long, value_name = "NAME")]
    joint: Option<String>,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    catalog: CatalogChoice,
    /// Draw the design: torque over speed, temperature, objective and limits over the ratio: an .svg or .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    html: Html,
    /// Print JSON (SI units, the unit in the key)
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    super::check_plot(arguments.plot.as_ref())?;
    let robot = arguments.set.read(&arguments.requirement, None)?;
    let explained = explain(robot, &arguments.catalog.rows()?, &arguments.design, arguments.joint.as_deref())?;
    super::draw_plot(arguments.plot.as_ref(), &explained)?;
    arguments.html.write_page(call, &explained)?;
    Ok(Done::of(&explained, arguments.json))
}
