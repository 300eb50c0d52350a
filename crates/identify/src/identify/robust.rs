//! How much each row weighs: few wild rows do not own the answer.
//!
//! The one idea: what no function of speed, current or torque comes near is no evidence about such functions. Around a
//! reversal bristles bend and a late sample is off by twice the friction; such rows may be forty times further off than the
//! others, and a hundredth of them then hold most of the squared error. So a row counts with at most the square of
//! [`FAR`] times the usual error of its log. Usual is what nine of ten rows say: where more rows are far off,
//! that is not wild but what is there.

use super::balance::Balance;
use super::hats::hats;
use super::regression::{Blocks, Rows, residual, solve};
use crate::answer::Target;
use crate::signals;
use gearwise_model::effects::Variable;

/// Times the usual error of its log from which a row weighs less: none of a million of normal noise.
pub const FAR: f64 = 5.0;
/// A standard deviation of normal noise, in medians of its absolute value and in quantiles that nine of ten lie below.
const NORMAL: (f64, f64) = (1.4826, 1.0 / 1.6449);
/// Fewest rows of a log whose usual error is known.
const FEWEST: usize = 200;
/// Share of the squared error that wild rows hold beyond what they weigh, from which it is said.
const OWN: f64 = 0.05;
/// How often weights and fit follow each other.
const ROUNDS: usize = 2;

/// The usual error of each log, of its rows for fitting where it has such; infinite where it is not known.
fn usual(rows: &Rows, left: &[f64]) -> Vec<f64> {
    let fits: Vec<bool> = (0..rows.logs()).map(|log| rows.fits(log)).collect();
    let mut of_logs: Vec<Vec<f64>> = vec![Vec::new(); rows.logs()];
    for k in (0..rows.len()).filter(|k| rows.block_fits[rows.block[*k]] || !fits[rows.log[*k]]) {
        of_logs[rows.log[k]].push(left[k].abs());
    }
    let usual = |errors: Vec<f64>| {
        if errors.len() < FEWEST {
            return f64::INFINITY;
        }
        let middle = signals::median(errors.clone()).unwrap_or(0.0) * NORMAL.0;
        let most = signals::quantile(errors, 0.9).unwrap_or(0.0) * NORMAL.1;
        if most > 0.0 { middle.max(most) } else { f64::INFINITY }
    };
    of_logs.into_iter().map(usual).collect()
}

/// Weights of rows that a model leaves so much of; empty where all weigh one.
fn weights(rows: &Rows, left: &[f64]) -> Vec<f64> {
    let usual = usual(rows, left);
    let weight = |k: usize| (left[k].abs() / (FAR * usual[rows.log[k]])).max(1.0).powi(-2);
    let weights: Vec<f64> = (0..rows.len()).map(weight).collect();
    if weights.iter().all(|w| *w == 1.0) { Vec::new() } else { weights }
}

/// What columns leave of a target where wild rows weigh less, row by row, and these weights.
fn fitted(rows: &Rows, columns: &[&[f64]], target: &[f64]) -> (Vec<f64>, Rows) {
    let mut rows = Rows { weight: Vec::new(), ..rows.clone() };
    let mut left = Vec::new();
    for _ in 0..ROUNDS {
        let total = Blocks::new(&rows, columns, target).total(|b| rows.block_fits[b]);
        let coefficients = solve(&total).coefficients;
        left = residual(target, columns, &coefficients);
        rows.weight = weights(&rows, &left);
        if rows.weight.is_empty() {
            break;
        }
    }
    (left, rows)
}

/// Squared errors of the blocks for fitting under columns, of which wild rows have no more than others may.
pub fn errors(rows: &Rows, columns: &[&[f64]], target: &[f64]) -> Vec<f64> {
    let (left, weighed) = fitted(rows, columns, target);
    let mut sums = vec![0.0; rows.block_log.len()];
    for (k, l) in left.iter().enumerate() {
        sums[rows.block[k]] += weighed.weight(k) * l * l;
    }
    sums.into_iter().zip(&rows.block_fits).filter(|(_, fits)| **fits).map(|(sum, _)| sum).collect()
}

/// Columns of any function of what the bench measures, beside the declared model.
fn anything(balance: &Balance) -> Vec<Vec<f64>> {
    let mut columns: Vec<Vec<f64>> = (0..balance.base.len()).map(|i| balance.base_column(i)).collect();
    let has = |v: Variable| balance.variables.contains(&v) && !balance.is_response(v);
    if has(Variable::Speed) {
        columns.push(balance.function(|at| at.direction));
        let speeds = balance.variable(false, |at| at.speed);
        columns.extend(hats(&balance.rows, &speeds).iter().map(|hat| balance.function(|at| hat(at.speed))));
    }
    if has(Variable::Current) {
        columns.push(balance.function(|at| at.current.signum()));
        let currents = balance.variable(false, |at| at.current);
        columns.extend(hats(&balance.rows, &currents).iter().map(|hat| balance.function(|at| hat(at.current))));
    }
    if has(Variable::Torque) {
        columns.push(balance.function(|at| at.torque.abs() * at.direction));
        if balance.target == Target::WindUp {
            columns.push(balance.function(|at| at.torque.signum()));
            let torques = balance.variable(false, |at| at.torque);
            columns.extend(hats(&balance.rows, &torques).iter().map(|hat| balance.function(|at| hat(at.torque))));
        }
    }
    if balance.target == Target::Drive {
        columns.push(balance.function(|_| 1.0));
    }
    columns.retain(|c| c.iter().all(|v| v.is_finite()) && c.iter().any(|v| *v != 0.0));
    columns
}

