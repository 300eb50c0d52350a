use clap::Args;

use super::{Done, Failure, Output, Which};
use crate::catalog::convention::word;
use crate::catalog::filter::{Filter, RowKind};
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
    /// `motors`, `gears`, `modules` or `families`, all without it; then filters that a row has to keep
    #[arg(value_name = "FILTER")]
    filters: Vec<String>,
    #[command(flatten)]
    which: Which,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let (kinds, filters) = match arguments.filters.split_first() {
        Some((first, rest)) if matches!(first.as_str(), "motors" | "motor") => (Some(RowKind::Motor), rest),
        Some((first, rest)) if matches!(first.as_str(), "gears" | "gear") => (Some(RowKind::Gear), rest),
        Some((first, rest)) if matches!(first.as_str(), "modules" | "module") => (Some(RowKind::Module), rest),
        Some((first, rest)) if matches!(first.as_str(), "families" | "family") => (Some(RowKind::Family), rest),
        _ => (None, arguments.filters.as_slice()),
    };
    if let (Some(RowKind::Family), Some(filter)) = (kinds, filters.first()) {
        let why = format!(
            "the filter `{filter}`: gear families have no columns; `gearwise catalog show NAME` lists the points of one"
        );
        return Err(Failure::Argument(why));
    }
    let filters: Vec<Filter> =
        filters.iter().map(|text| Filter::read(text)).collect::<Result<_, _>>().map_err(Failure::Argument)?;
    let having = |filter: &Filter| {
        let kinds = RowKind::NAMES.iter().filter(|(_, kind)| filter.is_of(*kind));
        kinds.map(|(word, _)| format!("{word}s")).collect::<Vec<_>>()
    };
    for filter in &filters {
        let Some(kind) = kinds.filter(|kind| !filter.is_of(*kind)) else { continue };
        let (lacks, has) = (word(RowKind::NAMES, &kind), having(filter).join(" and "));
        let why = format!("the filter `{}`: {lacks}s have no column `{}`; {has} do", filter.text, filter.column);
        return Err(Failure::Argument(why));
    }
    let all = |kind: RowKind| filters.iter().all(|filter| filter.is_of(kind));
    if kinds.is_none() && !RowKind::NAMES.iter().any(|(_, kind)| all(*kind)) {
        let of = |filter: &Filter| format!("`{}` asks for {}", filter.text, having(filter).join(" or "));
        let each: Vec<String> = filters.iter().map(of).collect();
        return Err(Failure::Argument(format!("{}: no row keeps all", each.join(", "))));
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
