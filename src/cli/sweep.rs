use std::path::PathBuf;

use clap::Args;

use super::progress::Telling;
use super::{Call, CatalogChoice, Done, Failure, Html, Output, Set};
use crate::ask::Watch;
use crate::ask::sweep::{self, Asked};

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

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    super::check_plot(arguments.plot.as_ref())?;
    let name = super::metric_name(&arguments.sort, arguments.mass_weight)?;
    let order = sweep::order(&name).map_err(|why| Failure::Argument(format!("`--sort`: {why}")))?;
    let robot = arguments.set.read(&arguments.requirement, Some("`sweep`"))?;
    let asked = Asked {
        ratios: arguments.ratios as usize,
        order,
        gears_per_motor: arguments.gears_per_motor.map(|most| most as usize),
    };
    let telling = arguments.telling;
    let watch = |steps| Watch { tick: telling.counted(steps, "sweeping").ticking(), ..Watch::default() };
    let swept = sweep::sweep(robot, &arguments.catalog.rows()?, asked, watch)?;
    super::draw_plot(arguments.plot.as_ref(), &swept)?;
    arguments.html.write_page(call, &swept)?;
    Ok(arguments.output.done(&swept, || swept.text_of(arguments.top, arguments.infeasible)))
}
