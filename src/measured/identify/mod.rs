//! Declared model against logs: what the model lacks, by how much, and how sure that is.
//!
//! The one idea: every explanation has to earn its name. Corrections of the measurement come first, then
//! the parameters that the model has, then effects that it lacks, one at a time, each judged on what was
//! left out, against chance over everything that was tried, against what is physically plausible and
//! against explanations without a name (a drift, any function of speed, of current, of position). What is
//! left and still depends on something is reported as such.

pub mod artefacts;
pub mod balance;
mod candidates;
pub mod evidence;
pub mod noise;
pub mod origin;
pub mod regression;
mod structure;
mod verdict;

pub use artefacts::Artefact;
pub use balance::{Balance, Corrections, Setting, Target, targets};
pub use evidence::{Evidence, Verdict};
pub use verdict::{Found, Ground, Parameter, Pictures, Refused, Report, Stage, Unexplained};

use nalgebra::DMatrix;

use crate::effects::{Effect, Shape};
use crate::measured::{Bench, Use};
use crate::numerics::line_search::golden_section;
use regression::{Blocks, Solution, finite_sum, solve};

/// Least share of the left-out squared error that an effect must take away to be worth a name: 3 % of the
/// error itself.
pub const WORTH: f64 = 0.06;
/// A gain must be this many standard errors above zero between blocks.
pub const SURE: f64 = 2.5;
/// Chance that the best of all candidates does as well where there is nothing.
pub const CHANCE: f64 = 0.01;

/// What identification is run with.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Cut-off of the filter \[Hz\]; chosen from the data where not given.
    pub band: Option<f64>,
}

/// Most rows that regressions see.
const ROWS: usize = 24_000;
/// Least share of the current's column that no function of speed makes up for K_T to be fitted.
const OWN_SHARE: f64 = 0.05;
/// Most effects and orders that are added one after the other.
const STEPS: usize = 16;

/// A term of the model: a parameter of the declared model or an effect.
#[derive(Clone)]
pub struct Term {
    /// Which.
    pub kind: Kind,
    /// Its columns, one for each linear parameter.
    pub columns: Vec<Vec<f64>>,
    /// Values that the declared model has, linear parameters.
    pub declared: Option<Vec<f64>>,
}

/// What a term is.
#[derive(Clone, Copy)]
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
pub struct Work<'a> {
    /// The bench.
    pub bench: &'a Bench,
    /// The equation.
    pub balance: Balance,
    /// Target less what is known and less what is fixed.
    pub target: Vec<f64>,
    /// The model so far.
    pub terms: Vec<Term>,
    /// Declared effects that stay as declared, because they are made of the response.
    pub fixed: Vec<(&'static dyn Effect, Vec<f64>)>,
    /// Fold of each block; `None` judges only.
    pub folds: Vec<Option<usize>>,
}

