use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::Args;

use super::progress::Telling;
use super::{Call, CatalogChoice, Done, Failure, Html, Set};
use crate::catalog::Catalog;
use crate::input::Source;
use crate::report::number;
use crate::study::assemble::{Shards, assemble};
use crate::study::file::{StudyFile, is_study_file, read};
use crate::study::grid::{Grid, Parameter};
use crate::study::journal::Journal;
use crate::study::output;
use crate::study::plan::{Hashed, Inputs};
use crate::study::run::{Existing, Study, Watch, prepare, run as work};
use crate::study::text as report;
use crate::study::worker::Broken;
use crate::study::{Settings, Shard, StudyError, Summary, page};

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

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Failure {
        match error {
            StudyError::Input(errors) => Failure::Input(errors),
            StudyError::Argument(message) => Failure::Argument(message),
            StudyError::Stopped { done, of } => Failure::Interrupted(format!(
                "stopped: {done} of {of} robots are finished and kept; the same command with `--resume` goes on"
            )),
        }
    }
}

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
    let file = study_file(&arguments.paths)?;
    let (mut inputs, catalog_paths) = match &file {
        Some(file) => {
            if !arguments.catalog.paths().is_empty() && !file.catalog.is_empty() {
                return Err(Failure::Argument("the study file names its catalogue; leave `--catalog` out".into()));
            }
            let base = file.source.folder().to_path_buf();
            let inputs = Inputs { base, paths: file.requirements.clone(), grid: file.grid.clone() };
            let named = if file.catalog.is_empty() { arguments.catalog.paths() } else { file.catalog.clone() };
            (inputs, named)
        }
        None => {
            let text = |path: &PathBuf| {
                let text = path.to_str().map(String::from);
                text.ok_or_else(|| Failure::Argument(format!("`{}` is not UTF-8", path.display())))
            };
            let paths = arguments.paths.iter().map(text).collect::<Result<_, _>>()?;
            (Inputs { base: PathBuf::new(), paths, grid: Grid::default() }, arguments.catalog.paths())
        }
    };
    let homes = set(&arguments.set, file.as_ref(), &mut inputs.grid)?;
    let (catalog, catalog_files) = catalog(&arguments.catalog, &catalog_paths)?;
    let study = Study {
        inputs: &inputs,
        file: file.as_ref().map(|f| &f.source),
        homes: &homes,
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
        let broken = broken_of(&journal)?;
        let text = format!("shard {shard}: {} finished, {broken} of them could not be worked on\n", in_words(robots));
        return Ok(Done { text, satisfied: broken == 0 });
    }
    let shards = Shards::whole(journal);
    let summary = assemble(&shards, out)?;
    page_of(&arguments.html, call, out, &summary)?;
    if summary.broken == 0 {
        Journal::remove(out)?;
    } else {
        let them = in_words(summary.broken);
        tell!(
            "{them} could not be worked on, see `{}`; fix them, and `--resume` does those again and keeps the rest",
            out.join("errors.csv").display()
        );
    }
    Ok(told(arguments, &summary))
}

/// What is set for every robot: parameters of the grid with one value each, so that plan and results have them. Gives the texts
/// that the grid is written in.
fn set(set: &Set, file: Option<&StudyFile>, grid: &mut Grid) -> Result<Vec<Arc<Source>>, Failure> {
    let settings = set.settings()?;
    settings.check_factors()?;
    let mut homes: Vec<Arc<Source>> = file.map(|f| f.source.clone()).into_iter().collect();
    let (changes, written) = settings.parts();
    let mut parameters = std::mem::take(&mut grid.parameters);
    for change in changes {
        let key = change.key();
        if parameters.iter().any(|p| p.key == key) {
            return Err(Failure::Argument(format!("`--set {key}`: the grid of the study has values for it already")));
        }
        parameters.push(Parameter::new(key.to_string(), vec![change.clone().written_after(homes.len())]));
    }
    homes.extend(written.iter().cloned());
    *grid = Grid::new(parameters).map_err(Failure::Argument)?;
    Ok(homes)
}

fn told(arguments: &Arguments, summary: &crate::study::Summary) -> Done {
    let text = if arguments.json { report::json_text(summary) } else { written(&arguments.out, report::text(summary)) };
    Done { text, satisfied: summary.broken == 0 }
}

