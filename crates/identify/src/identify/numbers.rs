//! Every fitted number with its error.

use super::candidates::Selection;
use nalgebra::DMatrix;

use super::regression::{Blocks, covariance, solve};
use super::ripple;
use super::work::{Kind, Term, Work};
use crate::answer::{Base, Found, Parameter, Undecided};
use gearwise_model::effects::{EFFECTS, Effect, Equation, FittedEffect, Named, Shape, Variable};

/// Every fitted number of the machine, with its error.
pub struct Numbers {
    /// Names.
    pub names: Vec<String>,
    /// Covariance.
    pub covariance: DMatrix<f64>,
    /// Values.
    pub values: Vec<f64>,
    /// The column of the model that each follows from; a shape is of none.
    columns: Vec<Option<usize>>,
    /// Derivative of each by the factor of its column.
    slopes: Vec<f64>,
    /// Factor of torques in the equation over those of the machine, and its variance: see [`Numbers::of_the_machine`].
    factor: (f64, f64),
}

impl Numbers {
    /// Independent numbers with their variances, of a column each.
    #[cfg(test)]
    pub fn independent(numbers: &[(&str, f64, f64)]) -> Numbers {
        let variances: Vec<f64> = numbers.iter().map(|(_, _, variance)| *variance).collect();
        Numbers {
            names: numbers.iter().map(|(name, ..)| name.to_string()).collect(),
            covariance: DMatrix::from_diagonal(&variances.into()),
            values: numbers.iter().map(|(_, value, _)| *value).collect(),
            columns: (0..numbers.len()).map(Some).collect(),
            slopes: vec![1.0; numbers.len()],
            factor: (1.0, 0.0),
        }
    }

    /// The numbers of the machine, from those of the equation. Where a known load has a scale, the equation is `N K_0 i = s (load + …)` with
    /// the declared torque constant K_0: s = K_0/K_T, and the coefficient of every torque is s times the machine's.
    pub(super) fn of_the_machine(mut self, torque_constant: f64, is_torque: &[bool]) -> Numbers {
        let Some(at) = self.names.iter().position(|name| name == Base::LoadScale.name()) else { return self };
        let count = self.names.len();
        let scale = self.values[at];
        let mut by = DMatrix::<f64>::identity(count, count);
        for k in (0..count).filter(|k| is_torque[*k]) {
            by[(k, k)] = 1.0 / scale;
            by[(k, at)] = -self.values[k] / (scale * scale);
            self.values[k] /= scale;
        }
        by[(at, at)] = -torque_constant / (scale * scale);
        self.names[at] = Base::TorqueConstant.name().into();
        self.values[at] = torque_constant / scale;
        self.factor = (scale, self.covariance[(at, at)]);
        self.slopes = (0..count).map(|k| by[(k, k)]).collect();
        self.covariance = &by * self.covariance * by.transpose();
        self
    }

    /// A number with its error, and with what is undecided of each column.
    fn of(&self, name: &str, undecided: &[Option<Undecided>]) -> Option<(f64, f64, Option<Undecided>)> {
        let k = self.names.iter().position(|n| n == name)?;
        let undecided = self.columns[k].and_then(|column| undecided.get(column).copied().flatten());
        let undecided = undecided.map(|u| Undecided { by: self.slopes[k].abs() * u.by, ..u });
        Some((self.values[k], self.covariance[(k, k)].max(0.0).sqrt(), undecided))
    }
}

