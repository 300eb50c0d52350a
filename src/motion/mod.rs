//! What the joint does: load torque and speed over time, or at independent operating points.

use std::sync::Arc;

pub mod instants;

pub use instants::Between;

use crate::input::csv::{Column, Content, Table};
use crate::input::{InputError, Problem, Range, Source};
use crate::numerics::spline::{self, Derivatives};
use crate::units;

/// How a motion goes on after its last sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    /// It repeats; the period \[s\].
    Periodic(f64),
    /// It happens once; its duration \[s\].
    Once(f64),
    /// Independent operating points, with their total duration \[s\] where durations are given.
    Points(Option<f64>),
}

/// Samples k = 1…K of what a joint asks of its actuator, output side, SI: those that are given, and the instants
/// between them that it takes to see all of the declared spline (`instants.rs`). All vectors but the last have the length K.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Periodic, once, or points.
    pub course: Course,
    /// Time \[s\]; the index for operating points.
    pub time: Vec<f64>,
    /// Load torque \[N·m\], τ: without the actuator's own rotor.
    pub torque: Vec<f64>,
    /// Speed \[rad/s\], ω.
    pub velocity: Vec<f64>,
    /// Acceleration \[rad/s²\], α.
    pub acceleration: Vec<f64>,
    /// Rate of the load torque \[N·m/s\], τ̇.
    pub torque_rate: Vec<f64>,
    /// Jerk \[rad/s³\], j.
    pub jerk: Vec<f64>,
    /// Share of the time that each sample stands for; sums to one. By the trapezoid rule, and by Simpson's where the
    /// way between two given samples is divided.
    pub weight: Vec<f64>,
    /// Share of the time at standstill (speed exactly zero over a whole interval) that each sample
    /// stands for.
    pub dwell: Vec<f64>,
    /// Position \[rad\], q: as given, else the integral of the speed from zero; `None` where it is not
    /// given and the motion does not close, and for operating points.
    pub position: Option<Vec<f64>>,
    /// What was not given but taken from the spline.
    pub derived: Vec<&'static str>,
    /// After what time a motion that happens once is made again \[s\], with rest in between; `None` where it is
    /// made from cold. It counts for heat alone.
    pub repeat_every: Option<f64>,
    /// Which of the samples are given, in order; all others are instants between them.
    pub given: Vec<usize>,
    /// What is known between the samples.
    pub between: Between,
}

/// Samples as they stand in a file or in a requirement; `None` is to be derived.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Time \[s\], strictly increasing.
    pub time: Vec<f64>,
    /// Load torque \[N·m\].
    pub torque: Vec<f64>,
    /// Position \[rad\].
    pub position: Option<Vec<f64>>,
    /// Speed \[rad/s\].
    pub velocity: Option<Vec<f64>>,
    /// Acceleration \[rad/s²\].
    pub acceleration: Option<Vec<f64>>,
    /// Rate of the load torque \[N·m/s\].
    pub torque_rate: Option<Vec<f64>>,
    /// Jerk \[rad/s³\].
    pub jerk: Option<Vec<f64>>,
}

/// One operating point, SI.
#[derive(Debug, Clone, Copy, Default)]
pub struct Point {
    /// Load torque \[N·m\].
    pub torque: f64,
    /// Speed \[rad/s\].
    pub velocity: f64,
    /// Acceleration \[rad/s²\].
    pub acceleration: f64,
    /// Rate of the load torque \[N·m/s\].
    pub torque_rate: f64,
    /// Jerk \[rad/s³\].
    pub jerk: f64,
    /// How long it lasts \[s\].
    pub duration: Option<f64>,
}

impl Motion {
    /// A motion from samples in time. A periodic one must not repeat its first sample. Where no rate but a velocity
    /// is given, the spline is the motion, and the instants that it takes are put between the samples.
    ///
    /// # Panics
    /// With fewer samples than the spline needs, or neither position nor velocity.
    pub fn from_samples(samples: Samples, course: Course) -> Motion {
        let given = samples.acceleration.is_some() || samples.torque_rate.is_some() || samples.jerk.is_some();
        let motion = Motion::at_samples(samples, course);
        if !given {
            return motion.resolved();
        }
        instants::with_holds(Motion { between: Between::Given(instants::likely(&motion)), ..motion })
    }

