//! A chosen design for a simulator.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Failure;
use super::chosen::{self, Chosen};
use super::optimize::Optimized;
use crate::catalog::{Catalog, Gear, Motor};
use crate::design::evaluate::FEASIBILITY_TOLERANCE;
use crate::design::examine::examine;
use crate::design::explain::explain;
use crate::design::judge::unjudged;
use crate::design::simulated::spread::Spread;
use crate::design::simulated::{Fact, LeftOut, SimulatedJoint};
use crate::design::{Evaluation, Mount, Unusable, load_through};
use crate::input::Source;
use crate::mechanism::stated::{Model, Quantity};
use crate::report::export::patch::Patched;
use crate::report::export::{Cell, Exported, FORMATS, Format, NamedFile, Origin, Wish, Wishes, patch};
use crate::report::unjudged::sentence;
use crate::requirement::{DesignFile, Joint, Robot};

/// What is exported, and how.
#[derive(Debug, Clone, Default)]
pub struct Asked {
    /// Joints by their names; none for all.
    pub joint: Vec<String>,
    /// The format, by its name in [`FORMATS`].
    pub to: Option<String>,
    /// A model that is written into, MJCF, URDF or SDFormat by its root.
    pub into: Option<PathBuf>,
    /// Which joints of the model a joint of the design is, `JOINT=PATTERN`.
    pub map: Vec<String>,
    /// Torques behind the gear's loss.
    pub with_efficiency: bool,
    /// The highest line of torque over speed below the motor's own curve.
    pub line_below: bool,
    /// How hot the winding is, as a state.
    pub thermal: bool,
    /// The current takes its time.
    pub electrical: bool,
    /// Without what Drake warns of.
    pub drake: bool,
    /// Elasticity or play of the gear as a second joint.
    pub gear_joint: bool,
    /// Ranges of 95 %.
    pub ranges: bool,
    /// So many draws of all numbers together.
    pub draws: Option<u16>,
}

/// What was exported.
pub struct Made<'a> {
    /// Where it comes from.
    pub origin: Origin,
    /// Its joints.
    pub joints: Vec<Exported<'a>>,
    /// The text.
    pub text: String,
    /// The format that it has, where that is known.
    pub format: Option<&'static Format>,
    /// What to be warned of.
    pub warnings: Vec<String>,
    /// Of a model that was written into: the names in it of each joint.
    pub written: Vec<(String, Vec<String>)>,
}

impl Made<'_> {
    /// Whether every design keeps its limits, as far as they can be judged.
    pub fn is_satisfied(&self) -> bool {
        self.joints.iter().all(|j| j.broken.is_empty() && j.unjudged.is_empty())
    }
}

impl Asked {
    /// How many draws are wanted, none of them where ranges alone are; `None` where neither is.
    fn spread(&self) -> Option<usize> {
        let draws = self.draws.map(usize::from);
        draws.or(self.ranges.then_some(0))
    }

    /// The wishes that were given; all formats have ranges, in a comment at least.
    fn given(&self) -> impl Iterator<Item = Wish> {
        let given = [
            (self.with_efficiency, Wish::WithEfficiency),
            (self.line_below, Wish::LineBelow),
            (self.thermal, Wish::Thermal),
            (self.electrical, Wish::Electrical),
            (self.drake, Wish::Drake),
            (self.draws.is_some(), Wish::Draws),
            (!self.map.is_empty(), Wish::Map),
        ];
        given.into_iter().filter(|(given, _)| *given).map(|(_, wish)| wish)
    }

    /// Whether the format can grant what was wished.
    fn check_wishes(&self, place: &str, takes: &[Wish]) -> Result<(), Failure> {
        let Some(wish) = self.given().find(|wish| !takes.contains(wish)) else { return Ok(()) };
        let others: Vec<&str> = FORMATS.iter().filter(|f| f.takes.contains(&wish)).map(|f| f.name).collect();
        let (option, others) = (wish.option(), others.join(", "));
        Err(Failure::Argument(format!("`{option}` is not for {place}; it is for {others}")))
    }

    /// The joints that are named.
    fn only<'r>(&self, robot: &'r Robot) -> Result<Vec<&'r Joint>, Failure> {
        self.joint.iter().map(|name| chosen::joint(robot, Some(name))).collect()
    }

    fn wishes(&self, joints: &[Exported]) -> Result<Wishes, Failure> {
        Ok(Wishes {
            names: names(&self.map, joints)?,
            with_efficiency: self.with_efficiency,
            line_below: self.line_below,
            thermal: self.thermal,
            electrical: self.electrical,
            for_drake: self.drake,
            gear_joint: self.gear_joint,
            as_dcmotor: self.into.is_some() && self.to.as_deref() == Some("dcmotor"),
        })
    }
}