/// Names, covariance and values of every fitted number of the machine; shape parameters by their derivative.
pub fn errors(work: &Work) -> Numbers {
    let fit = work.fit();
    let mut names = Vec::new();
    let mut values: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut of: Vec<Option<usize>> = Vec::new();
    let mut is_torque = Vec::new();
    for (t, term) in work.terms.iter().enumerate() {
        let offset = work.offset(t);
        let coefficients: Vec<f64> = (0..term.columns.len()).map(|j| fit.solution.coefficients[offset + j]).collect();
        columns.extend(term.columns.iter().cloned());
        values.extend(&coefficients);
        of.extend((0..coefficients.len()).map(|j| Some(offset + j)));
        match term.kind {
            Kind::Base(index) => {
                let which = work.balance.base[index].which;
                names.push(which.name().to_string());
                is_torque.push(matches!(which, Base::Inertia | Base::Mass | Base::Damping));
            }
            Kind::Effect(effect, shape) => {
                is_torque.extend(coefficients.iter().map(|_| effect.acts_on() == Equation::Torque));
                for parameter in &effect.parameters()[..effect.linear()] {
                    names.push(Named::new(effect, Some(shape), parameter.name).to_string());
                }
                if effect.is_of_torque_constant() {
                    // Slope and current are one number where saturation is weak: the current follows the slope.
                    continue;
                }
                if !matches!(effect.shape(), Shape::None | Shape::Order) {
                    let h = 1e-3 * shape;
                    let (up, down) = (
                        work.balance.effect_columns(effect, shape + h),
                        work.balance.effect_columns(effect, shape - h),
                    );
                    let slope = (0..work.balance.rows.len())
                        .map(|k| {
                            coefficients.iter().enumerate().map(|(j, c)| c * (up[j][k] - down[j][k])).sum::<f64>()
                                / (2.0 * h)
                        })
                        .collect();
                    columns.push(slope);
                    names.push(Named::new(effect, Some(shape), effect.parameters()[effect.linear()].name).to_string());
                    values.push(shape);
                    of.push(None);
                    is_torque.push(false);
                }
            }
        }
    }
    // The residual is that of the fit: linearised at its values, the shape's own step is zero.
    let residual = work.residual(&fit);
    let references: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let blocks = Blocks::new(&work.balance.rows, &references, &residual);
    let solution = solve(&blocks.total(|b| work.fits(b)));
    let covariance = covariance(&blocks, &solution, |b| work.fits(b));
    let slopes = vec![1.0; names.len()];
    Numbers { names, covariance, values, columns: of, slopes, factor: (1.0, 0.0) }
        .of_the_machine(work.balance.scale.torque_constant, &is_torque)
}

/// The parameters of the declared model, fitted or held.
pub fn parameters(work: &Work, numbers: &Numbers, undecided: &[Option<Undecided>], held: &[Base]) -> Vec<Parameter> {
    let mut list = Vec::new();
    let error = |name: &str| numbers.of(name, undecided);
    for base in &work.balance.base {
        let (which, declared) = match base.which {
            Base::LoadScale => (Base::TorqueConstant, Some(work.balance.scale.torque_constant)),
            which => (which, base.declared),
        };
        match error(which.name()) {
            Some((value, error, undecided)) => list.push(Parameter {
                name: which.name().into(),
                declared,
                fitted: value,
                standard_error: Some(error),
                undecided,
                unit: which.unit(),
            }),
            None if held.contains(&base.which) => {
                if let Some(declared) = base.declared {
                    list.push(Parameter {
                        name: base.which.name().into(),
                        declared: base.declared,
                        fitted: declared,
                        standard_error: None,
                        undecided: None,
                        unit: base.which.unit(),
                    });
                }
            }
            None => {}
        }
    }
    for term in work.terms.iter().filter(|t| t.declared.is_some()) {
        let Some((effect, shape)) = term.effect() else { continue };
        for (j, parameter) in effect.parameters()[..effect.linear()].iter().enumerate() {
            let name = Named::new(effect, Some(shape), parameter.name).to_string();
            if let Some((value, error, undecided)) = error(&name) {
                list.push(Parameter {
                    name,
                    declared: term.declared.as_ref().map(|d| d[j]),
                    fitted: value,
                    standard_error: Some(error),
                    undecided,
                    unit: parameter.kind.si,
                });
            }
        }
    }
    for FittedEffect { effect, values } in &work.fixed {
        for (parameter, value) in effect.parameters()[..effect.linear()].iter().zip(values) {
            list.push(Parameter {
                name: Named::new(*effect, values.last().copied(), parameter.name).to_string(),
                declared: Some(*value),
                fitted: *value,
                standard_error: None,
                undecided: None,
                unit: parameter.kind.si,
            });
        }
    }
    list
}

