//! How far apart models are: the T-criterion.
//!
//! The one idea: one of two models is taken as true, and the other one is fitted to what that predicts. What it cannot follow,
//! over what is left on this bench, is the squared distance δ² of the two (Atkinson and Fedorov 1975). All of it follows from
//! sums of products of columns, which add up over logs and over passages of a run.

use nalgebra::{DMatrix, DVector};

use crate::identify::regression::projection;

/// Less than this share of its square is no direction of a column.
const NOTHING: f64 = 1e-9;

/// A model that may be true: an instance among the columns of one side, with its values.
#[derive(Debug, Clone)]
pub struct Truth {
    /// The side.
    pub side: usize,
    /// Its columns, among all.
    pub columns: Vec<usize>,
    /// Their coefficients.
    pub values: DVector<f64>,
    /// How likely it is among those of its side.
    pub weight: f64,
}

/// Two models beside a common one, among the columns of sums of products.
#[derive(Debug, Clone)]
pub struct Contest {
    /// How many columns both models have, which come first.
    pub common: usize,
    /// Columns of each instance (shape) of each side.
    pub sides: Vec<Vec<Vec<usize>>>,
    /// What may be true.
    pub truths: Vec<Truth>,
    /// Variance of what is left, in units of information.
    pub variance: f64,
}

impl Contest {
    /// Of nothing yet.
    pub fn empty() -> Contest {
        Contest { common: 0, sides: Vec::new(), truths: Vec::new(), variance: f64::NAN }
    }

    /// δ², from sums of products of all columns: the mean over what may be true of a side, of the side that is told worse.
    pub fn square(&self, products: &DMatrix<f64>) -> f64 {
        let left = beyond(products, self.common);
        let mut least = f64::INFINITY;
        for side in 0..self.sides.len() {
            let (mut sum, mut weight) = (0.0, 0.0);
            for truth in self.truths.iter().filter(|t| t.side == side) {
                sum += truth.weight * self.distance(&left, truth);
                weight += truth.weight;
            }
            if weight > 0.0 {
                least = least.min(sum / weight);
            }
        }
        if least.is_finite() { least } else { 0.0 }
    }

    /// What the best instance of every other side leaves of a truth, over the variance.
    fn distance(&self, left: &DMatrix<f64>, truth: &Truth) -> f64 {
        let at = |k: usize| k - self.common;
        let entry = |a: usize, b: usize| left[(at(a), at(b))];
        let own: f64 = pairs(&truth.columns)
            .map(|(i, j)| value(truth, i) * value(truth, j) * entry(truth.columns[i], truth.columns[j]))
            .sum();
        let mut least = own;
        for instance in self.sides.iter().enumerate().filter(|(s, _)| *s != truth.side).flat_map(|(_, s)| s) {
            let cross = |k: &usize| -> f64 {
                truth.columns.iter().enumerate().map(|(i, c)| value(truth, i) * entry(*c, *k)).sum()
            };
            let followed = match instance.as_slice() {
                [one] => {
                    let square = entry(*one, *one);
                    if square > 0.0 { cross(one).powi(2) / square } else { 0.0 }
                }
                [one, two] => {
                    let (a, b, c) = (entry(*one, *one), entry(*one, *two), entry(*two, *two));
                    let (x, y) = (cross(one), cross(two));
                    let determinant = a * c - b * b;
                    if determinant > NOTHING * a * c {
                        (c * x * x - 2.0 * b * x * y + a * y * y) / determinant
                    } else if a.max(c) > 0.0 {
                        (x * x / a.max(f64::MIN_POSITIVE)).max(y * y / c.max(f64::MIN_POSITIVE))
                    } else {
                        0.0
                    }
                }
                _ => 0.0,
            };
            least = least.min(own - followed);
        }
        least.max(0.0) / self.variance
    }
}

fn value(truth: &Truth, index: usize) -> f64 {
    truth.values[index]
}

fn pairs(columns: &[usize]) -> impl Iterator<Item = (usize, usize)> + '_ {
    (0..columns.len()).flat_map(|i| (0..columns.len()).map(move |j| (i, j)))
}

