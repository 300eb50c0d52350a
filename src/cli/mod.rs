//! The command line: arguments in, library call, report out. No physics.

/// Says something on stderr, as a line of its own.
macro_rules! tell {
    ($($said:tt)*) => { $crate::cli::say(format_args!($($said)*), "\n") };
}
/// The same for a text that has its line end.
macro_rules! tell_on {
    ($($said:tt)*) => { $crate::cli::say(format_args!($($said)*), "") };
}

mod audit;
mod catalog;
mod characterize;
mod check;
mod check_model;
mod compare;
mod completions;
mod docs;
mod explain;
mod explore;
mod export;
mod identify;
mod import;
mod man;
mod merge;
mod optimize;
mod over;
mod progress;
mod rank;
mod rule;
mod signals;
mod study;
mod sweep;
mod threads;
mod torques;

/// What the bytes of a request to `explore` say: for its fuzzing.
#[doc(hidden)]
pub use explore::head as explore_http_head;

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand};

use crate::ask::{Answer, Failure, Rows};
use crate::catalog::{BUILTIN_WORD, Catalog};
use crate::input::{InputFile, Source, tame};
use crate::output::{self, inputs};
use crate::report::html;
use crate::report::plot;
use crate::report::{table, tint};
use crate::requirement::{Robot, Settings};
use crate::units;

/// Choose the motor and the gear ratio of a robot joint, and prove that the choice is the best.
#[derive(Debug, Parser)]
#[command(
    name = "gearwise",
    version,
    max_term_width = 100,
    propagate_version = true,
    before_help = "Examples:\n  gearwise optimize requirements/quadruped_mini_cheetah.toml\n  gearwise explain t-motor-ri50 requirements/quadruped_mini_cheetah.toml --joint knee"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Number of threads; the result is the same for any number
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Per joint: the best motors, each with its best ratio, what binds, margins and proof
    Optimize(optimize::Arguments),
    /// The whole story of one motor at a joint, feasible or not
    Explain(explain::Arguments),
    /// A page on this machine in which every slider moves the best designs: what if
    Explore(explore::Arguments),
    /// Every motor at every ratio: feasible, or why not
    Sweep(sweep::Arguments),
    /// Many robots in one go, or a grid of parameters: resumable, in shards, results as CSV and Parquet
    Study(study::Arguments),
    /// The shards of a study put together
    Merge(merge::Arguments),
    /// Motors by metric: S_M, S_T, mass-weighted, K_M, …
    Rank(rank::Arguments),
    /// Two motors side by side, at matched actuator inertia too
    Compare(compare::Arguments),
    /// What is in a catalogue: list, search, show; rows of one's own: new, add, diff, path
    Catalog(catalog::Arguments),
    /// Are the rows of a catalogue self-consistent, and what would explain a mismatch
    Audit(audit::Arguments),
    /// Design rules on a chosen design, for CI: table, JSON, JUnit, SARIF, GitHub annotations
    Check(check::Arguments),
    /// Robot models (URDF, MJCF, JSON) against the hardware that is bought for their joints
    CheckModel(check_model::Arguments),
    /// What a design rule does, why, and how to fix what it finds
    Rule(rule::Arguments),
    /// Bench logs against the declared model: what it lacks, by how much, and how sure that is
    Identify(identify::Arguments),
    /// Joint torques of a robot (URDF or MJCF) along a trajectory, as motions for a requirement
    Torques(torques::Arguments),
    /// Raw bench logs of a motor into a catalogue row, with uncertainties
    Characterize(characterize::Arguments),
    /// A chosen design for a simulator: MJCF, URDF, JSON
    Export(export::Arguments),
    /// A public motor database into catalogue files
    Import(import::Arguments),
    /// Manual pages of all commands
    Man(man::Arguments),
    /// The pages of docs/ that are made from the program
    #[command(hide = true)]
    Docs(docs::Arguments),
    /// Completions for a shell
    Completions(completions::Arguments),
}

