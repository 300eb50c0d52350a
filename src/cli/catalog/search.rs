use clap::Args;

use super::{Done, Failure, Output, Which};
use crate::report::catalog::list::Listing;
use crate::report::json;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise catalog search robodrive\n  gearwise catalog search 'ec frameless 90'\n\nExit status 1 if nothing is found; names that are near are named then."
)]
pub struct Arguments {
    /// Words, each of which is in id, model or maker; capitals, blanks and signs do not matter
    #[arg(value_name = "TEXT", required = true)]
    text: Vec<String>,
    #[command(flatten)]
    which: Which,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let text = arguments.text.join(" ");
    if !text.contains(char::is_alphanumeric) {
        return Err(Failure::Argument("a search needs letters or digits".into()));
    }
    let catalog = arguments.which.read()?;
    let listing = Listing::search(&catalog, &text);
    let done = super::list::print(&arguments.output, &listing, json::catalog::searched)?;
    Ok(Done { satisfied: !listing.is_empty(), ..done })
}
