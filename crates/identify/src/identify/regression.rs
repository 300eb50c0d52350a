//! Least squares over blocks of time.
//!
//! The one idea: the sums of squares and products of all columns are kept block by block. Fits, errors
//! on what was left out, and the scatter of a score between blocks all follow from these small matrices
//! and never walk over the samples again.

use nalgebra::{DMatrix, DVector};

/// Where each row of a regression comes from.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    /// Log of each row.
    pub log: Vec<usize>,
    /// Block of time of each row, numbered over all logs.
    pub block: Vec<usize>,
    /// Time of each row \[s\].
    pub time: Vec<f64>,
    /// How much each row weighs; empty where all weigh one.
    pub weight: Vec<f64>,
    /// Log of each block.
    pub block_log: Vec<usize>,
    /// Whether each block is for fitting; the others only judge.
    pub block_fits: Vec<bool>,
}

impl Rows {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.log.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.log.is_empty()
    }

    /// Number of logs that have rows.
    pub fn logs(&self) -> usize {
        self.log.iter().max().map_or(0, |l| l + 1)
    }

    /// Whether a log is for fitting, at least in part.
    pub fn fits(&self, log: usize) -> bool {
        self.block_log.iter().zip(&self.block_fits).any(|(l, fits)| *l == log && *fits)
    }

    /// How much a row weighs.
    pub fn weight(&self, row: usize) -> f64 {
        self.weight.get(row).copied().unwrap_or(1.0)
    }

    /// The mean of a column over each log, as its rows weigh; NaN of a log without rows.
    pub fn means(&self, column: &[f64]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.logs()];
        for (k, (value, log)) in column.iter().zip(&self.log).enumerate() {
            let weight = self.weight(k);
            sums[*log].0 += weight * value;
            sums[*log].1 += weight;
        }
        sums.into_iter().map(|(sum, weight)| sum / weight).collect()
    }

    /// Root mean square of what is left and the share of a target's variance that is accounted for \[%\], on blocks for fitting or
    /// on the others: of each row as much as it weighs. `None` without rows.
    pub fn error(&self, left: &[f64], target: &[f64], fitting: bool) -> Option<(f64, f64)> {
        let (mut squares, mut total, mut count) = (0.0, 0.0, 0.0);
        for k in (0..left.len()).filter(|k| self.block_fits[self.block[*k]] == fitting) {
            let weight = self.weight(k);
            squares += weight * left[k] * left[k];
            total += weight * target[k] * target[k];
            count += weight;
        }
        let accounted = if total > 0.0 { 100.0 * (1.0 - squares / total) } else { 0.0 };
        (count > 0.0).then(|| ((squares / count).sqrt(), accounted))
    }

    /// Root mean square of what is left on blocks for fitting or on the others, of all rows alike. `None` without rows.
    pub fn error_alike(&self, left: &[f64], fitting: bool) -> Option<f64> {
        let rows: Vec<usize> = (0..left.len()).filter(|k| self.block_fits[self.block[*k]] == fitting).collect();
        let squares: f64 = rows.iter().map(|k| left[*k] * left[*k]).sum();
        (!rows.is_empty()).then(|| (squares / rows.len() as f64).sqrt())
    }

    /// Takes the mean of each log off a column: its zero is the log's, not the actuator's.
    pub fn without_means(&self, column: &mut [f64]) {
        let means = self.means(column);
        column.iter_mut().zip(&self.log).for_each(|(value, log)| *value -= means[*log]);
    }
}

/// What columns with their coefficients leave of a target, row by row.
pub fn residual(target: &[f64], columns: &[&[f64]], coefficients: &DVector<f64>) -> Vec<f64> {
    let mut left = target.to_vec();
    for (column, coefficient) in columns.iter().zip(coefficients.iter()) {
        left.iter_mut().zip(*column).for_each(|(l, c)| *l -= coefficient * c);
    }
    left
}

/// Sums of products of columns and target, for each block. The target is the last column.
#[derive(Debug, Clone)]
pub struct Blocks {
    /// One matrix (columns + 1)² for each block.
    pub products: Vec<DMatrix<f64>>,
    /// Rows of each block.
    pub counts: Vec<usize>,
}

/// A fit by least squares.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Coefficients.
    pub coefficients: DVector<f64>,
    /// `(XᵀX)⁻¹`.
    pub inverse: DMatrix<f64>,
}

