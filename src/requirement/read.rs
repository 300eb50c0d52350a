//! Requirement files: TOML to a robot, every mistake with its place.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::carried::{self, Asked};
use super::mechanism::{self, Model, Use};
use super::robot::*;
use crate::catalog::convention::Modulation;
use crate::input::{Change, Form, InputError, Problem, Range, Section, Source, limits};
use crate::motion::{self, CarriedColumn, Motion, Point};
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
    read_as(&Source::read(path).map_err(|e| vec![e])?, &[], Some(what), &mut FromDisk::default())
}

/// Reads a requirement from a source; motions are looked for beside it.
///
/// # Errors
/// As [`read`].
pub fn read_source(source: &Arc<Source>) -> Result<Robot, Vec<InputError>> {
    read_as(source, &[], None, &mut FromDisk::default())
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
    read_as(source, changes, None, motions)
}

/// Where motions come from: [`FromDisk`], or a store that has read them before.
pub trait Motions {
    /// The file.
    ///
    /// # Errors
    /// It cannot be read.
    fn open(&mut self, path: &Path) -> Result<Arc<Source>, InputError> {
        Source::read(path)
    }

    /// The motion in it, with its columns of torque per mass for actuators of `joints` that are carried.
    ///
    /// # Errors
    /// Every mistake of the file.
    fn motion(
        &mut self,
        source: &Arc<Source>,
        periodic: bool,
        period: Option<f64>,
        joints: &[String],
    ) -> Result<(Motion, Vec<CarriedColumn>), InputError> {
        motion::read_carrying(source, periodic, period, joints)
    }
}

/// Each file is read once, whatever joints name it: all of them see the same motion.
#[derive(Debug, Default)]
pub struct FromDisk(HashMap<PathBuf, Arc<Source>>);

impl Motions for FromDisk {
    fn open(&mut self, path: &Path) -> Result<Arc<Source>, InputError> {
        if let Some(known) = self.0.get(path) {
            return Ok(known.clone());
        }
        let source = Source::read(path)?;
        self.0.insert(path.to_path_buf(), source.clone());
        Ok(source)
    }
}

/// Where a reading's motions come from, and what was wrong with them.
pub(super) struct MotionReader<'m> {
    pub(super) motions: &'m mut dyn Motions,
    pub(super) errors: Vec<InputError>,
}

fn read_as(
    source: &Arc<Source>,
    changes: &[Change],
    no_springs: Option<&str>,
    motions: &mut dyn Motions,
) -> Result<Robot, Vec<InputError>> {
    let mut reader = MotionReader { motions, errors: Vec::new() };
    let robot = Form::read_changed(source, changes, |root| read_robot(root, no_springs, &mut reader));
    Form::with_others(robot, reader.errors)
}

