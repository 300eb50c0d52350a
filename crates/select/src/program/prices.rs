//! What one more unit of a limit is worth.
//!
//! With one ratio to choose, a limit has a price only where N* stands at an end of its window that the
//! limit sets and the objective would go on beyond it: `∂f*/∂b = f'(N*) dN_end/db`, with
//! `dN_end/db = 1/g'(N*)` for a row `g(N) ≤ b`. The multiplier of the row is `−f'/g'`. Inside the window
//! nothing binds, and every price is zero.

use super::objective::Goal;
use super::{Asked, End, RatioProgram, ShadowPrice, Window};
use crate::evaluate::violation;
use gearwise_model::actuator::Laurent;

/// The prices of the limits that bind at a ratio.
pub(super) fn at(
    program: &RatioProgram,
    goal: &Goal,
    windows: &[Window],
    ratio: f64,
    low: &End,
    high: &End,
) -> Vec<ShadowPrice> {
    let value = goal.value(ratio);
    let natural = goal.natural(value);
    // Slope of the objective in its own unit: the cuts may be in its square.
    let per_cut = goal.natural_slope(value);
    let near = |end: f64| (ratio - end).abs() <= 1e-9 * ratio;
    let mut prices: Vec<ShadowPrice> = Vec::new();
    for window in windows {
        for (end, inwards, bind, range) in [(window.min, 1.0, &window.low, low), (window.max, -1.0, &window.high, high)]
        {
            if !near(end) {
                continue;
            }
            let slope = per_cut * goal.cut(ratio * (1.0 + inwards * 1e-9)).slope(ratio);
            // The end matters only where the objective would go on beyond it.
            if slope * inwards <= 0.0 {
                continue;
            }
            let (ratio_per_bound, bound) = if bind.limit == range.bind.limit {
                (range.ratio_per_bound, range.bound)
            } else {
                let named = program.limits.iter().enumerate().filter(|(_, l)| l.asked.limit.name == bind.limit);
                // The same limit may stand there for several sets of numbers: the one that binds.
                let found =
                    named.filter_map(|(i, l)| Some((program.polynomial_at(i, ratio)?.0, l.asked))).max_by(|a, b| {
                        let excess = |(row, asked): &(Laurent, &Asked)| violation(row.at(ratio), asked.raw_bound());
                        excess(a).total_cmp(&excess(b))
                    });
                let Some((row, asked)) = found else { continue };
                let raw_per_bound =
                    if asked.squared { 2.0 * asked.bound / asked.factor.powi(2) } else { 1.0 / asked.factor };
                (raw_per_bound / row.slope(ratio), asked.bound)
            };
            let price = slope * ratio_per_bound;
            if price != 0.0 && price.is_finite() && !prices.iter().any(|p| p.limit == bind.limit) {
                let elasticity = if natural == 0.0 { 0.0 } else { price * bound / natural };
                prices.push(ShadowPrice { limit: bind.limit, price, elasticity });
            }
        }
    }
    prices
}
