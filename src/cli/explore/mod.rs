//! `gearwise explore`: a page on this machine alone, and who answers it.

mod http;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::Args;
use rayon::ThreadPool;

pub use self::http::head;
use self::http::{Method, Request, Response, Server};
use super::progress::Telling;
use super::signals::Signals;
use super::{Call, CatalogChoice, Done, Failure, Set};
use crate::explore::grid::{self, Axis};
use crate::explore::state::{Ask, Wrong, overlap};
use crate::explore::work::{Next, Work};
use crate::explore::{Explorer, Ground};
use crate::input::Source;
use crate::output::write_whole;
use crate::report::html;
use crate::study::asked::Asked;
use crate::study::file::is_study_file;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise explore requirements/quadruped_mini_cheetah.toml\n  gearwise explore robot.toml --also my_motors.csv\n  gearwise explore robot.toml --state 'bus.voltage=36%20V&joint=knee'\n  gearwise explore robot.toml --static what_if.html --grid 'bus.voltage=24 V,36 V,48 V' --grid scale.torque=1,1.25"
)]
pub struct Arguments {
    /// Requirement file (TOML); with --static also a study file with one requirement and a grid
    requirement: PathBuf,
    /// The state to begin with, as the page's `copy link` gives it: KEY=VALUE, joined by &
    #[arg(long, value_name = "KEY=VALUE&...", conflicts_with = "static_page")]
    state: Option<String>,
    /// The port on 127.0.0.1; 0 is any that is free
    #[arg(long, value_name = "PORT", default_value_t = 0, conflicts_with = "static_page")]
    port: u16,
    /// Write one page that needs no program, with the answers at every point of a grid, and end
    #[arg(long = "static", value_name = "FILE.html")]
    static_page: Option<PathBuf>,
    /// A slider of that page with its values; may be repeated. Without any: five bus voltages and three factors on all torques
    #[arg(long, value_name = "KEY=VALUE,VALUE,...", requires = "static_page")]
    grid: Vec<String>,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    catalog: CatalogChoice,
    #[command(flatten)]
    telling: Telling,
}

/// An answer goes out when the joint that is viewed is done, or when so much time has passed.
const FIRST: Duration = Duration::from_millis(40);
/// So long a page that waits for more hears nothing.
const MORE: Duration = Duration::from_millis(250);

pub fn run(arguments: &Arguments, _: &Call) -> Result<Done, Failure> {
    if let Some(path) = &arguments.static_page {
        html::check(path).map_err(Failure::Argument)?;
    }
    let (requirement, axes) = arguments.asked()?;
    let source = Source::argument(&requirement).map_err(|e| vec![e])?;
    let mut words = vec!["optimize".to_string(), requirement.display().to_string()];
    words.extend(arguments.catalog.words());
    // What is set is told with its place before anything else; then it is the state that the page begins with.
    arguments.set.settings()?.read(&source, None)?;
    arguments.apart()?;
    let ground = Ground { source, begin: arguments.begin(), rows: arguments.catalog.rows()?, words };
    let explorer = Arc::new(Explorer::new(ground, |words| super::call(words.into_iter()))?);
    explorer.check().map_err(|wrong| {
        let all: Vec<String> = wrong.iter().map(|w| format!("`--set {}`: {}", w.key, w.message)).collect();
        Failure::Argument(all.join("; "))
    })?;
    match &arguments.static_page {
        Some(path) => arguments.write(&explorer, axes, path),
        None => arguments.serve(&explorer),
    }
}

impl Arguments {
    /// What is set, as the state of a page.
    fn begin(&self) -> std::collections::BTreeMap<String, String> {
        let pairs = self.set.set.iter().filter_map(|text| text.split_once('='));
        pairs.map(|(key, value)| (key.trim().to_string(), value.trim().to_string())).collect()
    }

    /// That no two values of `--set` are of the same thing: a state has no order in which one would win.
    fn apart(&self) -> Result<(), Failure> {
        let keys: Vec<String> = self.begin().into_keys().collect();
        for (k, key) in keys.iter().enumerate() {
            if let Some(other) = keys[..k].iter().find(|other| overlap(other, key)) {
                return Err(Failure::Argument(format!(
                    "`--set {other}` and `--set {key}` set the same value: give one"
                )));
            }
        }
        Ok(())
    }

