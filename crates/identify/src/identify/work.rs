//! The model at some point of the story: its terms, their columns, and its fit.

use std::sync::Arc;

use super::balance::{Balance, Weight, visible};
use super::noise::Unfiltered;
use super::orders::Ripple;
use super::regression::{Blocks, Solution, residual, solve};
use super::robust;
use crate::answer::{Base, Hidden, Stage, Step, Target};
use crate::{Bench, Use};
use gearwise_model::effects::{Effect, FittedEffect, of_efficiency, of_weight};
use gearwise_model::numerics::sums::finite_sum;

/// A term of the model: a parameter of the declared model or an effect.
#[derive(Debug, Clone)]
pub struct Term {
    /// Which.
    pub kind: Kind,
    /// Its columns, one for each linear parameter.
    pub columns: Vec<Vec<f64>>,
    /// Values that the declared model has, linear parameters.
    pub declared: Option<Vec<f64>>,
}

/// What a term is.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// The n-th parameter of the declared model.
    Base(usize),
    /// An effect with its shape parameter.
    Effect(&'static dyn Effect, f64),
}

impl Term {
    /// The effect, where it is one.
    pub fn effect(&self) -> Option<(&'static dyn Effect, f64)> {
        match self.kind {
            Kind::Base(_) => None,
            Kind::Effect(effect, shape) => Some((effect, shape)),
        }
    }
}

/// The model at some point of the story, fitted.
#[derive(Clone)]
pub struct Fit {
    /// Sums of products of all columns.
    pub blocks: Blocks,
    /// Coefficients in the order of the terms' columns.
    pub solution: Solution,
    /// Squared error of each block that is for fitting, left out with its fold.
    pub left_out: Vec<f64>,
}

/// Everything that the steps share.
#[derive(Clone)]
pub struct Work<'a> {
    /// The bench.
    pub bench: &'a Bench,
    /// The equation.
    pub balance: Arc<Balance>,
    /// Target less what is known and less what is fixed.
    pub target: Vec<f64>,
    /// The model so far.
    pub terms: Vec<Term>,
    /// Declared effects that stay as declared, because they are made of the response.
    pub fixed: Vec<FittedEffect>,
    /// What repeats with an angle, found at full bandwidth and taken out of the target.
    pub ripple: Option<Arc<Ripple>>,
    /// Fold of each block; `None` judges only.
    pub folds: Vec<Option<usize>>,
}