fn read_robot(root: &Section, no_springs: Option<&str>, motions: &mut MotionReader) -> Option<Robot> {
    let name = root.required_text("name", "\"quadruped\"").map(|t| t.into_inner());
    let bus = match root.section("bus") {
        Some(section) => read_bus(section),
        None => {
            if !root.has("bus") {
                root.missing("bus", "{ voltage = \"48 V\" }");
            }
            None
        }
    };
    let ambient = root.section("ambient").and_then(|section| {
        let temperature = section.quantity("temperature", &units::TEMPERATURE, Range::Positive);
        section.finish();
        temperature
    });
    let surroundings = ambient.unwrap_or(AMBIENT);
    let budget = root.section("budget").map(|section| {
        let budget = Budget {
            actuator_mass: section.quantity("actuator_mass", &units::MASS, Range::Positive),
            max_distinct_motors: section.count("max_distinct_motors"),
            power: section.quantity("power", &units::POWER, Range::Positive),
            current: section.quantity("current", &units::CURRENT, Range::Positive),
        };
        section.finish();
        budget
    });
    let sections = root.sections("joint");
    if sections.is_empty() && !root.has("joint") {
        root.missing("joint", "a table [[joint]] for each joint");
    }
    if let Some(extra) = sections.get(limits::JOINTS) {
        let message = limits::too_many("joints", sections.len(), limits::JOINTS);
        root.note(Problem::at(extra.span(), message, "one too many").help("split the robot into several requirements"));
        return None;
    }
    let model = mechanism::read(root, motions);
    let all: Vec<String> = sections.iter().filter_map(|s| s.text("name")).map(|n| n.into_inner()).collect();
    let mut names = HashSet::new();
    let (mut joints, mut uses, mut carried) = (Vec::new(), Vec::new(), Vec::new());
    let mut complete = true;
    let mut samples = 0;
    for section in sections {
        let span = section.span();
        let duplicate = section.text("name").filter(|n| !names.insert(n.get_ref().clone()));
        if let Some(name) = duplicate {
            root.note(Problem::at(name.span(), format!("two joints are called `{}`", name.get_ref()), "second time"));
        }
        match read_joint(section, surroundings, no_springs, &all, &model, motions) {
            Some((joint, taken, carries)) => {
                samples += joint.motion.len();
                if samples > limits::SAMPLES {
                    let message = limits::too_many("samples of all joints together", samples, limits::SAMPLES);
                    root.note(Problem::at(span, message, "reached here").help("take every n-th row of the motions"));
                    return None;
                }
                joints.push(joint);
                uses.push(taken);
                carried.push(carries);
            }
            None => complete = false,
        }
    }
    if !complete {
        return None;
    }
    let spans = uses.iter().map(|u| u.as_ref().map_or(0..0, |u| u.said.clone())).collect();
    let driven = mechanism::driven(model, &uses);
    if let Some(driven) = &driven {
        driven.load(&mut joints);
    }
    carried::resolve(root, &mut joints, carried, spans)?;
    Some(Robot { name: name?, bus: bus?, ambient: surroundings, budget: budget.unwrap_or_default(), joints, driven })
}

fn read_bus(section: Section) -> Option<Bus> {
    let voltage = section.required_quantity("voltage", &units::VOLTAGE, Range::Positive);
    let regeneration = section.text("regeneration").map(|text| match text.get_ref().as_str() {
        "allowed" => Some(Regeneration::Allowed),
        "none" => Some(Regeneration::Limited(0.0)),
        other => match units::quantity(other, &units::POWER) {
            Ok(power) if power >= 0.0 => Some(Regeneration::Limited(power)),
            _ => {
                section.note(
                    Problem::at(
                        text.span(),
                        format!("`regeneration` of [bus] cannot be `{other}`"),
                        "expected allowed, none, or a power",
                    )
                    .help("for example regeneration = \"none\" or regeneration = \"200 W\""),
                );
                None
            }
        },
    });
    let bus = Bus {
        voltage: voltage.unwrap_or(f64::NAN),
        modulation: section.choice("modulation", Modulation::NAMES).unwrap_or(Modulation::SpaceVector),
        modulation_limit: section.number("modulation_limit", Range::Fraction).unwrap_or(1.0),
        drive_current: section.quantity("drive_current", &units::CURRENT, Range::Positive),
        power: section.quantity("power", &units::POWER, Range::Positive),
        current: section.quantity("current", &units::CURRENT, Range::Positive),
        regeneration: regeneration.flatten().unwrap_or(Regeneration::Allowed),
        drive_efficiency: section.number("drive_efficiency", Range::Fraction).unwrap_or(1.0),
    };
    section.finish();
    voltage.map(|_| bus)
}

