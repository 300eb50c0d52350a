//! Design files: which motor at which ratio was chosen for each joint of a requirement.
//!
//! The one idea: reading needs no catalogue. [`DesignFile::read`] takes the file, its requirement and its fitted
//! actuators and checks all that they say of each other; [`DesignFile::choices`] then looks motors and gears up.
//! Every part of a joint keeps its place, so that whoever judges or exports a design can point at it.

use std::collections::HashMap;
use std::ops::Range as Span;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::gear::RatioChoice;
use super::gear_map::FamilyPlace;
use super::robot::{Joint, Robot};
use super::set::{SET, Settings};
use crate::catalog::{Catalog, Gear, Motor, is_word, place, read_fitted};
use crate::input::kind::{self, FileKind};
use crate::input::{Description, Form, InputError, Key, Problem, Range, Section, Source, key, limits};
use crate::units;
use crate::words::nearest;
use crate::words::number;

/// A design file with the requirement that it answers.
#[derive(Debug, Clone)]
pub struct DesignFile {
    /// The file.
    pub source: Arc<Source>,
    /// The requirement's file.
    pub requirement: Arc<Source>,
    /// Where the requirement is named.
    pub requirement_span: Span<usize>,
    /// What the requirement says.
    pub robot: Robot,
    /// Values that were set in the place of the requirement's.
    pub set: Settings,
    /// Catalogue files and folders that the design takes its rows from; empty for the built-in ones.
    pub catalog: Vec<PathBuf>,
    /// The rules that the design is checked by.
    pub rules: Option<PathBuf>,
    /// What was chosen, in the order of the requirement's joints, one for each.
    pub joints: Vec<JointDesign>,
}

/// What was chosen for one joint.
#[derive(Debug, Clone)]
pub struct JointDesign {
    /// Name of the joint.
    pub name: String,
    /// The motor.
    pub motor: MotorName,
    /// The ratio, or the gear that has it.
    pub reduction: Reduction,
    /// The spring parallel to the actuator, where there is one.
    pub spring: Option<FixedSpring>,
    /// Inertia of the load about the joint \[kg·m²\], where it is said.
    pub load_inertia: Option<f64>,
    /// The ratio that was proved to be the best, where the design has one that can be built near it.
    pub optimal_ratio: Option<f64>,
    /// Where the table stands.
    pub span: Span<usize>,
    /// Where the motor is named.
    pub motor_span: Span<usize>,
    /// Where ratio or gear stands.
    pub reduction_span: Span<usize>,
}

/// Where the requirement of a design comes from.
#[derive(Clone, Copy)]
enum Requirement<'a> {
    /// Its file is named, and read with what is set.
    OfFile(&'a Settings),
    /// It was read already.
    Given(&'a Arc<Source>, &'a Robot),
}

/// How a design names a motor.
#[derive(Debug, Clone)]
pub enum MotorName {
    /// Id of the catalogue.
    Catalog(String),
    /// A fitted actuator's file, read already.
    Fitted {
        /// As written in the design.
        file: String,
        /// Its row.
        motor: Box<Motor>,
    },
}

/// How a design gives its ratio.
#[derive(Debug, Clone, PartialEq)]
pub enum Reduction {
    /// A number, with the gear that the requirement describes.
    Ratio(f64),
    /// Id of a gear of the catalogue.
    Gear(String),
}

/// A spring that was chosen: it pulls the joint towards its rest angle with `k (q_0 − q)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedSpring {
    /// Stiffness \[N·m/rad\], k.
    pub stiffness: f64,
    /// Rest angle \[rad\], q_0.
    pub rest_angle: f64,
}

/// One joint's choice with everything looked up.
#[derive(Debug, Clone, Copy)]
pub struct Choice<'a> {
    /// As the file has it.
    pub design: &'a JointDesign,
    /// The joint of the requirement.
    pub joint: &'a Joint,
    /// The motor.
    pub motor: &'a Motor,
    /// The gear, where it is one of the catalogue.
    pub gear: Option<&'a Gear>,
    /// The ratio, N.
    pub ratio: f64,
    /// The points of a gear family that its gear is made of, where the ratio lies among them: one, or two.
    pub points: [Option<&'a Gear>; 2],
}

