//! A polynomial in N as a convex function of u = N² that touches it at one ratio and is nowhere above it
//! on an interval: concave terms become secants, odd convex ones tangents, `1/u`, `u` and `u²` stay.

use crate::program::{RatioProgram, minimise, value};
use gearwise_model::actuator::Laurent;
use gearwise_model::numerics::line_search::least_in_range;

/// How often a range of ratios is divided at most.
const DIVISIONS: usize = 200;
/// Polynomials that are followed at most to where a function is least, and ratios that are one.
const LEADS: usize = 12;
const NEAR: f64 = 1e-9;
/// A piece of ratios is settled where its bound is this near, relative to the size of its terms.
const SETTLED: f64 = 1e-11;

/// `c_w/u + c_0 + c_u u + c_t u²`, `c_w, c_t ≥ 0`.
pub(super) type Convex = [f64; 4];

/// Of a polynomial on the ratios `[low, high]`, touching it at `at` where its terms are convex.
pub(super) fn under(polynomial: &Laurent, (low, high): (f64, f64), at: f64) -> Convex {
    let (a, b, u) = (low * low, high * high, at * at);
    let mut sum = [0.0, polynomial[0], polynomial[2], 0.0];
    for power in [-2, -1, 1, 3, 4] {
        let c = polynomial[power];
        if c == 0.0 {
            continue;
        }
        match power {
            -2 if c > 0.0 => sum[0] += c,
            4 if c > 0.0 => sum[3] += c,
            _ => {
                // √u is concave, all others are convex.
                let convex = (c > 0.0) != (power == 1);
                let half = 0.5 * f64::from(power);
                let value = |u: f64| c * u.powf(half);
                let (slope, from) = match convex {
                    true => (c * half * u.powf(half - 1.0), u),
                    false if b > a => ((value(b) - value(a)) / (b - a), a),
                    false => (0.0, a),
                };
                sum[2] += slope;
                sum[1] += value(from) - slope * from;
            }
        }
    }
    sum
}

/// The sum of two, the second times a factor that is not negative.
pub(super) fn add(sum: &mut Convex, other: &Convex, factor: f64) {
    for (s, c) in sum.iter_mut().zip(other) {
        *s += factor * c;
    }
}

/// The least of a polynomial between two ratios, from below.
pub(super) fn least_over(polynomial: &Laurent, ratios: (f64, f64)) -> f64 {
    least_of_pieces(ratios, |(a, b)| (under(polynomial, (a, b), (a * b).sqrt()), Box::new(|n| polynomial.at(n))))
}

/// The least of what has a convex bound on each piece of some ratios, from below: pieces are divided until they are settled. `of` gives
/// the bound on a piece, and what it stands for.
pub(super) fn least_of_pieces<'o>(
    ratios: (f64, f64),
    of: impl Fn((f64, f64)) -> (Convex, Box<dyn Fn(f64) -> f64 + 'o>),
) -> f64 {
    let best = std::cell::Cell::new(f64::INFINITY);
    let settle = |(a, b): (f64, f64)| {
        let (least, here) = of((a, b));
        let u = minimise(&least, a * a, b * b);
        let size = value(&least.map(f64::abs), u);
        best.set(best.get().min(here(u.sqrt().clamp(a, b))).min(here((a * b).sqrt())));
        (value(&least, u) - 1e-14 * size, SETTLED * size, (a, b))
    };
    let mut open = vec![settle(ratios)];
    for _ in 0..DIVISIONS {
        let least = (0..open.len()).min_by(|a, b| open[*a].0.total_cmp(&open[*b].0)).unwrap_or(0);
        let (bound, near, (a, b)) = open[least];
        if best.get() - bound <= near || b <= a * (1.0 + 1e-12) {
            break;
        }
        let middle = (a * b).sqrt();
        open.swap_remove(least);
        open.extend([settle((a, middle)), settle((middle, b))]);
    }
    open.iter().map(|(bound, ..)| *bound).fold(f64::INFINITY, f64::min)
}

/// Where a function is least between two ratios: where polynomials lead that touch it and are nowhere above it, with what is `beside` them
/// and may have more than one valley; and where they lead back and forth, between these.
pub(super) fn lowest(
    (a, b): (f64, f64),
    cut: impl Fn(f64) -> Laurent,
    beside: Option<&dyn Fn(f64) -> f64>,
    value: impl Fn(f64) -> f64,
) -> f64 {
    if a >= b {
        return a;
    }
    let mut last = [a, b];
    let mut at = (a * b).sqrt();
    for _ in 0..LEADS {
        let cut = cut(at);
        let next = match beside {
            None => least_in_range(&|n: f64| cut.at(n), a, b),
            Some(beside) => {
                let of = |n: f64| cut.at(n) + beside(n);
                RatioProgram::least_over(&of, &[(a, b)]).map_or(at, |(ratio, _)| ratio)
            }
        };
        last = [at, next];
        if (next / at - 1.0).abs() < NEAR {
            return next;
        }
        at = next;
    }
    least_in_range(&value, last[0].min(last[1]), last[0].max(last[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_below_everywhere_and_touches() {
        for power in -2..=4 {
            for c in [-1.3, 0.7] {
                let polynomial = Laurent::monomial(c, power);
                let range = (2.0, 9.0);
                for at in [2.0, 4.4, 9.0] {
                    let under = under(&polynomial, range, at);
                    assert!(under[0] >= 0.0 && under[3] >= 0.0);
                    for i in 0..=70 {
                        let n = 2.0 + 0.1 * f64::from(i);
                        let (truth, bound) = (polynomial.at(n), value(&under, n * n));
                        assert!(bound <= truth + 1e-12 * (1.0 + truth.abs()), "{c} N^{power} at {n}: {bound} {truth}");
                    }
                }
            }
        }
    }
}
