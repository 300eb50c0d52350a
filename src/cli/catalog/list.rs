use clap::Args;

use super::{Done, Failure, Output, Which};
use crate::catalog::filter::{Filter, Kinds};
use crate::report::catalog::list::{self as report, Listing};
use crate::report::json;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise catalog list\n  gearwise catalog list motors maker=maxon 'mass<0.5kg'\n  gearwise catalog list gears kind=planetary 'ratio>=5'\n  gearwise catalog list motors 'Kt>0.1 N*m/A rms' --csv\n\n\
                   A filter is a column or another name of it, a comparison (= != < <= > >=) and a value with its unit. Texts are compared by = and !=, \
                   capitals do not matter, and * matches any letters. Resistance, inductance, constants and currents are compared on the q axis, or in \
                   the convention behind the unit. A row whose value is not known is not listed; how many there are is said. Quote what has < or >.\n\n\
                   `--csv` writes a catalogue file."
)]
pub struct Arguments {
    /// `motors` or `gears`, both without it; then filters that a row has to keep
    #[arg(value_name = "FILTER")]
    filters: Vec<String>,
    #[command(flatten)]
    which: Which,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let (kinds, filters) = match arguments.filters.split_first() {
        Some((first, rest)) if matches!(first.as_str(), "motors" | "motor") => (Kinds::Motors, rest),
        Some((first, rest)) if matches!(first.as_str(), "gears" | "gear") => (Kinds::Gears, rest),
        _ => (Kinds::Both, arguments.filters.as_slice()),
    };
    let filters: Vec<Filter> =
        filters.iter().map(|text| Filter::read(text)).collect::<Result<_, _>>().map_err(Failure::Argument)?;
    for filter in &filters {
        let (lacks, has) = match kinds {
            Kinds::Motors if !filter.is_of_motors() => ("motors", "gears"),
            Kinds::Gears if !filter.is_of_gears() => ("gears", "motors"),
            _ => continue,
        };
        let why = format!("the filter `{}`: {lacks} have no column `{}`; {has} do", filter.text, filter.column);
        return Err(Failure::Argument(why));
    }
    let of = |is: fn(&Filter) -> bool| filters.iter().find(|f| !is(f)).map(|f| f.text.as_str());
    if let (Kinds::Both, Some(gears), Some(motors)) = (kinds, of(Filter::is_of_motors), of(Filter::is_of_gears)) {
        let why = format!("`{motors}` asks for motors and `{gears}` for gears: no row keeps both");
        return Err(Failure::Argument(why));
    }
    let catalog = arguments.which.read()?;
    let listing = Listing::new(&catalog, kinds, filters);
    print(&arguments.output, &listing, json::catalog::listed)
}

/// A listing in the form that was asked for; a list without rows is one.
pub(super) fn print(
    output: &Output,
    listing: &Listing,
    json: fn(&Listing) -> serde_json::Value,
) -> Result<Done, Failure> {
    if output.csv {
        let fitted = listing.found.motors.iter().filter(|m| m.fit.is_some()).count();
        if fitted > 0 {
            tell!("warning: a table holds no fitted effects: those of {fitted} fitted actuators are left out");
        }
        let text = report::csv(listing).map_err(|why| Failure::Argument(format!("`--csv`: {why}")))?;
        return Ok(Done { text, satisfied: true });
    }
    let text = output.choose(|| report::text(listing), || json(listing), String::new);
    Ok(Done { text, satisfied: true })
}