/// The joint of a robot that one motor is exported at, `MOTOR`, `MOTOR@RATIO` or `MOTOR@GEAR`; `source` is the requirement.
///
/// # Errors
/// A motor, a gear or a joint that is not there; what cannot be said in the format.
pub fn of_motor<'a>(
    asked: &Asked,
    design: &str,
    robot: &'a Robot,
    catalog: &'a Catalog,
    source: &Source,
) -> Result<Made<'a>, Failure> {
    if let [_, another, ..] = &asked.joint[..] {
        return Err(Failure::Argument(format!(
            "`--joint {another}`: one motor is exported at one joint; a design file has several"
        )));
    }
    let joint = chosen::joint(robot, asked.joint.first().map(String::as_str))?;
    let Chosen { motor, gear, ratio } = chosen::design(design, joint, catalog)?;
    let story = explain(robot, joint, motor, gear, ratio).map_err(|why| cannot(motor, &why))?;
    let spring = match story.spring {
        Some(Ok(spring)) => Some((spring.stiffness, spring.rest_angle.unwrap_or(0.0))),
        _ => None,
    };
    let joints = vec![exported(robot, joint, motor, gear, &story.evaluation, &story.unchecked, (spring, asked))?];
    made(asked, origin(robot, source, None), joints)
}

/// The joints of a design file, whose robot was settled with the catalogue.
///
/// # Errors
/// As [`of_motor`].
pub fn of_design<'a>(asked: &Asked, design: &'a DesignFile, catalog: &'a Catalog) -> Result<Made<'a>, Failure> {
    let choices = design.choices(catalog).map_err(|e| vec![e])?;
    let only = asked.only(&design.robot)?;
    let mut joints = Vec::new();
    for (choice, examined) in choices.iter().zip(examine(&design.robot, &choices)) {
        if !only.is_empty() && only.iter().all(|only| only.name != choice.joint.name) {
            continue;
        }
        let examined = examined.map_err(|why| cannot(choice.motor, &why))?;
        let spring = choice.design.spring.map(|s| (s.stiffness, s.rest_angle));
        let (evaluation, unchecked) = (&examined.evaluation, &examined.unchecked);
        let (motor, gear) = (choice.motor, choice.gear);
        joints.push(exported(&design.robot, choice.joint, motor, gear, evaluation, unchecked, (spring, asked))?);
    }
    let origin = origin(&design.robot, &design.requirement, Some(&design.source));
    made(asked, origin, joints)
}

/// What was chosen: the best combination where the whole robot was looked at, else the first choices.
///
/// # Errors
/// A joint without a design; what cannot be said in the format.
pub fn of_choice<'a>(asked: &Asked, chosen: &'a Optimized, source: &Source) -> Result<Made<'a>, Failure> {
    let (found, robot) = (chosen.found(), chosen.robot());
    let only = asked.only(robot)?;
    let mut joints = Vec::new();
    for (k, of) in found.result.joints.iter().enumerate() {
        if !only.is_empty() && only.iter().all(|only| only.name != of.joint.name) {
            continue;
        }
        let Some(design) = chosen.chosen(k) else {
            return Err(Failure::Argument(format!("joint `{}` has no design to export", of.joint.name)));
        };
        let gear = design.gear.and_then(|id| chosen.catalog().gear_of(design.motor, id));
        let spring = design.spring.map(|s| (s.stiffness, s.rest_angle.unwrap_or(0.0)));
        let (evaluation, unchecked) = (&design.evaluation, &design.unchecked);
        joints.push(exported(robot, of.joint, design.motor, gear, evaluation, unchecked, (spring, asked))?);
    }
    made(asked, origin(robot, source, None), joints)
}

fn cannot(motor: &Motor, why: &Unusable) -> Failure {
    let help = match (why, &motor.inside) {
        (Unusable::NotAllowed, Some(inside)) => {
            format!(
                "; it is a module: give the [[joint]] `modules = [\"{}\"]` in place of `ratio` and `gear`",
                inside.module.id
            )
        }
        _ => String::new(),
    };
    Failure::Argument(format!("{} cannot be exported: {}{help}", motor.id, why.reason()))
}

