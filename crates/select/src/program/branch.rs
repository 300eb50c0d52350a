//! Where convexity in N² ends: interval branch and bound in N, until the bounds meet.
//!
//! On an interval of ratios a Laurent polynomial is bounded from below by a convex one: concave terms
//! are replaced by their secants. Rows so bounded cut the ends of the interval off; the objective's
//! cut so bounded gives the lower bound. What a sweep of the grid found is the upper bound; an
//! interval that cannot beat it is done.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::objective::Goal;
use super::underestimate::Underestimator;
use super::{
    Certificate, Class, GAP_TOLERANCE, Infeasible, Limited, Optimum, Outcome, RatioProgram, Refusal, Unsolved,
    evaluated, prices, scan, weakened,
};
use gearwise_model::actuator::Laurent;
use gearwise_model::actuator::limits::Demand;
use gearwise_model::numerics::work;

/// More intervals than any case has been seen to need; what is left then is reported as a gap.
const MAX_INTERVALS: usize = 20_000;
/// The same where a weakened field is bounded sample by sample.
const MAX_WEAKENED: usize = 400;
/// An interval narrower than this (relative) is not divided further.
const NARROWEST: f64 = 1e-12;
/// A limit that is met with equality is exceeded by no more than this (relative).
const ROUNDING: f64 = 1e-13;

/// An interval with a lower bound of the objective on it.
struct Interval {
    a: f64,
    b: f64,
    bound: f64,
}

impl PartialEq for Interval {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Interval {}

impl PartialOrd for Interval {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Interval {
    /// The heap gives the least bound first, ties from the left.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound).then(other.a.total_cmp(&self.a))
    }
}

struct Search<'a> {
    program: &'a RatioProgram<'a>,
    goal: Goal<'a>,
    best: Option<(f64, f64)>,
}

pub(super) fn solve(program: &RatioProgram, why: &'static str) -> Outcome {
    let (low, high) = match program.ends() {
        Ok(ends) => ends,
        Err(infeasible) => return Err(Refusal::Infeasible(infeasible)),
    };
    let (min, max) = (low.ratio, high.ratio);
    let goal = Goal::new(program);
    let found = scan::scan(program, &goal, &low, &high);
    let mut search = Search { program, best: found.best.as_ref().ok().map(|n| (*n, goal.value(*n))), goal };
    let (bound, finished) = search.run(min, max);
    let Some((ratio, value)) = search.best else {
        return match found.best {
            Err(nearest) if finished => Err(Refusal::Infeasible(nearest)),
            Err(Infeasible::Nowhere { bind, least, ratio, .. }) => {
                Err(Refusal::NotSolved(Unsolved::Nearly { limit: bind.limit, least, ratio }))
            }
            _ => Err(Refusal::NotSolved(Unsolved::NothingRuledOut)),
        };
    };
    let mut windows = found.windows;
    if !windows.iter().any(|w| w.min <= ratio * (1.0 + 1e-9) && ratio <= w.max * (1.0 + 1e-9)) {
        // In a sliver that the grid did not see.
        windows.push(scan::point(program, ratio));
        windows.sort_by(|a, b| a.min.total_cmp(&b.min));
    }
    let gap = ((value - bound) / search.goal.reference(ratio, value)).max(0.0);
    // Intervals left on the heap are bounded as well, so that the gap holds.
    let certificate = if is_proof(finished || work::is_spent(), gap) {
        Certificate::Certified { lower_bound: search.goal.natural(bound.min(value)), gap, method: "branch and bound" }
    } else if work::is_spent() {
        Certificate::ended(gap, search.goal.natural(bound.min(value)))
    } else {
        Certificate::NotCertified(why.into())
    };
    let optimum = Optimum {
        ratio,
        objective: search.goal.natural(value),
        shadow_prices: match program.is_evaluated() {
            true => evaluated::prices(program, &search.goal, &windows, ratio, &low, &high),
            false => prices::at(program, &search.goal, &windows, ratio, &low, &high),
        },
        windows,
        certificate,
    };
    Ok(optimum)
}

/// Whether the search has proved its best: it looked at everything, and what it left open is not better by more than the
/// tolerance.
fn is_proof(finished: bool, gap: f64) -> bool {
    finished && gap <= GAP_TOLERANCE
}

