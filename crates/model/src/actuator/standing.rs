//! Standstill of the rotor, by the electrical angle that it sweeps.
//!
//! While a rotor holds its place one phase of a brushless winding carries two thirds of the heat. The excess of that phase is a
//! share, the *degree*, of the excess at standstill:
//!
//! * A field that turns steadily at `ω_e` modulates the heat of a phase at `2 ω_e`, and a winding with the time constant τ passes
//!   `1/√(1 + (2 ω_e τ)²)` of that. Over a window of length τ, `ω_e τ` is the electrical angle swept.
//! * A motion that stays within an electrical angle Δθ for good has the degree `1 − (Δθ/1 rad)⁴`.
//! * So has a stay of at least 0.1 s between moves. It counts only if the motion leaves it: over three times the
//!   window the angle is more than nine times as large, which it is neither in a steady crawl (three times) nor at the turning point of
//!   an oscillation (at most nine times), or it is more than twice as large and every half of the window sweeps most of the angle,
//!   which it does neither in a crawl (half) nor at a turning point (a quarter).
//!
//! An operating point that is shorter counts as if it went on at its speed.
//!
//! Degrees below 1/16 count as zero; the others are stretched over the rest, so that the degree stays continuous, and rounded up to
//! 1/64. Turning points of an oscillation count as motion: they heat some phases more than others too, by 5 to 50 % of the excess at
//! standstill in walking, which no limit counts.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::load::Load;
use crate::requirement::{Course, Motion};

/// Degrees are multiples of one over this.
pub(super) const GRADES: f64 = 64.0;
/// Smaller degrees count as zero.
const LEAST: f64 = 1.0 / 16.0;
/// Shortest window \[s\]; the others are longer by factors of √2.
const SHORTEST: f64 = 0.1;
/// Blocks that make up a window.
const BLOCKS: f64 = 8.0;
/// Angle over three windows relative to the angle over one, from which a window is a stay; from twice that it is one entirely.
const LEAVES: f64 = 9.0;
/// Angle over half of a window relative to the angle over all of it, from which a window is a shake, and from which it is one entirely: in a
/// crawl it is a half, about a turning point less, for the half that has it least.
const SHAKES: [f64; 2] = [0.6, 0.75];
/// Twice the electrical angle \[rad\] from which a window is no stay.
const WIDEST: f64 = 2.0;

/// One course of a motion: positions in time, or operating points.
#[derive(Debug, Clone)]
struct Run {
    /// Sample range within the motion.
    samples: Range<usize>,
    course: Course,
    /// Time of each sample from the first \[s\]; duration of each operating point, infinite where it is not known.
    time: Vec<f64>,
    /// Position \[rad\] of each sample from the first, and that at the end of a period; speed \[rad/s\] of operating points.
    position: Vec<f64>,
    /// Position \[rad\] at which each interval turns round; that at its start where it does not.
    turns: Vec<f64>,
    /// True for each interval at rest: the speed is zero at both ends.
    rests: Vec<bool>,
}

/// A window of a run.
struct Window {
    /// Number of its length; `None` of a whole run.
    step: Option<usize>,
    /// Length \[s\].
    lasts: f64,
    /// The angle within it, at the output \[rad\].
    angle: f64,
    /// The share to which the motion leaves the angle before and after it.
    leaves: f64,
    /// Intervals of the run, repeated end to end.
    intervals: Range<usize>,
}

/// Intervals that follow one another.
#[derive(Debug, Clone, Copy)]
struct Block {
    /// The first of them.
    first: usize,
    /// Start time \[s\].
    begin: f64,
    /// The least and the largest position \[rad\].
    low: f64,
    high: f64,
}

impl Block {
    /// Blocks that begin at least so long after one another \[s\].
    fn merged(blocks: &[Block], apart: f64) -> Vec<Block> {
        let mut all: Vec<Block> = Vec::new();
        for block in blocks {
            match all.last_mut().filter(|last| block.begin - last.begin < apart * (1.0 - 1e-9)) {
                Some(last) => (last.low, last.high) = (last.low.min(block.low), last.high.max(block.high)),
                None => all.push(*block),
            }
        }
        all
    }
}

/// The largest `κ = 2 p N` at which some window of one length counts.
#[derive(Debug, Clone, Copy, Default)]
struct Threshold {
    /// Threshold for a stay.
    stay: f64,
    /// Threshold for a crawl, times the winding's time constant \[s\]; for a whole run, without it.
    crawl: f64,
}

