//! Where the shaft's torque has a part that no ratio changes (Coulomb friction): the program along N itself.
//!
//! The one idea: a row `p(N) ≤ b` leaves parts of the ratios that end at roots of N² (p − b), exactly. Jumping from root to
//! root gives the first and the last ratio that keep all rows, and whatever lies outside is ruled out. A mean of losses is
//! convex in 1/N, whatever the sign of the term with 1/N: the least of its cuts over what is left is found by halving, and a
//! combination of two of them whose slopes cancel is the bound. Where any of this cannot be shown, nothing is claimed,
//! and the branch and bound goes on.

use super::objective::Goal;
use super::{
    Bind, Certificate, Class, End, GAP_TOLERANCE, Infeasible, Limited, Optimum, Outcome, ROW_TOLERANCE, RatioProgram,
    Refusal, Window, prices, scan,
};
use gearwise_model::actuator::Laurent;
use gearwise_model::actuator::limits::Demand;
use gearwise_model::actuator::shaft::{Feature, Flow};
use gearwise_model::actuator::waveform::Functional;
use gearwise_model::numerics::roots::{parts_below, sign_changes};
use gearwise_model::numerics::work;

/// More jumps than any set of rows has been seen to need.
const MAX_JUMPS: usize = 200;
/// More cuts than any objective has been seen to need.
const MAX_CUTS: usize = 60;
/// Halvings of a range of ratios.
const HALVINGS: usize = 200;
/// Pieces of a window in which temperature over the motion is looked at.
const PIECES: usize = 64;
/// So near (relative) to an end of the window temperature over the motion is not shown to be kept.
const NEAR_END: f64 = 0.01;

/// A row that is violated at some ratio.
struct Violated {
    index: usize,
    sample: Option<usize>,
    polynomial: Laurent,
    bound: f64,
}

/// Why a walk ended without a ratio.
enum Ended {
    /// No ratio keeps the limits.
    Refused(Infeasible),
    /// Nothing can be said.
    Unclear,
}

/// The optimum, or why there is none; `None` where it is not shown.
pub(super) fn solve(program: &RatioProgram) -> Option<Outcome> {
    let follows = |demand: &Demand| matches!(demand, Demand::MeanCurrentSquared(_));
    if program.limits.iter().any(|l| l.asked.limit.class == Class::ReverseConvex || follows(&l.asked.demand)) {
        return None;
    }
    let (low, high) = match program.ends() {
        Ok(ends) => ends,
        Err(infeasible) => return Some(Err(Refusal::Infeasible(infeasible))),
    };
    let window = match window(program, &low, &high) {
        Ok(window) => window,
        Err(Ended::Refused(infeasible)) => return Some(Err(Refusal::Infeasible(infeasible))),
        Err(Ended::Unclear) => return None,
    };
    if !is_whole(program, &window) {
        return None;
    }
    let goal = Goal::new(program);
    let (ratio, bound) = least(program, &goal, &window)?;
    let value = goal.value(ratio);
    if !(value.is_finite() && bound.is_finite()) || scan::worst(program, ratio).0 > 1e-8 {
        return None;
    }
    let reference = goal.reference(ratio, value);
    let gap = ((value - bound) / reference).max(0.0);
    if gap > GAP_TOLERANCE {
        return None;
    }
    let windows = vec![window];
    Some(Ok(Optimum {
        ratio,
        objective: goal.natural(value),
        shadow_prices: prices::at(program, &goal, &windows, ratio, &low, &high),
        windows,
        certificate: Certificate::Certified {
            lower_bound: goal.natural(bound.min(value)),
            gap,
            method: "convex in 1/N",
        },
    }))
}

/// The first and the last ratio that keep all rows.
fn window(program: &RatioProgram, low: &End, high: &End) -> Result<Window, Ended> {
    let (min, at_low) = walk(program, low, high, true)?;
    let (max, at_high) = walk(program, low, high, false)?;
    Ok(Window { min, max: max.max(min), low: at_low, high: at_high })
}

