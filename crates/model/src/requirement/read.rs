//! Requirement files: TOML to a robot, every mistake with its place.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use super::bus::{self, Bus, Regeneration};
use super::motions::{FromDisk, MotionReader, Motions};
use super::robot::{Budget, Robot};
use super::{carried, cases, coupling, joint, map_file, mechanism, prices};
use crate::input::kind::{self, FileKind};
use crate::input::{Change, Description, Form, InputError, Problem, Range, Section, Source, key, limits};
use crate::units;

/// Room temperature, where no ambient is given \[K\].
const AMBIENT: f64 = 298.15;

/// Reads a requirement file and the motions that it names.
///
/// # Errors
/// All mistakes of the file, then all mistakes of its motions.
pub fn read(path: &Path) -> Result<Robot, Vec<InputError>> {
    read_source(&Source::read(path).map_err(|e| vec![e])?)
}

/// As [`read`], for what cannot choose a spring: a joint that asks for one is a mistake. `what` says who
/// cannot.
///
/// # Errors
/// As [`read`], and every spring.
pub fn read_without_springs(path: &Path, what: &str) -> Result<Robot, Vec<InputError>> {
    read_as(&Source::read(path).map_err(|e| vec![e])?, &[], Some(what), &mut FromDisk::default(), [1.0; 2])
}

/// Reads a requirement from a source; motions are looked for beside it.
///
/// # Errors
/// As [`read`].
pub fn read_source(source: &Arc<Source>) -> Result<Robot, Vec<InputError>> {
    read_as(source, &[], None, &mut FromDisk::default(), [1.0; 2])
}

/// As [`read_source`], with values in the place of the file's own, and motions from a store.
///
/// # Errors
/// As [`read`]; [`Change::send_home`] sorts the problems with the changes out.
pub fn read_changed(
    source: &Arc<Source>,
    changes: &[Change],
    motions: &mut dyn Motions,
) -> Result<Robot, Vec<InputError>> {
    read_as(source, changes, None, motions, [1.0; 2])
}

/// As [`read_changed`], with factors on torque and speed of all motions.
///
/// # Errors
/// As [`read_changed`].
pub fn read_scaled(
    source: &Arc<Source>,
    changes: &[Change],
    factors: [f64; 2],
    motions: &mut dyn Motions,
) -> Result<Robot, Vec<InputError>> {
    read_as(source, changes, None, motions, factors)
}

/// Every table that the reader looks into.
const SKELETON: &str = "
bus = {}
ambient = {}
budget = {}
prices = { rates = {} }
mechanism = { payload = {} }
[[joint]]
ratio = { teeth = {} }
gear = {}
motion = ''
scale = {}
objective = {}
reference = {}
limits = { torque_bandwidth = {}, spring = {}, reserve = {} }
transmission = { four_bar = {}, lever = {} }
spring = {}
drive = {}
mount = {}
[[joint]]
gears = []
points = [{}]
objective = ''
[[joint]]
family = ['a']
between = true
[[joint]]
mechanism_joint = 'a'
actuator_at = {}
[[joint]]
order = [{}]
[[joint.case]]
motion = ''
scale = {}
[[joint.case]]
points = [{}]
[[case]]
joints = {}
[[coupling]]
rods = [{}]
";

/// What the reader asks for.
pub fn describe() -> Description {
    let mut motions = FromDisk::default();
    let mut reader = MotionReader::new(&mut motions, 1.0);
    Form::describe(SKELETON, |root| read_robot(root, None, &mut reader))
}

/// Bare numbers of a program, each with its place and unit.
pub(super) fn bare_numbers(
    source: &Arc<Source>,
    changes: &[Change],
    motions: &mut dyn Motions,
) -> Vec<(std::ops::Range<usize>, &'static str)> {
    let mut reader = MotionReader::new(motions, 1.0);
    Form::bare_numbers(source, changes, |root| read_robot(root, None, &mut reader))
}

pub(super) fn read_as(
    source: &Arc<Source>,
    changes: &[Change],
    no_springs: Option<&str>,
    motions: &mut dyn Motions,
    [torque, speed]: [f64; 2],
) -> Result<Robot, Vec<InputError>> {
    let mut reader = MotionReader::new(motions, speed);
    let robot = Form::read_changed(source, changes, |root| read_robot(root, no_springs, &mut reader));
    let robot = robot.map(|mut robot| {
        scale(&mut robot, torque, speed);
        Robot { set: changes.iter().map(Change::said).collect(), ..robot }
    });
    let read = Form::with_others(robot, reader.errors);
    read.map_err(|errors| kind::instead_of_all(errors, source, &[FileKind::Requirement]))
}

/// Multiplies the motions of all joints: torques by the one factor; the same positions at another speed by the other.
fn scale(robot: &mut Robot, torque: f64, speed: f64) {
    // As it is, it is shared.
    if (torque, speed) == (1.0, 1.0) {
        return;
    }
    let joints = std::mem::take(&mut robot.joints);
    robot.joints = joints.into_iter().map(|joint| joint.scaled(torque, speed)).collect();
}