/// The angles that a motion sweeps, over windows of every length.
#[derive(Debug)]
pub(super) struct Sweep {
    runs: Vec<(Run, OnceLock<Vec<Threshold>>)>,
    samples: usize,
}

/// Length \[s\] of the windows of a step.
fn length(step: usize) -> f64 {
    SHORTEST * 2.0_f64.powf(0.5 * step as f64)
}

/// Degree of a steady crawl with `2 ω_e τ`.
fn crawl(turned: f64) -> f64 {
    1.0 / turned.hypot(1.0)
}

/// Degree of a stay with twice its electrical angle.
fn stay(angle: f64) -> f64 {
    (1.0 - (angle / WIDEST).powi(4)).max(0.0)
}

/// The largest argument at which [`crawl`] is not negligible.
fn most_crawl() -> f64 {
    (1.0 / (LEAST * LEAST) - 1.0).sqrt()
}

/// The largest argument at which [`stay`], of which a share counts, is not negligible.
fn most_stay(share: f64) -> f64 {
    WIDEST * (1.0 - LEAST / share).max(0.0).powf(0.25)
}

impl Run {
    fn new(motion: &Motion, samples: Range<usize>, course: Course) -> Run {
        let velocity = &motion.velocity[samples.clone()];
        let n = velocity.len();
        let own = &motion.time[samples.clone()];
        let ordered = own.windows(2).all(|pair| pair[1] >= pair[0]);
        let lasts = match course {
            Course::Periodic(period) if ordered => period,
            Course::Once(_) if ordered && n > 1 => own[n - 1] - own[0],
            _ => {
                let whole: f64 = motion.weight[samples.clone()].iter().sum();
                let duration = match course {
                    Course::Points(duration) => duration,
                    _ => None,
                };
                let time = |weight: &f64| duration.map_or(f64::INFINITY, |d| d * weight / whole);
                return Run {
                    time: motion.weight[samples.clone()].iter().map(time).collect(),
                    position: velocity.to_vec(),
                    turns: Vec::new(),
                    rests: Vec::new(),
                    course: Course::Points(duration),
                    samples,
                };
            }
        };
        let acceleration = &motion.acceleration[samples.clone()];
        let mut time: Vec<f64> = own.iter().map(|t| t - own[0]).collect();
        let count = if matches!(course, Course::Periodic(_)) { n } else { n - 1 };
        if count == n {
            time.push(lasts.max(time[n - 1]));
        }
        let (mut position, mut turns, mut rests) = (vec![0.0], Vec::with_capacity(count), Vec::with_capacity(count));
        for i in 0..count {
            let (next, h) = ((i + 1) % n, time[i + 1] - time[i]);
            let way = 0.5 * h * (velocity[i] + velocity[next]) + h * h / 12.0 * (acceleration[i] - acceleration[next]);
            // As if the acceleration were constant between them.
            let goes_back = velocity[i] * velocity[next] < 0.0;
            let until = if goes_back { 0.5 * h * velocity[i].powi(2) / (velocity[i] - velocity[next]) } else { 0.0 };
            turns.push(position[i] + until);
            position.push(position[i] + way);
            rests.push(velocity[i] == 0.0 && velocity[next] == 0.0);
        }
        Run { samples, course, time, position, turns, rests }
    }

    fn is_of_points(&self) -> bool {
        matches!(self.course, Course::Points(_))
    }

    /// Number of intervals.
    fn count(&self) -> usize {
        self.rests.len()
    }

