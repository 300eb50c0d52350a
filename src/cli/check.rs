use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::{Call, CatalogChoice, Done, Failure, Html, Set};
use crate::catalog::Catalog;
use crate::input::{InputError, Problem, Source};
use crate::output;
use crate::report::check::{Checked, github, input, junit, sarif, text};
use crate::report::html;
use crate::report::json_text;
use crate::requirement::DesignFile;
use crate::rules::Report;
use crate::rules::file::{RulesFile, read};
use crate::rules::lock::{Lock, path_of};

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
    let inputs = arguments.forms.reported("check", &arguments.design, Inputs::read(arguments))?;
    let Inputs { design, catalog, rules, lock_path, lock, .. } = &inputs;
    let report = crate::rules::check(design, catalog, rules, lock.as_ref(), lock_path).map_err(Failure::from);
    let report = arguments.forms.reported("check", &arguments.design, report)?;
    written(arguments, call, &inputs, &report)
}

/// What is checked, and with what.
struct Inputs {
    design: DesignFile,
    catalog: Catalog,
    rules: RulesFile,
    lock_path: PathBuf,
    lock: Option<Arc<Source>>,
    /// The text of a lock that is to be written.
    new_lock: Option<String>,
}

impl Inputs {
    fn read(arguments: &Arguments) -> Result<Inputs, Failure> {
        let settings = arguments.set.settings()?;
        if arguments.design.as_os_str() == Source::STDIN && (arguments.lock || arguments.update_lock) {
            return Err(Failure::Argument("a lock is a file next to the design: give a file in place of `-`".into()));
        }
        let source = Source::argument(&arguments.design).map_err(|e| vec![e])?;
        let mut design = DesignFile::read_set(&source, &settings)?;
        let named = arguments.catalog.paths();
        let paths = if named.is_empty() { &design.catalog } else { &named };
        let catalog = super::with_named(
            &design.robot,
            arguments.catalog.prepared(super::catalog(paths)?),
            design.motor_ids(),
            arguments.catalog.complete(),
        );
        design.robot = crate::design::families::settle(design.robot, &catalog).map_err(Failure::Argument)?;
        design.robot = super::balanced(&design.robot, &catalog, false)?;
        let rules = match arguments.rules.as_ref().or(design.rules.as_ref()).or(design.robot.rules.as_ref()) {
            Some(path) => read(path).map_err(|e| vec![e])?,
            None => RulesFile::default(),
        };
        let lock_path = path_of(&arguments.design);
        let new_lock = write_lock(arguments, &lock_path, &design, &catalog)?;
        let lock = match &new_lock {
            Some(text) => Some(Arc::new(Source::new(lock_path.display().to_string(), text.clone()))),
            None if !source.is_stdin() && lock_path.exists() => Some(Source::read(&lock_path).map_err(|e| vec![e])?),
            None => None,
        };
        Ok(Inputs { design, catalog, rules, lock_path, lock, new_lock })
    }
}

/// Writes the report in each form that was asked for.
fn written(arguments: &Arguments, call: &Call, inputs: &Inputs, report: &Report) -> Result<Done, Failure> {
    let Inputs { design, catalog, rules, lock_path, lock, new_lock } = inputs;
    let checked: Checked = report.into();
    arguments.forms.write(&checked, arguments.strict)?;
    let files = || {
        let files = [Some(&design.source), Some(&design.requirement), rules.source.as_ref(), lock.as_ref()];
        let files = files.into_iter().flatten().map(|source| source.file());
        files.chain(design.robot.files()).chain(catalog.files()).collect()
    };
    arguments.html.write(call, files, || html::check::page(report, arguments.strict))?;
    if let Some(text) = new_lock {
        output::write_whole(lock_path, text.as_bytes()).map_err(Failure::Argument)?;
        tell!("wrote {}", lock_path.display());
    }
    let json = || crate::report::json::check::json(report, arguments.strict);
    let plain = || super::told_set(&design.robot) + &text::text(report, arguments.strict);
    let text = arguments.forms.print(&checked, json, plain);
    Ok(Done { text, satisfied: report.passes(arguments.strict) })
}

/// The text of a lock that is to be written: where one is asked for again, or asked for and not there.
fn write_lock(
    arguments: &Arguments,
    path: &Path,
    design: &DesignFile,
    catalog: &Catalog,
) -> Result<Option<String>, Failure> {
    let missing = arguments.lock && !path.exists();
    if !arguments.update_lock && !missing {
        return Ok(None);
    }
    let choices = design.choices(catalog).map_err(|e| vec![e])?;
    Ok(Some(Lock::of(design, &choices, catalog).to_toml()))
}
