//! The power that all joints draw together, instant by instant, and how far it lets the bus sag.
//!
//! A joint's drive draws `P/η_d` where its motor takes power and gives back `η_d P` where it returns it, or `η_r P` where that
//! is less; the other joints may use what comes back. Between two samples the power is a straight line, as in all means
//! over time: the sum of joints with one time base is then largest at a sample of one of them. Joints without
//! a common time base can meet at their worst instants: the sum of their peaks is a safe bound, and is called so.
//!
//! A supply with a resistance gives each drive what the others leave. What a drive asks for beyond that is a power too
//! ([`Supply::beyond`]): so each drive at each instant is a row of the same kind as that of the power. What others give back is
//! not counted on.
//!
//! What comes back is counted at its most, as the limit of one joint counts it: of a winding at the reference temperature. What others
//! draw at that instant is taken off, at its least.

use super::answer::Sag;
use super::convex::under;
use crate::Prepared;
use crate::program::{minimise, value};
use gearwise_model::actuator::limits::Candidate;
use gearwise_model::actuator::supply::{Drawn, Supply};
use gearwise_model::actuator::waveform::{Functional, WavePoint, Waveform};
use gearwise_model::actuator::{Actuator, Laurent};
use gearwise_model::motion::Case;
use gearwise_model::requirement::{Course, Motion, Robot};

/// Instants closer than this share of the period are one.
const SAME_INSTANT: f64 = 1e-9;

/// One instant: which samples of which joints count, and how much.
#[derive(Debug, Clone, Default)]
pub(super) struct Instant {
    /// Joint, sample, weight; the weights of a joint sum to its count.
    pub parts: Vec<(usize, usize, f64)>,
    /// The actuators that do not all do the same.
    drives: Vec<Drive>,
}

/// An actuator at an instant: its joint, and the samples that it is at with their shares, which sum to one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Drive {
    pub joint: usize,
    pub samples: Vec<(usize, f64)>,
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
    /// The drive whose voltage is looked at; `None` where it is the power of all.
    pub drive: Option<Drive>,
}

/// What a joint does in a scenario: the motion, and which of the joint's samples it is.
struct Doing {
    joint: usize,
    first: usize,
    motion: Motion,
    /// How many actuators of the joint do it.
    count: f64,
    /// Whether it may be at any of these samples, whatever the others do.
    any: bool,
}

