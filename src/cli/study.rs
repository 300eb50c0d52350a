use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::Args;

use super::progress::Telling;
use super::signals::Signals;
use super::{Call, CatalogChoice, Done, Failure, Html, Set};
use crate::ask::Answer;
use crate::catalog::Catalog;
use crate::report::number;
use crate::study::answer::{Finished, Part};
use crate::study::asked::{Asked, hashed, some};
use crate::study::journal::Journal;
use crate::study::plan::Hashed;
use crate::study::run::{Existing, Study, Watch, prepare, run as work};
use crate::study::worker::Broken;
use crate::study::{Settings, Shard};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise study requirements/studies/quadruped.toml --out result\n  gearwise study robots/ --out result\n  gearwise study 'robots/**/*.toml' --out result --top 5\n  gearwise study study.toml --out result --resume\n  gearwise study study.toml --out part2 --shard 2/8 && gearwise merge result part*"
)]
pub struct Arguments {
    /// Requirement files, folders or patterns; or one study file (TOML) with a grid of parameters
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Folder for the results
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// How many designs of each joint are written; motors that provably are not among them are not solved
    #[arg(long, value_name = "K", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    top: u32,
    /// Solve every motor, and write every design
    #[arg(long, conflicts_with = "top")]
    all: bool,
    /// Leave out motors whose rows do not say enough to check every limit
    #[arg(long)]
    only_checked: bool,
    /// Go on with the study in the folder, or begin it
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Start again, in place of the study in the folder
    #[arg(long)]
    force: bool,
    /// Only this part of the study, e.g. 2/8; `merge` puts the parts together
    #[arg(long, value_name = "I/N")]
    shard: Option<String>,
    #[command(flatten)]
    telling: Telling,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    catalog: CatalogChoice,
}

/// Broken robots that are reported in full on stderr; all are in errors.csv.
const REPORTED: u64 = 10;
/// Time between two lines of progress, where they are asked for.
const PACE: Duration = Duration::from_secs(2);
/// Lines of progress at most where there is no terminal and nobody asks; none before so much time has passed.
const PARTS: u64 = 50;
const LONG: Duration = Duration::from_secs(5);

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    if arguments.shard.is_some() && arguments.html.is_asked() {
        let why = "a shard is a part of a study and has no page: `gearwise merge --html` writes that of the whole";
        return Err(Failure::Argument(why.into()));
    }
    let shard = match &arguments.shard {
        None => Shard::WHOLE,
        Some(text) => Shard::parse(text).map_err(|e| Failure::Argument(format!("`--shard`: {e}")))?,
    };
    let asked = Asked::of(&arguments.paths)?.set(&arguments.set.settings()?)?;
    let paths = asked.catalog(arguments.catalog.paths())?;
    let (catalog, catalog_files) = catalog(&arguments.catalog, &paths)?;
    let study = Study {
        inputs: &asked.inputs,
        file: asked.file.as_ref().map(|f| &f.source),
        homes: &asked.homes,
        catalog: &catalog,
        catalog_files,
        settings: Settings {
            top: (!arguments.all).then_some(arguments.top),
            only_checked: arguments.only_checked,
            estimates: !arguments.catalog.no_estimates,
        },
        shard,
    };
    let existing = match (arguments.resume, arguments.force) {
        (true, _) => Existing::Resume,
        (_, true) => Existing::Replace,
        _ => Existing::Refuse,
    };
    let out = &arguments.out;
    let Some(journal) = prepare(&study, out, existing)? else { return finished_before(arguments, call) };
    let robots = watched(arguments, &study, &journal)?;
    if arguments.shard.is_some() {
        let part = Part::of(&journal, robots)?;
        return Ok(Done { text: part.text(), satisfied: part.is_satisfied() });
    }
    let finished = Finished::of(journal, out)?;
    page_of(&arguments.html, call, &finished)?;
    for remark in finished.remarks() {
        tell!("{remark}");
    }
    let text = if arguments.json { finished.json_text() } else { finished.text() };
    Ok(Done { text, satisfied: finished.is_satisfied() })
}

