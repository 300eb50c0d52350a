//! Whether an effect travels: what some logs say of it, the others have to confirm.
//!
//! The one idea: a log weighs as much as it knows. One short log does not veto what the others are sure of, and one log
//! alone does not make a name; where logs differ beyond their errors, that is said.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::regression::{Blocks, solve, squares};
use super::scores::Scores;
use super::work::Work;
use nalgebra::{DMatrix, DVector};

/// Least share of what it should take away that an effect takes away of logs that it was not fitted on.
const TRAVELS: f64 = 0.3;
/// Least share of all information for a log to be asked whether it differs.
const KNOWN: f64 = 1e-4;
/// Chance below which logs are said to differ.
const DIFFER: f64 = 1e-3;

/// How the logs for fitting agree on columns beside the model: `Ok` with what is to be told of their disagreement.
///
/// # Errors
/// Why the logs do not carry it.
pub fn of(work: &Work, candidate: &[Vec<f64>]) -> Result<Option<String>, String> {
    let rows = &work.balance.rows;
    let mut logs: Vec<usize> = (0..rows.block_log.len()).filter(|b| work.fits(*b)).map(|b| rows.block_log[b]).collect();
    logs.dedup();
    if logs.len() < 2 {
        return Ok(None);
    }
    let mut columns = work.columns();
    let p = columns.len();
    columns.extend(candidate.iter().map(Vec::as_slice));
    let blocks = Blocks::new(rows, &columns, &work.target);
    let scores = Scores::new(&blocks, p, |b| work.fits(b));
    let variance = scores.variance().max(f64::MIN_POSITIVE);
    let together = scores.value();
    let of_all = scores.information();
    let plain: Vec<usize> = (0..p).collect();
    let model = blocks.select(&plain);
    let (mut falls, mut expected, mut heterogeneity, mut free) = (0.0, 0.0, 0.0, 0.0);
    let mut worst: Option<(f64, usize)> = None;
    for log in &logs {
        let own = |b: usize| work.fits(b) && rows.block_log[b] == *log;
        let others = |b: usize| work.fits(b) && rows.block_log[b] != *log;
        let of_others = Scores::new(&blocks, p, others);
        // The model's own numbers are refitted on the log: only what is asked has to travel.
        let of_model = model.total(own);
        let without = squares(&of_model, &solve(&of_model).coefficients);
        let fall = without - squares_given(&blocks.total(own), p, of_others.value().as_slice());
        let alone = Scores::new(&blocks, p, own);
        let information = &alone.information();
        // What the others know of it is uncertain, too: that alone would do harm.
        let they_say = (information * of_others.value()).dot(of_others.value());
        if 4.0 * variance * of_others.uncertainty_for(information) > they_say {
            continue;
        }
        let should = (information * together).dot(together).max(0.0);
        falls += fall;
        expected += should;
        if fall < 0.0 && worst.is_none_or(|(w, _)| fall < w) && fall < -2.0 * (4.0 * should * variance).sqrt() {
            worst = Some((fall, *log));
        }
        if information.trace() > KNOWN * of_all.trace() {
            let off: DVector<f64> = alone.value() - together;
            heterogeneity += (information * &off).dot(&off) / variance;
            free += candidate.len() as f64;
        }
    }
    let name = |log: usize| &work.balance.names[log];
    // What differs between logs alone (a temperature, a drift) has hardly any information within one: nothing is said then.
    if falls < TRAVELS * expected - 2.0 * (4.0 * expected * variance).sqrt() {
        let what = match worst {
            Some((_, log)) => format!("fitted on the other logs it makes `{}` worse", name(log)),
            None => "fitted on some logs it does not lower the error of the others".into(),
        };
        return Err(what);
    }
    let free = free - candidate.len() as f64;
    let chance = if free > 0.0 && heterogeneity.is_finite() {
        ChiSquared::new(free).map_or(1.0, |law| 1.0 - law.cdf(heterogeneity))
    } else {
        1.0
    };
    let told = worst.map(|(_, log)| format!("fitted on the other logs it makes `{}` worse", name(log))).or_else(|| {
        let spread = (heterogeneity / free.max(1.0)).sqrt();
        (chance < DIFFER && spread > 2.0)
            .then(|| format!("from log to log it scatters by {spread:.1} times its own error"))
    });
    Ok(told)
}

