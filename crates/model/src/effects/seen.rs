//! What a bench shows of an effect, and which run would show more.

use super::{Effect, Equation};

/// What a bench and the equation that it shows mean for an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct View {
    /// The equation.
    pub equation: Equation,
    /// The sensor has a zero that belongs to each log.
    pub has_free_zero: bool,
    /// The drive is seen against what hangs at the output, not through a sensor between the two.
    pub sees_load: bool,
    /// There is a gear.
    pub has_gear: bool,
    /// The voltage or the supply is measured.
    pub measures_supply: bool,
    /// Damping is a parameter that is fitted, the back-EMF within it.
    pub fits_damping: bool,
}

/// A run that separates effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Of two effects that look alike the run of the lower rank is advised.
    pub rank: u32,
    /// What to do, and that it would separate them.
    pub words: &'static str,
}

/// An effect that another looks like.
#[derive(Clone, Copy)]
pub struct Mimic {
    /// The effect.
    pub of: &'static dyn Effect,
    /// The run that separates the two.
    pub run: &'static str,
}

/// For what depends on temperature.
pub(super) const COLD_AND_HOT: Run =
    Run { rank: 10, words: "a run from cold and one from hot at the same currents would separate them" };
/// For what bends torque over current.
pub(super) const CURRENT_STEPS: Run = Run {
    rank: 20,
    words: "a run with current steps up to the largest current at constant temperature would separate them",
};
/// For friction near standstill.
pub(super) const SLOW_RUN: Run = Run {
    rank: 30,
    words: "a slow run in both directions, from standstill to a tenth of the speed, would separate them",
};
/// For what depends on an angle.
pub(super) const SLOW_TURNS: Run =
    Run { rank: 40, words: "slow turns of several revolutions at two different currents would separate them" };
/// For what differs between directions.
pub(super) const BOTH_DIRECTIONS: Run =
    Run { rank: 50, words: "the same speeds in both directions, in several logs, would separate them" };
/// For what the drive loses.
pub(super) const STEPS_AT_STANDSTILL: Run =
    Run { rank: 60, words: "slow current steps of both signs at standstill would separate them" };

/// What to do to separate two effects that look alike.
pub fn separating_run(a: &dyn Effect, b: &dyn Effect) -> &'static str {
    let pair = |one: &dyn Effect, other: &dyn Effect| one.mimics().filter(|m| m.of == other).map(|m| m.run);
    let general = || [a, b].into_iter().filter_map(|e| e.separated_by()).min_by_key(|run| run.rank).map(|r| r.words);
    pair(a, b)
        .or_else(|| pair(b, a))
        .or_else(general)
        .unwrap_or("a run in which speed, load and current vary independently would separate them")
}
