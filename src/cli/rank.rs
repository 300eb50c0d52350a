use std::path::PathBuf;

use clap::Args;

use super::{Call, Done, Failure, Html, Output};
use crate::ask::rank;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise rank\n  gearwise rank --sort mass_s_m --top 50\n  gearwise rank --html motors.html\n  gearwise rank my_motors.csv --tolerance 10%\n  gearwise rank --plot motors.svg --mark t-motor-ri50 --mark t-motor-u8"
)]
pub struct Arguments {
    /// Catalogue files or folders; the built-in catalogue if none is given
    catalog: Vec<PathBuf>,
    /// The metric that orders: s_m, s_t, mass_s_m, mass_s_t, k_m, k_t, k_t_per_mass, k_ts, gap_radius, …
    #[arg(long, default_value = "s_m", value_name = "METRIC")]
    sort: String,
    /// Weigh S_M or S_T by the motor's mass
    #[arg(long)]
    mass_weight: bool,
    /// Modules too whose rows have constants: by id or maker, `*` for any run of characters; their J has the gear in it. May be repeated
    #[arg(long, value_name = "PATTERN")]
    modules: Vec<String>,
    /// How many motors the table shows
    #[arg(long, default_value_t = 20, value_name = "N")]
    top: usize,
    /// Tolerance (±, 95 %) of every number whose row states none, e.g. 5%
    #[arg(long, value_name = "PERCENT")]
    tolerance: Option<String>,
    /// Draw rotor inertia over motor constant with lines of equal S_M, and over torque constant: an .svg or .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Motor to be marked in the picture, of --plot or --html; may be repeated
    #[arg(long, value_name = "ID")]
    mark: Vec<String>,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    let name = super::metric_name(&arguments.sort, arguments.mass_weight)?;
    let by = rank::by(&name).map_err(|why| Failure::Argument(format!("`--sort`: {why}")))?;
    let tolerance = super::tolerance(arguments.tolerance.as_deref())?;
    arguments.html.check()?;
    super::check_plot(arguments.plot.as_ref())?;
    let ranked = rank::rank(super::catalog(&arguments.catalog)?, by, &arguments.modules, tolerance, &arguments.mark)?;
    super::draw_plot(arguments.plot.as_ref(), &ranked)?;
    arguments.html.write_page(call, &ranked)?;
    Ok(arguments.output.done(&ranked, || ranked.text_of(arguments.top)))
}
