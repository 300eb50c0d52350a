//! The one declared interpolant: the cubic spline with continuous second derivative through the
//! samples, periodic where the motion is, not-a-knot at the ends otherwise (C. de Boor, *A Practical
//! Guide to Splines*, ch. IV). Derivatives that a motion does not give are the spline's.

/// First and second derivative of the spline at its knots.
#[derive(Debug, Clone, PartialEq)]
pub struct Derivatives {
    /// First derivative at each knot.
    pub first: Vec<f64>,
    /// Second derivative at each knot.
    pub second: Vec<f64>,
}

/// Fewest samples that an open motion needs.
pub const MIN_OPEN: usize = 4;
/// Fewest distinct samples that a periodic motion needs.
pub const MIN_PERIODIC: usize = 3;

/// Spline through `(x[i], y[i])` with period `period`; `x` strictly increasing within one period.
///
/// # Panics
/// With fewer than [`MIN_PERIODIC`] samples or different lengths.
pub fn periodic(x: &[f64], y: &[f64], period: f64) -> Derivatives {
    let n = x.len();
    assert!(n >= MIN_PERIODIC && y.len() == n, "a periodic spline needs at least three samples");
    let h = |i: usize| if i + 1 < n { x[i + 1] - x[i] } else { period - (x[n - 1] - x[0]) };
    let slope = |i: usize| (y[(i + 1) % n] - y[i]) / h(i);
    let (mut lower, mut diagonal, mut upper, mut right) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    for i in 0..n {
        let before = (i + n - 1) % n;
        let (h0, h1) = (h(before), h(i));
        lower[i] = h1;
        diagonal[i] = 2.0 * (h0 + h1);
        upper[i] = h0;
        right[i] = 3.0 * (h1 * slope(before) + h0 * slope(i));
    }
    // Sherman-Morrison takes the two corner entries out of the cyclic system.
    let (corner_low, corner_high) = (upper[n - 1], lower[0]);
    let gamma = -diagonal[0];
    diagonal[0] -= gamma;
    diagonal[n - 1] -= corner_low * corner_high / gamma;
    let mut u = vec![0.0; n];
    u[0] = gamma;
    u[n - 1] = corner_low;
    let z = tridiagonal(&lower, &diagonal, &upper, u);
    let mut first = tridiagonal(&lower, &diagonal, &upper, right);
    let factor = (first[0] + corner_high * first[n - 1] / gamma) / (1.0 + z[0] + corner_high * z[n - 1] / gamma);
    for (d, z) in first.iter_mut().zip(&z) {
        *d -= factor * z;
    }
    let second = (0..n).map(|i| (6.0 * slope(i) - 4.0 * first[i] - 2.0 * first[(i + 1) % n]) / h(i)).collect();
    Derivatives { first, second }
}

/// Spline through `(x[i], y[i])`, `x` strictly increasing, with the not-a-knot end condition.
///
/// # Panics
/// With fewer than [`MIN_OPEN`] samples or different lengths.
pub fn open(x: &[f64], y: &[f64]) -> Derivatives {
    let n = x.len();
    assert!(n >= MIN_OPEN && y.len() == n, "an open spline needs at least four samples");
    let h = |i: usize| x[i + 1] - x[i];
    let slope = |i: usize| (y[i + 1] - y[i]) / h(i);
    let (mut lower, mut diagonal, mut upper, mut right) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    for i in 1..n - 1 {
        let (h0, h1) = (h(i - 1), h(i));
        lower[i] = h1;
        diagonal[i] = 2.0 * (h0 + h1);
        upper[i] = h0;
        right[i] = 3.0 * (h1 * slope(i - 1) + h0 * slope(i));
    }
    let (h0, h1) = (h(0), h(1));
    diagonal[0] = h1;
    upper[0] = h0 + h1;
    right[0] = ((h0 + 2.0 * (h0 + h1)) * h1 * slope(0) + h0 * h0 * slope(1)) / (h0 + h1);
    let (h0, h1) = (h(n - 2), h(n - 3));
    diagonal[n - 1] = h1;
    lower[n - 1] = h0 + h1;
    right[n - 1] = ((h0 + 2.0 * (h0 + h1)) * h1 * slope(n - 2) + h0 * h0 * slope(n - 3)) / (h0 + h1);
    let first = tridiagonal(&lower, &diagonal, &upper, right);
    let at = |i: usize| (6.0 * slope(i) - 4.0 * first[i] - 2.0 * first[i + 1]) / h(i);
    let mut second: Vec<f64> = (0..n - 1).map(at).collect();
    let last = n - 2;
    second.push((-6.0 * slope(last) + 2.0 * first[last] + 4.0 * first[last + 1]) / h(last));
    Derivatives { first, second }
}

/// Solves a tridiagonal system by elimination from the top.
fn tridiagonal(lower: &[f64], diagonal: &[f64], upper: &[f64], mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    let mut pivots = vec![0.0; n];
    let mut pivot = diagonal[0];
    right[0] /= pivot;
    for i in 1..n {
        pivots[i] = upper[i - 1] / pivot;
        pivot = diagonal[i] - lower[i] * pivots[i];
        right[i] = (right[i] - lower[i] * right[i - 1]) / pivot;
    }
    for i in (0..n - 1).rev() {
        right[i] -= pivots[i + 1] * right[i + 1];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_cubic_is_reproduced_exactly() {
        let x = [0.0, 0.3, 0.5, 1.1, 1.6, 2.0];
        let y = x.map(|x: f64| 2.0 - x + 0.5 * x * x - 0.25 * x.powi(3));
        let d = open(&x, &y);
        for (i, x) in x.iter().enumerate() {
            assert_relative_eq!(d.first[i], -1.0 + x - 0.75 * x * x, epsilon = 1e-12);
            assert_relative_eq!(d.second[i], 1.0 - 1.5 * x, epsilon = 1e-11);
        }
    }

    #[test]
    fn a_sine_is_differentiated_with_fourth_order() {
        let error = |n: usize| {
            let x: Vec<f64> = (0..n).map(|i| (i as f64 + 0.2 * (i as f64 * 1.7).sin()) / n as f64).collect();
            let w = std::f64::consts::TAU;
            let y: Vec<f64> = x.iter().map(|x| (w * x).sin()).collect();
            let d = periodic(&x, &y, 1.0);
            x.iter().zip(&d.first).map(|(x, d)| (d - w * (w * x).cos()).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(40), error(80));
        assert!(fine < 1e-3 && coarse / fine > 6.0, "{coarse} {fine}");
    }

    #[test]
    fn the_second_derivative_is_continuous_across_the_period() {
        let x = [0.0, 0.2, 0.45, 0.7];
        let y = [0.0, 1.0, 0.3, -0.8];
        let d = periodic(&x, &y, 1.0);
        // From the left of the first knot, on the last interval:
        let (h, slope) = (0.3, (y[0] - y[3]) / 0.3);
        let left = (-6.0 * slope + 2.0 * d.first[3] + 4.0 * d.first[0]) / h;
        assert_relative_eq!(left, d.second[0], max_relative = 1e-10);
    }
}
