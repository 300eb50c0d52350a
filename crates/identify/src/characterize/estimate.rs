//! A number with its uncertainty, and how uncertainties combine.
//!
//! The one idea: a standard uncertainty is worth what its degrees of freedom are worth, so the two travel
//! together, and the interval of 95 % is Student's. Combination follows the GUM (JCGM 100:2008, sections 5.1.2
//! and G.4), with the plain worst case beside it.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// A number, its standard uncertainty and how many degrees of freedom that rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The number, SI.
    pub value: f64,
    /// Standard uncertainty, in the unit of the number.
    pub standard_uncertainty: f64,
    /// Degrees of freedom of the uncertainty; infinite where it is known.
    pub freedom: f64,
}

/// How the uncertainties of several numbers combine into that of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Combination {
    /// Independent: the root of the sum of squares.
    RootSumSquare,
    /// Worst case: all off to the same side, the sum.
    Linear,
}

impl Combination {
    /// Both, with their names.
    pub const NAMES: &[(&str, Combination)] =
        &[("root sum square", Combination::RootSumSquare), ("linear sum", Combination::Linear)];
}

/// Quantile of Student's distribution with `freedom` degrees of freedom (the normal one where infinite).
pub(crate) fn quantile(probability: f64, freedom: f64) -> f64 {
    if freedom.is_finite() && freedom < 1e6 {
        // Less than one degree of freedom says nothing that one would not.
        StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(f64::NAN, |d| d.inverse_cdf(probability))
    } else {
        Normal::new(0.0, 1.0).map_or(f64::NAN, |d| d.inverse_cdf(probability))
    }
}

/// Chance of less, by Student's distribution with `freedom` degrees of freedom.
fn probability(of: f64, freedom: f64) -> f64 {
    if freedom.is_finite() && freedom < 1e6 {
        StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(f64::NAN, |d| d.cdf(of))
    } else {
        Normal::new(0.0, 1.0).map_or(f64::NAN, |d| d.cdf(of))
    }
}

impl Estimate {
    /// A number that is known exactly.
    pub fn exact(value: f64) -> Estimate {
        Estimate { value, standard_uncertainty: 0.0, freedom: f64::INFINITY }
    }

    /// A number with the half-width of its interval of 95 %.
    pub fn stated(value: f64, half_width: f64) -> Estimate {
        Estimate { value, standard_uncertainty: half_width / quantile(0.975, f64::INFINITY), freedom: f64::INFINITY }
    }

    /// Half-width of the interval of 95 %.
    pub fn half_width(&self) -> f64 {
        quantile(0.975, self.freedom) * self.standard_uncertainty
    }

    /// The interval of 95 %.
    pub fn interval(&self) -> (f64, f64) {
        (self.value - self.half_width(), self.value + self.half_width())
    }

    /// Half-width over value.
    pub fn relative(&self) -> f64 {
        self.half_width() / self.value.abs()
    }

    /// The number in another unit.
    pub fn scaled(&self, factor: f64) -> Estimate {
        Estimate {
            value: self.value * factor,
            standard_uncertainty: self.standard_uncertainty * factor.abs(),
            freedom: self.freedom,
        }
    }

    /// A result of independent numbers, each with the derivative of the result by it. Degrees of freedom by
    /// Welch and Satterthwaite.
    pub fn combined(value: f64, parts: &[(f64, Estimate)]) -> Estimate {
        let shares: Vec<(f64, f64)> =
            parts.iter().map(|(slope, e)| ((slope * e.standard_uncertainty).powi(2), e.freedom)).collect();
        let variance: f64 = shares.iter().map(|s| s.0).sum();
        let spread: f64 = shares.iter().map(|(v, freedom)| v * v / freedom).sum();
        let freedom = if spread > 0.0 { variance * variance / spread } else { f64::INFINITY };
        Estimate { value, standard_uncertainty: variance.sqrt(), freedom }
    }
}