    /// How long it lasts \[s\].
    fn lasts(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    /// The longest windows that are no longer than a time \[s\]: their number.
    fn step_within(time: f64) -> Option<usize> {
        let steps = 2.0 * (time / SHORTEST).log2() + 1e-9;
        (steps >= 0.0).then_some(steps as usize)
    }

    /// Calls `look` with the windows of the lengths that are `wanted`, by their number, `None` for the whole run.
    fn windows(&self, wanted: impl Fn(Option<usize>) -> bool, mut look: impl FnMut(Window)) {
        let (count, lasts) = (self.count(), self.lasts());
        if count == 0 || lasts <= 0.0 {
            return;
        }
        if wanted(None) && self.rests.iter().any(|rests| !rests) {
            let ends = |(a, b): (f64, f64), q: &f64| (a.min(*q), b.max(*q));
            let (low, high) = self.position.iter().chain(&self.turns).fold((0.0, 0.0), ends);
            look(Window { step: None, lasts, angle: high - low, leaves: 1.0, intervals: 0..count });
        }
        // A periodic motion is laid end to end three times, so that the windows that begin in the middle have neighbours.
        let copies = if matches!(self.course, Course::Periodic(_)) { 3 } else { 1 };
        let first = if copies == 3 { lasts } else { 0.0 };
        let place = |i: usize| {
            let (turn, at) = ((i / count) as f64, i % count);
            (self.time[at] + turn * lasts, self.position[at] + turn * self.position[count])
        };
        // How many intervals are at rest before each.
        let mut resting = vec![0; count * copies + 1];
        (0..count * copies).for_each(|i| resting[i + 1] = resting[i] + usize::from(self.rests[i % count]));
        let any_rests = resting[count] > 0;
        let interval = |i: usize| {
            let ((begin, from), (_, to)) = (place(i), place(i + 1));
            let turns = self.turns[i % count] - self.position[i % count] + from;
            Block { first: i, begin, low: from.min(to).min(turns), high: from.max(to).max(turns) }
        };
        let mut fine: Vec<Block> = (0..count * copies).map(interval).collect();
        for step in (0..).take_while(|step| length(*step) < lasts) {
            let length = length(step);
            // Blocks for this length are short enough for all longer windows.
            fine = Block::merged(&fine, length / (4.0 * BLOCKS));
            if !wanted(Some(step)) {
                continue;
            }
            let blocks = Block::merged(&fine, length / BLOCKS);
            let mut begins: Vec<f64> = blocks.iter().map(|block| block.begin).collect();
            begins.push(lasts * copies as f64);
            let angle = |range: Range<usize>| {
                let wider = |(low, high): (f64, f64), block: &Block| (low.min(block.low), high.max(block.high));
                let (low, high) = blocks[range].iter().fold((f64::INFINITY, f64::NEG_INFINITY), wider);
                high - low
            };
            // Less rounding.
            let enough = length * (1.0 - 1e-9);
            let last = begins.partition_point(|t| lasts * copies as f64 - t >= enough).max(1) - 1;
            for start in 0..=last {
                let begin = begins[start];
                if begin < first * (1.0 - 1e-12) || begin >= (first + lasts) * (1.0 - 1e-12) {
                    continue;
                }
                // The last window of all goes to the end.
                let end = match start == last {
                    true => blocks.len(),
                    false => (start + 1).max(begins.partition_point(|t| t - begin < enough)),
                };
                let long = begins[end] - begin;
                let before = begins.partition_point(|t| begin - t > long * (1.0 + 1e-9)).min(start);
                let after = begins.partition_point(|t| t - begin < 2.0 * long * (1.0 - 1e-9)).clamp(end, blocks.len());
                let (own, around) = (angle(start..end), angle(before..after));
                let count_of = end - start;
                let halves = [0, count_of / 4, count_of / 2]
                    .map(|skip| start + skip..(start + skip + count_of.div_ceil(2)).min(end));
                let least = halves.into_iter().map(angle).fold(f64::INFINITY, f64::min);
                // With few blocks, half of them do not last half of the time.
                let least = if count_of >= 6 { least } else { 0.0 };
                let leaves = match own > 0.0 {
                    // Already in half of the time a shake sweeps most of its angle.
                    true => {
                        let shakes = (least / own - SHAKES[0]) / (SHAKES[1] - SHAKES[0]);
                        let away = around / own - 2.0;
                        (around / (LEAVES * own) - 1.0).max(shakes.min(away)).clamp(0.0, 1.0)
                    }
                    false => f64::from(around > 0.0),
                };
                let to = blocks.get(end).map_or(count * copies, |block| block.first);
                let mut intervals = blocks[start].first..to;
                // Beside a rest the motion begins or ends: only what moves between two rests stays with them.
                if any_rests && resting[intervals.start] < resting[intervals.end] {
                    while !self.rests[intervals.start % count] {
                        intervals.start += 1;
                    }
                    while !self.rests[(intervals.end - 1) % count] {
                        intervals.end -= 1;
                    }
                    if resting[intervals.end] - resting[intervals.start] == intervals.len() {
                        continue;
                    }
                }
                look(Window { step: Some(step), lasts: long, angle: own, leaves, intervals });
            }
        }
    }

    /// For the whole run and for each length of windows, the largest κ at which one counts.
    fn thresholds(&self) -> Vec<Threshold> {
        let mut all = vec![Threshold::default()];
        self.windows(
            |_| true,
            |window| {
                let place = window.step.map_or(0, |step| step + 1);
                if all.len() <= place {
                    all.resize(place + 1, Threshold::default());
                }
                let of = &mut all[place];
                // Nothing swept counts at every κ.
                let at = |most: f64| if window.angle > 0.0 { most / window.angle } else { f64::INFINITY };
                if window.leaves > LEAST {
                    of.stay = of.stay.max(at(most_stay(window.leaves)));
                }
                let scale = if window.step.is_some() { window.lasts } else { 1.0 };
                of.crawl = of.crawl.max(at(most_crawl() * scale));
            },
        );
        all
    }

    /// The κ above which nothing moves so slowly that it counts, of a winding with a time constant \[s\].
    fn counts_below(&self, thresholds: &[Threshold], tau: f64) -> f64 {
        if self.is_of_points() {
            let of_point = |(speed, lasts): (&f64, &f64)| match speed.abs() {
                0.0 => 0.0,
                speed if *lasts < SHORTEST => most_crawl() / (speed * tau),
                speed => (most_crawl() / (speed * lasts.min(tau))).max(most_stay(1.0) / (speed * lasts)),
            };
            return self.position.iter().zip(&self.time).map(of_point).fold(0.0, f64::max);
        }
        let [whole, windows @ ..] = thresholds else { return 0.0 };
        let stays = thresholds.iter().map(|of| of.stay).fold(0.0, f64::max);
        let crawls = match self.lasts() > tau {
            true => Run::step_within(tau).and_then(|step| windows.get(step)).map_or(0.0, |of| of.crawl / tau),
            false => whole.crawl,
        };
        stays.max(crawls)
    }

    /// Degree of every sample at a κ, of a winding with a time constant \[s\]; that of what is at rest is left out.
    fn degrees(&self, thresholds: &[Threshold], kappa: f64, tau: f64) -> Vec<f64> {
        if self.is_of_points() {
            let of_point = |(speed, lasts): (&f64, &f64)| {
                let turned = kappa * speed.abs();
                // As if it went on: where it goes next is not known.
                if *lasts < SHORTEST {
                    return crawl(turned * tau);
                }
                // Without a duration it goes on.
                let stays = if lasts.is_finite() { stay(turned * lasts) } else { 0.0 };
                stays.max(crawl(turned * lasts.min(tau)))
            };
            return self.position.iter().zip(&self.time).map(of_point).collect();
        }
        let (count, lasts) = (self.count(), self.lasts());
        let mut of_intervals = vec![0.0_f64; count];
        let within_tau = Run::step_within(tau);
        let is_periodic = matches!(self.course, Course::Periodic(_));
        let way = self.position.last().filter(|_| is_periodic).map_or(0.0, |q| q.abs());
        let wanted = |step: Option<usize>| {
            let crawls = if lasts > tau { step.is_some() && step == within_tau } else { step.is_none() };
            crawls || thresholds.get(step.map_or(0, |step| step + 1)).is_some_and(|of| kappa <= of.stay)
        };
        self.windows(wanted, |window| {
            let stays = window.leaves * stay(kappa * window.angle);
            let degree = match window.step {
                None if lasts > tau => stays,
                // Again and again, and a wheel goes on.
                None => stays.max(crawl(kappa * (window.angle + way * (tau / lasts - 1.0)))),
                Some(_) if window.step == within_tau && lasts > tau => {
                    stays.max(crawl(kappa * window.angle * tau / window.lasts))
                }
                Some(_) => stays,
            };
            // A wheel does not stay.
            let degree =
                if window.step.is_none() && way > 0.0 { degree.min(crawl(kappa * way * tau / lasts)) } else { degree };
            if degree > LEAST {
                window.intervals.for_each(|i| of_intervals[i % count] = of_intervals[i % count].max(degree));
            }
        });
        let of_sample = |k: usize| {
            let before = if k > 0 { Some(k - 1) } else { is_periodic.then(|| count - 1) };
            let beside = [before, (k < count).then_some(k)].into_iter().flatten().filter(|i| !self.rests[*i]);
            let (mut sum, mut length) = (0.0, 0.0);
            for i in beside {
                let own = self.time[i + 1] - self.time[i];
                (sum, length) = (sum + own * of_intervals[i], length + own);
            }
            if length > 0.0 { sum / length } else { 0.0 }
        };
        (0..self.samples.len()).map(of_sample).collect()
    }
}

impl Sweep {
    /// Build the sweep of a motion.
    pub(super) fn new(motion: &Motion) -> Sweep {
        let run = |(samples, course)| (Run::new(motion, samples, course), OnceLock::new());
        Sweep { runs: motion.courses().into_iter().map(run).collect(), samples: motion.len() }
    }

