//! Bench files: TOML and the logs that it names, to SI and canonical frames.
//!
//! What a log lacks is checked here against its kind; what had to be assumed or was left out is said in
//! the log's remarks.

mod actuator;
mod columns;
mod readings;
mod remark;
mod robot;
mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range as Span;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::actuator::{Frame, Purpose};
use self::columns::{Column, Target};
use self::remark::Remark;
use self::table::{Condition, Rows, Wanted};
use super::bench::*;
use super::robot::Subject;
use gearwise_model::catalog::Catalog;
use gearwise_model::catalog::convention::Commutation;
use gearwise_model::effects::{EFFECTS, Effect, FittedEffect};
use gearwise_model::input::kind::{self, FileKind};
use gearwise_model::input::{Description, Form, InputError, InputFile, Key, Problem, Range, Section, Source, key};
use gearwise_model::units;
use gearwise_model::words::number;

/// Standard gravity \[m/s²\].
pub const STANDARD_GRAVITY: f64 = 9.806_65;

const ROTORS: &[(&str, bool)] = &[("installed", true), ("removed", false)];

const USES: &[(&str, Use)] = &[("fit", Use::Fit), ("held_out", Use::HeldOut)];

/// Files that take the place of logs that a bench file names, each with its name there.
pub type Logs = Vec<(String, PathBuf)>;

/// Reads a bench file and its logs.
///
/// # Errors
/// All mistakes of the bench file, then those of its catalogue and of its logs.
pub fn read(path: &Path) -> Result<Bench, Vec<InputError>> {
    read_file(path, None, Logs::new(), false)
}

/// The same with another catalogue in place of the one that the bench file names.
///
/// # Errors
/// As of [`read`].
pub fn read_with(path: &Path, catalog: Catalog) -> Result<Bench, Vec<InputError>> {
    read_file(path, Some(catalog), Logs::new(), false)
}

/// A bench file from which a row is made: the motor needs no row yet, conventions are not assumed, and readings
/// alone are enough. With a catalogue in place of the one that the file names, where given, and files in the place of logs.
///
/// # Errors
/// As of [`read`].
pub fn read_for_row(path: &Path, catalog: Option<Catalog>, logs: Logs) -> Result<Bench, Vec<InputError>> {
    read_file(path, catalog, logs, true)
}

/// A bench file of one actuator, or of the joints of a robot. With a catalogue in place of the one that the file names,
/// where given, and files in the place of logs.
///
/// # Errors
/// As of [`read`].
pub fn read_subject(path: &Path, catalog: Option<Catalog>, logs: Logs) -> Result<Subject, Vec<InputError>> {
    read_form(path, logs, |root, source, others| {
        if robot::is_one(root) {
            return robot::read(root, path, source, catalog, others).map(|robot| Subject::Robot(Box::new(robot)));
        }
        read_bench(root, path, source, catalog, false, others).map(|bench| Subject::Actuator(Box::new(bench)))
    })
}

fn read_file(path: &Path, catalog: Option<Catalog>, logs: Logs, for_row: bool) -> Result<Bench, Vec<InputError>> {
    read_form(path, logs, |root, source, others| {
        if robot::is_one(root) {
            robot::refuse(root);
            return None;
        }
        read_bench(root, path, source, catalog, for_row, others)
    })
}

fn read_form<T>(
    path: &Path,
    logs: Logs,
    read: impl FnOnce(&Section, &Arc<Source>, &mut Vec<InputError>) -> Option<T>,
) -> Result<T, Vec<InputError>> {
    let mut source = Source::argument(path).map_err(|e| vec![e])?;
    let names: Vec<String> = logs.iter().map(|(name, _)| name.clone()).collect();
    if !logs.is_empty() {
        source = Arc::new(Arc::unwrap_or_clone(source).with_files(logs));
    }
    let mut others = Vec::new();
    let bench = Form::read(&source, |root| {
        note_unnamed(root, &names);
        read(root, &source, &mut others)
    });
    let read = Form::with_others(bench, others);
    read.map_err(|errors| kind::instead_of_all(errors, &source, &[FileKind::Bench]))
}