impl<'a> Choice<'a> {
    /// The rows of gears that it rests on.
    pub fn gears(&self) -> impl Iterator<Item = &'a Gear> {
        self.gear.into_iter().chain(self.points.into_iter().flatten())
    }
}

impl DesignFile {
    /// Reads a design, its requirement, and the fitted actuators that it names.
    ///
    /// # Errors
    /// All mistakes of the design file, then all of the files that it names.
    pub fn read(path: &Path) -> Result<DesignFile, Vec<InputError>> {
        DesignFile::read_source(&Source::read(path).map_err(|e| vec![e])?)
    }

    /// As [`DesignFile::read_source`], with values in the place of the requirement's, after those that the design sets.
    ///
    /// # Errors
    /// As [`DesignFile::read`].
    pub fn read_set(source: &Arc<Source>, settings: &Settings) -> Result<DesignFile, Vec<InputError>> {
        DesignFile::read_form(source, Requirement::OfFile(settings))
    }

    /// A design for a requirement that was read already, whatever its file names and sets.
    ///
    /// # Errors
    /// As [`DesignFile::read`].
    pub fn read_for(
        source: &Arc<Source>,
        requirement: &Arc<Source>,
        robot: &Robot,
    ) -> Result<DesignFile, Vec<InputError>> {
        DesignFile::read_form(source, Requirement::Given(requirement, robot))
    }

    fn read_form(source: &Arc<Source>, requirement: Requirement) -> Result<DesignFile, Vec<InputError>> {
        let mut others = Vec::new();
        let read = Form::read(source, |root| read_design(root, requirement, &mut others));
        let read = Form::with_others(read, others);
        read.map_err(|errors| kind::instead_of_all(errors, source, &[FileKind::Design]))
    }

    /// As [`DesignFile::read`], from a source; other files are looked for beside it.
    ///
    /// # Errors
    /// As [`DesignFile::read`].
    pub fn read_source(source: &Arc<Source>) -> Result<DesignFile, Vec<InputError>> {
        DesignFile::read_set(source, &Settings::default())
    }

    /// Ids of the motors that it names in the catalogue.
    pub fn motor_ids(&self) -> impl Iterator<Item = &str> {
        self.joints.iter().filter_map(|design| match &design.motor {
            MotorName::Catalog(id) => Some(id.as_str()),
            MotorName::Fitted { .. } => None,
        })
    }

    /// Fitted actuators that it names by their files, made into others.
    pub fn change_fitted(&mut self, changed: impl Fn(Motor) -> Motor) {
        for design in &mut self.joints {
            if let MotorName::Fitted { motor, .. } = &mut design.motor {
                **motor = changed(Motor::clone(motor));
            }
        }
    }

    /// Looks up motors and gears.
    ///
    /// # Errors
    /// Motors and gears that the catalogue does not have, and gears that the requirement does not allow.
    pub fn choices<'a>(&'a self, catalog: &'a Catalog) -> Result<Vec<Choice<'a>>, InputError> {
        let (mut choices, mut problems) = (Vec::new(), Vec::new());
        for (design, joint) in self.joints.iter().zip(&self.robot.joints) {
            match look_up(design, joint, catalog) {
                Ok(choice) => choices.push(choice),
                Err(found) => problems.extend(found),
            }
        }
        InputError::unless_empty(&self.source, problems)?;
        Ok(choices)
    }
}

