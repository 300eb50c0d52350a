//! Effects that are no polynomial of the ratio: every ratio is evaluated, at all samples.
//!
//! A grid shows windows and valleys, bisection and golden section refine them. What lies between two
//! points of the grid was not seen, so nothing is proved, and the certificate says which effect is the
//! reason. Prices are differences of evaluations.

use super::objective::Goal;
use super::{Certificate, End, Optimum, Outcome, RatioProgram, Refusal, ShadowPrice, Unsolved, Window, scan};
use gearwise_model::actuator::fitted::why_evaluated;
use gearwise_model::numerics::work;

/// Relative step of the differences.
const STEP: f64 = 1e-6;

pub(super) fn solve(program: &RatioProgram) -> Outcome {
    let (low, high) = match program.ends() {
        Ok(ends) => ends,
        Err(infeasible) => return Err(Refusal::Infeasible(infeasible)),
    };
    let goal = Goal::new(program);
    let found = scan::scan(program, &goal, &low, &high);
    let ratio = match found.best {
        Ok(ratio) => ratio,
        Err(_) if work::is_spent() => return Err(Refusal::NotSolved(Unsolved::NothingRuledOut)),
        Err(why) => return Err(Refusal::Infeasible(why)),
    };
    let objective = goal.natural(goal.value(ratio));
    Ok(Optimum {
        ratio,
        objective,
        shadow_prices: prices(program, &goal, &found.windows, ratio, &low, &high),
        windows: found.windows,
        certificate: Certificate::NotCertified(why_evaluated(program.prepared.candidate.motor).into()),
    })
}

/// The prices of the limits that end the window where N* stands.
pub(super) fn prices(
    program: &RatioProgram,
    goal: &Goal,
    windows: &[Window],
    ratio: f64,
    low: &End,
    high: &End,
) -> Vec<ShadowPrice> {
    let natural = |n: f64| goal.natural(goal.value(n));
    let difference =
        |f: &dyn Fn(f64) -> f64| (f(ratio * (1.0 + STEP)) - f(ratio * (1.0 - STEP))) / (2.0 * STEP * ratio);
    let mut prices: Vec<ShadowPrice> = Vec::new();
    for window in windows {
        for (end, inwards, bind, range) in [(window.min, 1.0, &window.low, low), (window.max, -1.0, &window.high, high)]
        {
            if (ratio - end).abs() > 1e-9 * ratio || prices.iter().any(|p| p.limit == bind.limit) {
                continue;
            }
            let slope = difference(&natural);
            if slope * inwards <= 0.0 {
                continue;
            }
            let (ratio_per_bound, bound) = if bind.limit == range.bind.limit {
                (range.ratio_per_bound, range.bound)
            } else {
                let Some(limited) = program.limits.iter().find(|l| l.asked.limit.name == bind.limit) else { continue };
                let demand = |n: f64| limited.asked.natural(limited.asked.raw_demand(limited.candidate, n).0);
                (1.0 / difference(&demand), limited.asked.bound)
            };
            let (price, value) = (slope * ratio_per_bound, natural(ratio));
            if price != 0.0 && price.is_finite() {
                let elasticity = if value == 0.0 { 0.0 } else { price * bound / value };
                prices.push(ShadowPrice { limit: bind.limit, price, elasticity });
            }
        }
    }
    prices
}
