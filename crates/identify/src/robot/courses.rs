//! How all joints of a robot moved during a log, on one even grid, smooth enough to be differentiated twice.

use std::ops::Range;

use super::bench::RobotBench;
use crate::bench::{Channel, Log};
use crate::signals::{self, LowPass, noise_level};
use gearwise_model::mechanism::dynamics::{Moving, State, inverse_dynamics, kinematics};
use gearwise_model::mechanism::{Mechanism, Motion};

/// The widest filter, as a share of the sampling rate.
const WIDEST: f64 = 0.2;
/// The narrowest.
const NARROWEST: f64 = 0.002;
/// What a filter takes out of a signal may be this many times what it takes of white noise: more is motion.
const MORE: f64 = 1.1;
/// Share of a signal's size that may be lost where it has no noise.
const LOST: f64 = 1e-5;
/// Share of the filter's cut-off below which motion passes as it is.
const PASSES: f64 = 0.5;
/// Fewest samples of a stretch between gaps.
const FEWEST: usize = 32;

/// The motion of a robot during a log.
pub(super) struct Course {
    /// Times of the grid \[s\], stretch after stretch.
    time: Vec<f64>,
    stretches: Vec<Range<usize>>,
    /// Positions, speeds and accelerations of each joint of the description \[rad, m\].
    state: Vec<[Vec<f64>; 3]>,
    /// Up to which frequency torques that are computed of it are true \[Hz\].
    pub band: f64,
}

/// What a joint's log says of its motion: its position at the output, and its speed where that is read, with what either is
/// multiplied by.
struct Read<'a> {
    log: &'a Log,
    position: (Vec<f64>, f64),
    speed: Option<(&'a [f64], f64)>,
}

impl Course {
    /// Of the logs of all joints, each by its number in the bench file.
    ///
    /// # Errors
    /// In words, where a joint's position is not known for long enough.
    pub fn new<'a>(robot: &'a RobotBench, log_of: impl Fn(usize) -> &'a Log) -> Result<Course, String> {
        let joints: Vec<&gearwise_model::mechanism::Joint> = robot.mechanism.joints().collect();
        let mut reads: Vec<Option<Read>> = (0..joints.len()).map(|_| None).collect();
        for (index, joint) in robot.joints.iter().enumerate() {
            let log = log_of(index);
            let ratio = joint.declared.as_ref().map_or(1.0, |d| d.ratio);
            let turns = joints[joint.number].motion == Motion::Turns;
            let read = Read::new(log, ratio, turns)
                .ok_or_else(|| format!("{}: nothing says where the joint `{}` is", log.name, joint.name))?;
            reads[joint.number] = Some(read);
        }
        let longest = reads.iter().flatten().map(|r| r.log).max_by_key(|log| log.len());
        let Some(log) = longest else { return Err("no joint of the robot is in its logs".into()) };
        let step = signals::median_step(&log.time);
        let grids: Vec<(f64, f64, usize)> = signals::stretches(&log.time)
            .into_iter()
            .filter(|r| r.len() >= FEWEST)
            .map(|r| {
                let (start, end) = (log.time[r.start], log.time[r.end - 1]);
                (start, end, ((end - start) / step).round() as usize + 1)
            })
            .collect();
        let Some(most) = grids.iter().max_by_key(|(.., count)| *count) else {
            return Err(format!("{}: fewer than {FEWEST} rows between gaps", log.name));
        };
        // What is smoothed of each joint: its speed where that is read, else its position.
        let gridded = |values: &[f64], time: &[f64], grid: &(f64, f64, usize)| {
            let rows = time.partition_point(|t| *t < grid.0 - step)..time.partition_point(|t| *t <= grid.1 + step);
            signals::on_grid(&time[rows.clone()], &values[rows], grid.0, step, grid.2)
        };
        let lacks = |name: &str| format!("{}: the position of `{name}` has too few values", log.name);
        let mut fraction = NARROWEST;
        for (read, joint) in reads.iter().zip(&joints) {
            let Some(read) = read else { continue };
            let values = read.speed.map_or(&read.position.0[..], |s| s.0);
            let even = gridded(values, &read.log.time, most).ok_or_else(|| lacks(&joint.name))?;
            fraction = fraction.max(cut(&even));
        }
        let filter = LowPass::new(fraction);
        let mut course =
            Course { time: Vec::new(), stretches: Vec::new(), state: Vec::new(), band: PASSES * fraction / step };
        for grid in &grids {
            let from = course.time.len();
            course.time.extend((0..grid.2).map(|k| grid.0 + k as f64 * step));
            course.stretches.push(from..course.time.len());
        }
        for (number, (read, joint)) in reads.iter().zip(&joints).enumerate() {
            let mut state = [Vec::new(), Vec::new(), Vec::new()];
            for grid in &grids {
                let Some(read) = read else {
                    let place = robot.fixed.iter().find(|(j, _)| *j == number).map_or(0.0, |(_, place)| *place);
                    state[0].extend(std::iter::repeat_n(place, grid.2));
                    state[1].extend(std::iter::repeat_n(0.0, grid.2));
                    state[2].extend(std::iter::repeat_n(0.0, grid.2));
                    continue;
                };
                let smooth = |values: &[f64], factor: f64| {
                    let even = gridded(values, &read.log.time, grid).ok_or_else(|| lacks(&joint.name))?;
                    Ok::<_, String>(filter.apply(&even).into_iter().map(|v| factor * v).collect::<Vec<_>>())
                };
                let position = smooth(&read.position.0, read.position.1)?;
                let speed = match read.speed {
                    Some((values, factor)) => smooth(values, factor)?,
                    None => signals::derivative(&position, step),
                };
                state[2].extend(signals::derivative(&speed, step));
                state[0].extend(position);
                state[1].extend(speed);
            }
            course.state.push(state);
        }
        Ok(course)
    }

    /// What each joint of the description is asked for \[N·m\], at the times of the grid: weight, inertia, springs; no friction.
    pub fn torques(&self, mechanism: &Mechanism) -> Vec<Vec<f64>> {
        let joints: Vec<&gearwise_model::mechanism::Joint> = mechanism.joints().collect();
        let mut all = vec![Vec::with_capacity(self.time.len()); joints.len()];
        for k in 0..self.time.len() {
            let [position, velocity, acceleration] = self.state_at(k);
            let state = State { position: &position, velocity: &velocity, acceleration: &acceleration };
            let torque = inverse_dynamics(mechanism, state, &[]);
            for (j, joint) in joints.iter().enumerate() {
                all[j].push(torque[j] + joint.stiffness * (position[j] - joint.spring_reference));
            }
        }
        all
    }

    /// How every body moves, at each time of the grid.
    pub fn kinematics<'a>(&'a self, mechanism: &'a Mechanism) -> impl Iterator<Item = Vec<Moving>> + 'a {
        (0..self.time.len()).map(|k| {
            let [position, velocity, acceleration] = self.state_at(k);
            kinematics(mechanism, State { position: &position, velocity: &velocity, acceleration: &acceleration })
        })
    }

    fn state_at(&self, k: usize) -> [Vec<f64>; 3] {
        [0, 1, 2].map(|order| self.state.iter().map(|s| s[order][k]).collect())
    }

    /// Values of the grid at other times, linear in between; beyond a stretch that at its end.
    pub fn at(&self, values: &[f64], times: &[f64]) -> Vec<f64> {
        let value = |t: f64| {
            let s = self.stretches.partition_point(|r| self.time[r.start] <= t).saturating_sub(1);
            let rows = self.stretches[s].clone();
            let (times, values) = (&self.time[rows.clone()], &values[rows]);
            let after = times.partition_point(|g| *g <= t);
            if after == 0 || after == times.len() {
                return values[after.min(times.len() - 1)];
            }
            let share = (t - times[after - 1]) / (times[after] - times[after - 1]);
            values[after - 1] + share * (values[after] - values[after - 1])
        };
        times.iter().map(|t| value(*t)).collect()
    }
}

