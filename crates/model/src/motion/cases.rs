//! Several load cases of a joint as one motion.
//!
//! The one idea: the samples of all cases stand in one list, each weighed by its case's share of the time. Whatever is kept at
//! every sample is then kept in every case, and every mean over time is a mean over the cases. What neighbours in time
//! (heat over the day, changes of direction, power of several joints) asks for the cases one by one.

use std::ops::Range;
use std::sync::Arc;

use super::{Between, Course, Motion};

/// What a joint does in one of its load cases.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Name.
    pub name: String,
    /// Its samples.
    pub samples: Range<usize>,
    /// Which of the samples that are given (`Motion::given`) are its own.
    pub given: Range<usize>,
    /// Whether it repeats, happens once, or is operating points with their total duration.
    pub course: Course,
    /// After what time it is made again \[s\], where it happens once with rest after it.
    pub repeat_every: Option<f64>,
    /// Share of all time, the rest after it included; the shares of all cases sum to one.
    pub share: f64,
}

impl Case {
    /// How long it moves in one repetition \[s\].
    pub fn lasts(&self) -> f64 {
        match self.course {
            Course::Periodic(duration) | Course::Once(duration) => duration,
            Course::Points(duration) => duration.unwrap_or(0.0),
            Course::Cases => 0.0,
        }
    }

    /// How much of its time is motion, not rest.
    pub fn moving_share(&self) -> f64 {
        if self.cycle() > 0.0 { self.lasts() / self.cycle() } else { 1.0 }
    }

    /// One repetition with the rest after it \[s\].
    pub fn cycle(&self) -> f64 {
        self.repeat_every.map_or(self.lasts(), |every| every.max(self.lasts()))
    }
}

/// How often each case happens, as it is stated.
#[derive(Debug, Clone, PartialEq)]
pub enum Often {
    /// Shares of the time, one for each case; they sum to one.
    Shares(Vec<f64>),
    /// Repetitions in all, one number for each case.
    Cycles(Vec<f64>),
    /// A sequence that is made again and again.
    Order(Vec<(usize, Lasting)>),
}

/// How long a step of a sequence is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lasting {
    /// Seconds.
    Duration(f64),
    /// Repetitions.
    Count(f64),
}

/// A case that is repeated so many times before the next one comes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Which case.
    pub case: usize,
    /// How many times; a part of a repetition counts with its mean heat.
    pub repetitions: f64,
}

/// The load cases of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Cases {
    /// The cases, in the order in which they are written.
    pub list: Vec<Case>,
    /// How often each happens, as it is stated.
    pub often: Often,
    /// In what sequence heat is followed. Where no order is stated: the rarest case once, the others as often as their
    /// shares say, in the order in which they are written.
    pub sequence: Vec<Step>,
    /// Whether the sequence is made once, from cold.
    pub once: bool,
    /// Whether they are no load cases, one after another, but what two actuators of one joint design do at the same time.
    pub together: bool,
}

impl Cases {
    /// The case that a sample is of.
    pub fn of(&self, sample: usize) -> Option<&Case> {
        self.list.iter().find(|case| case.samples.contains(&sample))
    }

    /// Whether the sequence is what the requirement states, and not made from shares.
    pub fn is_ordered(&self) -> bool {
        matches!(self.often, Often::Order(_))
    }

    /// How long the sequence moves, and how long it is with the rest in it \[s\].
    pub fn sequence_lasts(&self) -> (f64, f64) {
        let of = |time: fn(&Case) -> f64| {
            self.sequence.iter().map(|step| step.repetitions * time(&self.list[step.case])).sum::<f64>()
        };
        (of(Case::lasts), of(Case::cycle))
    }