impl Search<'_> {
    /// Runs until the bounds meet; gives the lower bound, and whether they did.
    fn run(&mut self, min: f64, max: f64) -> (f64, bool) {
        let mut heap = BinaryHeap::new();
        let mut start = min;
        // The least bound of what is not divided further.
        let mut settled = f64::INFINITY;
        self.offer(min);
        self.offer(max);
        for end in self.program.stage_ratios(min, max).into_iter().chain([max]) {
            self.offer(end);
            settled = settled.min(self.enter(&mut heap, start, end));
            start = end;
        }
        let most = if self.program.is_evaluated() { MAX_WEAKENED } else { MAX_INTERVALS };
        for _ in 0..most {
            if self.program.prepared.stop.ends_program() {
                break;
            }
            let Some(interval) = heap.pop() else {
                // Where nothing feasible was found, everything must have been ruled out.
                return (settled, self.best.is_some() || settled == f64::INFINITY);
            };
            if interval.bound >= self.target() {
                return (settled.min(interval.bound), true);
            }
            let middle = (interval.a * interval.b).sqrt();
            for (a, b) in [(interval.a, middle), (middle, interval.b)] {
                settled = settled.min(self.enter(&mut heap, a, b));
            }
        }
        let left = heap.peek().map_or(f64::INFINITY, |i| i.bound);
        (settled.min(left), false)
    }

    /// The value below which an interval is still of interest.
    fn target(&self) -> f64 {
        self.best
            .map_or(f64::INFINITY, |(ratio, value)| value - 0.25 * GAP_TOLERANCE * self.goal.reference(ratio, value))
    }

    fn offer(&mut self, ratio: f64) {
        let feasible = scan::worst(self.program, ratio).0 <= ROUNDING;
        let value = self.goal.value(ratio);
        if feasible && value.is_finite() && self.best.is_none_or(|(_, best)| value < best) {
            self.best = Some((ratio, value));
        }
    }

    /// Narrows an interval, bounds it, and puts it on the heap if it may hold something better. Gives
    /// its bound where it is too narrow to be divided, else infinity.
    fn enter(&mut self, heap: &mut BinaryHeap<Interval>, mut a: f64, mut b: f64) -> f64 {
        // A mass by stages is that of the interval's end everywhere but at its start, which the
        // interval before has as its end.
        let steps = self.goal.steps(b);
        for _ in 0..4 {
            let before = b - a;
            for at in [a, b] {
                let Some((polynomial, bound)) = self.worst_row(at, a, b) else { continue };
                match Underestimator::new(&polynomial, a, b).below(bound, a, b) {
                    Some(part) => (a, b) = part,
                    None => return f64::INFINITY,
                }
            }
            if b - a > 0.5 * before {
                break;
            }
        }
        let middle = (a * b).sqrt();
        let cut = match self.program.is_evaluated() {
            true => weakened::cut(self.program, &self.goal, middle, (a, b)),
            false => self.goal.cut(middle),
        };
        let under = Underestimator::new(&cut, a, b);
        let least = under.minimum(a, b);
        let bound = under.at(least) + steps - 1e-14 * under.size;
        self.offer(least);
        if bound >= self.target() {
            return bound;
        }
        if b - a <= NARROWEST * b {
            return bound;
        }
        heap.push(Interval { a, b, bound });
        f64::INFINITY
    }

    /// The most violated row at a ratio, where one is violated. A limit that takes a walk over all samples, or
    /// many where it runs away, is looked at only where the others are kept: any violated row will do.
    fn worst_row(&self, ratio: f64, a: f64, b: f64) -> Option<(Laurent, f64)> {
        if self.program.is_evaluated() {
            return weakened::worst_row(self.program, ratio, (a, b));
        }
        worst_row(self.program, ratio, |demand| !demand.takes_a_walk())
            .or_else(|| worst_row(self.program, ratio, Demand::takes_a_walk))
    }
}

/// The most violated row at a ratio among some of the limits, where one is violated.
pub(super) fn worst_row(program: &RatioProgram, ratio: f64, among: impl Fn(&Demand) -> bool) -> Option<(Laurent, f64)> {
    program.most_violated(|index, Limited { asked, .. }| {
        if !matches!(asked.limit.class, Class::Convex | Class::ReverseConvex) || !among(&asked.demand) {
            return None;
        }
        let (polynomial, _) = program.polynomial_at(index, ratio)?;
        Some((polynomial, program.excess(index, polynomial.at(ratio), ratio)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_proof_is_complete_and_tight() {
        assert!(is_proof(true, 0.0) && is_proof(true, GAP_TOLERANCE));
        assert!(!is_proof(true, 1.001 * GAP_TOLERANCE) && !is_proof(false, 0.0) && !is_proof(false, 1.0));
        assert!(!is_proof(true, f64::NAN));
    }

    /// The heap gives the least bound first, and of equal ones the leftmost.
    #[test]
    fn the_most_promising_interval_comes_first() {
        let interval = |a: f64, bound: f64| Interval { a, b: a + 1.0, bound };
        let mut heap =
            BinaryHeap::from([interval(3.0, 2.0), interval(2.0, 1.0), interval(1.0, 1.0), interval(0.0, 5.0)]);
        let order: Vec<f64> = std::iter::from_fn(|| heap.pop().map(|i| i.a)).collect();
        assert_eq!(order, [1.0, 2.0, 3.0, 0.0]);
        assert!(interval(1.0, 2.0) == interval(1.0, 2.0) && interval(1.0, 2.0) != interval(1.0, 3.0));
        assert!(interval(1.0, 2.0) != interval(2.0, 2.0) && interval(1.0, 2.0) > interval(1.0, 3.0));
    }
}