/// Notes logs that are handed over and that the bench file does not name.
fn note_unnamed(root: &Section, names: &[String]) {
    if names.is_empty() {
        return;
    }
    let table: toml::Table = root.source().text().parse().unwrap_or_default();
    let logs = table.get("log").and_then(toml::Value::as_array).into_iter().flatten();
    let known: Vec<&str> = logs.filter_map(|log| log.get("file")?.as_str()).collect();
    for name in names.iter().filter(|name| !known.contains(&name.as_str())) {
        let message = format!("the bench file names no log `{name}`, which is handed over");
        root.note(Problem::whole(message).suggest(name, known.iter().copied()));
    }
}

/// A log as the bench file describes it, of one actuator.
struct Plan {
    recording: Recording,
    kind: BenchKind,
    /// The actuator, by its number among those of the bench file.
    joint: usize,
    frame: Frame,
    load: KnownLoad,
    controller: Option<Controller>,
    rotor: bool,
    columns: Vec<Column>,
}

impl Plan {
    /// Whether it reads the same rows as another one, for the same.
    fn reads_the_rows_of(&self, other: &Plan) -> bool {
        let (own, its) = (&self.recording, &other.recording);
        let names = |plan: &Plan| plan.columns.iter().map(|c| (c.target, c.name.clone())).collect::<Vec<_>>();
        self.joint == other.joint
            && own.usage == its.usage
            && self.kind == other.kind
            && own.select.len() == its.select.len()
            && own.select.iter().zip(&its.select).all(|(a, b)| a.asks_the_same(b))
            && own.exclude == its.exclude
            && names(self) == names(other)
    }
}

/// A file of rows and what of it belongs to a log.
#[derive(Clone)]
struct Recording {
    file: String,
    path: PathBuf,
    /// The path as messages and lists have it: another where a file takes the place of the named one.
    shown: String,
    file_span: Span<usize>,
    span: Span<usize>,
    usage: Use,
    select: Vec<Condition>,
    exclude: Vec<Span<f64>>,
}

/// What the logs have in common.
struct Common<'a> {
    kind: Option<BenchKind>,
    load: KnownLoad,
    controller: Option<Controller>,
    columns: Vec<Column>,
    frame: &'a Frame,
}

/// One machine is simulated: by voltages, or by torques.
fn check_laws(root: &Section, plans: &[Plan]) {
    let of = |law: Law| {
        let is_law = |p: &&Plan| p.kind == BenchKind::Servo && p.controller.map_or(Law::Duty, |c| c.law) == law;
        plans.iter().find(is_law)
    };
    if let (Some(_), Some(torque)) = (of(Law::Duty), of(Law::Torque)) {
        let message = "one log's controller makes a torque, another's a duty cycle";
        root.note(
            Problem::at(torque.recording.span.clone(), message, "this one makes a torque")
                .help("two bench files, one for each, compare them with the model"),
        );
    }
}

/// Effects that are not to be asked for, each named once.
fn read_without(root: &Section, declared: &[FittedEffect]) -> Option<Vec<&'static dyn Effect>> {
    if !root.has(WITHOUT) {
        return Some(Vec::new());
    }
    let mut found: Vec<&'static dyn Effect> = Vec::new();
    for name in root.texts(WITHOUT)? {
        let Some(effect) = EFFECTS.iter().copied().find(|e| e.name() == name.get_ref()) else {
            root.note(
                Problem::at(name.span(), format!("unknown effect `{}`", name.get_ref()), "not in the library")
                    .suggest(name.get_ref(), EFFECTS.iter().map(|e| e.name())),
            );
            continue;
        };
        if declared.iter().any(|d| d.effect == effect) {
            let message = format!("`{}` is declared: it is in the model, and not asked for", name.get_ref());
            root.note(Problem::at(name.span(), message, "named here").help(
                "take it out of the row or of `actuator.effects` to do without it; what is declared is only refitted",
            ));
        } else if !found.contains(&effect) {
            found.push(effect);
        }
    }
    Some(found)
}

fn name_of(root: &Section, path: &Path) -> Option<String> {
    root.name_or(key("name", "name of the bench").default("that of the file"), || {
        path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
    })
}