impl<'a> Work<'a> {
    fn new(bench: &'a Bench, balance: Balance) -> Work<'a> {
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
        for (effect, values) in balance::declared_effects(&bench.declared) {
            let seen = balance::visible(effect, &balance, &bench.declared);
            if let Err(balance::Hidden::Response(_)) = seen {
                let factor = balance.conversion(effect);
                let column = balance.function(|at| factor * effect.value(&values, at));
                target.iter_mut().zip(column).for_each(|(t, c)| *t -= c);
                fixed.push((effect, values));
            } else if seen.is_ok() {
                let shape = values.get(effect.linear()).copied().unwrap_or(0.0);
                terms.push(Term {
                    kind: Kind::Effect(effect, shape),
                    columns: balance.effect_columns(effect, shape),
                    declared: Some(values[..effect.linear()].to_vec()),
                });
            }
        }
        Work { bench, balance, target, terms, fixed, folds }
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
    pub fn unfiltered(&self, coefficients: &[f64]) -> Vec<noise::Unfiltered> {
        let mut base: Vec<f64> =
            self.balance.base.iter().map(|b| b.declared.filter(|d| d.is_finite()).unwrap_or(0.0)).collect();
        let mut effects = self.fixed.clone();
        for (t, term) in self.terms.iter().enumerate() {
            let own = &coefficients[self.offset(t)..self.offset(t) + term.columns.len()];
            match term.kind {
                Kind::Base(index) => base[index] = own[0],
                Kind::Effect(effect, shape) => {
                    let mut values = own.to_vec();
                    values.push(shape);
                    effects.push((effect, values));
                }
            }
        }
        let fits = |log: usize| self.bench.logs[log].usage == Use::Fit;
        self.balance.unfiltered(fits, &base, &effects)
    }

    /// What the model leaves of the target, row by row.
    pub fn residual(&self, fit: &Fit) -> Vec<f64> {
        let mut residual = self.target.clone();
        for (column, coefficient) in self.columns().iter().zip(fit.solution.coefficients.iter()) {
            for (r, c) in residual.iter_mut().zip(*column) {
                *r -= coefficient * c;
            }
        }
        residual
    }

    /// Root mean square error and variance accounted for, on blocks for fitting or on the others.
    fn error(&self, fit: &Fit, fitting: bool) -> Option<(f64, f64)> {
        let take = |b: usize| self.fits(b) == fitting;
        let count = fit.blocks.count(take);
        if count == 0 {
            return None;
        }
        let products = fit.blocks.total(take);
        let squares = regression::squares(&products, &fit.solution.coefficients);
        let last = products.nrows() - 1;
        let total = products[(last, last)];
        Some(((squares / count as f64).sqrt(), if total > 0.0 { 100.0 * (1.0 - squares / total) } else { 0.0 }))
    }

    fn stage(&self, name: String, fit: &Fit) -> Stage {
        let (fit_error, held) = (self.error(fit, true), self.error(fit, false));
        Stage {
            name,
            fit: fit_error.map_or(f64::NAN, |e| e.0),
            fit_vaf: fit_error.map_or(f64::NAN, |e| e.1),
            held_out: held.map(|e| e.0),
            held_out_vaf: held.map(|e| e.1),
        }
    }

    /// Root mean square of what is left out.
    pub fn left_out_error(&self, fit: &Fit) -> f64 {
        let count = fit.blocks.count(|b| self.fits(b)).max(1);
        (finite_sum(&fit.left_out) / count as f64).sqrt()
    }

    /// The index of the first column of a term.
    pub fn offset(&self, term: usize) -> usize {
        self.terms[..term].iter().map(|t| t.columns.len()).sum()
    }

    /// What share of a column neither the other columns nor any function of speed make up.
    fn own_share(&self, term: usize) -> f64 {
        let mut columns = self.columns_without(term);
        let free = structure::of_speed(self);
        columns.extend(free.iter().map(Vec::as_slice));
        let column = &self.terms[term].columns[0];
        let total = Blocks::new(&self.balance.rows, &columns, column).total(|b| self.fits(b));
        let last = total.nrows() - 1;
        regression::squares(&total, &solve(&total).coefficients) / total[(last, last)].max(f64::MIN_POSITIVE)
    }

    /// Holds parameters of the declared model that the data do not show at their declared values.
    fn hold_what_is_not_seen(&mut self) -> Vec<&'static str> {
        let mut held = Vec::new();
        // A torque constant shows only where the current is more than an answer to speed.
        let constant = (0..self.terms.len()).find(|t| {
            self.balance.step() > 0.0
                && matches!(self.terms[*t].kind, Kind::Base(i) if self.balance.base[i].name == "torque_constant")
        });
        if let Some(t) = constant {
            let share = self.own_share(t);
            let fitted = self.fit().solution.coefficients[self.offset(t)];
            let relative = fitted / self.terms[t].declared.as_ref().map_or(fitted, |d| d[0]);
            let far = !(0.6..=1.7).contains(&relative);
            if share < OWN_SHARE || (far && share < 10.0 * OWN_SHARE) {
                held.extend(self.hold(t));
            }
        }
        for _ in 0..self.terms.len() {
            let fit = self.fit();
            let covariance = regression::covariance(&fit.blocks, &fit.solution, |b| self.fits(b));
            let worst = (0..self.terms.len())
                .filter_map(|t| {
                    let term = &self.terms[t];
                    let Kind::Base(index) = term.kind else { return None };
                    let declared = term.declared.as_ref().map_or(0.0, |d| d[0]);
                    let column = self.offset(t);
                    let value = fit.solution.coefficients[column];
                    let error = covariance[(column, column)].sqrt();
                    let unseen = fit.solution.inverse[(column, column)] == 0.0;
                    let doubt = error / declared.abs().max(value.abs() * 0.5).max(f64::MIN_POSITIVE);
                    (unseen || doubt > 0.3 || value < 0.0).then_some((t, index, if unseen { f64::MAX } else { doubt }))
                })
                .max_by(|a, b| a.2.total_cmp(&b.2));
            let Some((t, ..)) = worst else { break };
            held.extend(self.hold(t));
        }
        held
    }

    /// Takes a parameter of the declared model out of the fit, at its declared value; its name.
    fn hold(&mut self, term: usize) -> Option<&'static str> {
        let term = self.terms.remove(term);
        let Kind::Base(index) = term.kind else { return None };
        if let Some(declared) = &term.declared {
            for (y, c) in self.target.iter_mut().zip(&term.columns[0]) {
                *y -= declared[0] * c;
            }
        }
        Some(self.balance.base[index].name)
    }

