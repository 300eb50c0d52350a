//! How a search is run, and how it is stopped.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

use super::loads::Loads;
use gearwise_model::numerics::work;

/// A search was stopped: there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stopped;

/// Conditions that end a search: a request to stop, and the share of the work of each program.
#[derive(Clone, Copy)]
pub struct Stop<'s> {
    asked: &'s (dyn Fn() -> bool + Sync),
    /// Steps of [`work`] for each program.
    steps: u64,
    /// Sum of the steps that programs do.
    done: Option<&'s AtomicU64>,
}

/// Steps of [`work`] for all programs of a search, if all do them: about 60 s of one core.
const ALL_STEPS: u64 = 5_000_000_000;

/// Fewest steps for one program, of a search of many: 20 ms.
const FEWEST_STEPS: u64 = 2_000_000;

/// Most steps for one program.
const MOST_STEPS: u64 = 400_000_000;

/// Largest share of a program that is solved again, relative to its first share.
const MOST_TIMES: u64 = 8;

impl<'s> Stop<'s> {
    /// Never.
    pub const NEVER: Stop<'static> = Stop { asked: &|| false, steps: MOST_STEPS, done: None };

    /// When somebody says so.
    pub fn when(stop: &'s (dyn Fn() -> bool + Sync)) -> Stop<'s> {
        Stop { asked: stop, ..Stop::NEVER }
    }

    /// Share the work of a search among so many programs.
    pub(super) fn among(self, programs: usize) -> Stop<'s> {
        Stop { steps: (ALL_STEPS / programs.max(1) as u64).clamp(FEWEST_STEPS, MOST_STEPS), ..self }
    }

    /// Give each program so many steps, but not fewer than [`FEWEST_STEPS`].
    pub(super) fn with_steps(self, steps: u64) -> Self {
        Stop { steps: steps.max(FEWEST_STEPS), ..self }
    }

    /// Add up the steps that programs do.
    pub(super) fn adding(self, done: &'s AtomicU64) -> Stop<'s> {
        Stop { done: Some(done), ..self }
    }

    /// Share of each of `among` programs in the work that all `programs` left over, at most [`MOST_TIMES`] the first share; `None` where
    /// it is less than twice the first share.
    pub(super) fn again(self, programs: usize, among: usize) -> Option<Stop<'s>> {
        let done = self.done.map_or(u64::MAX, |done| done.load(Ordering::Relaxed));
        let left = self.steps.saturating_mul(programs as u64).saturating_sub(done);
        let steps = (left / among.max(1) as u64).min(MOST_TIMES * self.steps).min(MOST_STEPS);
        (steps >= 2 * self.steps).then_some(Stop { steps, ..self })
    }

    /// Solve a program within its share of the work.
    pub(super) fn within<T>(self, solve: impl FnOnce() -> T) -> T {
        self.within_share(solve).0
    }

    /// Solve a program within its share of the work; true if it took its whole share.
    pub(super) fn within_share<T>(self, solve: impl FnOnce() -> T) -> (T, bool) {
        let (found, steps) = work::within(self.steps, solve);
        if let Some(done) = self.done {
            done.fetch_add(steps, Ordering::Relaxed);
        }
        (found, steps >= self.steps)
    }

    /// True if a program is to end: it was stopped, or its share of the work is done.
    pub(super) fn ends_program(self) -> bool {
        work::is_spent() || self.now()
    }

    /// True if the search is to stop now.
    pub fn now(self) -> bool {
        (self.asked)()
    }

    /// What was found, if nobody stopped the search: what a stopped one leaves is no answer.
    ///
    /// # Errors
    /// It was stopped.
    pub(super) fn unless<T>(self, found: T) -> Result<T, Stopped> {
        if self.now() { Err(Stopped) } else { Ok(found) }
    }
}

impl fmt::Debug for Stop<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Stop")
    }
}

/// How an optimisation is run.
#[derive(Clone, Copy)]
pub struct Options<'p> {
    /// Reject designs with a limit that cannot be checked, because a number is not known.
    pub only_checked: bool,
    /// Only so many designs of each joint are wanted: motors whose lower bound shows that they are not
    /// among them are not solved.
    pub keep: Option<usize>,
    /// Whether it is told of every motor why it cannot do it. Else, where only the first designs are wanted, it is
    /// told of joints without a design alone: that a motor cannot is often quickly seen, and why it comes nowhere
    /// takes long.
    pub reasons: bool,
    /// If true, motors whose search reached its share of the work get the work that others left over.
    pub leftover: bool,
    /// Called once for each motor and joint that is done.
    pub tick: &'p (dyn Fn() + Sync),
    /// Asked before each motor, at each node of a branch and bound and at each region of a search for a spring. Once it
    /// says `true` it has to go on saying so; the search then ends with [`Stopped`].
    pub stop: &'p (dyn Fn() -> bool + Sync),
    /// The one joint that is looked at, by its place in the robot; `None` for all.
    pub joint: Option<usize>,
    /// Loads that were made ready before, of robots that are optimised one after another.
    pub loads: Option<&'p Loads>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            only_checked: false,
            keep: None,
            reasons: true,
            leftover: true,
            tick: &|| {},
            stop: &|| false,
            joint: None,
            loads: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_that_ended_share_the_work_that_the_others_left() {
        let done = AtomicU64::new(0);
        let stop = Stop::NEVER.among(1_000).adding(&done);
        let share = stop.steps;
        let solve = |stop: Stop, steps: usize| {
            stop.within(|| {
                while steps > 0 && !stop.ends_program() {
                    work::count(steps);
                }
            });
        };
        // 9 of 10 do nothing, one its whole share.
        (0..9).for_each(|_| solve(stop, 0));
        solve(stop, (share / 10) as usize);
        assert_eq!(stop.again(10, 1).map(|again| again.steps), Some(MOST_TIMES * share));
        assert_eq!(stop.again(10, 3).map(|again| again.steps), Some(3 * share));
        // Less than twice the first share is not worth a second search.
        assert!(stop.again(10, 5).is_none());
    }
}