impl Blocks {
    /// Of columns and a target.
    pub fn new(rows: &Rows, columns: &[&[f64]], target: &[f64]) -> Blocks {
        let blocks = rows.block_log.len();
        let size = columns.len() + 1;
        let mut products = vec![DMatrix::zeros(size, size); blocks];
        let mut counts = vec![0; blocks];
        let mut row = vec![0.0; size];
        for k in 0..rows.len() {
            for (slot, column) in row.iter_mut().zip(columns) {
                *slot = column[k];
            }
            row[size - 1] = target[k];
            let weight = rows.weight(k);
            if weight != 1.0 {
                row.iter_mut().for_each(|value| *value *= weight.sqrt());
            }
            let matrix = &mut products[rows.block[k]];
            counts[rows.block[k]] += 1;
            for i in 0..size {
                for j in 0..=i {
                    matrix[(i, j)] += row[i] * row[j];
                }
            }
        }
        for matrix in &mut products {
            matrix.fill_upper_triangle_with_lower_triangle();
        }
        Blocks { products, counts }
    }

    /// The sum over some blocks.
    pub fn total(&self, take: impl Fn(usize) -> bool) -> DMatrix<f64> {
        let size = self.products.first().map_or(1, DMatrix::nrows);
        let mut sum = DMatrix::zeros(size, size);
        for (b, matrix) in self.products.iter().enumerate() {
            if take(b) {
                sum += matrix;
            }
        }
        sum
    }

    /// Rows in some blocks.
    pub fn count(&self, take: impl Fn(usize) -> bool) -> usize {
        self.counts.iter().enumerate().filter(|(b, _)| take(*b)).map(|(_, n)| n).sum()
    }

    /// Sum of squared residuals of a block under coefficients.
    pub fn squares(&self, block: usize, coefficients: &DVector<f64>) -> f64 {
        squares(&self.products[block], coefficients)
    }

    /// The same with only some of the columns.
    pub fn select(&self, columns: &[usize]) -> Blocks {
        let last = self.products.first().map_or(0, |m| m.nrows() - 1);
        let keep: Vec<usize> = columns.iter().copied().chain([last]).collect();
        let products =
            self.products.iter().map(|m| DMatrix::from_fn(keep.len(), keep.len(), |i, j| m[(keep[i], keep[j])]));
        Blocks { products: products.collect(), counts: self.counts.clone() }
    }

    /// Squared residuals of each block when it is left out of the fit together with its fold; NaN where a
    /// block is in no fold.
    pub fn left_out(&self, folds: &[Option<usize>]) -> Vec<f64> {
        let all = self.total(|b| folds[b].is_some());
        let count = folds.iter().flatten().max().map_or(0, |f| f + 1);
        let mut errors = vec![f64::NAN; folds.len()];
        for fold in 0..count {
            let left = self.total(|b| folds[b] == Some(fold));
            let solution = solve(&(&all - &left));
            for b in (0..folds.len()).filter(|b| folds[*b] == Some(fold)) {
                errors[b] = self.squares(b, &solution.coefficients);
            }
        }
        errors
    }
}

/// Sum of squared residuals from sums of products.
pub fn squares(products: &DMatrix<f64>, coefficients: &DVector<f64>) -> f64 {
    let p = coefficients.len();
    let mut extended = coefficients.clone().insert_row(p, -1.0);
    extended.iter_mut().for_each(|v| {
        if !v.is_finite() {
            *v = 0.0;
        }
    });
    (products * &extended).dot(&extended).max(0.0)
}