/// Sum of squares with the last coefficients given and the first `p` fitted.
fn squares_given(total: &DMatrix<f64>, p: usize, given: &[f64]) -> f64 {
    // New columns from old: the model's own, and the target less the given part.
    let mut map = DMatrix::zeros(total.nrows(), p + 1);
    for i in 0..p {
        map[(i, i)] = 1.0;
    }
    for (j, value) in given.iter().enumerate() {
        map[(p + j, p)] = -value;
    }
    map[(total.nrows() - 1, p)] = 1.0;
    let small = map.transpose() * total * map;
    squares(&small, &solve(&small).coefficients)
}

#[cfg(test)]
mod tests {
    use super::super::steady::{CONSTANT, bench, noise, work};
    use super::*;
    use gearwise_model::effects::effect;

    const RATIO: f64 = 6.0;

    /// What logs say of Coulomb friction of so much each, with the largest friction first.
    fn said(friction: &[f64], points: usize) -> Result<Option<String>, String> {
        let log = |log: usize| -> Vec<[f64; 3]> {
            let point = |k: usize| {
                let place = 300 * log + k;
                let (w, i) = (100.0 * noise(place), 5.0 * noise(place + 5000));
                [w, i, RATIO * (CONSTANT * i - friction[log] * w.signum()) + 0.03 * noise(place + 9000)]
            };
            (0..points).map(point).collect()
        };
        let logs: Vec<Vec<[f64; 3]>> = (0..friction.len()).map(log).collect();
        let bench = bench(RATIO, &logs, 0);
        let work = work(&bench);
        let columns = work.balance.effect_columns(effect("coulomb_friction").unwrap(), 0.0);
        of(&work, &columns)
    }

    #[test]
    fn what_logs_confirm_travels_and_what_they_deny_does_not() {
        let worse = |log: usize| format!("fitted on the other logs it makes `{log}.csv` worse");
        assert_eq!(said(&[0.05, 0.05, 0.05], 300), Ok(None));
        // The opposite in one of three, or in one of two: it is no friction.
        assert_eq!(said(&[0.05, -0.05, 0.05], 300), Err(worse(1)));
        assert!(said(&[0.05, -0.05], 300).is_err());
        // One log without it does not veto what two are sure of; it is told.
        assert_eq!(said(&[0.05, 0.05, 0.0], 300), Ok(Some(worse(2))));
        // Different sizes are told as scatter.
        let told = said(&[0.05, 0.05, 0.03], 300).unwrap().unwrap_or_default();
        assert!(told.contains("from log to log it scatters by"), "{told}");
        // One log has nobody to object.
        assert_eq!(said(&[0.05], 300), Ok(None));
    }

    /// With the last coefficients given, the others are fitted to what they leave.
    #[test]
    fn squares_with_given_coefficients() {
        let columns: [Vec<f64>; 3] = [0, 1, 2].map(|j| (0..50).map(|k| noise(100 * j + k)).collect());
        let target: Vec<f64> = (0..50).map(|k| noise(700 + k)).collect();
        let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).chain([target.as_slice()]).collect();
        let total = DMatrix::from_fn(4, 4, |i, j| all[i].iter().zip(all[j]).map(|(a, b)| a * b).sum());
        for given in [[0.0, 0.0], [0.4, -0.7]] {
            let rest: Vec<f64> =
                (0..50).map(|k| target[k] - given[0] * columns[1][k] - given[1] * columns[2][k]).collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let beta = dot(&columns[0], &rest) / dot(&columns[0], &columns[0]);
            let left = dot(&rest, &rest) - beta * beta * dot(&columns[0], &columns[0]);
            assert!((squares_given(&total, 1, &given) - left).abs() < 1e-9);
        }
    }
}
