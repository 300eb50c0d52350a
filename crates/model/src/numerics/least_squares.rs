//! Least squares of residuals that are not linear: Levenberg and Marquardt with differences for derivatives, and bounds.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// A number to be found.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// Where to begin.
    pub start: f64,
    /// Its size: steps and damping are relative to it.
    pub scale: f64,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Values in the order of the unknowns.
    pub values: Vec<f64>,
    /// Sum of squares.
    pub cost: f64,
}

/// Relative step of the differences.
const DIFFERENCE: f64 = 1e-4;

/// Residuals of each part (a log) at given values.
pub type Parts<'a> = dyn Fn(usize, &[f64]) -> Vec<f64> + Sync + 'a;

/// All residuals, part by part, in parallel and in order.
pub fn residuals(parts: usize, of: &Parts, values: &[f64]) -> Vec<Vec<f64>> {
    (0..parts).into_par_iter().map(|p| of(p, values)).collect()
}

/// Derivatives of all residuals: for each part one column for each unknown \[per unit\].
pub fn derivatives(
    parts: usize,
    of: &Parts,
    unknowns: &[Unknown],
    values: &[f64],
    at: &[Vec<f64>],
) -> Vec<Vec<Vec<f64>>> {
    let n = unknowns.len();
    let all: Vec<Vec<f64>> = (0..parts * n)
        .into_par_iter()
        .map(|index| {
            let (part, j) = (index / n, index % n);
            let mut moved = values.to_vec();
            let mut step = DIFFERENCE * unknowns[j].scale;
            if moved[j] + step > unknowns[j].upper {
                step = -step;
            }
            moved[j] += step;
            let mut column = of(part, &moved);
            for (c, r) in column.iter_mut().zip(&at[part]) {
                *c = (*c - r) / step;
            }
            column
        })
        .collect();
    let mut all = all.into_iter();
    (0..parts).map(|_| all.by_ref().take(n).collect()).collect()
}

fn cost(residuals: &[Vec<f64>]) -> f64 {
    residuals.iter().flatten().map(|r| r * r).sum()
}

/// Finds the values with the least sum of squares over all parts: at most `rounds` rounds, or until a round
/// takes away less than `enough` of the sum. The same for any number of threads.
pub fn minimise(parts: usize, of: &Parts, unknowns: &[Unknown], rounds: usize, enough: f64) -> Fitted {
    let n = unknowns.len();
    let mut values: Vec<f64> = unknowns.iter().map(|u| u.start.clamp(u.lower, u.upper)).collect();
    let mut at = residuals(parts, of, &values);
    let mut best = cost(&at);
    let mut damping = 1e-2;
    for _ in 0..rounds {
        if n == 0 || best == 0.0 {
            break;
        }
        let columns = derivatives(parts, of, unknowns, &values, &at);
        let (mut normal, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for (part, residual) in columns.iter().zip(&at) {
            for a in 0..n {
                gradient[a] += unknowns[a].scale * dot(&part[a], residual);
                for b in 0..=a {
                    normal[(a, b)] += unknowns[a].scale * unknowns[b].scale * dot(&part[a], &part[b]);
                }
            }
        }
        normal.fill_upper_triangle_with_lower_triangle();
        let largest = (0..n).map(|j| normal[(j, j)]).fold(f64::MIN_POSITIVE, f64::max);
        let before = best;
        for _ in 0..8 {
            let step = bounded_step(&normal, &gradient, damping, largest, unknowns, &values);
            let moved: Vec<f64> = (0..n)
                .map(|j| (values[j] + step[j] * unknowns[j].scale).clamp(unknowns[j].lower, unknowns[j].upper))
                .collect();
            let there = residuals(parts, of, &moved);
            let now = cost(&there);
            if now < best {
                (values, at, best) = (moved, there, now);
                damping = (damping * 0.2).max(1e-9);
                break;
            }
            damping *= 5.0;
        }
        if best > before * (1.0 - enough) {
            break;
        }
    }
    Fitted { values, cost: best }
}

/// The damped step in scaled unknowns; one that a bound stops does not move.
fn bounded_step(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
    largest: f64,
    unknowns: &[Unknown],
    values: &[f64],
) -> DVector<f64> {
    let n = unknowns.len();
    let mut free: Vec<bool> = vec![true; n];
    for _ in 0..=n {
        let (mut matrix, mut right) = (normal.clone(), -gradient);
        for j in 0..n {
            matrix[(j, j)] += damping * normal[(j, j)] + 1e-14 * largest;
            if !free[j] {
                matrix.row_mut(j).fill(0.0);
                matrix.column_mut(j).fill(0.0);
                (matrix[(j, j)], right[j]) = (1.0, 0.0);
            }
        }
        let step = matrix.cholesky().map_or_else(|| DVector::zeros(n), |c| c.solve(&right));
        let stopped = (0..n).find(|j| {
            let stuck_low = values[*j] <= unknowns[*j].lower && step[*j] < 0.0;
            let stuck_high = values[*j] >= unknowns[*j].upper && step[*j] > 0.0;
            free[*j] && (stuck_low || stuck_high)
        });
        match stopped {
            Some(j) => free[j] = false,
            None => return step,
        }
    }
    DVector::zeros(n)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