    /// The factor of load-dependent friction that was found; zero where there is none.
    fn gear_loss(&self) -> f64 {
        let term = (0..self.terms.len())
            .find(|t| self.terms[*t].effect().is_some_and(|(e, _)| e.name() == "load_dependent_friction"));
        term.map_or(0.0, |t| self.fit().solution.coefficients[self.offset(t)].clamp(0.0, 0.9))
    }

    /// Brings the slope of saturation to the torque constant, where the data do not object: weak saturation
    /// shows only slope over current squared.
    fn settle_saturation(&mut self) {
        let Some(t) = (0..self.terms.len()).find(|t| {
            self.terms[*t].declared.is_none()
                && self.terms[*t].effect().is_some_and(|(e, _)| e.name() == "torque_constant_saturation")
        }) else {
            return;
        };
        let Some((effect, found)) = self.terms[t].effect() else { return };
        let own = |work: &Work| {
            let fit = work.fit();
            let constant = (0..work.terms.len())
                .find(
                    |k| matches!(work.terms[*k].kind, Kind::Base(i) if work.balance.base[i].name == "torque_constant"),
                )
                .map_or(work.balance.scale.torque_constant, |k| fit.solution.coefficients[work.offset(k)]);
            (fit.solution.coefficients[work.offset(t)] / constant, finite_sum(&fit.left_out))
        };
        let before = own(self).1;
        let (mut low, mut high) = ((0.25 * self.balance.scale.current).ln(), (10.0 * self.balance.scale.current).ln());
        for _ in 0..24 {
            let shape = 0.5 * (low + high);
            self.terms[t].columns = self.balance.effect_columns(effect, shape.exp());
            self.terms[t].kind = Kind::Effect(effect, shape.exp());
            if own(self).0 < 1.0 { low = shape } else { high = shape }
        }
        let (slope, after) = own(self);
        if (slope - 1.0).abs() > 0.02 || after > 1.02 * before {
            self.terms[t].columns = self.balance.effect_columns(effect, found);
            self.terms[t].kind = Kind::Effect(effect, found);
        }
    }

    /// Improves the shape parameters that are not orders.
    fn refine_shapes(&mut self) {
        for t in 0..self.terms.len() {
            let Kind::Effect(effect, shape) = self.terms[t].kind else { continue };
            if matches!(effect.shape(), Shape::None | Shape::Order) || self.terms[t].declared.is_some() {
                continue;
            }
            let squares = |ln_shape: f64| {
                let own = self.balance.effect_columns(effect, ln_shape.exp());
                let mut columns = self.columns_without(t);
                columns.extend(own.iter().map(Vec::as_slice));
                let blocks = Blocks::new(&self.balance.rows, &columns, &self.target);
                let total = blocks.total(|b| self.fits(b));
                let solution = solve(&total);
                let first = columns.len() - effect.linear();
                let mut values: Vec<f64> = (0..effect.linear()).map(|j| solution.coefficients[first + j]).collect();
                values.push(ln_shape.exp());
                if effect.plausible(&values, &self.balance.scale).is_err() {
                    return f64::INFINITY;
                }
                regression::squares(&total, &solution.coefficients)
            };
            let best = golden_section(&squares, (shape / 1.7).ln(), (shape * 1.7).ln(), 14);
            if squares(best).is_infinite() {
                continue;
            }
            let best = best.exp();
            self.terms[t].columns = self.balance.effect_columns(effect, best);
            self.terms[t].kind = Kind::Effect(effect, best);
        }
    }
}

