use std::path::PathBuf;

use clap::Args;

use super::{Call, Done, Failure, Html};
use crate::ask::Answer;
use crate::study::answer::Finished;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise merge result part1 part2 part3\n  gearwise merge result parts/* --force"
)]
pub struct Arguments {
    /// Folder for the results
    #[arg(value_name = "OUT")]
    out: PathBuf,
    /// The folders of all shards of the study
    #[arg(required = true, value_name = "SHARD")]
    shards: Vec<PathBuf>,
    /// Replace results that are there
    #[arg(long)]
    force: bool,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    html: Html,
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    let finished = Finished::merged(&arguments.out, &arguments.shards, arguments.force)?;
    super::study::page_of(&arguments.html, call, &finished)?;
    let text = if arguments.json { finished.json_text() } else { finished.text() };
    Ok(Done { text, satisfied: finished.is_satisfied() })
}