fn look_up<'a>(design: &'a JointDesign, joint: &'a Joint, catalog: &'a Catalog) -> Result<Choice<'a>, Vec<Problem>> {
    let mut problems = Vec::new();
    let motor = match &design.motor {
        MotorName::Fitted { motor, .. } => Some(&**motor),
        MotorName::Catalog(id) => catalog
            .motor(id)
            .map_err(|near| {
                let problem =
                    Problem::at(design.motor_span.clone(), format!("there is no motor `{id}`"), "not in the catalogue");
                problems.push(problem.help(near.map_or_else(
                    || "`gearwise rank` lists the motors; `catalog = [\"motors.csv\"]` adds others".to_string(),
                    |near| format!("did you mean `{near}`?"),
                )));
            })
            .ok(),
    };
    let at = |message: String, label: String| Problem::at(design.reduction_span.clone(), message, label);
    let mut gear = None;
    let built_in = motor.and_then(|motor| motor.inside.as_deref()).map(|inside| &inside.gear);
    let ratio = match &design.reduction {
        Reduction::Gear(id) if built_in.is_some_and(|own| &own.id == id) => {
            gear = built_in;
            gear.map(|g| g.ratio)
        }
        // Where the ratios are those between the points of a family, they are known with the catalogue.
        Reduction::Ratio(ratio) => {
            let range = joint.family_map().and(joint.ratio.range()).filter(|_| !joint.ratio.allows(*ratio));
            if let Some((min, max)) = range {
                let (message, label) = outside(*ratio, min, max);
                problems.push(at(message, label));
            }
            Some(*ratio)
        }
        Reduction::Gear(id) => {
            gear = catalog.gear(id);
            if gear.is_none() {
                let near = nearest(id, catalog.all_gears().map(|g| g.id.as_str()));
                problems.push(at(format!("there is no gear `{id}`"), "not in the catalogue".into()).help(
                    near.map_or_else(
                        || "ids begin with the kind, as in planetary-*, strain-wave-*".to_string(),
                        |near| format!("did you mean `{near}`?"),
                    ),
                ));
            }
            gear.map(|g| g.ratio)
        }
    };
    if let (Some(gear), Some(ratio)) = (gear, ratio) {
        match &joint.ratio {
            _ if built_in.is_some() => {}
            _ if joint.family_map().is_some_and(|map| map.family() != gear.family) => problems.push(at(
                format!("the requirement does not allow the gear `{}`", gear.id),
                format!(
                    "joint `{}` allows the family {}",
                    joint.name,
                    joint.family_map().map_or("", |map| map.family())
                ),
            )),
            RatioChoice::Continuous { min, max } if !joint.ratio.allows(ratio) => problems.push(at(
                format!("gear `{}` has a ratio of {}, outside the requirement's range", gear.id, number(ratio)),
                format!("joint `{}` asks for {} to {}", joint.name, number(*min), number(*max)),
            )),
            RatioChoice::Listed { values, .. } if !joint.ratio.allows(ratio) => problems.push(at(
                format!("gear `{}` has a ratio of {}, which the requirement does not list", gear.id, number(ratio)),
                format!("joint `{}` asks for {}", joint.name, nearest_of(values, ratio)),
            )),
            RatioChoice::Catalog { patterns, from, .. } if !from.has(patterns, gear) => {
                problems.push(at(
                    format!("the requirement does not allow the gear `{}`", gear.id),
                    format!("joint `{}` allows {} {}", joint.name, from.word(), patterns.join(", ")),
                ));
            }
            _ => {}
        }
    }
    if let (Some(motor), Some(own), Some(ratio)) = (motor, built_in, ratio)
        && (ratio / own.ratio - 1.0).abs() > SAME_RATIO
    {
        let message = format!("the module `{}` has a ratio of {}", motor.id, number(own.ratio));
        problems.push(at(message, format!("write gear = \"{}\"", own.id)));
    }
    match (motor, ratio) {
        (Some(motor), Some(ratio)) if problems.is_empty() => {
            let place = joint.family_map().filter(|_| gear.is_none()).and_then(|map| map.place(ratio));
            let points = match place {
                None => [None, None],
                Some(FamilyPlace::At(point)) => [catalog.gear(&point.id), None],
                Some(FamilyPlace::Between(below, above)) => [catalog.gear(&below.id), catalog.gear(&above.id)],
            };
            Ok(Choice { design, joint, motor, gear, ratio, points })
        }
        _ => Err(problems),
    }
}

/// That a ratio is none of those between two.
fn outside(ratio: f64, min: f64, max: f64) -> (String, String) {
    let message = format!("a ratio of {} is outside the requirement's range", number(ratio));
    (message, format!("expected {} to {}", number(min), number(max)))
}

/// What a ratio that is written may differ from that of a module.
const SAME_RATIO: f64 = 1e-3;

