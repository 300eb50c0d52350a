use std::path::PathBuf;

use clap::Args;

use super::{Call, Done, Failure, Html};
use crate::study::StudyError;
use crate::study::assemble::{Shards, assemble};
use crate::study::journal::Lock;
use crate::study::output;
use crate::study::text as report;

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
    let out = &arguments.out;
    let there = output::FILES.iter().find(|f| out.join(f).exists());
    if let (Some(file), false) = (there, arguments.force) {
        return Err(Failure::Argument(format!(
            "`{}` has results already (`{file}`): `--force` replaces them",
            out.display()
        )));
    }
    // Shards first: where they are wrong no folder is made.
    let shards = Shards::open(&arguments.shards)?;
    let _lock = Lock::take(out)?;
    let summary = assemble(&shards, out).map_err(|e: StudyError| Failure::from(e))?;
    super::study::page_of(&arguments.html, call, out, &summary)?;
    let text =
        if arguments.json { report::json_text(&summary) } else { super::study::written(out, report::text(&summary)) };
    Ok(Done { text, satisfied: summary.broken == 0 })
}
