use std::path::PathBuf;

use clap::Args;

use super::{Done, Failure};
use crate::output;
use crate::pages;
use crate::words::not_built;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(before_help = "Examples:\n  gearwise docs --out docs")]
pub struct Arguments {
    /// Folder for the pages
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Every page with its text; the commands' own page is made here, where they are known.
pub fn pages() -> Vec<(&'static str, String)> {
    let mut all: Vec<(&'static str, String)> = pages::PAGES.iter().map(|page| (page.file, (page.text)())).collect();
    #[cfg(feature = "schema")]
    all.push(("schema.json", crate::report::json_text(&pages::schema::schema())));
    all.push(("commands.md", pages::commands::text(super::command())));
    all
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let mut text = String::new();
    for (name, page) in pages() {
        let path = arguments.out.join(name);
        output::write_whole(&path, page.as_bytes()).map_err(Failure::Argument)?;
        text.push_str(&format!("{}\n", path.display()));
    }
    if !cfg!(feature = "schema") {
        text.push_str(&format!("{}\n", not_built("the schema (schema.json)")));
    }
    Ok(Done { text, satisfied: true })
}
