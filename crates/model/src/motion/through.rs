//! Motions behind something that changes their angles and torques instant by instant.
//!
//! The one idea: where the motions are their splines, the instants that they take are chosen anew: cut where a torque or a speed behind
//! changes its sign too, and divided until what is behind is a straight line from instant to instant.

use super::instants::{self, Between, Instant, Interval, Largest, Piece};
use super::{Course, Motion};

/// Looks for changes of sign within a piece.
const LOOKS: usize = 8;

/// What is made of the instants of one motion, or of several of one time base.
type Change<'c, const N: usize> = &'c dyn Fn(&[Instant; N]) -> [Instant; N];

/// Whether what is behind a motion has instants of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum At {
    /// Those that it takes.
    NewInstants,
    /// Those that the motion has.
    ItsInstants,
}

/// The motions that `change` makes of every instant, and those before at the same instants. A motion by itself may have cases.
///
/// # Panics
/// Several motions that have not the same course and times, or have cases.
pub(crate) fn through<const N: usize>(motions: [&Motion; N], at: At, change: Change<N>) -> ([Motion; N], [Motion; N]) {
    if let Some(cases) = &motions[0].cases {
        assert_eq!(N, 1, "several motions have no cases");
        let parts: Vec<_> = motions[0].parts().into_iter().map(|(_, part)| through([&part; N], at, change)).collect();
        let every = motions[0].repeat_every;
        let (behind, before): (Vec<[Motion; N]>, Vec<[Motion; N]>) = parts.into_iter().unzip();
        let again = |all: Vec<[Motion; N]>| {
            let motions = all.into_iter().flat_map(|one| one.into_iter().next()).collect();
            let again = Motion { repeat_every: every, ..Motion::recomposed(cases, motions) };
            std::array::from_fn(|_| again.clone())
        };
        return (again(behind), again(before));
    }
    let is_spline = |m: &&Motion| matches!(m.between, Between::Spline(_)) && !matches!(m.course, Course::Points(_));
    let before: [Motion; N] = match motions.iter().all(is_spline) {
        _ if at == At::ItsInstants => motions.map(Motion::clone),
        true => resolved(motions.map(Motion::at_given), change),
        false if N == 1 => motions.map(Motion::clone),
        false => motions.map(Motion::at_given),
    };
    let mut behind = before.clone();
    for k in 0..before[0].len() {
        let changed = change(&before.each_ref().map(|motion| motion.instant(k)));
        behind.iter_mut().zip(changed).for_each(|(motion, instant)| motion.put(k, &instant));
    }
    let dwell: Vec<f64> =
        (0..before[0].len()).map(|k| before.iter().map(|m| m.dwell[k]).fold(f64::INFINITY, f64::min)).collect();
    for motion in &mut behind {
        motion.dwell.clone_from(&dwell);
        if matches!(motion.between, Between::Given(_))
            || !motions.iter().all(is_spline) && N > 1 && at == At::NewInstants
        {
            motion.between = match motion.course {
                Course::Points(_) => Between::Nothing,
                _ => Between::Given(instants::likely(motion)),
            };
        }
    }
    (behind, before)
}

impl Motion {
    /// Sample k as an instant.
    pub(crate) fn instant(&self, k: usize) -> Instant {
        Instant {
            torque: self.torque[k],
            torque_rate: self.torque_rate[k],
            velocity: self.velocity[k],
            acceleration: self.acceleration[k],
            jerk: self.jerk[k],
            position: self.position.as_ref().map(|q| q[k]),
        }
    }

    fn put(&mut self, k: usize, instant: &Instant) {
        self.torque[k] = instant.torque;
        self.torque_rate[k] = instant.torque_rate;
        self.velocity[k] = instant.velocity;
        self.acceleration[k] = instant.acceleration;
        self.jerk[k] = instant.jerk;
        if let (Some(all), Some(q)) = (&mut self.position, instant.position) {
            all[k] = q;
        }
    }

    /// The given samples alone.
    pub(crate) fn at_given(&self) -> Motion {
        let of = |values: &[f64]| self.given.iter().map(|k| values[*k]).collect::<Vec<f64>>();
        let (time, velocity) = (of(&self.time), of(&self.velocity));
        let (weight, dwell) = match self.course {
            Course::Points(_) | Course::Cases => (of(&self.weight), of(&self.dwell)),
            Course::Periodic(_) | Course::Once(_) => super::time_weights(&time, &velocity, self.course),
        };
        Motion {
            torque: of(&self.torque),
            acceleration: of(&self.acceleration),
            torque_rate: of(&self.torque_rate),
            jerk: of(&self.jerk),
            position: self.position.as_deref().map(of),
            given: (0..self.given.len()).collect(),
            time,
            velocity,
            weight,
            dwell,
            ..self.clone()
        }
    }
}