/// Half-width of a result from the half-widths of its numbers, each with the derivative of the result by it.
///
/// ```
/// use gearwise_identify::characterize::estimate::{Combination, combine};
/// // J_m = (J_r − J_nr)/N² with (6.55 ± 0.95)e-4 and (1.48 ± 0.08)e-4 behind 7.5:1 (Urs et al.).
/// let parts = [(1.0 / 56.25, 0.95e-4), (-1.0 / 56.25, 0.08e-4)];
/// assert!((combine(Combination::RootSumSquare, &parts) - 1.69e-6).abs() < 1e-8);
/// assert!((combine(Combination::Linear, &parts) - 1.83e-6).abs() < 1e-8);
/// ```
pub fn combine(how: Combination, parts: &[(f64, f64)]) -> f64 {
    let terms = parts.iter().map(|(slope, half)| (slope * half).abs());
    match how {
        Combination::RootSumSquare => terms.map(|t| t * t).sum::<f64>().sqrt(),
        Combination::Linear => terms.sum(),
    }
}

/// Rotor inertia behind a gear from the inertias at the output with and without it:
/// `J_m = (J_r − J_nr)/N²` \[kg·m²\] (Urs et al., section IV).
pub fn rotor_inertia(with_rotor: Estimate, without_rotor: Estimate, ratio: f64) -> Estimate {
    let k = 1.0 / (ratio * ratio);
    Estimate::combined(k * (with_rotor.value - without_rotor.value), &[(k, with_rotor), (-k, without_rotor)])
}

/// Inertia of a thin ring, `m r²` \[kg·m²\].
pub fn thin_ring(mass: Estimate, radius: Estimate) -> Estimate {
    let (m, r) = (mass.value, radius.value);
    Estimate::combined(m * r * r, &[(r * r, mass), (2.0 * m * r, radius)])
}

/// Derivatives of [`thin_ring`] by mass and radius.
pub fn thin_ring_slopes(mass: f64, radius: f64) -> [f64; 2] {
    [radius * radius, 2.0 * mass * radius]
}

/// Motor constant `K_M = √(K_T K_B/R)` \[N·m/√W\].
pub fn motor_constant(torque: Estimate, back_emf: Estimate, resistance: Estimate) -> Estimate {
    let value = (torque.value * back_emf.value / resistance.value).sqrt();
    let [t, b, r] = motor_constant_slopes(torque.value, back_emf.value, resistance.value);
    Estimate::combined(value, &[(t, torque), (b, back_emf), (r, resistance)])
}

/// Derivatives of [`motor_constant`] by K_T, K_B and R.
pub fn motor_constant_slopes(torque: f64, back_emf: f64, resistance: f64) -> [f64; 3] {
    let half = 0.5 * (torque * back_emf / resistance).sqrt();
    [half / torque, half / back_emf, -half / resistance]
}

/// `a/b − 1`.
pub fn discrepancy(a: Estimate, b: Estimate) -> Estimate {
    Estimate::combined(a.value / b.value - 1.0, &[(1.0 / b.value, a), (-a.value / (b.value * b.value), b)])
}

/// What is only known to lie between estimates: the interval holds it in 95 of 100 cases wherever it lies, be it at an
/// end (Imbens and Manski, 2004). At an end one side alone can miss, so that it reaches beyond both ends by less than
/// two standard uncertainties; where the ends are alike it is the plain interval. Not a number of nothing.
pub fn bracket(ends: &[Estimate]) -> Estimate {
    if let [first, others @ ..] = ends
        && others.iter().all(|e| e == first)
    {
        return *first;
    }
    let (low, high) =
        ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(e.value), h.max(e.value)));
    let widest = ends.iter().map(|e| e.standard_uncertainty).fold(0.0, f64::max);
    let freedom = ends.iter().map(|e| e.freedom).fold(f64::INFINITY, f64::min);
    let apart = (high - low) / widest.max(f64::MIN_POSITIVE);
    // Chance of holding an end, by how far it reaches beyond.
    let holds = |c: f64| probability(c + apart, freedom) - probability(-c, freedom);
    let (mut near, mut far) = (quantile(0.95, freedom), quantile(0.975, freedom));
    for _ in 0..60 {
        let middle = 0.5 * (near + far);
        if holds(middle) < 0.95 { near = middle } else { far = middle }
    }
    Estimate::stated(0.5 * (low + high), 0.5 * (high - low) + far * widest)
}

