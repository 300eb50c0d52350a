//! A lower bound of the objective without solving: what a motor can reach at best.
//!
//! The range is cut into a few pieces. On each the rows that its ends break cut ratios off, and the
//! objective's cut at the middle, concave terms replaced by secants, is below the objective: its least
//! value bounds the piece. The least of the pieces bounds the program. It costs a few looks at the limits,
//! where solving takes many.

use super::branch::{Underestimator, worst_row};
use super::objective::Goal;
use super::{Demand, RatioProgram};
use crate::design::sweep::grid;
use crate::requirement::Quantity;

/// Pieces of the range, evenly spaced in ln N.
const PIECES: usize = 6;
/// How often the ends of a piece are cut off.
const ROUNDS: usize = 2;

impl RatioProgram<'_> {
    /// A number that the objective is nowhere below at any ratio that keeps the limits, in the unit of the
    /// objective. `None` where the bound shows that no ratio does, or where there is no bound: solve to
    /// learn why.
    pub fn lower_bound(&self) -> Option<f64> {
        if self.fixed_limits().is_some() {
            return None;
        }
        if self.why_evaluated().is_some() {
            return None;
        }
        let (low, high) = self.ends().ok()?;
        if self.objective.sole() == Some(Quantity::Mass) {
            return self.prepared.candidate.mass_at(low.ratio);
        }
        let goal = Goal::new(self);
        let mut ends = vec![low.ratio];
        if high.ratio > low.ratio {
            ends.extend(self.stage_ratios(low.ratio, high.ratio));
            ends.extend(grid(low.ratio, high.ratio, PIECES + 1));
        }
        ends.push(high.ratio);
        ends.sort_by(f64::total_cmp);
        let pieces = ends.windows(2).filter_map(|piece| self.bound_of_piece(&goal, piece[0], piece[1]));
        let least = pieces.reduce(f64::min)?;
        (!least.is_nan()).then(|| goal.natural(least))
    }

    /// The bound on an interval, in the unit of the cuts; `None` where nothing of it is feasible.
    fn bound_of_piece(&self, goal: &Goal, mut a: f64, mut b: f64) -> Option<f64> {
        // The mass by stages is that of the interval's end, but at its start.
        let steps = goal.steps(a).min(goal.steps(b));
        // The winding's temperature over the motion takes a walk over all samples: solving is as cheap.
        let cheap = |demand: &Demand| !matches!(demand, Demand::WindingPeak(_));
        for _ in 0..ROUNDS {
            for at in [a, b] {
                let Some((polynomial, bound)) = worst_row(self, at, cheap) else { continue };
                (a, b) = Underestimator::new(&polynomial, a, b).below(bound, a, b)?;
            }
        }
        let under = Underestimator::new(&goal.cut((a * b).sqrt()), a, b);
        Some(under.at(under.minimum(a, b)) + steps - 1e-14 * under.size)
    }
}