fn read_bench(
    root: &Section,
    path: &Path,
    source: &Arc<Source>,
    catalog: Option<Catalog>,
    for_row: bool,
    others: &mut Vec<InputError>,
) -> Option<Bench> {
    let name = name_of(root, path);
    let catalog = read_catalog(root, source, catalog, others);
    let kind = root.choice(KIND, BenchKind::NAMES);
    let linear = kind == Some(BenchKind::Linear);
    let readings = readings::read(root);
    let commutation = readings.motor.commutation.unwrap_or(Commutation::Brushless);
    let purpose = if for_row { Purpose::Characterize(commutation) } else { Purpose::Identify };
    let actuator = match root.section(key("actuator", "the declared model; required for `identify`")) {
        Some(section) => actuator::read(section, catalog.as_ref(), linear, purpose),
        None if for_row && !root.has("actuator") => Some(actuator::without_row(commutation)),
        None => {
            if !root.has("actuator") {
                root.missing("actuator", "{ motor = \"t-motor-ri50\", ratio = 7.5 }");
            }
            None
        }
    };
    let actuator_known = actuator.is_some();
    let (mut declared, frame) = actuator.unzip();
    let known_effects = declared.as_ref().map_or_else(Vec::new, |d: &Declared| d.all_effects());
    let without = read_without(root, &known_effects);
    if let (Some(declared), Some(without)) = (&mut declared, without) {
        declared.without = without;
    }
    let frame = frame.unwrap_or(Frame::unknown(linear));
    let (load, controller) = (read_load(root, &frame), read_controller(root));
    let (columns, complete) =
        root.section(COLUMNS).map_or((Vec::new(), true), |section| columns::read(section, &frame));
    let known = actuator_known && complete;
    let common = Common { kind, load: load.unwrap_or_default(), controller, columns, frame: &frame };
    let enough = for_row && (readings.terminals.is_some() || readings.rotor.is_some());
    let sections = match enough {
        true => root.sections(LOGS),
        false => root.some_sections(LOGS, LOG),
    };
    let count = sections.len();
    let plans: Vec<Plan> = sections.into_iter().filter_map(|section| read_plan(section, &common, known)).collect();
    check_laws(root, &plans);
    let complete = plans.len() == count && (count > 0 || enough);
    let mut files = vec![source.file()];
    let logs = read_logs(root, plans, &mut files, others)?.into_iter().map(|(_, log)| log).collect();
    if !complete || !others.is_empty() {
        return None;
    }
    let (catalog, path) = (catalog?, path.to_path_buf());
    files.extend(catalog.files());
    Some(Bench { name: name?, path, catalog, declared: declared?, logs, readings, files })
}

fn read_catalog(
    root: &Section,
    source: &Arc<Source>,
    given: Option<Catalog>,
    others: &mut Vec<InputError>,
) -> Option<Catalog> {
    let named = if root.has(CATALOG) { Some(root.texts("catalog")?) } else { None };
    let catalog = if given.is_some() {
        return given;
    } else if let Some(named) = named {
        let paths: Vec<PathBuf> = named.iter().map(|text| source.folder().join(text.get_ref())).collect();
        Catalog::read(&paths)
    } else {
        Catalog::builtin()
    };
    catalog.map_err(|errors| others.extend(errors)).ok()
}

const WITHOUT: Key =
    key("without", "effects that are not asked for, where one knows better").value("list of names").default("none");
const KIND: Key = key("kind", "what the logs record; may be in each log");
const LOGS: Key = key("log", "the logs, at least one for `identify`");
const LOG: &str = "a table [[log]] with file = \"run1.csv\" for each log";
const COLUMNS: Key = key("columns", "what the columns of the logs are; may be in each log");
const LOAD: Key = key("load", "what hangs at the output").value("table");
const PENDULUM: Key = key("pendulum", "a pendulum at the output, in place of `load`").value("table");
const CATALOG: Key = key("catalog", "where the motor is looked for, next to this file")
    .value("list of paths")
    .default("the built-in catalogue");
const USE: Key = key("use", "what is held out has no part in the choice").value("`fit`, `held_out`").default("`fit`");
const OWN_KIND: Key = key("kind", "of this log").value("kind of bench");
const ROTOR: Key = key("rotor", "of kind `random_torque`: whether the rotor was in")
    .value("`installed`, `removed`")
    .default("`installed`");
const SELECT: Key = key("select", "which rows, where one file has several logs").value("table or list of tables");

const EXCLUDE: Key =
    key("exclude", "stretches of time that are left out: `from`, `to`").value("table or list of tables");