/// Motions of given samples with the instants that what is behind them takes.
fn resolved<const N: usize>(motions: [Motion; N], change: Change<N>) -> [Motion; N] {
    let largest = motions.each_ref().map(Largest::new);
    let mut behind = motions.clone();
    for k in 0..motions[0].len() {
        let changed = change(&motions.each_ref().map(|motion| motion.instant(k)));
        behind.iter_mut().zip(changed).for_each(|(motion, instant)| motion.put(k, &instant));
    }
    let largest_behind = behind.each_ref().map(Largest::new);
    let intervals = motions.each_ref().map(instants::intervals);
    let apart = instants::apart_of(&motions[0]);
    let mut pieces = Vec::with_capacity(intervals[0].len());
    for i in 0..intervals[0].len() {
        let here = intervals.each_ref().map(|all| &all[i]);
        let bend = here.iter().zip(&largest).map(|(interval, largest)| interval.bend(largest)).fold(0.0, f64::max);
        let mut cuts: Vec<f64> =
            here.iter().zip(&largest).flat_map(|(interval, largest)| interval.cuts(largest, apart)).collect();
        cuts.sort_by(f64::total_cmp);
        // Those of several motions may be nearly the same; both ends stay.
        let end = here[0].end();
        cuts.dedup_by(|b, a| *b - *a < 0.5 * apart && *b != end);
        if cuts.len() > 2 && end - cuts[cuts.len() - 2] < 0.5 * apart {
            cuts.remove(cuts.len() - 2);
        }
        let cuts = with_changes_of_sign(here, cuts, apart, change);
        for w in cuts.windows(2) {
            // Around a change of sign nothing is smooth, and nothing takes time.
            let missed =
                if w[1] - w[0] > 4.0 * apart { missed(here, [w[0], w[1]], &largest_behind, change) } else { 0.0 };
            // A straight line over a time w misses w²/8 of what bends by this.
            let behind = 8.0 * missed / (w[1] - w[0]).powi(2);
            pieces.push(Piece { interval: i, from: w[0], to: w[1], bend: bend.max(behind) });
        }
    }
    std::array::from_fn(|j| instants::resolve_pieces(&motions[j], &intervals[j], &pieces))
}

fn behind<const N: usize>(intervals: [&Interval; N], s: f64, change: Change<N>) -> [Instant; N] {
    change(&intervals.map(|interval| interval.at(s)))
}

/// The cuts of an interval, with both sides of the changes of sign of torques and speeds behind.
fn with_changes_of_sign<const N: usize>(
    intervals: [&Interval; N],
    cuts: Vec<f64>,
    apart: f64,
    change: Change<N>,
) -> Vec<f64> {
    let mut all = vec![cuts[0]];
    for w in cuts.windows(2) {
        if w[1] - w[0] > 4.0 * apart {
            let looks: Vec<(f64, [Instant; N])> = (0..=LOOKS)
                .map(|k| w[0] + (w[1] - w[0]) * k as f64 / LOOKS as f64)
                .map(|s| (s, behind(intervals, s, change)))
                .collect();
            let mut changes = Vec::new();
            for pair in looks.windows(2) {
                for j in 0..N {
                    for of in [|instant: &Instant| instant.torque, |instant: &Instant| instant.velocity] {
                        let first = of(&pair[0].1[j]);
                        if first * of(&pair[1].1[j]) >= 0.0 {
                            continue;
                        }
                        let (mut a, mut b) = (pair[0].0, pair[1].0);
                        while b - a > 0.25 * apart {
                            let middle = 0.5 * (a + b);
                            if of(&behind(intervals, middle, change)[j]) * first > 0.0 {
                                a = middle
                            } else {
                                b = middle
                            }
                        }
                        changes.extend([a - 0.5 * apart, b + 0.5 * apart]);
                    }
                }
            }
            changes.sort_by(f64::total_cmp);
            for side in changes {
                if side - all[all.len() - 1] >= 0.5 * apart && w[1] - side >= 0.5 * apart {
                    all.push(side);
                }
            }
        }
        all.push(w[1]);
    }
    all
}

/// What straight lines over a part of an interval miss of what is behind, as a share of the largest values there.
fn missed<const N: usize>(
    intervals: [&Interval; N],
    [from, to]: [f64; 2],
    largest: &[Largest; N],
    change: Change<N>,
) -> f64 {
    let quantities = |s: f64| -> Vec<(f64, f64)> {
        let all = behind(intervals, s, change);
        let of = |(instant, largest): (&Instant, &Largest)| {
            let Instant { torque, torque_rate, velocity, acceleration, .. } = *instant;
            [
                (torque, largest.torque),
                (torque_rate, largest.torque_rate),
                (velocity, largest.velocity),
                (acceleration, largest.acceleration),
                (torque * velocity, largest.power),
                (velocity * acceleration, largest.inertial),
                (torque * torque, largest.torque * largest.torque),
                (torque * acceleration, largest.torque * largest.acceleration),
                (acceleration * acceleration, largest.acceleration * largest.acceleration),
            ]
        };
        all.iter().zip(largest).flat_map(of).collect()
    };
    let at: Vec<Vec<(f64, f64)>> = (0..=4).map(|k| quantities(from + (to - from) * f64::from(k) / 4.0)).collect();
    let half = |a: usize, c: usize| {
        let (first, middle, last) = (&at[a], &at[(a + c) / 2], &at[c]);
        let miss = |k: usize| match first[k].1 > 0.0 {
            true => (middle[k].0 - 0.5 * (first[k].0 + last[k].0)).abs() / first[k].1,
            false => 0.0,
        };
        (0..first.len()).map(miss).fold(0.0, f64::max)
    };
    // Half of it misses a quarter: whichever way it bends.
    half(0, 4).max(4.0 * half(0, 2)).max(4.0 * half(2, 4))
}