    /// The same with the instants between its samples, where its spline is the motion.
    pub(super) fn resolved(self) -> Motion {
        instants::resolve(self)
    }

    /// As [`Motion::from_samples`], at the given samples alone; of what lies between nothing is said.
    ///
    /// # Panics
    /// As [`Motion::from_samples`].
    pub(crate) fn at_samples(samples: Samples, course: Course) -> Motion {
        let Samples { time, torque, position, velocity, acceleration, torque_rate, jerk } = samples;
        let differentiate = |y: &[f64]| -> Derivatives {
            match course {
                Course::Periodic(period) => spline::periodic(&time, y, period),
                _ => spline::open(&time, y),
            }
        };
        let mut derived = Vec::new();
        let velocity = velocity.unwrap_or_else(|| {
            derived.push("velocity");
            differentiate(position.as_ref().expect("a motion has velocity or position")).first
        });
        let velocity = at_rest_where_it_rests(velocity);
        let (acceleration, jerk) = match (acceleration, jerk) {
            (Some(acceleration), Some(jerk)) => (acceleration, jerk),
            (Some(acceleration), None) => {
                derived.push("jerk");
                let jerk = differentiate(&acceleration).first;
                (acceleration, jerk)
            }
            (None, jerk) => {
                let Derivatives { first, second } = differentiate(&velocity);
                derived.push("acceleration");
                if jerk.is_none() {
                    derived.push("jerk");
                }
                (first, jerk.unwrap_or(second))
            }
        };
        let position = position.or_else(|| integral(&time, &velocity, &acceleration, course));
        let torque_rate = torque_rate.unwrap_or_else(|| {
            derived.push("torque_rate");
            differentiate(&torque).first
        });
        let (weight, dwell) = time_weights(&time, &velocity, course);
        Motion {
            course,
            given: (0..time.len()).collect(),
            time,
            torque,
            velocity,
            acceleration,
            torque_rate,
            jerk,
            weight,
            dwell,
            position,
            derived,
            repeat_every: None,
            between: Between::Nothing,
        }
    }

    /// Independent operating points. Without durations they weigh alike, and heat cannot be checked.
    ///
    /// # Panics
    /// Without a point.
    pub fn from_points(points: &[Point]) -> Motion {
        assert!(!points.is_empty(), "there is at least one operating point");
        let total: Option<f64> = points.iter().map(|p| p.duration).sum();
        let share = |p: &Point| match (p.duration, total) {
            (Some(duration), Some(total)) => duration / total,
            _ => 1.0 / points.len() as f64,
        };
        let column = |f: fn(&Point) -> f64| points.iter().map(f).collect::<Vec<_>>();
        Motion {
            course: Course::Points(total),
            time: (0..points.len()).map(|k| k as f64).collect(),
            torque: column(|p| p.torque),
            velocity: column(|p| p.velocity),
            acceleration: column(|p| p.acceleration),
            torque_rate: column(|p| p.torque_rate),
            jerk: column(|p| p.jerk),
            weight: points.iter().map(share).collect(),
            dwell: points.iter().map(|p| if p.velocity == 0.0 { share(p) } else { 0.0 }).collect(),
            position: None,
            derived: Vec::new(),
            repeat_every: None,
            given: (0..points.len()).collect(),
            between: Between::Nothing,
        }
    }

    /// The same with a spring of a stiffness \[N·m/rad\] and a rest angle \[rad\] parallel to the actuator: it
    /// pulls the joint towards its rest angle, so that the actuator has to supply `τ + k (q − q_0)`.
    /// `None` where the position is not known.
    pub fn with_spring(&self, stiffness: f64, rest_angle: f64) -> Option<Motion> {
        let position = self.position.as_ref()?;
        let mut moved = self.clone();
        for (k, q) in position.iter().enumerate() {
            moved.torque[k] += stiffness * (q - rest_angle);
            moved.torque_rate[k] += stiffness * self.velocity[k];
        }
        Some(moved)
    }

