use std::path::PathBuf;

use clap::Args;

use super::{Call, CatalogPaths, Done, Failure, Html, Output, Set};
use crate::ask::Answer;
use crate::ask::identify::{Asked, Identified, OfActuator, identify, with_actuator};
use crate::input::limits;
use crate::measured::identify::plan::Wanted;
use crate::measured::read;
use crate::measured::robot::{RobotBench, Subject};
use crate::output;
use crate::report::plot::Format;
use crate::report::{fitted, identify as report, plan as plan_report};
use crate::units;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise identify requirements/bench/leg_actuator.toml\n  gearwise identify bench.toml --plot residual.svg --write fitted.toml\n  gearwise identify bench.toml --requirement robot.toml\n  gearwise identify bench.toml --band \"40 Hz\" --json\n  gearwise identify bench.toml --plan next_run.csv --plan-time \"30 s\"\n\nStructure that no known effect explains is an answer, not a failure: exit status 0. Exit status 1 where nothing can be learnt from the logs."
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
    let requirement = match &arguments.requirement {
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
    let subject = read::read_subject(&arguments.bench, catalog, read::Logs::new())?;
    if let Subject::Robot(robot) = &subject {
        arguments.check_joint(robot)?;
    }
    let Arguments { plot, html, write, plan, .. } = arguments;
    super::check_outputs(plot.iter().chain(&html.html).chain(write).chain(plan))?;
    let plan = arguments.plan.as_ref().map(|_| wanted);
    let asked = Asked { band, joint: arguments.joint.clone(), requirement, plan };
    let found = match identify(subject, asked, &arguments.bench)? {
        Identified::Actuator(found) => found,
        Identified::Robot(found) => {
            arguments.html.write_page(call, &*found)?;
            return Ok(arguments.output.done(&*found, || found.text()));
        }
    };
    arguments.html.write_page(call, &*found)?;
    let written = arguments.written(&found)?;
    let plan = arguments.plan.as_deref();
    let text = arguments.output.choose(|| found.text_of(&written, plan), || found.json_of(plan), || found.csv());
    Ok(Done { text, satisfied: found.is_satisfied() })
}

impl Arguments {
    /// That what is asked for goes with a bench file of a whole robot.
    fn check_joint(&self, robot: &RobotBench) -> Result<(), Failure> {
        let alone = [
            ("--write", self.write.is_some()),
            ("--requirement", self.requirement.is_some()),
            ("--plot", self.plot.is_some()),
            ("--plan", self.plan.is_some()),
        ];
        let first = alone.iter().find(|(_, given)| *given);
        match (&self.joint, first) {
            (None, Some((option, _))) => {
                let names = with_actuator(robot).join(", ");
                Err(Failure::Argument(format!("`{option}` is of one joint: `--joint` says which of {names}")))
            }
            (Some(_), _) if self.plan.is_some() => {
                let why =
                    "`--plan` plans the run of one actuator on a bench: the runs of a whole robot are not planned";
                Err(Failure::Argument(why.into()))
            }
            _ => Ok(()),
        }
    }

    /// Writes what was asked for; what was written where, in sentences.
    fn written(&self, found: &OfActuator) -> Result<Vec<String>, Failure> {
        let mut written = Vec::new();
        if let Some(path) = &self.plot {
            super::draw_plot(Some(path), found)?;
            written.push(format!("The residual before and after is drawn in {}.", path.display()));
        }
        if let Some(path) = &self.write {
            let (bench, reports) = (found.bench(), found.reports());
            if reports.iter().all(|report| report.evidence.teaches_nothing()) {
                let why = report::sentence(bench, reports);
                return Err(Failure::Argument(format!("`--write`: there are no fitted numbers to write. {why}")));
            }
            let Some(actuator) = found.actuator() else {
                return Err(Failure::Argument("`--write`: the fitted numbers make no row of a motor".into()));
            };
            output::write_whole(path, fitted::text(actuator, reports).as_bytes()).map_err(Failure::Argument)?;
            written.push(format!("The fitted actuator is in {}.", path.display()));
        }
        if let Some((path, Ok(plan))) = self.plan.as_ref().zip(found.planned()) {
            let text = plan_report::csv(found.bench(), plan);
            output::write_whole(path, text.as_bytes()).map_err(Failure::Argument)?;
        }
        Ok(written)
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
        let time = read("--plan-time", &self.plan_time, &[&units::TIME])?;
        if time.is_some_and(|time| time > limits::PLAN_TIME) {
            let text = self.plan_time.as_deref().unwrap_or_default();
            return Err(Failure::Argument(format!(
                "`--plan-time {text}`: a planned run lasts at most {} s",
                limits::PLAN_TIME
            )));
        }
        Ok(Wanted { time, travel: read("--plan-travel", &self.plan_travel, &[&units::ANGLE, &units::LENGTH])? })
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