/// Jumps inwards from one end of the range until no row is violated.
fn walk(program: &RatioProgram, low: &End, high: &End, upwards: bool) -> Result<(f64, Bind), Ended> {
    let (first, last) = program.range;
    let from = if upwards { low } else { high };
    let (mut ratio, mut bind) = (from.ratio, from.bind.clone());
    let contradiction = |low: Bind, at_least: f64, high: Bind, at_most: f64| {
        Err(Ended::Refused(Infeasible::Contradiction { low, at_least, high, at_most }))
    };
    for _ in 0..MAX_JUMPS {
        if work::is_spent() {
            break;
        }
        let Some(row) = violated(program, ratio) else { return Ok((ratio, bind)) };
        let here = Bind::of(program.limits[row.index].asked.limit.name, row.sample);
        let parts = parts_below(&row.polynomial, row.bound, first, last);
        let (Some(lowest), Some(highest)) = (parts.first(), parts.last()) else {
            return Err(Ended::Refused(program.never(row.index)));
        };
        let next = match upwards {
            true => parts.iter().map(|part| part.0).find(|start| *start > ratio),
            false => parts.iter().rev().map(|part| part.1).find(|end| *end < ratio),
        };
        ratio = match next {
            Some(next) => next,
            // The row leaves only what others have ruled out.
            None if upwards && highest.1 <= ratio => return contradiction(bind, ratio, here, highest.1),
            None if !upwards && lowest.0 >= ratio => return contradiction(here, lowest.0, bind, ratio),
            None => return Err(Ended::Unclear),
        };
        if ratio > high.ratio * (1.0 + ROW_TOLERANCE) {
            return contradiction(here, ratio, high.bind.clone(), high.ratio);
        }
        if ratio < low.ratio * (1.0 - ROW_TOLERANCE) {
            return contradiction(low.bind.clone(), low.ratio, here, ratio);
        }
        ratio = ratio.clamp(low.ratio, high.ratio);
        bind = here;
    }
    Err(Ended::Unclear)
}

/// The most violated row at a ratio; a limit that takes a walk over all samples is looked at where the others are kept.
fn violated(program: &RatioProgram, ratio: f64) -> Option<Violated> {
    let among = |walks: bool| {
        let mut worst: Option<(f64, Violated)> = None;
        for (index, Limited { asked, .. }) in program.limits.iter().enumerate() {
            if asked.limit.class != Class::Convex || asked.demand.takes_a_walk() != walks {
                continue;
            }
            let Some((polynomial, sample)) = program.polynomial_at(index, ratio) else { continue };
            let bound = asked.raw_bound();
            let excess = program.excess(index, polynomial.at(ratio), ratio);
            if excess > ROW_TOLERANCE && worst.as_ref().is_none_or(|(most, _)| excess > *most) {
                worst = Some((excess, Violated { index, sample, polynomial, bound }));
            }
        }
        worst.map(|(_, row)| row)
    };
    among(false).or_else(|| among(true))
}

/// Whether every ratio of a window whose ends keep all rows does so, too.
fn is_whole(program: &RatioProgram, window: &Window) -> bool {
    let (a, b) = (window.min, window.max);
    let convex = program.limits.iter().filter(|l| l.asked.limit.class == Class::Convex);
    a == b || convex.into_iter().all(|limited| keeps_between(limited, a, b))
}

fn keeps_between(Limited { candidate, asked }: &Limited, a: f64, b: f64) -> bool {
    let bound = asked.raw_bound();
    let actuator = candidate.end(asked.end);
    let waveform = match asked.demand {
        Demand::Samples(_) => Some(&candidate.load.waveform),
        Demand::Bandwidth(_) => candidate.load.bandwidth.as_ref(),
        _ => None,
    };
    match asked.demand {
        Demand::Polynomial(polynomial, _) => is_below(&polynomial, bound, a, b),
        Demand::Samples(functional) | Demand::Bandwidth(functional) => {
            // Beyond its constant part the torque is monotone in N, or has its least magnitude where it has the sign of
            // the load: what is at most b ≥ |c| is one interval.
            let form = actuator.torque_form(Flow::Driving);
            let constant = form[Feature::Sign].abs() + form[Feature::One].abs();
            if functional == Functional::TorqueSquared && bound >= constant * constant {
                return true;
            }
            let Some(waveform) = waveform else { return true };
            let points = (0..waveform.len()).map(|k| waveform.point(k));
            let windings = functional.windings(actuator);
            let of_point = |point| windings.iter().map(move |winding| functional.polynomial(winding, &point, a));
            let mut rows = points.flat_map(of_point);
            !functional.touches(actuator) && rows.all(|row| is_below(&row, bound, a, b))
        }
        Demand::WindingPeak(node) => {
            let mut open = vec![(a, b)];
            for _ in 0..PIECES {
                let Some((from, to)) = open.pop() else { return true };
                if work::is_spent() {
                    return false;
                }
                let at_an_end = to <= a * (1.0 + NEAR_END) || from >= b * (1.0 - NEAR_END);
                if at_an_end
                    || asked.load(candidate).winding_peak_stays_within(actuator, &node, (from, to), asked.bound)
                {
                    continue;
                }
                let middle = (from * to).sqrt();
                open.extend([(from, middle), (middle, to)]);
            }
            false
        }
        _ => true,
    }
}