fn read_joint(
    section: Section,
    ambient: f64,
    no_springs: Option<&str>,
    joints: &[String],
    model: &Model,
    motions: &mut MotionReader,
) -> Option<(Joint, Option<Use>, Vec<Asked>)> {
    let name = section.required_text("name", "\"knee\"").map(|t| t.into_inner());
    let count = section.count("count").unwrap_or(1);
    let ratio = read_ratio(&section);
    let gear = match section.section("gear") {
        Some(gear) => {
            if matches!(ratio, Some(RatioChoice::Catalog { .. })) {
                section.note(
                    Problem::at(
                        gear.span(),
                        "`gear` describes the gear of a continuous ratio, but `gears` takes them from the catalogue",
                        "not used with `gears`",
                    )
                    .help("remove one of the two"),
                );
            }
            read_gear(gear)
        }
        None => GearModel::IDEAL,
    };
    let (read, taken) = if section.has("mechanism_joint") {
        let (motion, taken) = mechanism::read_joint(&section, model).unzip();
        (motion.map(|m| (m, Vec::new())), taken)
    } else {
        (read_motion(&section, joints, name.as_ref(), motions), None)
    };
    let (motion, columns) = read.unzip();
    let objective = read_objective(&section);
    let points = section.has("points");
    let (mut limits, in_limits) = match section.section("limits") {
        Some(table) => {
            let spring = table.section("spring").map(|s| (s.span(), read_spring(s)));
            (read_limits(table, ambient), spring)
        }
        None => (Limits::default(), None),
    };
    let of_joint = section.section("spring").map(|s| (s.span(), read_spring(s)));
    if let (Some(_), Some((span, _))) = (&in_limits, &of_joint) {
        let message = "a joint has one `spring`, in [joint.limits] or in [[joint]], not in both";
        section.note(Problem::at(span.clone(), message, "remove one of the two"));
    }
    if let Some((span, spring)) = in_limits.or(of_joint) {
        limits.spring = spring;
        if let Some(what) = no_springs {
            let message = format!("{what} cannot choose a spring");
            let help = "`optimize` and `explain` choose it with the ratio; or remove `spring`";
            section.note(Problem::at(span, message, "asked for here").help(help));
        } else if points {
            let message = "a spring needs a motion with a position, not operating points";
            section.note(
                Problem::at(span, message, "the points say no position").help("give `motion`, or remove `spring`"),
            );
        } else if spring.is_some() && motion.as_ref().is_some_and(|m| m.position.is_none()) {
            let message = "a spring needs the position, but the motion does not come back to where it began";
            section.note(Problem::at(span, message, "the motion's position is not periodic").help(
                "give a column `position` that repeats its first row, or `periodic = false`, or remove `spring`",
            ));
        }
    }
    let drive_current = section.section("drive").and_then(|drive| {
        let current = drive.required_quantity("current", &units::CURRENT, Range::Positive);
        drive.finish();
        current
    });
    if section.has("actuator") {
        let span = section.span_of("actuator");
        section.note(Problem::at(span, "`actuator` is not supported by this version", "remove it"));
    }
    let carries = carried::read(&section, columns.unwrap_or_default());
    let phases = read_phases(&section, count, motion.as_ref());
    section.finish();
    let joint = Joint {
        name: name?,
        count,
        ratio: ratio?,
        gear,
        motion: motion?,
        objective: objective?,
        limits,
        drive_current,
        phases,
        carries: Vec::new(),
    };
    Some((joint, taken, carries))
}

/// By how much of the period each of several joints is late.
fn read_phases(section: &Section, count: u32, motion: Option<&Motion>) -> Vec<f64> {
    let Some(phases) = section.number_list("phases", Range::Any) else { return Vec::new() };
    let span = section.span_of("phases");
    if phases.len() != count as usize {
        let message = format!("`phases` has {} entries, but `count` is {count}", phases.len());
        section.note(
            Problem::at(span, message, "expected one for each of the joints")
                .help("for example count = 4 and phases = [0, 0.5, 0.5, 0]"),
        );
    } else if phases.iter().any(|p| !(0.0..=1.0).contains(p)) {
        let message = "`phases` are shares of the period";
        section.note(Problem::at(span, message, "expected numbers from 0 to 1").help("half a period late is 0.5"));
    } else if motion.is_some_and(|m| !matches!(m.course, motion::Course::Periodic(_))) {
        let message = "`phases` need a motion that repeats";
        section
            .note(Problem::at(span, message, "this joint has none").help("give a periodic `motion`, or remove them"));
    }
    phases
}

