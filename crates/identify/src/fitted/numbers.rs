//! Fitted numbers of all equations of a bench, and what follows from them with its error.

use crate::answer::{Ground, Parameter, Refused, Report, Target};
use crate::bench::Bench;
use gearwise_model::catalog::Motor;
use gearwise_model::effects::{Effect, Named, Shape, of_damping};
use gearwise_model::words::handy::with_error;

/// A number, SI, and how it follows from fitted ones.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Number {
    pub value: f64,
    /// Places of fitted numbers and its derivative by each.
    pub by: Vec<(usize, f64)>,
    /// Variance of what has no place in the covariance.
    pub loose: f64,
}

impl Number {
    pub fn exact(value: f64) -> Number {
        Number { value, ..Number::default() }
    }

    /// Another value that follows from it with a derivative.
    pub fn through(&self, value: f64, slope: f64) -> Number {
        Number::of(value, &[(self, slope)])
    }

    pub fn by_factor(&self, factor: f64) -> Number {
        self.through(factor * self.value, factor)
    }

    pub fn plus(&self, constant: f64) -> Number {
        self.through(self.value + constant, 1.0)
    }

    pub fn sum(&self, other: &Number) -> Number {
        Number::of(self.value + other.value, &[(self, 1.0), (other, 1.0)])
    }

    pub fn minus(&self, other: &Number) -> Number {
        Number::of(self.value - other.value, &[(self, 1.0), (other, -1.0)])
    }

    pub fn times(&self, other: &Number) -> Number {
        Number::of(self.value * other.value, &[(self, other.value), (other, self.value)])
    }

    fn of(value: f64, parts: &[(&Number, f64)]) -> Number {
        let mut found = Number::exact(value);
        for (part, slope) in parts {
            found.loose += slope * slope * part.loose;
            for (place, by) in &part.by {
                match found.by.iter_mut().find(|(p, _)| p == place) {
                    Some((_, sum)) => *sum += slope * by,
                    None => found.by.push((*place, slope * by)),
                }
            }
        }
        found
    }
}

/// What the equation of a report sees.
pub(super) struct Sight {
    /// K_T over R rather than K_T: the drive is a duty cycle, and no current is known.
    pub sees_quotient: bool,
}

/// The reports of a bench; a place counts through the covariances of all of them.
pub(super) struct Fits<'a> {
    pub bench: &'a Bench,
    reports: &'a [Report],
    sight: Vec<Sight>,
    first: Vec<usize>,
    /// Parameters that several equations see: name, report that was used.
    used: std::cell::RefCell<Vec<(String, usize)>>,
}

impl<'a> Fits<'a> {
    /// True if some equation was asked for an effect, by its name, whether it was found or not.
    pub fn asked_for(&self, effect: &str) -> bool {
        let judged =
            |refused: &Refused| refused.name == effect && matches!(refused.ground, Ground::Judged | Ground::Drift);
        self.reports.iter().any(|report| report.refused.iter().any(judged))
    }

