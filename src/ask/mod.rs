//! What is asked of gearwise, and the answer with all its forms: the command line and other front ends ask here.
//!
//! The one idea: an answer owns what it speaks of (the robot, the catalogue), so that it can be kept, handed to another
//! thread and looked at later. A form (JSON, CSV, text, page, picture) is made when somebody wants it, never before. One
//! file for each question.

pub mod actuator_map;
pub mod audit;
pub mod characterize;
pub mod check;
pub mod chosen;
pub mod compare;
pub mod evaluate;
pub mod explain;
pub mod export;
pub mod identify;
pub mod optimize;
pub mod pareto;
pub mod rank;
pub mod robust;
pub mod rows;
pub mod sweep;
pub mod written;

use std::fmt;
use std::sync::Arc;

use serde_json::Value;

use crate::catalog::Catalog;
use crate::design::options::{Options, Stopped};
use crate::design::robot::{self, NoChoice};
use crate::input::{InputError, InputFile};
use crate::report::html::Page;
use crate::report::plot::Figure;
use crate::report::{table, tint};
use crate::requirement::Robot;
pub use rows::Rows;

/// Why there is no answer.
#[derive(Debug, Clone)]
pub enum Failure {
    /// Mistakes in what was read.
    Input(Vec<InputError>),
    /// A mistake in what was asked for, in words.
    Argument(String),
    /// It was stopped: what became of the work.
    Interrupted(String),
}

impl From<Vec<InputError>> for Failure {
    fn from(errors: Vec<InputError>) -> Failure {
        Failure::Input(errors)
    }
}

impl From<Stopped> for Failure {
    fn from(_: Stopped) -> Failure {
        Failure::Interrupted("stopped".into())
    }
}

impl From<NoChoice> for Failure {
    fn from(why: NoChoice) -> Failure {
        match why {
            NoChoice::Stopped => Stopped.into(),
            NoChoice::Cannot(why) => Failure::Argument(why),
        }
    }
}

/// An answer, in every form that it has.
pub trait Answer: Send + Sync {
    /// Whether what was asked is satisfied: what the exit status of the command says.
    fn is_satisfied(&self) -> bool;
    /// What `--json` prints.
    fn json(&self) -> Value;
    /// What `--csv` prints: the answer as a table.
    fn csv(&self) -> String;
    /// What the command prints for people.
    fn text(&self) -> String;
    /// The page of `--html`, without how it was called and what it rests on.
    fn page(&self) -> Page;
    /// The picture of `--plot`, where it has one.
    fn figure(&self) -> Option<Figure>;
    /// What the command says beside the answer, on stderr.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }
    /// The files that it rests on.
    fn files(&self) -> Vec<InputFile>;

    /// The page with what it rests on.
    fn whole_page(&self, call: &str) -> Page {
        let mut inputs = self.files();
        inputs.sort();
        inputs.dedup();
        Page { call: call.to_string(), inputs, ..self.page() }
    }

    /// The text of `--json`, to the byte.
    fn json_text(&self) -> String {
        crate::report::json_text(&self.json())
    }

    /// The text of `--csv`, to the byte.
    fn csv_text(&self) -> String {
        tint::set_on(false);
        self.csv()
    }
}

/// Who looks on while something is worked out.
pub struct Watch {
    /// Called for each step that is done: a motor at a joint.
    pub tick: Box<dyn Fn() + Send + Sync>,
    /// Asked often; once it says `true` the work ends without an answer.
    pub stop: Box<dyn Fn() -> bool + Send + Sync>,
    /// Called for each joint of a whole robot that is made ready.
    pub joint: Box<dyn Fn() + Send + Sync>,
    /// Called at each branch of the search over a whole robot, as [`robot::Options::searched`].
    pub searched: Box<dyn Fn(usize, usize) + Send + Sync>,
    /// When the search over a whole robot gives what it has; `None` for its fixed number of steps.
    pub enough: Option<Box<dyn Fn() -> bool + Send + Sync>>,
}

impl Default for Watch {
    fn default() -> Watch {
        Watch {
            tick: Box::new(|| ()),
            stop: Box::new(|| false),
            joint: Box::new(|| ()),
            searched: Box::new(|_, _| ()),
            enough: None,
        }
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Watch")
    }
}

impl Watch {
    /// Options of a search that is watched.
    pub(crate) fn options(&self, only_checked: bool) -> Options<'_> {
        Options { only_checked, tick: &*self.tick, stop: &*self.stop, ..Options::default() }
    }

    /// Options of a search over a whole robot that is watched.
    pub(crate) fn of_robot(&self, only_checked: bool, runner_ups: usize) -> robot::Options<'_> {
        robot::Options {
            only_checked,
            runner_ups,
            tick: &*self.joint,
            searched: &*self.searched,
            stop: &*self.stop,
            enough: self.enough.as_deref().map(|enough| enough as &(dyn Fn() -> bool + Sync)),
            ..robot::Options::default()
        }
    }
}

/// What an answer stands on.
#[derive(Debug)]
pub struct Ground {
    /// The robot, made ready.
    pub robot: Robot,
    /// The catalogue that was chosen from.
    pub catalog: Arc<Catalog>,
    /// Who looked on.
    pub watch: Watch,
}

impl Ground {
    /// The files of both.
    fn files(&self) -> Vec<InputFile> {
        [self.robot.files(), self.catalog.files()].concat()
    }

    /// What was put in the place of the requirement's own values, as a line of text; nothing where nothing was.
    pub(crate) fn told_set(&self) -> String {
        told_set(&self.robot)
    }
}

/// What was put in the place of a requirement's own values, as a line of text; nothing where nothing was.
pub(crate) fn told_set(robot: &Robot) -> String {
    if robot.set.is_empty() {
        return String::new();
    }
    let set: Vec<String> = robot.set.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    table::paragraph(&format!("Set: {}", set.join(", ")), 0, 2)
}

/// The robot with the balanced objectives that its joints ask for.
pub(crate) fn balanced(robot: &Robot, catalog: &Catalog, options: Options) -> Result<Robot, Failure> {
    Ok(crate::design::balance::balanced(robot, catalog, options)?)
}

/// The robot made ready for the catalogue, every pattern of which names a motor, a gear or a family of it.
pub(crate) fn settled(robot: Robot, catalog: &Catalog) -> Result<Robot, Failure> {
    crate::design::families::settled(robot, catalog).map_err(Failure::Argument)
}

/// A robot made ready for a catalogue: its patterns looked up, and its objectives balanced.
///
/// # Errors
/// Patterns that name nothing.
pub fn ready(robot: Robot, catalog: &Catalog) -> Result<Robot, Failure> {
    let robot = settled(robot, catalog)?;
    balanced(&robot, catalog, Options::default())
}

/// What is said of a robot whose joints are coupled, where each is taken by itself.
fn alone(robot: &Robot) -> Vec<String> {
    let said = "each joint is taken by itself here: budgets and `torque_per_mass` are not looked at";
    robot.is_coupled().then(|| said.to_string()).into_iter().collect()
}
