//! A lower bound on the objective that does not use the solver.
//!
//! For any multipliers λ ≥ 0, `min over u of f(u) + Σ λ_k (g_k(u) − b_k)` is a lower bound on the
//! objective over all feasible u (weak duality). The sum is again `c_w/u + c_0 + c_u u + c_t u²` with
//! `c_w, c_t ≥ 0`, so its minimum over the range is found exactly; the solver only proposes λ.

use super::window::minimise;
use super::{Row, slope, value};

/// Lower bound of the convex objective with coefficients `f` over the range, with multipliers.
pub(super) fn lower_bound(f: &[f64; 4], rows: &[(Row, f64)], low: f64, high: f64) -> f64 {
    let mut sum = *f;
    for (row, multiplier) in rows {
        let multiplier = multiplier.max(0.0);
        for (s, c) in sum.iter_mut().zip(row.coefficients) {
            *s += multiplier * c;
        }
        sum[1] -= multiplier * row.bound;
    }
    let u = minimise(&sum, low, high);
    // What rounding may have added to the sum is taken off again: a bound must not exceed the truth.
    value(&sum, u) - 4.0 * f64::EPSILON * size(f, rows, u)
}

/// Sum of the magnitudes of all terms at u: what cancels in the objective and in the rows.
fn size(f: &[f64; 4], rows: &[(Row, f64)], u: f64) -> f64 {
    let magnitude = |c: &[f64; 4]| value(&c.map(f64::abs), u);
    magnitude(f)
        + rows.iter().map(|(row, m)| m.max(0.0) * (magnitude(&row.coefficients) + row.bound.abs())).sum::<f64>()
}

/// The multiplier that makes a single row's gradient balance the objective's at u.
pub(super) fn balancing_multiplier(f: &[f64; 4], row: &Row, u: f64) -> f64 {
    let multiplier = -slope(f, u) / slope(&row.coefficients, u);
    if multiplier.is_finite() { multiplier.max(0.0) } else { 0.0 }
}
