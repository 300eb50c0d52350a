//! The power that all joints draw together, instant by instant.
//!
//! A joint's drive draws `P/η_d` where its motor takes power and gives back `η_d P` where it returns it; the
//! other joints may use what comes back. Between two samples the power is a straight line, as in all means
//! over time: the sum of joints with one time base is then largest at a sample of one of them. Joints without
//! a common time base can meet at their worst instants: the sum of their peaks is a safe bound, and is called so.

use crate::actuator::shaft::Flow;
use crate::actuator::waveform::{Functional, WavePoint};
use crate::actuator::{Actuator, Laurent, Load};
use crate::design::Prepared;
use crate::requirement::{Course, Joint, Motion, Robot};

/// Instants closer than this share of the period are one.
const SAME_INSTANT: f64 = 1e-9;

/// One instant: which samples of which joints count, and how much.
#[derive(Debug, Clone, Default)]
pub(super) struct Instant {
    /// Joint, sample, weight; the weights of a joint sum to its count.
    pub parts: Vec<(usize, usize, f64)>,
}

/// Joints that share a time base.
#[derive(Debug, Clone)]
pub(super) struct Group {
    pub joints: Vec<usize>,
    pub instants: Vec<Instant>,
}

/// When which joint does what.
#[derive(Debug, Clone)]
pub(super) struct Schedule {
    pub groups: Vec<Group>,
}

impl Schedule {
    pub(super) fn new(robot: &Robot) -> Schedule {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (j, joint) in robot.joints.iter().enumerate() {
            let same = |group: &&mut Vec<usize>| share_time(&robot.joints[group[0]].motion, &joint.motion);
            match groups.iter_mut().find(same) {
                Some(group) => group.push(j),
                None => groups.push(vec![j]),
            }
        }
        let make = |joints: Vec<usize>| Group { instants: instants(robot, &joints), joints };
        Schedule { groups: groups.into_iter().map(make).collect() }
    }
}

fn share_time(a: &Motion, b: &Motion) -> bool {
    match (a.course, b.course) {
        (Course::Periodic(x), Course::Periodic(y)) | (Course::Once(x), Course::Once(y)) => (x - y).abs() <= 1e-9 * x,
        _ => false,
    }
}

fn instants(robot: &Robot, joints: &[usize]) -> Vec<Instant> {
    let first = &robot.joints[joints[0]];
    let period = match first.motion.course {
        Course::Points(_) => {
            let whole = |k| Instant { parts: vec![(joints[0], k, f64::from(first.count))] };
            return (0..first.motion.len()).map(whole).collect();
        }
        Course::Periodic(period) => Some(period),
        Course::Once(_) => None,
    };
    let wrap = |t: f64| period.map_or(t, |p| t.rem_euclid(p));
    let own = |joint: &Joint| -> Vec<f64> {
        let start = joint.motion.time[0];
        joint.motion.time.iter().map(|t| t - start).collect()
    };
    let late = |joint: &Joint| -> Vec<(f64, f64)> {
        match (period, joint.phases.is_empty()) {
            (Some(period), false) => joint.phases.iter().map(|share| (share * period, 1.0)).collect(),
            _ => vec![(0.0, f64::from(joint.count))],
        }
    };
    let mut times: Vec<f64> = Vec::new();
    for j in joints {
        let joint = &robot.joints[*j];
        for (shift, _) in late(joint) {
            times.extend(own(joint).iter().map(|t| wrap(t + shift)));
        }
    }
    times.sort_by(f64::total_cmp);
    let scale = SAME_INSTANT * first.motion.duration().unwrap_or(1.0);
    times.dedup_by(|b, a| (*b - *a).abs() <= scale);
    let at = |t: f64| {
        let mut parts = Vec::new();
        for j in joints {
            let joint = &robot.joints[*j];
            let times = own(joint);
            for (shift, weight) in late(joint) {
                for (sample, share) in between(&times, wrap(t - shift), period, scale) {
                    parts.push((*j, sample, weight * share));
                }
            }
        }
        Instant { parts }
    };
    times.into_iter().map(at).collect()
}

/// The samples around a time with their shares.
fn between(times: &[f64], t: f64, period: Option<f64>, scale: f64) -> Vec<(usize, f64)> {
    let n = times.len();
    if period.is_some_and(|p| p - t <= scale) {
        return vec![(0, 1.0)];
    }
    let after = times.partition_point(|x| *x <= t + scale);
    let before = after.saturating_sub(1);
    if (t - times[before]).abs() <= scale || (after == n && period.is_none()) {
        return vec![(before, 1.0)];
    }
    let (next, end) = if after < n { (after, times[after]) } else { (0, period.unwrap_or(t)) };
    let share = (t - times[before]) / (end - times[before]);
    vec![(before, 1.0 - share), (next, share)]
}

/// The power of one actuator at its own samples.
pub(super) struct Profile {
    /// For each sample its points: two where friction may oppose either way.
    points: Vec<Vec<WavePoint>>,
    actuator: Actuator,
    drive: f64,
}

impl Profile {
    pub(super) fn new(load: &Load, samples: usize, actuator: Actuator, drive: f64) -> Profile {
        let mut points = vec![Vec::new(); samples];
        for index in 0..load.waveform.len() {
            let point = load.waveform.point(index);
            points[point.origin].push(point);
        }
        Profile { points, actuator, drive }
    }

    /// Of a candidate at a ratio.
    pub(super) fn of(prepared: &Prepared, drive: f64, ratio: f64) -> Profile {
        let candidate = &prepared.candidate;
        let samples = candidate.joint.motion.len();
        if candidate.is_evaluated() {
            return candidate.at_ratio(ratio, |here| Profile::new(here.load, samples, here.actuator, drive));
        }
        Profile::new(candidate.load, samples, candidate.actuator, drive)
    }

    /// Power that the bus gives at a sample \[W\], and the polynomial that touches it at this ratio and is
    /// nowhere above it.
    pub(super) fn at(&self, sample: usize, ratio: f64) -> (f64, Laurent) {
        let mut most: Option<(f64, Laurent)> = None;
        for point in &self.points[sample] {
            let polynomial = Functional::Power.polynomial(&self.actuator, point.flow as Flow, &point.features);
            let power = polynomial.at(ratio);
            // The larger of P/η and η P.
            let factor = if power > 0.0 { 1.0 / self.drive } else { self.drive };
            if most.as_ref().is_none_or(|(m, _)| power * factor > *m) {
                most = Some((power * factor, polynomial * factor));
            }
        }
        most.unwrap_or_default()
    }

    /// The power at every sample \[W\].
    pub(super) fn course(&self, ratio: f64) -> Vec<f64> {
        (0..self.points.len()).map(|k| self.at(k, ratio).0).collect()
    }
}

/// The largest power over time of all joints together \[W\], from the course of each, and the instant of each
/// group that makes it.
pub(super) fn largest(schedule: &Schedule, courses: &[Vec<f64>]) -> (f64, Vec<usize>) {
    let mut sum = 0.0;
    let mut places = Vec::new();
    for group in &schedule.groups {
        let power = |instant: &Instant| instant.parts.iter().map(|(j, k, w)| w * courses[*j][*k]).sum::<f64>();
        let mut best = (f64::NEG_INFINITY, 0);
        for (i, instant) in group.instants.iter().enumerate() {
            let here = power(instant);
            if here > best.0 {
                best = (here, i);
            }
        }
        sum += best.0;
        places.push(best.1);
    }
    (sum, places)
}