/// Writes the page of a finished study, where one is asked for.
pub(super) fn page_of(html: &Html, call: &Call, finished: &Finished) -> Result<(), Failure> {
    if !html.is_asked() {
        return Ok(());
    }
    let page = finished.own_page()?;
    html.write(call, || finished.files(), || page)
}

/// The results are there, of this very study.
fn finished_before(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    let out = &arguments.out;
    tell!("the study in `{}` is finished already", out.display());
    let finished = Finished::there(out)?;
    page_of(&arguments.html, call, &finished)?;
    let text = if arguments.json { finished.json_text() } else { finished.text() };
    Ok(Done { text, satisfied: finished.is_satisfied() })
}

/// The catalogue with the hashes of its files.
fn catalog(choice: &CatalogChoice, paths: &[PathBuf]) -> Result<(Catalog, Vec<Hashed>), Failure> {
    let sources = match paths {
        [] => Catalog::builtin_sources(),
        paths => Catalog::sources(paths).map_err(|(_, errors)| errors)?,
    };
    let files = hashed(&sources);
    Ok((some(choice.prepared(Catalog::from_sources(sources)?))?, files))
}

/// Runs the study, with progress on stderr; Ctrl-C or SIGTERM stops it, a second one at once.
fn watched(arguments: &Arguments, study: &Study, journal: &Journal) -> Result<u64, Failure> {
    let signals = Signals::watch();
    let stop = signals.asked();
    let (done, of, before) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
    let Telling { progress, quiet } = arguments.telling;
    let shows_bar = arguments.telling.bar();
    let bar = if shows_bar { super::bar(0, "robots") } else { indicatif::ProgressBar::hidden() };
    let began = Instant::now();
    let told = std::sync::Mutex::new(began);
    let line = |last: bool| {
        // Without a terminal a long study tells a line for each part of it; a short one ends first.
        let counted = !progress && !quiet && !shows_bar;
        if !progress && !counted {
            return;
        }
        let part = of.load(Ordering::Relaxed).div_ceil(PARTS).max(1);
        if counted && (last || !done.load(Ordering::Relaxed).is_multiple_of(part)) {
            return;
        }
        let Ok(mut told) = told.try_lock() else { return };
        if !last && told.elapsed() < if counted { LONG } else { PACE } {
            return;
        }
        *told = Instant::now();
        let (done, of, before) =
            (done.load(Ordering::Relaxed), of.load(Ordering::Relaxed), before.load(Ordering::Relaxed));
        let rate = (done - before) as f64 / began.elapsed().as_secs_f64().max(1e-3);
        let left = if rate > 0.0 { format!(", {:.0} s left", (of - done) as f64 / rate) } else { String::new() };
        tell!("{done} of {of} robots, {} robots/s{left}", number(rate));
    };
    let reported = AtomicU64::new(0);
    let watch = Watch {
        stop: &stop,
        begin: &|finished, all| {
            done.store(finished, Ordering::Relaxed);
            before.store(finished, Ordering::Relaxed);
            of.store(all, Ordering::Relaxed);
            bar.set_length(all);
            bar.set_position(finished);
            bar.reset_eta();
            if finished > 0 {
                bar.suspend(|| tell!("{finished} of {all} robots were finished before"));
            }
        },
        tick: &|| {
            done.fetch_add(1, Ordering::Relaxed);
            bar.inc(1);
            line(false);
        },
        broken: &|robot, requirement, point, why: &Broken| {
            let count = reported.fetch_add(1, Ordering::Relaxed);
            let at = if point.is_empty() { String::new() } else { format!(" with {point}") };
            bar.suspend(|| match count {
                0..REPORTED => tell_on!("robot {robot}, `{requirement}`{at}:\n{}", why.report),
                REPORTED => tell!("further broken robots are listed in errors.csv only"),
                _ => {}
            });
        },
    };
    let result = work(study, journal, &watch);
    bar.finish_and_clear();
    line(true);
    Ok(result?)
}
