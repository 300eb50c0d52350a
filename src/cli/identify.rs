use std::path::PathBuf;

use clap::Args;

use super::{Call, CatalogPaths, Done, Failure, Html, Output, Set};
use crate::actuator::estimate::complete;
use crate::catalog::fitted::Fitted;
use crate::design::remake::remake;
use crate::measured::fitted::fitted_actuator;
use crate::measured::identify::plan::{self, NoPlan, Wanted};
use crate::measured::robot::{self, JointReport, RobotBench, RobotReport, Subject};
use crate::measured::{identify, read, simulate};
use crate::output;
use crate::report::identify::robot as robot_report;
use crate::report::plot::{self, Format, residual};
use crate::report::table::paragraph;
use crate::report::{
    fitted, forward as forward_report, html, identify as report, json, number, plan as plan_report,
    remake as remake_report,
};
use crate::units;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise identify requirements/bench/leg_actuator.toml\n  gearwise identify bench.toml --plot residual.svg --write fitted.toml\n  gearwise identify bench.toml --requirement robot.toml\n  gearwise identify bench.toml --band \"40 Hz\" --json\n  gearwise identify bench.toml --plan next_run.csv --plan-time \"30 s\"\n\nStructure that no known effect explains is an answer, not a failure: exit status 0."
)]
pub struct Arguments {
    /// Bench file (TOML)
    bench: PathBuf,
    /// Cut-off of the filter that everything goes through; chosen from the data if not given
    #[arg(long, value_name = "FREQUENCY")]
    band: Option<String>,
    /// Of a bench file of a whole robot: show all of this joint; the motion of the others is its load
    #[arg(long, value_name = "NAME")]
    joint: Option<String>,
    /// Draw the residual before and after, against speed, position, current, temperature and time
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    plot: Option<PathBuf>,
    /// Make the choice of this requirement again, with the fitted motor in place of its row
    #[arg(long, value_name = "REQUIREMENT")]
    requirement: Option<PathBuf>,
    /// Write the fitted actuator, to be used in place of a catalogue row
    #[arg(long, value_name = "FITTED.toml")]
    write: Option<PathBuf>,
    /// Plan the run that separates what these logs do not, within the limits of the declared motor, and write its set-points
    #[arg(long, value_name = "SETPOINTS.csv")]
    plan: Option<PathBuf>,
    /// How long the planned run is; by default as long as the longest log, between 20 s and 60 s
    #[arg(long, value_name = "TIME", requires = "plan")]
    plan_time: Option<String>,
    /// The most that the output travels in the planned run; by default as far as in the logs
    #[arg(long, value_name = "ANGLE", requires = "plan")]
    plan_travel: Option<String>,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    catalog: CatalogPaths,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    let band = match &arguments.band {
        None => None,
        Some(text) => Some(read_band(text)?),
    };
    let wanted = arguments.wanted()?;
    arguments.html.check()?;
    if let Some(path) = &arguments.plot {
        Format::of(path).map_err(Failure::Argument)?;
    }
    let robot = match &arguments.requirement {
        Some(path) => Some(arguments.set.read(path, Some("`--requirement`"))?),
        None if arguments.set.settings()?.is_empty() => None,
        None => {
            let why = "`--set` puts values in the place of a requirement's: `--requirement` names it";
            return Err(Failure::Argument(why.into()));
        }
    };
    let catalog = match arguments.catalog.catalog.as_slice() {
        [] => None,
        paths => Some(super::catalog(paths)?),
    };
    let options = identify::Options { band };
    let failed = |why: String| Failure::Argument(format!("{}: {why}", arguments.bench.display()));
    let mut masses = None;
    let (bench, identified) = match read::read_subject(&arguments.bench, catalog)? {
        Subject::Robot(robot) => {
            let joint = arguments.joint_of(&robot)?;
            let mut report = robot::identify(&robot, &options, joint).map_err(failed)?;
            if joint.is_none() {
                return arguments.whole_robot(&robot, &report, call);
            }
            let Some(JointReport { bench, identified, .. }) = report.joints.pop() else {
                return Err(failed("the joint has no report".into()));
            };
            masses = Some(robot_report::payload(&robot, &report.payload));
            (bench, identified.map_err(failed)?)
        }
        Subject::Actuator(_) if arguments.joint.is_some() => {
            return Err(Failure::Argument("`--joint` is of a bench file of a whole robot, with [mechanism]".into()));
        }
        Subject::Actuator(bench) => {
            let identified = identify::identified(&bench, &options).map_err(failed)?;
            (*bench, identified)
        }
    };
    let planned = arguments.plan.as_ref().map(|path| (path, plan::plan(&bench, &identified, &wanted)));
    if let Some((path, Err(NoPlan::TooShort(shortest)))) = &planned {
        let why = format!("`--plan {}`: a run takes {} s at least", path.display(), number(*shortest));
        return Err(Failure::Argument(why));
    }
    let reports: Vec<identify::Report> = identified.into_iter().map(|i| i.report).collect();
    // One actuator: the choice is made again with what the file says.
    let actuator = fitted_actuator(&bench, &reports);
    // The balanced objective is that of the catalogue as one chooses from it.
    let robot = match robot {
        Some(robot) if robot.has_range_of_turns() => {
            let why = "`--requirement`: a range of `turns` is not combined with a fitted motor, which has those of its log; give a list, as in turns = [1, 0.5]";
            return Err(Failure::Argument(why.into()));
        }
        Some(robot) => {
            let robot = super::settled(robot, &bench.catalog)?;
            Some(super::balanced(&robot, &complete(bench.catalog.clone().free(false)), false)?)
        }
        None => None,
    };
    let remade = match &robot {
        None => None,
        Some(robot) => {
            let (Some(declared), Some(Fitted::Motor(motor))) = (&bench.declared.motor, &actuator) else {
                let why = "`--requirement`: a linear axis has no motor of the catalogue to choose again";
                return Err(Failure::Argument(why.into()));
            };
            Some(remake(robot, &bench.catalog, &declared.id, motor))
        }
    };
    let forward = reports.iter().find_map(|report| simulate::forward_check(&bench, report));
    let inputs = || [bench.files.clone(), robot.as_ref().map(|r| r.files()).unwrap_or_default()].concat();
    arguments
        .html
        .write(call, inputs, || html::identify::page(&bench, &reports, forward.as_ref(), remade.as_deref()))?;
    let mut written = Vec::new();
    if let Some(path) = &arguments.plot {
        plot::write(&residual::figure(&bench, &reports), path).map_err(Failure::Argument)?;
        written.push(format!("The residual before and after is drawn in {}.", path.display()));
    }
    if let Some(path) = &arguments.write {
        if reports.iter().all(|report| report.evidence.teaches_nothing()) {
            let why = report::sentence(&bench, &reports);
            return Err(Failure::Argument(format!("`--write`: there are no fitted numbers to write. {why}")));
        }
        let Some(actuator) = &actuator else {
            return Err(Failure::Argument("`--write`: the fitted numbers make no row of a motor".into()));
        };
        output::write_whole(path, fitted::text(actuator, &reports).as_bytes()).map_err(Failure::Argument)?;
        written.push(format!("The fitted actuator is in {}.", path.display()));
    }
    if let Some((path, Ok(plan))) = &planned {
        output::write_whole(path, plan_report::csv(&bench, plan).as_bytes()).map_err(Failure::Argument)?;
    }
    let text = arguments.output.choose(
        || {
            let set = robot.as_ref().map_or_else(String::new, super::told_set);
            let choice = remade.as_deref().map(|remade| set + &remake_report::text(remade));
            let simulated = forward.as_ref().map(forward_report::text);
            let next = planned.as_ref().map(|(path, plan)| plan_report::text(&bench, plan, path));
            let masses = masses.as_ref().map(|said| paragraph(said, 0, 2));
            [masses, Some(report::text(&bench, &reports, &written)), next, simulated, choice]
                .into_iter()
                .flatten()
                .collect::<Vec<_>>()
                .join("\n")
        },
        || {
            let next = planned.as_ref().map(|(path, plan)| {
                let file = plan.is_ok().then(|| path.display().to_string());
                json::identify::Planned::new(&bench, plan, file)
            });
            json::identify::json(&bench, &reports, forward.as_ref(), remade.as_deref(), next)
        },
        || report::csv(&bench, &reports),
    );
    let satisfied = planned.is_none_or(|(_, plan)| plan_report::is_satisfied(&plan));
    Ok(Done { text, satisfied })
}

