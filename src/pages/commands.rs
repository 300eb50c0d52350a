//! The page of commands: what `--help` of each says.

use super::MADE;

/// The page.
pub fn text(command: clap::Command) -> String {
    let mut command = command.term_width(100).color(clap::ColorChoice::Never);
    command.build();
    let about = command.get_about().map_or_else(String::new, ToString::to_string);
    let mut out = format!(
        "{MADE}# Commands\n\n{about}\n\nExit status of all: 0 done and satisfied; 1 done, but a requirement or rule is not met; 2 the input \
         is wrong. Tables and results go to stdout, warnings and progress to stderr. `gearwise man --out DIR` writes these pages for \
         `man`, `gearwise completions SHELL` completions.\n"
    );
    for sub in command.get_subcommands_mut().filter(|s| s.get_name() != "help" && !s.is_hide_set()) {
        let name = sub.get_name().to_string();
        let help = sub.clone().term_width(100).render_long_help().to_string();
        let help: Vec<&str> = help.trim_end().lines().map(str::trim_end).collect();
        out.push_str(&format!("\n## {name}\n\n```text\n{}\n```\n", help.join("\n")));
        for below in sub.get_subcommands().filter(|s| s.get_name() != "help") {
            let help = below.clone().term_width(100).render_long_help().to_string();
            let help: Vec<&str> = help.trim_end().lines().map(str::trim_end).collect();
            out.push_str(&format!("\n### {name} {}\n\n```text\n{}\n```\n", below.get_name(), help.join("\n")));
        }
    }
    out
}