impl<'a> Read<'a> {
    fn new(log: &'a Log, ratio: f64, turns: bool) -> Option<Read<'a>> {
        let at_motor = log.channel(Channel::MotorPosition).map(|v| (v, 1.0 / ratio));
        let (values, factor) = log.channel(Channel::OutputPosition).map(|v| (v, 1.0)).or(at_motor)?;
        let opened = if turns { signals::unwrapped(values) } else { values.to_vec() };
        let speed = log.channel(Channel::MotorVelocity).map(|v| (v, 1.0 / ratio));
        let speed = speed.or_else(|| log.channel(Channel::OutputVelocity).map(|v| (v, 1.0)));
        Some(Read { log, position: (opened, factor), speed })
    }
}

/// The narrowest filter that takes out noise alone, as a share of the sampling rate (D. A. Winter, *Biomechanics and Motor Control
/// of Human Movement*, ch. 3: residual analysis).
fn cut(values: &[f64]) -> f64 {
    let noise = noise_level(values);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let rms = |v: &[f64]| (v.iter().map(|v| v * v).sum::<f64>() / v.len().max(1) as f64).sqrt();
    let size = rms(&values.iter().map(|v| v - mean).collect::<Vec<_>>());
    let mut fraction = NARROWEST;
    while fraction < WIDEST {
        let filter = LowPass::new(fraction);
        let guard = filter.guard().min(values.len() / 4);
        let inside = guard..values.len() - guard;
        let smooth = filter.apply(values);
        let left: Vec<f64> = inside.map(|k| values[k] - smooth[k]).collect();
        let of_noise = noise * (1.0 - filter.noise_gain()).max(0.0).sqrt();
        if rms(&left) <= MORE * of_noise + LOST * size {
            break;
        }
        fraction *= std::f64::consts::SQRT_2.sqrt();
    }
    fraction.min(WIDEST)
}
