use clap::Args;

use super::{Done, Failure};
use crate::report::{json, json_text, rules as report};
use crate::rules::{every_rule, rule};
use crate::words::nearest;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise rule\n  gearwise rule GW106\n  gearwise rule voltage-headroom\n  gearwise rule --measures"
)]
pub struct Arguments {
    /// Code or name of a rule; without one all are listed
    rule: Option<String>,
    /// What rules of your own can measure
    #[arg(long, conflicts_with_all = ["rule", "json"])]
    measures: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let text = match &arguments.rule {
        _ if arguments.measures => report::measure_list(),
        None if arguments.json => json_text(&json::rule::json(every_rule())),
        None => report::list(),
        Some(name) => {
            let found = rule(name).ok_or_else(|| {
                let names = every_rule().flat_map(|r| [r.name, r.code]);
                let help = match nearest(name, names) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("there are {}", every_rule().map(|r| r.name).collect::<Vec<_>>().join(", ")),
                };
                Failure::Argument(format!("there is no rule `{name}`; {help}"))
            })?;
            if arguments.json { json_text(&json::rule::json([found])) } else { report::text(found) }
        }
    };
    Ok(Done { text, satisfied: true })
}