fn read_robot(root: &Section, no_springs: Option<&str>, motions: &mut MotionReader) -> Option<Robot> {
    let name = root.required_text(key("name", "name of the robot"), "\"quadruped\"").map(|t| t.into_inner());
    let rules = root
        .text(key("rules", "rules file that a design has to keep, for `optimize` and `check`").value("file"))
        .map(|file| root.source().folder().join(file.get_ref()));
    let bus = match root.section(key("bus", "the supply").required()) {
        Some(section) => bus::read(section),
        None => {
            if !root.has("bus") {
                root.missing("bus", "{ voltage = \"48 V\" }");
            }
            None
        }
    };
    let ambient = root.section(key("ambient", "the surroundings")).and_then(|section| {
        let temperature = section.quantity(
            key("temperature", "of the surroundings").default("25 degC"),
            &units::TEMPERATURE,
            Range::Positive,
        );
        section.finish();
        temperature
    });
    let surroundings = ambient.unwrap_or(AMBIENT);
    let budget = root.section(key("budget", "what the whole robot may have")).map(|section| {
        let budget = Budget {
            actuator_mass: section.quantity(
                key("actuator_mass", "all actuators together, counts included"),
                &units::MASS,
                Range::Positive,
            ),
            max_distinct_motors: section.count(key("max_distinct_motors", "how many different motors at most")),
            power: section.quantity(
                key("power", "what all joints together may take from the bus at any instant"),
                &units::POWER,
                Range::Positive,
            ),
            current: section.quantity(
                key("current", "the same as a current of the bus"),
                &units::CURRENT,
                Range::Positive,
            ),
            regeneration: section.quantity(
                key(
                    "regeneration",
                    "what the bus takes back from all joints together at any instant; what a brake burns is added",
                ),
                &units::POWER,
                Range::NonNegative,
            ),
        };
        let takes_all = |bus: &Bus| bus.regeneration == Regeneration::Dissipated && bus.brake_power.is_none();
        if budget.regeneration.is_some() && bus.as_ref().is_some_and(takes_all) {
            let message = "`regeneration` of [budget] limits nothing: the braking resistor of the [bus] takes all";
            let problem = Problem::at(section.span_of("regeneration"), message, "nothing comes back");
            section.note(problem.help(
                "a resistor that takes some of it is brake_power = \"500 W\" in [bus] without `regeneration` there",
            ));
        }
        section.finish();
        budget
    });
    let money = prices::read(root);
    let takes_nothing = |bus: &Bus| bus.brake_power.is_some() && bus.regeneration == Regeneration::Allowed;
    let limited = budget.as_ref().is_some_and(|budget| budget.regeneration.is_some());
    if bus.as_ref().is_some_and(takes_nothing) && !limited {
        let message =
            "`brake_power` of [bus] has nothing to take: `regeneration` is allowed, so that the supply takes all";
        let help = "say regeneration = \"none\", \"dissipated\", or a power; or `regeneration` in [budget], for all joints together";
        root.note(Problem::at(root.span_of("bus"), message, "nothing to act on").help(help));
    }
    let sections =
        root.some_sections(key("joint", "the joints, at least one").required(), "a table [[joint]] for each joint");
    if let Some(extra) = sections.get(limits::JOINTS) {
        let message = limits::too_many("joints", sections.len(), limits::JOINTS);
        root.note(Problem::at(extra.span(), message, "one too many").help("split the robot into several requirements"));
        return None;
    }
    let model = mechanism::read(root, motions);
    let all: Vec<String> = sections.iter().filter_map(|s| s.text("name")).map(|n| n.into_inner()).collect();
    let mut names = HashSet::new();
    let (mut joints, mut uses, mut carried, mut places) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut complete = true;
    let mut samples = 0;
    for section in sections {
        let span = section.span();
        let duplicate = section.text("name").filter(|n| !names.insert(n.get_ref().clone()));
        if let Some(name) = duplicate {
            root.note(Problem::at(name.span(), format!("two joints are called `{}`", name.get_ref()), "second time"));
        }
        match joint::read(section, surroundings, no_springs, &all, &money, &model, motions) {
            Some((joint, taken, carries)) => {
                samples += joint.motion.len();
                if samples > limits::SAMPLES {
                    let message = limits::too_many("samples of all joints together", samples, limits::SAMPLES);
                    root.note(
                        Problem::at(span.clone(), message, "reached here").help("take every n-th row of the motions"),
                    );
                    return None;
                }
                joints.push(joint);
                places.push(span);
                uses.push(taken);
                carried.push(carries);
            }
            None => complete = false,
        }
    }
    for (k, taken) in uses.iter().enumerate().filter_map(|(k, taken)| Some((k, taken.as_ref()?))) {
        let first = uses[..k].iter().position(|other| other.as_ref().is_some_and(|other| other.is_of_the_same(taken)));
        if let Some(first) = first {
            let message = format!("`{}` and `{}` have one `mechanism_joint`", joints[first].name, joints[k].name);
            let problem = Problem::at(taken.said.clone(), message, "its torque would count twice");
            root.note(problem.help("two actuators of one joint share its torque: describe them as one"));
            complete = false;
        }
    }
    let told = cases::told(root);
    let couplings = coupling::read(root, &money, motions);
    if !complete {
        return None;
    }
    let separate = matches!(&model, mechanism::Model::Read(known) if known.leaves_actuators_out());
    let (uses_of, carried_of, places_of) = (&mut uses, &mut carried, &mut places);
    let mut beside = coupling::Beside { uses: uses_of, carried: carried_of, places: places_of, separate };
    coupling::resolve(root, couplings, &mut joints, &mut beside)?;
    let spans = uses.iter().map(|u| u.as_ref().map_or(0..0, |u| u.said.clone())).collect();
    let driven = mechanism::driven(model, &uses);
    if let Some(driven) = &driven {
        mechanism::load(driven, &mut joints);
    }
    carried::resolve(root, &mut joints, carried, spans)?;
    map_file::check_robot(root, &joints, &places, budget.unwrap_or_default());
    let cases = cases::resolve(root, told, &joints)?;
    Some(Robot {
        name: name?,
        bus: bus?,
        ambient: surroundings,
        budget: budget.unwrap_or_default(),
        prices: money.prices(),
        joints,
        cases,
        driven,
        rules,
        set: Vec::new(),
        sources: [vec![root.source().clone()], std::mem::take(&mut motions.opened)].concat(),
    })
}
