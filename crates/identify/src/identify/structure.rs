//! Explanations without a name: any function of time, of speed, of current, of position.
//!
//! The one idea: what is left of a good model depends on nothing. Each variable is offered a flexible
//! function; where one lowers the left-out error beyond chance, something is left, and it is said on what
//! it depends.

use super::candidates::Superfluous;
use super::flexible::{drift, order_scores};
use super::hats::hats;
use super::work::{Fit, Work};
use crate::answer::{On, Target};
use crate::signals;
use gearwise_model::effects::{EFFECTS, Equation, Operating, Shape, Variable};
use gearwise_model::numerics::sums::{finite_sum, paired};

/// Share of the left-out squared error that a flexible function must take away to be worth saying.
const SAID: f64 = 0.08;
/// In standard errors between blocks.
const SURE: f64 = 3.0;

/// What the residual depends on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Dependence {
    /// On what.
    pub on: On,
    /// Share of the left-out squared error that a flexible function of it takes away.
    pub share: f64,
    /// In words.
    pub detail: String,
}

/// A flexible function that is offered: of what, and its columns.
type Offer = (On, Vec<Vec<f64>>);

/// The flexible functions that are offered.
fn offers(work: &Work) -> Vec<Offer> {
    let balance = &work.balance;
    let mut offers: Vec<Offer> = vec![(On::Time, drift(work))];
    let mut offer = |variable: Variable, f: &(dyn Fn(&Operating) -> f64 + Sync)| {
        let values = balance.variable(false, f);
        if values.iter().any(|v| !v.is_finite()) {
            return;
        }
        let columns = hats(&balance.rows, &values).iter().map(|hat| balance.function(|at| hat(f(at)))).collect();
        offers.push((On::Variable(variable), columns));
    };
    let has = |v: Variable| balance.variables.contains(&v);
    if has(Variable::Speed) {
        offer(Variable::Speed, &|at| at.speed);
    }
    // Where the target is made of the current, a free function of it would explain its noise.
    if has(Variable::Current) && !balance.is_response(Variable::Current) {
        offer(Variable::Current, &|at| at.current);
    }
    // The same with the transmitted torque: where a sensor has it, current stands for it.
    if balance.is_response(Variable::Torque) {
        // As above.
    } else if has(Variable::Torque) && balance.target == Target::Torque && has(Variable::Current) {
        let constant = balance.scale.torque_constant;
        offer(Variable::Torque, &|at| constant * at.current * at.direction);
    } else if has(Variable::Torque) && balance.target != Target::Torque {
        offer(Variable::Torque, &|at| at.torque * at.direction);
    }
    if has(Variable::WindingTemperature) {
        offer(Variable::WindingTemperature, &|at| at.winding_rise);
    }
    // Friction that changes with time.
    if has(Variable::Speed) && balance.step() > 0.0 {
        let rows = &balance.rows;
        let direction = balance.function(|at| at.direction);
        let columns = drift(work)
            .into_iter()
            .map(|hat| {
                let mut product: Vec<f64> = hat.iter().zip(&direction).map(|(h, d)| h * d).collect();
                if balance.target.has_zero() {
                    rows.without_means(&mut product);
                }
                product
            })
            .collect();
        offers.push((On::TimeAndDirection, columns));
    }
    let acceleration = balance.acceleration();
    if acceleration.iter().any(|a| *a != 0.0) {
        let columns = hats(&balance.rows, &acceleration)
            .iter()
            .map(|hat| {
                let mut column: Vec<f64> = acceleration.iter().map(|a| hat(*a)).collect();
                balance.rows.without_means(&mut column);
                column
            })
            .collect();
        offers.push((On::Acceleration, columns));
    }
    offers
}

/// What flexible functions find in what the model leaves, the strongest first, and the error that they
/// would leave together.
pub fn left(work: &Work, fit: &Fit) -> (Vec<Dependence>, Vec<(On, f64)>) {
    let before = finite_sum(&fit.left_out);
    let mut found = Vec::new();
    let mut shares = Vec::new();
    for (on, extra) in offers(work) {
        let mut columns = work.columns();
        columns.extend(extra.iter().map(Vec::as_slice));
        let with = work.fit_columns(&columns);
        let share = 1.0 - finite_sum(&with.left_out) / before;
        let sure = paired(&fit.left_out, &with.left_out);
        if share > SAID && sure > SURE {
            shares.push((on, share));
            let name = on.name();
            found.push(Dependence {
                on,
                share,
                detail: format!(
                    "a free function of {name} would lower the left-out error by {:.0} %",
                    100.0 * (1.0 - (1.0 - share).sqrt())
                ),
            });
        }
    }
    // Harmonics of an angle alone, whatever they are called.
    let of_an_angle = EFFECTS.iter().filter(|e| e.shape() == Shape::Order && e.acts_on() == Equation::Torque);
    for effect in of_an_angle.copied() {
        let &[variable] = effect.needs() else { continue };
        if !work.balance.variables.contains(&variable) {
            continue;
        }
        let name = variable.name();
        let mut scores = order_scores(work, fit, effect);
        scores.sort_by(|a, b| b.1.total_cmp(&a.1));
        let orders: Vec<f64> = scores.iter().take(4).map(|s| s.0).collect();
        let extra: Vec<Vec<f64>> = orders.iter().flat_map(|h| work.balance.effect_columns(effect, *h)).collect();
        let mut columns = work.columns();
        columns.extend(extra.iter().map(Vec::as_slice));
        let with = work.fit_columns(&columns);
        let share = 1.0 - finite_sum(&with.left_out) / before;
        if share > SAID && paired(&fit.left_out, &with.left_out) > SURE {
            shares.push((On::Variable(variable), share));
            let list: Vec<String> = orders.iter().map(f64::to_string).collect();
            found.push(Dependence {
                on: On::Variable(variable),
                share,
                detail: format!("orders {} of the {name} are above the rest", list.join(", ")),
            });
        }
    }
    if let Some((frequency, share)) = hum(work, fit) {
        found.push(Dependence {
            on: On::Time,
            share,
            detail: format!("a line at {frequency:.2} Hz that no speed explains holds {:.0} % of it", 100.0 * share),
        });
    }
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    (found, shares)
}