/// The numbers of several logs as one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pooled {
    /// Their mean, whose uncertainty has the spread between logs in it.
    pub estimate: Estimate,
    /// Standard deviation between logs beyond what each states, in the unit of the number.
    pub between: f64,
    /// How many logs.
    pub count: usize,
}

/// Random effects: each log has its own true value (mounting, zero, gain of that day), and the mean of those is
/// wanted. Spread between logs by DerSimonian and Laird (1986), interval by Hartung and Knapp (2001); never
/// narrower than the logs' own uncertainties allow. One log stands for itself. `None` where there is none.
pub fn pool(logs: &[Estimate]) -> Option<Pooled> {
    let first = logs.first()?;
    if logs.len() == 1 {
        return Some(Pooled { estimate: *first, between: 0.0, count: 1 });
    }
    let count = logs.len() as f64;
    let weighted = |between: f64| {
        // A variance of zero (a simulated log) would take all the weight.
        let weights: Vec<f64> = logs
            .iter()
            .map(|e| 1.0 / (e.standard_uncertainty.powi(2) + between).max(1e-24 * e.value * e.value))
            .collect();
        let sum: f64 = weights.iter().sum();
        let mean = logs.iter().zip(&weights).map(|(e, w)| w * e.value).sum::<f64>() / sum;
        let squares: f64 = logs.iter().zip(&weights).map(|(e, w)| w * (e.value - mean).powi(2)).sum();
        (weights, sum, mean, squares)
    };
    let (weights, sum, _, squares) = weighted(0.0);
    let scale = sum - weights.iter().map(|w| w * w).sum::<f64>() / sum;
    let between = if scale > 0.0 { ((squares - (count - 1.0)) / scale).max(0.0) } else { 0.0 };
    let (_, sum, mean, squares) = weighted(between);
    let knapp =
        Estimate { value: mean, standard_uncertainty: (squares / ((count - 1.0) * sum)).sqrt(), freedom: count - 1.0 };
    let own = Estimate { value: mean, standard_uncertainty: sum.powf(-0.5), freedom: f64::INFINITY };
    let estimate = if knapp.half_width() >= own.half_width() { knapp } else { own };
    Some(Pooled { estimate, between: between.sqrt(), count: logs.len() })
}

/// A fit by ordinary least squares.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Coefficients in the order of the columns.
    pub coefficients: Vec<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// What is left.
    pub residuals: Vec<f64>,
    /// Degrees of freedom.
    pub freedom: f64,
}

impl Fit {
    /// A coefficient with its uncertainty.
    pub fn estimate(&self, index: usize) -> Estimate {
        Estimate {
            value: self.coefficients[index],
            standard_uncertainty: self.covariance[(index, index)].max(0.0).sqrt(),
            freedom: self.freedom,
        }
    }

    /// How many standard uncertainties a coefficient is from zero.
    pub fn ratio(&self, index: usize) -> f64 {
        self.coefficients[index] / self.covariance[(index, index)].max(f64::MIN_POSITIVE).sqrt()
    }

    /// Sum of the squares of what is left.
    pub fn squares(&self) -> f64 {
        self.residuals.iter().map(|r| r * r).sum()
    }
}

