//! A polynomial in N as a convex function of u = N² that touches it at one ratio and is nowhere above it
//! on an interval: concave terms become secants, odd convex ones tangents, `1/u`, `u` and `u²` stay.

use crate::actuator::Laurent;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::program::value;

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