/// Sums of products of what the first columns do not make up of the others.
fn beyond(products: &DMatrix<f64>, common: usize) -> DMatrix<f64> {
    let extra = products.nrows() - common;
    let own = products.view((common, common), (extra, extra)).into_owned();
    if common == 0 {
        return own;
    }
    let onto = projection(products, common, extra);
    let mut left = own - products.view((0, common), (common, extra)).transpose() * onto;
    // What rounding alone leaves of a column is nothing.
    for k in 0..extra {
        if left[(k, k)] < NOTHING * products[(common + k, common + k)] {
            left.row_mut(k).fill(0.0);
            left.column_mut(k).fill(0.0);
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::steady::noise;
    use approx::assert_relative_eq;

    fn products(columns: &[Vec<f64>]) -> DMatrix<f64> {
        let n = columns.len();
        DMatrix::from_fn(n, n, |i, j| columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum())
    }

    fn contest(common: usize, sides: Vec<Vec<Vec<usize>>>, truth: (usize, Vec<usize>, Vec<f64>)) -> Contest {
        let truth = Truth { side: truth.0, columns: truth.1, values: DVector::from_vec(truth.2), weight: 1.0 };
        Contest { common, sides, truths: vec![truth], variance: 0.25 }
    }

    /// A speed and its sign at ±1 and ±3: the sign leaves of the speed (3 − 2)² and (1 − 2)² of each row, and of nothing else.
    #[test]
    fn what_the_other_model_cannot_follow_counts() {
        let speed: Vec<f64> = (0..40).map(|k| [1.0, 3.0, -1.0, -3.0][k % 4]).collect();
        let sign: Vec<f64> = speed.iter().map(|w: &f64| w.signum()).collect();
        let both = products(&[speed.clone(), sign.clone()]);
        let one = contest(0, vec![vec![vec![0]], vec![vec![1]]], (0, vec![0], vec![0.5]));
        assert_relative_eq!(one.square(&both), 0.25 * 40.0 / 0.25, max_relative = 1e-12);
        // At one speed nothing tells the two apart; at twice as many rows twice as much.
        let steady: Vec<f64> = sign.iter().map(|s| 3.0 * s).collect();
        assert_eq!(one.square(&products(&[steady, sign.clone()])), 0.0);
        assert_relative_eq!(one.square(&(&both * 2.0)), 2.0 * one.square(&both), max_relative = 1e-12);
        // Against nothing all of it counts; the most like of several instances does.
        let nothing = contest(0, vec![vec![vec![0]], Vec::new()], (0, vec![0], vec![0.5]));
        assert_relative_eq!(nothing.square(&both), 0.25 * 200.0 / 0.25, max_relative = 1e-12);
        let near: Vec<f64> = speed.iter().enumerate().map(|(k, w)| w + 1e-3 * noise(k)).collect();
        let two = contest(0, vec![vec![vec![0]], vec![vec![1], vec![2]]], (0, vec![0], vec![0.5]));
        assert!(two.square(&products(&[speed, sign, near])) < 1e-3);
    }

    /// A wave against a wave of two columns, beside a common column: as the projection by hand.
    #[test]
    fn waves_are_two_columns_and_what_is_common_is_taken_off_first() {
        let angle = |k: usize| 0.37 * k as f64;
        let wave = |f: fn(f64) -> f64, order: f64| (0..400).map(|k| f(order * angle(k))).collect::<Vec<f64>>();
        let columns =
            [vec![1.0; 400], wave(f64::cos, 3.0), wave(f64::sin, 3.0), wave(f64::cos, 5.0), wave(f64::sin, 5.0)];
        let apart = contest(1, vec![vec![vec![1, 2]], vec![vec![3, 4]]], (0, vec![1, 2], vec![0.1, 0.2]));
        assert_relative_eq!(apart.square(&products(&columns)), 0.05 * 200.0 / 0.25, max_relative = 0.02);
        let same = [columns[0].clone(), columns[1].clone(), columns[2].clone(), columns[2].clone(), columns[1].clone()];
        assert!(apart.square(&products(&same)) < 1e-9);
        // A column that is the common one is nothing.
        let constant = contest(1, vec![vec![vec![1]], Vec::new()], (0, vec![1], vec![2.0]));
        assert_eq!(constant.square(&products(&[vec![1.0; 50], vec![3.0; 50]])), 0.0);
    }
}
