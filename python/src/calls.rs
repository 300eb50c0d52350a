//! The functions of the package.

use std::path::PathBuf;
use std::sync::Arc;

use gearwise::ask::export::{Asked as Exporting, Made, of_choice, of_design, of_motor};
use gearwise::ask::optimize::{Asked, Names, Ready, Rules, optimize as choose};
use gearwise::ask::robust::{robust, with_tolerances};
use gearwise::ask::{
    Failure, Rows, Watch, actuator_map as maps, audit as audits, characterize as benches, check as checks,
    compare as compares, evaluate as evaluates, explain as explains, identify as logs, pareto as fronts, rank as ranks,
    sweep as sweeps,
};
use gearwise::design::robust::Taken;
use gearwise::input::Source;
use gearwise::measured::read::{self, Logs};
use gearwise::requirement::{DesignFile, Settings};
use gearwise::rules::lock::path_of;
use gearwise::units;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::answer::{Answer, Chosen};
use crate::arrays::{ActuatorMap, Evaluated};
use crate::catalog::Catalog;
use crate::failure::wrong;
use crate::motion::{numbers, quantity};
use crate::pool::{How, here};
use crate::requirement::{Requirement, taken};
use crate::values::texts;

/// Adds the functions to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let functions = [
        wrap_pyfunction!(optimize, module)?,
        wrap_pyfunction!(optimize_robust, module)?,
        wrap_pyfunction!(sweep, module)?,
        wrap_pyfunction!(evaluate, module)?,
        wrap_pyfunction!(actuator_map, module)?,
        wrap_pyfunction!(explain, module)?,
        wrap_pyfunction!(pareto, module)?,
        wrap_pyfunction!(rank, module)?,
        wrap_pyfunction!(compare, module)?,
        wrap_pyfunction!(audit, module)?,
        wrap_pyfunction!(check, module)?,
        wrap_pyfunction!(identify, module)?,
        wrap_pyfunction!(characterize, module)?,
        wrap_pyfunction!(export, module)?,
        wrap_pyfunction!(crate::studies::study, module)?,
        wrap_pyfunction!(crate::studies::merge, module)?,
        wrap_pyfunction!(command, module)?,
        wrap_pyfunction!(describe, module)?,
        wrap_pyfunction!(_panic, module)?,
        wrap_pyfunction!(crate::motion::_simulated, module)?,
        wrap_pyfunction!(crate::motion::_rollouts, module)?,
    ];
    functions.into_iter().try_for_each(|function| module.add_function(function))
}

/// The rows of a catalogue, of the built-in one where none is given.
fn rows(py: Python<'_>, catalog: &Bound<'_, Catalog>) -> PyResult<Rows> {
    let catalog = catalog.get();
    here(py, || catalog.rows())
}

#[pyfunction]
#[pyo3(signature = (requirement, catalog, only_top, only_checked, whole_robot, runner_ups, rules, keep_rules, threads, progress))]
#[expect(clippy::too_many_arguments, reason = "as Python calls it")]
fn optimize<'py>(
    py: Python<'py>,
    requirement: &Bound<'py, PyAny>,
    catalog: &Bound<'py, Catalog>,
    only_top: Option<usize>,
    only_checked: bool,
    whole_robot: bool,
    runner_ups: usize,
    rules: Option<PathBuf>,
    keep_rules: bool,
    threads: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Answer> {
    let requirement = taken(py, requirement)?;
    let (robot, source) = (requirement.get().robot(), requirement.get().source());
    if only_top == Some(0) {
        return Err(wrong(py, "`only_top` is 0: expected a number from 1 on"));
    }
    let rules = match (rules, keep_rules) {
        (_, false) => Rules::None,
        (Some(path), true) => Rules::File(path),
        (None, true) => Rules::OfRequirement,
    };
    let asked = Asked { only_checked, keep: only_top, whole: whole_robot, runner_ups, rules, ..Asked::default() };
    let (rows, paths) = (rows(py, catalog)?, catalog.get().paths().to_vec());
    let (own, plain) = (source.clone(), robot.clone());
    let found = How::new(py, threads, progress)?.run(py, move |looking| {
        let ready = Ready::new(Arc::unwrap_or_clone(robot), &rows, &asked, whole_robot, &looking.watch())?;
        looking.begin(ready.steps());
        let names = Names { requirement: own.name().as_ref(), given: Some(&own), catalog: &paths };
        choose(ready, &asked, names, looking.watch())
    })?;
    Ok(Answer::of_choice(found, source, plain))
}