fn read_ratio(section: &Section) -> Option<RatioChoice> {
    match (section.has("ratio"), section.has("gears")) {
        (true, true) => {
            section.note(Problem::at(
                section.span_of("gears"),
                "a joint has `ratio` or `gears`, not both",
                "remove one of the two",
            ));
            None
        }
        (false, false) => {
            section.missing("ratio", "{ min = 3, max = 30 }");
            None
        }
        (false, true) => {
            let patterns = section.texts("gears")?;
            Some(RatioChoice::Catalog {
                patterns: patterns.into_iter().map(|p| p.into_inner()).collect(),
                efficiency_covers: section
                    .choice("efficiency_covers", EfficiencyCovers::NAMES)
                    .unwrap_or(EfficiencyCovers::Load),
            })
        }
        (true, false) => {
            let ratio = section.section("ratio")?;
            let (min, max) = (ratio.number("min", Range::Positive), ratio.number("max", Range::Positive));
            for (key, value) in [("min", min), ("max", max)] {
                if value.is_none() && !ratio.has(if key == "min" { "min" } else { "max" }) {
                    ratio.missing(if key == "min" { "min" } else { "max" }, if key == "min" { "3" } else { "30" });
                }
            }
            let (span, max_span) = (ratio.span(), ratio.span_of("max"));
            ratio.finish();
            let (min, max) = (min?, max?);
            if min > max {
                section.note(
                    Problem::at(
                        max_span,
                        format!("the ratio range is upside down: max = {max} is less than min = {min}"),
                        "less than min",
                    )
                    .help("swap min and max"),
                );
                return None;
            }
            if max / min > 1e6 || max > 1e6 || min < 1e-6 {
                section.note(Problem::at(
                    span,
                    "the ratio range is not one of a gear",
                    "expected ratios between 1e-6 and 1e6, at most a factor of 1e6 apart",
                ));
                return None;
            }
            Some(RatioChoice::Continuous { min, max })
        }
    }
}

fn read_gear(section: Section) -> GearModel {
    let efficiency = section.number("efficiency", Range::Fraction).unwrap_or(1.0);
    let backdrive = section.number("backdrive_efficiency", Range::Any);
    if backdrive.is_some_and(|b| b > 1.0) {
        section.note(Problem::at(
            section.span_of("backdrive_efficiency"),
            "`backdrive_efficiency` of [gear] is out of range",
            "expected at most 1",
        ));
    }
    let per_stage = section.quantity("mass_per_stage", &units::MASS, Range::NonNegative);
    let stage_ratio = section.number("stage_ratio", Range::AtLeastOne);
    let mass = section.quantity("mass", &units::MASS, Range::NonNegative);
    match (per_stage, stage_ratio) {
        (Some(_), Some(ratio)) if ratio < 1.1 => {
            section.note(Problem::at(
                section.span_of("stage_ratio"),
                "`stage_ratio` of [gear] is out of range",
                "expected at least 1.1",
            ));
        }
        (Some(_), None) if !section.has("stage_ratio") => {
            section.missing("stage_ratio", "5  # largest ratio of one stage")
        }
        (None, Some(_)) if !section.has("mass_per_stage") => section.missing("mass_per_stage", "\"120 g\""),
        _ => {}
    }
    if per_stage.is_some() && mass.is_some() {
        section.note(Problem::at(
            section.span_of("mass_per_stage"),
            "a gear has `mass` or `mass_per_stage`, not both",
            "remove one of the two",
        ));
    }
    let gear = GearModel {
        efficiency,
        backdrive_efficiency: backdrive.unwrap_or_else(|| backdrive_efficiency(efficiency)),
        mass: mass.or(if per_stage.is_some() { None } else { Some(0.0) }),
        mass_per_stage: per_stage.zip(stage_ratio),
        inertia: section.quantity("inertia", &units::INERTIA, Range::NonNegative).unwrap_or(0.0),
        peak_torque: section.quantity("peak_torque", &units::TORQUE, Range::Positive),
        continuous_torque: section.quantity("continuous_torque", &units::TORQUE, Range::Positive),
        max_input_speed: section.quantity("max_input_speed", &units::SPEED, Range::Positive),
    };
    if section.choice("efficiency_covers", EfficiencyCovers::NAMES) == Some(EfficiencyCovers::LoadAndGear) {
        let span = section.span_of("efficiency_covers");
        section.note(
            Problem::at(span, "`efficiency_covers = \"load_and_gear\"` needs gears of the catalogue", "not with a continuous ratio")
                .help("which way power flows through the gear then depends on the ratio; use `gears`, or cover the load alone"),
        );
    }
    section.finish();
    gear
}