impl<'a> Work<'a> {
    /// The model as declared on a balance: its parameters, and its effects where they can be seen.
    pub fn new(bench: &'a Bench, mut balance: Balance) -> Work<'a> {
        robust::weigh(&mut balance);
        let mut next = 0;
        let folds = balance
            .rows
            .block_fits
            .iter()
            .map(|fits| {
                fits.then(|| {
                    next += 1;
                    (next - 1) % 8
                })
            })
            .collect();
        let mut target = balance.target_column();
        let (mut terms, mut fixed) = (Vec::new(), Vec::new());
        for (index, base) in balance.base.iter().enumerate() {
            let column = balance.base_column(index);
            if column.iter().any(|v| *v != 0.0) {
                terms.push(Term {
                    kind: Kind::Base(index),
                    columns: vec![column],
                    declared: base.declared.map(|d| vec![d]),
                });
            }
        }
        for FittedEffect { effect, values } in bench.declared.all_effects() {
            let seen = visible(effect, &balance, &bench.declared);
            if let Err(Hidden::Response(_)) = seen {
                let factor = balance.conversion(effect);
                let column = balance.function(|at| factor * effect.value(&values, at));
                target.iter_mut().zip(column).for_each(|(t, c)| *t -= c);
                fixed.push(FittedEffect { effect, values });
            } else if seen.is_ok() {
                let shape = values.get(effect.linear()).copied().unwrap_or(0.0);
                terms.push(Term {
                    kind: Kind::Effect(effect, shape),
                    columns: balance.effect_columns(effect, shape),
                    declared: Some(values[..effect.linear()].to_vec()),
                });
            }
        }
        Work { bench, balance: Arc::new(balance), target, terms, fixed, ripple: None, folds }
    }

    /// Takes what repeats with an angle out of the target.
    pub fn take_out(&mut self, ripple: &Ripple) {
        for fitted in ripple.effects() {
            let factor = self.balance.conversion(fitted.effect);
            let column = self.balance.function(|at| factor * fitted.effect.value(&fitted.values, at));
            self.target.iter_mut().zip(column).for_each(|(t, c)| *t -= c);
        }
        self.ripple = Some(Arc::new(ripple.clone()));
    }

    /// Effects that were found on another balance of the same logs, with their columns of this one.
    pub fn add_again(&mut self, terms: Vec<Term>) {
        for term in terms {
            if let (Kind::Effect(effect, shape), None) = (term.kind, &term.declared) {
                let columns = self.balance.effect_columns(effect, shape);
                self.terms.push(Term { columns, ..term });
            }
        }
    }

    /// Columns of the terms, one after the other.
    pub fn columns(&self) -> Vec<&[f64]> {
        self.terms.iter().flat_map(|t| &t.columns).map(Vec::as_slice).collect()
    }

    /// Columns of all terms but one.
    pub fn columns_without(&self, term: usize) -> Vec<&[f64]> {
        let others = self.terms.iter().enumerate().filter(|(k, _)| *k != term);
        others.flat_map(|(_, t)| &t.columns).map(Vec::as_slice).collect()
    }

    /// Left-out errors of the model without one of its terms.
    pub fn left_out_without(&self, term: usize) -> Vec<f64> {
        self.fit_columns(&self.columns_without(term)).left_out
    }

    /// Whether a block is for fitting.
    pub fn fits(&self, block: usize) -> bool {
        self.folds[block].is_some()
    }

    /// Fits columns.
    pub fn fit_columns(&self, columns: &[&[f64]]) -> Fit {
        let blocks = Blocks::new(&self.balance.rows, columns, &self.target);
        let solution = solve(&blocks.total(|b| self.fits(b)));
        let left_out = blocks.left_out(&self.folds);
        Fit { blocks, solution, left_out }
    }

    /// Fits the model as it is.
    pub fn fit(&self) -> Fit {
        self.fit_columns(&self.columns())
    }

    /// What the model leaves of the logs for fitting, unfiltered; what is not fitted stays as declared.
    pub fn unfiltered(&self, coefficients: &[f64]) -> Vec<Unfiltered> {
        let mut base: Vec<f64> =
            self.balance.base.iter().map(|b| b.declared.filter(|d| d.is_finite()).unwrap_or(0.0)).collect();
        let mut effects = self.fixed.clone();
        effects.extend(self.ripple.iter().flat_map(|r| r.effects()));
        for (t, term) in self.terms.iter().enumerate() {
            let own = &coefficients[self.offset(t)..self.offset(t) + term.columns.len()];
            match term.kind {
                Kind::Base(index) => base[index] = own[0],
                Kind::Effect(effect, shape) => {
                    let mut values = own.to_vec();
                    values.push(shape);
                    effects.push(FittedEffect { effect, values });
                }
            }
        }
        let fits = |log: usize| self.bench.logs[log].usage == Use::Fit;
        self.balance.unfiltered(fits, &base, &effects)
    }

    /// What the model leaves of the target, row by row.
    pub fn residual(&self, fit: &Fit) -> Vec<f64> {
        self.left_by(&self.columns(), fit)
    }

    /// The same of any columns with their fit.
    pub fn left_by(&self, columns: &[&[f64]], fit: &Fit) -> Vec<f64> {
        residual(&self.target, columns, &fit.solution.coefficients)
    }

    /// Root mean square error and variance accounted for of columns with their fit, on blocks for fitting or on the others: of
    /// each row as much as it weighs.
    pub fn error(&self, columns: &[&[f64]], fit: &Fit, fitting: bool) -> Option<(f64, f64)> {
        self.balance.rows.error(&self.left_by(columns, fit), &self.target, fitting)
    }

    /// What is left of each row, as much as it weighs.
    pub fn weighed(&self, mut left: Vec<f64>) -> Vec<f64> {
        left.iter_mut().enumerate().for_each(|(k, l)| *l *= self.balance.rows.weight(k));
        left
    }

    /// Where the story stands.
    pub fn stage(&self, step: Step, fit: &Fit) -> Stage {
        let columns = self.columns();
        Stage::new(step, self.error(&columns, fit, true), self.error(&columns, fit, false))
    }

    /// Root mean square of left-out squared errors of the blocks, of all rows alike: with what is left beyond what rows weigh.
    pub fn of_all_rows(&self, left: &[f64], left_out: &[f64]) -> f64 {
        let rows = &self.balance.rows;
        let fits: Vec<usize> = (0..rows.len()).filter(|k| self.fits(rows.block[*k])).collect();
        let wild: f64 = fits.iter().map(|k| (1.0 - rows.weight(*k)) * left[*k] * left[*k]).sum();
        ((finite_sum(left_out) + wild) / fits.len().max(1) as f64).sqrt()
    }

    /// Mean squared error that the model leaves, each block left out of the fit in turn.
    pub fn left_out_per_row(&self) -> f64 {
        let rows = self.balance.rows.block.iter().filter(|b| self.fits(**b)).count();
        finite_sum(&self.fit().left_out) / rows.max(1) as f64
    }

    /// Whether a term is this parameter of the declared model.
    pub fn is_base(&self, term: usize, which: Base) -> bool {
        matches!(self.terms[term].kind, Kind::Base(i) if self.balance.base[i].which == which)
    }

    /// What a term is called.
    pub fn name(&self, term: usize) -> String {
        match self.terms[term].kind {
            Kind::Base(index) => self.balance.base[index].which.name().replace('_', " "),
            Kind::Effect(effect, _) => effect.title(),
        }
    }

    /// The index of the first column of a term.
    pub fn offset(&self, term: usize) -> usize {
        self.terms[..term].iter().map(|t| t.columns.len()).sum()
    }

    /// The load that was found and that nobody declared: its weight, and the inertia that is there beyond the declared one.
    pub fn fitted_weight(&self) -> Option<Weight> {
        let is_weight = |t: &usize| self.terms[*t].effect().is_some_and(|(e, _)| Some(e) == of_weight());
        let term = (0..self.terms.len()).find(is_weight).filter(|_| self.balance.target == Target::Drive)?;
        let (solution, at) = (self.fit().solution, self.offset(term));
        let inertia = (0..self.terms.len()).find(|t| self.is_base(*t, Base::Inertia)).map_or(0.0, |t| {
            let declared = self.terms[t].declared.as_ref().map_or(0.0, |d| d[0]);
            (solution.coefficients[self.offset(t)] - declared).max(0.0)
        });
        Some(Weight { sine: solution.coefficients[at], cosine: solution.coefficients[at + 1], inertia })
    }

    /// The factor of load-dependent friction that was found; zero where there is none.
    pub fn gear_loss(&self) -> f64 {
        let term =
            (0..self.terms.len()).find(|t| self.terms[*t].effect().is_some_and(|(e, _)| Some(e) == of_efficiency()));
        term.map_or(0.0, |t| self.fit().solution.coefficients[self.offset(t)].clamp(0.0, 0.9))
    }

    /// Torque constant and inertia of the motor as a torque sensor shows them. `None` on other equations, where the declared constant
    /// agrees, and where a number that is held has no declared value.
    pub fn fitted_shaft(&self) -> Option<[f64; 2]> {
        const AGREES: f64 = 0.01;
        if self.balance.target != Target::Torque {
            return None;
        }
        let solution = self.fit().solution;
        let both = |which: Base| {
            let declared = self.balance.base.iter().find(|b| b.which == which)?.declared;
            let term = (0..self.terms.len()).find(|t| self.is_base(*t, which));
            Some((declared, term.map_or(declared, |t| Some(solution.coefficients[self.offset(t)]))?))
        };
        let ((declared, constant), (_, inertia)) = (both(Base::TorqueConstant)?, both(Base::Inertia)?);
        let agrees = declared.is_some_and(|declared| (constant / declared - 1.0).abs() <= AGREES);
        (!agrees).then_some([constant, inertia])
    }
}