/// Identifies every equation that the bench shows.
///
/// # Errors
/// In words, where the logs say nothing that can be compared.
pub fn identify(bench: &Bench, options: &Options) -> Result<Vec<Report>, String> {
    let targets = targets(bench);
    let simulated = crate::measured::simulate::serves(bench);
    if targets.is_empty() && !simulated {
        return Err("no log for fitting has the channels of an equation: torque or a known load and a current, \
                    or a voltage, with a velocity or a position"
            .into());
    }
    let mut reports: Vec<Report> = targets.into_iter().filter_map(|target| run(bench, target, options)).collect();
    if simulated {
        reports.extend(crate::measured::simulate::identify_servo(bench));
    }
    if reports.is_empty() {
        return Err("nothing can be learnt: no log has 16 samples in a row with all channels, moving".into());
    }
    Ok(reports)
}

fn run(bench: &Bench, target: Target, options: &Options) -> Option<Report> {
    let wide = Setting {
        corrections: Corrections::none(bench.logs.len()),
        band: options.band,
        rows: ROWS,
        samples: usize::MAX,
    };
    let mut first = Balance::new(bench, target, &wide)?;
    let mut band = options.band;
    if band.is_none()
        && let Some(narrower) = artefacts::band_of_structure(&first)
    {
        band = Some(narrower);
        first = Balance::new(bench, target, &Setting { band, ..wide })?;
    }
    let setting = |corrections| Setting { corrections, band, rows: ROWS, samples: usize::MAX };
    let as_declared = verdict::declared_stage(bench, &first);
    let mut corrections = artefacts::find(bench, first, &setting);
    let balance = Balance::new(bench, target, &setting(corrections.clone()))?;
    let mut work = Work::new(bench, balance);
    let mut stages = vec![as_declared, verdict::corrected_stage(&work)];
    let held = work.hold_what_is_not_seen();
    let refit = work.fit();
    stages.push(work.stage("refit".into(), &refit));
    let mut selection = candidates::Selection::new(&work);
    for _ in 0..STEPS {
        let Some((effect, shape)) = selection.next(&work) else { break };
        work.terms.push(Term {
            kind: Kind::Effect(effect, shape),
            columns: work.balance.effect_columns(effect, shape),
            declared: None,
        });
        work.refine_shapes();
        let fit = work.fit();
        stages.push(work.stage(verdict::label(effect, shape), &fit));
    }
    // Lags are found again with the effects in: a late channel and friction look alike. What the gear
    // transmits follows from its loss.
    let gear_loss = work.gear_loss();
    let refined = artefacts::refine(bench, &work, &corrections, &setting);
    if refined.is_some() || gear_loss > 0.02 {
        corrections = Corrections { gear_loss, ..refined.unwrap_or(corrections) };
        let balance = Balance::new(bench, target, &setting(corrections.clone()))?;
        let terms = std::mem::take(&mut work.terms);
        work = Work::new(bench, balance);
        work.hold_what_is_not_seen();
        for term in terms {
            if let (Kind::Effect(effect, shape), None) = (term.kind, &term.declared) {
                let columns = work.balance.effect_columns(effect, shape);
                work.terms.push(Term { columns, ..term });
            }
        }
        work.refine_shapes();
    }
    selection.drop_superfluous(&mut work);
    work.settle_saturation();
    let found = artefacts::list(&work, &corrections);
    Some(verdict::report(work, selection, stages, found, held))
}

/// The coefficients of extra columns on the model's, and what they leave: from sums of products in which
/// the model's `p` columns come first.
fn projection(total: &DMatrix<f64>, p: usize, extra: usize) -> DMatrix<f64> {
    let normal = total.view((0, 0), (p, p)).into_owned();
    let cross = total.view((0, p), (p, extra)).into_owned();
    let mut padded = DMatrix::zeros(p + 1, p + 1);
    padded.view_mut((0, 0), (p, p)).copy_from(&normal);
    let inverse = solve(&padded).inverse;
    inverse * cross
}

#[cfg(test)]
mod steady;