    /// The same with all torques times `torque`, played `speed` times as fast: the same positions in less
    /// time, so that accelerations go with the square of it and jerks with the cube. The load torque at each
    /// position stays what it was times `torque`: what of it is the load's own inertia is not known here. After
    /// what time it is made again stays what it was, or becomes how long it lasts where that is longer.
    #[must_use]
    pub fn scaled(mut self, torque: f64, speed: f64) -> Motion {
        let times = |values: &mut Vec<f64>, factor: f64| values.iter_mut().for_each(|v| *v *= factor);
        times(&mut self.torque, torque);
        times(&mut self.torque_rate, torque * speed);
        times(&mut self.velocity, speed);
        times(&mut self.acceleration, speed * speed);
        times(&mut self.jerk, speed * speed * speed);
        self.course = match self.course {
            Course::Periodic(duration) => Course::Periodic(duration / speed),
            Course::Once(duration) => Course::Once(duration / speed),
            // The time of a point is its number.
            Course::Points(duration) => return Motion { course: Course::Points(duration.map(|d| d / speed)), ..self },
        };
        times(&mut self.time, 1.0 / speed);
        self.repeat_every = self.repeat_every.zip(self.duration()).map(|(every, lasts)| every.max(lasts));
        self
    }

    /// Number of samples, K.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Whether means over time mean anything: false for points without durations.
    pub fn has_durations(&self) -> bool {
        self.course != Course::Points(None)
    }

    /// Period or duration \[s\]; `None` for points without durations.
    pub fn duration(&self) -> Option<f64> {
        match self.course {
            Course::Periodic(duration) | Course::Once(duration) => Some(duration),
            Course::Points(duration) => duration,
        }
    }

    /// Whether heat has a steady state: it repeats, or means over its durations mean something. Not a motion that
    /// happens once from cold.
    pub fn has_steady_heat(&self) -> bool {
        match self.course {
            Course::Periodic(_) => true,
            Course::Once(_) => self.repeat_every.is_some(),
            Course::Points(total) => total.is_some(),
        }
    }

    /// The share of all time that the motion takes: less than one where rest follows it.
    pub fn share_of_time(&self) -> f64 {
        match (self.course, self.repeat_every) {
            (Course::Once(duration), Some(every)) => duration / every,
            _ => 1.0,
        }
    }

    /// Mean over time of a quantity given per sample.
    pub fn mean(&self, quantity: impl Fn(usize) -> f64) -> f64 {
        (0..self.len()).map(|k| self.weight[k] * quantity(k)).sum()
    }

    /// When sample k is \[s\]: beside a change of sign at a given sample, that of the given one.
    pub fn moment(&self, k: usize) -> f64 {
        self.time[self.given_sample(k).map_or(k, |i| self.given[i])]
    }

    /// Names sample k for people: its time, or its number for operating points.
    pub fn name_sample(&self, k: usize) -> String {
        match self.course {
            Course::Points(_) => format!("point {}", k + 1),
            _ => format!("t = {} s", crate::words::number(self.moment(k))),
        }
    }
}

/// A periodic speed may miss its start by this share of the whole way: what sampling leaves.
const CLOSES: f64 = 1e-3;

/// Position from speed, from zero: the integral of the cubic through speeds and accelerations. What is
/// left over at the end of a period is spread evenly over it; where that is more than rounding and
/// sampling explain, the motion does not close and there is no position.
fn integral(time: &[f64], velocity: &[f64], slope: &[f64], course: Course) -> Option<Vec<f64>> {
    let n = time.len();
    let mut position = vec![0.0; n];
    let step = |i: usize, next: usize, h: f64| {
        0.5 * h * (velocity[i] + velocity[next]) + h * h / 12.0 * (slope[i] - slope[next])
    };
    let mut way = 0.0;
    for i in 1..n {
        let moved = step(i - 1, i, time[i] - time[i - 1]);
        way += moved.abs();
        position[i] = position[i - 1] + moved;
    }
    if let Course::Periodic(period) = course {
        let last = step(n - 1, 0, period - (time[n - 1] - time[0]));
        let left = position[n - 1] + last;
        if left.abs() > CLOSES * (way + last.abs()) {
            return None;
        }
        for (q, t) in position.iter_mut().zip(time) {
            *q -= left * (t - time[0]) / period;
        }
    }
    Some(position)
}

/// Speeds below this share of the largest are rounding, and the joint stands still.
const STANDSTILL: f64 = 1e-9;

/// Sets what is zero but for rounding (a hold that a spline differentiated) to zero: at standstill the
/// direction of power, friction and heat are those of a hold.
fn at_rest_where_it_rests(mut velocity: Vec<f64>) -> Vec<f64> {
    let largest = velocity.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    for v in &mut velocity {
        if v.abs() <= STANDSTILL * largest {
            *v = 0.0;
        }
    }
    velocity
}

