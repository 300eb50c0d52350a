//! What each block of time says of columns that are not in the model.
//!
//! The one idea: blocks do not know equally much. An effect that lives in slow passages, in steps or in the minutes of
//! warm-up is seen by few of them; the others say neither yes nor no. So every block is weighed by its own information,
//! and scatter is that of what the blocks say against what their information lets expect.

use nalgebra::{DMatrix, DVector};

use super::regression::{Blocks, projection, solve};

/// Blocks with less than this share of the most information have no say in the scatter.
const SILENT: f64 = 1e-4;

/// Scores of columns under a model, block by block: the columns, less what the model's columns make of them, times what
/// the model leaves.
#[derive(Debug, Clone)]
pub struct Scores {
    /// One for each fitting block; which, and what it says.
    blocks: Vec<Score>,
    /// Where blocks lie among all.
    places: Vec<usize>,
    /// How many blocks there are in all.
    count: usize,
    /// Coefficients of the columns, fitted beside the model.
    value: DVector<f64>,
    /// The inverse of all information.
    inverse: DMatrix<f64>,
    /// Variance of what is left, in units of information.
    variance: f64,
}

/// What a block says.
#[derive(Debug, Clone)]
struct Score {
    score: DVector<f64>,
    information: DMatrix<f64>,
    /// What the block says beyond the fitted value, in standard deviations of white noise of variance one.
    left: DVector<f64>,
    root: DMatrix<f64>,
}

impl Scores {
    /// Of no block.
    #[cfg(test)]
    pub fn of_nothing() -> Scores {
        Scores {
            blocks: Vec::new(),
            places: Vec::new(),
            count: 0,
            value: DVector::zeros(1),
            inverse: DMatrix::zeros(1, 1),
            variance: 0.0,
        }
    }

    /// Of blocks in which the model's `p` columns come first, then those that are asked.
    pub fn new(blocks: &Blocks, p: usize, take: impl Fn(usize) -> bool) -> Scores {
        let total = blocks.total(&take);
        let last = total.nrows() - 1;
        let extra = last - p;
        let onto = projection(&total, p, extra);
        let small = DMatrix::from_fn(p + 1, p + 1, |i, j| {
            let at = |k: usize| if k == p { last } else { k };
            total[(at(i), at(j))]
        });
        let beta = solve(&small).coefficients;
        let mut parts = Vec::new();
        let mut places = Vec::new();
        for (b, m) in blocks.products.iter().enumerate().filter(|(b, _)| take(*b)) {
            let of_model = m.view((0, last), (p, 1)) - m.view((0, 0), (p, p)) * &beta;
            let own = m.view((p, last), (extra, 1)) - m.view((p, 0), (extra, p)) * &beta;
            let score = own - onto.transpose() * of_model;
            let cross = m.view((p, 0), (extra, p)) * &onto;
            let information = m.view((p, p), (extra, extra)) - &cross - cross.transpose()
                + onto.transpose() * m.view((0, 0), (p, p)) * &onto;
            parts.push((DVector::from_iterator(extra, score.iter().copied()), information));
            places.push(b);
        }
        let mut information = DMatrix::zeros(extra, extra);
        let mut sum = DVector::zeros(extra);
        for (score, own) in &parts {
            information += own;
            sum += score;
        }
        let inverse = invert(&information);
        let value = &inverse * &sum;
        let most = parts.iter().map(|(_, own)| own.trace()).fold(0.0, f64::max);
        let mut scores: Vec<Score> = parts
            .into_iter()
            .map(|(score, information)| {
                let root = root(&information);
                // What one block alone decides is not confirmed by itself: less its own leverage.
                let leverage = (&inverse * &information).trace() / extra as f64;
                let beyond = (&score - &information * &value) / (1.0 - leverage).max(0.05);
                let left = if information.trace() > SILENT * most { solve_lower(&root, &beyond) } else { beyond * 0.0 };
                Score { score, information, left, root }
            })
            .collect();
        let said: f64 = scores.iter().filter(|s| s.information.trace() > SILENT * most).count() as f64;
        let sum: f64 = scores.iter().map(|s| s.left.norm_squared()).sum();
        let variance = sum / (extra as f64 * said.max(1.0));
        for s in &mut scores {
            s.left /= variance.sqrt().max(f64::MIN_POSITIVE);
        }
        Scores { blocks: scores, places, count: blocks.products.len(), value, inverse, variance }
    }

