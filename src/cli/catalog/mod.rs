//! `gearwise catalog`: what is in a catalogue, and a catalogue of one's own.

mod add;
mod diff;
mod list;
mod new;
mod path;
mod search;
mod show;

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{Done, Failure, Output};
use crate::catalog::{BUILTIN_WORD, Catalog};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise catalog list motors maker=maxon 'mass<0.5kg'\n  gearwise catalog search robodrive\n  gearwise catalog show t-motor-u8-lee\n  gearwise catalog new motor --write my_motor.csv\n  gearwise catalog add my_motor.csv\n  gearwise catalog diff builtin my_motors.csv\n  gearwise catalog path"
)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Motors and gears of a catalogue, with filters: maker=maxon, mass<0.5kg, diameter<=100mm, kind=planetary, ratio>=5
    List(list::Arguments),
    /// Rows whose id, model or maker has a text in it
    Search(search::Arguments),
    /// One row in all conventions: what is not known, what that prevents, and what is estimated in its place
    Show(show::Arguments),
    /// A commented template of a file, or a row made of flags
    New(new::Arguments),
    /// Rows into one's own catalogue file, read and audited first; whole or not at all
    Add(add::Arguments),
    /// Rows that two catalogues do not have in common, column by column
    Diff(diff::Arguments),
    /// Where `user` and `builtin` are
    Path(path::Arguments),
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    match &arguments.what {
        What::List(arguments) => list::run(arguments),
        What::Search(arguments) => search::run(arguments),
        What::Show(arguments) => show::run(arguments),
        What::New(arguments) => new::run(arguments),
        What::Add(arguments) => add::run(arguments),
        What::Diff(arguments) => diff::run(arguments),
        What::Path(arguments) => path::run(arguments),
    }
}

/// Which catalogue is looked at.
#[derive(Debug, Args)]
struct Which {
    /// Catalogue files or folders, in place of the built-in catalogue; `builtin` and `user` name that and your own
    #[arg(long, value_name = "PATH", num_args = 1.., conflicts_with = "also")]
    catalog: Vec<PathBuf>,
    /// Catalogue files or folders next to the built-in catalogue
    #[arg(long, value_name = "PATH", num_args = 1..)]
    also: Vec<PathBuf>,
}

impl Which {
    /// The catalogue with every row as it was read.
    fn read(&self) -> Result<Catalog, Failure> {
        match self.also.as_slice() {
            [] => super::catalog(&self.catalog),
            also => {
                let paths: Vec<PathBuf> = std::iter::once(BUILTIN_WORD.into()).chain(also.iter().cloned()).collect();
                super::catalog(&paths)
            }
        }
    }
}
