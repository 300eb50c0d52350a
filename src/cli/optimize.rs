use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::progress::{Counted, Telling};
use super::{Call, CatalogChoice, Done, Failure, Html, Output, Set};
use crate::ask::optimize::{Asked, Names, Optimized, Ready, Rules, TOP, optimize};
use crate::ask::robust::{robust, with_tolerances};
use crate::ask::{Answer, Watch, pareto};
use crate::design::robust::Taken;
use crate::input::{Source, limits};
use crate::output::write_whole;
use crate::report;
use crate::report::optimize::Shown;
use crate::requirement::Robot;
use crate::units;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise optimize requirements/quadruped_mini_cheetah.toml\n  gearwise optimize robot.toml --why\n  gearwise optimize robot.toml --top 20 --rejected\n  gearwise optimize robot.toml --pareto loss,mass,reflected_inertia\n  gearwise optimize robot.toml --html robot.html\n  gearwise optimize robot.toml --robust --catalog my_motors.csv\n  gearwise optimize robot.toml --robot --runner-ups 5\n  gearwise optimize robot.toml --write-design design.toml\n  gearwise optimize robot.toml --json | jq '.joints[].candidates[0].motor'"
)]
pub struct Arguments {
    /// Requirement file (TOML); `-` is standard input
    requirement: PathBuf,
    /// How many motors of each joint its table shows: as `--full`, which shows 5. Of a front of three or more quantities 10, with `--full` all
    #[arg(long, value_name = "N")]
    top: Option<usize>,
    /// Why each first choice: what binds, how its number comes about, how far the ratio may move, which gears are near
    #[arg(long)]
    why: bool,
    /// Everything: the tables of all joints, what could not be checked, why the others cannot
    #[arg(long)]
    full: bool,
    /// Only the first K designs of each joint: motors that provably are not among them are not solved
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "pareto")]
    only_top: Option<u32>,
    /// List every rejected motor with its reason
    #[arg(long)]
    rejected: bool,
    /// Leave out motors whose rows do not say enough to check every limit
    #[arg(long)]
    only_checked: bool,
    /// The front of two or more quantities instead, e.g. loss,mass,reflected_inertia: designs of which none has less of one without more of another
    #[arg(long, value_name = "A,B,...")]
    pareto: Option<String>,
    /// The best design over one number that is given in the requirement, between two values: as
    /// joint.knee.transmission.ratio=1:3 or joint.knee.transmission.four_bar.crank="20 mm:60 mm"
    #[arg(long, value_name = "KEY=LOW:HIGH", conflicts_with_all = ["pareto", "robust", "robot", "plot", "html", "write_design", "rules", "only_top"])]
    search: Option<String>,
    /// Designs that keep all limits over the motors' tolerances, and how likely the first choice stays first
    #[arg(long, conflicts_with_all = ["pareto", "only_top", "plot"])]
    robust: bool,
    /// Tolerance (±, 95 %) of every number whose row states none, e.g. 5%, with --robust; temperatures have none
    #[arg(long, value_name = "PERCENT", requires = "robust", allow_hyphen_values = true)]
    tolerance: Option<String>,
    /// Take the ends of what all sources print of a module's numbers as their ±, with --robust
    #[arg(long, value_name = "HOW", requires = "robust", value_parser = PossibleValuesParser::new(["worst"]))]
    alternatives: Option<String>,
    /// How many ratios along each motor's front, with --pareto; how many values of the grid, with --search
    #[arg(long, default_value_t = 33, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=limits::FRONT_POINTS))]
    points: u32,
    /// Draw the objective of the first designs over the ratio and the first choice's torque over speed, or the fronts: an .svg or .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Write what was chosen as a design file, for `check` and `export`: the best combination where the whole
    /// robot is looked at, else the first choices. Keeps the default rules of `check` (`--no-rules` does not)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["pareto", "robust"])]
    write_design: Option<PathBuf>,
    /// Rules that a choice has to keep (a file as for `check`): what they bound becomes a limit of the program
    #[arg(long, value_name = "FILE")]
    rules: Option<PathBuf>,
    /// Choose without any rules; by default `--write-design` keeps those of `check`
    #[arg(long, conflicts_with = "rules")]
    no_rules: bool,
    /// The best combination for the whole robot, even where nothing couples the joints (a budget or
    /// `torque_per_mass` does, and then it is always reported)
    #[arg(long, conflicts_with_all = ["pareto", "robust"])]
    robot: bool,
    /// How many further combinations of the whole robot are reported
    #[arg(long, default_value_t = 3, value_name = "K", value_parser = clap::value_parser!(u32).range(..=1000))]
    runner_ups: u32,
    /// End the search over the whole robot after so long, e.g. "30 s", and give what it has: without it the search ends after a fixed
    /// number of steps, and the answer is the same each time
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, conflicts_with_all = ["pareto", "robust"])]
    time_limit: Option<String>,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    catalog: CatalogChoice,
    #[command(flatten)]
    telling: Telling,
    #[command(flatten)]
    output: Output,
}