    /// How long all that is stated moves \[s\]; `None` where shares state no number of repetitions.
    pub(super) fn moves(&self) -> Option<f64> {
        if self.together {
            return Some(self.sequence_lasts().0);
        }
        match &self.often {
            Often::Shares(_) => None,
            Often::Cycles(cycles) => Some(cycles.iter().zip(&self.list).map(|(n, case)| n * case.lasts()).sum()),
            Often::Order(_) => Some(self.sequence_lasts().0),
        }
    }

    /// The share of all time that is motion.
    pub(super) fn moving(&self) -> f64 {
        self.list.iter().map(|case| case.share * case.moving_share()).sum()
    }

    /// In words, how often the cases happen in the sequence: `trot 17.6 times, jump once`.
    pub fn sequence_words(&self) -> String {
        let times = |step: &Step| {
            let name = &self.list[step.case].name;
            match step.repetitions {
                1.0 => format!("{name} once"),
                n => format!("{name} {} times", crate::words::number(n)),
            }
        };
        self.sequence.iter().map(times).collect::<Vec<_>>().join(", then ")
    }
}

/// Shares of the time, and the sequence, of what is stated.
fn plan(list: &[Case], often: &Often) -> (Vec<f64>, Vec<Step>) {
    let shares_of = |repetitions: &[f64]| -> Vec<f64> {
        let times: Vec<f64> = repetitions.iter().zip(list).map(|(n, case)| n * case.cycle()).collect();
        let all: f64 = times.iter().sum();
        times.into_iter().map(|time| time / all).collect()
    };
    let alternating = |repetitions: Vec<f64>| -> Vec<Step> {
        let rarest = repetitions.iter().copied().filter(|n| *n > 0.0).fold(f64::INFINITY, f64::min);
        let steps = repetitions.into_iter().enumerate().filter(|(_, n)| *n > 0.0);
        steps.map(|(case, n)| Step { case, repetitions: n / rarest }).collect()
    };
    match often {
        Often::Shares(shares) => {
            let repetitions = shares.iter().zip(list).map(|(share, case)| share / case.cycle()).collect();
            (shares.clone(), alternating(repetitions))
        }
        Often::Cycles(cycles) => (shares_of(cycles), alternating(cycles.clone())),
        Often::Order(steps) => {
            let step = |(case, lasting): &(usize, Lasting)| Step {
                case: *case,
                repetitions: match lasting {
                    Lasting::Duration(time) => time / list[*case].cycle(),
                    Lasting::Count(count) => *count,
                },
            };
            let sequence: Vec<Step> = steps.iter().map(step).collect();
            let mut repetitions = vec![0.0; list.len()];
            sequence.iter().for_each(|step| repetitions[step.case] += step.repetitions);
            (shares_of(&repetitions), sequence)
        }
    }
}