    /// The requirement, and the axes of the grid that were asked for.
    fn asked(&self) -> Result<(PathBuf, Vec<Axis>), Failure> {
        let typed: Result<Vec<Axis>, String> = self.grid.iter().map(|text| Axis::read(text)).collect();
        let typed = typed.map_err(Failure::Argument)?;
        let is_study = Source::read(&self.requirement).is_ok_and(|source| is_study_file(&source));
        if !is_study {
            return Ok((self.requirement.clone(), typed));
        }
        if self.static_page.is_none() {
            let message =
                format!("`{}` is a study: give one requirement, or `--static FILE.html`", self.requirement.display());
            return Err(Failure::Argument(message));
        }
        let study = Asked::of(std::slice::from_ref(&self.requirement))?;
        let [only] = study.inputs.paths.as_slice() else {
            let message = format!("`{}` has several requirements: a page is of one", self.requirement.display());
            return Err(Failure::Argument(message));
        };
        let axis = |parameter: &crate::study::grid::Parameter| Axis {
            key: parameter.key.clone(),
            values: (0..parameter.changes.len()).map(|k| parameter.text(k).to_string()).collect(),
        };
        let axes: Vec<Axis> = study.inputs.grid.parameters.iter().map(axis).collect();
        Ok((study.inputs.base.join(only), if typed.is_empty() { axes } else { typed }))
    }

    /// Writes the page that needs no program.
    fn write(&self, explorer: &Explorer, axes: Vec<Axis>, path: &Path) -> Result<Done, Failure> {
        let axes = if axes.is_empty() { Axis::usual(explorer) } else { axes };
        if axes.is_empty() {
            let message = "`--set` gives the usual sliders a value: give others with `--grid KEY=VALUE,VALUE`";
            return Err(Failure::Argument(message.into()));
        }
        super::check_outputs(&self.static_page)?;
        let points = grid::points(&axes).unwrap_or(0);
        let work = self.telling.counted(points.saturating_mul(explorer.robot().joints.len()), "answers");
        let page = grid::page(explorer, &axes, &|| work.step(), &|| false)?;
        work.end();
        write_whole(path, page.as_bytes()).map_err(Failure::Argument)?;
        let sliders: Vec<String> = axes.iter().map(|axis| format!("{} ({})", axis.key, axis.values.len())).collect();
        let size = (page.len() as f64 / 1e5).round() / 10.0;
        Ok(Done { text: format!("{}: {size} MB, sliders: {}\n", path.display(), sliders.join(", ")), satisfied: true })
    }

    /// Serves the page until Ctrl-C or SIGTERM.
    fn serve(&self, explorer: &Arc<Explorer>) -> Result<Done, Failure> {
        let state = self.state.as_deref().unwrap_or_default();
        let asked = Ask::of_link(state).map_err(|why| Failure::Argument(format!("`--state`: {why}")))?;
        if let Some(key) = self.begin().keys().find(|key| asked.state.contains_key(*key)) {
            return Err(Failure::Argument(format!("`{key}` is set by `--set` and by `--state`")));
        }
        let link: Vec<String> =
            [explorer.link(), state.to_string()].into_iter().filter(|part| !part.is_empty()).collect();
        let link = link.join("&");
        for wrong in explorer.left_out(asked) {
            tell!("warning: `--state {}`: {}; it is left out", wrong.key, wrong.message);
        }
        let mut secret = [0_u8; 16];
        getrandom::fill(&mut secret).map_err(|why| Failure::Argument(format!("no random numbers: {why}")))?;
        let token: String = secret.iter().map(|byte| format!("{byte:02x}")).collect();
        let server = Server::bind(self.port, token).map_err(|why| {
            Failure::Argument(format!("cannot listen on 127.0.0.1:{}: {}", self.port, crate::words::reason(&why)))
        })?;
        let threads = rayon::current_num_threads();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|why| Failure::Argument(format!("cannot start {threads} threads: {why}")))?;
        let signals = Signals::watch();
        super::print(&format!("{}\n", server.address())).map_err(|why| Failure::Argument(why.to_string()))?;
        tell!(
            "Open this address in a browser on this machine; Ctrl-C ends it. It is for nobody else: it has a secret in it."
        );
        let host = Host {
            explorer: explorer.clone(),
            pool: Arc::new(pool),
            works: Mutex::default(),
            reports: Mutex::default(),
            link,
            stop: signals.asked(),
        };
        let stop = || signals.have_come();
        server.serve(&|request| host.answer(request), &|| host.leave_silent(), &stop);
        host.leave_all();
        Ok(Done { text: String::new(), satisfied: true })
    }
}

