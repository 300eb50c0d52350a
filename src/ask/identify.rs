//! Bench logs against the declared model.

use std::path::Path;

use self_cell::self_cell;
use serde_json::Value;

use super::{Answer, Failure, balanced, settled, told_set};
use crate::actuator::estimate::complete;
use crate::catalog::fitted::Fitted;
use crate::design::options::Options;
use crate::design::remake::{Remade, remake};
use crate::input::InputFile;
use crate::measured::bench::Bench;
use crate::measured::fitted::fitted_actuator;
use crate::measured::identify::plan::{self, NoPlan, Plan, Wanted};
use crate::measured::identify::{self, Report};
use crate::measured::robot::{self, JointReport, RobotBench, RobotReport, Subject};
use crate::measured::simulate::{self, ForwardCheck};
use crate::report::html::Page;
use crate::report::identify::robot as robot_report;
use crate::report::plot::{Figure, residual};
use crate::report::table::paragraph;
use crate::report::{forward, html, identify as report, json, number, plan as plan_report, remake as remake_report};
use crate::requirement::Robot;

/// What is asked of the logs.
#[derive(Debug, Default)]
pub struct Asked {
    /// Cut-off of the filter that everything goes through \[Hz\]; `None` to choose it from the data.
    pub band: Option<f64>,
    /// Of a bench of a whole robot, the joint that all is said of; `None` for all of them.
    pub joint: Option<String>,
    /// The requirement whose choice is made again.
    pub requirement: Option<Robot>,
    /// The run that is planned.
    pub plan: Option<Wanted>,
}

/// The logs of one actuator, and the requirement.
#[derive(Debug)]
struct Measured {
    bench: Bench,
    reports: Vec<Report>,
    actuator: Option<Fitted>,
    robot: Option<Robot>,
    /// The masses of the robot that the actuator is of, in words.
    masses: Option<String>,
    forward: Option<ForwardCheck>,
    planned: Option<Result<Plan, NoPlan>>,
}

type Again<'a> = Option<Vec<Remade<'a>>>;

self_cell!(
    struct Cell {
        owner: Measured,
        #[covariant]
        dependent: Again,
    }
    impl {Debug}
);

/// What the logs of one actuator say.
#[derive(Debug)]
pub struct OfActuator {
    cell: Cell,
}

/// What the logs of the joints of a robot say.
#[derive(Debug)]
pub struct OfRobot {
    /// The bench.
    pub bench: RobotBench,
    /// What they say.
    pub report: RobotReport,
}

/// What logs say.
#[derive(Debug)]
pub enum Identified {
    /// Of one actuator.
    Actuator(Box<OfActuator>),
    /// Of all joints of a robot.
    Robot(Box<OfRobot>),
}

/// Identifies; `path` is the bench file, as it is named in messages.
///
/// # Errors
/// Why the logs say nothing, and what does not go together.
pub fn identify(subject: Subject, asked: Asked, path: &Path) -> Result<Identified, Failure> {
    let options = identify::Options { band: asked.band };
    let failed = |why: String| Failure::Argument(format!("{}: {why}", path.display()));
    let mut masses = None;
    let (bench, identified) = match subject {
        Subject::Robot(robot) => {
            let joint = asked.joint.as_deref().map(|name| joint_of(&robot, name)).transpose()?;
            let mut report = robot::identify(&robot, &options, joint).map_err(failed)?;
            if joint.is_none() {
                return Ok(Identified::Robot(Box::new(OfRobot { bench: *robot, report })));
            }
            let Some(JointReport { bench, identified, .. }) = report.joints.pop() else {
                return Err(failed("the joint has no report".into()));
            };
            masses = Some(robot_report::payload(&robot, &report.payload));
            (bench, identified.map_err(failed)?)
        }
        Subject::Actuator(_) if asked.joint.is_some() => {
            return Err(Failure::Argument("`--joint` is of a bench file of a whole robot, with [mechanism]".into()));
        }
        Subject::Actuator(bench) => {
            let identified = identify::identified(&bench, &options).map_err(failed)?;
            (*bench, identified)
        }
    };
    let planned = asked.plan.as_ref().map(|wanted| plan::plan(&bench, &identified, wanted));
    if let Some(Err(NoPlan::TooShort(shortest))) = &planned {
        return Err(Failure::Argument(format!("a planned run takes {} s at least", number(*shortest))));
    }
    let reports: Vec<Report> = identified.into_iter().map(|i| i.report).collect();
    // One actuator: the choice is made again with what the file says.
    let actuator = fitted_actuator(&bench, &reports);
    // The balanced objective is that of the catalogue as one chooses from it.
    let robot = match asked.requirement {
        Some(robot) if robot.has_range_of_turns() => {
            let why = "`--requirement`: a range of `turns` is not combined with a fitted motor, which has those of its log; give a list, as in turns = [1, 0.5]";
            return Err(Failure::Argument(why.into()));
        }
        Some(robot) => {
            let robot = settled(robot, &bench.catalog)?;
            let catalog = complete(bench.catalog.clone().free(false));
            Some(balanced(&robot, &catalog, Options::default())?)
        }
        None => None,
    };
    let forward = reports.iter().find_map(|report| simulate::forward_check(&bench, report));
    let measured = Measured { bench, reports, actuator, robot, masses, forward, planned };
    let cell = Cell::try_new(measured, |Measured { bench, actuator, robot, .. }| {
        let Some(robot) = robot else { return Ok(None) };
        let (Some(declared), Some(Fitted::Motor(motor))) = (&bench.declared.motor, actuator) else {
            let why = "`--requirement`: a linear axis has no motor of the catalogue to choose again";
            return Err(Failure::Argument(why.into()));
        };
        Ok(Some(remake(robot, &bench.catalog, &declared.id, motor)))
    })?;
    Ok(Identified::Actuator(Box::new(OfActuator { cell })))
}