/// The whole command line, for manual, completions and documentation.
pub fn command() -> clap::Command {
    Cli::command()
}

/// The pages of `docs/` that are made from the program: name and text.
pub fn pages() -> Vec<(&'static str, String)> {
    docs::pages()
}

/// In which form a result is printed.
#[derive(Debug, Args)]
struct Output {
    /// Print JSON (SI units, the unit in the key)
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print CSV, one row for each result
    #[arg(long)]
    csv: bool,
}

impl Output {
    /// Whether it is for people.
    fn is_text(&self) -> bool {
        !self.json && !self.csv
    }

    /// The text in the form that was asked for.
    fn choose(
        &self,
        text: impl FnOnce() -> String,
        json: impl FnOnce() -> serde_json::Value,
        csv: impl FnOnce() -> String,
    ) -> String {
        if self.json || self.csv {
            tint::set_on(false);
        }
        if self.json {
            crate::report::json_text(&json())
        } else if self.csv {
            csv()
        } else {
            text()
        }
    }

    /// An answer in the form that was asked for, with this text for people.
    fn done(&self, answer: &dyn Answer, text: impl FnOnce() -> String) -> Done {
        let text = self.choose(text, || answer.json(), || answer.csv());
        Done { text, satisfied: answer.is_satisfied() }
    }
}

/// Which catalogue is used.
#[derive(Debug, Args)]
struct CatalogChoice {
    /// Catalogue files or folders, in place of the built-in catalogue; `builtin` and `user` name that and your own
    #[arg(long, value_name = "PATH", num_args = 1.., conflicts_with = "also")]
    catalog: Vec<PathBuf>,
    /// Catalogue files or folders next to the built-in catalogue
    #[arg(long, value_name = "PATH", num_args = 1..)]
    also: Vec<PathBuf>,
    /// What a row lacks stays unknown: no estimates of heat, rotor inertia and inductance from rows built alike
    #[arg(long)]
    no_estimates: bool,
    /// Motors that are only sold inside a module are a free choice too
    #[arg(long)]
    also_inside_modules: bool,
}

impl CatalogChoice {
    /// The rows that one chooses from, of which there is at least one.
    fn rows(&self) -> Result<Rows, Failure> {
        self.prepared(catalog(&self.paths())?).some()
    }

    /// The paths that are named; none for the built-in catalogue alone.
    fn paths(&self) -> Vec<PathBuf> {
        match self.also.as_slice() {
            [] => self.catalog.clone(),
            also => std::iter::once(BUILTIN_WORD.into()).chain(also.iter().cloned()).collect(),
        }
    }

    /// The words of a call with the same catalogue.
    fn words(&self) -> Vec<String> {
        let list = |option: &str, paths: &[PathBuf]| match paths {
            [] => Vec::new(),
            paths => std::iter::once(option.to_string()).chain(paths.iter().map(|p| p.display().to_string())).collect(),
        };
        let mut words = [list("--catalog", &self.catalog), list("--also", &self.also)].concat();
        words.extend(self.no_estimates.then(|| "--no-estimates".to_string()));
        words.extend(self.also_inside_modules.then(|| "--also-inside-modules".to_string()));
        words
    }

    /// A catalogue as one chooses from it.
    fn prepared(&self, catalog: Catalog) -> Rows {
        Rows::new(catalog, !self.no_estimates, self.also_inside_modules)
    }
}