impl Motion {
    /// Several motions as one: the load cases of a joint, each with its name. `once`: the sequence is made once, from cold.
    ///
    /// # Panics
    /// Without a case, with a case that has no durations or has cases itself, or where `often` counts other cases than
    /// there are.
    pub fn from_cases(cases: Vec<(String, Motion)>, often: Often, once: bool) -> Motion {
        assert!(!cases.is_empty(), "there is at least one case");
        let mut list = Vec::new();
        let (mut first, mut first_given) = (0, 0);
        for (name, motion) in &cases {
            assert!(motion.has_durations() && motion.cases.is_none(), "a case has durations and no cases");
            list.push(Case {
                name: name.clone(),
                samples: first..first + motion.len(),
                given: first_given..first_given + motion.given.len(),
                course: motion.course,
                repeat_every: motion.repeat_every,
                share: 0.0,
            });
            first += motion.len();
            first_given += motion.given.len();
        }
        let (shares, sequence) = plan(&list, &often);
        assert_eq!(shares.len(), list.len(), "one share for each case");
        list.iter_mut().zip(shares).for_each(|(case, share)| case.share = share);
        let cases: (Vec<Case>, Vec<Motion>) = list.into_iter().zip(cases.into_iter().map(|(_, motion)| motion)).unzip();
        let (list, motions) = cases;
        let cases = Cases { list, often, sequence, once, together: false };
        let moving = cases.moving();
        let join = |of: &dyn Fn(&Motion) -> &Vec<f64>| motions.iter().flat_map(|m| of(m).iter().copied()).collect();
        let weighed = |of: &dyn Fn(&Motion) -> &Vec<f64>| {
            let parts = motions.iter().zip(&cases.list);
            parts
                .flat_map(|(m, case)| {
                    let share = case.share * case.moving_share() / moving;
                    of(m).iter().map(move |w| share * w).collect::<Vec<_>>()
                })
                .collect()
        };
        let position: Option<Vec<Vec<f64>>> = motions.iter().map(|m| m.position.clone()).collect();
        let mut derived: Vec<&'static str> = Vec::new();
        for name in motions.iter().flat_map(|m| &m.derived) {
            if !derived.contains(name) {
                derived.push(name);
            }
        }
        let given = motions.iter().zip(&cases.list);
        Motion {
            course: Course::Cases,
            time: join(&|m| &m.time),
            torque: join(&|m| &m.torque),
            velocity: join(&|m| &m.velocity),
            acceleration: join(&|m| &m.acceleration),
            torque_rate: join(&|m| &m.torque_rate),
            jerk: join(&|m| &m.jerk),
            weight: weighed(&|m| &m.weight),
            dwell: weighed(&|m| &m.dwell),
            position: position.map(|all| all.concat()),
            placed: motions.iter().all(|m| m.placed),
            derived,
            repeat_every: None,
            given: given.flat_map(|(m, case)| m.given.iter().map(|k| k + case.samples.start)).collect(),
            between: motions.iter().map(|m| m.between).fold(Between::Nothing, worse),
            held: motions.iter().map(|m| m.held).fold(0.0, f64::max),
            cases: Some(Arc::new(cases)),
            sprung: motions.iter().any(|m| m.sprung),
            looked: None,
            mixed: false,
        }
    }

    /// What two actuators of one design do at the same time \[rad, N·m\], as one motion: what is kept at every sample is kept by both,
    /// and means are those over both. Heat is that of each ([`Cases::together`]).
    ///
    /// # Panics
    /// As [`Motion::from_cases`].
    pub fn together(motions: [Motion; 2]) -> Motion {
        let once = matches!(motions[0].course, Course::Once(_)) && motions[0].repeat_every.is_none();
        let numbered = motions.into_iter().enumerate().map(|(k, motion)| (format!("actuator {}", k + 1), motion));
        let mut both = Motion::from_cases(numbered.collect(), Often::Shares(vec![0.5, 0.5]), once);
        if let Some(cases) = &mut both.cases {
            let cases = Arc::make_mut(cases);
            cases.together = true;
            cases.sequence = vec![Step { case: 0, repetitions: 1.0 }];
        }
        both
    }

    /// The motion of each of its actuators, where it is that of two.
    pub(crate) fn actuators(&self) -> Vec<Motion> {
        match &self.cases {
            Some(cases) if cases.together => cases.list.iter().map(|case| self.part(case)).collect(),
            _ => Vec::new(),
        }
    }

    /// The motions that it is made of, with which samples they are: its cases, or all of it.
    pub fn parts(&self) -> Vec<(Range<usize>, Motion)> {
        let Some(cases) = &self.cases else { return vec![(0..self.len(), self.clone())] };
        cases.list.iter().map(|case| (case.samples.clone(), self.part(case))).collect()
    }

    /// Largest load torque \[N·m\] and speed \[rad/s\] of one of its cases.
    pub fn peaks(&self, case: &Case) -> (f64, f64) {
        self.peaks_in(case.samples.clone())
    }

    /// Largest load torque \[N·m\] and speed \[rad/s\] of some of its samples.
    pub fn peaks_in(&self, samples: Range<usize>) -> (f64, f64) {
        let most = |of: &[f64]| of[samples.clone()].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        (most(&self.torque), most(&self.velocity))
    }

