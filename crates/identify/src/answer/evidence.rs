//! What a verdict rests on, and the one place that makes a verdict of it.
//!
//! The one idea: a verdict says no more than was shown. That an effect is there is shown by its gain; that none of
//! those asked is there, by a bound on what each and all together could still explain; that nothing at all is missing,
//! only by the instrument's own noise, found without the model. What could not be bounded is not resolved.

use super::noise::Noise;
use crate::bench::Channel;
use gearwise_model::numerics::sums::finite_sum;

/// Largest share of the error that refused effects may still explain (upper 95 % bound) to be called absent.
pub(crate) const BOUND: f64 = 0.03;
/// What is left is noise up to this many times the instrument's: twice would admit three quarters of the error's
/// variance.
pub const AT_THE_NOISE: f64 = 1.15;
/// Less than this many times the instrument's noise cannot be left.
const BELOW_THE_NOISE: f64 = 0.8;
/// Variance accounted for \[%\] below which a channel may not follow the model at all.
const FOLLOWS: f64 = 10.0;
/// Standard errors from nothing at which a model explains something.
const SURE: f64 = 3.0;
/// By how much the error must rise, beyond its scatter, to be called worse: fitted numbers always cost a little of what is
/// left out.
const WORSE: f64 = 0.01;
/// Student's t of a one-sided 95 % bound at 16 degrees of freedom: the fewest blocks that fit.
const STUDENT: f64 = 1.746;

/// What the logs say of the declared model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// What is left is the instrument's own noise, and nothing that was asked could take a part of it away.
    NothingMissing,
    /// Every effect that could be asked is bounded, alone and together; whether more than noise is left is another
    /// question.
    NoneOfThese,
    /// No effect could be named with certainty, and not all could be excluded.
    NotResolved,
    /// Effects of the library explain what the declared model left.
    Explained,
    /// Something is left that no effect of the library explains.
    UnexplainedStructure,
}

impl Verdict {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::NothingMissing => "nothing_missing",
            Verdict::NoneOfThese => "none_of_these",
            Verdict::NotResolved => "not_resolved",
            Verdict::Explained => "explained",
            Verdict::UnexplainedStructure => "unexplained_structure",
        }
    }

    /// The verdict over several equations of one bench: the one that claims least of completeness.
    pub fn over(verdicts: impl IntoIterator<Item = Verdict>) -> Verdict {
        let rank = |v: &Verdict| match v {
            Verdict::NothingMissing => 0,
            Verdict::NoneOfThese => 1,
            Verdict::NotResolved => 2,
            Verdict::Explained => 3,
            Verdict::UnexplainedStructure => 4,
        };
        verdicts.into_iter().max_by_key(rank).unwrap_or(Verdict::NotResolved)
    }
}

/// The share of the left-out squared error that something takes away, with its standard error between blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Share of the squared error; negative where it does harm.
    pub share: f64,
    /// Its standard error; not finite where nothing was left or blocks are too few.
    pub error: f64,
}

impl Gain {
    /// From the left-out squared errors of the blocks without and with it.
    pub fn new(before: &[f64], after: &[f64]) -> Gain {
        let total = finite_sum(before);
        let falls: Vec<f64> = before.iter().zip(after).map(|(a, b)| a - b).filter(|d| d.is_finite()).collect();
        let n = falls.len() as f64;
        if n < 4.0 || total.is_nan() || total <= 0.0 {
            return Gain { share: 0.0, error: f64::INFINITY };
        }
        let mean = falls.iter().sum::<f64>() / n;
        let variance = falls.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Gain { share: n * mean / total, error: (n * variance).sqrt() / total }
    }

    /// By what share the error itself falls.
    pub fn fall(self) -> f64 {
        fall(self.share)
    }

    /// The most that it may be (95 %): by what share the error falls.
    pub fn most(self) -> f64 {
        fall((self.share + STUDENT * self.error).max(0.0))
    }

    /// Whether it does harm: the error rises, surely and by more than fitting costs.
    pub fn is_harm(self) -> bool {
        self.fall() < -WORSE && self.share + STUDENT * self.error < 0.0
    }

    /// How many standard errors it is from nothing.
    pub fn sure(self) -> f64 {
        if self.error > 0.0 { self.share / self.error } else { 0.0 }
    }
}

/// By what share the error falls, from that of its square.
fn fall(share: f64) -> f64 {
    1.0 - (1.0 - share).max(0.0).sqrt()
}

/// An effect that was asked and is not in the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Asked {
    /// Name in the library.
    pub name: &'static str,
    /// What it would take away of what is left in the end.
    pub gain: Gain,
}

