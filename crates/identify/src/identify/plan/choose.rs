//! Which passages, and in which order.
//!
//! The one idea: what passages say of a pair adds up as sums of products. So passages are taken one after the other, each the
//! one after which the pairs are told apart best, the weakest pair counting most; then each is exchanged where another one is
//! better. Every other effect counts as a rival too, so that the run brings up no third name. Of equals the parameters of the
//! models decide (D-optimality), and nothing else does.

use std::cmp::Ordering;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::question::Question;

/// Two choices whose pairs are as far apart to this share are equal.
const EQUAL: f64 = 1e-4;
/// A pair gains less than this δ² by the best run: no run tells it apart.
const HOPELESS: f64 = 1.0;

/// How good a choice is.
#[derive(Debug, Clone, Copy)]
struct Worth {
    /// The harmonic mean of δ² over the pairs.
    apart: f64,
    /// Logarithm of the determinant of the information.
    information: f64,
}

impl Worth {
    fn compare(&self, other: &Worth) -> Ordering {
        if (self.apart - other.apart).abs() > EQUAL * self.apart.max(other.apart) {
            return self.apart.total_cmp(&other.apart);
        }
        self.information.total_cmp(&other.information)
    }
}

/// What each passage says of each question: sums of products.
pub struct Said<'q> {
    questions: Vec<(&'q Question, Vec<DMatrix<f64>>)>,
    /// Whether the run can keep every other effect away, of each question.
    guards: Vec<bool>,
    count: usize,
}

/// Sums of products of a choice, for each question.
type Sums = Vec<DMatrix<f64>>;

impl<'q> Said<'q> {
    /// Of questions, each with what the passages say of it; those that the best run of `length` passages tells nothing of are
    /// left out, unless it is so for all.
    pub fn new(questions: Vec<(&'q Question, Vec<DMatrix<f64>>)>, length: usize) -> Said<'q> {
        let count = questions.iter().map(|(_, parts)| parts.len()).min().unwrap_or(0);
        let gains = |(question, parts): &(&Question, Vec<DMatrix<f64>>)| {
            let now = question.square_now();
            let best = parts.par_iter().map(|p| question.square(&(p * length as f64))).reduce(|| 0.0, f64::max);
            best - now > HOPELESS
        };
        let hopeful: Vec<bool> = questions.iter().map(gains).collect();
        let any = hopeful.iter().any(|h| *h);
        let questions = questions.into_iter().zip(hopeful).filter(|(_, h)| *h || !any).map(|(q, _)| q).collect();
        let guarded = |(question, parts): &(&Question, Vec<DMatrix<f64>>)| {
            let whole = |p: &DMatrix<f64>| question.square_guarded(&(p * length as f64));
            let now = question.square_guarded(&DMatrix::zeros(question.existing.nrows(), question.existing.nrows()));
            parts.par_iter().map(whole).reduce(|| 0.0, f64::max) - now > HOPELESS
        };
        let questions: Vec<(&Question, Vec<DMatrix<f64>>)> = questions;
        let guards = questions.iter().map(guarded).collect();
        Said { questions, guards, count }
    }

    fn nothing(&self) -> Sums {
        self.questions.iter().map(|(q, _)| q.existing.clone()).collect()
    }

    fn changed(&self, sums: &Sums, out: Option<usize>, into: usize) -> Sums {
        let one = |(sum, (_, parts)): (&DMatrix<f64>, &(&Question, Vec<DMatrix<f64>>))| match out {
            Some(out) => sum - &parts[out] + &parts[into],
            None => sum + &parts[into],
        };
        sums.iter().zip(&self.questions).map(one).collect()
    }

    fn worth(&self, sums: &Sums) -> Worth {
        let (mut inverse, mut information) = (0.0, 0.0);
        for ((sum, (question, _)), guarded) in sums.iter().zip(&self.questions).zip(&self.guards) {
            inverse += 1.0 / (1.0 + question.contest.square(sum));
            if *guarded {
                inverse += 1.0 / (1.0 + question.guarded.square(sum));
            }
            information += log_determinant(sum, question.contest.common);
        }
        Worth { apart: self.questions.len() as f64 / inverse, information }
    }

    /// The best of some passages to come next.
    fn best(&self, sums: &Sums, out: Option<usize>, of: &[usize]) -> Option<(usize, Worth)> {
        let all: Vec<(usize, Worth)> = of.par_iter().map(|k| (*k, self.worth(&self.changed(sums, out, *k)))).collect();
        // The first of equals, whatever the number of threads.
        all.into_iter().reduce(|best, next| if next.1.compare(&best.1) == Ordering::Greater { next } else { best })
    }

    /// So many passages, those that tell most first.
    pub fn choose(&self, length: usize) -> Vec<usize> {
        let all: Vec<usize> = (0..self.count).collect();
        let mut chosen = Vec::new();
        let mut sums = self.nothing();
        for _ in 0..length {
            let Some((next, _)) = self.best(&sums, None, &all) else { break };
            sums = self.changed(&sums, None, next);
            chosen.push(next);
        }
        for slot in &mut chosen {
            let now = self.worth(&sums);
            let out = *slot;
            if let Some((other, worth)) = self.best(&sums, Some(out), &all)
                && other != out
                && worth.compare(&now) == Ordering::Greater
            {
                sums = self.changed(&sums, Some(out), other);
                *slot = other;
            }
        }
        let mut ordered = Vec::new();
        let mut sums = self.nothing();
        while !chosen.is_empty() {
            let mut left = chosen.clone();
            left.sort_unstable();
            left.dedup();
            let next = self.best(&sums, None, &left).map_or(chosen[0], |(next, _)| next);
            sums = self.changed(&sums, None, next);
            if let Some(at) = chosen.iter().position(|k| *k == next) {
                chosen.remove(at);
            }
            ordered.push(next);
        }
        ordered
    }
}

/// Logarithm of the determinant of the first so many columns; those without information take no part.
fn log_determinant(products: &DMatrix<f64>, columns: usize) -> f64 {
    let own = products.view((0, 0), (columns, columns)).into_owned();
    own.symmetric_eigen().eigenvalues.iter().filter(|v| **v > 0.0).map(|v| v.ln()).sum()
}
