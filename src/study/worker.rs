//! One robot of a study: read, optimised, put into a record.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use serde::{Deserialize, Serialize};

use super::columns;
use super::grid::Grid;
use super::plan::Settings;
use crate::actuator::estimate::completed_module;
use crate::catalog::{Catalog, Module, Motor};
use crate::design::answer::{JointResult, Says};
use crate::design::balance::balanced;
use crate::design::loads::Loads;

use crate::design::optimize::optimize_with;
use crate::design::options::Options;
use crate::design::options::Stopped;
use crate::design::robot::{self, Choice, NoChoice};
use crate::design::windings;
use crate::input::{Change, InputError, Problem, Source};
use crate::motion::CarriedColumn;
use crate::requirement::{self, Joint, Motion, Motions, Robot};

/// What was found for one robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its number.
    pub robot: u64,
    /// Its name; blank where it could not be read.
    pub name: String,
    /// Every file that was read for it, with its SHA-256.
    pub inputs: Files,
    /// Its joints.
    pub joints: Vec<JointRecord>,
    /// Whether a combination was found that keeps all of it; nothing where each joint is chosen by itself.
    #[serde(default)]
    pub combined: Option<bool>,
    /// Why it could not be worked on.
    pub broken: Option<Broken>,
}

/// What was found for one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointRecord {
    /// Its name.
    pub name: String,
    /// What is known of each motor of the catalogue, then of each module, one letter each: see [`Standing`]. Behind the last letter
    /// nothing is known.
    pub motors: String,
    /// Its rows of the results.
    pub rows: Vec<Vec<String>>,
}

/// Why a robot could not be worked on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Broken {
    /// The first mistake with its place, in one line.
    pub first: String,
    /// How many mistakes there are.
    pub mistakes: u64,
    /// The whole report.
    pub report: String,
}

/// What is known of a motor at a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// It is the first choice.
    First,
    /// It is among those asked for.
    Among,
    /// It can do it, but stands behind them.
    Behind,
    /// It cannot do it.
    Cannot,
    /// It cannot be among those asked for; whether it can do it was not asked.
    Unknown,
    /// A limit that the requirement states cannot be judged of it.
    Unjudged,
}

impl Standing {
    /// Every standing with its letter in a record.
    pub const LETTERS: [(Standing, char); 6] = [
        (Standing::First, '1'),
        (Standing::Among, 'a'),
        (Standing::Behind, 'b'),
        (Standing::Cannot, 'x'),
        (Standing::Unknown, '?'),
        (Standing::Unjudged, 'u'),
    ];

    /// The standing of a letter.
    pub fn of(letter: char) -> Option<Standing> {
        Standing::LETTERS.iter().find(|(_, l)| *l == letter).map(|(s, _)| *s)
    }

    fn letter(self) -> char {
        Standing::LETTERS.iter().find(|(s, _)| *s == self).map_or('?', |(_, l)| *l)
    }
}

/// Each file that was read, with its SHA-256.
pub type Files = Vec<(String, String)>;

/// A motion's file, whether it is periodic, and the bits of its period.
type MotionKey = (PathBuf, bool, Option<u64>, Vec<String>);

/// A motion with its columns of torque per mass.
type Kept = (Arc<Motion>, Vec<CarriedColumn>);

/// Files and motions that were read before, for robots that share them. Bounded: when it is full it is
/// emptied.
#[derive(Debug, Default)]
pub struct Store {
    files: Mutex<HashMap<PathBuf, (Arc<Source>, String)>>,
    motions: Mutex<HashMap<MotionKey, Kept>>,
    loads: Loads,
}

/// Most files, and most motions, that are kept.
const KEPT: usize = 256;

impl Store {
    /// The store as a source of motions; paths are told from `base`.
    pub fn reading<'s>(&'s self, base: &'s Path) -> impl Motions + 's {
        Reading { store: self, base, inputs: BTreeMap::new() }
    }

