//! Any function of a variable, by straight pieces between knots.

use super::regression::Rows;
use crate::signals;

/// Knots of a flexible function.
pub const KNOTS: usize = 9;

/// Piecewise linear functions over knots at the quantiles that a variable has in the rows for fitting.
pub fn hats(rows: &Rows, values: &[f64]) -> Vec<Box<dyn Fn(f64) -> f64 + Sync>> {
    hats_over((0..values.len()).filter(|k| rows.block_fits[rows.block[*k]]).map(|k| values[k]).collect())
}

/// The same at quantiles of all values.
pub fn hats_over(values: Vec<f64>) -> Vec<Box<dyn Fn(f64) -> f64 + Sync>> {
    let mut knots: Vec<f64> =
        (0..KNOTS).filter_map(|k| signals::quantile(values.clone(), k as f64 / (KNOTS - 1) as f64)).collect();
    knots.dedup_by(|a, b| (*a - *b).abs() <= 1e-12 * b.abs().max(1e-300));
    if knots.len() < 3 {
        return Vec::new();
    }
    (0..knots.len())
        .map(|k| {
            let knots = knots.clone();
            // Beyond the ends the last pieces go on: together they stay straight lines, as within.
            let hat = move |x: f64| {
                let last = knots.len() - 1;
                let piece = knots.partition_point(|knot| *knot <= x).clamp(1, last) - 1;
                let share = (x - knots[piece]) / (knots[piece + 1] - knots[piece]);
                match k {
                    _ if k == piece => 1.0 - share,
                    _ if k == piece + 1 => share,
                    _ => 0.0,
                }
            };
            Box::new(hat) as Box<dyn Fn(f64) -> f64 + Sync>
        })
        .collect()
}