/// Trapezoid weights, and the part of them in intervals that stand still from end to end.
fn time_weights(time: &[f64], velocity: &[f64], course: Course) -> (Vec<f64>, Vec<f64>) {
    let n = time.len();
    let (mut weight, mut dwell) = (vec![0.0; n], vec![0.0; n]);
    let (intervals, total) = match course {
        Course::Periodic(period) => (n, period),
        _ => (n - 1, time[n - 1] - time[0]),
    };
    for i in 0..intervals {
        let next = (i + 1) % n;
        let length = if i + 1 < n { time[i + 1] - time[i] } else { total - (time[n - 1] - time[0]) };
        let half = 0.5 * length / total;
        weight[i] += half;
        weight[next] += half;
        if velocity[i] == 0.0 && velocity[next] == 0.0 {
            dwell[i] += half;
            dwell[next] += half;
        }
    }
    (weight, dwell)
}

/// Reads a motion file.
///
/// # Errors
/// Every mistake of the file: columns, units, cells, order of time, too few rows, and a periodic
/// motion whose last row does not repeat the first.
pub fn read(source: &Arc<Source>, periodic: bool, period: Option<f64>) -> Result<Motion, InputError> {
    read_carrying(source, periodic, period, &[]).map(|(motion, _)| motion)
}

/// A column of torque per mass: joint, values \[N·m/kg\], rates \[N·m/(kg·s)\].
pub type CarriedColumn = (String, Vec<f64>, Vec<f64>);

/// Name of a column of torque per mass, without the joint's name.
const TORQUE_PER_MASS: &str = "torque_per_mass_";

/// As [`read`], with what carried actuators ask at each sample: a column `torque_per_mass_NAME [N*m/kg]` for
/// any of `joints`, with its rate.
///
/// # Errors
/// As [`read`].
pub fn read_carrying(
    source: &Arc<Source>,
    periodic: bool,
    period: Option<f64>,
    joints: &[String],
) -> Result<(Motion, Vec<CarriedColumn>), InputError> {
    let mut problems = Vec::new();
    let read = read_samples(source, periodic, period, joints, &mut problems);
    InputError::unless_empty(source, problems)?;
    let (motion, carried) = read.expect("a motion without problems was read");
    let with_rate = |(name, values): (String, Vec<f64>)| {
        let (values, rates) = motion.at_every_sample(&values[..motion.given.len()]);
        (name, values, rates)
    };
    let carried = carried.into_iter().map(with_rate).collect();
    Ok((motion, carried))
}

/// A column of torque per mass: the joint that is carried, and the values \[N·m/kg\].
type Named = (String, Vec<f64>);

/// Whether a motion has a column of torque per mass, or one that could be meant for it.
pub(crate) fn may_carry(source: &Source) -> bool {
    let header = source.text().lines().find(|line| !line.starts_with('#') && !line.trim().is_empty());
    header.is_some_and(|header| header.contains("mass"))
}

/// The columns that a motion may have, with those for actuators of `joints` that are carried.
pub fn columns(joints: &[String]) -> Vec<Column> {
    let column = |name: &str, kind, required| Column {
        name: name.into(),
        content: Content::Quantity(kind, Range::Any),
        required,
    };
    let carried = joints.iter().map(|j| column(&format!("{TORQUE_PER_MASS}{j}"), &units::TORQUE_PER_MASS, false));
    let own = vec![
        column("time", &units::TIME, true),
        column("torque", &units::TORQUE, true),
        column("velocity", &units::SPEED, false),
        column("position", &units::ANGLE, false),
        column("acceleration", &units::ACCELERATION, false),
        column("torque_rate", &units::TORQUE_RATE, false),
        column("jerk", &units::JERK, false),
    ];
    own.into_iter().chain(carried).collect()
}

