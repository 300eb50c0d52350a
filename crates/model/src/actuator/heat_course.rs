//! In what order of time the heat of the samples comes: the motion, its rest, or a sequence of load cases.

use std::ops::Range;

use super::stretch::Piece;
use super::thermal_motion::{Course, Heat};
use crate::motion::{Case, Cases};
use crate::requirement::{self, Motion};

/// Samples that the repetitions of one step of a sequence take at most one by one: those at its beginning and at its end,
/// and some between. The others count with their mean heat.
const ONE_BY_ONE: f64 = 6000.0;

/// Looks at single repetitions between the first and the last of a step.
const LOOKS: f64 = 2.0;

/// How heat goes on in time.
#[derive(Debug, Clone)]
pub(super) struct HeatCourse {
    /// After the last entry.
    pub course: Course,
    /// Times of the entries \[s\].
    pub times: Vec<f64>,
    /// Period, or duration \[s\].
    pub lasts: f64,
    /// Whose heat each entry has; `None` where they are the samples in their order, and rest after them.
    play: Option<Play>,
}

/// Entries that are no samples in their order.
#[derive(Debug, Clone)]
struct Play {
    entries: Vec<Entry>,
    /// Entries after a mean, on the way to the temperatures of repetitions one by one: no peak counts there.
    settling: Vec<bool>,
    /// The samples of each case, and what each of them counts in the mean heat over a repetition with its rest.
    means: Vec<(Range<usize>, Vec<f64>)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Entry {
    Sample(usize),
    /// The mean over a case.
    Mean(usize),
    Rest,
}

impl HeatCourse {
    /// Of a motion; `None` for operating points, which have no order.
    pub(super) fn new(motion: &Motion) -> Option<HeatCourse> {
        if let Some(cases) = &motion.cases {
            return Some(HeatCourse::of_cases(motion, cases, ONE_BY_ONE));
        }
        let mut times = motion.time.clone();
        let (course, lasts) = match (motion.course, motion.repeat_every) {
            (requirement::Course::Periodic(period), _) => (Course::Periodic, period),
            (requirement::Course::Once(duration), None) => (Course::FromCold, duration),
            (requirement::Course::Once(duration), Some(every)) => {
                times.extend([times[0] + duration, times[0] + every.max(duration)]);
                (Course::Periodic, every.max(duration))
            }
            (requirement::Course::Points(_) | requirement::Course::Cases, _) => return None,
        };
        Some(HeatCourse { course, times, lasts, play: None })
    }

    fn of_cases(motion: &Motion, cases: &Cases, one_by_one: f64) -> HeatCourse {
        let mean = |case: &Case| {
            let weights = &motion.weight[case.samples.clone()];
            let all: f64 = weights.iter().sum();
            let share = if all > 0.0 { case.moving_share() / all } else { 0.0 };
            (case.samples.clone(), weights.iter().map(|w| w * share).collect())
        };
        let mut track = Track {
            motion,
            times: Vec::new(),
            entries: Vec::new(),
            settling: Vec::new(),
            settles: false,
            at: 0.0,
            one_by_one,
        };
        for step in &cases.sequence {
            track.repeat(&cases.list[step.case], step.case, step.repetitions);
        }
        let (every, lasts) = (motion.repeat_every, track.at);
        if let Some(every) = every.filter(|every| *every > lasts) {
            track.push(lasts, Entry::Rest);
            track.push(every, Entry::Rest);
        }
        HeatCourse {
            course: if cases.once && every.is_none() { Course::FromCold } else { Course::Periodic },
            times: track.times,
            lasts: every.map_or(lasts, |every| every.max(lasts)),
            play: Some(Play {
                entries: track.entries,
                settling: track.settling,
                means: cases.list.iter().map(mean).collect(),
            }),
        }
    }

    /// What the entries have, from what the samples have.
    pub(super) fn spread(&self, mut at_samples: Vec<f64>) -> Vec<f64> {
        let Some(play) = &self.play else {
            at_samples.resize(self.times.len(), 0.0);
            return at_samples;
        };
        let mean = |(samples, shares): &(Range<usize>, Vec<f64>)| -> f64 {
            at_samples[samples.clone()].iter().zip(shares).map(|(value, share)| share * value).sum()
        };
        let means: Vec<f64> = play.means.iter().map(mean).collect();
        let value = |entry: &Entry| match entry {
            Entry::Sample(k) => at_samples[*k],
            Entry::Mean(case) => means[*case],
            Entry::Rest => 0.0,
        };
        play.entries.iter().map(value).collect()
    }

