//! The power that all joints draw together, instant by instant.
//!
//! A joint's drive draws `P/η_d` where its motor takes power and gives back `η_d P` where it returns it, or `η_r P` where that
//! is less; the other joints may use what comes back. Between two samples the power is a straight line, as in all means
//! over time: the sum of joints with one time base is then largest at a sample of one of them. Joints without
//! a common time base can meet at their worst instants: the sum of their peaks is a safe bound, and is called so.

use crate::actuator::limits::Candidate;
use crate::actuator::supply::Drawn;
use crate::actuator::waveform::{Functional, WavePoint};
use crate::actuator::{Actuator, Laurent};
use crate::design::Prepared;
use crate::requirement::{Course, Motion, Robot};

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
    /// Whether they meet at instants of time, not at operating points.
    pub timed: bool,
}

/// When which joint does what.
#[derive(Debug, Clone)]
pub(super) struct Schedule {
    /// What the robot does: one of these at a time.
    pub scenarios: Vec<Scenario>,
}

/// What all joints do together.
#[derive(Debug, Clone)]
pub(super) struct Scenario {
    /// The load case; `None` where joints have none.
    pub name: Option<String>,
    pub groups: Vec<Group>,
}

/// An instant of each group of a scenario.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Places {
    scenario: usize,
    instants: Vec<usize>,
}

/// What a joint does in a scenario: the motion, and which of the joint's samples it is.
struct Doing {
    joint: usize,
    first: usize,
    motion: Motion,
    /// Whether it may be at any of these samples, whatever the others do.
    any: bool,
}

impl Schedule {
    pub(super) fn new(robot: &Robot) -> Schedule {
        let scenarios = robot.scenarios().into_iter().map(|(name, doing)| {
            let doing = robot.joints.iter().zip(doing).enumerate().map(|(joint, (of, case))| {
                let motion = of.motion.as_ref();
                match motion.cases.as_ref().zip(case) {
                    Some((cases, case)) => {
                        let case = &cases.list[case];
                        Doing { joint, first: case.samples.start, motion: motion.part(case), any: false }
                    }
                    None => Doing { joint, first: 0, motion: motion.clone(), any: motion.cases.is_some() },
                }
            });
            Scenario { name, groups: groups(robot, doing.collect()) }
        });
        Schedule { scenarios: scenarios.collect() }
    }

    /// Joint, sample and weight of everything that counts at an instant of each group.
    pub(super) fn parts<'s>(&'s self, places: &'s Places) -> impl Iterator<Item = &'s (usize, usize, f64)> {
        let groups = &self.scenarios[places.scenario].groups;
        groups.iter().zip(&places.instants).flat_map(|(group, place)| &group.instants[*place].parts)
    }
}

fn groups(robot: &Robot, doing: Vec<Doing>) -> Vec<Group> {
    let mut groups: Vec<Vec<Doing>> = Vec::new();
    for one in doing {
        let same = |group: &&mut Vec<Doing>| !one.any && !group[0].any && share_time(&group[0].motion, &one.motion);
        match groups.iter_mut().find(same) {
            Some(group) => group.push(one),
            None => groups.push(vec![one]),
        }
    }
    let make = |group: Vec<Doing>| Group {
        instants: instants(robot, &group),
        joints: group.iter().map(|doing| doing.joint).collect(),
        timed: matches!(group[0].motion.course, Course::Periodic(_) | Course::Once(_)),
    };
    groups.into_iter().map(make).collect()
}

fn share_time(a: &Motion, b: &Motion) -> bool {
    match (a.course, b.course) {
        (Course::Periodic(x), Course::Periodic(y)) | (Course::Once(x), Course::Once(y)) => (x - y).abs() <= 1e-9 * x,
        _ => false,
    }
}

