//! A polynomial of the ratio from below, on an interval.
//!
//! The one idea: concave terms are above their secants between the ends, so what is left is convex and meets the
//! polynomial at both ends.

use gearwise_model::actuator::Laurent;

/// A convex function `Σ c_j N^j + slope N + constant`, all `c_j ≥ 0`, below a polynomial on an interval.
#[derive(Debug, Clone, Copy)]
pub(super) struct Underestimator {
    convex: [(f64, i32); 5],
    slope: f64,
    constant: f64,
    /// Sum of the magnitudes of all terms at their worst: what rounding is measured by.
    pub(super) size: f64,
}

const CONVEX_POWERS: [i32; 5] = [-2, -1, 2, 3, 4];

impl Underestimator {
    /// Of a polynomial on `[a, b]`, 0 < a ≤ b.
    pub(super) fn new(polynomial: &Laurent, a: f64, b: f64) -> Underestimator {
        let mut under =
            Underestimator { convex: [(0.0, 1); 5], slope: polynomial[1], constant: polynomial[0], size: 0.0 };
        under.size = polynomial[0].abs() + polynomial[1].abs() * b;
        for (i, power) in CONVEX_POWERS.into_iter().enumerate() {
            let c = polynomial[power];
            under.size += c.abs() * a.powi(power).max(b.powi(power));
            if c >= 0.0 {
                under.convex[i] = (c, power);
                continue;
            }
            // Concave: on the interval it is above its secant.
            let (at_a, at_b) = (c * a.powi(power), c * b.powi(power));
            let slope = if b > a { (at_b - at_a) / (b - a) } else { 0.0 };
            under.slope += slope;
            under.constant += at_a - slope * a;
        }
        under
    }

    pub(super) fn at(&self, n: f64) -> f64 {
        self.convex.iter().map(|(c, p)| c * n.powi(*p)).sum::<f64>() + self.slope * n + self.constant
    }

    fn derivative(&self, n: f64) -> f64 {
        self.convex.iter().map(|(c, p)| f64::from(*p) * c * n.powi(p - 1)).sum::<f64>() + self.slope
    }

    /// Where it is least on `[a, b]`.
    pub(super) fn minimum(&self, a: f64, b: f64) -> f64 {
        if self.derivative(a) >= 0.0 {
            return a;
        }
        if self.derivative(b) <= 0.0 {
            return b;
        }
        let (mut low, mut high) = (a, b);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.derivative(middle) < 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// The part of `[a, b]` on which it is at most `bound`, a little too wide; `None` if empty.
    pub(super) fn below(&self, bound: f64, a: f64, b: f64) -> Option<(f64, f64)> {
        let slack = 1e-14 * self.size;
        let least = self.minimum(a, b);
        if self.at(least) > bound + slack {
            return None;
        }
        let end = |outside: f64| {
            if self.at(outside) <= bound + slack {
                return outside;
            }
            let (mut bad, mut good) = (outside, least);
            for _ in 0..50 {
                let middle = 0.5 * (bad + good);
                if self.at(middle) > bound + slack { bad = middle } else { good = middle }
            }
            bad
        };
        Some((end(a), end(b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Random polynomials: the underestimate is convex, below, equal at the ends, least where a scan says, and the
    /// part on which it keeps a bound is that part.
    #[test]
    fn underestimates_are_below_and_as_near_as_secants_are() {
        let mut random = Pcg64::seed_from_u64(5);
        let (mut parts, mut empty) = (0, 0);
        for _ in 0..300 {
            let middle = 10.0_f64.powf(random.random_range(-1.0..2.0));
            let (a, b) = (middle, middle * random.random_range(1.01..20.0));
            let terms: Vec<(f64, i32)> =
                (-2..=4).map(|p| (random.random_range(-1.0..1.0) * middle.powi(-p), p)).collect();
            let polynomial =
                terms.iter().map(|(c, p)| Laurent::monomial(*c, *p)).fold(Laurent::default(), |x, y| x + y);
            let under = Underestimator::new(&polynomial, a, b);
            let largest = |n: f64| terms.iter().map(|(c, p)| (c * n.powi(*p)).abs()).sum::<f64>();
            let size = largest(a).max(largest(b));
            // Every term at its worst end.
            let worst: f64 = terms.iter().map(|(c, p)| c.abs() * a.powi(*p).max(b.powi(*p))).sum();
            assert!((under.size / worst - 1.0).abs() < 1e-12);
            // Concave terms are on their secants: the ends are met.
            for end in [a, b] {
                assert!((under.at(end) - polynomial.at(end)).abs() <= 1e-12 * size);
            }
            let grid: Vec<f64> = (0..=600).map(|k| (a + (b - a) * f64::from(k) / 600.0).min(b)).collect();
            for n in &grid {
                // Term by term: convex ones as they are, the others on their secant between the ends.
                let by_hand: f64 = terms
                    .iter()
                    .map(|(c, p)| {
                        let at = |n: f64| c * n.powi(*p);
                        if *c >= 0.0 || *p == 0 || *p == 1 {
                            at(*n)
                        } else {
                            at(a) + (at(b) - at(a)) * (n - a) / (b - a)
                        }
                    })
                    .sum();
                assert!((under.at(*n) - by_hand).abs() <= 1e-11 * size, "{} {by_hand}", under.at(*n));
                assert!(under.at(*n) <= polynomial.at(*n) + 1e-12 * size);
            }
            let least = under.minimum(a, b);
            let scanned = grid.iter().map(|n| under.at(*n)).fold(f64::INFINITY, f64::min);
            assert!(least >= a && least <= b && under.at(least) <= scanned + 1e-13 * size);
            // Within half a step of the grid's best.
            let bound =
                under.at(least) + random.random_range(-0.2..1.0) * (under.at(a).max(under.at(b)) - under.at(least));
            match under.below(bound, a, b) {
                None => {
                    empty += 1;
                    assert!(under.at(least) > bound);
                }
                Some((start, end)) => {
                    parts += 1;
                    assert!(start >= a && end <= b && start <= end);
                    for n in &grid {
                        let inside = *n >= start && *n <= end;
                        assert!(inside || under.at(*n) > bound - 1e-12 * size);
                        assert!(!inside || under.at(*n) <= bound + 1e-9 * size, "{n} in {start} {end}");
                    }
                }
            }
        }
        assert!(parts > 150 && empty > 20, "{parts} {empty}");
        // An interval of one ratio.
        let point = Underestimator::new(&Laurent::monomial(-2.0, 2), 3.0, 3.0);
        assert_eq!(
            (point.at(3.0), point.minimum(3.0, 3.0), point.below(-18.0, 3.0, 3.0)),
            (-18.0, 3.0, Some((3.0, 3.0)))
        );
        assert_eq!(point.below(-18.1, 3.0, 3.0), None);
    }
}
