//! The logs, and how they judge a model: on logs, or stretches of time, that were left out of its fit.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::candidate::Candidate;
use crate::simulate::model::{Counted, Model};
use crate::simulate::track::Track;

/// Least share of the left-out error that an effect must take away.
pub(super) const WORTH: f64 = 0.03;
/// Length of the stretches of time that judge, several times what the error of a closed loop remembers \[s\].
const BLOCK: f64 = 1.5;
/// So many logs are left out as wholes.
pub(super) const ENOUGH_LOGS: usize = 4;
/// So many logs judge as wholes: stretches of one log are not independent.
const MANY_LOGS: usize = 8;
/// Most folds.
const FOLDS: usize = 6;
/// Rounds of the first fit of a candidate, with its shape as it is.
const FIRST_ROUNDS: usize = 3;
/// Draws of the test by random signs.
const DRAWS: usize = 20_000;

/// The logs and how they judge.
pub(super) struct Judges<'a> {
    pub fit: Vec<&'a Track>,
    /// Unit of each sample of each track.
    pub unit: Vec<Vec<usize>>,
    /// Fold of each unit.
    pub fold: Vec<usize>,
    folds: usize,
    pub samples: usize,
}

impl<'a> Judges<'a> {
    /// Which logs, or stretches of them, judge together.
    pub fn new(all: &'a [Track]) -> Judges<'a> {
        let fit: Vec<&Track> = all.iter().filter(|t| t.fits).collect();
        let whole = fit.len() >= ENOUGH_LOGS;
        let (mut unit, mut fold, mut count) = (Vec::new(), Vec::new(), 0);
        for (index, track) in fit.iter().enumerate() {
            let length = track.time[track.len() - 1] - track.time[0];
            let blocks = if fit.len() >= MANY_LOGS { 1 } else { ((length / BLOCK).round() as usize).max(1) };
            let at = |t: f64| (((t - track.time[0]) / length * blocks as f64) as usize).min(blocks - 1);
            unit.push(track.time.iter().map(|t| count + at(*t)).collect());
            // With few logs neighbouring stretches are in different folds.
            fold.extend((0..blocks).map(|b| if whole { index } else { b }));
            count += blocks;
        }
        let folds = fold.iter().max().map_or(1, |m| m + 1).min(FOLDS);
        fold.iter_mut().for_each(|f| *f %= folds);
        let samples = fit.iter().map(|t| t.count()).sum::<usize>().max(1);
        Judges { fit, unit, fold, folds, samples }
    }

    fn counted(&self, fold: usize) -> Counted {
        self.unit.iter().map(|units| units.iter().map(|u| self.fold[*u] != fold).collect()).collect()
    }

    /// Squared error of each unit, simulated with what the other folds say.
    pub fn left_out(&self, model: &Model) -> Vec<f64> {
        let mut squares = vec![0.0; self.fold.len()];
        for fold in 0..self.folds {
            let mut trial = model.clone();
            let counted = self.counted(fold);
            let seen: Vec<usize> = (0..self.fit.len()).filter(|t| counted[*t].iter().any(|c| *c)).collect();
            let part: Vec<&Track> = seen.iter().map(|t| self.fit[*t]).collect();
            trial.fit(&part, &seen.iter().map(|t| counted[*t].clone()).collect(), 5, 2e-3);
            let judged: Vec<usize> = (0..self.fit.len()).filter(|t| counted[*t].iter().any(|c| !c)).collect();
            let residuals = trial.residuals(&judged.iter().map(|t| self.fit[*t]).collect::<Vec<_>>());
            for (t, residual) in judged.iter().zip(&residuals) {
                for ((r, c), u) in residual.iter().zip(&counted[*t]).zip(&self.unit[*t]) {
                    if !c {
                        squares[*u] += r * r;
                    }
                }
            }
        }
        squares
    }

    /// Root mean square error of squared errors of all units.
    pub fn error(&self, squares: &[f64]) -> f64 {
        (squares.iter().sum::<f64>() / self.samples as f64).sqrt()
    }

    /// How many standard errors the amount of a candidate is from nothing: of two amplitudes their vector, as one value.
    pub fn beyond_its_error(&self, with: &Model, candidate: Candidate) -> f64 {
        let own: Vec<usize> = (0..with.slots.len()).filter(|k| candidate.is_amount(with, with.slots[*k])).collect();
        let matrix = covariance(with, self);
        let value = nalgebra::DVector::from_iterator(own.len(), own.iter().map(|k| with.get(with.slots[*k])));
        let matrix = nalgebra::DMatrix::from_fn(own.len(), own.len(), |a, b| matrix[(own[a], own[b])]);
        let squared = matrix.try_inverse().map_or(f64::NAN, |inverse| value.dot(&(inverse * &value)));
        (squared / own.len() as f64).max(0.0).sqrt()
    }

    /// Fits a model to all logs; its root mean square error.
    pub fn fit(&self, model: &mut Model, rounds: usize, enough: f64) -> f64 {
        let cost = model.fit(&self.fit, &Counted::new(), rounds, enough);
        (cost / self.samples as f64).sqrt()
    }

    /// The best fit over the places to start from.
    pub fn fit_added(&self, candidate: Candidate, model: &Model, rounds: usize, enough: f64) -> Option<(Model, f64)> {
        let mut starts = candidate.added(model);
        // From nothing, with its shape as it is: what the others have taken of it they give back.
        for mut start in candidate.starting_at_nothing(model) {
            let slots = start.slots.clone();
            start.slots = slots.iter().copied().filter(|slot| !candidate.is_shape(&start, *slot)).collect();
            self.fit(&mut start, FIRST_ROUNDS, enough);
            start.slots = slots;
            starts.push(start);
        }
        let squares = |m: &Model| m.residuals(&self.fit).iter().flatten().map(|r| r * r).sum::<f64>();
        let costs: Vec<f64> = starts.iter().map(squares).collect();
        let best = (0..starts.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
        let mut with = starts[best].clone();
        let error = self.fit(&mut with, rounds, enough);
        Some((with, error))
    }
}

/// Probability that gains as large as these come about where there is none: signs at random, stretch by
/// stretch.
pub(super) fn chance(before: &[f64], after: &[f64]) -> f64 {
    let gains: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
    let sum: f64 = gains.iter().sum();
    if gains.len() < 2 || sum <= 0.0 {
        return 1.0;
    }
    let mut random = Pcg64::seed_from_u64(1);
    let as_large = (0..DRAWS)
        .filter(|_| {
            let mut word = 0;
            let drawn: f64 = gains
                .iter()
                .enumerate()
                .map(|(k, g)| {
                    if k % 64 == 0 {
                        word = random.next_u64();
                    }
                    let sign = (word >> (k % 64)) & 1;
                    if sign == 1 { *g } else { -g }
                })
                .sum();
            drawn >= sum * (1.0 - 1e-12)
        })
        .count();
    (as_large + 1) as f64 / (DRAWS + 1) as f64
}

/// Covariance of the unknowns, from the logs or stretches as independent judges.
pub(super) fn covariance(model: &Model, judges: &Judges) -> nalgebra::DMatrix<f64> {
    let n = model.slots.len();
    let (at, columns) = model.derivatives(&judges.fit);
    let mut normal = nalgebra::DMatrix::<f64>::zeros(n, n);
    let mut scores = nalgebra::DMatrix::<f64>::zeros(n, judges.fold.len());
    for (t, units) in judges.unit.iter().enumerate() {
        for (k, unit) in units.iter().enumerate() {
            for a in 0..n {
                scores[(a, *unit)] += columns[t][a][k] * at[t][k];
                for b in 0..=a {
                    normal[(a, b)] += columns[t][a][k] * columns[t][b][k];
                }
            }
        }
    }
    normal.fill_upper_triangle_with_lower_triangle();
    // Scaled, so that inversion does not see units.
    let size: Vec<f64> = (0..n).map(|j| normal[(j, j)].sqrt().max(f64::MIN_POSITIVE)).collect();
    let scaled = nalgebra::DMatrix::from_fn(n, n, |a, b| normal[(a, b)] / (size[a] * size[b]));
    let Some(inverse) = scaled.try_inverse() else { return nalgebra::DMatrix::from_element(n, n, f64::NAN) };
    let inverse = nalgebra::DMatrix::from_fn(n, n, |a, b| inverse[(a, b)] / (size[a] * size[b]));
    let units = judges.fold.len() as f64;
    let spread = &scores * scores.transpose() * (units / (units - 1.0).max(1.0));
    &inverse * spread * &inverse
}
