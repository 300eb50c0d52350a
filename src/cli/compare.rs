use std::path::PathBuf;

use clap::Args;

use super::{Call, CatalogChoice, Done, Failure, Html};
use crate::ask::compare::compare;
use crate::units;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise compare t-motor-ri50 t-motor-u8\n  gearwise compare t-motor-ri50 t-motor-u8 --inertia \"0.02 kg*m^2\""
)]
pub struct Arguments {
    /// Id of the first motor
    a: String,
    /// Id of the second motor
    b: String,
    /// Actuator inertia at which they are compared; by default the larger rotor inertia
    #[arg(long, value_name = "J", allow_hyphen_values = true)]
    inertia: Option<String>,
    #[command(flatten)]
    catalog: CatalogChoice,
    /// Draw the responses to a voltage step: an .svg or .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    html: Html,
    /// Print JSON (SI units, the unit in the key)
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    let inertia = match &arguments.inertia {
        None => None,
        Some(text) => match units::quantity(text, &units::INERTIA) {
            Ok(value) if value > 0.0 => Some(value),
            Ok(_) => return Err(Failure::Argument(format!("`--inertia {text}` is not greater than zero"))),
            Err(error) => {
                let kind = &units::INERTIA;
                return Err(Failure::Argument(format!(
                    "`--inertia {text}`: {}; {}",
                    error.message(kind),
                    error.help(kind)
                )));
            }
        },
    };
    arguments.html.check()?;
    super::check_plot(arguments.plot.as_ref())?;
    let compared = compare(&arguments.catalog.rows()?, &arguments.a, &arguments.b, inertia)?;
    super::draw_plot(arguments.plot.as_ref(), &compared)?;
    arguments.html.write_page(call, &compared)?;
    Ok(Done::of(&compared, arguments.json))
}