/// A question on its way, and who waits for it.
struct Flying {
    work: Work,
    news: Condvar,
    count: Mutex<u64>,
    /// When its page was last heard.
    heard: Mutex<Instant>,
}

impl Flying {
    fn new(work: Work) -> Flying {
        Flying { work, news: Condvar::new(), count: Mutex::new(0), heard: Mutex::new(Instant::now()) }
    }

    /// Its page is there.
    fn hear(&self) {
        *self.heard.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    /// True if its page has gone: one that waits for more asks again at once.
    fn is_left(&self) -> bool {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner).elapsed() > SILENT
    }
}

/// Who answers the page: brings threads and time to the explorer.
struct Host {
    explorer: Arc<Explorer>,
    pool: Arc<ThreadPool>,
    /// The newest questions, each with its page.
    works: Mutex<Vec<Arc<Flying>>>,
    /// The reports that were made last, each with its name.
    reports: Mutex<Vec<(String, String)>>,
    /// Whether all ends.
    stop: Arc<AtomicBool>,
    /// The state to begin with.
    link: String,
}

/// Reports that are kept.
const REPORTS: usize = 8;
/// Questions that are known at once.
const WORKS: usize = 64;
/// A page that has not been heard for so long has been closed: nobody waits for what it asked.
const SILENT: Duration = Duration::from_secs(30);

impl Host {
    fn answer(&self, request: &Request) -> Response {
        let body = &request.body;
        match (request.method, request.path.as_str()) {
            (Method::Get, "") => {
                let (page, policy) = self.explorer.page(&self.link);
                Response {
                    policy: Some(policy + "; frame-ancestors 'none'"),
                    ..text(200, "text/html; charset=utf-8", page)
                }
            }
            (Method::Get, name) if name.starts_with("report") => {
                let reports = self.reports.lock().unwrap_or_else(PoisonError::into_inner);
                match reports.iter().find(|(own, _)| own == name) {
                    Some((_, page)) => text(200, "text/html; charset=utf-8", page.clone()),
                    None => text(404, PLAIN, "no such report: it is older than the last eight"),
                }
            }
            (Method::Post, "ask") => self.ask(body),
            (Method::Post, "more") => self.more(body),
            (Method::Post, "toml") => match self.pool.install(|| self.explorer.toml(body)) {
                Ok(toml) => text(200, "application/toml; charset=utf-8", toml),
                Err(wrong) => refused(&wrong),
            },
            (Method::Post, "report") => match self.pool.install(|| self.explorer.report(body, self.stopping())) {
                Ok(page) => text(200, PLAIN, self.keep(page)),
                Err(wrong) => refused(&wrong),
            },
            (Method::Post, "fronts") => match self.pool.install(|| self.explorer.fronts(body, self.stopping())) {
                Ok(fragment) => text(200, JSON, fragment.to_string()),
                Err(wrong) => refused(&wrong),
            },
            _ => text(404, PLAIN, "not found"),
        }
    }

    /// Whether all ends, for what takes long.
    fn stopping(&self) -> crate::explore::Stop {
        let stop = self.stop.clone();
        Arc::new(move || stop.load(Ordering::Relaxed))
    }

    /// Keeps a report, and gives its name: a path has letters alone.
    fn keep(&self, page: String) -> String {
        let mut reports = self.reports.lock().unwrap_or_else(PoisonError::into_inner);
        let letters = |name: &str| name["report".len()..].bytes().fold(0_usize, |n, c| 26 * n + usize::from(c - b'a'));
        let mut number = reports.last().map_or(0, |(name, _)| letters(name)) + 1;
        let mut name = Vec::new();
        while number > 0 {
            name.insert(0, char::from(b'a' + (number % 26) as u8));
            number /= 26;
        }
        let name = format!("report{}", name.into_iter().collect::<String>());
        if reports.len() == REPORTS {
            reports.remove(0);
        }
        reports.push((name.clone(), page));
        name
    }