    /// One of its cases as a motion of its own.
    pub fn part(&self, case: &Case) -> Motion {
        let of = |values: &[f64]| values[case.samples.clone()].to_vec();
        // What a case weighs by itself; one that never happens has lost it.
        let own = |values: &[f64]| {
            let all: f64 = self.weight[case.samples.clone()].iter().sum();
            let share = if all > 0.0 { all.recip() } else { 0.0 };
            values[case.samples.clone()].iter().map(|w| w * share).collect()
        };
        Motion {
            course: case.course,
            time: of(&self.time),
            torque: of(&self.torque),
            velocity: of(&self.velocity),
            acceleration: of(&self.acceleration),
            torque_rate: of(&self.torque_rate),
            jerk: of(&self.jerk),
            weight: own(&self.weight),
            dwell: own(&self.dwell),
            position: self.position.as_deref().map(of),
            placed: self.placed,
            derived: self.derived.clone(),
            repeat_every: case.repeat_every,
            given: self.given[case.given.clone()].iter().map(|k| k - case.samples.start).collect(),
            between: self.between,
            held: self.held,
            cases: None,
            sprung: self.sprung,
            looked: None,
            mixed: false,
        }
    }

    /// The same for other motions in place of its cases, with what is stated of them.
    pub(super) fn recomposed(cases: &Cases, motions: Vec<Motion>) -> Motion {
        if let (true, Ok(both)) = (cases.together, <[Motion; 2]>::try_from(motions.clone())) {
            return Motion::together(both);
        }
        let names = cases.list.iter().map(|case| case.name.clone());
        Motion::from_cases(names.zip(motions).collect(), cases.often.clone(), cases.once)
    }
}