#[pyfunction]
fn optimize_robust<'py>(
    py: Python<'py>,
    requirement: &Bound<'py, PyAny>,
    catalog: &Bound<'py, Catalog>,
    only_checked: bool,
    tolerance: Option<f64>,
    threads: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Answer> {
    if let Some(share) = tolerance.filter(|share| !(0.0..1.0).contains(share)) {
        return Err(wrong(py, format!("`tolerance` is {share}: expected a share from 0 to less than 1")));
    }
    let robot = taken(py, requirement)?.get().without_springs(py, "`robust`")?;
    let (rows, asked) = (rows(py, catalog)?, Asked { only_checked, ..Asked::default() });
    let found = How::new(py, threads, progress)?.run(py, move |looking| {
        let taken = Taken { tolerance, alternatives: false };
        let catalog = with_tolerances(rows.for_robot(&robot)?, &taken);
        let ready = Ready::of(Arc::unwrap_or_clone(robot), catalog, &asked, true, &looking.watch())?;
        looking.begin(ready.steps());
        robust(ready, taken, only_checked, looking.watch())
    })?;
    Ok(Answer::new(found))
}

#[pyfunction]
fn sweep<'py>(
    py: Python<'py>,
    requirement: &Bound<'py, PyAny>,
    catalog: &Bound<'py, Catalog>,
    ratios: usize,
    by: &str,
    threads: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Answer> {
    if !(1..=1_000_000).contains(&ratios) {
        return Err(wrong(py, format!("`ratios` is {ratios}: expected a number from 1 to 1 000 000")));
    }
    let order = sweeps::order(by).map_err(|why| wrong(py, format!("`by`: {why}")))?;
    let robot = taken(py, requirement)?.get().without_springs(py, "`sweep`")?;
    let (rows, asked) = (rows(py, catalog)?, sweeps::Asked { ratios, order, gears_per_motor: None });
    let found = How::new(py, threads, progress)?.run(py, move |looking| {
        let watch = |steps| {
            looking.begin(steps);
            looking.watch()
        };
        sweeps::sweep(Arc::unwrap_or_clone(robot), &rows, asked, watch)
    })?;
    Ok(Answer::new(found))
}

#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "as Python calls it")]
fn evaluate<'py>(
    py: Python<'py>,
    requirement: &Bound<'py, PyAny>,
    motors: Option<Bound<'py, PyAny>>,
    ratios: &Bound<'py, PyAny>,
    joint: Option<String>,
    limits: &Bound<'py, PyAny>,
    catalog: &Bound<'py, Catalog>,
    threads: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Evaluated> {
    let robot = taken(py, requirement)?.get().without_springs(py, "`evaluate`")?;
    let limits = match limits.cast::<PyString>().ok().map(|text| text.to_str()).transpose()? {
        Some("all") => evaluates::Which::All,
        Some("instant") => evaluates::Which::Instant,
        _ => evaluates::Which::Named(texts(py, "limits", limits)?),
    };
    let motors = motors.map(|motors| texts(py, "motors", &motors)).transpose()?;
    let asked = evaluates::Asked { motors, ratios: numbers(py, "ratios", ratios)?, joint, limits };
    let rows = rows(py, catalog)?;
    // One motor takes less than handing it over.
    if asked.motors.as_ref().is_some_and(|motors| motors.len() == 1) {
        return here(py, || evaluates::evaluate(&robot, &rows, &asked, &Watch::default())).map(Evaluated);
    }
    let found = How::new(py, threads, progress)?.run(py, move |looking| {
        looking.begin(asked.motors.as_ref().map_or(rows.catalog().motors.len(), Vec::len));
        evaluates::evaluate(&robot, &rows, &asked, &looking.watch())
    })?;
    Ok(Evaluated(found))
}

