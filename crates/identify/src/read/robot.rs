//! Bench files of a whole robot: `[mechanism]`, a table `[[joint]]` for each joint, and logs that have them all.
//!
//! The one idea: every joint reads the same file with its own columns, and becomes a bench of one actuator whose load is
//! computed of how all of them move.

use toml::Spanned;

use super::columns::{Column, Target};
use super::*;
use crate::robot::{RobotBench, RobotJoint};
use gearwise_model::mechanism::described::{self, Described};
use gearwise_model::mechanism::{Mechanism, Motion};

const MECHANISM: Key =
    key("mechanism", "of logs of a whole robot: its description, which says the load of each joint").value("table");
const JOINTS: Key = key("joint", "with `mechanism`: its joints, each with its columns").value("list of tables");
const FIXED: Key = key("fixed", "joints that did not move, and where they were").value("table of joints");

/// Every table that the reader looks into.
pub(super) const SKELETON: &str = "
kind = 'free'
columns = { time = {} }
mechanism = { model = '', payload = {} }
[[joint]]
mechanism_joint = ''
actuator = {}
columns = { position = {} }
[[log]]
file = ''
payload = {}
select = {}
exclude = {}
";

/// Whether a bench file is of a whole robot.
pub(super) fn is_one(root: &Section) -> bool {
    root.has(MECHANISM) || root.has(JOINTS)
}

/// Says that one actuator is wanted.
pub(super) fn refuse(root: &Section) {
    let place = if root.has("mechanism") { "mechanism" } else { "joint" };
    root.note(
        Problem::at(root.span_of(place), "this bench file is of a whole robot", "one actuator is wanted here")
            .help("`gearwise identify` takes whole robots, with `--joint` one of their joints"),
    );
}

/// A joint as the bench file describes it.
struct Reading {
    joint: RobotJoint,
    frame: Frame,
    columns: Vec<Column>,
    /// Whether all of it could be read.
    complete: bool,
}

pub(super) fn read(
    root: &Section,
    path: &Path,
    source: &Arc<Source>,
    catalog: Option<Catalog>,
    others: &mut Vec<InputError>,
) -> Option<RobotBench> {
    let name = name_of(root, path);
    let catalog = read_catalog(root, source, catalog, others);
    let kind = root.choice(KIND, BenchKind::NAMES);
    let mut files = vec![source.file()];
    let described = read_mechanism(root, &mut files, others);
    let example = "a table [[joint]] with mechanism_joint = \"elbow_joint\" for each joint";
    let sections = root.some_sections(JOINTS, example);
    let count = sections.len();
    let mut readings: Vec<Reading> = Vec::new();
    let without = read_without(root, &[]).unwrap_or_default();
    for section in sections {
        let robot = described.as_ref().map(|(described, _)| described);
        readings.extend(read_joint(root, section, robot, catalog.as_ref(), readings.len()));
    }
    let mechanism = described.as_ref().map(|(described, _)| &described.mechanism);
    if let (Some(mechanism), true) = (mechanism, readings.len() == count) {
        check_joints(root, mechanism, &readings, described.as_ref().map_or(&[], |(_, fixed)| fixed));
    }
    let sections = root.some_sections(LOGS, LOG);
    let mut plans = Vec::new();
    let mut carrying = Vec::new();
    for section in sections {
        let (own, payloads) = read_log(section, kind, &readings, described.as_ref().map(|(d, _)| d));
        plans.extend(own);
        carrying.push(payloads);
    }
    let wanted = carrying.len() * readings.len();
    let whole = plans.len() == wanted && readings.len() == count && readings.iter().all(|r| r.complete);
    let logs = read_logs(root, plans, &mut files, others)?;
    if !whole || !others.is_empty() {
        return None;
    }
    let (catalog, name, (described, fixed)) = (catalog?, name?, described?);
    files.extend(catalog.files());
    let mut joints: Vec<RobotJoint> = readings.into_iter().map(|r| r.joint).collect();
    for (joint, log) in logs {
        joints[joint].logs.push(log);
    }
    for declared in joints.iter_mut().filter_map(|j| j.declared.as_mut()) {
        let known = declared.all_effects();
        declared.without = without.iter().copied().filter(|e| known.iter().all(|k| k.effect != *e)).collect();
    }
    let carrying = carrying.into_iter().map(|own| own.unwrap_or_else(|| described.payloads.clone())).collect();
    let bare = described.bare;
    let path = path.to_path_buf();
    Some(RobotBench { name, path, catalog, model: described.model, mechanism: bare, fixed, joints, carrying, files })
}

