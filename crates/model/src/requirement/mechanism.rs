//! Joints whose motion comes from a description of the robot: `[mechanism]` names model and trajectory,
//! `mechanism_joint` in a joint takes its torque from inverse dynamics in place of a motion file.

use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;

use super::driven::Driven;
use super::motions::{MotionReader, REPEAT_EVERY, Scale, repeat_every};
use super::robot::Joint;
use super::transmission::passed_on;
use crate::input::{InputError, Key, Problem, Range, Section, Source, key};
use crate::mechanism::described::{self, Described};
use crate::mechanism::torques::{self, Carried, Torques};
use crate::mechanism::trajectory::{self, Trajectory};
use crate::mechanism::{Mechanism, Place};
use crate::motion::Motion;
use crate::units;

/// Lets the joints carry what the description says that they carry, where it leaves the actuators out.
pub(super) fn load(driven: &Driven, joints: &mut [Joint]) {
    let size = driven.carried.iter().map(|c| c.largest().abs()).fold(0.0, f64::max);
    // What only rounding says is nothing: the joint would be solved anew for each mass that it does not feel.
    let felt = |c: &&Carried| driven.separate && c.largest().abs() > 1e-12 * size;
    for Carried { carrying, actuator, coefficients } in driven.carried.iter().filter(felt) {
        let Joint { motion, carries, passed, .. } = &mut joints[*carrying];
        let (mut torque_per_mass, mut rate) = motion.at_every_sample(coefficients);
        if let Some(passed) = passed.as_deref() {
            let through = (0..rate.len()).map(|k| passed_on(passed, k, torque_per_mass[k], rate[k]));
            (torque_per_mass, rate) = through.unzip();
        }
        carries.push(super::robot::Carried { joint: *actuator, torque_per_mass, rate, constant: false });
    }
}

/// The section while the joints are read.
pub(super) enum Model {
    /// There is none.
    Absent,
    /// There is one with mistakes, which are noted already.
    Broken,
    /// Read, and its torques computed.
    Read(Box<Known>),
}

/// A mechanism with its torques.
pub(super) struct Known {
    model: String,
    mechanism: Mechanism,
    trajectory: Trajectory,
    torques: Torques,
    separate: bool,
    /// After what time a trajectory that happens once is made again \[s\].
    repeat_every: Option<f64>,
    /// Speed factor on all motions once they are read.
    overall: f64,
}

impl Known {
    /// Whether its masses are without the actuators.
    pub(super) fn leaves_actuators_out(&self) -> bool {
        self.separate
    }
}

/// What a joint takes from the mechanism.
#[derive(Debug, Clone)]
pub(super) struct Use {
    joint: usize,
    place: Option<Place>,
    /// Where the requirement says where the actuator sits, or which joint it moves.
    pub(super) said: std::ops::Range<usize>,
    /// Force over torque of the screw or belt that moves a sliding joint \[1/m\] inverted: travel per radian \[m\].
    travel: Option<f64>,
    /// Speed of the joint in the end over that of the trajectory.
    speed: f64,
}

/// Reads `[mechanism]`, its files, and computes the torques.
pub(super) fn read(root: &Section, motions: &mut MotionReader) -> Model {
    let about = "a description of the robot that torques are computed from";
    let Some(section) = root.section(key("mechanism", about)) else {
        return if root.has("mechanism") { Model::Broken } else { Model::Absent };
    };
    let known = read_section(&section, motions);
    section.finish();
    known.map_or(Model::Broken, |known| Model::Read(Box::new(known)))
}

fn read_section(section: &Section, motions: &mut MotionReader) -> Option<Known> {
    let model = described::model(section);
    let path = section
        .required_text(key("trajectory", "CSV, a column for each joint").value("file"), "\"robots/arm_pick.csv\"");
    let periodic = section.boolean(key("periodic", "whether the trajectory repeats").default("true")).unwrap_or(true);
    let period = section.quantity(
        key("period", "of a trajectory whose last row does not repeat the first"),
        &units::TIME,
        Range::Positive,
    );
    let every = section.quantity(REPEAT_EVERY, &units::TIME, Range::Positive);
    let friction = section
        .boolean(
            key("joint_friction", "whether damping and dry friction of the model's joints count as load")
                .default("true"),
        )
        .unwrap_or(true);
    let actuators = read_separate(section);
    let mut errors = Vec::new();
    let described = described::read(section, model, &mut |path| motions.open(path), &mut errors);
    motions.errors.append(&mut errors);
    let (Described { model, mechanism, .. }, path) = (described?, path?);
    let trajectory =
        open(section, &path, "trajectory", motions, |source| trajectory::read(source, &mechanism, periodic, period))?;
    let torques = torques::torques(&mechanism, &trajectory, friction);
    let separate = actuators?;
    let repeat_every = repeat_every(section, every, trajectory.course);
    Some(Known { model, mechanism, trajectory, torques, separate, repeat_every, overall: motions.speed })
}

const ACTUATOR_AT: Key = key("actuator_at", "with `mechanism_joint`: where the actuator sits").default("at the joint");