#[pyfunction]
fn actuator_map<'py>(
    py: Python<'py>,
    requirement: &Bound<'py, Requirement>,
    motors: Option<Bound<'py, PyAny>>,
    ratios: &Bound<'py, PyAny>,
    speeds: Option<Bound<'py, PyAny>>,
    catalog: &Bound<'py, Catalog>,
    threads: Option<i64>,
) -> PyResult<ActuatorMap> {
    let robot = requirement.get().robot();
    let motors = motors.map(|motors| texts(py, "motors", &motors)).transpose()?;
    let ratios = numbers(py, "ratios", ratios)?;
    let speeds = speeds.map(|speeds| numbers(py, "speed", &speeds)).transpose()?.unwrap_or_default();
    let rows = rows(py, catalog)?;
    if motors.as_ref().is_some_and(|motors| motors.len() == 1) {
        let made = || maps::actuator_map(&robot, &rows, motors.as_deref(), &ratios, &speeds);
        return here(py, made).map(ActuatorMap);
    }
    let found = How::new(py, threads, None)?
        .run(py, move |_| maps::actuator_map(&robot, &rows, motors.as_deref(), &ratios, &speeds))?;
    Ok(ActuatorMap(found))
}

#[pyfunction]
fn explain<'py>(
    py: Python<'py>,
    design: String,
    requirement: &Bound<'py, PyAny>,
    joint: Option<String>,
    catalog: &Bound<'py, Catalog>,
    threads: Option<i64>,
) -> PyResult<Answer> {
    let robot = taken(py, requirement)?.get().robot();
    let rows = rows(py, catalog)?;
    let found = How::new(py, threads, None)?
        .run(py, move |_| explains::explain(Arc::unwrap_or_clone(robot), &rows, &design, joint.as_deref()))?;
    Ok(Answer::new(found))
}

#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "as Python calls it")]
fn pareto<'py>(
    py: Python<'py>,
    requirement: &Bound<'py, PyAny>,
    quantities: Vec<String>,
    points: usize,
    only_checked: bool,
    catalog: &Bound<'py, Catalog>,
    threads: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Answer> {
    if !(2..=100_000).contains(&points) {
        return Err(wrong(py, format!("`points` is {points}: expected a number from 2 to 100 000")));
    }
    let quantities = fronts::quantities(quantities.iter().map(String::as_str)).map_err(|why| wrong(py, why))?;
    let robot = taken(py, requirement)?.get().without_springs(py, "`pareto`")?;
    let (rows, asked) = (rows(py, catalog)?, Asked { only_checked, ..Asked::default() });
    let found = How::new(py, threads, progress)?.run(py, move |looking| {
        let ready = Ready::new(Arc::unwrap_or_clone(robot), &rows, &asked, true, &looking.watch())?;
        fronts::pareto(ready, &quantities, points, only_checked, looking.watch())
    })?;
    Ok(Answer::new(found))
}

#[pyfunction]
fn rank<'py>(
    py: Python<'py>,
    by: &str,
    mark: Vec<String>,
    modules: Vec<String>,
    tolerance: Option<f64>,
    catalog: &Bound<'py, Catalog>,
) -> PyResult<Answer> {
    let by = ranks::by(by).map_err(|why| wrong(py, format!("`by`: {why}")))?;
    if let Some(share) = tolerance.filter(|share| !(0.0..1.0).contains(share)) {
        return Err(wrong(py, format!("`tolerance` is {share}: expected a share from 0 to less than 1")));
    }
    let catalog = catalog.get().read();
    let found = here(py, || ranks::rank(Arc::unwrap_or_clone(catalog), by, &modules, tolerance, &mark))?;
    Ok(Answer::new(found))
}

#[pyfunction]
fn compare<'py>(
    py: Python<'py>,
    a: &str,
    b: &str,
    inertia: Option<Bound<'py, PyAny>>,
    catalog: &Bound<'py, Catalog>,
) -> PyResult<Answer> {
    let inertia = inertia.map(|value| quantity(py, "inertia", &value, &units::INERTIA)).transpose()?;
    let rows = rows(py, catalog)?;
    Ok(Answer::new(here(py, || compares::compare(&rows, a, b, inertia))?))
}