/// Values in the place of a requirement's own.
#[derive(Debug, Args)]
struct Set {
    /// Put a value in the place of the requirement's: a path as in the grid of a study, and a value as in the file. May be
    /// repeated, e.g. --set bus.voltage="48 V" --set 'joint.*.limits.safety=1.2' --set scale.torque=1.1
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl Set {
    /// The values.
    fn settings(&self) -> Result<Settings, Failure> {
        Settings::of_arguments(&self.set).map_err(Failure::Argument)
    }

    /// The requirement at a path (`-` is standard input) with them; `no_springs` as for `read_without_springs`.
    fn read(&self, path: &Path, no_springs: Option<&str>) -> Result<Robot, Failure> {
        let settings = self.settings()?;
        let source = Source::argument(path).map_err(|e| vec![e])?;
        Ok(settings.read(&source, no_springs)?)
    }
}

/// Catalogue files.
#[derive(Debug, Args)]
struct CatalogPaths {
    /// Catalogue files or folders, in place of the built-in catalogue
    #[arg(long, value_name = "PATH", num_args = 1..)]
    catalog: Vec<PathBuf>,
}

/// What a command leaves: what it prints, and whether what was asked is satisfied.
struct Done {
    text: String,
    satisfied: bool,
}

impl Done {
    /// An answer as JSON or for people.
    fn of(answer: &dyn Answer, json: bool) -> Done {
        let text = if json { answer.json_text() } else { answer.text() };
        Done { text, satisfied: answer.is_satisfied() }
    }
}

fn catalog(paths: &[PathBuf]) -> Result<Catalog, Failure> {
    let catalog = if paths.is_empty() { Catalog::builtin()? } else { Catalog::read(paths)? };
    Ok(catalog)
}

/// Says what an answer remarks.
fn remark(answer: &dyn Answer) {
    answer.remarks().iter().for_each(|remark| tell!("warning: {remark}"));
}

/// A picture's file name must be one before any work is done.
fn check_plot(path: Option<&PathBuf>) -> Result<(), Failure> {
    path.map_or(Ok(()), |p| plot::Format::of(p).map(|_| ()).map_err(Failure::Argument))
}

/// That files can be written, once what is read has been read and before any work is done.
fn check_outputs<'p>(paths: impl IntoIterator<Item = &'p PathBuf>) -> Result<(), Failure> {
    paths.into_iter().try_for_each(|path| output::check(path)).map_err(Failure::Argument)
}

/// Draws the picture of an answer, where it was asked for and there is one.
fn draw_plot(path: Option<&PathBuf>, answer: &dyn Answer) -> Result<(), Failure> {
    match path.and_then(|path| Some((path, answer.figure()?))) {
        Some((path, figure)) => plot::write(&figure, path).map_err(Failure::Argument),
        None => Ok(()),
    }
}

/// The page of a result, where one is asked for.
#[derive(Debug, Args)]
struct Html {
    /// Write the result as a page that opens anywhere without a network: tables that sort and filter, figures, warnings, inputs
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
}

impl Html {
    /// Whether a page is to be written.
    fn is_asked(&self) -> bool {
        self.html.is_some()
    }

    /// Checks the file's name before any work is done.
    fn check(&self) -> Result<(), Failure> {
        self.html.as_deref().map_or(Ok(()), html::check).map_err(Failure::Argument)
    }

    /// Writes the page of an answer, where it was asked for.
    fn write_page(&self, call: &Call, answer: &dyn Answer) -> Result<(), Failure> {
        let Some(path) = &self.html else { return Ok(()) };
        html::write(&answer.whole_page(&call.0), path).map_err(Failure::Argument)
    }

    /// Writes the page that was asked for, with how the program was called and which files the result rests on.
    fn write(
        &self,
        call: &Call,
        inputs: impl FnOnce() -> Vec<InputFile>,
        page: impl FnOnce() -> html::Page,
    ) -> Result<(), Failure> {
        let Some(path) = &self.html else { return Ok(()) };
        let mut inputs = inputs();
        inputs.sort();
        inputs.dedup();
        html::write(&html::Page { call: call.0.clone(), inputs, ..page() }, path).map_err(Failure::Argument)
    }
}

/// How the program was called, as one types it, without what does not change the result: where the page goes, and how many
/// threads.
struct Call(String);

impl Call {
    /// Of the program's arguments, the first of which is its own name.
    fn new(arguments: &[OsString]) -> Call {
        Call(call(arguments.iter().skip(1).map(|a| a.to_string_lossy().into_owned())))
    }
}

