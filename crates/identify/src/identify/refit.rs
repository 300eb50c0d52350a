//! Numbers of the model that are found beside its linear coefficients: what is held, and shapes.

use super::candidates::window;
use super::flexible::of_speed;
use super::regression::{Blocks, covariance, solve, squares};
use super::work::{Kind, Term, Work};
use crate::answer::Base;
use gearwise_model::effects::{FittedEffect, Shape};
use gearwise_model::numerics::line_search::golden_section;
use gearwise_model::numerics::sums::finite_sum;

/// Least share of the current's column that no function of speed makes up for K_T to be fitted.
const OWN_SHARE: f64 = 0.05;
/// Least share of the known load's column that inertia and effects leave for its scale to be fitted.
const LOAD_SHARE: f64 = 0.01;
/// A current whose noise is a larger share of what it does on its own (of the squares) says no constant: by this share the
/// fitted one would be too small.
const NOISY: f64 = 0.1;
/// So many places over its window are looked at for a shape; where one leaves less by this share of the squares, it is looked
/// for there. In logarithms, how far on either side.
const PLACES: usize = 10;
const ELSEWHERE: f64 = 0.02;
const WIDE: f64 = 0.53;
/// A fitted value that is this many times its error is seen, whatever is declared.
const SEEN: f64 = 3.0;
/// A number of the declared model whose error is a larger share of it is not seen.
const DOUBT: f64 = 0.3;