/// An effect whose own variable still explains much of what is left, measured by what the effect itself
/// explains.
pub fn doubtful(work: &Work) -> Option<Superfluous> {
    doubtful_by(work, &left(work, &work.fit()).1)
}

/// The same by what free functions take away.
pub(crate) fn doubtful_by(work: &Work, shares: &[(On, f64)]) -> Option<Superfluous> {
    let fit = work.fit();
    let now = finite_sum(&fit.left_out);
    (0..work.terms.len()).find_map(|t| {
        let term = &work.terms[t];
        let (effect, _) = term.effect()?;
        if term.declared.is_some() || effect.shape() == Shape::Order {
            return None;
        }
        let explains = finite_sum(&work.left_out_without(t)) - now;
        let is_its_own = |on: On| matches!(on, On::Variable(v) if effect.needs().contains(&v));
        let (on, share) = shares.iter().find(|(on, _)| is_its_own(*on))?;
        let left = share * now;
        // A shape parameter bends a wrong curve nearly right: what it leaves weighs more.
        let tolerated = if effect.shape() == Shape::None { 0.15 } else { 0.04 };
        (left > tolerated * explains && left > 0.0).then(|| {
            let name = on.name();
            let more = 100.0 * left / explains.max(f64::MIN_POSITIVE);
            Superfluous {
                term: t,
                gain: explains / (explains + now),
                reason: format!(
                    "it has not the right shape: a free function of {name} takes away {more:.0} % more than it does"
                ),
            }
        })
    })
}

/// A line in the spectrum of what is left: its frequency \[Hz\] and its share of the variance.
fn hum(work: &Work, fit: &Fit) -> Option<(f64, f64)> {
    if work.balance.step() == 0.0 {
        return None;
    }
    let rows = &work.balance.rows;
    let residual = work.residual(fit);
    let speed = work.balance.variable(true, |at| at.speed);
    let direction = work.balance.variable(true, |at| at.direction);
    let current = work.balance.variable(true, |at| if at.current.is_finite() { at.current } else { 0.0 });
    let mut best: Option<(f64, f64, usize)> = None;
    let mut seen = 0;
    for log in 0..rows.logs() {
        let at: Vec<usize> = (0..rows.len()).filter(|k| rows.log[*k] == log).collect();
        let times: Vec<f64> = at.iter().map(|k| rows.time[*k]).collect();
        let step = signals::median_step(&times);
        if at.len() < 256 || step <= 0.0 {
            continue;
        }
        // Above the band the filter leaves nothing: bins there would make any motion look like a line.
        let density_of = |signal: &[f64]| {
            let values: Vec<f64> = at.iter().map(|k| signal[*k]).collect();
            let mut density = signals::welch(&values, step, 512);
            density.retain(|d| work.balance.band.is_none_or(|band| d.0 <= band));
            density
        };
        let density = density_of(&residual);
        let total: f64 = density.iter().skip(2).map(|d| d.1).sum();
        let Some(peak) = (3..density.len().saturating_sub(2)).max_by(|a, b| density[*a].1.total_cmp(&density[*b].1))
        else {
            continue;
        };
        seen += 1;
        let line: f64 = density[peak - 1..=peak + 1].iter().map(|d| d.1).sum();
        let around: Vec<f64> = density.iter().map(|d| d.1).collect();
        let usual = signals::median(around).unwrap_or(0.0);
        let share = line / total.max(f64::MIN_POSITIVE);
        // Not where the motion itself has a line.
        let motion = [&speed, &direction, &current].iter().any(|signal| {
            let own = density_of(signal);
            let usual = signals::median(own.iter().map(|d| d.1).collect()).unwrap_or(0.0);
            own.get(peak).is_some_and(|d| d.1.is_finite() && d.1 > 25.0 * usual)
        });
        if density[peak].1 > 25.0 * usual && share > 0.15 && !motion {
            let frequency = density[peak].0;
            best = match best {
                Some((f, s, n)) if (f - frequency).abs() < 3.0 * density[1].0 => Some((f, s.max(share), n + 1)),
                None => Some((frequency, share, 1)),
                other => other,
            };
        }
    }
    best.filter(|(_, _, logs)| 2 * logs > seen).map(|(f, s, _)| (f, s))
}

#[cfg(test)]
mod tests;
