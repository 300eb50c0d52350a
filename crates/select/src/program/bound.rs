//! A lower bound of the objective without solving: what a motor can reach at best.
//!
//! The range is cut into a few pieces. On each the rows that its ends break cut ratios off, and the
//! objective's cut at the middle, concave terms replaced by secants, is below the objective: its least
//! value bounds the piece. The least of the pieces bounds the program. It costs a few looks at the limits,
//! where solving takes many. In the same way it is proved that a limit is exceeded all over an interval.

use super::branch::worst_row;
use super::objective::Goal;
use super::scan::{self, CLEARLY};
use super::underestimate::Underestimator;
use super::{Demand, Limited, RatioProgram, mapped};
use gearwise_model::actuator::Laurent;
use gearwise_model::numerics::grid::grid;
use gearwise_model::requirement::{Objective, Quantity};

/// Pieces of the range, evenly spaced in ln N.
const PIECES: usize = 6;

/// Intervals after which the proof that nothing is possible is given up.
const MOST_INTERVALS: usize = 64;

/// What is certain of an objective without solving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// It is nowhere below this at a ratio that keeps the limits.
    Of(f64),
    /// No ratio keeps the limits: each exceeds one by more than any tolerance.
    Nowhere,
    /// Nothing.
    Unknown,
}

/// The part of an interval on which a row is not clearly broken.
fn part_kept((polynomial, bound): &(Laurent, f64), a: f64, b: f64) -> Option<(f64, f64)> {
    let under = Underestimator::new(polynomial, a, b);
    under.below(bound + CLEARLY * (bound + under.size), a, b)
}