/// What a verdict rests on.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    /// Effects that were found.
    pub found: usize,
    /// Variables that what is left depends on, without a name.
    pub unexplained: usize,
    /// Root mean square of what the final model leaves, each block left out of the fit in turn, of all rows alike \[unit\].
    pub left: f64,
    /// Share of the rows for fitting that are so far off that they weigh less, where that matters.
    pub far_off: Option<f64>,
    /// The error of the final model on what was held out, of all rows alike \[unit\].
    pub held_out: Option<f64>,
    /// The instrument's own noise in the band.
    pub noise: Noise,
    /// Effects that were asked and are not in the model, the strongest first.
    pub asked: Vec<Asked>,
    /// All of these together; `None` where that was not tried.
    pub together: Option<Gain>,
    /// What a model with effects whose values are not believed would leave, where that is surely less \[unit\].
    pub better: Option<f64>,
    /// Whether the final model is surely no better than the declared one: what was held out is further off with it.
    pub worse_held_out: bool,
    /// Whether refitting the declared parameters made the left-out error worse.
    pub worse_by_refitting: bool,
    /// The channel that is explained, where no log has it moving.
    pub dead: Option<Channel>,
    /// Whether channels contradict each other, so that nothing was asked.
    pub contradicted: bool,
    /// Whether stretches that own the error were left out: what they show is not explained.
    pub owned: bool,
    /// Whether what is explained does not follow the model at all: see [`Evidence::does_not_follow`].
    pub unrelated: bool,
    /// How many effects were not asked for because the bench file says so.
    pub left_out: usize,
    /// Whether what is explained does no more than the instrument's own noise.
    pub still: bool,
}

impl Evidence {
    /// Of logs whose refusals were not bounded: nothing more is known than what is left.
    pub fn unbounded(found: usize, unexplained: usize, left: f64) -> Evidence {
        Evidence { found, unexplained, left, ..Evidence::default() }
    }

    /// Whether a model with so much variance accounted for \[%\], on the logs for fitting and on what was held out, explains
    /// nothing: next to none of either, and no more than chance would (`gain` over a constant).
    pub fn does_not_follow(fit: f64, held_out: Option<f64>, gain: Gain) -> bool {
        let next_to_none = |percent: f64| percent < FOLLOWS;
        next_to_none(fit) && held_out.is_none_or(next_to_none) && gain.error.is_finite() && gain.sure() < SURE
    }

    /// Whether the logs say nothing of the model: what is explained never moves, or does not follow it.
    pub fn teaches_nothing(&self) -> bool {
        self.dead.is_some() || self.unrelated || self.contradicted
    }

    /// The refused effect that would take away most.
    pub fn strongest(&self) -> Option<&Asked> {
        self.asked.first()
    }

    /// The most that refused effects could take away, alone or together (share of the error, 95 %); `None` where that
    /// was not bounded.
    pub fn most(&self) -> Option<f64> {
        let together = self.together?.most();
        Some(self.asked.iter().map(|a| a.gain.most()).fold(together, f64::max))
    }

    /// What is left, in times of the instrument's noise, where that can be told.
    pub fn times_the_noise(&self) -> Option<f64> {
        self.noise.floor().map(|floor| self.left / floor)
    }

    /// The same of what was held out, where that is more than the noise and more than what is left.
    pub fn held_out_times_the_noise(&self) -> Option<f64> {
        let times = self.held_out? / self.noise.floor()?;
        (times > AT_THE_NOISE && self.times_the_noise().is_some_and(|left| times > left)).then_some(times)
    }

    /// Whether less is left than the instrument's own noise: then something explains noise, and no name is certain.
    pub fn is_below_the_noise(&self) -> bool {
        self.times_the_noise().is_some_and(|times| times < BELOW_THE_NOISE)
    }

    /// Whether what is left is the instrument's noise, on what was held out too.
    fn is_noise(&self) -> bool {
        let within = |error: f64| self.noise.floor().is_some_and(|floor| error <= AT_THE_NOISE * floor);
        within(self.left) && self.held_out.is_none_or(within)
    }
}

/// The verdict.
pub fn verdict(evidence: &Evidence) -> Verdict {
    let bounded = evidence.most().is_some_and(|most| most <= BOUND);
    match (evidence.unexplained, evidence.found) {
        _ if evidence.teaches_nothing() || evidence.is_below_the_noise() => Verdict::NotResolved,
        (1.., _) => Verdict::UnexplainedStructure,
        _ if evidence.better.is_some() || evidence.worse_held_out => Verdict::NotResolved,
        (0, 1..) => Verdict::Explained,
        _ if !bounded || evidence.owned => Verdict::NotResolved,
        _ if evidence.left_out == 0
            && evidence.is_noise()
            && !evidence.worse_by_refitting
            && evidence.noise.line.is_none() =>
        {
            Verdict::NothingMissing
        }
        _ => Verdict::NoneOfThese,
    }
}

#[cfg(test)]
mod tests;
