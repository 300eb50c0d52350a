//! Laurent polynomials in the ratio N, powers −2 to 4: what every limit of the model is made of.

use std::ops::{Add, Index, Mul};

/// Lowest power.
const LOW: i32 = -2;
/// Number of powers: N⁻² … N⁴.
const POWERS: usize = 7;

/// `Σ c_j N^j`, j = −2 … 4.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Laurent([f64; POWERS]);

impl Laurent {
    /// `c N^power`.
    ///
    /// # Panics
    /// If the power is outside −2 … 4.
    pub fn monomial(coefficient: f64, power: i32) -> Laurent {
        let mut c = [0.0; POWERS];
        c[usize::try_from(power - LOW).expect("power at least -2")] = coefficient;
        Laurent(c)
    }

    /// `inverse/N + constant + linear N`.
    #[inline]
    pub fn of_terms(inverse: f64, constant: f64, linear: f64) -> Laurent {
        Laurent([0.0, inverse, constant, linear, 0.0, 0.0, 0.0])
    }

    /// A constant.
    #[inline]
    pub fn constant(value: f64) -> Laurent {
        Laurent::monomial(value, 0)
    }

    /// The coefficient of a power; zero of one that it cannot have.
    pub fn coefficient(&self, power: i32) -> f64 {
        usize::try_from(power - LOW).ok().and_then(|j| self.0.get(j)).copied().unwrap_or(0.0)
    }

    /// The value at a ratio.
    #[inline]
    pub fn at(&self, ratio: f64) -> f64 {
        let c = &self.0;
        let polynomial = c[2] + ratio * (c[3] + ratio * (c[4] + ratio * (c[5] + ratio * c[6])));
        polynomial + (c[1] + c[0] / ratio) / ratio
    }

    /// The derivative with respect to N at a ratio.
    pub fn slope(&self, ratio: f64) -> f64 {
        (0..POWERS).map(|j| (j as i32 + LOW, self.0[j])).map(|(p, c)| f64::from(p) * c * ratio.powi(p - 1)).sum()
    }

    /// The square.
    ///
    /// # Panics
    /// As the product.
    #[inline]
    pub fn squared(&self) -> Laurent {
        match self.0 {
            // What is linear in features has these powers alone.
            [0.0, a, b, c, 0.0, 0.0, 0.0] => {
                Laurent([a * a, 2.0 * (a * b), a * c + b * b + c * a, 2.0 * (b * c), c * c, 0.0, 0.0])
            }
            _ => *self * *self,
        }
    }

    /// Whether only the powers −2, 0, 2, 4 occur and those of −2 and 4 are not negative: then the
    /// polynomial is convex in `u = N²`, and `w u ≥ 1`, `t ≥ u²` relax it exactly.
    pub fn is_convex_in_square(&self) -> bool {
        let c = &self.0;
        c[1] == 0.0 && c[3] == 0.0 && c[5] == 0.0 && c[0] >= 0.0 && c[6] >= 0.0
    }

    /// Coefficients of `w = 1/u`, 1, `u = N²` and `t = u²`.
    ///
    /// # Panics
    /// If an odd power occurs.
    pub fn in_square(&self) -> [f64; 4] {
        let c = &self.0;
        assert!(c[1] == 0.0 && c[3] == 0.0 && c[5] == 0.0, "odd powers of N have no place in the conic program");
        [c[0], c[2], c[4], c[6]]
    }

    /// Sum of the magnitudes of all terms at a ratio: what can cancel in the value.
    pub fn size(&self, ratio: f64) -> f64 {
        Laurent(self.0.map(f64::abs)).at(ratio)
    }
}

impl Index<i32> for Laurent {
    type Output = f64;

    fn index(&self, power: i32) -> &f64 {
        &self.0[(power - LOW) as usize]
    }
}

impl Add for Laurent {
    type Output = Laurent;

    #[inline]
    fn add(mut self, other: Laurent) -> Laurent {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += b;
        }
        self
    }
}

impl Mul<f64> for Laurent {
    type Output = Laurent;

    #[inline]
    fn mul(self, factor: f64) -> Laurent {
        Laurent(self.0.map(|c| c * factor))
    }
}

impl Mul for Laurent {
    type Output = Laurent;

    /// # Panics
    /// If the product has a power outside −2 … 4.
    fn mul(self, other: Laurent) -> Laurent {
        let mut product = [0.0; POWERS];
        for (i, a) in self.0.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            for (j, b) in other.0.iter().enumerate().filter(|(_, b)| **b != 0.0) {
                let power = (i + j) as i32 + 2 * LOW;
                product[usize::try_from(power - LOW).expect("power at least -2")] += a * b;
            }
        }
        Laurent(product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn products_and_slopes() {
        let p = Laurent::monomial(2.0, -1) + Laurent::constant(3.0) + Laurent::monomial(-1.0, 1);
        let n = 1.7;
        let direct = |n: f64| 2.0 / n + 3.0 - n;
        assert_relative_eq!(p.at(n), direct(n), max_relative = 1e-14);
        assert_relative_eq!(p.squared().at(n), direct(n).powi(2), max_relative = 1e-13);
        let h = 1e-6;
        assert_relative_eq!(
            p.squared().slope(n),
            (direct(n + h).powi(2) - direct(n - h).powi(2)) / (2.0 * h),
            max_relative = 1e-7
        );
        assert_relative_eq!(p.size(n), 2.0 / n + 3.0 + n, max_relative = 1e-14);
    }
}