/// The description, and where joints are that do not move.
fn read_mechanism(
    root: &Section,
    files: &mut Vec<InputFile>,
    others: &mut Vec<InputError>,
) -> Option<(Described, Vec<(usize, f64)>)> {
    let Some(section) = root.section(MECHANISM) else {
        if !root.has("mechanism") {
            root.missing("mechanism", "{ model = \"robots/arm.urdf\" }");
        }
        return None;
    };
    let model = described::model(&section);
    let mut open = |path: &Path| {
        let source = Source::read(path)?;
        files.push(source.file());
        Ok(source)
    };
    let described = described::read(&section, model, &mut open, others);
    let fixed = section.section(FIXED);
    let mut places = Vec::new();
    if let (Some(fixed), Some(described)) = (fixed, &described) {
        for (name, text) in fixed.items() {
            let names: Vec<&str> = described.mechanism.joints().map(|j| j.name.as_str()).collect();
            let Some(joint) = described.mechanism.joint(name.get_ref()) else {
                let message = format!("no joint `{}` moves in `{}`", name.get_ref(), described.model);
                section.note(Problem::at(name.span(), message, "named here").suggest(name.get_ref(), names));
                continue;
            };
            let turns = described.mechanism.joints().nth(joint).is_some_and(|j| j.motion == Motion::Turns);
            let kind = if turns { &units::ANGLE } else { &units::LENGTH };
            let value = text.get_ref().as_str().map(|text| units::quantity(text, kind));
            match value {
                Some(Ok(place)) => places.push((joint, place)),
                Some(Err(error)) => {
                    section
                        .note(Problem::at(text.span(), error.message(kind), "not a position").help(error.help(kind)));
                }
                None => section.note(Problem::at(
                    text.span(),
                    format!("where `{}` was is not a text with a unit", name.get_ref()),
                    format!("expected a position, as \"{}\"", if turns { "30 deg" } else { "20 mm" }),
                )),
            }
        }
    }
    section.finish();
    Some((described?, places))
}

/// A joint: which it is, its actuator, and its columns with those of all.
fn read_joint(
    root: &Section,
    section: Section,
    robot: Option<&Described>,
    catalog: Option<&Catalog>,
    number: usize,
) -> Option<Reading> {
    let about = "a joint of the description";
    let name = section.required_text(key("mechanism_joint", about).value("name"), "\"elbow_joint\"");
    let title = section.text(key("name", "of the joint in reports").default("that of the description"));
    let found = name.as_ref().zip(robot).and_then(|(name, robot)| find(&section, name, robot));
    let slides = found.is_some_and(|(_, motion)| motion == Motion::Slides);
    let table = section.section(key("actuator", "the declared model; without it the joint says only how it moves"));
    if let (true, true) = (slides, table.is_some()) {
        section.note(
            Problem::at(section.span_of("actuator"), "a joint that slides has no actuator here", "remove it")
                .help("its motion counts for the others; a bench file of kind `linear` of its own compares its drive"),
        );
        return None;
    }
    let wanted = table.is_some();
    let (declared, frame) = table.and_then(|table| actuator::read(table, catalog, false, Purpose::Identify)).unzip();
    let complete = frame.is_some() == wanted && name.is_some();
    // Of a joint without an actuator only its motion counts; of one that slides, what is in common has other units.
    let moves_only = Frame { torque_constant: Some(1.0), ..Frame::unknown(false) };
    let of_all = frame.as_ref().unwrap_or(&moves_only);
    let (mut common, whole) = root.section(COLUMNS).map_or((Vec::new(), true), |table| columns::read(table, of_all));
    if frame.is_none() {
        common.retain(|c| c.target == Target::Time || !slides && is_motion(c));
    }
    let frame = frame.unwrap_or(Frame::unknown(slides));
    let (own, all) = section
        .section(key("columns", "of this joint, over the common ones"))
        .map_or((Vec::new(), true), |table| columns::read(table, &frame));
    section.finish();
    let name = name?.into_inner();
    let mut columns = columns::merge(&common, own);
    for column in &mut columns {
        column.name = column.name.replace("{joint}", &name).replace("{number}", &number.to_string());
    }
    let title = title.map_or_else(|| name.clone(), Spanned::into_inner);
    let joint = RobotJoint { name: title, number: found?.0, declared, logs: Vec::new() };
    Some(Reading { joint, frame, columns, complete: complete && whole && all })
}

/// Whether a column says how a joint moves.
fn is_motion(column: &Column) -> bool {
    use Channel::*;
    let motion = [MotorPosition, MotorVelocity, OutputPosition, OutputVelocity];
    matches!(column.target, Target::Channel(channel) if motion.contains(&channel))
}

fn find(section: &Section, name: &Spanned<String>, robot: &Described) -> Option<(usize, Motion)> {
    let mechanism = &robot.mechanism;
    let found = mechanism.joints().enumerate().find(|(_, joint)| joint.name == *name.get_ref());
    if found.is_none() {
        let names: Vec<&str> = mechanism.joints().map(|j| j.name.as_str()).collect();
        let message = format!("no joint `{}` moves in `{}`", name.get_ref(), robot.model);
        section.note(Problem::at(name.span(), message, "named here").suggest(name.get_ref(), names));
    }
    found.map(|(number, joint)| (number, joint.motion))
}