    /// Whether a file was read before.
    pub fn knows(&self, path: &Path) -> bool {
        self.files.lock().expect("no thread panicked").contains_key(path)
    }

    /// A file with its SHA-256.
    fn open(&self, path: &Path) -> Result<(Arc<Source>, String), InputError> {
        if let Some(found) = self.files.lock().expect("no thread panicked").get(path) {
            return Ok(found.clone());
        }
        let source = Source::read(path)?;
        let found = (source.clone(), source.sha256());
        let mut files = self.files.lock().expect("no thread panicked");
        if files.len() >= KEPT {
            files.clear();
        }
        // Whoever was first counts: a file that changes meanwhile is one file for all.
        Ok(files.entry(path.to_path_buf()).or_insert(found).clone())
    }
}

/// The store as one robot's reading sees it, noting what it took.
struct Reading<'s> {
    store: &'s Store,
    base: &'s Path,
    inputs: BTreeMap<PathBuf, String>,
}

impl Reading<'_> {
    fn note(&mut self, path: &Path, hash: &str) {
        let name = path.strip_prefix(self.base).unwrap_or(path);
        self.inputs.insert(name.to_path_buf(), hash.to_string());
    }
}

impl Motions for Reading<'_> {
    fn open(&mut self, path: &Path) -> Result<Arc<Source>, InputError> {
        let (source, hash) = self.store.open(path)?;
        self.note(path, &hash);
        Ok(source)
    }

    fn motion(
        &mut self,
        source: &Arc<Source>,
        periodic: bool,
        period: Option<f64>,
        joints: &[String],
    ) -> Result<(Arc<Motion>, Vec<CarriedColumn>), InputError> {
        let key = (PathBuf::from(source.name()), periodic, period.map(f64::to_bits), joints.to_vec());
        if let Some(found) = self.store.motions.lock().expect("no thread panicked").get(&key) {
            return Ok(found.clone());
        }
        let (motion, carried) = crate::motion::read_carrying(source, periodic, period, joints)?;
        let mut motions = self.store.motions.lock().expect("no thread panicked");
        if motions.len() >= KEPT {
            motions.clear();
        }
        Ok(motions.entry(key).or_insert((Arc::new(motion), carried)).clone())
    }
}

/// What all robots of a study have in common.
#[derive(Debug)]
pub struct Worker<'a> {
    /// The catalogue.
    pub catalog: &'a Catalog,
    /// Settings.
    pub settings: Settings,
    /// The grid.
    pub grid: &'a Grid,
    /// Where the grid is written: the study file, the command line.
    pub homes: &'a [Arc<Source>],
    /// The folder that requirements' names start from.
    pub base: &'a Path,
    /// Files read before.
    pub store: Store,
}