/// Whether a row whose ends are kept is kept between them: it is convex in N or in 1/N there, or its roots say so.
fn is_below(row: &Laurent, bound: f64, a: f64, b: f64) -> bool {
    let is_positive = |power| row[power] >= 0.0;
    let shared = is_positive(-2) && is_positive(2) && is_positive(3) && is_positive(4);
    if shared && (is_positive(1) || is_positive(-1)) {
        return true;
    }
    // The largest that its terms allow.
    let most: f64 = (-2..=4).map(|p| (row[p] * a.powi(p)).max(row[p] * b.powi(p))).sum();
    let slack = 1e-9 * (bound.abs() + row.size(a).max(row.size(b)));
    if most <= bound + slack || is_convex_in_inverse(row, a, b) {
        return true;
    }
    matches!(parts_below(row, bound + slack, a, b).as_slice(), [(from, to)] if *from <= a && *to >= b)
}

/// Whether a polynomial is convex as a function of 1/N on an interval.
pub(super) fn is_convex_in_inverse(polynomial: &Laurent, a: f64, b: f64) -> bool {
    let p = |power: i32| polynomial[power];
    if [-2, 1, 2, 3, 4].into_iter().all(|power| p(power) >= 0.0) {
        return true;
    }
    // Its second derivative by 1/N, over N⁰: with N as a share of b.
    let curvature = [2.0 * p(-2), 0.0, 0.0, 2.0 * p(1), 6.0 * p(2), 12.0 * p(3), 20.0 * p(4)];
    let scaled: Vec<f64> = curvature.iter().enumerate().map(|(k, c)| c * b.powi(k as i32)).collect();
    let at = |x: f64| scaled.iter().rev().fold(0.0, |sum, c| sum * x + c);
    at(a / b) >= 0.0 && at(1.0) >= 0.0 && sign_changes(&scaled, a / b, 1.0).is_empty()
}

/// The best ratio of a window and what no ratio of it is below, in the unit of the cuts.
fn least(program: &RatioProgram, goal: &Goal, window: &Window) -> Option<(f64, f64)> {
    let mut best: Option<(f64, f64)> = None;
    let mut bound = f64::INFINITY;
    let mut start = window.min;
    for end in program.stage_ratios(window.min, window.max).into_iter().chain([window.max]) {
        let (ratio, below) = least_between(goal, start, end)?;
        // At its start a piece has the mass of the piece before, and that ratio is looked at by itself.
        bound = bound.min(below + goal.steps(end)).min(goal.value(start));
        for n in [start, ratio, end] {
            let value = goal.value(n);
            if value.is_finite() && best.is_none_or(|(_, least)| value < least) {
                best = Some((n, value));
            }
        }
        start = end;
    }
    best.map(|(ratio, _)| (ratio, bound))
}

/// The least of an objective without its steps between two ratios, by its cuts: the ratio, and what nothing is below.
fn least_between(goal: &Goal, a: f64, b: f64) -> Option<(f64, f64)> {
    let mut cuts: Vec<Laurent> = Vec::new();
    let mut ratio = (a * b).sqrt();
    let mut best = (ratio, f64::INFINITY);
    let mut bound = f64::NEG_INFINITY;
    for _ in 0..MAX_CUTS {
        let cut = goal.cut(ratio);
        if !is_convex_in_inverse(&cut, a, b) {
            return None;
        }
        let value = cut.at(ratio);
        if value < best.1 {
            best = (ratio, value);
        }
        let size = cut.size(ratio);
        cuts.push(cut);
        let (next, below) = least_of_cuts(&cuts, a, b);
        bound = bound.max(below - 1e-14 * size);
        if best.1 - bound <= 1e-12 * size.max(best.1.abs()) || next == ratio {
            break;
        }
        ratio = next;
    }
    Some((best.0, bound))
}