#[pyfunction]
fn audit<'py>(py: Python<'py>, catalog: &Bound<'py, Catalog>) -> PyResult<Answer> {
    let catalog = catalog.get().read();
    Ok(Answer::new(here(py, || Ok(audits::audit(Arc::unwrap_or_clone(catalog))))?))
}

#[pyfunction]
fn check<'py>(
    py: Python<'py>,
    design: &Bound<'py, PyAny>,
    rules: Option<PathBuf>,
    strict: bool,
    catalog: Option<Bound<'py, Catalog>>,
) -> PyResult<Answer> {
    let given = catalog.map(|catalog| rows(py, &catalog)).transpose()?;
    let chosen = match design.cast::<Answer>() {
        Ok(answer) => {
            Some(answer.get().choice().cloned().ok_or_else(|| wrong(py, "only what `optimize` chose is checked"))?)
        }
        Err(_) => None,
    };
    let path = match &chosen {
        None => design.extract().map_err(|_| wrong(py, "`design` is neither a path nor what `optimize` chose"))?,
        Some(_) => PathBuf::from("the choice"),
    };
    let found = here(py, move || {
        let design = match &chosen {
            None => design_file(&path)?,
            Some(Chosen { found, source, robot }) => {
                let text = Source::of_values(path.display().to_string(), found.design_text(source.name().as_ref())?);
                DesignFile::read_for(&Arc::new(text), source, robot)?
            }
        };
        let rows = given.map_or_else(|| rows_of(&design), Ok)?;
        let lock_path = path_of(design.source.name().as_ref());
        let lock = match lock_path.exists() {
            true => Some(Source::read(&lock_path).map_err(|e| vec![e])?),
            false => None,
        };
        let inputs = checks::Inputs::new(design, &rows, rules.as_deref(), lock_path)?;
        checks::check(checks::Inputs { lock, ..inputs }, strict)
    })?;
    Ok(Answer::new(found))
}

fn design_file(path: &std::path::Path) -> Result<DesignFile, Failure> {
    let source = Source::read(path).map_err(|e| vec![e])?;
    Ok(DesignFile::read_set(&source, &Settings::default())?)
}

/// The rows of the catalogue that a design names.
fn rows_of(design: &DesignFile) -> Result<Rows, Failure> {
    let catalog = match design.catalog.as_slice() {
        [] => gearwise::catalog::Catalog::builtin()?,
        paths => gearwise::catalog::Catalog::read(paths)?,
    };
    Ok(Rows::new(catalog, true, false))
}

#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "as Python calls it")]
fn identify<'py>(
    py: Python<'py>,
    bench: PathBuf,
    given: Logs,
    requirement: Option<Bound<'py, PyAny>>,
    joint: Option<String>,
    band: Option<Bound<'py, PyAny>>,
    catalog: Option<Bound<'py, Catalog>>,
    threads: Option<i64>,
) -> PyResult<Answer> {
    let requirement = requirement.map(|value| taken(py, &value)?.get().without_springs(py, "`requirement`"));
    let requirement = requirement.transpose()?.map(Arc::unwrap_or_clone);
    let band = band.map(|value| quantity(py, "band", &value, &units::FREQUENCY)).transpose()?;
    let catalog = catalog.map(|catalog| Arc::unwrap_or_clone(catalog.get().read()));
    let found = How::new(py, threads, None)?.run(py, move |_| {
        let subject = read::read_subject(&bench, catalog, given)?;
        logs::identify(subject, logs::Asked { band, joint, requirement, plan: None }, &bench)
    })?;
    Ok(match found {
        logs::Identified::Actuator(found) => Answer::new(*found),
        logs::Identified::Robot(found) => Answer::new(*found),
    })
}

#[pyfunction]
fn characterize<'py>(
    py: Python<'py>,
    bench: PathBuf,
    given: Logs,
    catalog: Option<Bound<'py, Catalog>>,
    threads: Option<i64>,
) -> PyResult<Answer> {
    let catalog = catalog.map(|catalog| Arc::unwrap_or_clone(catalog.get().read()));
    let found = How::new(py, threads, None)?.run(py, move |_| {
        let bench = read::read_for_row(&bench, catalog, given)?;
        benches::characterize(bench)
    })?;
    Ok(Answer::new(found))
}