    /// What each of `samples` samples has, from what the entries have: the sum over all times that it comes.
    pub(super) fn gather(&self, mut at_entries: Vec<f64>, samples: usize) -> Vec<f64> {
        let Some(play) = &self.play else {
            at_entries.truncate(samples);
            return at_entries;
        };
        let mut sums = vec![0.0; samples];
        for (entry, value) in play.entries.iter().zip(at_entries) {
            match entry {
                Entry::Sample(k) => sums[*k] += value,
                Entry::Mean(case) => {
                    let (of, shares) = &play.means[*case];
                    sums[of.clone()].iter_mut().zip(shares).for_each(|(sum, share)| *sum += share * value);
                }
                Entry::Rest => {}
            }
        }
        sums
    }

    /// From each entry to the next, with the value of every entry.
    pub(super) fn pieces(&self, values: &[f64]) -> Vec<Piece> {
        let (times, last) = (&self.times, self.times.len() - 1);
        let piece = |k: usize| match k < last {
            true => Piece { duration: times[k + 1] - times[k], from: values[k], to: values[k + 1] },
            false => {
                let next = if self.course == Course::Periodic { 0 } else { last };
                let duration = (self.lasts - (times[last] - times[0])).max(0.0);
                Piece { duration, from: values[last], to: values[next] }
            }
        };
        (0..=last).map(piece).collect()
    }

    /// The sample of an entry: that before a rest, and the first of a case where that has its mean heat.
    pub(super) fn sample(&self, entry: usize, samples: usize) -> usize {
        let Some(play) = &self.play else { return entry.min(samples - 1) };
        let of = |entry: &Entry| match entry {
            Entry::Sample(k) => Some(*k),
            Entry::Mean(case) => Some(play.means[*case].0.start),
            Entry::Rest => None,
        };
        play.entries[..=entry].iter().rev().find_map(of).unwrap_or(0)
    }

    /// The heat of its entries as a course in time, and that of the hottest phase where it is not the same.
    pub(super) fn heat<'h>(&'h self, heat: &'h [f64], phase: &'h [f64]) -> Heat<'h> {
        let settling = self.play.as_ref().map_or(&[][..], |play| &play.settling);
        Heat { times: &self.times, period_or_duration: self.lasts, heat, settling, phase }
    }
}

/// A sequence as it is written down.
struct Track<'m> {
    motion: &'m Motion,
    times: Vec<f64>,
    entries: Vec<Entry>,
    settling: Vec<bool>,
    /// Whether what comes now only finds its way from a mean.
    settles: bool,
    /// Now \[s\].
    at: f64,
    /// Samples of one step at most.
    one_by_one: f64,
}