impl Arguments {
    /// The joint that is asked for; `None` where all are.
    fn joint_of(&self, robot: &RobotBench) -> Result<Option<usize>, Failure> {
        let Some(name) = &self.joint else {
            let alone = [
                ("--write", self.write.is_some()),
                ("--requirement", self.requirement.is_some()),
                ("--plot", self.plot.is_some()),
                ("--plan", self.plan.is_some()),
            ];
            return match alone.iter().find(|(_, given)| *given) {
                Some((option, _)) => {
                    let names = robot.joints.iter().filter(|j| j.declared.is_some()).map(|j| j.name.as_str());
                    let names: Vec<&str> = names.collect();
                    let why = format!("`{option}` is of one joint: `--joint` says which of {}", names.join(", "));
                    Err(Failure::Argument(why))
                }
                None => Ok(None),
            };
        };
        if self.plan.is_some() {
            let why = "`--plan` plans the run of one actuator on a bench: the runs of a whole robot are not planned";
            return Err(Failure::Argument(why.into()));
        }
        let with: Vec<&str> = robot.joints.iter().filter(|j| j.declared.is_some()).map(|j| j.name.as_str()).collect();
        let found = robot.joints.iter().position(|j| j.name == *name && j.declared.is_some());
        match found {
            Some(joint) => Ok(Some(joint)),
            None => {
                let why = format!("`--joint {name}`: the joints with an actuator are {}", with.join(", "));
                Err(Failure::Argument(why))
            }
        }
    }