impl RatioProgram<'_> {
    /// A number that the objective is nowhere below at any ratio that keeps the limits, in the unit of the
    /// objective. `None` where the bound shows that no ratio does, or where there is no bound: solve to
    /// learn why.
    pub fn lower_bound(&self) -> Option<f64> {
        match self.bounded(true) {
            Bound::Of(least) => Some(least),
            Bound::Nowhere | Bound::Unknown => None,
        }
    }

    /// What is certain of the objective without solving. Without the limits that are asked of samples it is less, and next to nothing
    /// to find.
    pub fn bounded(&self, of_samples: bool) -> Bound {
        if self.stands_by_ratio() {
            return mapped::with_least_standing(self, |program| program.bounded(of_samples));
        }
        if let Some((quantity, weight)) = self.objective.weighed() {
            let single = Objective::single(quantity);
            let program = RatioProgram { objective: &single, limits: self.limits.clone(), ..*self };
            return match program.bounded(of_samples) {
                Bound::Of(least) => Bound::Of(weight * least),
                other => other,
            };
        }
        if self.fixed_limits().is_some() {
            return Bound::Nowhere;
        }
        if self.is_evaluated() {
            return Bound::Unknown;
        }
        let Ok((low, high)) = self.ends() else { return Bound::Nowhere };
        if self.objective.sole() == Some(Quantity::Mass) && self.prepared.candidate.mass_slope() == 0.0 {
            return self.prepared.candidate.mass_at(low.ratio).map_or(Bound::Unknown, Bound::Of);
        }
        let goal = Goal::new(self);
        let ends = self.ends_of_pieces(low.ratio, high.ratio);
        let row = |end: &f64| if of_samples { self.cheap_row(*end) } else { None };
        let rows: Vec<_> = ends.iter().map(row).collect();
        let pieces = (1..ends.len())
            .filter_map(|k| self.bound_of_piece(&goal, [ends[k - 1], ends[k]], [&rows[k - 1], &rows[k]]));
        match pieces.reduce(f64::min) {
            None => Bound::Nowhere,
            Some(least) if least.is_nan() => Bound::Unknown,
            Some(least) => Bound::Of(goal.natural(least)),
        }
    }

    /// The same program without the limits that take a walk over all samples; `None` where it has none of them.
    pub(super) fn without_walks(&self) -> Option<RatioProgram<'_>> {
        let mut limits = self.limits.clone();
        limits.retain(|l| !l.asked.demand.takes_a_walk());
        (limits.len() < self.limits.len()).then_some(RatioProgram { limits, ..*self })
    }

    /// Whether it is certain without solving that no ratio keeps the limits: [`solve`](Self::solve) would find none.
    /// Where the program is not convex solving is dear, and this is a few looks at the limits; where it is convex
    /// nothing is tried. `false` says nothing.
    pub fn is_impossible(&self) -> bool {
        if self.stands_by_ratio() {
            return mapped::with_least_standing(self, |program| program.is_impossible());
        }
        if self.is_evaluated() || self.why_not_convex().is_none() {
            return false;
        }
        if self.fixed_limits().is_some() {
            return true;
        }
        let Ok((low, high)) = self.ends() else { return true };
        let ends = self.ends_of_pieces(low.ratio, high.ratio);
        let mut open: Vec<(f64, f64)> = ends.windows(2).map(|piece| (piece[0], piece[1])).collect();
        for _ in 0..MOST_INTERVALS {
            let Some((mut a, mut b)) = open.pop() else { return true };
            let mut ruled_out = false;
            for at_start in [true, false] {
                let at = if at_start { a } else { b };
                let Some(row) = self.broken_row(at) else { continue };
                match part_kept(&row, a, b) {
                    Some(part) => (a, b) = part,
                    None => ruled_out = true,
                }
            }
            if ruled_out || self.is_broken_between(a, b) {
                continue;
            }
            let middle = (a * b).sqrt();
            if b <= a * (1.0 + CLEARLY) || scan::worst(self, middle).0 <= CLEARLY {
                return false;
            }
            open.extend([(a, middle), (middle, b)]);
        }
        false
    }

    /// Whether one limit is certainly exceeded, by more than any tolerance, at every ratio of an interval.
    pub(super) fn is_broken_between(&self, a: f64, b: f64) -> bool {
        if self.broken_row((a * b).sqrt()).is_some_and(|row| part_kept(&row, a, b).is_none()) {
            return true;
        }
        self.limits.iter().any(|Limited { candidate, asked }| match asked.demand {
            Demand::WindingPeak(node) if asked.bound > 0.0 => {
                let bound = asked.bound * (1.0 + CLEARLY);
                asked.load(candidate).winding_peak_is_beyond(candidate.end(asked.end), &node, (a, b), bound)
            }
            _ => false,
        })
    }

    /// The most violated row among those that cost no walk over the samples, where its bound is a measure.
    fn broken_row(&self, ratio: f64) -> Option<(Laurent, f64)> {
        worst_row(self, ratio, |demand| !demand.takes_a_walk()).filter(|(_, bound)| *bound > 0.0)
    }

    /// The range cut into pieces: their ends.
    fn ends_of_pieces(&self, low: f64, high: f64) -> Vec<f64> {
        let mut ends = vec![low];
        if high > low {
            ends.extend(self.stage_ratios(low, high));
            ends.extend(grid(low, high, PIECES + 1));
        }
        ends.push(high);
        ends.sort_by(f64::total_cmp);
        ends
    }

    /// The most violated row at a ratio. The winding's temperature over the motion takes a walk over all samples: solving is as
    /// cheap.
    fn cheap_row(&self, ratio: f64) -> Option<(Laurent, f64)> {
        worst_row(self, ratio, |demand| !demand.takes_a_walk())
    }

    /// The bound on an interval with the most violated rows at its ends, in the unit of the cuts; `None` where nothing of it is
    /// feasible.
    fn bound_of_piece(&self, goal: &Goal, ends: [f64; 2], at_ends: [&Option<(Laurent, f64)>; 2]) -> Option<f64> {
        let [mut a, mut b] = ends;
        // The mass by stages is that of the interval's end, but at its start.
        let steps = goal.steps(a).min(goal.steps(b));
        let cut = |row: &Option<(Laurent, f64)>, a: f64, b: f64| match row {
            // What is broken by no more than a tolerance is not ruled out.
            Some(row) => part_kept(row, a, b),
            None => Some((a, b)),
        };
        for row in at_ends {
            (a, b) = cut(row, a, b)?;
        }
        // An end that did not move keeps its limits.
        for at in [a, b].into_iter().filter(|at| !ends.contains(at)) {
            (a, b) = cut(&self.cheap_row(at), a, b)?;
        }
        let under = Underestimator::new(&goal.cut((a * b).sqrt()), a, b);
        Some(under.at(under.minimum(a, b)) + steps - 1e-14 * under.size)
    }
}
