//! In what order of time the heat of the samples comes: the motion, its rest, or a sequence of load cases.

use std::ops::Range;

use super::stretch::Piece;
use super::thermal_motion::{Course, Heat};
use crate::motion::{Case, Cases};
use crate::requirement::{self, Motion};

/// Samples that the repetitions of one step of a sequence take at most one by one: those at its beginning and at its end,
/// and some between. The others count with their mean heat.
const ONE_BY_ONE: f64 = 6000.0;

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
            return Some(HeatCourse::of_cases(motion, cases));
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

    fn of_cases(motion: &Motion, cases: &Cases) -> HeatCourse {
        let mean = |case: &Case| {
            let weights = &motion.weight[case.samples.clone()];
            let all: f64 = weights.iter().sum();
            let moving = if case.cycle() > 0.0 { case.lasts() / case.cycle() } else { 1.0 };
            let share = if all > 0.0 { moving / all } else { 0.0 };
            (case.samples.clone(), weights.iter().map(|w| w * share).collect())
        };
        let mut track = Track { motion, times: Vec::new(), entries: Vec::new(), at: 0.0 };
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
            play: Some(Play { entries: track.entries, means: cases.list.iter().map(mean).collect() }),
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

    /// From each entry to the next what the samples have, where both of them are of those that `count` (1, else 0), and
    /// nothing elsewhere; where a case has its mean, that of `means`.
    pub(super) fn pieces_where(&self, count: Vec<f64>, at_samples: Vec<f64>, means: Vec<f64>) -> Vec<Piece> {
        let is_mean = |k: usize| {
            self.play.as_ref().is_some_and(|play| play.entries.get(k).is_some_and(|e| matches!(e, Entry::Mean(_))))
        };
        let (counts, means) = (self.pieces(&self.spread(count)), self.pieces(&self.spread(means)));
        let all = self.pieces(&self.spread(at_samples)).into_iter().zip(counts).zip(means).enumerate();
        let kept = |(k, ((piece, counts), mean)): (usize, ((Piece, Piece), Piece))| match is_mean(k) {
            true => mean,
            false if counts.from == 1.0 && counts.to == 1.0 => piece,
            false => Piece { from: 0.0, to: 0.0, ..piece },
        };
        all.map(kept).collect()
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

    pub(super) fn heat<'h>(&'h self, heat: &'h [f64]) -> Heat<'h> {
        Heat { times: &self.times, period_or_duration: self.lasts, heat }
    }
}

/// A sequence as it is written down.
struct Track<'m> {
    motion: &'m Motion,
    times: Vec<f64>,
    entries: Vec<Entry>,
    /// Now \[s\].
    at: f64,
}

impl Track<'_> {
    fn push(&mut self, time: f64, entry: Entry) {
        self.times.push(time);
        self.entries.push(entry);
    }

    /// A case so many times.
    fn repeat(&mut self, case: &Case, number: usize, repetitions: f64) {
        let whole = (repetitions * (1.0 + 1e-12)).floor();
        let part = (repetitions - whole).max(0.0);
        let most = (ONE_BY_ONE / case.samples.len() as f64).floor().max(12.0);
        if whole <= most {
            (0..whole as usize).for_each(|_| self.once(case));
            self.mean(case, number, part);
            return;
        }
        // A third at either end, and a third between them at times that grow by the same factor.
        let ends = (most / 3.0).floor();
        let middle = whole - 2.0 * ends;
        (0..ends as usize).for_each(|_| self.once(case));
        let looks = ends.min(middle);
        let mut done = 0.0;
        for look in 1..=looks as usize {
            let until = (middle.powf(look as f64 / looks)).round().clamp(done + 1.0, middle);
            self.mean(case, number, until - done - 1.0 + if look == looks as usize { part } else { 0.0 });
            self.once(case);
            done = until;
        }
        self.mean(case, number, middle - done);
        (0..ends as usize).for_each(|_| self.once(case));
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