/// Text of the export, what it warns of, and whether every design keeps its limits.
type Exported = (String, Vec<String>, bool);

#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "as Python calls it")]
fn export<'py>(
    py: Python<'py>,
    design: &Bound<'py, PyAny>,
    requirement: Option<Bound<'py, PyAny>>,
    to: Option<String>,
    into: Option<PathBuf>,
    joint: Vec<String>,
    map: Vec<String>,
    options: Vec<String>,
    draws: Option<u16>,
    catalog: Option<Bound<'py, Catalog>>,
) -> PyResult<Exported> {
    let is = |name: &str| options.iter().any(|option| option == name);
    let asked = Exporting {
        joint,
        to,
        into,
        map,
        with_efficiency: is("with_efficiency"),
        line_below: is("line_below"),
        thermal: is("thermal"),
        electrical: is("electrical"),
        drake: is("drake"),
        gear_joint: is("gear_joint"),
        ranges: is("ranges"),
        draws,
    };
    let plain = |made: Made| (made.text.clone(), made.warnings.clone(), made.is_satisfied());
    if let Some(format) = asked.to.as_deref().filter(|to| !formats().contains(to)) {
        let near = gearwise::words::nearest(format, formats());
        let help =
            near.map_or_else(|| format!("there are: {}", formats().join(", ")), |n| format!("did you mean `{n}`?"));
        return Err(wrong(py, format!("`to` is `{format}`, which is no format; {help}")));
    }
    if let Ok(answer) = design.cast::<Answer>() {
        let Some(Chosen { found, source, .. }) = answer.get().choice() else {
            return Err(wrong(py, "only what `optimize` chose is exported"));
        };
        return here(py, || of_choice(&asked, found, source).map(plain));
    }
    let given = catalog.map(|catalog| rows(py, &catalog)).transpose()?;
    let Some(requirement) = requirement else {
        let path: PathBuf = design.extract().map_err(|_| wrong(py, "`design` is no path of a design file"))?;
        return here(py, move || {
            let mut design = design_file(&path)?;
            let rows = given.map_or_else(|| rows_of(&design), Ok)?;
            let catalog = rows.for_design(&mut design);
            design.robot = gearwise::design::families::settle(design.robot, &catalog).map_err(Failure::Argument)?;
            of_design(&asked, &design, &catalog).map(plain)
        });
    };
    let text: String = design.extract().map_err(|_| wrong(py, "`design` is no text, as in \"t-motor-ri50@9\""))?;
    let requirement = taken(py, &requirement)?;
    let (robot, source) = (requirement.get().robot(), requirement.get().source());
    here(py, move || {
        let rows = match given {
            Some(rows) => rows,
            None => Rows::new(gearwise::catalog::Catalog::builtin()?, true, false),
        };
        let catalog = rows.with_named(&robot, std::iter::once(gearwise::ask::chosen::id(&text)));
        let robot = gearwise::ask::ready(Arc::unwrap_or_clone(robot), &catalog)?;
        of_motor(&asked, &text, &robot, &catalog, &source).map(plain)
    })
}

/// The formats of simulators.
fn formats() -> Vec<&'static str> {
    gearwise::report::export::FORMATS.iter().map(|format| format.name).collect()
}

/// A key that the reader of requirements asks for: its table, its name, what may stand there, what it means, whether it must be there.
type Described = (String, &'static str, String, String, bool);

/// What the reader of requirements asks for, key by key.
#[pyfunction]
fn describe() -> Vec<Described> {
    let asked = gearwise::requirement::describe();
    let of_table = |table: &gearwise::input::TableAsked| -> Vec<Described> {
        let key = |key: &gearwise::input::KeyAsked| {
            (table.path.clone(), key.name, key.value.clone(), key.meaning(), key.required)
        };
        table.keys.iter().map(key).collect()
    };
    asked.tables.iter().flat_map(of_table).collect()
}

/// Panics where work is done: what a test needs.
#[pyfunction]
fn _panic(py: Python<'_>) -> PyResult<()> {
    How::new(py, Some(1), None)?.run(py, |_| -> Result<(), Failure> { panic!("as a test asked for") })
}

/// Runs the command line with these arguments; its exit status.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| gearwise::cli::run_with(arguments))
}
