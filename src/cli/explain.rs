use std::path::PathBuf;

use clap::Args;

use super::chosen::Chosen;
use super::{Call, CatalogChoice, Done, Failure, Html, Set};
use crate::design::explain::explain;
use crate::report::explain as report;
use crate::report::plot::design as plot;
use crate::report::{html, json};

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
    let named = std::iter::once(super::chosen::id(&arguments.design));
    let catalog = super::with_named(&robot, arguments.catalog.rows()?, named, arguments.catalog.complete());
    let robot = super::settled(robot, &catalog)?;
    let robot = super::balanced(&robot, &catalog, false)?;
    let joint = super::chosen::joint(&robot, arguments.joint.as_deref())?;
    let Chosen { motor, gear, ratio } = super::chosen::design(&arguments.design, joint, &catalog)?;
    let story = explain(&robot, joint, motor, gear, ratio).map_err(|why| {
        Failure::Argument(format!("{} cannot be explained at this joint: {}", motor.id, why.reason()))
    })?;
    super::draw_plot(arguments.plot.as_ref(), || plot::explained(&robot, &story))?;
    arguments.html.write(call, || [robot.files(), catalog.files()].concat(), || html::explain::page(&robot, &story))?;
    let text = if arguments.json {
        crate::report::json_text(&json::explain::json(&robot, &story))
    } else {
        super::told_set(&robot) + &report::text(&story)
    };
    Ok(Done { text, satisfied: story.is_choice() })
}