    /// The `κ = 2 p N` above which no sample that moves is at standstill to any degree, of a winding with a time constant \[s\];
    /// infinite where some are at every κ.
    pub(super) fn counts_below(&self, tau: f64) -> f64 {
        self.runs().map(|(run, thresholds)| run.counts_below(thresholds, tau)).fold(0.0, f64::max)
    }

    /// The runs with their thresholds, which are computed once.
    fn runs(&self) -> impl Iterator<Item = (&Run, &[Threshold])> {
        self.runs.iter().map(|(run, thresholds)| (run, &thresholds.get_or_init(|| run.thresholds())[..]))
    }

    /// Degree of standstill of every sample that moves, in 64ths, at a κ.
    pub(super) fn degrees(&self, kappa: f64, tau: f64) -> Vec<u8> {
        let mut all = vec![0; self.samples];
        for (run, thresholds) in self.runs() {
            for (degree, of) in all[run.samples.clone()].iter_mut().zip(run.degrees(thresholds, kappa, tau)) {
                // A value that exceeds a grade by rounding keeps that grade.
                *degree = ((of - LEAST) / (1.0 - LEAST) * GRADES - 1e-9).ceil().max(0.0) as u8;
            }
        }
        all
    }
}

/// Motions of more samples have one step to an octave, of κ and of the time constant: each step holds numbers of all samples.
const MANY: usize = 2000;

/// Time constant \[s\] for which the degrees of a motion of so many samples are computed.
fn rounded_time_constant(tau: f64, samples: usize) -> f64 {
    if samples > MANY { tau.log2().floor().exp2() } else { tau }
}

/// Number of the step of κ, for a motion of so many samples: four to an octave, or every fourth of them.
fn step_of(kappa: f64, samples: usize) -> i32 {
    let fine = (4.0 * kappa.log2() + 1e-9).floor() as i32;
    if samples > MANY { fine.div_euclid(4).saturating_mul(4) } else { fine }
}

/// The κ at which a step begins, and for which degrees are computed over all of it.
fn begin_of(step: i32) -> f64 {
    (f64::from(step) / 4.0).exp2()
}

/// Loads that differ in the degrees of standstill alone, made where they are asked for.
#[derive(Debug, Default)]
pub(super) struct Stood(OnceLock<Box<Node>>);

#[derive(Debug)]
struct Node {
    step: i32,
    tau: u64,
    degrees: Arc<[u8]>,
    /// `None` where no degree is above zero, or an earlier node has the same.
    load: Option<Load>,
    next: Stood,
}

/// A copy makes its own.
impl Clone for Stood {
    fn clone(&self) -> Stood {
        Stood::default()
    }
}

impl Stood {
    fn nodes(&self) -> impl Iterator<Item = &Node> {
        std::iter::successors(self.0.get(), |node| node.next.0.get()).map(|node| &**node)
    }