/// A design file names its files, and what is written is read again: standard input has no name.
fn read_again(arguments: &Arguments, robot: &Robot) -> Result<(), Failure> {
    let stdin = |path: &Path| path.as_os_str() == Source::STDIN;
    let rules = arguments.rules.as_ref().or(robot.rules.as_ref()).filter(|_| !arguments.no_rules);
    let why = match (stdin(&arguments.requirement), &arguments.write_design) {
        (true, Some(_)) => "`--write-design` names the requirement's file in the design: give a file in place of `-`",
        (true, None) if rules.is_some() => {
            "rules are looked at with the requirement's file: give a file in place of `-`"
        }
        (false, Some(_)) if rules.is_some_and(|path| stdin(path)) => {
            "`--write-design` names the rules' file in the design: give a file in place of `-`"
        }
        (_, Some(_)) if arguments.catalog.paths().iter().any(|path| stdin(path)) => {
            "`--write-design` names the catalogue's files in the design: give a file in place of `-`"
        }
        _ => return Ok(()),
    };
    Err(Failure::Argument(why.into()))
}

/// How long a search may take.
fn time_limit(text: &str) -> Result<Duration, Failure> {
    let limit = units::quantity(text, &units::TIME).map_err(|error| {
        let kind = &units::TIME;
        Failure::Argument(format!("`--time-limit`: {}; {}", error.message(kind), error.help(kind)))
    })?;
    match Duration::try_from_secs_f64(limit) {
        Ok(limit) if !limit.is_zero() => Ok(limit),
        _ => Err(Failure::Argument(format!("`--time-limit`: `{text}` is no time to search in"))),
    }
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    if let Some(over) = &arguments.search {
        let Arguments { requirement, set, catalog, only_checked, output, .. } = arguments;
        return super::over::run(over, arguments.points as usize, requirement, set, catalog, *only_checked, output);
    }
    arguments.html.check()?;
    let quantities = |names: &String| {
        pareto::quantities(names.split(',')).map_err(|why| Failure::Argument(format!("`--pareto {names}`: {why}")))
    };
    let quantities = arguments.pareto.as_ref().map(quantities).transpose()?;
    super::check_plot(arguments.plot.as_ref())?;
    let no_springs = match (&arguments.pareto, arguments.robust) {
        (Some(_), _) => Some("`--pareto`"),
        (None, true) => Some("`--robust`"),
        (None, false) => None,
    };
    let robot = arguments.set.read(&arguments.requirement, no_springs)?;
    read_again(arguments, &robot)?;
    let taken = Taken {
        tolerance: super::tolerance(arguments.tolerance.as_deref())?,
        alternatives: arguments.alternatives.is_some(),
    };
    let limit = arguments.time_limit.as_deref().map(time_limit).transpose()?;
    if limit.is_some() && !robot.is_coupled() && !arguments.robot {
        let message =
            "`--time-limit` ends the search over a whole robot, and nothing couples these joints: give `--robot` too";
        return Err(Failure::Argument(message.into()));
    }
    let asked = arguments.asked(limit);
    let catalog = with_tolerances(arguments.catalog.rows()?.for_robot(&robot)?, &taken);
    super::check_outputs(arguments.plot.iter().chain(&arguments.html.html).chain(&arguments.write_design))?;
    let one_by_one = arguments.pareto.is_some() || arguments.robust || arguments.robot;
    let ready = Ready::of(robot, catalog, &asked, one_by_one, &Watch::default())?;
    if let Some(quantities) = &quantities {
        let points = arguments.points as usize;
        let fronts = pareto::pareto(ready, quantities, points, arguments.only_checked, Watch::default())?;
        let most = if arguments.full { usize::MAX } else { arguments.top.unwrap_or(report::pareto::MOTORS) };
        return arguments.answered(call, &fronts, || fronts.text_of(most));
    }
    let work = Arc::new(arguments.telling.counted(ready.steps(), "optimising"));
    if arguments.robust {
        let watch = Watch { tick: Box::new(move || work.step()), ..Watch::default() };
        let robust = robust(ready, taken, arguments.only_checked, watch)?;
        return arguments.answered(call, &robust, || robust.text_of(arguments.top.unwrap_or(TOP)));
    }
    let whole = ready.robot().is_coupled() || arguments.robot;
    let names = arguments.catalog.paths();
    let names = Names { requirement: &arguments.requirement, given: None, catalog: &names };
    let watch = arguments.watch(work, ready.robot().joints.len(), whole, limit);
    let found = optimize(ready, &asked, names, watch)?;
    super::draw_plot(arguments.plot.as_ref(), &found)?;
    arguments.html.write_page(call, &found)?;
    found.looked_at().for_each(|said| tell!("{said}"));
    let kept = arguments.written(&found)?;
    let top = arguments.only_top.map(|k| k as usize).or(arguments.top);
    let shown = Shown {
        top: top.unwrap_or(TOP),
        rejected: arguments.rejected,
        why: arguments.why || arguments.full,
        full: arguments.full || top.is_some(),
    };
    let done = arguments.output.done(&found, || found.text_of(shown));
    Ok(Done { satisfied: done.satisfied && kept, ..done })
}