impl Work<'_> {
    /// Share of a column that neither the other columns nor any function of speed explain.
    fn own_share(&self, term: usize) -> f64 {
        self.share_beside(term, &of_speed(self))
    }

    /// Share of a column that neither the other columns nor the `more` ones explain.
    fn share_beside(&self, term: usize, more: &[Vec<f64>]) -> f64 {
        let mut columns = self.columns_without(term);
        columns.extend(more.iter().map(Vec::as_slice));
        let column = &self.terms[term].columns[0];
        let total = Blocks::new(&self.balance.rows, &columns, column).total(|b| self.fits(b));
        let last = total.nrows() - 1;
        squares(&total, &solve(&total).coefficients) / total[(last, last)].max(f64::MIN_POSITIVE)
    }

    /// Whether a column that is made of a measured current moves too little beside the noise of that current: a fit took the
    /// noise for motion and found a constant that is too small, with a small error.
    fn is_in_noise(&self, term: usize) -> bool {
        let balance = &self.balance;
        let factor = match self.terms[term].kind {
            Kind::Base(i) if balance.base[i].which == Base::TorqueConstant => balance.factor,
            Kind::Base(i) if balance.base[i].which == Base::Resistance => 1.0,
            _ => return false,
        };
        let columns = self.columns_without(term);
        let total = Blocks::new(&balance.rows, &columns, &self.terms[term].columns[0]).total(|b| self.fits(b));
        let own = squares(&total, &solve(&total).coefficients) / balance.fitting().max(1) as f64;
        let share = (factor * balance.noise_of(|at| at.current)).powi(2) / own.max(f64::MIN_POSITIVE);
        // A current that is driven at random looks like noise, but the constant is what was declared: noise makes it smaller.
        let fitted = self.fit().solution.coefficients[self.offset(term)];
        let declared = self.terms[term].declared.as_ref().map_or(f64::NAN, |d| d[0]);
        let is_as_declared = fitted > (1.0 - 0.5 * share.min(1.0)) * declared;
        share > NOISY && !is_as_declared
    }

    /// Holds parameters of the declared model that the data do not show at their declared values.
    pub fn hold_what_is_not_seen(&mut self) -> Vec<Base> {
        let mut held = Vec::new();
        while let Some(t) = (0..self.terms.len()).find(|t| self.is_in_noise(*t)) {
            held.extend(self.hold(t));
        }
        // A torque constant shows only where the current is more than an answer to speed.
        let constant =
            (0..self.terms.len()).find(|t| self.balance.step() > 0.0 && self.is_base(*t, Base::TorqueConstant));
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
            let covariance = covariance(&fit.blocks, &fit.solution, |b| self.fits(b));
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
                    (unseen || doubt > DOUBT || value < 0.0).then_some((
                        t,
                        index,
                        if unseen { f64::MAX } else { doubt },
                    ))
                })
                .max_by(|a, b| a.2.total_cmp(&b.2));
            let Some((t, ..)) = worst else { break };
            held.extend(self.hold(t));
        }
        self.hold_effects_in_doubt();
        held
    }

    /// Declared effects stay as declared where their errors are larger than what is declared, and no value stands out of them: at
    /// one speed nothing says which of two frictions it is.
    fn hold_effects_in_doubt(&mut self) {
        loop {
            let fit = self.fit();
            let covariance = covariance(&fit.blocks, &fit.solution, |b| self.fits(b));
            let doubt = |t: usize| {
                let declared = self.terms[t].declared.as_ref()?;
                self.terms[t].effect()?;
                let first = self.offset(t);
                let of_one = |(j, value): (usize, &f64)| {
                    if fit.solution.inverse[(first + j, first + j)] == 0.0 {
                        return f64::INFINITY;
                    }
                    let error = covariance[(first + j, first + j)].sqrt();
                    error / value.abs().max(fit.solution.coefficients[first + j].abs() / SEEN).max(f64::MIN_POSITIVE)
                };
                Some(declared.iter().enumerate().map(of_one).fold(0.0, f64::max))
            };
            let worst = (0..self.terms.len()).filter_map(|t| Some((t, doubt(t)?))).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((t, _)) = worst.filter(|(_, doubt)| doubt.is_nan() || *doubt > 1.0) else { return };
            self.hold_effect(t);
        }
    }

    /// Takes a declared effect out of the fit, at its declared values.
    fn hold_effect(&mut self, term: usize) {
        let Term { kind: Kind::Effect(effect, shape), columns, declared: Some(mut values) } = self.terms.remove(term)
        else {
            return;
        };
        for (value, column) in values.iter().zip(&columns) {
            self.target.iter_mut().zip(column).for_each(|(y, c)| *y -= value * c);
        }
        if effect.shape() != Shape::None {
            values.push(shape);
        }
        self.fixed.push(FittedEffect { effect, values });
    }

    /// Holds what another model of the same logs holds.
    pub fn hold_as(&mut self, other: &Work) {
        let is_held = |work: &Work, t: usize| {
            let own = work.terms[t].effect().filter(|_| work.terms[t].declared.is_some());
            own.is_some_and(|(e, _)| other.fixed.iter().any(|f| f.effect == e))
        };
        while let Some(t) = (0..self.terms.len()).find(|t| is_held(self, *t)) {
            self.hold_effect(t);
        }
        for which in self.balance.base.iter().map(|b| b.which).collect::<Vec<Base>>() {
            let is_fitted = (0..other.terms.len()).any(|t| other.is_base(t, which));
            if let Some(t) = (0..self.terms.len()).find(|t| !is_fitted && self.is_base(*t, which)) {
                self.hold(t);
            }
        }
    }

    /// Takes a parameter of the declared model out of the fit, at its declared value; which it was.
    fn hold(&mut self, term: usize) -> Option<Base> {
        let term = self.terms.remove(term);
        let Kind::Base(index) = term.kind else { return None };
        if let Some(declared) = &term.declared {
            for (y, c) in self.target.iter_mut().zip(&term.columns[0]) {
                *y -= declared[0] * c;
            }
        }
        Some(self.balance.base[index].which)
    }

    /// Brings the slope of saturation to the torque constant, where the data do not object: weak saturation
    /// shows only slope over current squared.
    pub fn settle_saturation(&mut self) {
        let Some(t) = (0..self.terms.len()).find(|t| {
            self.terms[*t].declared.is_none() && self.terms[*t].effect().is_some_and(|(e, _)| e.is_of_torque_constant())
        }) else {
            return;
        };
        let Some((effect, found)) = self.terms[t].effect() else { return };
        let own = |work: &Work| {
            let fit = work.fit();
            let constant = (0..work.terms.len())
                .find(|k| work.is_base(*k, Base::TorqueConstant))
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

    /// True if inertia and effects explain the column of the known load, whose scale shows the torque constant: a pendulum beside an
    /// unknown inertia and another weight.
    fn hides_load(&self) -> bool {
        let scale = (0..self.terms.len()).find(|t| self.is_base(*t, Base::LoadScale));
        scale.is_some_and(|t| self.share_beside(t, &[]) < LOAD_SHARE)
    }

    /// Holds the inertia where it hides the scale of the known load.
    pub fn hold_what_hides_load(&mut self) -> Option<Base> {
        let is_it = |t: &usize| self.is_base(*t, Base::Inertia) && self.terms[*t].declared.is_some();
        let inertia = (0..self.terms.len()).find(is_it).filter(|_| self.hides_load())?;
        self.hold(inertia)
    }

    /// Takes a parameter that was held back into the fit, where with all effects in the data show it; whether they do.
    pub fn release(&mut self, which: Base) -> bool {
        let Some(index) = self.balance.base.iter().position(|b| b.which == which) else { return false };
        let Some(declared) = self.balance.base[index].declared.filter(|d| d.is_finite() && *d != 0.0) else {
            return false;
        };
        let column = self.balance.base_column(index);
        if column.iter().all(|v| *v == 0.0) {
            return false;
        }
        let (before, target) = (self.fit(), self.target.clone());
        for (y, c) in self.target.iter_mut().zip(&column) {
            *y += declared * c;
        }
        self.terms.insert(0, Term { kind: Kind::Base(index), columns: vec![column], declared: Some(vec![declared]) });
        let fit = self.fit();
        let covariance = covariance(&fit.blocks, &fit.solution, |b| self.fits(b));
        let (value, error) = (fit.solution.coefficients[0], covariance[(0, 0)].sqrt());
        let is_seen =
            fit.solution.inverse[(0, 0)] > 0.0 && value > 0.0 && error < DOUBT * declared.abs().max(0.5 * value);
        let is_no_worse = finite_sum(&fit.left_out) < finite_sum(&before.left_out);
        let is_told = is_seen && is_no_worse && !self.is_in_noise(0) && !self.hides_load();
        if !is_told {
            self.terms.remove(0);
            self.target = target;
        }
        is_told
    }

    /// Improves the shape parameters that are not orders.
    pub fn refine_shapes(&mut self) {
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
                squares(&total, &solution.coefficients)
            };
            // Beside what was added since, it may lie elsewhere.
            let spaced = window(self, effect).into_iter().flat_map(|(low, high)| {
                (0..PLACES).map(move |k| low.ln() + (high / low).ln() * k as f64 / (PLACES - 1) as f64)
            });
            let far = spaced.map(|at| (at, squares(at))).min_by(|a, b| a.1.total_cmp(&b.1));
            let middle =
                far.filter(|(_, sum)| *sum < (1.0 - ELSEWHERE) * squares(shape.ln())).map_or(shape.ln(), |f| f.0);
            let best = golden_section(&squares, middle - WIDE, middle + WIDE, 14);
            if squares(best).is_infinite() {
                continue;
            }
            let best = best.exp();
            self.terms[t].columns = self.balance.effect_columns(effect, best);
            self.terms[t].kind = Kind::Effect(effect, best);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::steady::{CONSTANT, OVER_TIME, bench_of, noise, work};
    use super::*;
    use gearwise_model::effects::effect;

    /// At a constant load what the current does is its own noise: a fit would take it for a torque constant of next to nothing,
    /// and be sure of it. Where the load changes the constant is seen.
    #[test]
    fn a_current_that_is_its_own_noise_says_no_constant() {
        let held = |change: f64| {
            let row = |k: usize| {
                let t = 1e-3 * k as f64;
                let i = 2.0 + change * (11.0 * t).sin();
                let torque = 6.0 * CONSTANT * i + 0.01 * noise(k + 50_000);
                vec![t, 40.0 + 20.0 * (3.0 * t).sin(), i + 0.3 * noise(k), torque]
            };
            let bench = bench_of("dynamometer", 6.0, &OVER_TIME, &[(0..6000).map(row).collect()], 0);
            let mut work = work(&bench);
            let held = work.hold_what_is_not_seen();
            let constant = (0..work.terms.len()).find(|t| work.is_base(*t, Base::TorqueConstant));
            (held, constant.map(|t| work.fit().solution.coefficients[work.offset(t)]))
        };
        let (nothing, fitted) = held(0.0);
        assert!(nothing.contains(&Base::TorqueConstant) && fitted.is_none());
        let (something, fitted) = held(2.0);
        assert!(!something.contains(&Base::TorqueConstant));
        assert!((fitted.unwrap() / CONSTANT - 1.0).abs() < 0.02, "{fitted:?}");
    }

    /// At one speed two frictions look the same: both stay as declared. Over many speeds both are fitted.
    #[test]
    fn frictions_that_one_speed_cannot_tell_apart_stay_as_declared() {
        let fitted = |swing: f64| {
            let row = |k: usize| {
                let t = 1e-3 * k as f64;
                let (w, i) = (40.0 + swing * (3.0 * t).sin() + 0.01 * noise(k), 2.0 * (11.0 * t).sin());
                let drag = 0.03 * w.signum() + 1e-3 * w;
                vec![t, w, i, 6.0 * (CONSTANT * i - drag) + 0.05 * noise(k + 50_000)]
            };
            let mut bench = bench_of("dynamometer", 6.0, &OVER_TIME, &[(0..6000).map(row).collect()], 0);
            let declared = |name: &str, value: f64| FittedEffect { effect: effect(name).unwrap(), values: vec![value] };
            bench.declared.effects.extend([declared("coulomb_friction", 0.02), declared("viscous_friction", 2e-3)]);
            let mut work = work(&bench);
            work.hold_what_is_not_seen();
            let fit = work.fit();
            let mut values = Vec::new();
            for t in 0..work.terms.len() {
                if let Some((effect, _)) = work.terms[t].effect() {
                    values.push((effect.name(), fit.solution.coefficients[work.offset(t)]));
                }
            }
            (values, work.fixed.len())
        };
        assert_eq!(fitted(0.0), (Vec::new(), 2));
        let (values, held) = fitted(80.0);
        assert_eq!(held, 0);
        for (name, value) in values {
            let wanted = if name == "coulomb_friction" { 0.03 } else { 1e-3 };
            assert!((value / wanted - 1.0).abs() < 0.1, "{name} {value}");
        }
    }
}