    /// The load at a step, from `make` where it is not there; `base` where nothing that moves stands.
    fn of<'l>(
        &'l self,
        base: &'l Load,
        (step, tau): (i32, f64),
        degrees: impl FnOnce() -> Vec<u8>,
        make: impl FnOnce(&[u8]) -> Load,
    ) -> &'l Load {
        let is_same = |node: &&Node| node.step == step && node.tau == tau.to_bits();
        let with = |degrees: &[u8]| {
            let alike = self.nodes().find(|node| *node.degrees == *degrees && node.load.is_some());
            alike.and_then(|node| node.load.as_ref()).unwrap_or(base)
        };
        if let Some(node) = self.nodes().find(is_same) {
            return node.load.as_ref().unwrap_or_else(|| with(&node.degrees));
        }
        let degrees: Arc<[u8]> = degrees().into();
        let is_new = degrees.iter().any(|d| *d > 0) && std::ptr::eq(with(&degrees), base);
        let load = is_new.then(|| make(&degrees));
        let mut node = Box::new(Node { step, tau: tau.to_bits(), degrees, load, next: Stood::default() });
        let mut at = self;
        // Another thread may add one meanwhile: then this comes after that.
        loop {
            match at.0.set(node) {
                Ok(()) => break,
                Err(mine) => node = mine,
            }
            at = match at.0.get() {
                Some(taken) => &taken.next,
                None => return base,
            };
        }
        let own = self.nodes().find(is_same).unwrap_or_else(|| unreachable!("it was added"));
        own.load.as_ref().unwrap_or_else(|| with(&own.degrees))
    }
}