    /// What is said of all joints.
    fn whole_robot(&self, robot: &RobotBench, report: &RobotReport, call: &Call) -> Result<Done, Failure> {
        let said = robot_report::Said::new(report);
        self.html.write(call, || robot.files.clone(), || html::identify_robot::page(robot, &said))?;
        let text = self.output.choose(
            || robot_report::text(robot, &said),
            || json::identify_robot::json(robot, &said),
            || robot_report::csv(robot, &said),
        );
        Ok(Done { text, satisfied: true })
    }

    /// What is wanted of a plan.
    fn wanted(&self) -> Result<Wanted, Failure> {
        let read =
            |option: &str, text: &Option<String>, kinds: &[&'static units::Kind]| -> Result<Option<f64>, Failure> {
                let Some(text) = text else { return Ok(None) };
                let read = kinds.iter().map(|kind| (kind, units::quantity(text, kind))).collect::<Vec<_>>();
                if let Some(value) = read.iter().find_map(|(_, value)| value.as_ref().ok()) {
                    return match *value > 0.0 {
                        true => Ok(Some(*value)),
                        false => Err(Failure::Argument(format!("`{option} {text}` must be greater than zero"))),
                    };
                }
                let said =
                    read.into_iter().find_map(|(kind, value)| value.err().map(|e| (e.message(kind), e.help(kind))));
                let (message, help) = said.unwrap_or_default();
                Err(Failure::Argument(format!("`{option} {text}`: {message}; {help}")))
            };
        Ok(Wanted {
            time: read("--plan-time", &self.plan_time, &[&units::TIME])?,
            travel: read("--plan-travel", &self.plan_travel, &[&units::ANGLE, &units::LENGTH])?,
        })
    }
}

fn read_band(text: &str) -> Result<f64, Failure> {
    match units::quantity(text, &units::FREQUENCY) {
        Ok(band) if band > 0.0 => Ok(band),
        Ok(_) => Err(Failure::Argument(format!("`--band {text}` must be greater than zero"))),
        Err(error) => Err(Failure::Argument(format!(
            "`--band {text}`: {}; {}",
            error.message(&units::FREQUENCY),
            error.help(&units::FREQUENCY)
        ))),
    }
}
