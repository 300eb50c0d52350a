use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::progress::Telling;
use super::written::Ruled;
use super::{Call, CatalogChoice, Done, Failure, Html, Output, Set};
use crate::design::optimize::optimize_with;
use crate::design::options::Options;
use crate::design::outlook::outlooks;
use crate::design::pareto::fronts;
use crate::design::robot::{self, choose};
use crate::design::robust::{Taken, assume_tolerance, robust, take_alternatives};
use crate::input::Source;
use crate::output::write_whole;
use crate::report::optimize as report;
use crate::report::{html, json, pareto, plot, robot as robot_report, robust as robust_report, table};
use crate::requirement::{Quantity, Robot};
use crate::units;
use crate::words::nearest;

/// How many motors a joint's table shows where nobody says.
const TOP: usize = 5;

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
    #[arg(long, default_value_t = 33, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000))]
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

/// Two or more different quantities, separated by commas.
fn quantities(names: &str) -> Result<Vec<Quantity>, Failure> {
    let wrong = |what: String| Err(Failure::Argument(format!("`--pareto {names}`: {what}")));
    let all = || Quantity::NAMES.iter().map(|(name, _)| *name);
    let mut quantities: Vec<Quantity> = Vec::new();
    for (place, name) in names.split(',').map(str::trim).enumerate() {
        let Some((_, quantity)) = Quantity::NAMES.iter().find(|(n, _)| *n == name) else {
            let help = nearest(name, all()).map_or_else(
                || format!("there are: {}", all().collect::<Vec<_>>().join(", ")),
                |n| format!("did you mean `{n}`?"),
            );
            return wrong(match name {
                "" => format!("name {} is empty; {help}", place + 1),
                _ => format!("name {}, `{name}`, is not a quantity; {help}", place + 1),
            });
        };
        if let Some(before) = quantities.iter().position(|q| q == quantity) {
            return wrong(format!("names {} and {} are both `{name}`: give each quantity once", before + 1, place + 1));
        }
        quantities.push(*quantity);
    }
    match quantities.len() {
        0 | 1 => wrong("a front takes two or more quantities, e.g. loss,mass,reflected_inertia".into()),
        _ => Ok(quantities),
    }
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
    let quantities = arguments.pareto.as_deref().map(quantities).transpose()?;
    super::check_plot(arguments.plot.as_ref())?;
    let no_springs = match (&arguments.pareto, arguments.robust) {
        (Some(_), _) => Some("`--pareto`"),
        (None, true) => Some("`--robust`"),
        (None, false) => None,
    };
    let robot = arguments.set.read(&arguments.requirement, no_springs)?;
    read_again(arguments, &robot)?;
    let tolerance = super::tolerance(arguments.tolerance.as_deref())?;
    let limit = arguments.time_limit.as_deref().map(time_limit).transpose()?;
    if limit.is_some() && !robot.is_coupled() && !arguments.robot {
        let message =
            "`--time-limit` ends the search over a whole robot, and nothing couples these joints: give `--robot` too";
        return Err(Failure::Argument(message.into()));
    }
    let mut catalog = arguments.catalog.for_robot(&robot)?;
    if let Some(share) = tolerance {
        assume_tolerance(&mut catalog.motors, share);
    }
    if arguments.alternatives.is_some() {
        take_alternatives(&mut catalog);
    }
    let plain = super::settled(robot, &catalog)?;
    let writes = arguments.write_design.is_some();
    let mut ruled = Ruled::new(plain.clone(), arguments.rules.as_deref(), writes, arguments.no_rules)?;
    ruled.robot = super::balanced(&ruled.robot, &catalog, arguments.only_checked)?;
    if ruled.robot.has_range_of_turns() && (arguments.pareto.is_some() || arguments.robust || arguments.robot) {
        let message = "a range of `turns` is not combined with `--pareto`, `--robust` or `--robot`; give a list, as in turns = [1, 0.5]";
        return Err(Failure::Argument(message.into()));
    }
    let catalog = &*super::wound(&mut ruled.robot, &catalog, arguments.only_checked)?;
    let robot = &ruled.robot;
    if robot.is_coupled() && (arguments.pareto.is_some() || arguments.robust) {
        tell!("warning: each joint is taken by itself here: budgets and `torque_per_mass` are not looked at");
    }
    if let Some(quantities) = &quantities {
        let points = arguments.points as usize;
        let options = Options { only_checked: arguments.only_checked, ..Options::default() };
        let fronts = fronts(robot, catalog, quantities, points, options)?;
        super::draw_plot(arguments.plot.as_ref(), || plot::pareto::figure(&fronts))?;
        arguments.html.write(
            call,
            || [robot.files(), catalog.files()].concat(),
            || html::pareto::page(robot, &fronts),
        )?;
        let satisfied = fronts.iter().all(|f| !f.points.is_empty());
        let text = arguments.output.choose(
            || {
                super::told_set(robot)
                    + &pareto::text(
                        &fronts,
                        if arguments.full { usize::MAX } else { arguments.top.unwrap_or(pareto::MOTORS) },
                    )
            },
            || json::pareto::json(robot, &fronts),
            || pareto::csv(&fronts),
        );
        return Ok(Done { text, satisfied });
    }
    let work = arguments.telling.counted(robot.joints.len() * catalog.motors.len(), "optimising");
    let keep = arguments.only_top.map(|k| k as usize);
    let search = Options { only_checked: arguments.only_checked, ..Options::default() };
    let options = Options { keep, tick: &|| work.step(), ..search };
    if arguments.robust {
        let joints = robust(robot, catalog, options)?;
        work.end();
        let satisfied = joints.iter().all(|j| !j.designs.is_empty());
        let inputs = || [robot.files(), catalog.files()].concat();
        let taken = Taken { tolerance, alternatives: arguments.alternatives.is_some() };
        arguments.html.write(call, inputs, || html::robust::page(robot, &joints))?;
        let text = arguments.output.choose(
            || super::told_set(robot) + &robust_report::text(robot, &joints, arguments.top.unwrap_or(TOP), &taken),
            || json::robust::json(robot, &joints, &taken),
            || robust_report::csv(&joints),
        );
        return Ok(Done { text, satisfied });
    }
    let mut result = optimize_with(robot, catalog, options)?;
    work.end();
    let paths = arguments.catalog.paths();
    let files = (catalog, paths.as_slice());
    let target = arguments.write_design.as_deref();
    let whole = robot.is_coupled() || arguments.robot;
    let telling = if whole { arguments.telling } else { Telling { progress: false, quiet: true } };
    // Rules that are no limit of the program are looked at on the first designs, and the next are tried.
    let text = match !whole && (ruled.keeps() || target.is_some()) {
        true => ruled.keep(&mut result, &arguments.requirement, files, target),
        false => Ok(None),
    };
    super::draw_plot(arguments.plot.as_ref(), || plot::design::optimized(&result, catalog))?;
    let shown = report::Shown {
        top: keep.or(arguments.top).unwrap_or(TOP),
        rejected: arguments.rejected,
        why: arguments.why || arguments.full,
        full: arguments.full || arguments.top.is_some() || keep.is_some(),
    };
    let with_front = arguments.why || arguments.full;
    let outlooks = outlooks(&result, catalog, with_front, search)?;
    let of_joints = telling.counted(robot.joints.len(), "the whole robot: joints");
    let search = telling.search("the whole robot");
    let begun = Instant::now();
    let enough = || limit.is_some_and(|limit| begun.elapsed() >= limit);
    let options = robot::Options {
        enough: limit.map(|_| &enough as &(dyn Fn() -> bool + Sync)),
        only_checked: arguments.only_checked,
        runner_ups: arguments.runner_ups as usize,
        tick: &|| of_joints.step(),
        searched: &|branches, solved| search.at(branches, solved),
        ..robot::Options::default()
    };
    let choice = whole.then(|| choose(robot, catalog, options)).transpose()?;
    let took = limit.map(|_| begun.elapsed());
    let told = choice.as_ref().filter(|_| arguments.output.is_text());
    let of_rules = told.map(|whole| ruled.cost_of_robot(&plain, catalog, whole, options)).transpose()?;
    of_joints.end();
    search.end();
    arguments.html.write(
        call,
        || [robot.files(), catalog.files()].concat(),
        || html::optimize::page(&result, &outlooks, choice.as_ref(), catalog),
    )?;
    let text = match (&choice, target) {
        (Some(whole), Some(path)) => ruled.whole(&result, whole, &arguments.requirement, files, path).map(Some),
        _ => text,
    };
    let stays = |path: &Path| match path.exists() {
        true => format!("; {} is left as it was", path.display()),
        false => String::new(),
    };
    let mut kept = true;
    match (text, target) {
        (Ok(Some(text)), Some(path)) => {
            write_whole(path, text.toml.as_bytes()).map_err(Failure::Argument)?;
            text.costs.iter().for_each(|cost| tell!("{cost}"));
        }
        (Ok(None), Some(path)) => {
            let without = report::without_choice(&result, "no").join("; ");
            tell!("no design written: {without}{}", stays(path));
            kept = false;
        }
        (Err(why), target) => {
            match target {
                Some(path) => tell!("no design written: {why}{}", stays(path)),
                None => tell!("{why}"),
            }
            kept = false;
        }
        (Ok(_), None) => {}
    }
    let costs = ruled.costs(&plain, catalog, &result)?;
    let text = arguments.output.choose(
        || {
            let mut whole = choice.as_ref().map_or_else(String::new, |c| format!("\n{}", robot_report::text(c, took)));
            if let Some(cost) = of_rules.iter().flatten().next() {
                whole.push_str(&format!("\n{}", table::paragraph(cost, 0, 2)));
            }
            let costs: String = costs.iter().map(|line| table::paragraph(line, 0, 2)).collect();
            super::told_set(robot) + &costs + &report::text(&result, &outlooks, shown) + &whole
        },
        || json::optimize::json(&result, &outlooks, choice.as_ref()),
        || report::csv(&result),
    );
    let satisfied = kept && choice.as_ref().map_or_else(|| result.satisfied(), |c| !c.combinations.is_empty());
    Ok(Done { text, satisfied })
}