/// Every table that the reader looks into.
const SKELETON: &str = "
actuator = {}
columns = { time = {}, position = {}, velocity = {}, current = {}, duty = {} }
load = {}
controller = {}
terminals = {}
rotor = {}
[[log]]
file = ''
select = {}
exclude = {}
[[log]]
pendulum = {}
";

/// What the reader asks for: of columns, those tables that differ.
pub fn describe() -> Description {
    let catalog = || Some(Catalog::default());
    let source = Arc::new(Source::new("skeleton.toml", ""));
    let read =
        |root: &Section| read_bench(root, Path::new("skeleton.toml"), &source, catalog(), false, &mut Vec::new());
    let read_robot =
        |root: &Section| robot::read(root, Path::new("skeleton.toml"), &source, catalog(), &mut Vec::new());
    Form::describe(SKELETON, read)
        .and(Form::describe("actuator = { mass = '1 kg' }", read))
        .and(Form::describe(robot::SKELETON, read_robot))
}

/// What hangs at the output: `load`, or `pendulum`.
fn read_load(section: &Section, frame: &Frame) -> Option<KnownLoad> {
    if section.has(LOAD) && section.has(PENDULUM) {
        section.note(
            Problem::at(
                section.span_of("pendulum"),
                "a log has `load` or `pendulum`, not both",
                "remove one of the two",
            )
            .help("a pendulum is a load: mass, length and arm_mass"),
        );
        return None;
    }
    if let Some(table) = section.section(PENDULUM) {
        let mass = table.required_quantity(key("mass", "at the end"), &units::MASS, Range::NonNegative);
        let length = table.required_quantity(key("length", "to the mass"), &units::LENGTH, Range::Positive);
        let arm = table
            .quantity(key("arm_mass", "of the arm").default("none"), &units::MASS, Range::NonNegative)
            .unwrap_or(0.0);
        table.finish();
        let (mass, length) = (mass?, length?);
        // A mass at the end of a slender arm.
        return Some(KnownLoad {
            inertia: Some((mass + arm / 3.0) * length * length),
            gravity_torque: Some((mass + arm / 2.0) * STANDARD_GRAVITY * length),
        });
    }
    let table = section.section(LOAD)?;
    let mass = table.quantity(key("mass", "of what hangs there"), &units::MASS, Range::NonNegative);
    let load = if frame.linear.is_some() {
        KnownLoad { inertia: mass, gravity_torque: None }
    } else {
        let inertia = table.quantity(key("inertia", "about the output"), &units::INERTIA, Range::NonNegative);
        let gravity =
            table.quantity(key("gravity_torque", "in place of mass and distance"), &units::TORQUE, Range::NonNegative);
        let distance = table.quantity(key("distance", "of its centre"), &units::LENGTH, Range::NonNegative);
        for (key, other, example) in [("mass", "distance", "\"0.1 m\""), ("distance", "mass", "\"0.5 kg\"")] {
            if table.has(key) && !table.has(other) {
                table.missing(other, example);
            }
        }
        let point = mass.zip(distance);
        // The inertia that is given is that about the output, its mass included.
        KnownLoad {
            inertia: inertia.or(point.map(|(m, d)| m * d * d)),
            gravity_torque: gravity.or(point.map(|(m, d)| m * STANDARD_GRAVITY * d)),
        }
    };
    table.finish();
    Some(load)
}

fn read_controller(section: &Section) -> Option<Controller> {
    let table = section.section(key("controller", "of kind `servo`: what makes duty, or torque, of the goal"))?;
    // The gain is often called kp.
    let gain = if table.has(key("kp", "another name of `gain`").value("number")) { "kp" } else { "gain" };
    if !table.has(gain) {
        table.missing("gain", "0.29  # duty per rad, or \"20 N*m/rad\"");
    }
    // Its unit says what it makes.
    let in_torque = table.is_text(gain)
        && table.text(gain).is_some_and(|text| units::quantity(text.get_ref(), &units::STIFFNESS).is_ok());
    let law = if in_torque { Law::Torque } else { Law::Duty };
    let number = |asked: Key, of_duty, of_torque| match (in_torque, table.is_text(asked.name())) {
        (true, _) => table.quantity(asked, of_torque, Range::Any),
        (false, true) => table.quantity(asked, of_duty, Range::Any),
        (false, false) => table.number(asked, Range::Any),
    };
    let about = "duty per angle, or per rad; or torque per angle, as `\"20 N*m/rad\"`";
    let gain = number(key(gain, about).required(), &units::PER_ANGLE, &units::STIFFNESS);
    let supply = table.quantity(key("supply", "where the log does not have it"), &units::VOLTAGE, Range::Positive);
    let damping = number(
        key("damping", "duty, or torque, per speed").default("none"),
        &units::PER_SPEED,
        &units::VISCOUS_FRICTION,
    );
    let about = key("limit", "largest duty, or torque").default("1, of a torque none");
    let limit = match in_torque {
        true => table.quantity(about, &units::TORQUE, Range::Positive).unwrap_or(f64::INFINITY),
        false => table.number(about, Range::Positive).unwrap_or(1.0),
    };
    table.finish();
    Some(Controller { law, gain: gain?, damping: damping.unwrap_or(0.0), limit, supply })
}

