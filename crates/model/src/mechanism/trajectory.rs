//! What the robot does: positions of all joints over time, and the forces of its surroundings. What is not
//! given comes from the spline of [`crate::numerics::spline`], by the rule of a motion file.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::Vector3;

use super::dynamics::{State, Wrench};
use super::{Joint, Mechanism, Motion as Degree};
use crate::input::csv::{Column, Content, Table};
use crate::input::kind::{self, FileKind};
use crate::input::{InputError, Problem, Range, Source, limits};
use crate::motion::{Course, Motion, Samples};
use crate::motion::{check_length, check_time, course, repeats};
use crate::units::{self, Kind};

/// Samples of the state of all joints, and of the outer forces. SI.
#[derive(Debug, Clone)]
pub struct Trajectory {
    /// Periodic or once.
    pub course: Course,
    /// Time of the samples \[s\].
    pub time: Vec<f64>,
    /// Per joint and sample: positions \[rad, m\].
    pub position: Vec<Vec<f64>>,
    /// Per joint and sample: speeds \[rad/s, m/s\].
    pub velocity: Vec<Vec<f64>>,
    /// Per joint and sample: accelerations \[rad/s², m/s²\].
    pub acceleration: Vec<Vec<f64>>,
    /// Per joint: whether the trajectory gives its accelerations; else they are the spline's.
    pub gives_acceleration: Vec<bool>,
    /// Forces at the origins of frames, world axes.
    pub contacts: Vec<Contact>,
}

/// Force and moment of the surroundings on a frame, per sample, world axes.
#[derive(Debug, Clone)]
pub struct Contact {
    /// Index of the body.
    pub body: usize,
    /// Force at its origin \[N\].
    pub force: Vec<Vector3<f64>>,
    /// Moment \[N·m\].
    pub moment: Vec<Vector3<f64>>,
}

/// The state of one sample.
#[derive(Debug, Clone, Default)]
pub struct Sample {
    /// Positions of the joints.
    pub position: Vec<f64>,
    /// Their speeds.
    pub velocity: Vec<f64>,
    /// Their accelerations.
    pub acceleration: Vec<f64>,
}

impl Trajectory {
    /// Scale the speed of the path by a factor: the same positions in less time, under the same external forces.
    #[must_use]
    pub fn faster(&self, speed: f64) -> Trajectory {
        let mut faster = self.clone();
        faster.time.iter_mut().for_each(|time| *time /= speed);
        faster.velocity.iter_mut().flatten().for_each(|velocity| *velocity *= speed);
        faster.acceleration.iter_mut().flatten().for_each(|acceleration| *acceleration *= speed * speed);
        faster.course = match self.course {
            Course::Periodic(lasts) => Course::Periodic(lasts / speed),
            Course::Once(lasts) => Course::Once(lasts / speed),
            other => other,
        };
        faster
    }
}

impl Sample {
    /// As the dynamics take it.
    pub fn state(&self) -> State<'_> {
        State { position: &self.position, velocity: &self.velocity, acceleration: &self.acceleration }
    }
}

impl Trajectory {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// The joints at sample `k`.
    pub fn sample(&self, k: usize) -> Sample {
        let column = |columns: &[Vec<f64>]| columns.iter().map(|values| values[k]).collect();
        Sample {
            position: column(&self.position),
            velocity: column(&self.velocity),
            acceleration: column(&self.acceleration),
        }
    }