/// How many robots.
fn in_words(robots: u64) -> String {
    if robots == 1 { "1 robot".into() } else { format!("{robots} robots") }
}

/// The summary with where the results are.
pub(super) fn written(out: &Path, text: String) -> String {
    let parquet = if cfg!(feature = "parquet") { ", results.parquet" } else { "" };
    let files = format!(
        "In {}: results.csv{parquet}, summary.json, summary.svg, inputs.csv, errors.csv, manifest.json",
        out.display()
    );
    format!("{text}\n{}", crate::report::table::paragraph(&files, 0, 2))
}

/// Writes the page of a finished study, where one is asked for.
pub(super) fn page_of(html: &Html, call: &Call, out: &Path, summary: &Summary) -> Result<(), Failure> {
    if !html.is_asked() {
        return Ok(());
    }
    let manifest = output::read_manifest(out)?;
    let Some(manifest) = manifest else {
        return Err(Failure::Argument(format!("`{}` has no finished study", out.display())));
    };
    let page = page::page(out, summary, &manifest)?;
    html.write(call, || page::inputs(&manifest), || page)
}

/// The results are there, of this very study.
fn finished_before(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    tell!("the study in `{}` is finished already", arguments.out.display());
    // A journal is kept where robots are broken, so here none is.
    let path = arguments.out.join("summary.json");
    let text = std::fs::read_to_string(&path)
        .map_err(|e| Failure::Argument(format!("cannot read `{}`: {e}", path.display())))?;
    if arguments.html.is_asked() {
        let summary: Summary = serde_json::from_str(&text).map_err(|_| {
            Failure::Argument(format!("`{}` is not the summary of a study of this version", path.display()))
        })?;
        page_of(&arguments.html, call, &arguments.out, &summary)?;
    }
    let manifest = output::read_manifest(&arguments.out)?;
    let satisfied = manifest.as_ref().is_some_and(|m| m.broken == 0);
    let robots = manifest.map_or(0, |m| m.plan.robots);
    let text = if arguments.json { text } else { written(&arguments.out, format!("{}\n", in_words(robots))) };
    Ok(Done { text, satisfied })
}

fn broken_of(journal: &Journal) -> Result<u64, Failure> {
    let mut broken = 0;
    for block in (0..journal.plan.blocks()).filter(|b| journal.shard.has(*b)) {
        broken += journal.read(block)?.iter().filter(|r| r.broken.is_some()).count() as u64;
    }
    Ok(broken)
}

/// The study file, where the one path is one.
fn study_file(paths: &[PathBuf]) -> Result<Option<StudyFile>, Failure> {
    let [path] = paths else { return Ok(None) };
    // A pattern, or nothing. What is there and is no file is refused by the reader.
    let stdin = path.as_os_str() == Source::STDIN;
    if !stdin && (path.is_dir() || path.symlink_metadata().is_err()) {
        return Ok(None);
    }
    let source: Arc<Source> = Source::argument(path).map_err(|e| vec![e])?;
    if !is_study_file(&source) {
        if stdin {
            let why = "a study notes the names of its requirements: what comes from `-` can be a study file only";
            return Err(Failure::Argument(why.into()));
        }
        return Ok(None);
    }
    Ok(Some(read(&source).map_err(|e| vec![e])?))
}

/// The catalogue with the hashes of its files.
fn catalog(choice: &CatalogChoice, paths: &[PathBuf]) -> Result<(Catalog, Vec<Hashed>), Failure> {
    let sources = match paths {
        [] => Catalog::builtin_sources(),
        paths => Catalog::sources(paths).map_err(|(_, errors)| errors)?,
    };
    let files = sources.iter().map(|s| Hashed { file: s.name().to_string(), sha256: s.sha256() }).collect();
    let catalog = choice.prepared(Catalog::from_sources(sources)?).into_catalog();
    if catalog.motors.is_empty() && catalog.modules.is_empty() {
        return Err(Failure::Argument("the catalogue has no motors and no modules".into()));
    }
    Ok((catalog, files))
}

/// Runs the study, with progress on stderr; Ctrl-C stops it, a second one at once.
fn watched(arguments: &Arguments, study: &Study, journal: &Journal) -> Result<u64, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let handler = stop.clone();
    let _ = ctrlc::set_handler(move || {
        if handler.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
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
