use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::chosen::Chosen;
use super::{Call, CatalogChoice, Done, Failure, Html, Set};
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
use crate::output;
use crate::report::export::patch::Patched;
use crate::report::export::{Cell, Exported, FORMATS, NamedFile, Origin, Wish, Wishes, patch};
use crate::report::html;
use crate::report::unjudged::sentence;
use crate::requirement::{DesignFile, Joint, Robot};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise export requirements/designs/quadruped_mini_cheetah/design.toml --to mjcf\n  gearwise export design.toml --into robot.urdf --out with_limits.urdf\n  gearwise export t-motor-ri50@9 requirements/quadruped_mini_cheetah.toml --joint knee --to mjcf\n  gearwise export t-motor-u8-lee requirements/quadruped_mini_cheetah.toml --joint knee --to json\n  gearwise export t-motor-ri50@9 robot.toml --joint knee --into model.xml --map 'knee=*_knee' --out with_motors.xml\n\nExit status 1 if a design is not feasible; it is exported all the same."
)]
pub struct Arguments {
    /// Design file (TOML; `-` is standard input); or a motor's id, with `@RATIO` or `@GEAR`, else at its best ratio
    design: String,
    /// Requirement file (TOML), where no design file names it; `-` is standard input
    requirement: Option<PathBuf>,
    /// Joint, several times for several: by default all of a design file; may be left out where the requirement has only one
    #[arg(long, value_name = "NAME")]
    joint: Vec<String>,
    /// Format: MuJoCo, URDF, or all facts in SI
    #[arg(long, value_name = "FORMAT", required_unless_present = "into", value_parser = PossibleValuesParser::new(FORMATS.iter().map(|f| PossibleValue::new(f.name).help(f.about))))]
    to: Option<String>,
    /// Write into this model, MJCF, URDF or SDFormat by its root; the result goes to `--out` or stdout. With `--to dcmotor` MJCF
    /// gets that
    #[arg(long, value_name = "MODEL")]
    into: Option<PathBuf>,
    /// Which joints of the model a joint of the design is, `*` for any run of characters; else those of its name. For USD the
    /// path of its prim
    #[arg(long, value_name = "JOINT=PATTERN", num_args = 1..)]
    map: Vec<String>,
    /// Write torques behind the gear's loss: right while the motor drives, too little while the load drives
    #[arg(long)]
    with_efficiency: bool,
    /// Line of torque over speed: through the corner, or the highest `below` the motor's own curve
    #[arg(long, value_name = "LINE", default_value = "corner", value_parser = ["corner", "below"])]
    line: String,
    /// dcmotor: how hot the winding is, as a state
    #[arg(long)]
    thermal: bool,
    /// dcmotor: the current takes its time, L/R
    #[arg(long)]
    electrical: bool,
    /// URDF: without the `mechanicalReduction` of older readers, of which Drake warns
    #[arg(long)]
    drake: bool,
    /// MJCF with --into: elasticity or play of the gear as a second joint
    #[arg(long, requires = "into")]
    gear_joint: bool,
    /// Write ranges of 95 % where rows or fits have a ±
    #[arg(long)]
    ranges: bool,
    /// Write so many draws of all numbers together, by their ± and covariance: JSON and Python
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1000))]
    draws: Option<u16>,
    /// Write to this file instead of stdout
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    catalog: CatalogChoice,
}

impl Arguments {
    /// How many draws are wanted, none of them where ranges alone are; `None` where neither is.
    fn spread(&self) -> Option<usize> {
        let draws = self.draws.map(usize::from);
        draws.or(self.ranges.then_some(0))
    }

