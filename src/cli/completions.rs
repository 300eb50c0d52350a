use clap::{Args, Command, ValueEnum};

use super::{Done, Failure};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(before_help = "Examples:\n  gearwise completions bash > ~/.local/share/bash-completion/completions/gearwise")]
pub struct Arguments {
    /// Which shell
    shell: Shell,
}

/// A shell that completions can be made for.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Shell {
    Bash,
    Elvish,
    Fish,
    Powershell,
    Zsh,
}

#[cfg(feature = "packaging")]
pub fn run(arguments: &Arguments, command: &mut Command) -> Result<Done, Failure> {
    let shell = match arguments.shell {
        Shell::Bash => clap_complete::Shell::Bash,
        Shell::Elvish => clap_complete::Shell::Elvish,
        Shell::Fish => clap_complete::Shell::Fish,
        Shell::Powershell => clap_complete::Shell::PowerShell,
        Shell::Zsh => clap_complete::Shell::Zsh,
    };
    let mut bytes = Vec::new();
    clap_complete::generate(shell, command, "gearwise", &mut bytes);
    Ok(Done { text: String::from_utf8_lossy(&bytes).into_owned(), satisfied: true })
}

#[cfg(not(feature = "packaging"))]
pub fn run(arguments: &Arguments, _: &mut Command) -> Result<Done, Failure> {
    let shell = arguments.shell.to_possible_value().map_or_else(String::new, |value| value.get_name().to_string());
    Err(Failure::Argument(crate::words::not_built(&format!("completions for {shell}"))))
}
