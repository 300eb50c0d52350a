use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;

use super::{Call, Done, Failure, Html, Output};
use crate::ask::Answer;
use crate::ask::audit::audit;
use crate::catalog::Catalog;
use crate::catalog::against::against;
use crate::input::Source;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise audit\n  gearwise audit my_motors.csv\n  gearwise audit my_motors.csv --against second_reading.csv --map ids.csv\n\nExit status 1 if a row contradicts itself and its note does not say why; with --against, if a number is more than 1 % from that of the \
                   second source."
)]
pub struct Arguments {
    /// Catalogue files or folders; the built-in catalogue if none is given
    catalog: Vec<PathBuf>,
    /// Compare with a second source of the same rows: which numbers are more than 1 % apart, and which one of them lacks
    #[arg(long, value_name = "SECOND.csv", conflicts_with = "html")]
    against: Option<PathBuf>,
    /// Ids of the second source and ours, where they are not the same: CSV with the columns `second` and `own`
    #[arg(long, value_name = "IDS.csv", requires = "against")]
    map: Option<PathBuf>,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    let catalog = super::catalog(&arguments.catalog)?;
    if let Some(second) = &arguments.against {
        let names = arguments.map.as_deref().map(names).transpose()?.unwrap_or_default();
        let second = super::catalog(std::slice::from_ref(second))?;
        if let Some(id) = names.keys().find(|id| !has(&second, id)) {
            return Err(Failure::Argument(format!("--map: the second source has no row `{id}`")));
        }
        if let Some(id) = names.values().find(|id| !has(&catalog, id)) {
            return Err(Failure::Argument(format!("--map: the catalogue has no row `{id}`")));
        }
        let mut taken: Vec<&String> = names.values().collect();
        taken.sort_unstable();
        if let Some(twice) = taken.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Failure::Argument(format!("--map: two rows of the second source are `{}`", twice[0])));
        }
        let found = against(&catalog, &second, &names);
        let text = arguments.output.choose(
            || crate::report::catalog::against::text(&found),
            || crate::report::json::catalog::compared(&found),
            || crate::report::catalog::against::csv(&found),
        );
        return Ok(Done { text, satisfied: found.apart.is_empty() && found.compared > 0 });
    }
    let audited = audit(catalog);
    arguments.html.write_page(call, &audited)?;
    Ok(arguments.output.done(&audited, || audited.text()))
}

fn has(catalog: &Catalog, id: &str) -> bool {
    catalog.motors.iter().any(|m| m.id == id)
        || catalog.gears.iter().any(|g| g.id == id)
        || catalog.modules.iter().any(|m| m.id == id)
}

/// Ids of the second source to ours.
fn names(path: &Path) -> Result<BTreeMap<String, String>, Failure> {
    let failed = |why: String| Failure::Argument(format!("{}: {why}", path.display()));
    let source = Source::read(path).map_err(|e| vec![e])?;
    let mut reader = csv::Reader::from_reader(source.text().as_bytes());
    let header = reader.headers().map_err(|e| failed(e.to_string()))?.clone();
    let place = |name: &str| {
        header.iter().position(|h| h.trim() == name).ok_or_else(|| failed(format!("there is no column `{name}`")))
    };
    let (second, own) = (place("second")?, place("own")?);
    let mut found = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| failed(e.to_string()))?;
        let cell = |k: usize| record.get(k).unwrap_or_default().trim().to_string();
        if found.insert(cell(second), cell(own)).is_some() {
            return Err(failed(format!("`{}` has two of ours", cell(second))));
        }
    }
    Ok(found)
}