    /// Variance of what is left, as the blocks scatter.
    pub fn variance(&self) -> f64 {
        self.variance
    }

    /// How far the columns' coefficients are from zero: `s'I⁻¹s` over its expectation without an effect.
    pub fn statistic(&self) -> f64 {
        let sum = self.blocks.iter().fold(DVector::zeros(self.value.len()), |sum, b| sum + &b.score);
        sum.dot(&(&self.inverse * &sum)) / (self.variance * self.value.len() as f64).max(f64::MIN_POSITIVE)
    }

    /// The same where the blocks say what they scatter by, with other signs.
    pub fn by_chance(&self, signs: &[f64]) -> f64 {
        let sum = self
            .blocks
            .iter()
            .zip(signs)
            .fold(DVector::zeros(self.value.len()), |sum, (b, sign)| sum + &b.root * &b.left * *sign);
        sum.dot(&(&self.inverse * &sum)) / self.value.len() as f64
    }

    /// By how much the squared error of each block should fall, by its information; NaN where a block is not for fitting.
    pub fn expected_falls(&self) -> Vec<f64> {
        let mut falls = vec![f64::NAN; self.count];
        for (place, block) in self.places.iter().zip(&self.blocks) {
            falls[*place] = (&block.information * &self.value).dot(&self.value).max(0.0);
        }
        falls
    }

    /// What all blocks know of the columns.
    pub fn information(&self) -> DMatrix<f64> {
        let n = self.value.len();
        self.blocks.iter().fold(DMatrix::zeros(n, n), |sum, b| sum + &b.information)
    }

    /// By how much the uncertainty of the coefficients raises the squared error of blocks with such information, for a
    /// variance of one.
    pub fn uncertainty_for(&self, information: &DMatrix<f64>) -> f64 {
        (information * &self.inverse).trace()
    }

    /// The fitted coefficients.
    pub fn value(&self) -> &DVector<f64> {
        &self.value
    }
}

/// How sure a fall of the left-out squared error is, in standard errors: blocks count by the fall that their information
/// lets expect, `λ = Σd/Σe`, and scatter is that of `d − λe`, each without the block itself, but no less than that of
/// noise of this variance (`4 e σ²`). Where one block has all the information it is zero: one event is not enough.
pub fn informed(before: &[f64], after: &[f64], expected: &[f64], variance: f64) -> f64 {
    let blocks: Vec<(f64, f64)> = before
        .iter()
        .zip(after)
        .zip(expected)
        .map(|((a, b), e)| (a - b, *e))
        .filter(|(d, e)| d.is_finite() && e.is_finite())
        .collect();
    let (fall, all) = blocks.iter().fold((0.0, 0.0), |(d, e), b| (d + b.0, e + b.1));
    if blocks.len() < 4 || all.is_nan() || all <= 0.0 {
        return 0.0;
    }
    let mut scatter = 0.0;
    for (d, e) in &blocks {
        let leverage = e / all;
        if leverage > 0.95 {
            return 0.0;
        }
        scatter += ((d - fall / all * e) / (1.0 - leverage)).powi(2);
    }
    let scatter = scatter.max(4.0 * all * variance);
    if scatter > 0.0 { fall / scatter.sqrt() } else { 0.0 }
}

fn invert(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.nrows();
    let ridge = 1e-12 * matrix.trace() / n as f64 + f64::MIN_POSITIVE;
    let mut safe = matrix.clone();
    for i in 0..n {
        safe[(i, i)] += ridge;
    }
    safe.cholesky().map_or_else(|| DMatrix::zeros(n, n), |c| c.inverse())
}

/// A lower triangle whose square is the matrix; zero where that is none.
fn root(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.nrows();
    let mut safe = matrix.clone();
    let ridge = 1e-9 * matrix.trace().abs() / n as f64 + f64::MIN_POSITIVE;
    for i in 0..n {
        safe[(i, i)] += ridge;
    }
    safe.cholesky().map_or_else(|| DMatrix::zeros(n, n), |c| c.l())
}