fn read_samples(
    source: &Arc<Source>,
    periodic: bool,
    period: Option<f64>,
    joints: &[String],
    problems: &mut Vec<Problem>,
) -> Option<(Motion, Vec<Named>)> {
    let table = Table::read(source, columns(joints), problems)?;
    let mut read = |name: &str| table.whole_column(name, "a motion has no gaps", problems);
    let mut samples = Samples {
        time: read("time")?,
        torque: read("torque")?,
        velocity: read("velocity"),
        position: read("position"),
        acceleration: read("acceleration"),
        torque_rate: read("torque_rate"),
        jerk: read("jerk"),
    };
    let column = |name: &String| Some((name.clone(), read(&format!("{TORQUE_PER_MASS}{name}"))?));
    let carried: Vec<(String, Vec<f64>)> = joints.iter().filter_map(column).collect();
    if samples.velocity.is_none() && samples.position.is_none() {
        problems.push(
            Problem::at(0..0, "a motion needs a column `velocity` or `position`", "neither is in the header")
                .help("for example `velocity [rad/s]`"),
        );
    }
    if !problems.is_empty() {
        return None;
    }
    if !check_time(&table, &samples.time, problems) {
        return None;
    }
    let course = take_course(&table, &mut samples, &carried, periodic, period, problems)?;
    if !check_length(&table, samples.time.len(), periodic, period, problems) {
        return None;
    }
    if let Some(problem) = contradiction(&table, &samples) {
        problems.push(problem);
        return None;
    }
    Some((Motion::from_samples(samples, course), carried))
}

/// A velocity that is not the rate of the position given beside it: a wrong unit, sign or column.
fn contradiction(table: &Table, samples: &Samples) -> Option<Problem> {
    let worst = disagreement(&samples.time, samples.position.as_ref()?, samples.velocity.as_ref()?)?;
    Some(
        Problem::at(table.cell_span(worst, "velocity"), "velocity is not the rate of position", "differs most here")
            .help(
                "deg for rad, rpm for rad/s, a wrong sign, or the wrong column? Leave position out if it is not needed",
            ),
    )
}

/// The sample at which velocity differs most from the rate of position, where the two do not belong together.
pub(crate) fn disagreement(time: &[f64], position: &[f64], velocity: &[f64]) -> Option<usize> {
    let (mut apart, mut size, mut worst) = (0.0, 0.0, (0.0, 0));
    for k in 1..position.len() {
        let rate = (position[k] - position[k - 1]) / (time[k] - time[k - 1]);
        let mean = 0.5 * (velocity[k] + velocity[k - 1]);
        apart += (rate - mean).powi(2);
        size += rate.powi(2).max(mean.powi(2));
        if (rate - mean).abs() > worst.0 {
            worst = ((rate - mean).abs(), k);
        }
    }
    (apart > 0.25 * size).then_some(worst.1)
}

/// Whether time increases from row to row, by enough to differentiate; if not, notes where.
pub(crate) fn check_time(table: &Table, time: &[f64], problems: &mut Vec<Problem>) -> bool {
    for row in 1..time.len() {
        if time[row] <= time[row - 1] {
            problems.push(
                Problem::at(
                    table.cell_span(row, "time"),
                    "time does not increase",
                    format!("not later than the row above, {} s", time[row - 1]),
                )
                .help("sort the rows by time and remove duplicates"),
            );
            return false;
        }
    }
    let duration = time[time.len().max(1) - 1] - time[0];
    for row in 1..time.len() {
        if time[row] - time[row - 1] < 1e-9 * duration {
            let what = "two rows are at practically the same time: no derivative can be taken";
            problems.push(Problem::at(
                table.cell_span(row, "time"),
                what,
                "less than 1e-9 of the motion after the row above",
            ));
            return false;
        }
    }
    true
}

/// Whether there are enough samples for the spline; if not, notes it.
pub(crate) fn check_length(
    table: &Table,
    distinct: usize,
    periodic: bool,
    period: Option<f64>,
    problems: &mut Vec<Problem>,
) -> bool {
    let fewest = if periodic { spline::MIN_PERIODIC } else { spline::MIN_OPEN };
    if distinct < fewest {
        problems.push(Problem::at(
            table.row_span(table.len() - 1),
            format!("the motion has {distinct} distinct samples: too few to differentiate"),
            format!("expected at least {}", if periodic && period.is_none() { fewest + 1 } else { fewest }),
        ));
    }
    distinct >= fewest
}

/// Whether the last value is the first again, but for the digits of a table.
pub(crate) fn repeats(values: &[f64]) -> bool {
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    (values[values.len() - 1] - values[0]).abs() <= 1e-4 * (high - low)
}