fn call(mut arguments: impl Iterator<Item = String>) -> String {
    let mut words = vec!["gearwise".to_string()];
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--html" | "--threads" | "--plot" => drop(arguments.next()),
            "--json" | "--csv" => {}
            a if ["--html=", "--threads=", "--plot="].iter().any(|option| a.starts_with(option)) => {}
            a if a.is_empty() || a.contains(|c: char| c.is_whitespace() || "\"'\\$`*?<>|&;()#".contains(c)) => {
                words.push(format!("'{}'", a.replace('\'', r"'\''")));
            }
            _ => words.push(argument),
        }
    }
    words.join(" ")
}

/// A tolerance as an option gives it, a share.
fn tolerance(text: Option<&str>) -> Result<Option<f64>, Failure> {
    let Some(text) = text else { return Ok(None) };
    match units::quantity(text, &units::RATIO) {
        Ok(value) if (0.0..1.0).contains(&value) => Ok(Some(value)),
        _ => Err(Failure::Argument(format!("`--tolerance {text}` is not a tolerance; write it like 5% or 0.05"))),
    }
}

/// The name of an order, or of its mass-weighted form.
fn metric_name(sort: &str, mass_weight: bool) -> Result<String, Failure> {
    match (mass_weight, sort) {
        (false, _) => Ok(sort.to_string()),
        (true, "s_m" | "s_t") => Ok(format!("mass_{sort}")),
        (true, _) => Err(Failure::Argument("`--mass-weight` goes with `--sort s_m` or `--sort s_t`".into())),
    }
}

/// What turns while a work of unknown size is done.
fn spinner(what: &'static str) -> indicatif::ProgressBar {
    let bar = indicatif::ProgressBar::new_spinner().with_message(what);
    match indicatif::ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// A bar, with an estimate of the time that is left.
fn bar(length: usize, what: &'static str) -> indicatif::ProgressBar {
    let style = indicatif::ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
    let bar = indicatif::ProgressBar::new(length as u64).with_message(what);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Runs the program on the process's arguments, as [`run_with`].
pub fn run() -> ExitCode {
    run_with(std::env::args_os()).into()
}

/// Runs the program on these arguments, the first of which is the program's own name, with the process's standard output
/// and error. May be called any number of times; Ctrl-C and SIGTERM stop a study, and end `explore`. Exit status: 0 done and
/// satisfied, 1 done but a requirement is not met, 2 the input is wrong, 130 it was stopped.
///
/// ```
/// assert_eq!(gearwise::cli::run_with(["gearwise", "rule", "voltage-headroom"]), 0);
/// assert_eq!(gearwise::cli::run_with(["gearwise", "optimize", "no_such_file.toml"]), 2);
/// ```
pub fn run_with(arguments: impl IntoIterator<Item = impl Into<OsString>>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are answers, not mistakes.
            let code = u8::from(error.use_stderr()) * 2;
            return match error.print() {
                Err(why) if !error.use_stderr() && why.kind() != std::io::ErrorKind::BrokenPipe => not_printed(&why),
                _ => code,
            };
        }
    };
    let call = Call::new(&arguments);
    // What this call reads it does not write over.
    let _run = inputs::Run::begin();
    if let Some(why) = stdin_twice(&arguments) {
        return finish(Err(why));
    }
    finish(threads::shared_out(cli.threads, || answer(&cli.command, &call)))
}

/// Standard input can be read once: that it is asked for more often.
fn stdin_twice(arguments: &[OsString]) -> Option<Failure> {
    let names = |argument: &&OsString| {
        let text = argument.to_string_lossy();
        text == Source::STDIN || text.starts_with("--") && text.ends_with("=-")
    };
    let why = "`-` is standard input, which can be read only once: name one file at least";
    (arguments.iter().filter(names).count() > 1).then(|| Failure::Argument(why.into()))
}

