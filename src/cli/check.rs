use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::{Call, CatalogChoice, Done, Failure, Html, Set};
use crate::ask::Answer;
use crate::ask::check::{self, Inputs};
use crate::input::{InputError, Problem, Source};
use crate::output;
use crate::report::check::{Checked, github, input, junit, sarif};
use crate::report::json_text;
use crate::requirement::DesignFile;
use crate::rules::lock::path_of;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise check requirements/designs/quadruped_mini_cheetah/design.toml\n  gearwise check design.toml --rules rules.toml --strict\n  gearwise check design.toml --sarif check.sarif --junit check.xml --github\n  gearwise check design.toml --lock\n\nExit status 1 if a rule with severity `error` is broken. Where an input file is wrong (exit status 2) the mistakes are in what --github, --json, --junit and --sarif write."
)]
pub struct Arguments {
    /// Design file (TOML); `-` is standard input, without a lock
    design: PathBuf,
    /// Rules file, in place of the one that the design names
    #[arg(long, value_name = "FILE")]
    rules: Option<PathBuf>,
    /// Warnings fail the check too
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    catalog: CatalogChoice,
    #[command(flatten)]
    forms: Forms,
    #[command(flatten)]
    html: Html,
    /// Write the lock of the catalogue rows next to the design where there is none; an existing one is always compared
    #[arg(long)]
    lock: bool,
    /// Write the lock again
    #[arg(long)]
    update_lock: bool,
}

/// Forms of a check's result for machines.
#[derive(Debug, Args)]
pub(super) struct Forms {
    /// Print JSON (SI units, the unit next to the value)
    #[arg(long, conflicts_with = "github")]
    json: bool,
    /// Print annotations for GitHub Actions
    #[arg(long)]
    github: bool,
    /// Write JUnit XML
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write SARIF 2.1.0; places are relative to the folder the program runs in
    #[arg(long, value_name = "FILE")]
    sarif: Option<PathBuf>,
}

impl Forms {
    /// The result; what is wrong with the input is reported in each form that was asked for. What cannot be written is no
    /// mistake of the input. `main` is the file that was checked.
    pub(super) fn reported<T>(
        &self,
        command: &'static str,
        main: &Path,
        result: Result<T, Failure>,
    ) -> Result<T, Failure> {
        match &result {
            Err(Failure::Input(errors)) => self.wrong_input(command, errors)?,
            // What is wrong with the input as a whole has no place in a file: it stands at the file that was checked.
            Err(Failure::Argument(why)) => {
                let source = Arc::new(Source::new(main.display().to_string(), ""));
                self.wrong_input(command, &[InputError { source, problems: vec![Problem::whole(why)] }])?;
            }
            _ => {}
        }
        result
    }

    /// Reports what is wrong with the input in each form that was asked for.
    fn wrong_input(&self, command: &'static str, errors: &[InputError]) -> Result<(), Failure> {
        let root = std::env::current_dir().unwrap_or_default();
        if let Some(path) = &self.junit {
            output::write_whole(path, input::junit(errors, command).as_bytes()).map_err(Failure::Argument)?;
        }
        if let Some(path) = &self.sarif {
            let text = json_text(&input::sarif(errors, &root));
            output::write_whole(path, text.as_bytes()).map_err(Failure::Argument)?;
        }
        let text = match (self.json, self.github) {
            (true, _) => json_text(&input::json(errors, command)),
            (_, true) => input::github(errors, &root),
            _ => return Ok(()),
        };
        let not_printed = |e| Failure::Argument(format!("cannot write the result: {}", crate::words::reason(&e)));
        super::print(&text).map_err(not_printed)
    }

    /// Writes the files that were asked for.
    pub(super) fn write(&self, checked: &Checked, strict: bool) -> Result<(), Failure> {
        let root = std::env::current_dir().unwrap_or_default();
        let write = |path: &Option<PathBuf>, text: &dyn Fn() -> String| match path {
            Some(path) => output::write_whole(path, text().as_bytes()).map_err(Failure::Argument),
            None => Ok(()),
        };
        write(&self.junit, &|| junit::text(checked, strict))?;
        write(&self.sarif, &|| json_text(&sarif::json(checked, &root)))
    }

    /// Whether the result is printed for people.
    pub(super) fn is_text(&self) -> bool {
        !self.json && !self.github
    }

    /// What is printed: JSON or annotations where they were asked for, else the text.
    pub(super) fn print(
        &self,
        checked: &Checked,
        json: impl FnOnce() -> serde_json::Value,
        text: impl FnOnce() -> String,
    ) -> String {
        match (self.json, self.github) {
            (true, _) => json_text(&json()),
            (_, true) => github::text(checked, &std::env::current_dir().unwrap_or_default()),
            _ => text(),
        }
    }
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    let reported = |result| arguments.forms.reported("check", &arguments.design, result);
    let (inputs, new_lock) = arguments.forms.reported("check", &arguments.design, read_inputs(arguments))?;
    let lock_path = inputs.lock_path.clone();
    let checked = reported(check::check(inputs, arguments.strict))?;
    written(arguments, call, &checked, new_lock.map(|text| (lock_path, text)))
}

/// What is checked and with what; the text of a lock that is to be written.
fn read_inputs(arguments: &Arguments) -> Result<(Inputs, Option<String>), Failure> {
    let settings = arguments.set.settings()?;
    if arguments.design.as_os_str() == Source::STDIN && (arguments.lock || arguments.update_lock) {
        return Err(Failure::Argument("a lock is a file next to the design: give a file in place of `-`".into()));
    }
    let source = Source::argument(&arguments.design).map_err(|e| vec![e])?;
    let design = DesignFile::read_set(&source, &settings)?;
    let named = arguments.catalog.paths();
    let paths = if named.is_empty() { &design.catalog } else { &named };
    let rows = arguments.catalog.prepared(super::catalog(paths)?);
    let lock_path = path_of(&arguments.design);
    let inputs = Inputs::new(design, &rows, arguments.rules.as_deref(), lock_path)?;
    let lock_path = &inputs.lock_path;
    // Where one is asked for again, or asked for and not there.
    let new_lock = match arguments.update_lock || arguments.lock && !lock_path.exists() {
        true => Some(inputs.new_lock()?),
        false => None,
    };
    let lock = match &new_lock {
        Some(text) => Some(Arc::new(Source::new(lock_path.display().to_string(), text.clone()))),
        None if !source.is_stdin() && lock_path.exists() => Some(Source::read(lock_path).map_err(|e| vec![e])?),
        None => None,
    };
    Ok((Inputs { lock, ..inputs }, new_lock))
}

/// Writes the report in each form that was asked for.
fn written(
    arguments: &Arguments,
    call: &Call,
    found: &check::Checked,
    new_lock: Option<(PathBuf, String)>,
) -> Result<Done, Failure> {
    let checked: Checked = found.report().into();
    arguments.forms.write(&checked, arguments.strict)?;
    arguments.html.write_page(call, found)?;
    if let Some((path, text)) = new_lock {
        output::write_whole(&path, text.as_bytes()).map_err(Failure::Argument)?;
        tell!("wrote {}", path.display());
    }
    let text = arguments.forms.print(&checked, || found.json(), || found.text());
    Ok(Done { text, satisfied: found.is_satisfied() })
}