/// The listed ratios next to one that is none of them, in words.
fn nearest_of(values: &[f64], ratio: f64) -> String {
    let above = values.partition_point(|n| *n < ratio);
    let next = values[above.saturating_sub(1)..].iter().take(if above == 0 { 1 } else { 2 });
    let next: Vec<String> = next.map(|n| n.to_string()).collect();
    format!("certain ratios; the nearest: {}", next.join(", "))
}

const CATALOG: Key =
    key("catalog", "files and folders, next to this file").value("list of paths").default("the built-in catalogue");
const MOTOR: Key = key("motor", "of the catalogue").value("id").or("actuator");
const ACTUATOR: Key = key("actuator", "a fitted actuator").value("file").or("motor");
const RATIO: Key = key("ratio", "of the gear that the requirement describes").value("number, above zero").or("gear");
const GEAR: Key = key("gear", "of the catalogue").value("id").or("ratio");

/// What the reader asks for.
pub fn describe() -> Description {
    Form::describe("[[joint]]\nspring = {}\n", |root| {
        read_design(root, Requirement::OfFile(&Settings::default()), &mut Vec::new())
    })
}

fn read_design(root: &Section, from: Requirement, others: &mut Vec<InputError>) -> Option<DesignFile> {
    let folder = root.source().folder().to_path_buf();
    let requirement = root.required_text(key("requirement", "next to this file").value("file"), "\"robot.toml\"");
    let requirement_span = root.span_of("requirement");
    let own = root.section(SET).map(|section| Settings::of_section(&section)).unwrap_or_default();
    let set = match from {
        Requirement::OfFile(settings) => own.then(settings),
        Requirement::Given(..) => Settings::default(),
    };
    let robot = requirement.as_ref().and_then(|file| {
        if let Requirement::Given(source, robot) = from {
            return Some((source.clone(), robot.clone()));
        }
        let source = open(root, &folder, file.get_ref(), file.span(), "requirement")?;
        let robot = set.read(&source, None);
        let mut noted = |error: InputError| match Arc::ptr_eq(&error.source, root.source()) {
            // What the design itself sets.
            true => error.problems.into_iter().for_each(|problem| root.note(problem)),
            false => others.push(error),
        };
        robot.map_err(|errors| errors.into_iter().for_each(&mut noted)).ok().map(|robot| (source, robot))
    });
    let catalog: Vec<PathBuf> = if root.has(CATALOG) {
        let paths = root.texts("catalog").unwrap_or_default();
        let missing = paths.iter().filter(|p| !is_word(p.get_ref()) && !folder.join(p.get_ref()).exists());
        for path in missing {
            let message = format!("catalogue `{}`: there is no such file", path.get_ref());
            root.note(Problem::at(path.span(), message, "paths are relative to this file"));
        }
        paths.iter().map(|p| place(&folder, p.get_ref())).collect()
    } else {
        Vec::new()
    };
    let rules = root.text(key("rules", "rules file for `check`").value("file")).map(|file| folder.join(file.get_ref()));
    let about = "one for each joint of the requirement";
    let sections =
        root.some_sections(key("joint", about).required(), "a table [[joint]] for each joint of the requirement");
    if let Some(extra) = sections.get(limits::JOINTS) {
        let message = limits::too_many("joints", sections.len(), limits::JOINTS);
        root.note(Problem::at(extra.span(), message, "one too many").help("split the design into several"));
        return None;
    }
    let mut found: HashMap<String, JointDesign> = HashMap::new();
    let (mut seen, mut complete) = (HashMap::new(), true);
    for section in sections {
        let span = section.span();
        let joint = read_joint(&section, robot.as_ref().map(|(_, robot)| robot), &folder, others);
        if let Some(name) = section.text("name")
            && let Some(first) = seen.insert(name.get_ref().clone(), span)
        {
            let line = section.source().position(first.start).0;
            let message = format!("duplicate joint `{}` in this design", name.get_ref());
            root.note(Problem::at(name.span(), message, format!("first in line {line}")).help("remove one of the two"));
        }
        section.finish();
        match joint {
            Some(joint) => {
                found.insert(joint.name.clone(), joint);
            }
            None => complete = false,
        }
    }
    let (requirement, robot) = robot?;
    let missing: Vec<&str> = robot.joints.iter().map(|j| j.name.as_str()).filter(|n| !seen.contains_key(*n)).collect();
    if !missing.is_empty() && root.has("joint") {
        let (joints, these) = if missing.len() == 1 { ("joint", "it") } else { ("joints", "each of them") };
        root.note(
            Problem::at(
                requirement_span.clone(),
                format!("the design has nothing for the {joints} `{}` of the requirement", missing.join("`, `")),
                "asked for here",
            )
            .help(format!("add a table [[joint]] with name, motor and ratio for {these}")),
        );
    }
    if !complete || !missing.is_empty() {
        return None;
    }
    let joints = robot.joints.iter().map(|j| found.remove(&j.name)).collect::<Option<Vec<_>>>()?;
    Some(DesignFile {
        source: root.source().clone(),
        requirement,
        requirement_span,
        robot,
        set,
        catalog,
        rules,
        joints,
    })
}

