use std::path::PathBuf;

use clap::Args;

use super::progress::Telling;
use super::{Call, CatalogChoice, Done, Failure, Html, Output, Set};
use crate::actuator::metrics::METRICS;
use crate::design::options::Options;
use crate::design::sweep::sweep_with;
use crate::report::plot::sweep as plot;
use crate::report::sweep::{self as report, Order};
use crate::report::{html, json, table};
use crate::requirement::{Joint, Quantity, RatioChoice};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise sweep requirements/quadruped_mini_cheetah.toml\n  gearwise sweep robot.toml --ratios 100 --sort s_m --top 30\n  gearwise sweep robot.toml --html designs.html\n  gearwise sweep robot.toml --csv > designs.csv"
)]
pub struct Arguments {
    /// Requirement file (TOML); `-` is standard input
    requirement: PathBuf,
    /// How many ratios are tried, evenly spaced in ln N, where the ratio is continuous
    #[arg(long, default_value_t = 25, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    ratios: u32,
    /// Order: objective, margin, loss, reflected_inertia, peak_current, mass, or a metric (s_m, s_t, mass_s_m, …)
    #[arg(long, default_value = "objective", value_name = "BY")]
    sort: String,
    /// Weigh S_M or S_T by the motor's mass
    #[arg(long)]
    mass_weight: bool,
    /// How many designs of each joint the table shows
    #[arg(long, default_value_t = 10, value_name = "N")]
    top: usize,
    /// Only the first K gears of each motor, in the order that is asked for; by default all
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    gears_per_motor: Option<u32>,
    /// Show infeasible designs too, after the feasible ones
    #[arg(long)]
    infeasible: bool,
    /// Draw what is feasible, motor by motor, and the objective over the ratio: an .svg or .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    catalog: CatalogChoice,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    telling: Telling,
    #[command(flatten)]
    output: Output,
}

fn order(name: &str) -> Result<Order, Failure> {
    match name {
        "objective" => return Ok(Order::Objective),
        "margin" => return Ok(Order::Margin),
        _ => {}
    }
    // A motor's mass is a metric too; in a sweep the design's mass is meant.
    if let Some((_, quantity)) = Quantity::NAMES.iter().find(|(n, _)| *n == name) {
        return Ok(Order::Quantity(*quantity));
    }
    METRICS.iter().find(|m| m.name == name).map(Order::Metric).ok_or_else(|| {
        let names = ["objective", "margin"]
            .into_iter()
            .chain(Quantity::NAMES.iter().map(|(n, _)| *n))
            .chain(METRICS.iter().map(|m| m.name));
        super::unknown_order(name, names)
    })
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    super::check_plot(arguments.plot.as_ref())?;
    let order = order(&super::metric_name(&arguments.sort, arguments.mass_weight)?)?;
    let robot = arguments.set.read(&arguments.requirement, Some("`sweep`"))?;
    let catalog = arguments.catalog.for_robot(&robot)?;
    let robot = super::settled(robot, &catalog)?;
    let mut robot = super::balanced(&robot, &catalog, false)?;
    let catalog = &*super::wound(&mut robot, &catalog, false)?;
    let geared = |joint: &Joint| matches!(joint.ratio, RatioChoice::Catalog { .. });
    if arguments.gears_per_motor.is_some() && !robot.joints.iter().any(geared) {
        let why = "`--gears-per-motor`: no joint of the requirement takes gears of the catalogue";
        return Err(Failure::Argument(why.into()));
    }
    let work = arguments.telling.counted(robot.joints.len() * catalog.motors.len(), "sweeping");
    let options = Options { tick: &|| work.step(), ..Options::default() };
    let mut sweeps = sweep_with(&robot, catalog, arguments.ratios as usize, options)?;
    work.end();
    let mut left_out = 0;
    if let Some(most) = arguments.gears_per_motor {
        left_out =
            sweeps.iter_mut().filter(|s| geared(s.joint)).map(|s| report::first_gears(s, order, most as usize)).sum();
    }
    let fewer = match (left_out, arguments.gears_per_motor) {
        (1.., Some(most)) => {
            let line = format!("Only the first {most} of each motor's gears: {left_out} designs are left out.");
            format!("\n{}", table::paragraph(&line, 0, 2))
        }
        _ => String::new(),
    };
    super::draw_plot(arguments.plot.as_ref(), || plot::figure(&sweeps))?;
    arguments.html.write(
        call,
        || [robot.files(), catalog.files()].concat(),
        || html::sweep::page(&robot, &sweeps, order),
    )?;
    let satisfied = sweeps.iter().all(|s| s.designs.iter().any(|d| d.is_choice()));
    let text = arguments.output.choose(
        || {
            super::told_set(&robot)
                + &report::text(&robot, &sweeps, order, arguments.top, arguments.infeasible)
                + &fewer
        },
        || json::sweep::json(&robot, &sweeps, order),
        || report::csv(&sweeps, order),
    );
    Ok(Done { text, satisfied })
}