/// The place of an actuator.
fn read_place(table: &Section) -> (Option<toml::Spanned<String>>, [f64; 3]) {
    let link = table.required_text(key("link", "the link that it is mounted on"), "\"base_link\"");
    let at = table.vector(key("at", "where on the link").default("its origin"), &units::LENGTH);
    (link, at.unwrap_or([0.0; 3]))
}

/// Whether the description leaves the actuators out; `None` where what stands there is wrong.
fn read_separate(section: &Section) -> Option<bool> {
    let about = "whether the masses of the model contain the actuators";
    let choices = [("included", false), ("separate", true)];
    let choice = section.choice(key("actuators", about).default("`included`"), &choices);
    if section.has("actuators") { choice } else { Some(false) }
}

/// Opens a file that a key names; what is wrong in it is its own report.
fn open<T>(
    section: &Section,
    name: &toml::Spanned<String>,
    what: &str,
    motions: &mut MotionReader,
    read: impl FnOnce(&Arc<Source>) -> Result<T, InputError>,
) -> Option<T> {
    match motions.open(&section.source().folder().join(Path::new(name.get_ref()))) {
        Ok(source) => read(&source).map_err(|e| motions.errors.push(e)).ok(),
        Err(error) => {
            section.note(error.where_named(what, name.get_ref(), name.span()));
            None
        }
    }
}

impl Use {
    /// Whether two joints of the requirement drive one of the mechanism.
    pub(super) fn is_of_the_same(&self, other: &Use) -> bool {
        self.joint == other.joint
    }
}

/// Reads what `mechanism_joint` and its companions of a joint say, and gives the joint's motion.
pub(super) fn read_joint(section: &Section, scale: Option<Scale>, model: &Model) -> Option<(Motion, Use)> {
    let name = section.required_text(
        key("mechanism_joint", "a joint of `[mechanism]`").value("name").or("motion"),
        "\"elbow_joint\"",
    )?;
    let lead = section.quantity(
        key("lead", "with `mechanism_joint`, where that slides: travel per turn of the gear's output"),
        &units::LENGTH,
        Range::Positive,
    );
    for key in ["periodic", "period", "repeat_every", "motion", "points"] {
        if section.has(key) {
            let message = format!("`{key}` does not go with `mechanism_joint`");
            let help = match key {
                "motion" | "points" => "remove one of the two",
                _ => "write it in [mechanism]",
            };
            section.note(Problem::at(section.span_of(key), message, "the motion is the trajectory's").help(help));
        }
    }
    let known = match model {
        Model::Read(known) => known,
        Model::Broken => {
            if let Some(table) = section.section(ACTUATOR_AT) {
                read_place(&table);
                table.finish();
            }
            return None;
        }
        Model::Absent => {
            section.note(
                Problem::at(name.span(), "`mechanism_joint` needs a table [mechanism]", "no mechanism is described")
                    .help("for example [mechanism] with model = \"robots/arm.urdf\" and trajectory = \"robots/arm_pick.csv\""),
            );
            return None;
        }
    };
    let mechanism = &known.mechanism;
    let Some(joint) = mechanism.joint(name.get_ref()) else {
        let names: Vec<&str> = mechanism.joints().map(|j| j.name.as_str()).collect();
        let message = format!("no joint `{}` moves in `{}`", name.get_ref(), known.model);
        section.note(Problem::at(name.span(), message, "named here").suggest(name.get_ref(), names));
        return None;
    };
    let turns = torques::turns(mechanism, joint);
    if turns && lead.is_some() {
        let message = format!("`{}` turns: it has no lead", name.get_ref());
        section.note(Problem::at(section.span_of("lead"), message, "for joints that slide"));
    }
    if !turns && !section.has("lead") {
        section.missing("lead", "\"10 mm\"  # travel of this sliding joint per turn of the gear's output");
        return None;
    }
    let said = if section.has("actuator_at") { section.span_of("actuator_at") } else { name.span() };
    let place = match section.section(ACTUATOR_AT) {
        None => mechanism.actuator_place(joint),
        Some(table) => {
            let (link, at) = read_place(&table);
            table.finish();
            let link = link?;
            let Some(body) = mechanism.body(link.get_ref()) else {
                let message = format!("there is no link `{}` in `{}`", link.get_ref(), known.model);
                section
                    .note(Problem::at(link.span(), message, "named here").suggest(link.get_ref(), mechanism.frames()));
                return None;
            };
            if known.separate && mechanism.moves(joint, body) {
                let message =
                    format!("the actuator of `{}` sits on what it moves itself, `{}`", name.get_ref(), link.get_ref());
                section.note(Problem::at(link.span(), message, "moved by this joint").help(
                    "name a link that comes before the joint; or let the description's masses contain the actuators (`actuators = \"included\"`)",
                ));
                return None;
            }
            Some(Place { body, at: Vector3::from(at) })
        }
    };
    let travel = lead.filter(|_| !turns).map(|lead| lead / std::f64::consts::TAU);
    // Faster is more than the torque of the slow trajectory: time is scaled before the dynamics, also for what plays all motions faster later.
    let speed = known.overall * scale.map_or(1.0, |scale| scale.speed);
    let motion = if speed == 1.0 {
        known.torques.motion_at_every_instant(&known.trajectory, joint)
    } else {
        let faster = known.trajectory.faster(speed);
        let torques = torques::torques(mechanism, &faster, known.torques.joint_friction);
        torques.motion_at_every_instant(&faster, joint).scaled(1.0, 1.0 / known.overall)
    };
    let motion = travel.map_or_else(|| motion.clone(), |r| through_screw(&motion, r));
    Some((again(section, known, scale, motion)?, Use { joint, place, said, travel, speed }))
}