/// Opens a file that the design names; where that fails, the problem stands at the name.
fn open(root: &Section, folder: &Path, file: &str, span: Span<usize>, what: &str) -> Option<Arc<Source>> {
    match Source::read(&folder.join(file)) {
        Ok(source) => Some(source),
        Err(error) => {
            root.note(error.where_named(what, file, span));
            None
        }
    }
}

fn read_joint(
    section: &Section,
    robot: Option<&Robot>,
    folder: &Path,
    others: &mut Vec<InputError>,
) -> Option<JointDesign> {
    let name = section.required_text(key("name", "a joint of the requirement"), "\"knee\"");
    let joint = name.as_ref().zip(robot).and_then(|(name, robot)| {
        let joint = robot.joints.iter().find(|j| &j.name == name.get_ref());
        if joint.is_none() {
            let names: Vec<&str> = robot.joints.iter().map(|j| j.name.as_str()).collect();
            let message = format!("the requirement has no joint `{}`", name.get_ref());
            section.note(Problem::at(name.span(), message, "not a joint of the robot").suggest(name.get_ref(), names));
        }
        joint
    });
    let motor = match (section.has(MOTOR), section.has(ACTUATOR)) {
        (true, true) => {
            let span = section.span_of("actuator");
            let message = "a joint has `motor` or `actuator` (a fitted one, which has its motor), not both";
            section.note(Problem::at(span, message, "remove one of the two"));
            None
        }
        (false, false) => {
            section.missing("motor", "\"t-motor-ri50\"");
            None
        }
        (true, false) => {
            section.required_text("motor", "\"t-motor-ri50\"").map(|id| MotorName::Catalog(id.into_inner()))
        }
        (false, true) => section.required_text("actuator", "\"fitted.toml\"").and_then(|file| {
            let source = open(section, folder, file.get_ref(), file.span(), "fitted actuator")?;
            let motor = read_fitted(&source).map_err(|error| others.push(error)).ok()?;
            Some(MotorName::Fitted { file: file.into_inner(), motor: Box::new(motor) })
        }),
    };
    let motor_span = section.span_of(if section.has("motor") { "motor" } else { "actuator" });
    let reduction = read_reduction(section, joint);
    let reduction_span = section.span_of(if section.has("ratio") { "ratio" } else { "gear" });
    let spring = section.section(key("spring", "a parallel spring")).map(|table| {
        let spring = read_spring(&table, joint);
        table.finish();
        spring
    });
    let load_inertia = section.quantity(
        key("load_inertia", "of the load about the joint, for the rules"),
        &units::INERTIA,
        Range::Positive,
    );
    let optimal_ratio = section.number(
        key("optimal_ratio", "the ratio that was proved, where `ratio` is one near it that can be built; not checked"),
        Range::Positive,
    );
    let asked = joint.and_then(|j| j.limits.spring).filter(|asked| asked.stiffness[0] > 0.0);
    let spring = match (spring, asked) {
        (Some(None), _) => return None,
        (None, Some(asked)) => {
            let [least, most] = asked.stiffness.map(number);
            let message =
                format!("the requirement asks for a spring of {least} to {most} N*m/rad, and this design has none");
            let example = "spring = { stiffness = \"…\", rest_angle = \"…\" }";
            section.note(Problem::at(section.span(), message, "in this table").help(format!("give {example}")));
            return None;
        }
        (spring, _) => spring.flatten(),
    };
    Some(JointDesign {
        name: name?.into_inner(),
        motor: motor?,
        reduction: reduction?,
        spring,
        load_inertia,
        optimal_ratio,
        span: section.span(),
        motor_span,
        reduction_span,
    })
}