    pub fn new(bench: &'a Bench, reports: &'a [Report]) -> Fits<'a> {
        let mut count = 0;
        let first = reports
            .iter()
            .map(|r| {
                count += r.fitted_names.len();
                count - r.fitted_names.len()
            })
            .collect();
        let quotient = |r: &Report| match r.target {
            Target::Position => true,
            Target::Drive => r.parameters.iter().any(|p| p.name == "damping"),
            _ => false,
        };
        let sight = reports.iter().map(|r| Sight { sees_quotient: quotient(r) }).collect();
        Fits { bench, reports, sight, first, used: std::cell::RefCell::default() }
    }

    fn parameter(&self, report: usize, name: &str) -> Option<&'a Parameter> {
        let report = &self.reports[report];
        let own = report.parameters.iter().find(|p| p.name == name);
        own.or_else(|| {
            let found = |e: &&crate::answer::Found| name.starts_with(e.name());
            report.effects.iter().filter(found).find_map(|e| {
                let rest = name.strip_prefix(e.name())?.strip_prefix('.')?;
                e.parameters.iter().find(|p| p.name == rest)
            })
        })
    }

    /// The place of a fitted number in a report, where its variance is one.
    fn place(&self, report: usize, name: &str) -> Option<usize> {
        let of = &self.reports[report];
        let k = of.fitted_names.iter().position(|n| n == name)?;
        let variance = *of.covariance.get(k)?.get(k)?;
        (variance.is_finite() && variance >= 0.0).then_some(self.first[report] + k)
    }

    /// A parameter of the machine as a report sees it.
    fn seen(&self, report: usize, name: &str) -> Option<Number> {
        let p = self.parameter(report, name)?;
        let error = p.standard_error.filter(|e| e.is_finite() && p.fitted.is_finite())?;
        let loose = p.undecided.map_or(0.0, |u| u.by * u.by);
        if let Some(place) = self.place(report, name) {
            return Some(Number { value: p.fitted, by: vec![(place, 1.0)], loose });
        }
        Some(Number { value: p.fitted, by: Vec::new(), loose: loose + error * error })
    }

    /// A parameter by the equation that is surest of it, of those that may say it.
    pub fn best(&self, name: &str, may: impl Fn(&Sight) -> bool) -> Option<Number> {
        let of = (0..self.reports.len()).filter(|r| may(&self.sight[*r]));
        let (report, number) = of
            .filter_map(|r| Some((r, self.seen(r, name)?)))
            .min_by(|a, b| self.doubt(std::slice::from_ref(&a.1)).total_cmp(&self.doubt(std::slice::from_ref(&b.1))))?;
        self.used.borrow_mut().push((name.to_string(), report));
        Some(number)
    }

    /// Relative squared error of numbers that belong together.
    fn doubt(&self, numbers: &[Number]) -> f64 {
        let squares: f64 = numbers.iter().map(|n| n.value * n.value).sum();
        let errors: f64 = numbers.iter().map(|n| self.covariance(n, n) + n.loose).sum();
        errors / squares.max(f64::MIN_POSITIVE)
    }

    /// Covariance of two numbers by the fitted ones that they follow from: equations are taken as independent.
    pub fn covariance(&self, a: &Number, b: &Number) -> f64 {
        let mut sum = 0.0;
        for (p, by_p) in &a.by {
            for (q, by_q) in &b.by {
                let report = self.first.partition_point(|f| f <= p) - 1;
                let (j, k) = (p - self.first[report], q.checked_sub(self.first[report]));
                let value = k.and_then(|k| self.reports[report].covariance[j].get(k)).copied().unwrap_or(0.0);
                sum += by_p * by_q * if value.is_finite() { value } else { 0.0 };
            }
        }
        sum
    }

    /// Standard error; `None` of what was not fitted.
    pub fn error(&self, number: &Number) -> Option<f64> {
        let variance = self.covariance(number, number) + number.loose;
        (!number.by.is_empty() || number.loose > 0.0).then(|| variance.max(0.0).sqrt())
    }

    /// The first value of an effect that the bench file declares beyond the row.
    pub fn declared_effect(&self, effect: &dyn Effect) -> Option<f64> {
        self.bench.declared.effects.iter().find(|e| e.effect == effect)?.values.first().copied()
    }

    /// What opposes motion in proportion to speed where a voltage drives, and K_T/R of the same fit: by the surest
    /// equation.
    pub fn damping(&self, motor: &Motor) -> Option<(Number, Number)> {
        let effect = of_damping()?;
        let declared = self.bench.declared.all_effects();
        let viscous = declared.iter().find(|e| e.effect == effect).map_or(0.0, |e| e.values[0]);
        let coefficient = coefficient(effect);
        let of = |r: usize| {
            let (own, term) = (self.seen(r, "damping"), self.seen(r, &coefficient));
            if !self.sight[r].sees_quotient || (own.is_none() && term.is_none()) {
                return None;
            }
            let quotient = self.seen(r, "torque_constant").unwrap_or(Number::exact(motor.torque_constant));
            let held = |value: f64| match self.reports[r].target {
                Target::Drive => quotient.by_factor(value / motor.torque_constant),
                _ => Number::exact(value),
            };
            let back_emf = motor.torque_constant * motor.back_emf_constant / motor.resistance;
            let damping = own.unwrap_or_else(|| held(back_emf)).sum(&term.unwrap_or_else(|| held(viscous)));
            Some((damping, quotient.by_factor(1.0 / motor.resistance)))
        };
        let all = (0..self.reports.len()).filter_map(of);
        all.min_by(|a, b| self.doubt(std::slice::from_ref(&a.0)).total_cmp(&self.doubt(std::slice::from_ref(&b.0))))
    }

    /// Instances of an effect, declared or found, each once: of several orders, each order.
    pub fn instances(&self, effect: &dyn Effect) -> Vec<Vec<f64>> {
        let declared = self.bench.declared.effects.iter().filter(|e| e.effect == effect).map(|e| &e.values);
        let found = self.reports.iter().flat_map(|r| &r.effects).filter(|e| e.effect == effect);
        let mut list: Vec<Vec<f64>> = Vec::new();
        for instance in declared.chain(found.flat_map(|e| &e.instances)) {
            let same = |other: &Vec<f64>| effect.is_same_instance(other, instance);
            if instance.len() == effect.parameters().len() && !list.iter().any(same) {
                list.push(instance.clone());
            }
        }
        list
    }

    /// The values of an instance: all of the equation that is surest of it.
    pub fn values(&self, effect: &'static dyn Effect, instance: &[f64]) -> Vec<Number> {
        let name = |parameter| Named::new(effect, instance.last().copied(), parameter).to_string();
        let linear = |r: usize| -> Option<Vec<Number>> {
            effect.parameters()[..effect.linear()].iter().map(|p| self.seen(r, &name(p.name))).collect()
        };
        let surest = (0..self.reports.len())
            .filter_map(|r| Some((r, linear(r)?)))
            .min_by(|a, b| self.doubt(&a.1).total_cmp(&self.doubt(&b.1)));
        let Some((report, mut values)) = surest else {
            return instance.iter().map(|v| Number::exact(*v)).collect();
        };
        self.used.borrow_mut().push((name(effect.parameters()[0].name), report));
        if effect.shape() != Shape::None {
            // A shape belongs to the fit that its size is of.
            let found = self.reports[report].effects.iter().filter(|e| e.effect == effect);
            let own = found
                .flat_map(|e| &e.instances)
                .find(|i| effect.is_same_instance(i, instance))
                .map_or(instance, Vec::as_slice);
            let index = effect.linear();
            let shape = self.seen(report, &name(effect.parameters()[index].name));
            values.push(shape.unwrap_or(Number::exact(own[index])));
        }
        values
    }

    /// What equations say that were not used, of each parameter that several see.
    pub fn disagreements(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let mut used = self.used.borrow().clone();
        used.dedup();
        for (name, report) in &used {
            let told = |r: usize| {
                let found = self.seen(r, name)?;
                let text = with_error(found.value, self.error(&found).map(|e| 2.0 * e), self.parameter(r, name)?.unit);
                Some((format!("{} says {text}", self.reports[r].target.name()), found))
            };
            let alike = |r: &usize| self.sight[*r].sees_quotient == self.sight[*report].sees_quotient;
            let others = (0..self.reports.len()).filter(|r| r != report).filter(alike).filter_map(told);
            let Some((own, number)) = told(*report) else { continue };
            let own_error = self.error(&number).unwrap_or(0.0);
            let others: Vec<String> = others
                .map(|(text, other)| {
                    let joint = own_error.hypot(self.error(&other).unwrap_or(0.0));
                    let apart = (number.value - other.value).abs() > 3.0 * joint;
                    if apart { format!("{text}, which disagrees") } else { text }
                })
                .collect();
            if !others.is_empty() {
                notes.push(format!("of two equations the surer is used for {name}: {own}; {}", others.join("; ")));
            }
        }
        notes
    }
}

/// The name of an effect's first parameter, as a report has it.
pub(super) fn coefficient(effect: &'static dyn Effect) -> String {
    Named::new(effect, None, effect.parameters()[0].name).to_string()
}