/// The design of one joint, made ready for a simulator.
fn exported<'a>(
    robot: &Robot,
    joint: &'a Joint,
    motor: &'a Motor,
    gear: Option<&'a Gear>,
    evaluation: &Evaluation,
    unchecked: &[(&'static str, &'static str)],
    (spring, asked): (Option<(f64, f64)>, &Asked),
) -> Result<Exported<'a>, Failure> {
    // A simulator takes every number for true: torque and speed must be some.
    if let Some(inside) = motor.inside.as_deref() {
        let says_speed = inside.says_power() || inside.module.no_load_speed().is_some();
        let lacks = match (inside.module.largest_torque(), says_speed) {
            (None, _) if !inside.says_currents() => Some(
                "its row does not say its largest torque: give it `peak_torque` or a `driving_curve`, in a catalogue of your own",
            ),
            (_, false) => Some(
                "how fast it turns is not known: give its row `no_load_speed` or a `driving_curve`, in a catalogue of your own",
            ),
            _ => None,
        };
        if let Some(why) = lacks {
            return Err(Failure::Argument(format!("{} cannot be exported: {why}", motor.id)));
        }
    }
    let load = load_through(joint, gear);
    let ratio = evaluation.ratio;
    let candidate = Mount::new(robot, joint, &load, motor).with_gear(gear).candidate();
    let mut simulated = SimulatedJoint::new(&candidate.map_err(|why| cannot(motor, &why))?, ratio);
    let with = |motor: &Motor| {
        let candidate = Mount::new(robot, joint, &load, motor).with_gear(gear).candidate().ok()?;
        Some(SimulatedJoint::new(&candidate, ratio).numbers(asked.line_below, asked.with_efficiency))
    };
    let spread = asked.spread().and_then(|draws| Spread::new(motor, draws, with));
    if let Some((stiffness, rest_angle)) = spring.filter(|(stiffness, _)| *stiffness > 0.0) {
        let number = crate::words::number;
        simulated.left_out.push(LeftOut {
            fact: Some(Fact::Spring),
            what: format!(
                "parallel spring of {} N*m/rad with its rest at {} rad",
                number(stiffness),
                number(rest_angle)
            ),
            why: "it belongs to the joint, not to the actuator: give the joint this stiffness and rest angle".into(),
        });
    }
    let broken = evaluation.margins.iter().filter(|m| m.margin < -FEASIBILITY_TOLERANCE).map(|m| m.limit);
    Ok(Exported {
        joint: &joint.name,
        motor,
        gear,
        simulated,
        spread,
        broken: broken.collect(),
        unchecked: unchecked.iter().map(|(limit, _)| *limit).collect(),
        unjudged: unjudged(robot, joint, unchecked),
    })
}

fn origin(robot: &Robot, requirement: &Source, design: Option<&Source>) -> Origin {
    let file = |source: &Source| {
        let name = Path::new(source.name()).file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        NamedFile { name, sha256: source.sha256() }
    };
    Origin {
        robot: robot.name.clone(),
        set: robot.set.clone(),
        requirement: file(requirement),
        design: design.map(file),
    }
}