fn read_plan(section: Section, common: &Common, known: bool) -> Option<Plan> {
    let recording = read_recording(&section);
    let kind = read_kind(&section, common.kind);
    let load = read_load(&section, common.frame);
    let controller = read_controller(&section);
    let (own, complete) = section
        .section(key("columns", "of this log, over the common ones"))
        .map_or((Vec::new(), true), |table| columns::read(table, common.frame));
    let columns = columns::merge(&common.columns, own);
    let rotor = if section.has(ROTOR) { section.choice(ROTOR, ROTORS) } else { Some(true) };
    let columns = columns
        .into_iter()
        .map(|c| if kind == Some(BenchKind::ThermalStep) { c.heating(common.frame) } else { c })
        .collect::<Vec<_>>();
    if let Some(kind) = kind {
        check_kind(&section, kind, common.frame, known);
        let controlled = controller.or(common.controller).is_some();
        let has = |target: Target| columns.iter().any(|c| c.target == target);
        let problem = lacking(kind, controlled, common.frame, &section.span(), &has);
        if let Some(problem) = problem.filter(|_| known && complete) {
            section.note(problem);
        }
    }
    section.finish();
    Some(Plan {
        recording: recording?,
        kind: kind?,
        joint: 0,
        frame: *common.frame,
        load: load.unwrap_or(common.load),
        controller: controller.or(common.controller),
        rotor: rotor?,
        columns,
    })
}

/// What kind of test a log is of: its own, or that of all.
fn read_kind(section: &Section, common: Option<BenchKind>) -> Option<BenchKind> {
    let kind = if section.has(OWN_KIND) { section.choice(OWN_KIND, BenchKind::NAMES) } else { common };
    if kind.is_none() && !section.has("kind") && common.is_none() {
        section.missing("kind", "\"dynamometer\", here or at the top of the file");
    }
    kind
}

/// The file of a log, and which of its rows; `None` where something of it is wrong, which is noted.
fn read_recording(section: &Section) -> Option<Recording> {
    let file = section.required_text(
        key("file", "next to this file: CSV, `.parquet`, `.npz` or `.mcap`").value("file"),
        "\"run1.csv\"",
    );
    let usage = if section.has(USE) { section.choice(USE, USES) } else { Some(Use::Fit) };
    let select = read_select(section);
    let exclude = read_exclude(section);
    let file = file?;
    let path = section.source().file_for(file.get_ref());
    let shown = section.source().folder().join(file.get_ref()).display().to_string();
    if let Err((message, help)) = table::probe(&path) {
        let problem = Problem::at(file.span(), format!("log `{}`: {message}", file.get_ref()), "named here");
        section.note(Problem { help, ..problem });
        return None;
    }
    let file_span = file.span();
    let file = file.into_inner();
    Some(Recording {
        file,
        path,
        shown,
        file_span,
        span: section.span(),
        usage: usage?,
        select: select?,
        exclude: exclude?,
    })
}

/// Whether the kind suits the actuator, and has a log at all.
fn check_kind(section: &Section, kind: BenchKind, frame: &Frame, known: bool) {
    let span = if section.has("kind") { section.span_of("kind") } else { section.span() };
    if matches!(kind, BenchKind::Terminals | BenchKind::Rotor) {
        section.note(
            Problem::at(
                span,
                format!("a log cannot be of kind `{}`: that is a reading, not a recording", kind.name()),
                "expected a kind with a log",
            )
            .help(format!("it is a table of the bench file: [{}]", kind.name())),
        );
    } else if known && frame.linear.is_some() != (kind == BenchKind::Linear) {
        let (message, help) = if frame.linear.is_some() {
            (format!("kind `{}` is of an actuator that turns", kind.name()), "this axis is linear: kind = \"linear\"")
        } else {
            (
                "kind `linear` needs a linear axis".to_string(),
                "for example actuator = { mass = \"95 kg\", force_gain = \"35.15 N/V\" }",
            )
        };
        section.note(Problem::at(span, message, "does not suit the actuator").help(help));
    }
}