fn instants(robot: &Robot, group: &[Doing]) -> Vec<Instant> {
    let first = &group[0];
    let period = match first.motion.course {
        Course::Points(_) | Course::Cases => {
            let count = f64::from(robot.joints[first.joint].count);
            let whole = |k| Instant { parts: vec![(first.joint, first.first + k, count)] };
            return (0..first.motion.len()).map(whole).collect();
        }
        Course::Periodic(period) => Some(period),
        Course::Once(_) => None,
    };
    let wrap = |t: f64| period.map_or(t, |p| t.rem_euclid(p));
    let own = |doing: &Doing| -> Vec<f64> {
        let start = doing.motion.time[0];
        doing.motion.time.iter().map(|t| t - start).collect()
    };
    let late = |doing: &Doing| -> Vec<(f64, f64)> {
        let joint = &robot.joints[doing.joint];
        match (period, joint.phases.is_empty()) {
            (Some(period), false) => joint.phases.iter().map(|share| (share * period, 1.0)).collect(),
            _ => vec![(0.0, f64::from(joint.count))],
        }
    };
    let mut times: Vec<f64> = Vec::new();
    for doing in group {
        for (shift, _) in late(doing) {
            times.extend(own(doing).iter().map(|t| wrap(t + shift)));
        }
    }
    times.sort_by(f64::total_cmp);
    let scale = SAME_INSTANT * first.motion.duration().unwrap_or(1.0);
    times.dedup_by(|b, a| (*b - *a).abs() <= scale);
    let at = |t: f64| {
        let mut parts = Vec::new();
        for doing in group {
            let times = own(doing);
            for (shift, weight) in late(doing) {
                for (sample, share) in between(&times, wrap(t - shift), period, scale) {
                    parts.push((doing.joint, doing.first + sample, weight * share));
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
    /// The equations at each end of what is known of the motor's drag.
    ends: Vec<Actuator>,
    /// What is drawn from the bus; of what a joint gives back others can use what would be kept.
    drawn: Drawn,
    standby: f64,
}

impl Profile {
    fn new(candidate: &Candidate, samples: usize) -> Profile {
        let load = candidate.load;
        let drawn = Drawn::new(&candidate.robot.bus);
        let mut points = vec![Vec::new(); samples];
        for index in 0..load.waveform.len() {
            let point = load.waveform.point(index);
            points[point.origin].push(point);
        }
        Profile { points, ends: candidate.ends().copied().collect(), drawn, standby: candidate.standby_power() }
    }

    /// Of a candidate at a ratio.
    pub(super) fn of(prepared: &Prepared, ratio: f64) -> Profile {
        let candidate = &prepared.candidate;
        let samples = candidate.joint.motion.len();
        if candidate.is_evaluated() {
            return candidate.at_ratio(ratio, |here| Profile::new(here, samples));
        }
        Profile::new(candidate, samples)
    }

    /// Power that the bus gives at a sample \[W\], and the polynomial that touches it at this ratio and is
    /// nowhere above it.
    pub(super) fn at(&self, sample: usize, ratio: f64) -> (f64, Laurent) {
        let mut most: Option<(f64, Laurent)> = None;
        let points = self.points[sample].iter().flat_map(|point| self.ends.iter().map(move |end| (point, end)));
        for (point, end) in points {
            let polynomial = Functional::Power.polynomial(end, point, ratio);
            let power = polynomial.at(ratio);
            let factor = self.drawn.per_power(power);
            let drawn = power * factor + self.standby;
            if most.as_ref().is_none_or(|(m, _)| drawn > *m) {
                most = Some((drawn, polynomial * factor + Laurent::constant(self.standby)));
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
pub(super) fn largest(schedule: &Schedule, courses: &[Vec<f64>]) -> (f64, Places) {
    let mut best = (f64::NEG_INFINITY, Places { scenario: 0, instants: Vec::new() });
    for (scenario, of) in schedule.scenarios.iter().enumerate() {
        let (power, instants) = worst(of, courses);
        if power > best.0 {
            best = (power, Places { scenario, instants });
        }
    }
    best
}

/// The largest power over time in one scenario \[W\], and the instant of each group that makes it.
fn worst(scenario: &Scenario, courses: &[Vec<f64>]) -> (f64, Vec<usize>) {
    let mut sum = 0.0;
    let mut places = Vec::new();
    for group in &scenario.groups {
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

/// The largest power of each load case \[W\] with its name; nothing where joints have no cases.
pub(super) fn by_case(schedule: &Schedule, courses: &[Vec<f64>]) -> Vec<(String, f64)> {
    let named = schedule.scenarios.iter().filter_map(|scenario| Some((scenario.name.clone()?, scenario)));
    named.map(|(name, scenario)| (name, worst(scenario, courses).0)).collect()
}
