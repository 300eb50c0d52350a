//! How a search is run, and how it is stopped.

use std::fmt;

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
}

/// Steps of [`work`] for all programs of a search, if all do them: about 60 s of one core.
const ALL_STEPS: u64 = 5_000_000_000;

/// Fewest steps for one program, of a search of many: 20 ms.
const FEWEST_STEPS: u64 = 2_000_000;

/// Most steps for one program.
const MOST_STEPS: u64 = 400_000_000;

impl<'s> Stop<'s> {
    /// Never.
    pub const NEVER: Stop<'static> = Stop { asked: &|| false, steps: MOST_STEPS };

    /// When somebody says so.
    pub fn when(stop: &'s (dyn Fn() -> bool + Sync)) -> Stop<'s> {
        Stop { asked: stop, ..Stop::NEVER }
    }

    /// Share the work of a search among so many programs.
    pub(super) fn among(self, programs: usize) -> Stop<'s> {
        Stop { steps: (ALL_STEPS / programs.max(1) as u64).clamp(FEWEST_STEPS, MOST_STEPS), ..self }
    }

    /// Solve a program within its share of the work.
    pub(super) fn within<T>(self, solve: impl FnOnce() -> T) -> T {
        work::within(self.steps, solve)
    }

    /// True if a program is to end: it was stopped, or its share of the work is done.
    pub(super) fn ends_program(self) -> bool {
        work::is_spent() || self.now()
    }

    /// Whether it is to stop now.
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
            tick: &|| {},
            stop: &|| false,
            joint: None,
            loads: None,
        }
    }
}
