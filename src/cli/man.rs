use std::path::PathBuf;

use clap::{Args, Command};
#[cfg(feature = "packaging")]
use clap_mangen::Man;

use super::{Done, Failure};
#[cfg(feature = "packaging")]
use crate::output;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(before_help = "Examples:\n  gearwise man --out man\n  gearwise man --out ~/.local/share/man/man1")]
pub struct Arguments {
    /// Folder for the pages: gearwise.1, gearwise-optimize.1, …
    #[arg(long, value_name = "DIR")]
    #[cfg_attr(not(feature = "packaging"), allow(dead_code, reason = "only manual pages are written there"))]
    out: PathBuf,
}

#[cfg(feature = "packaging")]
pub fn run(arguments: &Arguments, mut command: Command) -> Result<Done, Failure> {
    command.build();
    let failed = |error: std::io::Error| {
        Failure::Argument(format!("cannot write to the folder `{}`: {error}", arguments.out.display()))
    };
    output::make_folder(&arguments.out).map_err(Failure::Argument)?;
    let mut pages = vec![("gearwise".to_string(), page(&command).map_err(failed)?)];
    for sub in command.get_subcommands().filter(|c| c.get_name() != "help" && !c.is_hide_set()) {
        let name = format!("gearwise-{}", sub.get_name());
        for below in sub.get_subcommands().filter(|c| c.get_name() != "help") {
            pages.push((format!("{name}-{}", below.get_name()), page(below).map_err(failed)?));
        }
        pages.push((name, page(sub).map_err(failed)?));
    }
    let mut text = String::new();
    for (name, page) in pages {
        let path = arguments.out.join(format!("{name}.1"));
        output::write_whole(&path, &page).map_err(Failure::Argument)?;
        text.push_str(&format!("{}\n", path.display()));
    }
    Ok(Done { text, satisfied: true })
}

/// A page with its examples before the options. No date, so that the same program makes the same page.
#[cfg(feature = "packaging")]
fn page(command: &Command) -> std::io::Result<Vec<u8>> {
    let mut out = Vec::new();
    let man = Man::new(command.clone());
    man.render_title(&mut out)?;
    man.render_name_section(&mut out)?;
    man.render_synopsis_section(&mut out)?;
    man.render_description_section(&mut out)?;
    if let Some(help) = command.get_before_help() {
        out.extend(b".SH EXAMPLES\n.nf\n");
        for line in help.to_string().lines().filter(|l| *l != "Examples:" && *l != "Example:") {
            out.extend(roff(line).as_bytes());
        }
        out.extend(b".fi\n");
    }
    man.render_options_section(&mut out)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut out)?;
    }
    man.render_version_section(&mut out)?;
    Ok(out)
}

/// A line as roff has it: nothing in it is a request, hyphens can be copied.
#[cfg(feature = "packaging")]
fn roff(line: &str) -> String {
    let escaped = line.replace('\\', "\\e").replace('-', "\\-").replace('\'', "\\(aq");
    format!("\\&{escaped}\n")
}

#[cfg(not(feature = "packaging"))]
pub fn run(_: &Arguments, _: Command) -> Result<Done, Failure> {
    Err(Failure::Argument(crate::words::not_built("manual pages")))
}