impl Track<'_> {
    fn push(&mut self, time: f64, entry: Entry) {
        // Sums of durations may miss each other by rounding.
        let last = self.times.last().copied().unwrap_or(0.0);
        self.times.push(time.max(last));
        self.entries.push(entry);
        self.settling.push(self.settles);
    }

    /// A case so many times.
    fn repeat(&mut self, case: &Case, number: usize, repetitions: f64) {
        let whole = (repetitions * (1.0 + 1e-12)).floor();
        let part = (repetitions - whole).max(0.0);
        let most = (self.one_by_one / case.samples.len() as f64).floor().max(40.0);
        if whole <= most {
            (0..whole as usize).for_each(|_| self.once(case));
            self.mean(case, number, part);
            return;
        }
        // A quarter at the beginning, a quarter at the end behind a quarter in which the temperature settles, and
        // looks at one between them at times that grow by the same factor, each behind as many.
        let quarter = (most / 4.0).floor();
        let before = quarter - 1.0;
        let middle = whole - 3.0 * quarter;
        (0..quarter as usize).for_each(|_| self.once(case));
        let mut done = 0.0;
        for look in 1..LOOKS as usize + 1 {
            let until = middle.powf(look as f64 / (LOOKS + 1.0)).round().max(done + before + 2.0);
            if until >= middle {
                break;
            }
            self.mean(case, number, until - done - before - 1.0);
            self.settle(case, before);
            self.once(case);
            done = until;
        }
        self.mean(case, number, middle - done + part);
        self.settle(case, quarter);
        (0..quarter as usize).for_each(|_| self.once(case));
    }

    /// Repetitions in which the temperature finds its way from a mean.
    fn settle(&mut self, case: &Case, repetitions: f64) {
        self.settles = true;
        (0..repetitions as usize).for_each(|_| self.once(case));
        self.settles = false;
    }

    /// One repetition with its rest.
    fn once(&mut self, case: &Case) {
        let start = self.at;
        let (samples, time) = (case.samples.clone(), &self.motion.time);
        match case.course {
            requirement::Course::Points(total) => {
                let weights = &self.motion.weight[samples.clone()];
                let all: f64 = weights.iter().sum();
                let mut at = start;
                for (k, weight) in samples.zip(weights) {
                    self.push(at, Entry::Sample(k));
                    at += total.unwrap_or(0.0) * weight / all;
                    self.push(at, Entry::Sample(k));
                }
            }
            course => {
                let (first, last) = (samples.start, samples.end - 1);
                let begins = time[first];
                for k in samples {
                    self.push(start + self.motion.time[k] - begins, Entry::Sample(k));
                }
                let end = if matches!(course, requirement::Course::Periodic(_)) { first } else { last };
                self.push(start + case.lasts(), Entry::Sample(end));
            }
        }
        self.at = start + case.cycle();
        if case.cycle() > case.lasts() {
            self.push(start + case.lasts(), Entry::Rest);
            self.push(self.at, Entry::Rest);
        }
    }

    /// The mean heat for so many repetitions.
    fn mean(&mut self, case: &Case, number: usize, repetitions: f64) {
        if repetitions > 0.0 {
            self.push(self.at, Entry::Mean(number));
            self.at += repetitions * case.cycle();
            self.push(self.at, Entry::Mean(number));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator::thermal_motion::{Outcome, TwoNode};
    use crate::motion::{Lasting, Often, Point, Samples};

    const MOTOR: TwoNode = TwoNode {
        resistance_winding_housing: 0.9,
        resistance_housing_ambient: 1.4,
        time_constant_winding: 12.0,
        time_constant_housing: 700.0,
        ambient: 298.15,
        reference: 298.15,
        phases: true,
    };

    fn cases(period: f64, steps: Vec<(usize, Lasting)>) -> Motion {
        let time: Vec<f64> = (0..40).map(|k| period * f64::from(k) / 40.0).collect();
        let at = |t: &f64| (std::f64::consts::TAU * t / period).sin();
        let torque: Vec<f64> = time.iter().map(at).collect();
        let trot = Samples { time, position: Some(torque.clone()), torque, ..Samples::default() };
        let trot = Motion::from_samples(trot, requirement::Course::Periodic(period));
        let point = |torque, duration| Point { torque, duration: Some(duration), ..Point::default() };
        let jump = Motion::from_points(&[point(3.0, 0.1), point(0.0, 0.5), point(2.5, 0.2)]);
        let rest = Motion::from_points(&[point(0.0, 1.0)]);
        let list = [("trot", trot), ("jump", jump), ("rest", rest)];
        let list = list.into_iter().map(|(name, motion)| (name.to_string(), motion)).collect();
        Motion::from_cases(list, Often::Order(steps), false)
    }

    /// Heat of 10 W at a torque of 1 N·m.
    fn peak(motion: &Motion, one_by_one: f64) -> f64 {
        let course = HeatCourse::of_cases(motion, motion.cases.as_ref().unwrap(), one_by_one);
        let heat = course.spread(motion.torque.iter().map(|t| 10.0 * t * t).collect());
        match MOTOR.periodic_state(&course.heat(&heat, &[])) {
            Outcome::Settles(temperature) => temperature.peak - MOTOR.ambient,
            Outcome::Runaway => f64::INFINITY,
        }
    }

    #[test]
    fn many_repetitions_are_as_if_each_were_followed() {
        use Lasting::{Count, Duration};
        let orders = [
            (0.5, vec![(0, Duration(300.0)), (1, Count(20.0)), (2, Duration(60.0))]),
            (3.0, vec![(2, Duration(900.0)), (0, Duration(1500.0)), (1, Count(4.0))]),
            // A hot start: the winding cools, the housing warms.
            (1.0, vec![(1, Count(60.0)), (0, Duration(800.0)), (2, Duration(30.0))]),
            (0.2, vec![(0, Duration(40.0)), (1, Count(1.0)), (2, Duration(400.3))]),
        ];
        for (period, steps) in orders {
            let motion = cases(period, steps);
            let (short, full) = (peak(&motion, ONE_BY_ONE), peak(&motion, 1e9));
            assert!((short / full - 1.0).abs() < 2e-4, "{short} {full}");
        }
    }

    #[test]
    fn a_cycle_as_long_as_the_winding_remembers_is_followed_too() {
        // A burst of heat and rest, again and again: the mean is far from what the winding has at the start of each.
        for (winding, rest) in [(3.16, 4.0), (12.0, 4.0), (5.1, 1.5), (30.0, 9.0)] {
            let node = TwoNode {
                resistance_winding_housing: 3.0,
                resistance_housing_ambient: 0.3,
                time_constant_winding: winding,
                time_constant_housing: 1767.0,
                ..MOTOR
            };
            let point = |torque, duration| Point { torque, duration: Some(duration), ..Point::default() };
            let rests = [point(0.0, 0.1), point(3.0, 0.6), point(0.0, 0.1 + rest)];
            let single = [("burst".to_string(), Motion::from_points(&rests))];
            let count = |n: f64| Motion::from_cases(single.to_vec(), Often::Order(vec![(0, Lasting::Count(n))]), false);
            let peak = |motion: &Motion, one_by_one: f64| {
                let course = HeatCourse::of_cases(motion, motion.cases.as_ref().unwrap(), one_by_one);
                let heat = course.spread(motion.torque.iter().map(|t| t * t).collect());
                match node.periodic_state(&course.heat(&heat, &[])) {
                    Outcome::Settles(temperature) => temperature.peak - node.ambient,
                    Outcome::Runaway => f64::INFINITY,
                }
            };
            let once = peak(&count(1.0), 1e9);
            // As a motion of many samples: 40 repetitions one by one.
            let many = peak(&count(3000.0), 0.0);
            println!("{winding} {rest}: {once} {many}");
            // From above, by what is left of the mean after forty repetitions.
            assert!(many > once * (1.0 - 2e-3) && many < once * (1.0 + 2e-2), "{winding} {rest}: {once} {many}");
        }
    }

    #[test]
    fn what_is_gathered_is_the_gradient_of_what_is_spread() {
        let motion =
            cases(0.5, vec![(0, Lasting::Duration(300.0)), (1, Lasting::Count(2.0)), (2, Lasting::Count(1.0))]);
        let course = HeatCourse::new(&motion).unwrap();
        let samples = motion.len();
        let weights: Vec<f64> = (0..course.times.len()).map(|k| 1.0 + (k % 7) as f64).collect();
        let sum = |at: &[f64]| course.spread(at.to_vec()).iter().zip(&weights).map(|(a, w)| a * w).sum::<f64>();
        let gathered = course.gather(weights.clone(), samples);
        for k in [0, 5, samples - 4, samples - 3, samples - 1] {
            let mut unit = vec![0.0; samples];
            unit[k] = 1.0;
            assert!((sum(&unit) - gathered[k]).abs() < 1e-9 * (1.0 + gathered[k]), "{k}");
        }
    }

    #[test]
    fn the_sequence_has_the_mean_heat_of_the_shares() {
        let motion =
            cases(0.5, vec![(0, Lasting::Duration(100.0)), (1, Lasting::Count(5.0)), (2, Lasting::Count(10.0))]);
        for one_by_one in [ONE_BY_ONE, 1e9] {
            let course = HeatCourse::of_cases(&motion, motion.cases.as_ref().unwrap(), one_by_one);
            let heat = course.spread(motion.torque.iter().map(|t| t * t).collect());
            let pieces = course.pieces(&heat);
            let all: f64 = pieces.iter().map(|p| 0.5 * p.duration * (p.from + p.to)).sum();
            let mean = motion.mean(|k| motion.torque[k].powi(2)) * motion.share_of_time();
            // Between two samples heat is a straight line here, and a parabola there.
            assert!((all / course.lasts / mean - 1.0).abs() < 2e-3, "{all} {mean}");
            assert!((pieces.iter().map(|p| p.duration).sum::<f64>() / course.lasts - 1.0).abs() < 1e-12);
        }
    }
}