/// Adds a wave to that of the same order, where there is one; whether there is.
fn add_to_its_order(found: &mut Found, values: &[f64], covariance: &[[f64; 2]; 2]) -> bool {
    let (Some(order), effect) = (values.last(), found.effect) else { return false };
    let Some(instance) = found.instances.iter_mut().find(|i| i.last() == Some(order)) else { return false };
    for (j, parameter) in effect.parameters()[..effect.linear()].iter().enumerate() {
        instance[j] += values[j];
        let name = Named::new(effect, Some(*order), parameter.name).within();
        for own in found.parameters.iter_mut().filter(|p| p.name == name) {
            own.fitted += values[j];
            own.standard_error = own.standard_error.map(|e| e.hypot(covariance[j][j].max(0.0).sqrt()));
        }
    }
    true
}

/// Effects that were found at full bandwidth: their errors are of that.
fn of_ripple(work: &Work, numbers: &Numbers, list: &mut Vec<Found>) {
    let Some(ripple) = &work.ripple else { return };
    let (scale, variance) = numbers.factor;
    for (effect, _, held) in &ripple.without {
        let lines = ripple.lines.iter().filter(|l| l.fitted.effect == *effect);
        let (mut parameters, mut instances, mut square) = (Vec::new(), Vec::new(), 0.0);
        let mut confounded_with: Vec<&'static dyn Effect> = Vec::new();
        for line in lines {
            let (mut values, mut covariance) = (line.fitted.values.clone(), line.covariance);
            let linear = effect.linear();
            values[..linear].iter_mut().for_each(|value| *value /= scale);
            for (j, row) in covariance.iter_mut().enumerate() {
                for (k, cell) in row.iter_mut().enumerate() {
                    *cell = (*cell + values[j] * values[k] * variance) / (scale * scale);
                }
            }
            // What the band shows of the same order beside it is one wave with it.
            let same = list.iter_mut().find(|f| f.effect == *effect);
            if same.is_some_and(|found| add_to_its_order(found, &values, &covariance)) {
                continue;
            }
            for (j, parameter) in effect.parameters()[..effect.linear()].iter().enumerate() {
                parameters.push(Parameter {
                    name: Named::new(*effect, values.last().copied(), parameter.name).within(),
                    declared: None,
                    fitted: values[j],
                    standard_error: Some(covariance[j][j].max(0.0).sqrt()),
                    undecided: None,
                    unit: parameter.kind.si,
                });
            }
            let column = work.balance.variable(false, |at| work.balance.factor * effect.value(&line.fitted.values, at));
            square += column.iter().map(|v| v * v).sum::<f64>() / column.len().max(1) as f64;
            instances.push(values);
            let new: Vec<_> = line.twins.iter().copied().filter(|t| !confounded_with.contains(t)).collect();
            confounded_with.extend(new);
        }
        match list.iter_mut().find(|f| f.effect == *effect) {
            Some(same) => {
                same.parameters.extend(parameters);
                same.instances.extend(instances);
                same.size = same.size.hypot(square.sqrt());
            }
            None => list.push(Found {
                effect: *effect,
                parameters,
                instances,
                size: square.sqrt(),
                held_out_before: *held,
                held_out_after: ripple.after.1,
                confounded_with,
            }),
        }
    }
}