/// The motion with the torque as the joint scales it, made again after the time that the mechanism says.
fn again(section: &Section, known: &Known, scale: Option<Scale>, motion: Motion) -> Option<Motion> {
    let mut motion = match scale {
        Some(scale) => motion.scaled(scale.torque, 1.0),
        None => motion,
    };
    motion.repeat_every = known.repeat_every;
    let Some((every, lasts)) = motion.repeat_every.zip(motion.duration()).filter(|(every, lasts)| every < lasts) else {
        return Some(motion);
    };
    let message = format!("the scaled motion lasts {lasts} s, but is to be made again after {every} s");
    let problem = Problem::at(section.span_of("scale"), message, "before it ends");
    section.note(problem.help("give a longer `repeat_every` in [mechanism]"));
    None
}

/// The motion of the screw that moves a sliding joint by `travel` \[m\] per radian.
fn through_screw(motion: &Motion, travel: f64) -> Motion {
    let mut turned = motion.clone();
    for values in [&mut turned.torque, &mut turned.torque_rate] {
        values.iter_mut().for_each(|v| *v *= travel);
    }
    let moved = [&mut turned.velocity, &mut turned.acceleration, &mut turned.jerk];
    for values in moved.into_iter().chain(turned.position.as_mut()) {
        values.iter_mut().for_each(|v| *v /= travel);
    }
    turned
}

/// What remains for the robot once its joints are read; `uses` has one entry per joint.
pub(super) fn driven(model: Model, uses: &[Option<Use>]) -> Option<Driven> {
    let Model::Read(known) = model else { return None };
    let Known { model, mechanism, trajectory, torques, separate, .. } = *known;
    let mut notes = torques::notes(&mechanism, &trajectory, &torques);
    let mut places = vec![None; mechanism.moving().len()];
    for u in uses.iter().flatten() {
        places[u.joint] = u.place;
    }
    let mut carried = Vec::new();
    // Each joint feels what it carries as fast as it is asked to move.
    let mut speeds: Vec<f64> = uses.iter().flatten().map(|u| u.speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let at = |speed: f64| {
        let pairs = torques::torques_per_mass(&mechanism, &trajectory.faster(speed), &places);
        pairs.into_iter().map(move |pair| (speed, pair))
    };
    for (speed, pair) in speeds.into_iter().flat_map(at) {
        // A joint of the mechanism may serve several joints of the requirement, or none.
        let by =
            |joint: usize| uses.iter().enumerate().filter(move |(_, u)| u.as_ref().is_some_and(|u| u.joint == joint));
        let as_fast = |(_, u): &(usize, &Option<Use>)| u.as_ref().is_some_and(|u| u.speed == speed);
        for (carrying, u) in by(pair.carrying).filter(as_fast) {
            let travel = u.as_ref().and_then(|u| u.travel).unwrap_or(1.0);
            for (actuator, _) in by(pair.actuator) {
                let coefficients: Vec<f64> = pair.coefficients.iter().map(|c| c * travel).collect();
                carried.push(Carried { carrying, actuator, coefficients });
            }
        }
    }
    carried.sort_by_key(|c| (c.carrying, c.actuator));
    // Of all joints that move it that which is moved by most.
    let before = |joint: usize| {
        let moving = mechanism.moving()[joint];
        let moves = |k: &usize| uses[*k].as_ref().is_some_and(|u| u.joint != joint && mechanism.moves(u.joint, moving));
        (0..uses.len()).filter(moves).max_by_key(|k| {
            let own = uses[*k].as_ref().map_or(0, |u| mechanism.moving()[u.joint]);
            ((0..mechanism.moving().len()).filter(|j| mechanism.moves(*j, own)).count(), std::cmp::Reverse(*k))
        })
    };
    let hangs_on = uses.iter().map(|u| before(u.as_ref()?.joint)).collect();
    let unused: Vec<&str> = mechanism
        .joints()
        .enumerate()
        .filter(|(j, _)| !uses.iter().flatten().any(|u| u.joint == *j))
        .map(|(_, joint)| joint.name.as_str())
        .collect();
    if !unused.is_empty() {
        notes.push(format!("joints of the model that no joint of the requirement drives: {}", unused.join(", ")));
    }
    Some(Driven { model, notes, carried, hangs_on, separate })
}