/// The motion, and the columns of torque per mass in its file.
fn read_motion(
    section: &Section,
    joints: &[String],
    name: Option<&String>,
    motions: &mut MotionReader,
) -> Option<(Motion, Vec<CarriedColumn>)> {
    let periodic = section.boolean("periodic").unwrap_or(true);
    let period = section.quantity("period", &units::TIME, Range::Positive);
    let every = section.quantity("repeat_every", &units::TIME, Range::Positive);
    let read = match (section.has("motion"), section.has("points")) {
        (true, true) => {
            section.note(Problem::at(
                section.span_of("points"),
                "a joint has `motion` or `points`, not both",
                "remove one of the two",
            ));
            None
        }
        (false, false) => {
            section.missing(
                "motion",
                "\"motions/knee.csv\", or points = [ { torque = \"18 N*m\", speed = \"0 rad/s\" } ], or mechanism_joint = \"knee_joint\"",
            );
            None
        }
        (false, true) => {
            for key in ["periodic", "period"].into_iter().filter(|key| section.has(key)) {
                let problem = Problem::at(
                    section.span_of(key),
                    format!("`{key}` says nothing of operating points"),
                    "points have durations and no order",
                );
                section.note(problem.help("remove it, or give a `motion`"));
            }
            Some((read_points(section)?, Vec::new()))
        }
        (true, false) => {
            let file = section.text("motion")?;
            let path = section.source().folder().join(file.get_ref());
            match motions.motions.open(&path) {
                Ok(source) => {
                    // Many joints have many motions: the names of all others are for the few that ask for them.
                    let others: Vec<String> = match motion::may_carry(&source) {
                        true => joints.iter().filter(|j| name != Some(*j)).cloned().collect(),
                        false => Vec::new(),
                    };
                    motions.motions.motion(&source, periodic, period, &others).map_err(|e| motions.errors.push(e)).ok()
                }
                Err(error) => {
                    let first = error.problems.into_iter().next();
                    let (message, help) = first.map_or((String::new(), None), |p| (p.message, p.help));
                    let mut problem =
                        Problem::at(file.span(), format!("motion `{}`: {message}", file.get_ref()), "named here");
                    problem.help = help;
                    section.note(problem);
                    None
                }
            }
        }
    };
    let (mut motion, carried) = read?;
    motion.repeat_every = repeat_every(section, every, motion.course);
    Some((motion, carried))
}

/// After what time a motion that happens once is made again \[s\], as asked; `None` where it is not, or where that is a
/// mistake, which is noted.
pub(super) fn repeat_every(section: &Section, every: Option<f64>, course: motion::Course) -> Option<f64> {
    let every = every?;
    let span = section.span_of("repeat_every");
    let needs = "`repeat_every` needs a motion that happens once";
    section.note(match course {
        motion::Course::Once(lasts) if every >= lasts => return Some(every),
        motion::Course::Once(lasts) => {
            let message = format!("the motion lasts {lasts} s, but is to be made again after {every} s");
            Problem::at(span, message, "before it ends").help("give the time from one start to the next, rest included")
        }
        motion::Course::Periodic(_) => Problem::at(span, needs, "this one repeats without rest")
            .help("set `periodic = false`, or remove `repeat_every`"),
        motion::Course::Points(_) => Problem::at(span, needs, "not with operating points")
            .help("give a `motion` and `periodic = false`; or add a point at rest without torque, with its duration"),
    });
    None
}

fn read_points(section: &Section) -> Option<Motion> {
    let mut points = Vec::new();
    let mut complete = true;
    let (mut timed, mut untimed) = (0, 0);
    let sections = section.sections("points");
    if sections.is_empty() {
        section.note(
            Problem::at(section.span_of("points"), "`points` is empty", "expected at least one operating point")
                .help("for example points = [ { torque = \"18 N*m\", speed = \"0 rad/s\", duration = \"0.5 s\" } ]"),
        );
        return None;
    }
    for point in sections {
        let torque = point.required_quantity("torque", &units::TORQUE, Range::Any);
        let speed = point.required_quantity("speed", &units::SPEED, Range::Any);
        let optional = |key, kind| point.quantity(key, kind, Range::Any).unwrap_or(0.0);
        let acceleration = optional("acceleration", &units::ACCELERATION);
        let torque_rate = optional("torque_rate", &units::TORQUE_RATE);
        let jerk = optional("jerk", &units::JERK);
        let duration = point.quantity("duration", &units::TIME, Range::Positive);
        if duration.is_some() {
            timed += 1
        } else {
            untimed += 1
        }
        point.finish();
        match (torque, speed) {
            (Some(torque), Some(velocity)) => {
                points.push(Point { torque, velocity, acceleration, torque_rate, jerk, duration })
            }
            _ => complete = false,
        }
    }
    if timed > 0 && untimed > 0 {
        section.note(Problem::at(
            section.span_of("points"),
            format!("{timed} points have a `duration` and {untimed} have none"),
            "give all of them a duration, or none",
        ));
        return None;
    }
    complete.then(|| Motion::from_points(&points))
}