impl Worker<'_> {
    /// Reads the requirement at a point of the grid, and says which files that took.
    ///
    /// # Errors
    /// Every mistake, each in the file where it was written.
    pub fn read(&self, requirement: &str, point: u64) -> (Result<Robot, Vec<InputError>>, Files) {
        let mut reading = Reading { store: &self.store, base: self.base, inputs: BTreeMap::new() };
        let (changes, scale) = self.grid.at(point);
        let read = self.store.open(&self.base.join(requirement)).map_err(|e| vec![e]).and_then(|(source, hash)| {
            reading.note(Path::new(requirement), &hash);
            requirement::read_scaled(&source, &changes, [scale.torque, scale.speed], &mut reading)
        });
        let robot = read.map_err(|errors| Change::send_home(errors, self.homes));
        let inputs = reading.inputs.into_iter().map(|(path, hash)| (super::plan::path_name(&path), hash)).collect();
        (robot, inputs)
    }

    /// Does the work of one robot; `stop` as that of [`Options`].
    ///
    /// # Errors
    /// It was stopped.
    pub fn work(
        &self,
        robot: u64,
        requirement: &str,
        point: u64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Record, Stopped> {
        let (read, inputs) = self.read(requirement, point);
        let broken = |name: String, broken| Record {
            robot,
            name,
            inputs: inputs.clone(),
            joints: Vec::new(),
            combined: None,
            broken: Some(broken),
        };
        let read = match read {
            Ok(read) => read,
            Err(errors) => return Ok(broken(String::new(), Broken::of(&errors))),
        };
        let refused = |name: &str, message: String| {
            let source = Arc::new(Source::new(requirement, ""));
            let errors = [InputError { source, problems: vec![Problem::whole(message)] }];
            broken(name.to_string(), Broken::of(&errors))
        };
        if let Err(message) = self.can_be_asked(&read) {
            return Ok(refused(&read.name, message));
        }
        let name = read.name.clone();
        let read = match crate::design::families::settled(read, self.catalog) {
            Ok(read) => read,
            Err(message) => return Ok(refused(&name, message)),
        };
        let turns = read.listed_turns();
        let wound = (!turns.is_empty() || read.modules().next().is_some()).then(|| {
            let complete = if self.settings.estimates { completed_module } else { |module| module };
            self.catalog.clone().with_turns(&turns).with_modules(read.modules(), complete)
        });
        let catalog = wound.as_ref().unwrap_or(self.catalog);
        let keep = self.settings.top.map(|k| k as usize);
        let options = Options {
            only_checked: self.settings.only_checked,
            keep,
            reasons: false,
            stop,
            loads: Some(&self.store.loads),
            ..Options::default()
        };
        let mut read = balanced(&read, catalog, options)?;
        let catalog = match windings::wind(&mut read, catalog, options.only_checked) {
            Ok(wound) => wound,
            Err(message) => return Ok(refused(&read.name, message)),
        };
        let (joints, combined) = match read.is_coupled() {
            true => match self.whole(&read, &catalog, stop)? {
                Ok((joints, combined)) => (joints, Some(combined)),
                Err(message) => return Ok(refused(&read.name, message)),
            },
            false => {
                let result = optimize_with(&read, &catalog, options)?;
                let joints = result.joints.iter().map(|joint| JointRecord {
                    name: joint.joint.name.clone(),
                    motors: standings(joint, self.catalog),
                    rows: columns::rows(joint),
                });
                (joints.collect(), None)
            }
        };
        Ok(Record { robot, name: read.name.clone(), inputs, joints, combined, broken: None })
    }

    /// A robot whose joints depend on each other has combinations: as many as designs are asked for.
    fn can_be_asked(&self, robot: &Robot) -> Result<(), String> {
        let phases = self.grid.parameters.iter().find(|parameter| parameter.key.ends_with(".phases"));
        if let Some(parameter) = phases.filter(|_| !robot.is_coupled()) {
            return Err(format!(
                "`{}` of [grid] would change nothing: each joint is chosen by itself, as nothing couples them ([budget] does)",
                parameter.key
            ));
        }
        match self.settings.top {
            None if robot.is_coupled() => {
                Err("its joints depend on each other, and of a whole robot the best combinations are \
                found, not all: give `--top` in place of `--all`"
                    .into())
            }
            _ => Ok(()),
        }
    }

    /// The best combinations of a robot whose joints depend on each other; in words why it cannot be asked.
    fn whole(
        &self,
        robot: &Robot,
        catalog: &Catalog,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Result<(Vec<JointRecord>, bool), String>, Stopped> {
        let options = robot::Options {
            only_checked: self.settings.only_checked,
            runner_ups: self.settings.top.map_or(0, |top| top.saturating_sub(1) as usize),
            budgets: false,
            stop,
            ..robot::Options::default()
        };
        let choice = match robot::choose(robot, catalog, options) {
            Ok(choice) => choice,
            Err(NoChoice::Stopped) => return Err(Stopped),
            Err(NoChoice::Cannot(why)) => return Ok(Err(why)),
        };
        let joint = |(j, joint): (usize, &Joint)| JointRecord {
            name: joint.name.clone(),
            motors: standings_of_robot(&choice, j, self.catalog),
            rows: columns::rows_of_robot(&choice, j),
        };
        Ok(Ok((robot.joints.iter().enumerate().map(joint).collect(), !choice.combinations.is_empty())))
    }
}

/// What is known of every motor at a joint of a whole robot, a letter each.
fn standings_of_robot(choice: &Choice, joint: usize, catalog: &Catalog) -> String {
    let mut standing: HashMap<&str, Standing> = HashMap::new();
    for (place, combination) in choice.combinations.iter().enumerate() {
        let motor = combination.joints[joint].motor.row_id();
        standing.entry(motor).or_insert(if place == 0 { Standing::First } else { Standing::Among });
    }
    let of = &choice.robot.joints[joint];
    for apart in choice.unjudged.iter().filter(|apart| std::ptr::eq(apart.joint, of)) {
        standing.entry(apart.motor.row_id()).or_insert(Standing::Unjudged);
    }
    letters(&standing, catalog, |_| Standing::Unknown, |_| Standing::Unknown)
}

/// The letters of motors and modules, of what is not in a table by what it is there.
fn letters(
    standing: &HashMap<&str, Standing>,
    catalog: &Catalog,
    of_motor: impl Fn(&Motor) -> Standing,
    of_module: impl Fn(&Module) -> Standing,
) -> String {
    let letter = |id: &String, else_: Standing| standing.get(id.as_str()).copied().unwrap_or(else_).letter();
    let motors = catalog.motors.iter().map(|motor| letter(&motor.id, of_motor(motor)));
    let modules = catalog.modules.iter().map(|module| letter(&module.id, of_module(module)));
    let all: String = motors.chain(modules).collect();
    all.trim_end_matches(Standing::Unknown.letter()).to_string()
}

/// What is known of every motor, a letter each: of several windings of one that which does best.
fn standings(joint: &JointResult, catalog: &Catalog) -> String {
    let mut standing: HashMap<&str, Standing> = HashMap::new();
    for (place, design) in joint.candidates.iter().enumerate() {
        standing.entry(design.motor.row_id()).or_insert(if place == 0 { Standing::First } else { Standing::Among });
    }
    for rejected in &joint.rejected {
        let known = rejected.reason.says() != Says::NotKnown;
        let said = if known { Standing::Cannot } else { Standing::Unjudged };
        standing.entry(rejected.motor.row_id()).or_insert(said);
    }
    for unjudged in &joint.unjudged {
        standing.entry(unjudged.motor.row_id()).or_insert(Standing::Unjudged);
    }
    for motor in joint.pruned.iter().flat_map(|p| &p.impossible) {
        standing.entry(motor.row_id()).or_insert(Standing::Cannot);
    }
    for (motor, _) in joint.pruned.iter().flat_map(|p| &p.not_solved) {
        standing.entry(motor.row_id()).or_insert(Standing::Unknown);
    }
    // What was solved, can do it and is not listed stands behind; what the joint does not ask for was not.
    let behind = |asked: bool| if asked { Standing::Behind } else { Standing::Unknown };
    let asked = &joint.joint.motors;
    letters(&standing, catalog, |_| behind(!asked.only_modules), |module| behind(asked.takes(module)))
}

impl Broken {
    fn of(errors: &[InputError]) -> Broken {
        let first = errors.first().and_then(|e| {
            let problem = e.problems.first()?;
            let place = problem.span.as_ref().map_or_else(String::new, |s| {
                let (line, column) = e.source.position(s.start);
                format!(":{line}:{column}")
            });
            let help = problem.help.as_ref().map_or_else(String::new, |h| format!("; {h}"));
            Some(format!("{}{place}: {}{help}", e.source.name(), problem.message))
        });
        let report: String = errors.iter().map(ToString::to_string).collect();
        let mistakes = errors.iter().map(|e| e.problems.len() as u64).sum();
        Broken { first: first.unwrap_or_default(), mistakes, report }
    }
}