    /// A new question: it is worked on behind this, and what there is after a moment is said.
    fn ask(&self, body: &str) -> Response {
        // Whoever works says so through this, which the work has and which has the work.
        let slot: Arc<Mutex<std::sync::Weak<Flying>>> = Arc::default();
        let of_work = slot.clone();
        let announce = move || {
            let flying = of_work.lock().unwrap_or_else(PoisonError::into_inner).upgrade();
            if let Some(flying) = flying {
                *flying.count.lock().unwrap_or_else(PoisonError::into_inner) += 1;
                flying.news.notify_all();
            }
        };
        let work = match self.explorer.begin(body, Box::new(announce)) {
            Ok(work) => work,
            Err(why) => return text(400, PLAIN, why),
        };
        let flying = Arc::new(Flying::new(work));
        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Arc::downgrade(&flying);
        {
            let mut works = self.works.lock().unwrap_or_else(PoisonError::into_inner);
            works.retain(|other| other.work.ask.tab != flying.work.ask.tab);
            if works.len() == WORKS {
                works.remove(0).work.course.stop();
            }
            works.push(flying.clone());
        }
        let (explorer, worker) = (self.explorer.clone(), flying.clone());
        self.pool.spawn(move || explorer.run(&worker.work));
        next(&flying, 0, FIRST)
    }

    /// Ends the work for pages that have been closed.
    fn leave_silent(&self) {
        let mut works = self.works.lock().unwrap_or_else(PoisonError::into_inner);
        works.retain(|flying| {
            let is_left = flying.is_left();
            if is_left {
                flying.work.course.stop();
            }
            !is_left
        });
    }

    /// Ends all work.
    fn leave_all(&self) {
        let mut works = self.works.lock().unwrap_or_else(PoisonError::into_inner);
        works.drain(..).for_each(|flying| flying.work.course.stop());
    }

    /// What comes after what the page has.
    fn more(&self, body: &str) -> Response {
        #[derive(serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        struct More {
            tab: String,
            ask: u64,
            have: usize,
        }
        let more: More = match serde_json::from_str(body) {
            Ok(more) => more,
            Err(why) => return text(400, PLAIN, format!("the question is not understood: {why}")),
        };
        let works = self.works.lock().unwrap_or_else(PoisonError::into_inner);
        let flying = works.iter().find(|f| f.work.ask.tab == more.tab && f.work.ask.ask == more.ask).cloned();
        drop(works);
        match flying {
            Some(flying) => {
                flying.hear();
                next(&flying, more.have, MORE)
            }
            None => text(204, PLAIN, ""),
        }
    }
}

/// The next reply to a question, or how far it is once so much time has passed.
fn next(flying: &Flying, have: usize, most: Duration) -> Response {
    let end = Instant::now() + most;
    loop {
        let count = flying.count.lock().unwrap_or_else(PoisonError::into_inner);
        match flying.work.next(have) {
            Next::Reply(reply) => return text(200, JSON, reply),
            Next::Nothing => return text(204, PLAIN, ""),
            Next::Broken(what) => return text(500, PLAIN, what),
            Next::Pending(done, of) => {
                let left = end.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    let far = serde_json::json!({ "ask": flying.work.ask.ask, "far": [done, of], "pending": true });
                    return text(200, JSON, far.to_string());
                }
                let waited = flying.news.wait_timeout(count, left);
                drop(waited.unwrap_or_else(PoisonError::into_inner));
            }
        }
    }
}

const PLAIN: &str = "text/plain; charset=utf-8";
const JSON: &str = "application/json";

fn text(status: u16, kind: &'static str, body: impl Into<String>) -> Response {
    Response { status, kind, body: body.into().into_bytes(), policy: None }
}

/// What is wrong with a state.
fn refused(wrong: &[Wrong]) -> Response {
    let one = |w: &Wrong| serde_json::json!({ "key": w.key, "message": w.message, "help": w.help });
    text(200, JSON, serde_json::json!({ "problems": wrong.iter().map(one).collect::<Vec<_>>() }).to_string())
}