/// The course of a table, and whether its last row is the first again. Each of `columns` has to repeat its
/// first value at the end of the period.
pub(crate) fn course(
    table: &Table,
    time: &[f64],
    columns: &[(&str, &[f64])],
    periodic: bool,
    period: Option<f64>,
    problems: &mut Vec<Problem>,
) -> Option<(Course, bool)> {
    let last = table.len().checked_sub(1)?;
    let duration = time[last] - time[0];
    if !periodic {
        return Some((Course::Once(duration), false));
    }
    if let Some(period) = period {
        if period < duration * (1.0 - 1e-12) {
            problems.push(Problem::at(
                table.cell_span(last, "time"),
                format!("the motion lasts {duration} s, longer than its period of {period} s"),
                "after the end of the period",
            ));
            return None;
        }
        if period > duration * (1.0 + 1e-9) {
            return Some((Course::Periodic(period), false));
        }
    }
    let before = problems.len();
    for (name, values) in columns {
        if !repeats(values) {
            problems.push(
                Problem::at(
                    table.cell_span(last, name),
                    format!("a periodic motion repeats its first row at the end, but `{name}` does not"),
                    "differs from the first row",
                )
                .help("add the first row again at the end of the period, or give `period`, or set `periodic = false`"),
            );
        }
    }
    (problems.len() == before).then_some((Course::Periodic(duration), true))
}

/// Finds the period, and takes the repeated last row of a periodic motion away.
fn take_course(
    table: &Table,
    samples: &mut Samples,
    carried: &[Named],
    periodic: bool,
    period: Option<f64>,
    problems: &mut Vec<Problem>,
) -> Option<Course> {
    let names: [(&str, Option<&Vec<f64>>); 6] = [
        ("torque", Some(&samples.torque)),
        ("position", samples.position.as_ref().filter(|_| samples.velocity.is_none())),
        ("velocity", samples.velocity.as_ref()),
        ("acceleration", samples.acceleration.as_ref()),
        ("torque_rate", samples.torque_rate.as_ref()),
        ("jerk", samples.jerk.as_ref()),
    ];
    let named: Vec<String> = carried.iter().map(|(joint, _)| format!("{TORQUE_PER_MASS}{joint}")).collect();
    let own = names.iter().filter_map(|(n, v)| Some((*n, v.as_ref()?.as_slice())));
    let more = named.iter().zip(carried).map(|(name, (_, values))| (name.as_str(), values.as_slice()));
    let columns: Vec<(&str, &[f64])> = own.chain(more).collect();
    let (course, last_is_first) = course(table, &samples.time, &columns, periodic, period, problems)?;
    if !last_is_first {
        return Some(course);
    }
    // Beside a velocity the position is only for a spring, which must find its start again: a wheel's is none.
    if samples.position.as_ref().is_some_and(|q| !repeats(q)) {
        samples.position = None;
    }
    samples.time.pop();
    samples.torque.pop();
    let Samples { position, velocity, acceleration, torque_rate, jerk, .. } = samples;
    for values in [position, velocity, acceleration, torque_rate, jerk].into_iter().flatten() {
        values.pop();
    }
    Some(course)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn source(text: &str) -> Arc<Source> {
        Arc::new(Source::new("motion.csv", text))
    }

    #[test]
    fn weights_are_those_of_the_trapezoid_rule() {
        let text = "time [s],torque [N*m],velocity [rad/s],acceleration [rad/s^2]\n\
                    0,1,0,0\n0.1,2,0,0\n0.4,3,1,0\n1,1,0,0\n";
        let motion = read(&source(text), true, None).unwrap();
        assert_eq!(motion.len(), 3);
        assert_relative_eq!(motion.weight.iter().sum::<f64>(), 1.0, max_relative = 1e-14);
        // By hand: 0.1·1.5 + 0.3·2.5 + 0.6·2 = 2.1
        assert_relative_eq!(motion.mean(|k| motion.torque[k]), 2.1, max_relative = 1e-12);
        assert_eq!(motion.dwell, vec![0.05, 0.05, 0.0]);
        assert_eq!(motion.derived, vec!["jerk", "torque_rate"]);
    }

    #[test]
    fn a_motion_that_does_not_close_is_refused() {
        let text = "time [s],torque [N*m],velocity [rad/s]\n0,1,0\n0.1,2,0\n0.4,3,1\n1,1.5,0\n";
        assert!(read(&source(text), true, None).is_err());
        assert!(read(&source(text), false, None).is_ok());
        assert_eq!(read(&source(text), true, Some(1.5)).unwrap().given.len(), 4);
    }
}