impl Schedule {
    pub(super) fn new(robot: &Robot) -> Schedule {
        let scenarios = robot.scenarios().into_iter().map(|(name, doing)| {
            let doing = robot.joints.iter().zip(doing).enumerate().flat_map(|(joint, (of, case))| {
                let (motion, count) = (of.motion.as_ref(), f64::from(of.count));
                let part = |case: &Case, count| Doing {
                    joint,
                    first: case.samples.start,
                    motion: motion.part(case),
                    count,
                    any: false,
                };
                match (motion.cases.as_ref(), case) {
                    (Some(both), _) if both.together => {
                        let each = count / both.list.len() as f64;
                        both.list.iter().map(|case| part(case, each)).collect()
                    }
                    (Some(cases), Some(case)) => vec![part(&cases.list[case], count)],
                    (cases, _) => {
                        vec![Doing { joint, first: 0, motion: motion.clone(), count, any: cases.is_some() }]
                    }
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
    groups.into_iter().map(make).flat_map(|group| apart(robot, group)).collect()
}

/// Actuators of one joint at operating points need not be at the same one: on a supply that sags one of them is looked at while the
/// others are at their worst.
fn apart(robot: &Robot, group: Group) -> Vec<Group> {
    let parts = group.instants.first().into_iter().flat_map(|instant| &instant.parts);
    let count: f64 = parts.map(|(_, _, weight)| weight).sum();
    if group.timed || count <= 1.0 || robot.shared_resistance().is_none() {
        return vec![group];
    }
    let of = |many: f64| {
        let mut some = group.clone();
        let parts = some.instants.iter_mut().flat_map(|instant| &mut instant.parts);
        parts.for_each(|(_, _, weight)| *weight *= many / count);
        some
    };
    vec![of(1.0), of(count - 1.0)]
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
            let count = first.count;
            let whole = |k| Instant {
                parts: vec![(first.joint, first.first + k, count)],
                drives: vec![Drive { joint: first.joint, samples: vec![(first.first + k, 1.0)] }],
            };
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
            _ => vec![(0.0, doing.count)],
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
        let (mut parts, mut drives) = (Vec::new(), Vec::new());
        for doing in group {
            let times = own(doing);
            for (shift, weight) in late(doing) {
                let around = between(&times, wrap(t - shift), period, scale).into_iter();
                let samples: Vec<(usize, f64)> = around.map(|(k, share)| (doing.first + k, share)).collect();
                parts.extend(samples.iter().map(|(sample, share)| (doing.joint, *sample, weight * share)));
                drives.push(Drive { joint: doing.joint, samples });
            }
        }
        Instant { parts, drives }
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
    waveform: Waveform,
    samples: usize,
    /// The equations at each end of what is known of the motor's drag.
    ends: Vec<Actuator>,
    /// What is drawn from the bus; of what a joint gives back others can use what would be kept.
    drawn: Drawn,
    drive_efficiency: f64,
    standby: f64,
    /// A supply that sags under all joints, and the resistance that they share \[Ω\].
    supply: Option<(Supply, f64)>,
}

/// What one actuator draws and asks for at its own samples, at a ratio.
#[derive(Debug, Clone)]
pub struct Draws {
    /// Power that the bus gives \[W\], what comes back less than zero.
    pub power: Vec<f64>,
    /// Power that reaches the bus \[W\], at the most: of a winding at the reference temperature, at the end of the motor's drag where it
    /// is more; less than zero where some is drawn.
    pub returned: Vec<f64>,
    /// Power that its drive asks for beyond what there is \[W\], as if it were alone, and the bus voltage that it needs \[V\]; empty where
    /// the supply is stiff.
    beyond: Vec<(f64, f64)>,
}

impl Draws {
    /// What counts of its power where it is not counted on that it gives some back.
    fn taken(&self, sample: usize) -> f64 {
        self.power[sample].max(0.0)
    }
}

impl Profile {
    fn new(candidate: &Candidate, samples: usize) -> Profile {
        let supply = candidate.supply(candidate.joint.limits.reserve("voltage"));
        Profile {
            waveform: candidate.load.waveform.clone(),
            samples,
            ends: candidate.ends().copied().collect(),
            drawn: Drawn::new(&candidate.robot.bus),
            drive_efficiency: candidate.robot.bus.drive_efficiency,
            standby: candidate.standby_power(),
            supply: supply.zip(candidate.robot.shared_resistance()),
        }
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

    /// The largest of a measure over the points of a sample and the ends of the drag, with its polynomial.
    fn largest<T>(&self, sample: usize, of: impl Fn(&WavePoint, &Actuator) -> (f64, T)) -> Option<(f64, T)> {
        let mut most: Option<(f64, T)> = None;
        // Two points where friction may oppose either way.
        let points = self.waveform.of_sample(sample).iter().map(|k| self.waveform.point(*k));
        for (point, end) in points.flat_map(|point| self.ends.iter().map(move |end| (point, end))) {
            let here = of(&point, end);
            if most.as_ref().is_none_or(|(value, _)| here.0 > *value) {
                most = Some(here);
            }
        }
        most
    }

    /// Power that the bus gives at a sample \[W\], and the polynomial that touches it at this ratio and is
    /// nowhere above it.
    pub(super) fn at(&self, sample: usize, ratio: f64) -> (f64, Laurent) {
        let of_point = |point: &WavePoint, end: &Actuator| {
            let polynomial = Functional::Power.polynomial(end, point, ratio);
            let power = polynomial.at(ratio);
            let factor = self.drawn.per_power(power);
            (power * factor + self.standby, polynomial * factor + Laurent::constant(self.standby))
        };
        self.largest(sample, of_point).unwrap_or_default()
    }

    /// The same where what it gives back is not counted on.
    pub(super) fn taken(&self, sample: usize, ratio: f64) -> (f64, Laurent) {
        let (power, polynomial) = self.at(sample, ratio);
        if power > 0.0 { (power, polynomial) } else { (0.0, Laurent::default()) }
    }

    /// Power that its drive asks for at a sample beyond what there is \[W\], as if it were alone, and the polynomial that touches it at
    /// this ratio and is nowhere above it; nothing where the supply is stiff.
    pub(super) fn beyond(&self, sample: usize, ratio: f64) -> Option<(f64, Laurent)> {
        let (supply, shared) = self.supply?;
        let of_point =
            |point: &WavePoint, end: &Actuator| supply.beyond(end, (point.flow, &point.features), ratio, shared);
        self.largest(sample, of_point)
    }

    /// What reaches the bus of power that comes back at the terminals, and what is drawn for power that goes there.
    fn reaching(&self, back: f64) -> f64 {
        let through = if back > 0.0 { back * self.drive_efficiency } else { back / self.drive_efficiency };
        through - self.standby
    }

    /// Power that comes back at the terminals at a sample at a ratio \[W\], and its polynomial, which is nowhere above it.
    fn back(&self, sample: usize, ratio: f64) -> (f64, Laurent) {
        let of_point = |point: &WavePoint, end: &Actuator| {
            let back = Functional::PowerBack.polynomial(end, point, ratio);
            (back.at(ratio), back)
        };
        self.largest(sample, of_point).unwrap_or_default()
    }

    /// A bound below it at ratios between two, or above it.
    fn back_between(&self, sample: usize, ratios: (f64, f64), above: bool) -> f64 {
        let (middle, sign) = ((ratios.0 * ratios.1).sqrt(), if above { -1.0 } else { 1.0 });
        let of_point = |point: &WavePoint, end: &Actuator| {
            let back = under(&(Functional::PowerBack.polynomial(end, point, middle) * sign), ratios, middle);
            let u = minimise(&back, ratios.0.powi(2), ratios.1.powi(2));
            (sign * (value(&back, u) - 1e-13 * value(&back.map(f64::abs), u)), ())
        };
        self.largest(sample, of_point).map_or(0.0, |(bound, ())| bound)
    }

    /// What reaches the bus at a sample at a ratio \[W\].
    pub(super) fn returned(&self, sample: usize, ratio: f64) -> f64 {
        self.reaching(self.back(sample, ratio).0)
    }

    /// Its derivative by the ratio \[W\], on the side on which power flows there.
    pub(super) fn returned_slope(&self, sample: usize, ratio: f64) -> f64 {
        let (here, back) = self.back(sample, ratio);
        back.slope(ratio) * if here > 0.0 { self.drive_efficiency } else { 1.0 / self.drive_efficiency }
    }

    /// The same as a polynomial that is nowhere above it at ratios between two; it touches it at the ratio where power flows one way at all
    /// of them.
    pub(super) fn returned_cut(&self, sample: usize, ratio: f64, ratios: (f64, f64)) -> Laurent {
        let (here, back) = self.back(sample, ratio);
        let ends = [false, true].map(|above| self.back_between(sample, ratios, above));
        // What the drive's efficiency makes of it is a concave function of it: its chord is below.
        let [low, high] = ends.map(|back| self.reaching(back));
        let factor = match (high - low) / (ends[1] - ends[0]) {
            slope if slope.is_finite() && ends[1] > ends[0] => slope,
            _ if here > 0.0 => self.drive_efficiency,
            _ => 1.0 / self.drive_efficiency,
        };
        back * factor + Laurent::constant(low - factor * ends[0])
    }

    /// What reaches the bus at a sample at least, at ratios between two \[W\].
    pub(super) fn least_returned(&self, sample: usize, ratios: (f64, f64)) -> f64 {
        self.reaching(self.back_between(sample, ratios, false))
    }

    /// What it draws and asks for at every sample; what it gives back only where that is asked.
    pub(super) fn draws(&self, ratio: f64, comes_back: bool) -> Draws {
        let mut power = vec![f64::NEG_INFINITY; self.samples];
        let mut back = vec![f64::NEG_INFINITY; if comes_back { self.samples } else { 0 }];
        let mut beyond = vec![(f64::NEG_INFINITY, 0.0); if self.supply.is_some() { self.samples } else { 0 }];
        for end in &self.ends {
            let here = self.waveform.at(end, ratio);
            for k in 0..self.waveform.len() {
                let (sample, [hot, cold]) = (self.waveform.origin(k), here.terminals(k));
                power[sample] = power[sample].max(hot.1 * self.drawn.per_power(hot.1) + self.standby);
                if comes_back {
                    back[sample] = back[sample].max(here.given_back(k));
                }
                let Some((supply, shared)) = &self.supply else { continue };
                for asks in [hot, cold].map(|terminals| supply.asks_beyond(terminals, *shared)) {
                    if asks.0 > beyond[sample].0 {
                        beyond[sample] = asks;
                    }
                }
            }
        }
        let returned = back.into_iter().map(|back| self.reaching(back)).collect();
        Draws { power, returned, beyond }
    }
}

/// The largest power over time of all joints together \[W\], from the power of each, and the instant of each
/// group that makes it.
pub(super) fn largest(schedule: &Schedule, courses: &[&[f64]]) -> (f64, Places) {
    let mut best = (f64::NEG_INFINITY, Places { scenario: 0, instants: Vec::new(), drive: None });
    for (scenario, of) in schedule.scenarios.iter().enumerate() {
        let (power, instants) = worst(of, |joint, sample| courses[joint][sample]);
        if power > best.0 {
            best = (power, Places { scenario, instants, drive: None });
        }
    }
    best
}

/// The most that all joints together give back to the bus at an instant \[W\], less what others draw then, and where; less than zero where
/// they always draw some.
pub(super) fn most_returned(schedule: &Schedule, all: &[Draws]) -> (f64, Places) {
    let courses: Vec<&[f64]> = all.iter().map(|draws| draws.returned.as_slice()).collect();
    largest(schedule, &courses)
}

/// A drive with what the others leave it.
struct Left<'s> {
    scenario: usize,
    group: usize,
    instant: usize,
    drive: &'s Drive,
    /// Instants of all groups.
    instants: &'s [usize],
    /// Power that all others take \[W\].
    others: f64,
}

/// Every drive at every instant, the other groups at their worst.
fn drives<'s>(schedule: &'s Schedule, courses: &'s [Draws], mut look: impl FnMut(Left)) {
    let taken = |joint: usize, sample: usize| courses[joint].taken(sample);
    for (scenario, of) in schedule.scenarios.iter().enumerate() {
        let (all, instants) = worst(of, taken);
        for (group, place) in instants.iter().enumerate() {
            let at_worst = sum(&of.groups[group].instants[*place], taken);
            for (instant, here) in of.groups[group].instants.iter().enumerate() {
                let together = all - at_worst + sum(here, taken);
                for drive in &here.drives {
                    let own: f64 = drive.samples.iter().map(|(k, share)| share * taken(drive.joint, *k)).sum();
                    let others = (together - own).max(0.0);
                    look(Left { scenario, group, instant, drive, instants: &instants, others });
                }
            }
        }
    }
}

/// The power by which the drive that is worst off asks for more than the others leave \[W\], and where; `None` where the supply is
/// stiff.
pub(super) fn worst_drive(schedule: &Schedule, courses: &[Draws]) -> Option<(f64, Places)> {
    let mut best: Option<(f64, Places)> = None;
    drives(schedule, courses, |Left { scenario, group, instant, drive, instants, others }| {
        let beyond = &courses[drive.joint].beyond;
        if beyond.is_empty() {
            return;
        }
        let own: f64 = drive.samples.iter().map(|(k, share)| share * beyond[*k].0).sum();
        if best.as_ref().is_none_or(|(most, _)| own + others > *most) {
            let mut instants = instants.to_vec();
            instants[group] = instant;
            best = Some((own + others, Places { scenario, instants, drive: Some(drive.clone()) }));
        }
    });
    best
}

/// What a supply of an open-circuit voltage \[V\] with a resistance that all share \[Ω\] makes of what all draw; `None` where it is stiff.
pub(super) fn sag(schedule: &Schedule, all: &[Draws], (open, shared): (f64, f64)) -> Option<Sag> {
    let mut least: Option<(f64, usize)> = None;
    drives(schedule, all, |Left { drive, others, .. }| {
        let beyond = &all[drive.joint].beyond;
        if beyond.is_empty() {
            return;
        }
        let short = |(k, share): &(usize, f64)| share * shared * (beyond[*k].0 + others) / beyond[*k].1;
        let left = -drive.samples.iter().map(short).sum::<f64>() / open;
        if least.is_none_or(|(most, _)| left < most) {
            least = Some((left, drive.joint));
        }
    });
    let of = |scenario| worst(scenario, |joint, sample| all[joint].taken(sample)).0;
    let taken = schedule.scenarios.iter().map(of).fold(0.0, f64::max);
    let root = open * open - 4.0 * shared * taken;
    // What is kept to the accuracy of the search is kept.
    let lowest = (root >= -1e-8 * open * open).then(|| 0.5 * (open + root.max(0.0).sqrt()));
    least.map(|(left, joint)| Sag { lowest, left, joint })
}

/// What all take together at an instant.
fn sum(instant: &Instant, power: impl Fn(usize, usize) -> f64) -> f64 {
    instant.parts.iter().map(|(j, k, w)| w * power(*j, *k)).sum()
}

/// The largest power over time in one scenario \[W\], and the instant of each group that makes it.
fn worst(scenario: &Scenario, power: impl Fn(usize, usize) -> f64) -> (f64, Vec<usize>) {
    let mut all = 0.0;
    let mut places = Vec::new();
    for group in &scenario.groups {
        let mut best = (f64::NEG_INFINITY, 0);
        for (i, instant) in group.instants.iter().enumerate() {
            let here = sum(instant, &power);
            if here > best.0 {
                best = (here, i);
            }
        }
        all += best.0;
        places.push(best.1);
    }
    (all, places)
}

/// The largest power of each load case \[W\] with its name; nothing where joints have no cases.
pub(super) fn by_case(schedule: &Schedule, courses: &[&[f64]]) -> Vec<(String, f64)> {
    let named = schedule.scenarios.iter().filter_map(|scenario| Some((scenario.name.clone()?, scenario)));
    named.map(|(name, scenario)| (name, worst(scenario, |joint, sample| courses[joint][sample]).0)).collect()
}
