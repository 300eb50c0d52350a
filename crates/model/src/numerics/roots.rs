//! Where polynomials change their sign: exactly, over an interval.

use super::laurent::Laurent;

/// Halvings that leave two neighbouring numbers.
const HALVINGS: usize = 200;

/// The value of a polynomial by its coefficients, the constant first.
fn at(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Places in `[a, b]` where a polynomial changes its sign, ascending, each as the two neighbouring numbers that it lies
/// between; coefficients from the constant up. Between two places where its derivative changes sign a polynomial rises or
/// falls, so that halving finds the only one there is.
pub fn sign_changes(coefficients: &[f64], a: f64, b: f64) -> Vec<(f64, f64)> {
    let degree = coefficients.iter().rposition(|c| *c != 0.0).unwrap_or(0);
    if degree == 0 || a >= b {
        return Vec::new();
    }
    let coefficients = &coefficients[..=degree];
    let derivative: Vec<f64> = coefficients.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect();
    let mut ends = vec![a];
    ends.extend(sign_changes(&derivative, a, b).into_iter().map(|(low, _)| low).filter(|x| a < *x && *x < b));
    ends.push(b);
    let between = |w: &[f64]| {
        let (mut low, mut high) = (w[0], w[1]);
        let rises = at(coefficients, high) > 0.0;
        if (at(coefficients, low) > 0.0) == rises {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if (at(coefficients, middle) > 0.0) == rises { high = middle } else { low = middle }
        }
        Some((low, high))
    };
    ends.windows(2).filter_map(between).collect()
}

/// The parts of `[a, b]`, 0 < a ≤ b, on which a Laurent polynomial is at most `bound`, ascending.
pub fn parts_below(polynomial: &Laurent, bound: f64, a: f64, b: f64) -> Vec<(f64, f64)> {
    // N² (p − bound), with N as a share of b so that no power runs away.
    let coefficient = |power: i32| (polynomial[power] - if power == 0 { bound } else { 0.0 }) * b.powi(power);
    let coefficients: Vec<f64> = (-2..=4).map(coefficient).collect();
    let changes = sign_changes(&coefficients, a / b, 1.0);
    let is_below = |x: f64| at(&coefficients, x) <= 0.0;
    let mut parts: Vec<(f64, f64)> = Vec::new();
    let mut start = is_below(a / b).then_some(a);
    for (before, after) in changes {
        match (start.take(), is_below(before)) {
            (Some(from), true) => parts.push((from, before * b)),
            (_, false) => start = Some(after * b),
            (None, true) => {}
        }
    }
    parts.extend(start.map(|from| (from, b)));
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    #[test]
    fn the_roots_of_a_product_are_its_factors() {
        // (x − 1)(x − 2)(x − 3) and (x − 1.5)² (x − 4), which only touches at 1.5.
        let roots: Vec<f64> = sign_changes(&[-6.0, 11.0, -6.0, 1.0], 0.5, 10.0).into_iter().map(|r| r.0).collect();
        assert_eq!(roots.len(), 3);
        assert!(roots.iter().zip([1.0, 2.0, 3.0]).all(|(r, x)| (r - x).abs() < 1e-12), "{roots:?}");
        let touching = sign_changes(&[-9.0, 14.25, -7.0, 1.0], 0.1, 10.0);
        let far: Vec<f64> = touching.iter().map(|r| r.0).filter(|r| (r - 1.5).abs() > 1e-3).collect();
        assert!(far.len() == 1 && (far[0] - 4.0).abs() < 1e-12, "{touching:?}");
        assert!(sign_changes(&[1.0], 0.0, 1.0).is_empty() && sign_changes(&[0.0, 0.0], 0.0, 1.0).is_empty());
        assert!(sign_changes(&[1.0, 0.0, 1.0], -5.0, 5.0).is_empty());
    }

    /// Random polynomials of powers −2 to 4: a fine grid says the same of what is below the bound.
    #[test]
    fn the_parts_below_a_bound_are_those_of_a_grid() {
        let mut random = Pcg64::seed_from_u64(11);
        let (mut split, mut none) = (0, 0);
        for _ in 0..2000 {
            let (a, b) = (0.3, random.random_range(1.0..300.0));
            let middle = 10.0_f64.powf(random.random_range(-0.5..2.0));
            let term =
                |p: i32, random: &mut Pcg64| Laurent::monomial(random.random_range(-1.0..1.0) * middle.powi(-p), p);
            let polynomial = (-2..=4).map(|p| term(p, &mut random)).fold(Laurent::default(), |x, y| x + y);
            let bound = random.random_range(-1.0..1.0);
            let parts = parts_below(&polynomial, bound, a, b);
            split += usize::from(parts.len() > 1);
            none += usize::from(parts.is_empty());
            for k in 0..=2000 {
                let n = (a * (b / a).powf(f64::from(k) / 2000.0)).min(b);
                let clear = (polynomial.at(n) - bound).abs() > 1e-9 * (polynomial.size(n) + bound.abs());
                let inside = parts.iter().any(|(from, to)| *from <= n && n <= *to);
                assert!(!clear || inside == (polynomial.at(n) < bound), "{n} of {parts:?}");
            }
        }
        assert!(split > 50 && none > 50, "{split} {none}");
    }
}