/// The joint of this name, with its actuator.
fn joint_of(robot: &RobotBench, name: &str) -> Result<usize, Failure> {
    let found = robot.joints.iter().position(|j| j.name == *name && j.declared.is_some());
    found.ok_or_else(|| {
        let why = format!("`--joint {name}`: the joints with an actuator are {}", with_actuator(robot).join(", "));
        Failure::Argument(why)
    })
}

/// The names of the joints with an actuator.
pub fn with_actuator(robot: &RobotBench) -> Vec<&str> {
    robot.joints.iter().filter(|j| j.declared.is_some()).map(|j| j.name.as_str()).collect()
}

impl OfActuator {
    /// The bench.
    pub fn bench(&self) -> &Bench {
        &self.cell.borrow_owner().bench
    }

    /// What each of its equations says.
    pub fn reports(&self) -> &[Report] {
        &self.cell.borrow_owner().reports
    }

    /// The row with what was fitted, where they make one.
    pub fn actuator(&self) -> Option<&Fitted> {
        self.cell.borrow_owner().actuator.as_ref()
    }

    /// The planned run, where one was asked for.
    pub fn planned(&self) -> Option<&Result<Plan, NoPlan>> {
        self.cell.borrow_owner().planned.as_ref()
    }

    fn remade(&self) -> Option<&[Remade<'_>]> {
        self.cell.borrow_dependent().as_deref()
    }

    /// The text, with where something was written; `plan` is the file of the planned run.
    pub fn text_of(&self, written: &[String], plan: Option<&Path>) -> String {
        let Measured { bench, reports, robot, masses, forward, planned, .. } = self.cell.borrow_owner();
        let set = robot.as_ref().map_or_else(String::new, told_set);
        let choice = self.remade().map(|remade| set + &remake_report::text(remade));
        let next = planned.as_ref().zip(plan).map(|(plan, path)| plan_report::text(bench, plan, path));
        let parts = [
            masses.as_ref().map(|said| paragraph(said, 0, 2)),
            Some(report::text(bench, reports, written)),
            next,
            forward.as_ref().map(forward::text),
            choice,
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join("\n")
    }

    /// The JSON; `plan` is the file of the planned run.
    pub fn json_of(&self, plan: Option<&Path>) -> Value {
        let Measured { bench, reports, forward, planned, .. } = self.cell.borrow_owner();
        let next = planned.as_ref().zip(plan).map(|(plan, path)| {
            let file = plan.is_ok().then(|| path.display().to_string());
            json::identify::Planned::new(bench, plan, file)
        });
        json::identify::json(bench, reports, forward.as_ref(), self.remade(), next)
    }
}

impl Answer for OfActuator {
    fn is_satisfied(&self) -> bool {
        self.planned().is_none_or(plan_report::is_satisfied) && report::is_learnt(self.reports())
    }

    fn json(&self) -> Value {
        self.json_of(None)
    }

    fn csv(&self) -> String {
        report::csv(self.bench(), self.reports())
    }

    fn text(&self) -> String {
        self.text_of(&[], None)
    }

    fn page(&self) -> Page {
        let Measured { bench, reports, forward, .. } = self.cell.borrow_owner();
        html::identify::page(bench, reports, forward.as_ref(), self.remade())
    }

    fn figure(&self) -> Option<Figure> {
        Some(residual::figure(self.bench(), self.reports()))
    }

    fn files(&self) -> Vec<InputFile> {
        let Measured { bench, robot, .. } = self.cell.borrow_owner();
        [bench.files.clone(), robot.as_ref().map(|r| r.files()).unwrap_or_default()].concat()
    }
}

impl Answer for OfRobot {
    fn is_satisfied(&self) -> bool {
        let said = robot_report::Said::new(&self.report);
        said.joints().any(|(_, reports)| reports.as_ref().is_ok_and(|reports| report::is_learnt(reports)))
    }

    fn json(&self) -> Value {
        json::identify_robot::json(&self.bench, &robot_report::Said::new(&self.report))
    }

    fn csv(&self) -> String {
        robot_report::csv(&self.bench, &robot_report::Said::new(&self.report))
    }

    fn text(&self) -> String {
        robot_report::text(&self.bench, &robot_report::Said::new(&self.report))
    }

    fn page(&self) -> Page {
        html::identify_robot::page(&self.bench, &robot_report::Said::new(&self.report))
    }

    fn figure(&self) -> Option<Figure> {
        None
    }

    fn files(&self) -> Vec<InputFile> {
        self.bench.files.clone()
    }
}