/// Every joint of the description moves as one column says, or stays.
fn check_joints(root: &Section, mechanism: &Mechanism, readings: &[Reading], fixed: &[(usize, f64)]) {
    let place = root.span_of("joint");
    for (number, joint) in mechanism.joints().enumerate() {
        let count = readings.iter().filter(|r| r.joint.number == number).count();
        let stays = fixed.iter().any(|(j, _)| *j == number);
        let name = &joint.name;
        let (message, help) = match (count, stays) {
            (0, false) => (
                format!("nothing says where the joint `{name}` of the description is"),
                format!(
                    "give it a table [[joint]], or, where it did not move, [mechanism] fixed = {{ {name} = \"0 {}\" }}",
                    joint.position_unit()
                ),
            ),
            (0, true) | (1, false) => continue,
            (1, true) => (format!("the joint `{name}` is `fixed`, and has a table [[joint]]"), "remove one".into()),
            _ => (format!("the joint `{name}` has two tables [[joint]]"), "remove one".into()),
        };
        root.note(Problem::at(place.clone(), message, "the joints of the logs").help(help));
    }
    let own = |c: &Column| {
        use Channel::*;
        let shared = [Supply, BusCurrent, WindingTemperature, HousingTemperature, Command];
        matches!(c.target, Target::Channel(channel) if !shared.contains(&channel))
    };
    for (k, reading) in readings.iter().enumerate() {
        for column in reading.columns.iter().filter(|c| own(c)) {
            let other = readings[..k].iter().find(|r| r.columns.iter().any(|c| own(c) && c.name == column.name));
            if let Some(other) = other {
                let message =
                    format!("`{}` and `{}` have one column, `{}`", other.joint.name, reading.joint.name, column.name);
                let help =
                    "a name in common [columns] may have `{joint}` in it, which each joint replaces by its own name";
                root.note(Problem::at(column.span.clone(), message, "named here").help(help));
            }
        }
    }
}

/// A log as each joint reads it, and what the robot carried in it, where the log says that.
fn read_log(
    section: Section,
    common: Option<BenchKind>,
    readings: &[Reading],
    robot: Option<&Described>,
) -> (Vec<Plan>, Option<Vec<gearwise_model::mechanism::Payload>>) {
    let recording = read_recording(&section);
    let kind = read_kind(&section, common);
    let payloads = section.has("payload").then(|| {
        let own = described::payloads(&section);
        robot.map_or_else(Vec::new, |robot| described::hang(&section, &mut robot.bare.clone(), own, &robot.model))
    });
    let span = section.span();
    if let Some(kind) = kind.filter(|kind| !matches!(kind, BenchKind::Free | BenchKind::Dynamometer)) {
        section.note(
            Problem::at(span.clone(), format!("a log of a whole robot cannot be of kind `{}`", kind.name()), "of this log")
                .help("kind = \"free\": currents or torques of the drives; kind = \"dynamometer\": torque sensors at the joints"),
        );
    }
    for reading in readings.iter().filter(|r| r.complete) {
        let has = |target: Target| reading.columns.iter().any(|c| c.target == target);
        if let Some(mut problem) = kind.and_then(|kind| needs(kind, &reading.joint, &reading.frame, &span, &has)) {
            problem.message = format!("joint `{}`: {}", reading.joint.name, problem.message);
            section.note(problem);
        }
    }
    section.finish();
    let (Some(recording), Some(kind)) = (recording, kind) else { return (Vec::new(), payloads) };
    let plan = |(joint, reading): (usize, &Reading)| Plan {
        recording: recording.clone(),
        kind,
        joint,
        frame: reading.frame,
        load: KnownLoad::default(),
        controller: None,
        rotor: true,
        columns: reading.columns.clone(),
    };
    (readings.iter().enumerate().map(plan).collect(), payloads)
}

/// What a log lacks for a joint: with an actuator what its kind needs, else how it moves.
fn needs(
    kind: BenchKind,
    joint: &RobotJoint,
    frame: &Frame,
    span: &Span<usize>,
    has: &dyn Fn(Target) -> bool,
) -> Option<Problem> {
    if joint.declared.is_some() {
        let lacks = lacking(kind, false, frame, span, has);
        if lacks.is_some() {
            return lacks;
        }
    }
    let places = [Channel::MotorPosition, Channel::OutputPosition];
    let placed = places.iter().any(|c| has(Target::Channel(*c)));
    (!placed || !has(Target::Time)).then(|| {
        Problem::at(span.clone(), "a log of a whole robot needs `time` and `position`", "this log has no such column")
            .help("the weight of an arm follows from where its joints are: a velocity alone does not say it")
    })
}