/// One condition, or a list of conditions that must all hold. `None` where one of them is wrong.
fn read_select(section: &Section) -> Option<Vec<Condition>> {
    if !section.has(SELECT) {
        return Some(Vec::new());
    }
    let tables = if section.is_list("select") { section.sections("select") } else { vec![section.section("select")?] };
    tables.into_iter().map(read_condition).collect()
}

/// Stretches of time that are left out. `None` where one of them is wrong.
fn read_exclude(section: &Section) -> Option<Vec<Span<f64>>> {
    if !section.has(EXCLUDE) {
        return Some(Vec::new());
    }
    let tables =
        if section.is_list("exclude") { section.sections("exclude") } else { vec![section.section("exclude")?] };
    let one = |table: Section| {
        let from = table.quantity(
            key("from", "the first time that is left out").default("the beginning"),
            &units::TIME,
            Range::Any,
        );
        let to = table.quantity(key("to", "up to this time").default("the end"), &units::TIME, Range::Any);
        if !table.has("from") && !table.has("to") {
            table.missing("from", "\"27 s\"");
        }
        let span = table.span();
        let end = |name: &'static str, given: Option<f64>, end: f64| if table.has(name) { given } else { Some(end) };
        let (from, to) = (end("from", from, f64::NEG_INFINITY)?, end("to", to, f64::INFINITY)?);
        if from >= to {
            table.note(Problem::at(span, "`exclude` ends before it begins", "`from` must be less than `to`"));
            return None;
        }
        table.finish();
        Some(from..to)
    };
    tables.into_iter().map(one).collect()
}

fn read_condition(table: Section) -> Option<Condition> {
    let column = table.required_text(key("column", "in the header of the log"), "\"run\"");
    let cells = table.cells(key("equals", "rows with one of these cells"));
    let (min, max) = (
        table.number(key("min", "rows from this value on"), Range::Any),
        table.number(key("max", "rows up to this value"), Range::Any),
    );
    let bounded = table.has("min") || table.has("max");
    if !table.has("equals") && !bounded {
        table.missing("equals", "\"run 1\", a list of values, or `min` and `max`");
    }
    let span = if table.has("equals") { table.span_of("equals") } else { table.span() };
    table.finish();
    let column = column?;
    if cells.is_empty() && min.is_none() && max.is_none() {
        return None;
    }
    Some(Condition {
        column_span: column.span(),
        column: column.into_inner().trim().to_string(),
        equals: cells.into_iter().map(|c| c.into_inner().trim().to_string()).collect(),
        min,
        max,
        span,
    })
}