/// Fits `y` by columns; `None` where they cannot be told apart or nothing is left to judge by.
pub fn least_squares(columns: &[Vec<f64>], y: &[f64]) -> Option<Fit> {
    let (n, k) = (y.len(), columns.len());
    if n <= k || k == 0 {
        return None;
    }
    let scales: Vec<f64> = columns.iter().map(|c| c.iter().map(|v| v * v).sum::<f64>().sqrt()).collect();
    if scales.iter().any(|s| !s.is_finite() || *s == 0.0) {
        return None;
    }
    let x = DMatrix::from_fn(n, k, |r, c| columns[c][r] / scales[c]);
    let target = DVector::from_column_slice(y);
    let products = x.transpose() * &x;
    let smallest = products.clone().symmetric_eigenvalues().min();
    if smallest.is_nan() || smallest < 1e-10 {
        return None;
    }
    let inverse = products.cholesky()?.inverse();
    let scaled = &inverse * x.transpose() * &target;
    let residuals: Vec<f64> = (&target - &x * &scaled).iter().copied().collect();
    let freedom = (n - k) as f64;
    let variance = residuals.iter().map(|r| r * r).sum::<f64>() / freedom;
    let covariance = DMatrix::from_fn(k, k, |a, b| variance * inverse[(a, b)] / (scales[a] * scales[b]));
    let coefficients = scaled.iter().zip(&scales).map(|(c, s)| c / s).collect();
    Some(Fit { coefficients, covariance, residuals, freedom })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_line_has_the_errors_of_the_textbook() {
        // Draper and Smith: x 1…5, y by hand; slope 0.6, s² = 0.8, se(slope) = √(0.8/10).
        let x: Vec<f64> = (1..=5).map(f64::from).collect();
        let fit = least_squares(&[x, vec![1.0; 5]], &[2.0, 4.0, 5.0, 4.0, 5.0]).unwrap();
        assert_relative_eq!(fit.coefficients[0], 0.6, max_relative = 1e-12);
        assert_relative_eq!(fit.coefficients[1], 2.2, max_relative = 1e-12);
        assert_relative_eq!(fit.estimate(0).standard_uncertainty, (0.8_f64 / 10.0).sqrt(), max_relative = 1e-12);
        assert_relative_eq!(fit.estimate(0).half_width(), 3.182_446 * 0.08_f64.sqrt(), max_relative = 1e-6);
        assert!(least_squares(&[vec![1.0; 3], vec![2.0; 3]], &[1.0, 2.0, 3.0]).is_none());
    }

    #[test]
    fn freedom_combines_as_in_the_guide() {
        // GUM H.1.6: four parts of 25, 9.7, 2.9, 16.6 nm with 18, 25.6, 50 and 2 degrees of freedom: 32 nm, 16.
        let part = |u: f64, freedom| (1.0, Estimate { value: 0.0, standard_uncertainty: u, freedom });
        let sum = Estimate::combined(0.0, &[part(25.0, 18.0), part(9.7, 25.6), part(2.9, 50.0), part(16.6, 2.0)]);
        assert_relative_eq!(sum.standard_uncertainty, 31.7, max_relative = 5e-3);
        assert!((sum.freedom - 16.7).abs() < 0.8, "{}", sum.freedom);
    }

    #[test]
    fn a_bracket_reaches_beyond_its_ends_as_far_as_chance_does() {
        // Imbens and Manski (2004): 1.96 where the ends are alike, 1.645 where they are far apart.
        let end = |value| Estimate { value, standard_uncertainty: 1.0, freedom: f64::INFINITY };
        assert_relative_eq!(bracket(&[end(5.0), end(5.0)]).half_width(), 1.959_964, max_relative = 1e-5);
        let far = bracket(&[end(0.0), end(20.0), end(10.0)]);
        assert_relative_eq!(far.value, 10.0, max_relative = 1e-12);
        assert_relative_eq!(far.half_width(), 10.0 + 1.644_854, max_relative = 1e-5);
    }

    #[test]
    fn logs_that_differ_widen_the_interval() {
        let log = |value| Estimate { value, standard_uncertainty: 1.0, freedom: 20.0 };
        let alike = pool(&[log(10.0), log(10.5), log(9.5)]).unwrap();
        assert_eq!(alike.between, 0.0);
        let apart = pool(&[log(10.0), log(20.0), log(30.0)]).unwrap();
        // Equal weights: the interval is that of the mean of three numbers.
        assert_relative_eq!(apart.estimate.value, 20.0, max_relative = 1e-12);
        assert_relative_eq!(apart.estimate.half_width(), 4.302_653 * 10.0 / 3.0_f64.sqrt(), max_relative = 1e-6);
        assert_relative_eq!(apart.between, 99.0_f64.sqrt(), max_relative = 1e-9);
    }
}