fn solve_lower(root: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    root.solve_lower_triangular(right).filter(|v| v.iter().all(|x| x.is_finite())).unwrap_or_else(|| right * 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Blocks of one column with so much information and such a score each, beside no model.
    fn of(blocks: &[(f64, f64)]) -> Scores {
        let one =
            |(information, score): &(f64, f64)| DMatrix::from_row_slice(2, 2, &[*information, *score, *score, 99.0]);
        let blocks = Blocks { products: blocks.iter().map(one).collect(), counts: vec![10; blocks.len()] };
        Scores::new(&blocks, 0, |_| true)
    }

    /// β = 6/4; what is left, without the block's own part: −2/3, 2/3, 0; its mean square 8/27.
    #[test]
    fn blocks_weigh_by_their_information() {
        let scores = of(&[(1.0, 1.0), (1.0, 2.0), (2.0, 3.0)]);
        assert_relative_eq!(scores.value()[0], 1.5, max_relative = 1e-9);
        assert_relative_eq!(scores.variance(), 8.0 / 27.0, max_relative = 1e-6);
        assert_relative_eq!(scores.statistic(), 9.0 / (8.0 / 27.0), max_relative = 1e-6);
        assert_relative_eq!(scores.expected_falls()[..], [2.25, 2.25, 4.5], max_relative = 1e-9);
        // By chance: what they scatter by cancels, or adds up to 4/3 over √(8/27), squared over 4.
        assert_relative_eq!(scores.by_chance(&[1.0, 1.0, 1.0]), 0.0, epsilon = 1e-9);
        assert_relative_eq!(scores.by_chance(&[-1.0, 1.0, 1.0]), 1.5, max_relative = 1e-6);
        // Two blocks know it, the others nothing: these change neither the value nor the scatter of what is said.
        let few = of(&[(1.0, 1.0), (1.0, 1.1), (0.0, 0.0), (0.0, 0.0)]);
        let two = of(&[(1.0, 1.0), (1.0, 1.1)]);
        assert_relative_eq!(few.statistic(), two.statistic(), max_relative = 1e-6);
    }

    /// Beside a model the columns count with what the model does not make up of them.
    #[test]
    fn beside_a_model_the_value_is_that_of_the_whole_fit() {
        let noise = crate::identify::steady::noise;
        let rows = crate::identify::regression::Rows {
            log: vec![0; 300],
            block: (0..300).map(|k| k / 10).collect(),
            time: vec![0.0; 300],
            weight: Vec::new(),
            block_log: vec![0; 30],
            block_fits: vec![true; 30],
        };
        let model: Vec<f64> = (0..300).map(noise).collect();
        let own: Vec<f64> = (0..300).map(|k| 0.7 * model[k] + noise(k + 1000)).collect();
        let target: Vec<f64> = (0..300).map(|k| model[k] + 0.3 * own[k] + 0.2 * noise(k + 5000)).collect();
        let blocks = Blocks::new(&rows, &[&model, &own], &target);
        let scores = Scores::new(&blocks, 1, |_| true);
        let whole = solve(&blocks.total(|_| true));
        assert_relative_eq!(scores.value()[0], whole.coefficients[1], max_relative = 1e-9);
        // The noise is uniform and of variance 0.04/3, and the statistic (β/σ)² times the information.
        assert_relative_eq!(scores.variance(), 0.04 / 3.0, max_relative = 0.5);
        let by_hand = whole.coefficients[1].powi(2) / whole.inverse[(1, 1)] / scores.variance();
        assert_relative_eq!(scores.statistic(), by_hand, max_relative = 1e-9);
    }

    /// An effect that two of many blocks show is sure; one event is not, nor what some blocks gain and others lose.
    #[test]
    fn a_fall_is_as_sure_as_information_lets_it_be() {
        let before = [10.0; 12];
        let fall = |falls: &[f64]| -> Vec<f64> { before.iter().zip(falls).map(|(b, f)| b - f).collect() };
        let mut rare = [0.0; 12];
        (rare[3], rare[8]) = (6.0, 6.2);
        // Plain scatter between blocks would say 12.2/√(12 · 5.6) = 1.5.
        let sure = informed(&before, &fall(&rare), &rare, 0.01);
        assert_relative_eq!(sure, 12.2 / (4.0_f64 * 12.2 * 0.01).sqrt(), max_relative = 1e-6);
        let mut one = [0.0; 12];
        one[5] = 8.0;
        assert_eq!(informed(&before, &fall(&one), &one, 0.01), 0.0);
        let expected = [1.0; 12];
        let wild: Vec<f64> = (0..12).map(|k| if k % 2 == 0 { 7.0 } else { -5.0 }).collect();
        assert!(informed(&before, &fall(&wild), &expected, 0.01) < 1.0);
        assert!(informed(&before, &fall(&expected), &expected, 0.01) > 10.0);
        assert_eq!(informed(&before[..3], &before[..3], &expected[..3], 0.01), 0.0);
    }
}