    /// The wishes that were given; all formats have ranges, in a comment at least.
    fn given(&self) -> impl Iterator<Item = Wish> {
        let given = [
            (self.with_efficiency, Wish::WithEfficiency),
            (self.line == "below", Wish::LineBelow),
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

    fn wishes(&self, joints: &[Exported]) -> Result<Wishes, Failure> {
        Ok(Wishes {
            names: names(&self.map, joints)?,
            with_efficiency: self.with_efficiency,
            line_below: self.line == "below",
            thermal: self.thermal,
            electrical: self.electrical,
            for_drake: self.drake,
            gear_joint: self.gear_joint,
            as_dcmotor: self.into.is_some() && self.to.as_deref() == Some("dcmotor"),
        })
    }
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    match &arguments.requirement {
        Some(path) => one_motor(arguments, path, call),
        None => design_file(arguments, call),
    }
}

/// A motor at a joint of a requirement.
fn one_motor(arguments: &Arguments, path: &Path, call: &Call) -> Result<Done, Failure> {
    let settings = arguments.set.settings()?;
    let source = Source::argument(path).map_err(|e| vec![e])?;
    let robot = settings.read(&source, None)?;
    let catalog = super::with_named(
        &robot,
        arguments.catalog.rows()?,
        std::iter::once(super::chosen::id(&arguments.design)),
        arguments.catalog.complete(),
    );
    let robot = super::settled(robot, &catalog)?;
    let robot = super::balanced(&robot, &catalog, false)?;
    if let [_, another, ..] = &arguments.joint[..] {
        return Err(Failure::Argument(format!(
            "`--joint {another}`: one motor is exported at one joint; a design file has several"
        )));
    }
    let joint = super::chosen::joint(&robot, arguments.joint.first().map(String::as_str))?;
    let Chosen { motor, gear, ratio } = super::chosen::design(&arguments.design, joint, &catalog)?;
    let story = explain(&robot, joint, motor, gear, ratio).map_err(|why| cannot(motor, &why))?;
    let spring = match story.spring {
        Some(Ok(spring)) => Some((spring.stiffness, spring.rest_angle.unwrap_or(0.0))),
        _ => None,
    };
    let joints = [exported(&robot, joint, motor, gear, &story.evaluation, &story.unchecked, (spring, arguments))?];
    finish(arguments, call, (&robot, &catalog), &origin(&robot, &source, None), &joints)
}

/// The joints of a design file.
fn design_file(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    let path = Path::new(&arguments.design);
    let settings = arguments.set.settings()?;
    let stdin = path.as_os_str() == Source::STDIN;
    if !stdin && !path.exists() && path.extension().is_none_or(|e| e != "toml") {
        return Err(Failure::Argument(format!(
            "`{0}` is no design file; a motor needs its requirement: gearwise export {0} robot.toml --joint NAME",
            arguments.design
        )));
    }
    let mut design = DesignFile::read_set(&Source::argument(path).map_err(|e| vec![e])?, &settings)?;
    let named = arguments.catalog.paths();
    let paths = if named.is_empty() { &design.catalog } else { &named };
    let catalog = super::with_named(
        &design.robot,
        arguments.catalog.prepared(super::catalog(paths)?),
        design.motor_ids(),
        arguments.catalog.complete(),
    );
    design.robot = crate::design::families::settle(design.robot, &catalog).map_err(Failure::Argument)?;
    let choices = design.choices(&catalog).map_err(|e| vec![e])?;
    let only = arguments.joint.iter().map(|name| super::chosen::joint(&design.robot, Some(name)));
    let only = only.collect::<Result<Vec<_>, _>>()?;
    let mut joints = Vec::new();
    for (choice, examined) in choices.iter().zip(examine(&design.robot, &choices)) {
        if !only.is_empty() && only.iter().all(|only| only.name != choice.joint.name) {
            continue;
        }
        let examined = examined.map_err(|why| cannot(choice.motor, &why))?;
        let spring = choice.design.spring.map(|s| (s.stiffness, s.rest_angle));
        joints.push(exported(
            &design.robot,
            choice.joint,
            choice.motor,
            choice.gear,
            &examined.evaluation,
            &examined.unchecked,
            (spring, arguments),
        )?);
    }
    let origin = origin(&design.robot, &design.requirement, Some(&design.source));
    finish(arguments, call, (&design.robot, &catalog), &origin, &joints)
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
    (spring, arguments): (Option<(f64, f64)>, &Arguments),
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
        Some(SimulatedJoint::new(&candidate, ratio).numbers(arguments.line == "below", arguments.with_efficiency))
    };
    let spread = arguments.spread().and_then(|draws| Spread::new(motor, draws, with));
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

/// Warns, makes the text and puts it where it belongs.
fn finish(
    arguments: &Arguments,
    call: &Call,
    (robot, catalog): (&Robot, &Catalog),
    origin: &Origin,
    joints: &[Exported],
) -> Result<Done, Failure> {
    let mut said = Vec::new();
    let wishes = arguments.wishes(joints)?;
    let format = FORMATS.iter().find(|f| Some(f.name) == arguments.to.as_deref());
    let mut page_of = format;
    let text = match (&arguments.into, format) {
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
            arguments.check_wishes("a model (`--into`)", &takes)?;
            let shown = model.display();
            let old = Source::read(model).map_err(|e| vec![e])?;
            let patched = patch::patch(old.text(), origin, joints, &wishes)
                .map_err(|why| Failure::Argument(format!("`{shown}`: {why}")))?;
            page_of = FORMATS.iter().find(|f| f.name == patched.format);
            for remark in patched.remarks.iter().chain(&stays(&patched, joints)) {
                tell!("warning: {remark}");
            }
            said.extend(patched.written.iter().map(|(joint, names)| format!("{joint}: {}", names.join(", "))));
            patched.text
        }
        (None, Some(format)) => {
            arguments.check_wishes(&format!("`{}`", format.name), format.takes)?;
            (format.text)(origin, joints, &wishes).map_err(Failure::Argument)?
        }
        (None, None) => return Err(Failure::Argument("a format (`--to`) or a model (`--into`) is needed".into())),
    };
    for joint in joints.iter().filter(|j| !j.broken.is_empty()) {
        tell!(
            "warning: joint `{}`: {} at N = {} is not feasible, it breaks {}; exported anyway",
            joint.joint,
            joint.motor.id,
            crate::words::number(joint.simulated.ratio),
            joint.broken.join(", ")
        );
    }
    for joint in joints.iter().filter(|j| j.simulated.armature.is_none() && arguments.into.is_none()) {
        tell!(
            "warning: joint `{}`: the own inertia of {} is not known and left out: a simulator takes none for it",
            joint.joint,
            joint.motor.id
        );
    }
    for joint in joints.iter().filter(|j| j.broken.is_empty() && !j.unjudged.is_empty()) {
        tell!(
            "warning: joint `{}`: {} at N = {} {}; exported anyway",
            joint.joint,
            joint.motor.id,
            crate::words::number(joint.simulated.ratio),
            sentence(&joint.unjudged)
        );
    }
    for e in joints.iter().filter(|e| e.simulated.is_before_the_joint) {
        let takes = page_of.is_some_and(|f| matches!((f.says)(Fact::Transmission), Cell::Approximately(_)));
        if takes && !e.simulated.over_angle.is_empty() {
            tell!(
                "warning: joint `{}`: its ratio goes with the angle: torque over the angle is written; speed, inertia and friction are left out",
                e.joint
            );
        } else {
            tell!(
                "warning: joint `{}`: its transmission has no one ratio: the numbers are those of the actuator before it",
                e.joint
            );
        }
    }
    if arguments.spread().is_some() {
        for e in joints.iter().filter(|e| e.spread.as_ref().is_none_or(|spread| spread.ranges.is_empty())) {
            tell!("warning: joint `{}`: no number of {} has a ±: no range is written", e.joint, e.motor.id);
        }
    }
    if let Some(wished) = arguments.draws {
        for (e, spread) in joints.iter().filter_map(|e| Some((e, e.spread.as_ref()?))) {
            if spread.draws.len() < usize::from(wished) {
                tell!(
                    "warning: joint `{}`: {} of {wished} draws: with so wide a ± most of the others are no numbers of a motor",
                    e.joint,
                    spread.draws.len()
                );
            }
        }
    }
    if let Some(format) = page_of {
        let inputs = || {
            let mut inputs = catalog.files();
            inputs.extend(robot.files());
            inputs
        };
        arguments.html.write(call, inputs, || html::export::page(format, origin, joints))?;
    }
    let satisfied = joints.iter().all(|j| j.broken.is_empty() && j.unjudged.is_empty());
    let Some(out) = &arguments.out else { return Ok(Done { text, satisfied }) };
    output::write_whole(out, text.as_bytes()).map_err(Failure::Argument)?;
    said.extend(joints.iter().map(|j| {
        let number = crate::words::number;
        let s = &j.simulated;
        format!(
            "{}: {} at N = {}, armature {} kg*m^2, effort {} N*m, velocity {} rad/s",
            j.joint,
            j.motor.id,
            number(s.ratio),
            crate::report::optional(s.armature),
            crate::report::optional(s.effort().map(|b| b.value)),
            number(s.speed.value)
        )
    }));
    said.push(format!("written to {}", out.display()));
    let text = said.iter().map(|line| crate::report::table::paragraph(line, 0, 2)).collect();
    Ok(Done { text, satisfied })
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
