use clap::{Args, Command};
use clap_complete::Shell;

use super::{Done, Failure};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(before_help = "Examples:\n  gearwise completions bash > ~/.local/share/bash-completion/completions/gearwise")]
pub struct Arguments {
    /// Which shell
    shell: Shell,
}

pub fn run(arguments: &Arguments, command: &mut Command) -> Result<Done, Failure> {
    let mut bytes = Vec::new();
    clap_complete::generate(arguments.shell, command, "gearwise", &mut bytes);
    Ok(Done { text: String::from_utf8_lossy(&bytes).into_owned(), satisfied: true })
}
