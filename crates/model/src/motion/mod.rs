//! What the joint does: load torque and speed over time, or at independent operating points.

pub mod cases;
mod episodes;
pub mod instants;
mod read;
mod through;

pub use cases::{Case, Cases, Lasting, Often, Step};
pub use episodes::{SimulatorsOwn, of_episodes};
pub use instants::Between;
pub(crate) use instants::Instant;
pub use read::{CarriedColumn, OWN_COLUMNS, columns, of_arrays, read, read_carrying};
pub(crate) use read::{check_length, check_time, course, disagreement, may_carry, repeats};
pub(crate) use through::{At, through};

use std::sync::Arc;

use crate::numerics::spline::{self, Derivatives};

/// How a motion goes on after its last sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    /// It repeats; the period \[s\].
    Periodic(f64),
    /// It happens once; its duration \[s\].
    Once(f64),
    /// Independent operating points, with their total duration \[s\] where durations are given.
    Points(Option<f64>),
    /// Several load cases, each with a course of its own (`Motion::cases`).
    Cases,
}

/// Samples k = 1…K of what a joint asks of its actuator, output side, SI: those that are given, and the instants
/// between them that it takes to see all of the declared spline (`instants.rs`). All vectors but the last have the length K.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Periodic, once, or points.
    pub course: Course,
    /// Time \[s\]; the index for operating points. Of several cases each has its own.
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
    /// True if a spring may take part of the torque. Standstill is then weighted by time instead of torque, so that it does not depend
    /// on the spring.
    pub sprung: bool,
    /// Share of the time that each sample stands for; sums to one. By the trapezoid rule, and by Simpson's where the
    /// way between two given samples is divided.
    pub weight: Vec<f64>,
    /// Share of the time at standstill (speed exactly zero over a whole interval) that each sample
    /// stands for.
    pub dwell: Vec<f64>,
    /// Position \[rad\], q: as given, else the integral of the speed from zero; `None` where it is not
    /// given and the motion does not close, and for operating points.
    pub position: Option<Vec<f64>>,
    /// Whether the position is given, and not counted from where the motion begins.
    pub placed: bool,
    /// What was not given but taken from the spline.
    pub derived: Vec<&'static str>,
    /// After what time a motion that happens once is made again \[s\], with rest in between; `None` where it is
    /// made from cold. It counts for heat alone.
    pub repeat_every: Option<f64>,
    /// Which of the samples are given, in order; all others are instants between them.
    pub given: Vec<usize>,
    /// What is known between the samples.
    pub between: Between,
    /// What of the torque at standstill counts in means over time: all of it, but for what friction of a transmission may hold.
    pub held: f64,
    /// The load cases, where there are several.
    pub cases: Option<Arc<Cases>>,
    /// Whether the samples are of many runs, each with an order of its own: then temperature over the motion cannot be followed,
    /// and the order of the samples says nothing of it.
    pub mixed: bool,
    /// Samples at which limits at instants are looked at, ascending, where these are not all: means and heat are of all. Whoever
    /// chooses them has to look at the others afterwards.
    pub looked: Option<Arc<[usize]>>,
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
        let placed = position.is_some();
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
            placed,
            derived,
            repeat_every: None,
            between: Between::Nothing,
            held: 1.0,
            cases: None,
            sprung: false,
            looked: None,
            mixed: false,
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
            placed: false,
            derived: Vec::new(),
            repeat_every: None,
            given: (0..points.len()).collect(),
            between: Between::Nothing,
            held: 1.0,
            cases: None,
            sprung: false,
            looked: None,
            mixed: false,
        }
    }

    /// The same with a spring of a stiffness \[N·m/rad\] and a rest angle \[rad\] parallel to the actuator: it
    /// pulls the joint towards its rest angle, so that the actuator has to supply `τ + k (q − q_0)`.
    /// `None` where the position is not known.
    pub fn with_spring(&self, stiffness: f64, rest_angle: f64) -> Option<Motion> {
        let position = self.position.as_ref()?;
        let mut moved = self.clone();
        moved.sprung = true;
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
        if let Some(cases) = self.cases.clone() {
            let parts = self.parts().into_iter().map(|(_, part)| part.scaled(torque, speed)).collect();
            let every = self.repeat_every;
            let scaled = Motion { repeat_every: every, ..Motion::recomposed(&cases, parts) };
            let repeat_every = every.zip(scaled.duration()).map(|(every, lasts)| every.max(lasts));
            return Motion { repeat_every, ..scaled };
        }
        let times = |values: &mut Vec<f64>, factor: f64| values.iter_mut().for_each(|v| *v *= factor);
        times(&mut self.torque, torque);
        times(&mut self.torque_rate, torque * speed);
        times(&mut self.velocity, speed);
        times(&mut self.acceleration, speed * speed);
        times(&mut self.jerk, speed * speed * speed);
        self.course = match self.course {
            Course::Periodic(duration) => Course::Periodic(duration / speed),
            Course::Once(duration) => Course::Once(duration / speed),
            Course::Cases => Course::Cases,
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

    /// The samples at which limits at instants are looked at.
    pub fn looked_at(&self) -> Vec<usize> {
        self.looked.as_ref().map_or_else(|| (0..self.len()).collect(), |looked| looked.to_vec())
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Whether means over time mean anything: false for points without durations.
    pub fn has_durations(&self) -> bool {
        self.course != Course::Points(None)
    }

    /// Period or duration \[s\]; `None` for points without durations. Of several cases: how long all that is stated
    /// moves, without rest; `None` where only shares of the time are stated.
    pub fn duration(&self) -> Option<f64> {
        match self.course {
            Course::Cases => self.cases.as_ref()?.moves(),
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
            Course::Cases => self.repeat_every.is_some() || !self.cases.as_ref().is_some_and(|c| c.once),
        }
    }

    /// The share of all time that the motion takes: less than one where rest follows it.
    pub fn share_of_time(&self) -> f64 {
        match (self.course, self.repeat_every, &self.cases) {
            (Course::Once(duration), Some(every), _) => duration / every,
            (Course::Cases, every, Some(cases)) => {
                let lasts = cases.sequence_lasts().1;
                cases.moving() * every.map_or(1.0, |every| lasts / every.max(lasts))
            }
            _ => 1.0,
        }
    }

    /// Mean over time of a quantity given per sample.
    pub fn mean(&self, quantity: impl Fn(usize) -> f64) -> f64 {
        (0..self.len()).map(|k| self.weight[k] * quantity(k)).sum()
    }

    /// When sample k is \[s\]: beside a change of sign at a given sample, that of the given one.
    pub fn moment(&self, k: usize) -> f64 {
        let first = self.case_of(k).map_or(0, |case| case.given.start);
        self.time[self.given_sample(k).map_or(k, |i| self.given[first + i])]
    }

    /// The load case that sample k is of, where there are several.
    pub fn case_of(&self, k: usize) -> Option<&Case> {
        self.cases.as_ref()?.of(k)
    }

    /// The samples of each of its cases with their course, or all of them with its own.
    pub fn courses(&self) -> Vec<(std::ops::Range<usize>, Course)> {
        match &self.cases {
            Some(cases) => cases.list.iter().map(|case| (case.samples.clone(), case.course)).collect(),
            None => vec![(0..self.len(), self.course)],
        }
    }

    /// Whether sample k is an operating point: it has a number and no time.
    pub fn is_point(&self, k: usize) -> bool {
        matches!(self.case_of(k).map_or(self.course, |case| case.course), Course::Points(_))
    }

    /// Names sample k for people: its case where there are several, and its time, or its number for operating points.
    pub fn name_sample(&self, k: usize) -> String {
        let case = self.case_of(k);
        let name = match self.is_point(k) {
            true => format!("point {}", k - case.map_or(0, |case| case.samples.start) + 1),
            false => format!("t = {} s", crate::words::number(self.moment(k))),
        };
        case.map_or(name.clone(), |case| format!("{}, {name}", case.name))
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