impl Arguments {
    fn asked(&self, time_limit: Option<Duration>) -> Asked {
        Asked {
            only_checked: self.only_checked,
            keep: self.only_top.map(|k| k as usize),
            whole: self.robot,
            runner_ups: self.runner_ups as usize,
            with_front: self.why || self.full,
            rules: match (&self.rules, self.no_rules) {
                (_, true) => Rules::None,
                (Some(path), _) => Rules::File(path.clone()),
                (None, _) => Rules::OfRequirement,
            },
            design: self.write_design.clone(),
            with_costs: self.output.is_text(),
            time_limit,
            joint: None,
        }
    }

    /// Who looks on: `work` is the search of the joints.
    fn watch(&self, work: Arc<Counted>, joints: usize, whole: bool, limit: Option<Duration>) -> Watch {
        let telling = if whole { self.telling } else { Telling { progress: false, quiet: true } };
        let of_joints = Arc::new(telling.counted(joints, "the whole robot: joints"));
        let search = telling.search("the whole robot");
        let (each, first) = (of_joints, work.clone());
        let begun = OnceLock::new();
        Watch {
            tick: Box::new(move || work.step()),
            joint: Box::new(move || {
                first.end();
                each.step();
            }),
            searched: Box::new(move |branches, solved| search.at(branches, solved)),
            enough: limit.map(|limit| {
                // The time is that of the search over the whole robot, which asks.
                let enough = move || begun.get_or_init(Instant::now).elapsed() >= limit;
                Box::new(enough) as Box<dyn Fn() -> bool + Send + Sync>
            }),
            ..Watch::default()
        }
    }

    /// An answer that is no choice, in the form that was asked for.
    fn answered(&self, call: &Call, answer: &dyn Answer, text: impl FnOnce() -> String) -> Result<Done, Failure> {
        super::remark(answer);
        super::draw_plot(self.plot.as_ref(), answer)?;
        self.html.write_page(call, answer)?;
        Ok(self.output.done(answer, text))
    }

    /// Writes the design file that was asked for; whether there is none that should be.
    fn written(&self, found: &Optimized) -> Result<bool, Failure> {
        let stays = |path: &Path| match path.exists() {
            true => format!("; {} is left as it was", path.display()),
            false => String::new(),
        };
        match (&found.found().design, &self.write_design) {
            (Ok(Some(text)), Some(path)) => {
                write_whole(path, text.toml.as_bytes()).map_err(Failure::Argument)?;
                text.costs.iter().for_each(|cost| tell!("{cost}"));
                return Ok(true);
            }
            (Ok(None), Some(path)) => {
                let without = report::optimize::without_choice(&found.found().result, "no").join("; ");
                tell!("no design written: {without}{}", stays(path));
            }
            (Err(why), Some(path)) => tell!("no design written: {why}{}", stays(path)),
            (Err(why), None) => tell!("{why}"),
            (Ok(_), None) => return Ok(true),
        }
        Ok(false)
    }
}