/// What is known of two motions between their samples, the worse of each kind.
fn worse(a: Between, b: Between) -> Between {
    match (a, b) {
        (Between::Nothing, other) | (other, Between::Nothing) => other,
        (Between::Given(x), Between::Given(y)) => Between::Given(x.max(y)),
        (Between::Given(x), Between::Spline(_)) | (Between::Spline(_), Between::Given(x)) => Between::Given(x),
        (Between::Spline(x), Between::Spline(y)) => Between::Spline(x.max(y)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Point, Samples};

    fn sine(period: f64, amplitude: f64, course: fn(f64) -> Course) -> Motion {
        let time: Vec<f64> = (0..40).map(|k| period * f64::from(k) / 40.0).collect();
        let at = |t: &f64| (std::f64::consts::TAU * t / period).sin();
        let torque = time.iter().map(|t| amplitude * at(t)).collect();
        let position = Some(time.iter().map(at).collect());
        let lasts = if let Course::Once(_) = course(period) { period * 39.0 / 40.0 } else { period };
        Motion::from_samples(Samples { time, torque, position, ..Samples::default() }, course(lasts))
    }

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * (1.0 + b.abs()), "{a} {b}");
    }

    #[test]
    fn means_are_those_of_the_cases_by_their_shares() {
        let (trot, jump) = (sine(0.4, 10.0, Course::Periodic), sine(0.8, 60.0, Course::Once));
        let both = Motion::from_cases(
            vec![("trot".into(), trot.clone()), ("jump".into(), jump.clone())],
            Often::Shares(vec![0.75, 0.25]),
            false,
        );
        let square = |m: &Motion| m.mean(|k| m.torque[k].powi(2));
        near(square(&both), 0.75 * square(&trot) + 0.25 * square(&jump));
        near(both.weight.iter().sum(), 1.0);
        near(both.share_of_time(), 1.0);
        assert_eq!(both.duration(), None);
        assert_eq!(both.len(), trot.len() + jump.len());
        assert!(both.name_sample(trot.len()).starts_with("jump, t = 0 s"), "{}", both.name_sample(trot.len()));
        // What a joint is made of is what it was made from.
        let parts = both.parts();
        assert_eq!(parts[1].1.torque, jump.torque);
        assert_eq!(parts[1].1.given, jump.given);
        parts[1].1.weight.iter().zip(&jump.weight).for_each(|(a, b)| near(*a, *b));
    }

    #[test]
    fn rest_counts_as_time_and_not_as_motion() {
        let trot = sine(0.4, 10.0, Course::Periodic);
        let jump = Motion { repeat_every: Some(7.8), ..sine(0.8, 60.0, Course::Once) };
        let both = Motion::from_cases(
            vec![("trot".into(), trot.clone()), ("jump".into(), jump.clone())],
            Often::Shares(vec![0.5, 0.5]),
            false,
        );
        let square = |m: &Motion| m.mean(|k| m.torque[k].powi(2));
        // Heat over all time: by shares, and of the jump's half a tenth is motion.
        let all = 0.5 * square(&trot) + 0.5 * 0.1 * square(&jump);
        near(square(&both) * both.share_of_time(), all);
        near(both.share_of_time(), 0.55);
    }

    #[test]
    fn one_case_is_the_motion_itself() {
        let trot = sine(0.4, 10.0, Course::Periodic);
        let one = Motion::from_cases(vec![("trot".into(), trot.clone())], Often::Shares(vec![1.0]), false);
        assert_eq!((&one.torque, &one.weight, &one.given), (&trot.torque, &trot.weight, &trot.given));
        assert_eq!(one.cases.as_ref().unwrap().sequence, [Step { case: 0, repetitions: 1.0 }]);
    }

    #[test]
    fn an_order_says_its_shares_and_its_cycle() {
        let (trot, jump) = (sine(0.4, 10.0, Course::Periodic), sine(0.8, 60.0, Course::Periodic));
        let order = Often::Order(vec![(0, Lasting::Duration(120.0)), (1, Lasting::Count(5.0))]);
        let both = Motion::from_cases(vec![("trot".into(), trot), ("jump".into(), jump)], order, false);
        near(both.duration().unwrap(), 124.0);
        let cases = both.cases.as_ref().unwrap();
        near(cases.list[0].share, 120.0 / 124.0);
        near(cases.sequence[0].repetitions, 300.0);
        // Twice as fast: 120 s hold twice as many, five jumps take half the time.
        let fast = both.scaled(1.0, 2.0);
        near(fast.cases.as_ref().unwrap().sequence[0].repetitions, 600.0);
        near(fast.duration().unwrap(), 122.0);
    }

    #[test]
    fn a_case_that_takes_no_time_has_no_weight() {
        let (trot, fall) = (sine(0.4, 10.0, Course::Periodic), sine(0.8, 60.0, Course::Once));
        let both = Motion::from_cases(
            vec![("trot".into(), trot.clone()), ("fall".into(), fall)],
            Often::Shares(vec![1.0, 0.0]),
            false,
        );
        let square = |m: &Motion| m.mean(|k| m.torque[k].powi(2));
        near(square(&both), square(&trot));
        assert_eq!(both.cases.as_ref().unwrap().sequence.len(), 1);
    }

    #[test]
    fn points_are_a_case_too() {
        let hold = Motion::from_points(&[
            Point { torque: 5.0, duration: Some(2.0), ..Point::default() },
            Point { torque: 1.0, velocity: 3.0, duration: Some(6.0), ..Point::default() },
        ]);
        let both = Motion::from_cases(
            vec![("hold".into(), hold), ("trot".into(), sine(0.4, 10.0, Course::Periodic))],
            Often::Cycles(vec![1.0, 5.0]),
            false,
        );
        near(both.duration().unwrap(), 10.0);
        near(both.dwell.iter().sum(), 0.2);
        assert_eq!(both.name_sample(1), "hold, point 2");
        assert_eq!(both.position, None);
    }
}