/// Where the largest of functions that are convex in 1/N is least on `[a, b]`, and a number that it is nowhere below.
fn least_of_cuts(cuts: &[Laurent], a: f64, b: f64) -> (f64, f64) {
    let largest = |n: f64| {
        let values = cuts.iter().map(|cut| (cut.at(n), cut));
        values.fold((f64::NEG_INFINITY, &cuts[0]), |most, here| if here.0 > most.0 { here } else { most })
    };
    let (at_a, of_a) = largest(a);
    if of_a.slope(a) >= 0.0 || a == b {
        return (a, at_a);
    }
    let (at_b, of_b) = largest(b);
    if of_b.slope(b) <= 0.0 {
        return (b, at_b);
    }
    let (mut low, mut high) = (a, b);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if largest(middle).1.slope(middle) < 0.0 { low = middle } else { high = middle }
    }
    // One falls at the lower end and one rises at the upper: in a combination of both the slopes cancel. What is left of
    // them is worth no more than the way to the ends.
    let (falling, rising) = (largest(low).1, largest(high).1);
    let ratio = if largest(low).0 <= largest(high).0 { low } else { high };
    // d/d(1/N) = −N² d/dN.
    let slopes = [falling, rising].map(|cut| -ratio * ratio * cut.slope(ratio));
    let share = match slopes {
        [f, r] if f > 0.0 && r < 0.0 => r / (r - f),
        [f, r] if f.abs() <= r.abs() => 1.0,
        _ => 0.0,
    };
    let slope = share * slopes[0] + (1.0 - share) * slopes[1];
    let reach = (1.0 / a - 1.0 / ratio).max(1.0 / ratio - 1.0 / b);
    let value = share * falling.at(ratio) + (1.0 - share) * rising.at(ratio);
    (ratio, value - slope.abs() * reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Random sums of terms that are convex in 1/N, and the largest of several: a grid finds nothing below the bound, and
    /// nothing clearly better than the ratio.
    #[test]
    fn the_least_of_convex_cuts_is_that_of_a_grid() {
        let mut random = Pcg64::seed_from_u64(3);
        for _ in 0..500 {
            let middle = 10.0_f64.powf(random.random_range(0.0..2.0));
            let (a, b) = (middle / random.random_range(1.0..30.0), middle * random.random_range(1.0..30.0));
            let one = |random: &mut Pcg64| {
                let term = |c: f64, p: i32| Laurent::monomial(c * middle.powi(-p), p);
                term(random.random_range(0.0..1.0), -2)
                    + term(random.random_range(-2.0..2.0), -1)
                    + Laurent::constant(random.random_range(-1.0..1.0))
                    + term(random.random_range(0.0..1.0), 1)
                    + term(random.random_range(0.0..1.0), 2)
            };
            let cuts: Vec<Laurent> = (0..random.random_range(1..4)).map(|_| one(&mut random)).collect();
            assert!(cuts.iter().all(|cut| is_convex_in_inverse(cut, a, b)));
            let (ratio, bound) = least_of_cuts(&cuts, a, b);
            let value = |n: f64| cuts.iter().map(|c| c.at(n)).fold(f64::NEG_INFINITY, f64::max);
            let size = cuts.iter().map(|c| c.size(ratio)).fold(0.0, f64::max);
            assert!(value(ratio) - bound <= 1e-9 * size, "gap {}", value(ratio) - bound);
            let grid = (0..=4000).map(|k| value(a * (b / a).powf(f64::from(k) / 4000.0)));
            let least = grid.fold(f64::INFINITY, f64::min);
            assert!(bound <= least + 1e-12 * size && value(ratio) <= least + 1e-9 * size, "{bound} {least}");
        }
    }

    #[test]
    fn what_bends_the_other_way_is_not_called_convex() {
        // −N is concave in 1/N; 1/N² outweighs it at small ratios only.
        let bent = Laurent::monomial(1.0, -2) + Laurent::monomial(-1.0, 1);
        assert!(is_convex_in_inverse(&bent, 0.1, 0.99) && !is_convex_in_inverse(&bent, 0.1, 1.1));
        assert!(!is_convex_in_inverse(&Laurent::monomial(-1.0, -2), 1.0, 2.0));
        // A row with a hill between two ratios that keep it.
        let hill = Laurent::constant(1.0) + Laurent::monomial(-0.1, 2) + Laurent::monomial(0.5, 1);
        assert!(!is_below(&hill, 1.2, 0.4, 4.6) && is_below(&hill, 1.7, 0.4, 4.6));
    }
}