    /// The outer forces at sample `k`.
    pub fn wrenches(&self, k: usize) -> Vec<Wrench> {
        self.contacts.iter().map(|c| Wrench { body: c.body, force: c.force[k], moment: c.moment[k] }).collect()
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Kinds of position, speed and acceleration of a joint.
fn kinds(joint: &Joint) -> [(&'static str, &'static Kind); 3] {
    match joint.motion {
        Degree::Turns => [("", &units::ANGLE), (".velocity", &units::SPEED), (".acceleration", &units::ACCELERATION)],
        Degree::Slides => {
            [("", &units::LENGTH), (".velocity", &units::LINEAR_SPEED), (".acceleration", &units::LINEAR_ACCELERATION)]
        }
    }
}

fn columns(mechanism: &Mechanism) -> Vec<Column> {
    let column = |name: String, kind, required| Column { name, content: Content::Quantity(kind, Range::Any), required };
    let mut columns = vec![column("time".into(), &units::TIME, true)];
    for joint in mechanism.joints() {
        for (suffix, kind) in kinds(joint) {
            columns.push(column(format!("{}{suffix}", joint.name), kind, false));
        }
    }
    for frame in mechanism.frames() {
        for axis in AXES {
            columns.push(column(format!("{frame}.force_{axis}"), &units::FORCE, false));
            columns.push(column(format!("{frame}.moment_{axis}"), &units::TORQUE, false));
        }
    }
    columns
}

/// Reads a trajectory: `time [s]` and, for every joint of the mechanism, `<joint> [rad]` (`[m]` where it
/// slides), with `<joint>.velocity` and `<joint>.acceleration` where they are known; `<frame>.force_x [N]` …
/// `<frame>.moment_z [N*m]` for what the surroundings put on the origin of a frame, in world axes.
///
/// # Errors
/// Every mistake of the file: unknown and missing columns, units, cells, order of time, too few rows, and a
/// periodic motion whose last row does not repeat the first (whole turns of a revolute joint apart).
pub fn read(
    source: &Arc<Source>,
    mechanism: &Mechanism,
    periodic: bool,
    period: Option<f64>,
) -> Result<Trajectory, InputError> {
    let mut problems = Vec::new();
    let trajectory = read_table(source, mechanism, periodic, period, &mut problems);
    // A table with another joint's name is a trajectory with a slip.
    let wanted = [FileKind::OverTime, FileKind::Table, FileKind::Empty];
    InputError::unless_empty(source, problems).map_err(|error| kind::instead(error, &wanted))?;
    trajectory.ok_or_else(|| InputError {
        source: source.clone(),
        problems: vec![Problem::whole("the trajectory could not be read")],
    })
}

fn read_table(
    source: &Arc<Source>,
    mechanism: &Mechanism,
    periodic: bool,
    period: Option<f64>,
    problems: &mut Vec<Problem>,
) -> Option<Trajectory> {
    let table = Table::read(source, columns(mechanism), problems)?;
    let values = table.len().saturating_mul(mechanism.joints().count());
    if values > limits::SAMPLES {
        let message = limits::too_many("samples of all joints together", values, limits::SAMPLES);
        problems.push(Problem::whole(message).help("take every n-th row of the trajectory"));
        return None;
    }
    for joint in mechanism.joints().filter(|j| !table.has(&j.name)) {
        let message = format!("`{}` is a joint of the model, but has no column", joint.name);
        let example =
            format!("add a column `{} [{}]`: its position; all zero where it stays", joint.name, joint.position_unit());
        problems.push(Problem::at(table.header_span(), message, "not in this header").help(example));
    }
    let mut read = |name: &str| table.whole_column(name, "a trajectory has no gaps", problems);
    let mut time = read("time")?;
    let mut joints: Vec<[Option<Vec<f64>>; 3]> = Vec::new();
    for joint in mechanism.joints() {
        joints.push(kinds(joint).map(|(suffix, _)| read(&format!("{}{suffix}", joint.name))));
    }
    let mut contacts: Vec<(usize, [Option<Vec<f64>>; 6])> = Vec::new();
    for (b, body) in mechanism.bodies.iter().enumerate() {
        let Some(name) = &body.name else { continue };
        let column = |i: usize| format!("{name}.{}_{}", if i < 3 { "force" } else { "moment" }, AXES[i % 3]);
        if (0..6).any(|i| table.has(&column(i))) {
            contacts.push((b, [0, 1, 2, 3, 4, 5].map(|i| read(&column(i)))));
        }
    }
    if !problems.is_empty() || table.is_empty() || !check_time(&table, &time, problems) {
        return None;
    }
    let named = named_columns(mechanism, &joints, &contacts, periodic);
    let borrowed: Vec<(&str, &[f64])> = named.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    let (course, last_is_first) = course(&table, &time, &borrowed, periodic, period, problems)?;
    // Whole turns that a joint of a periodic motion gains over the period.
    let gains: Vec<f64> = joints
        .iter()
        .map(|[q, ..]| {
            q.as_ref().map_or(0.0, |q| if last_is_first && !repeats(q) { q[q.len() - 1] - q[0] } else { 0.0 })
        })
        .collect();
    if last_is_first {
        time.pop();
        for values in joints.iter_mut().flatten().chain(contacts.iter_mut().flat_map(|(_, six)| six)).flatten() {
            values.pop();
        }
    }
    if !check_length(&table, time.len(), periodic, period, problems) {
        return None;
    }
    let mut trajectory = Trajectory {
        course,
        position: Vec::new(),
        velocity: Vec::new(),
        acceleration: Vec::new(),
        gives_acceleration: Vec::new(),
        contacts: Vec::new(),
        time,
    };
    for ([position, velocity, acceleration], gain) in joints.into_iter().zip(gains) {
        trajectory.add_joint(position?, velocity, acceleration, gain);
    }
    let n = trajectory.len();
    for (body, six) in contacts {
        let triple = |i: usize| {
            let at = |axis: usize, k: usize| six[i + axis].as_ref().map_or(0.0, |values| values[k]);
            (0..n).map(|k| Vector3::new(at(0, k), at(1, k), at(2, k))).collect()
        };
        trajectory.contacts.push(Contact { body, force: triple(0), moment: triple(3) });
    }
    Some(trajectory)
}

/// The columns that have to repeat; a joint that gains whole turns is asked for them alone.
fn named_columns<'a>(
    mechanism: &Mechanism,
    joints: &'a [[Option<Vec<f64>>; 3]],
    contacts: &'a [(usize, [Option<Vec<f64>>; 6])],
    periodic: bool,
) -> Vec<(String, &'a [f64])> {
    let mut named = Vec::new();
    for (joint, three) in mechanism.joints().zip(joints) {
        for ((suffix, _), values) in kinds(joint).iter().zip(three) {
            let Some(values) = values else { continue };
            let gained = (values[values.len() - 1] - values[0]) / TAU;
            let turns =
                joint.motion == Degree::Turns && gained.round() != 0.0 && (gained - gained.round()).abs() < 1e-4;
            if !(periodic && suffix.is_empty() && turns) {
                named.push((format!("{}{suffix}", joint.name), values.as_slice()));
            }
        }
    }
    for (body, six) in contacts {
        let name = mechanism.bodies[*body].name.as_deref().unwrap_or("");
        for (i, values) in six.iter().enumerate() {
            if let Some(values) = values {
                let what = if i < 3 { "force" } else { "moment" };
                named.push((format!("{name}.{what}_{}", AXES[i % 3]), values.as_slice()));
            }
        }
    }
    named
}

impl Trajectory {
    /// Adds a joint; `gain` is how far its position comes over a period \[rad\].
    fn add_joint(&mut self, position: Vec<f64>, velocity: Option<Vec<f64>>, acceleration: Option<Vec<f64>>, gain: f64) {
        let rate = match self.course {
            Course::Periodic(period) => gain / period,
            _ => 0.0,
        };
        let begin = self.time[0];
        let closed = position.iter().zip(&self.time).map(|(q, t)| q - rate * (t - begin)).collect();
        let given = velocity.is_some();
        self.gives_acceleration.push(acceleration.is_some());
        let samples = Samples {
            torque: vec![0.0; self.time.len()],
            time: self.time.clone(),
            position: Some(closed),
            velocity,
            acceleration,
            ..Samples::default()
        };
        let motion = Motion::at_samples(samples, self.course);
        let offset = if given { 0.0 } else { rate };
        self.velocity.push(motion.velocity.iter().map(|v| v + offset).collect());
        self.acceleration.push(motion.acceleration);
        self.position.push(position);
    }
}