impl Load {
    /// The load as the winding of a motor with the time constant `tau` \[s\] has it at `kappa = 2 p N`: samples at which the rotor
    /// moves so slowly that one phase is hotter than the others count as standstill to a degree. Within a quarter of an octave of
    /// κ, degrees are those of its lower end, where they are larger; an octave of κ and of `tau` for motions of many samples.
    pub fn standing(&self, kappa: f64, tau: f64) -> &Load {
        let Some(sweep) = self.sweep.as_deref() else { return self };
        let tau = rounded_time_constant(tau, sweep.samples);
        if kappa > sweep.counts_below(tau) {
            return self;
        }
        let step = step_of(kappa, sweep.samples);
        let degrees = || sweep.degrees(begin_of(step), tau);
        self.stood.of(self, (step, tau), degrees, |degrees| self.with_degrees(degrees, (begin_of(step), tau)))
    }

    /// This load with samples at standstill as in another load of the same motion.
    pub fn standing_as(&self, other: &Load) -> &Load {
        other.stands_at.map_or(self, |(kappa, tau)| self.standing(kappa, tau))
    }

    /// True if degrees of standstill of samples that move were counted.
    pub fn counts_slow_motion(&self) -> bool {
        self.stands_at.is_some()
    }

    /// The κ from `low` to `high` at which the degrees of standstill change, in rising order.
    pub(super) fn changes_between(&self, (low, high): (f64, f64), tau: f64) -> Vec<f64> {
        let Some(sweep) = self.sweep.as_deref() else { return Vec::new() };
        let tau = rounded_time_constant(tau, sweep.samples);
        let most = high.min(sweep.counts_below(tau));
        if low.is_nan() || low > most {
            return Vec::new();
        }
        let ends = (step_of(low.max(1e-9), 0) + 1..).map(begin_of).take_while(|kappa| *kappa <= most);
        let mut changes: Vec<f64> = ends.collect();
        // Beyond the last one no sample counts.
        changes.extend((most < high).then_some(most * (1.0 + 1e-12)));
        let mut before = self.standing(low, tau);
        changes.retain(|kappa| {
            let here = self.standing(*kappa, tau);
            let changes = !std::ptr::eq(before, here);
            before = here;
            changes
        });
        changes
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::requirement::{Point, Samples};

    /// Peaks of the excess of the worst phase and of the mean heat behind a lag of `tau`: by integration over the electrical angle,
    /// and by degrees of standstill. The heat of every sample is the square of `torque`.
    fn excess(motion: &Motion, kappa: f64, tau: f64) -> (f64, f64, f64) {
        let run = Run::new(motion, 0..motion.len(), motion.course);
        let (count, n) = (run.count(), motion.len());
        let degrees = Sweep::new(motion).degrees(kappa, tau);
        let degree = |k: usize| {
            let rest = if motion.weight[k] > 0.0 { motion.dwell[k] / motion.weight[k] } else { 0.0 };
            rest + (1.0 - rest) * f64::from(degrees[k]) / GRADES
        };
        let periodic = matches!(motion.course, Course::Periodic(_));
        // From cold, or until the state repeats.
        let rounds = if periodic { (12.0 * tau / run.lasts()).ceil() as usize + 2 } else { 1 };
        let (mut truth, mut told, mut mean) = ([0.0_f64; 2], 0.0_f64, 0.0_f64);
        let mut peaks = (0.0_f64, 0.0_f64, 0.0_f64);
        for round in 0..rounds {
            for i in 0..count {
                let (next, h) = ((i + 1) % n, run.time[i + 1] - run.time[i]);
                let way = run.position[i + 1] - run.position[i];
                let turned = kappa * (way.abs() + h * motion.velocity[i].abs().max(motion.velocity[next].abs()));
                let parts = (4.0 + 8.0 * turned).ceil();
                for part in 0..parts as usize {
                    let s = (part as f64 + 0.5) / parts;
                    let between = |a: f64, b: f64| a + s * (b - a);
                    let heat = between(motion.torque[i], motion.torque[next]).powi(2);
                    // Cubic through positions and speeds.
                    let (v0, v1) = (motion.velocity[i] * h, motion.velocity[next] * h);
                    let cubic = s * v0 + s * s * (3.0 * way - 2.0 * v0 - v1) + s * s * s * (v0 + v1 - 2.0 * way);
                    let turns = round as f64 * run.position[count];
                    let angle = kappa * (turns + run.position[i] + cubic);
                    let decay = (-h / parts / tau).exp();
                    let lag = |y: f64, x: f64| x + (y - x) * decay;
                    truth = [lag(truth[0], heat * angle.cos()), lag(truth[1], heat * angle.sin())];
                    told = lag(told, heat * between(degree(i), degree(next)));
                    mean = lag(mean, heat);
                    if round + 2 >= rounds {
                        let here = (truth[0].hypot(truth[1]), told, mean);
                        peaks = (peaks.0.max(here.0), peaks.1.max(here.1), peaks.2.max(here.2));
                    }
                }
            }
        }
        peaks
    }

    /// A motion of samples every `step` seconds with a torque of one, from its positions.
    fn motion(period: f64, count: usize, position: impl Fn(f64) -> f64, course: Course) -> Motion {
        let time: Vec<f64> = (0..count).map(|k| period * k as f64 / count as f64).collect();
        let position = time.iter().map(|t| position(*t)).collect();
        Motion::from_samples(
            Samples {
                torque: vec![1.0; count],
                time,
                position: Some(position),
                velocity: None,
                acceleration: None,
                torque_rate: None,
                jerk: None,
            },
            course,
        )
    }

    #[test]
    fn a_steady_crawl_has_the_degree_of_a_first_order_lag() {
        // 2 ω_e τ = κ v τ; whole turns of a joint, so that positions do not close.
        for (turned, lasts) in [(0.01, 100.0), (0.3, 100.0), (1.0, 100.0), (3.0, 1000.0), (8.0, 1000.0)] {
            let (kappa, tau) = (140.0, 20.0);
            let speed = turned / kappa / tau;
            let creep = motion(lasts, 400, |t| speed * t, Course::Once(lasts));
            let degrees = Sweep::new(&creep).degrees(kappa, tau);
            let expected = (1.0 / turned.hypot(1.0) - LEAST) / (1.0 - LEAST);
            for degree in &degrees {
                let degree = f64::from(*degree) / GRADES;
                assert!((degree - expected).abs() < 0.03, "{turned}: {degree}, not {expected}");
            }
        }
    }

    #[test]
    fn a_hold_with_noise_heats_the_worst_phase_as_an_integration_shows() {
        let mut generator = Pcg64::seed_from_u64(21);
        let mut apart = [0.0_f64; 2];
        for _ in 0..12 {
            // A hold of 30 to 80 % of the period between quick moves, with noise of up to 0.8 rad of twice the electrical angle.
            let (period, kappa) = (generator.random_range(2.0..60.0), generator.random_range(40.0..600.0));
            let tau = generator.random_range(3.0..60.0);
            let (hold, noise) = (period * generator.random_range(0.3..0.8), generator.random_range(0.0..0.4) / kappa);
            let waves: Vec<[f64; 2]> =
                (0..5).map(|_| [generator.random_range(3.0..30.0), generator.random_range(0.0..6.0)]).collect();
            let shake = |t: f64| waves.iter().map(|[w, x]| noise / 5.0 * (w * t / hold + x).sin()).sum::<f64>();
            let way = |t: f64| {
                let s = ((t - hold) / (period - hold)).clamp(0.0, 1.0);
                shake(t) + 0.5 * (2.0 - 2.0 * (std::f64::consts::TAU * s).cos()) * (1.0 - 0.3 * s)
            };
            let held = motion(period, 1500, way, Course::Periodic(period));
            let (truth, told, mean) = excess(&held, kappa, tau);
            apart = [apart[0].max((truth - told) / mean), apart[1].max((told - truth) / mean)];
        }
        // Parts of the moves into and out of the hold stay near it and heat the same phase.
        assert!(apart[0] < 0.12 && apart[1] < 0.08, "{apart:?}");
    }

    #[test]
    fn dwells_with_a_shake_of_a_tenth_of_the_way_between_them_heat_as_an_integration_shows() {
        // Two dwells a turn of twice the electrical angle apart, so that the same phase is hot in both.
        let (kappa, tau, period) = (140.0, 20.0, 4.1);
        for shake in [0.1, 0.4, 0.8] {
            let way = |t: f64| {
                let s = ((t - 2.0) / 0.05).clamp(0.0, 1.0) - ((t - 4.05) / 0.05).clamp(0.0, 1.0);
                let blend = s * s * (3.0 - 2.0 * s);
                (std::f64::consts::TAU * blend + 0.5 * shake * (std::f64::consts::TAU * 30.0 * t / period).sin())
                    / kappa
            };
            let held = motion(period, 1640, way, Course::Periodic(period));
            let (truth, told, mean) = excess(&held, kappa, tau);
            assert!((told - truth).abs() < 0.05 * mean, "{shake}: {} not {}", told / mean, truth / mean);
        }
    }

    #[test]
    fn turning_points_are_no_standstill_and_a_small_shake_is() {
        for (amplitude, stands) in [(0.5, false), (0.05, false), (1e-4, true)] {
            let swing = motion(1.0, 400, |t| amplitude * (std::f64::consts::TAU * t).sin(), Course::Periodic(1.0));
            let degrees = Sweep::new(&swing).degrees(280.0, 10.0);
            assert!(degrees.iter().all(|d| (*d > 60) == stands && (*d == 0) != stands), "{amplitude}: {degrees:?}");
        }
    }

    #[test]
    fn from_rest_to_motion_the_degree_falls_without_a_jump() {
        let mut before = GRADES;
        for k in 0..400 {
            let speed = 1e-9 * 1.06_f64.powi(k);
            let point = |duration| Point { torque: 1.0, velocity: speed, duration, ..Point::default() };
            let held = Sweep::new(&Motion::from_points(&[point(Some(3600.0))])).degrees(140.0, 20.0)[0];
            let untimed = Sweep::new(&Motion::from_points(&[point(None)])).degrees(140.0, 20.0)[0];
            assert_eq!(held, untimed, "at {speed} rad/s");
            let here = f64::from(held);
            assert!(here <= before && before - here <= 0.05 * GRADES, "at {speed} rad/s: {before} to {here}");
            before = here;
        }
        assert_eq!(before, 0.0);
    }

    /// Short operating points count by their speed: the degree falls from that at rest to zero.
    #[test]
    fn a_short_operating_point_counts_by_its_speed() {
        let degree = |speed: f64| {
            let point = Point { torque: 1.0, velocity: speed, duration: Some(0.09), ..Point::default() };
            let sweep = Sweep::new(&Motion::from_points(&[point]));
            let degree = sweep.degrees(140.0, 20.0)[0];
            assert!(degree == 0 || sweep.counts_below(20.0) >= 140.0, "at {speed} rad/s");
            degree
        };
        assert_eq!([1e-9, 1e-6, 1.0].map(degree), [64, 64, 0]);
        assert!((1..64).contains(&degree(1e-3)));
    }

    #[test]
    fn no_degree_rises_with_the_ratio_and_none_is_left_beyond_the_threshold() {
        let mut generator = Pcg64::seed_from_u64(5);
        for _ in 0..40 {
            let (period, tau) = (generator.random_range(0.3..90.0), generator.random_range(2.0..60.0));
            let size = 10.0_f64.powf(generator.random_range(-4.0..0.0));
            let waves: Vec<[f64; 3]> = (1..6)
                .map(|k| [size * generator.random_range(0.0..1.0), f64::from(k), generator.random_range(0.0..6.0)])
                .collect();
            let flat = generator.random_range(0.0..1.5);
            let way = |t: f64| {
                let all: f64 =
                    waves.iter().map(|[a, w, x]| a * (w * std::f64::consts::TAU * t / period + x).sin()).sum();
                all.signum() * (all.abs() - flat * size).max(0.0)
            };
            let sweep = Sweep::new(&motion(period, 150, way, Course::Periodic(period)));
            let mut before = vec![u8::MAX; 150];
            for step in -8..60 {
                let kappa = begin_of(step);
                let here = sweep.degrees(kappa, tau);
                assert!(here.iter().zip(&before).all(|(here, before)| here <= before), "period {period}, κ {kappa}");
                let any = here.iter().any(|d| *d > 0);
                assert!(!any || kappa <= sweep.counts_below(tau), "κ {kappa} beyond {}", sweep.counts_below(tau));
                before = here;
            }
        }
    }
}