/// What a log of this kind needs and does not have.
fn lacking(
    kind: BenchKind,
    controlled: bool,
    frame: &Frame,
    span: &Span<usize>,
    has: &dyn Fn(Target) -> bool,
) -> Option<Problem> {
    use Channel::*;
    let any = |channels: &[Channel]| channels.iter().any(|c| has(Target::Channel(*c)));
    let linear = frame.linear.is_some();
    // A steady table lists points, not instants.
    let table = kind == BenchKind::SteadyTable || (frame.characterize && kind == BenchKind::Backdrive);
    let time = (table || has(Target::Time), "`time`");
    let drive = (
        any(&[Current]) || (!linear && any(&[Voltage, Duty])),
        if linear {
            "`force`, or the column that `force_gain` is for"
        } else {
            "`current` (or `torque_demand`, `torque_estimate`), `voltage` or `duty`"
        },
    );
    let motion = (any(&[MotorPosition, MotorVelocity, OutputPosition, OutputVelocity]), "`velocity` or `position`");
    let current = (any(&[Current]), "`current`");
    let torque = (any(&[Torque]), "`torque`");
    let needs = match kind {
        BenchKind::Dynamometer | BenchKind::SteadyTable => vec![time, drive, torque, motion],
        BenchKind::Free | BenchKind::Linear => vec![time, drive, motion],
        BenchKind::Electrical => vec![time, (any(&[Voltage]), "`voltage`"), current, motion],
        BenchKind::Stall => vec![time, current, torque],
        BenchKind::Backdrive => vec![time, (any(&[Voltage, Torque]), "`voltage` or `torque`"), motion],
        BenchKind::RandomTorque => vec![time, torque, motion],
        BenchKind::Drag => vec![time, (any(&[Current, Torque]), "`current` or `torque`"), motion],
        BenchKind::ThermalStep => {
            let warm = any(&[WindingTemperature, HousingTemperature]);
            vec![time, current, (warm, "`winding_temperature` or `housing_temperature`")]
        }
        BenchKind::Servo => {
            let driven = any(&[Duty, Voltage]) || (controlled && any(&[Goal]));
            let position = (any(&[MotorPosition, OutputPosition]), "`position`");
            vec![time, (driven, "`duty` (or `goal` with `controller`)"), position]
        }
        BenchKind::Terminals | BenchKind::Rotor => Vec::new(),
    };
    let missing: Vec<&str> = needs.iter().filter(|(there, _)| !there).map(|(_, key)| *key).collect();
    if missing.is_empty() {
        return None;
    }
    let all: Vec<&str> = needs.iter().map(|(_, key)| *key).collect();
    Some(
        Problem::at(
            span.clone(),
            format!("a log of kind `{}` needs {}", kind.name(), missing.join(" and ")),
            "this log has no such column",
        )
        .help(format!("kind `{}` needs {}; they are given in [columns]", kind.name(), all.join(", "))),
    )
}

/// Reads every file once, and puts the logs in the order of the bench file.
fn read_logs(
    root: &Section,
    plans: Vec<Plan>,
    files: &mut Vec<InputFile>,
    others: &mut Vec<InputError>,
) -> Option<Vec<(usize, Log)>> {
    let mut once: Vec<(PathBuf, Vec<usize>)> = Vec::new();
    for (index, plan) in plans.iter().enumerate() {
        let path = &plan.recording.path;
        let canonical = path.canonicalize().unwrap_or_else(|_| path.clone());
        match once.iter_mut().find(|(path, _)| *path == canonical) {
            Some((_, indices)) => indices.push(index),
            None => once.push((canonical, vec![index])),
        }
    }
    let mut rows: BTreeMap<usize, (String, Rows)> = BTreeMap::new();
    for (_, indices) in once {
        let twice = |(k, i): (usize, &usize)| {
            indices[..k].iter().any(|j| plans[*i].reads_the_rows_of(&plans[*j])).then_some(*i)
        };
        // Of a robot each joint reads them: the first says it for all.
        if let Some(first) = indices.iter().enumerate().find_map(twice) {
            let recording = &plans[first].recording;
            let message = format!("log `{}` is here twice, with the same rows", recording.file);
            let problem = Problem::at(recording.file_span.clone(), message, "read before");
            root.note(
                problem.help("rows that count twice make every ± too small; to hold out a part of a log, `select` it"),
            );
        }
        let of = |i: &usize| Wanted {
            select: plans[*i].recording.select.clone(),
            columns: plans[*i].columns.clone(),
            span: plans[*i].recording.file_span.clone(),
            held_out: plans[*i].recording.usage == Use::HeldOut,
        };
        let wanted: Vec<Wanted> = indices.iter().map(of).collect();
        let Recording { path, shown, .. } = &plans[indices[0]].recording;
        match table::read((path, shown), &wanted, &mut |problem| root.note(problem)) {
            Ok(Some((hash, found))) => {
                files.push(InputFile { name: shown.clone(), sha256: hash.clone() });
                rows.extend(indices.iter().zip(found).map(|(i, found)| (*i, (hash.clone(), found))));
            }
            Ok(None) => {}
            Err(error) => others.push(error),
        }
    }
    let mut logs: Vec<(usize, Log)> = Vec::new();
    let mut complete = true;
    for (index, plan) in plans.into_iter().enumerate() {
        let Some((hash, rows)) = rows.remove(&index) else {
            complete = false;
            continue;
        };
        let empty: Vec<Remark> = rows.remarks.iter().copied().filter(|r| matches!(r, Remark::Empty { .. })).collect();
        let mut log = assemble(&plan, hash, rows);
        // What a column does not hold is as good as not there.
        let has = |target: Target| match target {
            Target::Time => true,
            Target::Channel(channel) => log.channels.contains_key(&channel),
        };
        let emptied = log.channels.len() + usize::from(plan.columns.iter().any(|c| c.target == Target::Time))
            < plan.columns.len();
        let problem = || lacking(plan.kind, plan.controller.is_some(), &plan.frame, &plan.recording.span, &has);
        if emptied && let Some(problem) = problem() {
            let what: Vec<String> = empty.iter().map(Remark::to_string).collect();
            root.note(Problem { help: Some(what.join("; ")), ..problem });
            complete = false;
        }
        let own = || logs.iter().filter(|(joint, _)| *joint == plan.joint).map(|(_, log)| &log.name);
        if own().any(|name| *name == log.name) {
            let twice = own().filter(|name| **name == log.name || name.starts_with(&format!("{} (", log.name))).count();
            log.name = format!("{} ({})", log.name, twice + 1);
        }
        logs.push((plan.joint, log));
    }
    complete.then_some(logs)
}