/// Makes the text.
fn made<'a>(asked: &Asked, origin: Origin, exported: Vec<Exported<'a>>) -> Result<Made<'a>, Failure> {
    let joints = &exported[..];
    let mut warnings = Vec::new();
    let wishes = asked.wishes(joints)?;
    let format = FORMATS.iter().find(|f| Some(f.name) == asked.to.as_deref());
    let (mut page_of, mut written) = (format, Vec::new());
    let text = match (&asked.into, format) {
        (Some(model), _) => {
            if let Some(joint) = joints.iter().find(|joint| joint.simulated.is_before_the_joint) {
                let why = "its transmission goes with the angle, or couples two joints: the numbers are those of the actuator, not of a joint of the model; use `--to`";
                return Err(Failure::Argument(format!("`--into`: `{}`: {why}", joint.joint)));
            }
            let takes = match format {
                Some(dcmotor) if wishes.as_dcmotor => [dcmotor.takes, &[Wish::Map]].concat(),
                Some(other) => {
                    let why = format!(
                        "`--to {}` is not for a model (`--into`); it is MJCF, URDF or SDFormat by its root, and `--to dcmotor` is for MJCF",
                        other.name
                    );
                    return Err(Failure::Argument(why));
                }
                None => vec![Wish::Map, Wish::Drake],
            };
            asked.check_wishes("a model (`--into`)", &takes)?;
            let shown = model.display();
            let old = Source::read(model).map_err(|e| vec![e])?;
            let patched = patch::patch(old.text(), &origin, joints, &wishes)
                .map_err(|why| Failure::Argument(format!("`{shown}`: {why}")))?;
            page_of = FORMATS.iter().find(|f| f.name == patched.format);
            warnings.extend(patched.remarks.iter().cloned().chain(stays(&patched, joints)));
            written.extend(patched.written.iter().cloned());
            patched.text
        }
        (None, Some(format)) => {
            asked.check_wishes(&format!("`{}`", format.name), format.takes)?;
            (format.text)(&origin, joints, &wishes).map_err(Failure::Argument)?
        }
        (None, None) => return Err(Failure::Argument("a format (`--to`) or a model (`--into`) is needed".into())),
    };
    for joint in joints.iter().filter(|j| !j.broken.is_empty()) {
        warnings.push(format!(
            "joint `{}`: {} at N = {} is not feasible, it breaks {}; exported anyway",
            joint.joint,
            joint.motor.id,
            crate::words::number(joint.simulated.ratio),
            joint.broken.join(", ")
        ));
    }
    for joint in joints.iter().filter(|j| j.simulated.armature.is_none() && asked.into.is_none()) {
        warnings.push(format!(
            "joint `{}`: the own inertia of {} is not known and left out: a simulator takes none for it",
            joint.joint, joint.motor.id
        ));
    }
    for joint in joints.iter().filter(|j| j.broken.is_empty() && !j.unjudged.is_empty()) {
        warnings.push(format!(
            "joint `{}`: {} at N = {} {}; exported anyway",
            joint.joint,
            joint.motor.id,
            crate::words::number(joint.simulated.ratio),
            sentence(&joint.unjudged)
        ));
    }
    for e in joints.iter().filter(|e| e.simulated.is_before_the_joint) {
        let takes = page_of.is_some_and(|f| matches!((f.says)(Fact::Transmission), Cell::Approximately(_)));
        if takes && !e.simulated.over_angle.is_empty() {
            warnings.push(format!("joint `{}`: its ratio goes with the angle: torque over the angle is written; speed, inertia and friction are left out",
                e.joint
            ));
        } else {
            warnings.push(format!(
                "joint `{}`: its transmission has no one ratio: the numbers are those of the actuator before it",
                e.joint
            ));
        }
    }
    if asked.spread().is_some() {
        for e in joints.iter().filter(|e| e.spread.as_ref().is_none_or(|spread| spread.ranges.is_empty())) {
            warnings.push(format!("joint `{}`: no number of {} has a ±: no range is written", e.joint, e.motor.id));
        }
    }
    if let Some(wished) = asked.draws {
        for (e, spread) in joints.iter().filter_map(|e| Some((e, e.spread.as_ref()?))) {
            if spread.draws.len() < usize::from(wished) {
                warnings.push(format!(
                    "joint `{}`: {} of {wished} draws: with so wide a ± most of the others are no numbers of a motor",
                    e.joint,
                    spread.draws.len()
                ));
            }
        }
    }
    Ok(Made { origin, joints: exported, text, format: page_of, warnings, written })
}

/// What a patched model says of quantities that are not known: its own numbers stay, and that has to be known.
fn stays(patched: &Patched, joints: &[Exported]) -> Vec<String> {
    let Ok(model) = Model::read_source(&Arc::new(Source::new("the model", &patched.text))) else { return Vec::new() };
    let mut lines = Vec::new();
    for (e, (_, names)) in joints.iter().zip(&patched.written) {
        let s = &e.simulated;
        let unknown = [
            (Quantity::Armature, s.armature.is_none()),
            (Quantity::Damping, s.damping.is_none()),
            (Quantity::Friction, s.friction_loss.is_none()),
            (Quantity::Effort, s.motor_torque.is_none()),
        ];
        for (quantity, _) in unknown.iter().filter(|(_, is_unknown)| *is_unknown) {
            for joint in model.joints.iter().filter(|joint| names.contains(&joint.name)) {
                let Some(own) = joint.get(*quantity) else { continue };
                lines.push(format!(
                    "joint `{}`: {} of {} is not known; the model's own {} {} stays",
                    joint.name,
                    quantity.name(),
                    e.motor.id,
                    crate::words::number(own.value),
                    quantity.unit()
                ));
            }
        }
    }
    lines
}

/// `--map JOINT=PATTERN`, with the joints checked.
fn names(map: &[String], joints: &[Exported]) -> Result<Vec<(String, String)>, Failure> {
    let one = |text: &String| {
        let Some((joint, pattern)) = text.split_once('=').filter(|(j, p)| !j.is_empty() && !p.is_empty()) else {
            return Err(Failure::Argument(format!("`--map {text}`: expected JOINT=PATTERN, as in knee=*_knee")));
        };
        if joints.iter().all(|e| e.joint != joint) {
            let known = joints.iter().map(|e| e.joint);
            let help = crate::words::nearest(joint, known.clone()).map_or_else(
                || format!("there are: {}", known.collect::<Vec<_>>().join(", ")),
                |n| format!("did you mean `{n}`?"),
            );
            return Err(Failure::Argument(format!("`--map {text}`: no joint `{joint}` is exported; {help}")));
        }
        Ok((joint.to_string(), pattern.to_string()))
    };
    map.iter().map(one).collect()
}