/// The effects that the declared model lacked.
pub fn found(work: &Work, selection: &Selection, numbers: &Numbers, undecided: &[Option<Undecided>]) -> Vec<Found> {
    let fit = work.fit();
    let mut list: Vec<Found> = Vec::new();
    let missing = |t: &Term| t.declared.is_none() && t.effect().is_some();
    for (t, term) in work.terms.iter().enumerate().filter(|(_, t)| missing(t)) {
        let Some((effect, shape)) = term.effect() else { continue };
        let offset = work.offset(t);
        let coefficients: Vec<f64> = (0..effect.linear()).map(|j| fit.solution.coefficients[offset + j]).collect();
        let of_machine = |(j, coefficient): (usize, &f64)| {
            let name = Named::new(effect, Some(shape), effect.parameters()[j].name).to_string();
            numbers.of(&name, &[]).map_or(*coefficient, |(value, ..)| value)
        };
        let mut instance: Vec<f64> = coefficients.iter().enumerate().map(of_machine).collect();
        let mut parameters = Vec::new();
        for (index, parameter) in effect.parameters().iter().enumerate() {
            let named = Named::new(effect, Some(shape), parameter.name);
            let name = named.to_string();
            if effect.is_of_torque_constant() && index == effect.linear() {
                // Its depth goes with slope over current squared.
                let slope =
                    parameters.first().map_or((1.0, 0.0), |p: &Parameter| (p.fitted, p.standard_error.unwrap_or(0.0)));
                parameters.push(Parameter {
                    name: parameter.name.into(),
                    declared: None,
                    fitted: shape,
                    standard_error: Some(0.5 * shape * slope.1 / slope.0.abs().max(f64::MIN_POSITIVE)),
                    undecided: None,
                    unit: parameter.kind.si,
                });
            } else if let Some((fitted, error, undecided)) = numbers.of(&name, undecided) {
                parameters.push(Parameter {
                    name: named.within(),
                    declared: None,
                    fitted,
                    standard_error: Some(error),
                    undecided,
                    unit: parameter.kind.si,
                });
            }
        }
        if effect.shape() != Shape::None {
            instance.push(shape);
        }
        let part: Vec<f64> = (0..work.balance.rows.len())
            .map(|k| (0..effect.linear()).map(|j| coefficients[j] * term.columns[j][k]).sum())
            .collect();
        let square = part.iter().map(|v| v * v).sum::<f64>() / part.len().max(1) as f64;
        match list.iter_mut().find(|f| f.effect == effect) {
            Some(same) => {
                same.parameters.extend(parameters);
                same.instances.push(instance);
                same.size = same.size.hypot(square.sqrt());
            }
            None => list.push(Found {
                effect,
                parameters,
                instances: vec![instance],
                size: square.sqrt(),
                held_out_before: None,
                held_out_after: work.error(&work.columns(), &fit, false).map(|e| e.0),
                confounded_with: selection.look_alikes(work, t),
            }),
        }
        if effect.shape() == Shape::Order
            && let Some(entry) = list.iter_mut().find(|f| f.effect == effect)
        {
            let twins = ripple::twins(work, effect, shape);
            let new: Vec<&'static dyn Effect> =
                twins.into_iter().filter(|twin| !entry.confounded_with.contains(twin)).collect();
            entry.confounded_with.extend(new);
        }
    }
    of_ripple(work, numbers, &mut list);
    // Once a turn of the output may be a weight as well as a wheel.
    let of_output = |e: &dyn Effect| e.shape() == Shape::Order && e.needs().contains(&Variable::OutputAngle);
    for entry in list.iter_mut().filter(|f| of_output(f.effect) && f.instances.iter().any(|i| i.last() == Some(&1.0))) {
        let weights = EFFECTS.iter().copied().filter(|e| e.once_a_turn());
        let new: Vec<&'static dyn Effect> = weights.filter(|e| !entry.confounded_with.contains(e)).collect();
        entry.confounded_with.extend(new);
    }
    for entry in &mut list {
        if entry.held_out_before.is_some() {
            continue;
        }
        // Without all orders of the effect.
        let columns: Vec<&[f64]> = work
            .terms
            .iter()
            .filter(|t| !(t.declared.is_none() && t.effect().is_some_and(|(e, _)| e == entry.effect)))
            .flat_map(|t| &t.columns)
            .map(Vec::as_slice)
            .collect();
        let without = work.fit_columns(&columns);
        entry.held_out_before = work.error(&columns, &without, false).map(|e| e.0);
    }
    // What repeats with an angle was found first; friction is what one wants to hear first.
    list.sort_by_key(|found| found.effect.shape() == Shape::Order);
    list
}