fn read_objective(section: &Section) -> Option<Objective> {
    if !section.has("objective") {
        return Some(Objective::single(Quantity::Loss));
    }
    if !section.is_table("objective") {
        return section.choice("objective", Quantity::NAMES).map(Objective::single);
    }
    let table = section.section("objective")?;
    let weight = |(name, quantity): &(&'static str, Quantity)| {
        table.number(name, Range::NonNegative).map(|weight| (*name, *quantity, weight))
    };
    let weights: Vec<_> = Quantity::NAMES.iter().filter_map(weight).collect();
    let span = table.span();
    table.finish();
    let reference_span;
    let mut references = Vec::new();
    match section.section("reference") {
        Some(reference) => {
            reference_span = reference.span();
            for (name, quantity) in Quantity::NAMES {
                if let Some(value) = reference.quantity(name, quantity.kind(), Range::Positive) {
                    references.push((*name, value));
                }
            }
            reference.finish();
        }
        None => {
            reference_span = span.clone();
        }
    }
    if !weights.iter().any(|(.., weight)| *weight > 0.0) {
        section.note(Problem::at(
            span,
            "the objective has no weight above zero",
            "expected for example { loss = 1, reflected_inertia = 0.5 }",
        ));
        return None;
    }
    let mut terms = Vec::new();
    for (name, quantity, weight) in weights.into_iter().filter(|(.., weight)| *weight != 0.0) {
        match references.iter().find(|(n, _)| *n == name) {
            Some((_, reference)) => terms.push((quantity, weight / reference)),
            None => section.note(
                Problem::at(
                    reference_span.clone(),
                    format!("the weighted objective needs a reference for `{name}`"),
                    "not in `reference`",
                )
                .help(format!("for example reference = {{ {name} = \"1 {}\" }}", quantity.unit())),
            ),
        }
    }
    terms.sort_by_key(|(quantity, _)| *quantity);
    Some(Objective { terms })
}

fn read_spring(section: Section) -> Option<Spring> {
    const STIFFNESS: &str = "[\"0 N*m/rad\", \"50 N*m/rad\"]";
    const REST_ANGLE: &str = "[\"-90 deg\", \"90 deg\"]";
    for (key, example) in [("stiffness", STIFFNESS), ("rest_angle", REST_ANGLE)] {
        if !section.has(key) {
            section.missing(key, example);
        }
    }
    let stiffness = section.quantity_range("stiffness", &units::STIFFNESS, Range::NonNegative);
    let rest_angle = section.quantity_range("rest_angle", &units::ANGLE, Range::Any);
    section.finish();
    Some(Spring { stiffness: stiffness?, rest_angle: rest_angle? })
}

fn read_limits(section: Section, ambient: f64) -> Limits {
    let bandwidth = section.section("torque_bandwidth").and_then(|table| {
        let frequency = table.required_quantity("frequency", &units::FREQUENCY, Range::Positive);
        let amplitude = table.required_quantity("amplitude", &units::TORQUE, Range::NonNegative);
        table.finish();
        Some(TorqueBandwidth { frequency: frequency?, amplitude: amplitude? })
    });
    let limits = Limits {
        actuator_mass: section.quantity("actuator_mass", &units::MASS, Range::Positive),
        reflected_inertia: section.quantity("reflected_inertia", &units::INERTIA, Range::Positive),
        torque_bandwidth: bandwidth,
        winding_temperature: section.quantity("winding_temperature", &units::TEMPERATURE, Range::Positive),
        safety: section.number("safety", Range::Positive).unwrap_or(1.0),
        spring: None,
    };
    if limits.winding_temperature.is_some_and(|t| t <= ambient) {
        section.note(Problem::at(
            section.span_of("winding_temperature"),
            "the winding may not even be as warm as its surroundings",
            format!("expected more than the ambient temperature, {} degC", crate::words::number(ambient - 273.15)),
        ));
    }
    section.finish();
    limits
}