fn read_reduction(section: &Section, joint: Option<&Joint>) -> Option<Reduction> {
    match (section.has(RATIO), section.has(GEAR)) {
        (true, true) => {
            let span = section.span_of("gear");
            let message = "a joint has `ratio` or `gear` (which has its ratio), not both";
            section.note(Problem::at(span, message, "remove one of the two"));
            None
        }
        (false, false) => {
            section.missing("ratio", "9.0, or gear = \"planetary-…\" of the catalogue");
            None
        }
        (false, true) => section.required_text("gear", "\"planetary-…\"").map(|id| Reduction::Gear(id.into_inner())),
        (true, false) => {
            let ratio = section.number("ratio", Range::Positive)?;
            match joint.map(|j| &j.ratio) {
                // Between the points of a family any ratio may be chosen, once the catalogue is read.
                Some(RatioChoice::Catalog { from, .. }) if from.is_between() => {}
                Some(RatioChoice::Catalog { patterns, from, .. }) => {
                    let message = "the requirement takes the gears of this joint from the catalogue";
                    section.note(Problem::at(section.span_of("ratio"), message, "expected `gear`").help(format!(
                        "write gear = \"…\" with one of the {} {}",
                        from.word(),
                        patterns.join(", ")
                    )));
                    return None;
                }
                Some(choice @ RatioChoice::Continuous { min, max }) if !choice.allows(ratio) => {
                    let (message, label) = outside(ratio, *min, *max);
                    section.note(Problem::at(section.span_of("ratio"), message, label));
                    return None;
                }
                Some(choice @ RatioChoice::Listed { values, .. }) if !choice.allows(ratio) => {
                    let message = format!("a ratio of {ratio} is none of those that the requirement lists");
                    let label = format!("expected {}", nearest_of(values, ratio));
                    section.note(Problem::at(section.span_of("ratio"), message, label));
                    return None;
                }
                _ => {}
            }
            Some(Reduction::Ratio(ratio))
        }
    }
}

fn read_spring(table: &Section, joint: Option<&Joint>) -> Option<FixedSpring> {
    let stiffness = table.required_quantity(key("stiffness", "k"), &units::STIFFNESS, Range::NonNegative);
    let rest_angle = table.required_quantity(
        key("rest_angle", "q_0 on the scale of the motion's position"),
        &units::ANGLE,
        Range::Any,
    );
    let rest_angle = table.at_most("rest_angle", rest_angle, limits::REST_ANGLE, " rad");
    let spring = FixedSpring { stiffness: stiffness?, rest_angle: rest_angle? };
    if joint.is_some_and(|j| j.motion.position.is_none()) {
        let message = "a spring needs the position, but the joint's motion has none";
        table.note(Problem::at(table.span(), message, "asked for here"));
        return None;
    }
    // A requirement that lets no spring be chosen does not forbid one that is there.
    let Some(asked) = joint.and_then(|j| j.limits.spring) else { return Some(spring) };
    let mut inside = true;
    let mut outside = |key, value: f64, [least, most]: [f64; 2], unit: &str| {
        if !(least - 1e-9 * least.abs()..=most + 1e-9 * most.abs()).contains(&value) {
            let message = format!("`{key}` of [spring] is outside the requirement's range");
            let label = format!("expected {} to {} {unit}", number(least), number(most));
            table.note(Problem::at(table.span_of(key), message, label));
            inside = false;
        }
    };
    outside("stiffness", spring.stiffness, asked.stiffness, "N*m/rad");
    outside("rest_angle", spring.rest_angle, asked.rest_angle, "rad");
    inside.then_some(spring)
}