/// Does what a command asks for.
fn answer(command: &Command, call: &Call) -> Result<Done, Failure> {
    table::set_width(width());
    tint::set_on(has_colour());
    match command {
        Command::Optimize(arguments) => optimize::run(arguments, call),
        Command::Explain(arguments) => explain::run(arguments, call),
        Command::Explore(arguments) => explore::run(arguments, call),
        Command::Sweep(arguments) => sweep::run(arguments, call),
        Command::Study(arguments) => study::run(arguments, call),
        Command::Merge(arguments) => merge::run(arguments, call),
        Command::Rank(arguments) => rank::run(arguments, call),
        Command::Compare(arguments) => compare::run(arguments, call),
        Command::Catalog(arguments) => catalog::run(arguments),
        Command::Audit(arguments) => audit::run(arguments, call),
        Command::Check(arguments) => check::run(arguments, call),
        Command::CheckModel(arguments) => check_model::run(arguments),
        Command::Rule(arguments) => rule::run(arguments),
        Command::Identify(arguments) => identify::run(arguments, call),
        Command::Torques(arguments) => torques::run(arguments),
        Command::Characterize(arguments) => characterize::run(arguments, call),
        Command::Export(arguments) => export::run(arguments, call),
        Command::Import(arguments) => import::run(arguments),
        Command::Man(arguments) => man::run(arguments, self::command()),
        Command::Docs(arguments) => docs::run(arguments),
        Command::Completions(arguments) => completions::run(arguments, &mut Cli::command()),
    }
}

/// Prints what came of a command, and gives the exit status.
fn finish(result: Result<Done, Failure>) -> u8 {
    match result {
        Ok(done) => match print(&done.text) {
            Ok(()) => u8::from(!done.satisfied),
            Err(error) => not_printed(&error),
        },
        Err(Failure::Input(errors)) => {
            for error in &errors {
                tell_on!("{error}");
            }
            let mistakes: usize = errors.iter().map(|e| e.problems.len()).sum();
            tell!("{mistakes} {} in {} {}", plural(mistakes, "mistake"), errors.len(), plural(errors.len(), "file"));
            2
        }
        Err(Failure::Argument(message)) => {
            tell!("error: {message}");
            2
        }
        Err(Failure::Interrupted(message)) => {
            tell!("{message}");
            130
        }
    }
}

/// The width of tables and paragraphs: `COLUMNS`, else the terminal's, else the same everywhere.
fn width() -> usize {
    let out = console::Term::stdout();
    // `size` has the usual 80 for a terminal that does not tell its size.
    let terminal = out.is_term().then(|| usize::from(out.size().1));
    table::decide(std::env::var("COLUMNS").ok().as_deref(), terminal)
}

/// Whether results have colours: on a terminal that has them, unless `NO_COLOR` or `CLICOLOR=0` forbids it;
/// `CLICOLOR_FORCE` brings them into a pipe, too.
fn has_colour() -> bool {
    let says = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let is_zero = |name: &str| says(name).is_some_and(|value| value == "0");
    let is_able = console::Term::stdout().is_term() && says("TERM").is_none_or(|term| term != "dumb");
    let is_forced = says("CLICOLOR_FORCE").is_some() && !is_zero("CLICOLOR_FORCE");
    says("NO_COLOR").is_none() && (is_forced || is_able && !is_zero("CLICOLOR"))
}

fn plural(count: usize, word: &str) -> String {
    if count == 1 { word.into() } else { format!("{word}s") }
}

/// Says something on stderr. Where stderr cannot be written, the work goes on.
fn say(said: std::fmt::Arguments, end: &str) {
    let _ = write!(std::io::stderr().lock(), "{}{end}", tame(&said.to_string()));
}

fn not_printed(error: &std::io::Error) -> u8 {
    tell!("error: cannot write the result: {}", crate::words::reason(error));
    2
}

/// Writes to stdout, names from files included, which may not drive the terminal; a reader that has seen enough and closed the pipe is no error.
fn print(text: &str) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(tint::printed(tame(text)).as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}