/// Solves the normal equations. Columns are scaled to one; a direction that the data do not show (to
/// 1e-11 of the largest) gets no coefficient.
pub fn solve(products: &DMatrix<f64>) -> Solution {
    let p = products.nrows() - 1;
    if p == 0 {
        return Solution { coefficients: DVector::zeros(0), inverse: DMatrix::zeros(0, 0) };
    }
    let scale = DVector::from_fn(p, |i, _| {
        let norm = products[(i, i)].sqrt();
        if norm > 0.0 { 1.0 / norm } else { 0.0 }
    });
    let normal = DMatrix::from_fn(p, p, |i, j| products[(i, j)] * scale[i] * scale[j]);
    let right = DVector::from_fn(p, |i, _| products[(i, p)] * scale[i]);
    let eigen = normal.symmetric_eigen();
    let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    let inverse_values = eigen.eigenvalues.map(|v| if v > 1e-11 * largest { 1.0 / v } else { 0.0 });
    let inverse = &eigen.eigenvectors * DMatrix::from_diagonal(&inverse_values) * eigen.eigenvectors.transpose();
    let coefficients = (&inverse * right).component_mul(&scale);
    let inverse = DMatrix::from_fn(p, p, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
    Solution { coefficients, inverse }
}

/// Covariance of the coefficients, from the scatter of the scores between blocks (which holds for
/// residuals that are correlated within a block).
pub fn covariance(blocks: &Blocks, solution: &Solution, take: impl Fn(usize) -> bool) -> DMatrix<f64> {
    let p = solution.coefficients.len();
    let mut middle = DMatrix::zeros(p, p);
    let mut used = 0.0;
    for (b, matrix) in blocks.products.iter().enumerate().filter(|(b, _)| take(*b)) {
        if blocks.counts[b] == 0 {
            continue;
        }
        let score = matrix.view((0, p), (p, 1)) - matrix.view((0, 0), (p, p)) * &solution.coefficients;
        middle += &score * score.transpose();
        used += 1.0;
    }
    let factor = if used > p as f64 + 1.0 { used / (used - p as f64 - 1.0).max(1.0) } else { 1.0 };
    &solution.inverse * middle * &solution.inverse * factor
}

/// The coefficients of extra columns on the model's, and what they leave: from sums of products in which
/// the model's `p` columns come first.
pub(crate) fn projection(total: &DMatrix<f64>, p: usize, extra: usize) -> DMatrix<f64> {
    let normal = total.view((0, 0), (p, p)).into_owned();
    let cross = total.view((0, p), (p, extra)).into_owned();
    let mut padded = DMatrix::zeros(p + 1, p + 1);
    padded.view_mut((0, 0), (p, p)).copy_from(&normal);
    let inverse = solve(&padded).inverse;
    inverse * cross
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn example() -> (Rows, Vec<Vec<f64>>, Vec<f64>) {
        let n = 200;
        let rows = Rows {
            log: (0..n).map(|k| k / 100).collect(),
            block: (0..n).map(|k| k / 10).collect(),
            time: (0..n).map(|k| k as f64).collect(),
            weight: Vec::new(),
            block_log: (0..20).map(|b| b / 10).collect(),
            block_fits: vec![true; 20],
        };
        let a: Vec<f64> = (0..n).map(|k| (0.3 * k as f64).sin()).collect();
        let b: Vec<f64> = (0..n).map(|k| 1e6 * (0.11 * k as f64).cos()).collect();
        let y = a.iter().zip(&b).map(|(a, b)| 2.0 * a - 3e-6 * b).collect();
        (rows, vec![a, b], y)
    }

    #[test]
    fn the_fit_is_that_on_paper_and_left_out_blocks_follow() {
        let (rows, columns, y) = example();
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let blocks = Blocks::new(&rows, &columns, &y);
        let solution = solve(&blocks.total(|_| true));
        assert_relative_eq!(solution.coefficients[0], 2.0, max_relative = 1e-9);
        assert_relative_eq!(solution.coefficients[1], -3e-6, max_relative = 1e-9);
        let folds: Vec<Option<usize>> = (0..20).map(|b| Some(b % 5)).collect();
        assert!(blocks.left_out(&folds).iter().all(|e| *e < 1e-12 * y.iter().map(|v| v * v).sum::<f64>()));
        // A constant column twice changes nothing but its own coefficient.
        let twice = [columns[0], columns[1], columns[0]];
        let solution = solve(&Blocks::new(&rows, &twice, &y).total(|_| true));
        assert_relative_eq!(solution.coefficients[0] + solution.coefficients[2], 2.0, max_relative = 1e-8);
    }

    /// What is compared with the noise has wild rows in full; what a model is told by has them as much as they weigh.
    #[test]
    fn errors_are_of_rows_as_they_weigh_or_of_all_alike() {
        let (mut rows, ..) = example();
        rows.block_fits = (0..20).map(|b| b < 10).collect();
        let left: Vec<f64> = (0..200).map(|k| if k % 100 < 4 { 10.0 } else { 1.0 }).collect();
        rows.weight = (0..200).map(|k| if k % 100 < 4 { 0.01 } else { 1.0 }).collect();
        for fitting in [true, false] {
            // 96 ones and four of 10² · 0.01 over 96.04; 96 ones and four hundreds over 100.
            let (error, accounted) = rows.error(&left, &left, fitting).unwrap();
            assert_relative_eq!(error, (100.0_f64 / 96.04).sqrt(), max_relative = 1e-12);
            assert_eq!(accounted, 0.0);
            assert_relative_eq!(rows.error_alike(&left, fitting).unwrap(), 4.96_f64.sqrt(), max_relative = 1e-12);
        }
        rows.block_fits = vec![true; 20];
        assert_eq!((rows.error(&left, &left, false), rows.error_alike(&left, false)), (None, None));
    }

    #[test]
    fn means_are_taken_off_log_by_log() {
        let (rows, columns, _) = example();
        let mut column = columns[0].clone();
        column.iter_mut().skip(100).for_each(|v| *v += 7.0);
        rows.without_means(&mut column);
        for range in [0..100, 100..200] {
            assert!(column[range].iter().sum::<f64>().abs() < 1e-10);
        }
    }
}