/// The share of the rows for fitting that weigh less, where they hold much of what is left.
pub fn far_off(rows: &Rows, left: &[f64]) -> Option<f64> {
    let fits: Vec<usize> = (0..rows.len()).filter(|k| rows.block_fits[rows.block[*k]]).collect();
    let far = fits.iter().filter(|k| rows.weight(**k) < 1.0).count();
    let squares = |weight: &dyn Fn(usize) -> f64| fits.iter().map(|k| weight(*k) * left[*k] * left[*k]).sum::<f64>();
    let all = squares(&|_| 1.0);
    (far > 0 && all - squares(&|k| rows.weight(k)) > OWN * all).then(|| far as f64 / fits.len() as f64)
}

/// Says how much each row of a balance weighs.
pub fn weigh(balance: &mut Balance) {
    if balance.step() == 0.0 {
        return;
    }
    balance.rows.weight = Vec::new();
    let columns = anything(balance);
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    balance.rows.weight = fitted(&balance.rows, &columns, &balance.target_column()).1.weight;
}

#[cfg(test)]
mod tests {
    use super::super::steady::noise;
    use super::*;

    /// Rows of one log, a column, and twice that with noise where rows before `far` of each hundred are far off.
    fn example(count: usize, far: usize) -> (Rows, Vec<f64>, Vec<f64>) {
        let rows = Rows {
            log: vec![0; count],
            block: (0..count).map(|k| k / 20).collect(),
            time: (0..count).map(|k| k as f64).collect(),
            weight: Vec::new(),
            block_log: vec![0; count.div_ceil(20)],
            block_fits: vec![true; count.div_ceil(20)],
        };
        let column: Vec<f64> = (0..count).map(|k| noise(k + 700)).collect();
        let off = |k: usize| if k % 100 < far { 8.0 + column[k] } else { 0.0 };
        let target = (0..count).map(|k| 2.0 * column[k] + 0.1 * noise(k) + off(k)).collect();
        (rows, column, target)
    }

    fn coefficient(rows: &Rows, column: &[f64], target: &[f64]) -> f64 {
        solve(&Blocks::new(rows, &[column], target).total(|_| true)).coefficients[0]
    }

    #[test]
    fn few_wild_rows_do_not_own_the_fit() {
        let (rows, column, target) = example(2000, 2);
        let (_, weighed) = fitted(&rows, &[&column], &target);
        assert!((coefficient(&rows, &column, &target) - 2.0).abs() > 0.02);
        assert!((coefficient(&weighed, &column, &target) - 2.0).abs() < 0.005);
        for (k, weight) in weighed.weight.iter().enumerate() {
            assert!(if k % 100 < 2 { *weight < 0.01 } else { *weight == 1.0 }, "{k}: {weight}");
        }
        // A wild row has at most the square of five times the usual error.
        let most = errors(&rows, &[&column], &target).into_iter().fold(0.0, f64::max);
        assert!(most < 20.0 * 0.01 + 2.0 * (5.0 * 0.1_f64).powi(2), "{most}");
    }

    /// Noise of every row, and what a fifth of them has, is not wild; nor is it known what is where rows are few.
    #[test]
    fn what_many_rows_have_is_not_wild() {
        for (count, far) in [(2000, 0), (2000, 20), (150, 2)] {
            let (rows, column, target) = example(count, far);
            assert!(fitted(&rows, &[&column], &target).1.weight.is_empty(), "{count} {far}");
        }
    }

    /// Rows that only judge weigh by their own log, and say nothing of the others.
    #[test]
    fn what_is_held_out_does_not_say_what_is_wild() {
        let (rows, column, target) = example(2000, 2);
        let held = |factor: f64| {
            let rows = Rows {
                log: (0..2000).map(|k| k / 1000).collect(),
                block_log: (0..100).map(|b| b / 50).collect(),
                block_fits: (0..100).map(|b| b < 50).collect(),
                ..rows.clone()
            };
            let target: Vec<f64> = (0..2000).map(|k| if k < 1000 { target[k] } else { factor * target[k] }).collect();
            fitted(&rows, &[&column], &target).1.weight[..1000].to_vec()
        };
        assert_eq!(held(1.0), held(50.0));
    }
}