fn assemble(plan: &Plan, hash: String, rows: Rows) -> Log {
    let of_columns = plan.columns.iter().flat_map(|c| &c.remarks);
    let remarks = of_columns.chain(&rows.remarks).map(Remark::to_string).collect();
    let from_motor = |c: &Column| match c.target {
        Target::Channel(channel) if c.from_motor => Some(channel),
        _ => None,
    };
    Log {
        name: plan.name(),
        file: plan.recording.file.clone(),
        hash,
        kind: plan.kind,
        usage: plan.recording.usage,
        load: plan.load,
        controller: plan.controller,
        rotor: plan.rotor,
        difference: plan.difference(),
        gains: plan.gains(),
        held: plan.held(),
        from_motor: plan.columns.iter().filter_map(from_motor).collect(),
        estimated: plan.estimated(),
        excluded: plan.recording.exclude.clone(),
        band: None,
        fresh: BTreeMap::new(),
        time: rows.time,
        channels: rows.channels,
        remarks,
    }
}

impl Plan {
    /// How well its columns say that their instruments are calibrated.
    fn gains(&self) -> BTreeMap<Channel, f64> {
        let of = |c: &Column| match c.target {
            Target::Channel(channel) => Some((channel, c.gain_tolerance?)),
            Target::Time => None,
        };
        self.columns.iter().filter_map(of).collect()
    }

    /// The channels that hold their value from row to row.
    fn held(&self) -> BTreeSet<Channel> {
        let of = |c: &Column| match c.target {
            Target::Channel(channel) if c.held => Some(channel),
            _ => None,
        };
        self.columns.iter().filter_map(of).collect()
    }

    /// The channels that are the driver's own estimate.
    fn estimated(&self) -> BTreeSet<Channel> {
        let of = |c: &Column| match c.target {
            Target::Channel(channel) if c.estimated => Some(channel),
            _ => None,
        };
        self.columns.iter().filter_map(of).collect()
    }

    /// What its columns say of the velocity that is used: the motor's, where there are two.
    fn difference(&self) -> Option<f64> {
        let of = |channel| self.columns.iter().find(|c| c.target == Target::Channel(channel));
        of(Channel::MotorVelocity).or(of(Channel::OutputVelocity))?.difference
    }

    /// The file and what is selected of it, short.
    fn name(&self) -> String {
        let conditions: Vec<String> = self.recording.select.iter().filter_map(Condition::label).collect();
        if conditions.is_empty() {
            return self.recording.file.clone();
        }
        format!("{}, {}", self.recording.file, conditions.join(", "))
    }
}

impl Condition {
    fn label(&self) -> Option<String> {
        let column = &self.column;
        match self.equals.as_slice() {
            [] => match (self.min, self.max) {
                (Some(min), Some(max)) => Some(format!("{column} {} to {}", number(min), number(max))),
                (Some(min), None) => Some(format!("{column} from {}", number(min))),
                (None, Some(max)) => Some(format!("{column} up to {}", number(max))),
                (None, None) => None,
            },
            [one] => Some(format!("{} {one}", self.column)),
            [one, .., last] => Some(format!("{} {one} … {last}", self.column)),
        }
    }
}
