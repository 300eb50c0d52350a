//! Artefacts of the measurement: channels that are late, of the wrong sign or gain.
//!
//! The one idea: they are looked for with a generous model (the declared one plus plain friction), so that
//! an effect that the model lacks does not pass for a lag, and again at the end with what was found.

use super::balance::{Balance, Corrections, Setting};
use super::regression::{Blocks, covariance, residual, solve, squares};
use super::robust;
use super::work::{Kind, Work};
use crate::answer::{About, Artefact, ArtefactKind, Base, Finding, Target};
use crate::{Bench, BenchKind, Channel, signals};
use gearwise_model::effects::Variable;
use gearwise_model::numerics::line_search::golden_section;
use gearwise_model::numerics::sums::paired;

/// Gains that differ by less from the other logs' are taken for scatter.
const GAIN: f64 = 0.12;
/// The same in medians of what logs differ by: three standard deviations of normal scatter.
const SCATTER: f64 = 3.0 * 1.48;
/// Least share of the squared error that a lag must take away.
const WORTH: f64 = 0.02;
/// Share of the variance that speed and acceleration must make up to say a sign.
const FOLLOWS: f64 = 0.5;
/// How many times its speed one way the speed the other way may be for that.
const RANGES: f64 = 5.0;
/// Standard errors beyond which a sign is sure.
const SURE: f64 = 6.0;
/// A lag beyond this share of the largest is at the end of the search.
const AT_THE_END: f64 = 0.95;
/// Largest lag that is looked for \[s\].
const LARGEST_LAG: f64 = 0.05;

/// A zero that is this many times the largest value that its sensor read is none.
const BEYOND: f64 = 1.05;

/// Columns of the generous model.
fn generous(balance: &Balance) -> Vec<Vec<f64>> {
    let mut columns: Vec<Vec<f64>> = (0..balance.base.len()).map(|i| balance.base_column(i)).collect();
    match balance.target {
        Target::Torque | Target::Drive => {
            columns.push(balance.function(|at| at.speed));
            columns.push(balance.function(|at| at.direction));
            columns.push(balance.function(|at| at.speed.abs()));
            if balance.target == Target::Drive {
                columns.push(balance.function(|_| 1.0));
            }
            if balance.variables.contains(&Variable::Torque) {
                columns.push(balance.function(|at| at.torque.abs() * at.direction));
            }
        }
        Target::Voltage if balance.is_response(Variable::Current) => {}
        Target::Voltage => columns.push(balance.function(|at| at.current.signum())),
        // Simulated, not regressed.
        Target::Position => {}
        Target::WindUp if balance.is_response(Variable::Torque) => {}
        Target::WindUp => {
            columns.push(balance.function(|at| at.torque));
            columns.push(balance.function(|at| at.torque.signum()));
        }
    }
    columns.retain(|c| c.iter().all(|v| v.is_finite()) && c.iter().any(|v| *v != 0.0));
    columns
}

/// A band that holds all that is not noise: five times what the motion holds, and where something turns and
/// could ripple, all at which what the generous model leaves stands out of its own flat top. `None` where
/// that is not clearly narrower than the band there is.
pub(crate) fn band_of_structure(balance: &Balance) -> Option<f64> {
    let band = balance.band?;
    let columns = generous(balance);
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let target = balance.target_column();
    let blocks = Blocks::new(&balance.rows, &columns, &target);
    let coefficients = solve(&blocks.total(|b| balance.rows.block_fits[b])).coefficients;
    let left = residual(&target, &columns, &coefficients);
    let speed = balance.variable(true, |at| at.speed);
    let current = balance.variable(true, |at| at.current);
    let turns = balance.variables.contains(&Variable::Angle);
    let mut highest = 0.0_f64;
    for log in (0..balance.rows.logs()).filter(|l| balance.rows.fits(*l)) {
        let at: Vec<usize> = (0..balance.rows.len()).filter(|k| balance.rows.log[*k] == log).collect();
        let times: Vec<f64> = at.iter().map(|k| balance.rows.time[*k]).collect();
        let step = signals::median_step(&times);
        if at.len() < 512 || step <= 0.0 {
            return None;
        }
        let inside = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            let values: Vec<f64> = at.iter().map(|k| value(*k)).collect();
            let density = signals::welch(&values, step, 2048);
            density.into_iter().filter(|d| d.0 > 0.0 && d.0 < 0.9 * band).collect()
        };
        let top = |density: &[(f64, f64)]| {
            signals::median(density.iter().filter(|d| d.0 > 0.55 * band).map(|d| d.1).collect()).unwrap_or(0.0)
        };
        // The frequency below which a signal holds a share of what it is over its noise.
        let holds = |density: &[(f64, f64)], share: f64| {
            let floor = top(density);
            let total: f64 = density.iter().map(|d| (d.1 - floor).max(0.0)).sum();
            let mut sum = 0.0;
            density
                .iter()
                .find(|d| {
                    sum += (d.1 - floor).max(0.0);
                    sum >= share * total
                })
                .map_or(band, |d| d.0)
        };
        highest = highest.max(5.0 * holds(&inside(&|k| speed[k]), 0.99));
        if balance.target != Target::Drive && balance.variables.contains(&Variable::Current) {
            highest = highest.max(3.0 * holds(&inside(&|k| current[k]), 0.99));
        }
        if turns {
            let left = inside(&|k| left[k]);
            let floor = top(&left);
            let stands_out = |k: usize| left[k].1 > 5.0 * floor;
            let last = (1..left.len()).rev().find(|k| stands_out(*k) && stands_out(k - 1));
            highest = highest.max(last.map_or(0.0, |k| 1.5 * left[k].0));
        }
    }
    let narrower = highest.max(5.0);
    (narrower < 0.6 * band).then_some(narrower)
}

/// Squared errors of the fitting blocks under the generous model, each block left out in turn with its
/// fold.
fn errors(balance: &Balance) -> Vec<f64> {
    let columns = generous(balance);
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    robust::errors(&balance.rows, &columns, &balance.target_column())
}

/// Finds sign, gain and lag. `balance` is uncorrected.
pub fn find(bench: &Bench, balance: Balance, setting: &impl Fn(Corrections) -> Setting) -> Corrections {
    let mut corrections = Corrections::none(balance.logs.len());
    let target = balance.target;
    corrections.gains = gains(&balance);
    let signs = passive_signs(bench, &balance).into_iter().zip(taken_torque(&balance));
    for (log, (sign, taken)) in signs.enumerate() {
        corrections.gains[log] *= sign;
        let is_turned = corrections.gains[log] < 0.0;
        match (is_turned, taken) {
            (true, Some(Taken::Opposing)) => {
                corrections.gains[log] *= -1.0;
                corrections.signs[log].current = -1.0;
            }
            (false, Some(Taken::Following)) => corrections.signs[log].motion = -1.0,
            _ => {}
        }
    }
    if shows_lags(bench, &balance) {
        corrections = lags(bench, target, corrections, setting, &errors);
    }
    corrections
}

/// The sign of each log's torque, where no current drives it: a machine that is driven takes power, and where its torque
/// surely rises with its speed the sensor has the other sign.
fn passive_signs(bench: &Bench, balance: &Balance) -> Vec<f64> {
    let is_passive = |log: usize| bench.logs[balance.logs[log]].channel(Channel::Current).is_none();
    if balance.target != Target::Torque || balance.step() == 0.0 {
        return vec![1.0; balance.logs.len()];
    }
    let (speed, acceleration) = (balance.function(|at| at.speed), balance.acceleration());
    let turning = balance.variable(true, |at| at.speed);
    let columns: [&[f64]; 2] = [&speed, &acceleration];
    // The factor of the balance turns a torque that is needed into one that is missing at the sensor.
    let blocks = Blocks::new(&balance.rows, &columns, &balance.target_column());
    (0..balance.logs.len())
        .map(|log| {
            let own = |b: usize| balance.rows.block_log[b] == log;
            let driven = matches!(bench.logs[balance.logs[log]].kind, BenchKind::Drag | BenchKind::Backdrive);
            if !is_passive(log) || !driven || blocks.count(own) == 0 {
                return 1.0;
            }
            let total = blocks.total(own);
            let solution = solve(&total);
            let error = covariance(&blocks, &solution, own)[(0, 0)].sqrt();
            // Its zero is not known: only a torque that goes with the speed over much of its range says its sign.
            let follows = squares(&total, &solution.coefficients) < (1.0 - FOLLOWS) * total[(2, 2)];
            let sure = error.is_finite() && solution.coefficients[0] < -SURE * error;
            // At one speed it is the torque that makes the speed waver.
            let own_speeds = || (0..balance.rows.len()).filter(|k| balance.rows.log[*k] == log).map(|k| turning[k]);
            let at = |share| signals::quantile(own_speeds().collect(), share).unwrap_or(0.0);
            let (low, high) = (at(0.1), at(0.9));
            // Driven both ways, clearly: what wavers about one speed says nothing of the sign.
            let ranges = low * high < 0.0 && low.abs().max(high.abs()) < RANGES * low.abs().min(high.abs());
            if sure && follows && ranges { -1.0 } else { 1.0 }
        })
        .collect()
}

/// Direction of the torque that inertia and friction take at the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Taken {
    /// It opposes the motion, as in every machine.
    Opposing,
    /// It has the direction of the motion: sensor and motion have different signs.
    Following,
}

/// The direction in which inertia and friction take torque in each log that a current drives; `None` where it is not certain.
fn taken_torque(balance: &Balance) -> Vec<Option<Taken>> {
    let logs = balance.logs.len();
    let inertia = balance.base.iter().position(|b| b.which == Base::Inertia);
    let Some(inertia) = inertia.filter(|_| balance.target == Target::Torque) else { return vec![None; logs] };
    let driving = balance.base_column(0);
    if driving.iter().all(|v| *v == 0.0) {
        return vec![None; logs];
    }
    let taken = [balance.base_column(inertia), balance.function(|at| at.speed), balance.function(|at| at.direction)];
    let target = balance.target_column();
    let alone = Blocks::new(&balance.rows, &[&driving], &target);
    let with = Blocks::new(&balance.rows, &[&driving, &taken[0], &taken[1], &taken[2]], &target);
    let of_log = |log: usize| {
        let own = |b: usize| balance.rows.block_log[b] == log;
        let [total_alone, total] = [&alone, &with].map(|blocks| blocks.total(own));
        let solution = solve(&total);
        let covariance = covariance(&with, &solution, own);
        let in_errors = (1..=taken.len()).map(|k| solution.coefficients[k] / covariance[(k, k)].sqrt());
        let surest = in_errors.filter(|t| t.is_finite()).max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        let left = squares(&total_alone, &solve(&total_alone).coefficients);
        let is_certain = surest.abs() > SURE && squares(&total, &solution.coefficients) < (1.0 - FOLLOWS) * left;
        is_certain.then_some(if surest > 0.0 { Taken::Opposing } else { Taken::Following })
    };
    (0..logs).map(of_log).collect()
}

/// Whether a late channel would show: over time, where something moves; and not beside a wind-up, which looks the same.
pub fn shows_lags(bench: &Bench, balance: &Balance) -> bool {
    let stands = balance.logs.iter().all(|l| bench.logs[*l].kind == BenchKind::Stall);
    balance.step() > 0.0 && balance.target != Target::WindUp && !stands
}

/// The artefacts of all channels. One that is only told, not taken out, is looked for here in the bench's logs.
pub fn list(work: &Work, corrections: &Corrections) -> Vec<Artefact> {
    let balance = &work.balance;
    let channel = match balance.target {
        Target::Torque => "torque",
        Target::Drive => "current",
        Target::Voltage => "voltage",
        Target::WindUp | Target::Position => "position",
    };
    let mut found = Vec::new();
    for (log, (gain, signs)) in corrections.gains.iter().zip(&corrections.signs).enumerate() {
        let place = |channel: &str| match corrections.gains.len() {
            1 => channel.to_string(),
            _ => format!("{channel} of {}", balance.names[log]),
        };
        let signs = [(channel, *gain), ("current", signs.current), ("motion", signs.motion)];
        for (channel, _) in signs.into_iter().filter(|(_, sign)| *sign < 0.0) {
            found.push(Artefact { kind: ArtefactKind::Sign, channel: place(channel), value: -1.0, unit: "1" });
        }
        if (gain.abs() - 1.0).abs() > 1e-9 {
            found.push(Artefact {
                kind: ArtefactKind::Gain,
                channel: place(channel),
                value: 1.0 / gain.abs(),
                unit: "1",
            });
        }
    }
    for (name, lag) in [(channel, corrections.target_lag), ("velocity", corrections.motion_lag)] {
        if lag != 0.0 {
            found.push(Artefact { kind: ArtefactKind::Lag, channel: name.into(), value: lag, unit: "s" });
        }
    }
    found
}

/// The zero of each log, and those that no sensor has which reads what the log says.
pub fn zeros(work: &Work) -> (Vec<Artefact>, Vec<Finding>) {
    let balance = &work.balance;
    let zeros = zero_of_logs(work);
    let largest = |log: usize| {
        let values = balance.target.channel().and_then(|c| work.bench.logs[balance.logs[log]].channel(c));
        let read = values.unwrap_or_default().iter().filter(|v| v.is_finite());
        read.fold(0.0_f64, |most, v| most.max(v.abs()))
    };
    let is_beyond =
        |(log, zero): &&(usize, f64)| balance.target == Target::Torque && zero.abs() > BEYOND * largest(*log);
    let beyond = zeros.iter().filter(is_beyond).map(|(log, zero)| Finding {
        log: balance.names[*log].clone(),
        about: About::Zero { channel: Channel::Torque, zero: *zero, most: largest(*log) },
    });
    let artefact = |(log, zero): &(usize, f64)| Artefact {
        kind: ArtefactKind::Zero,
        channel: format!("{} of {}", balance.target.name(), balance.names[*log]),
        value: *zero,
        unit: balance.unit,
    };
    (zeros.iter().map(artefact).collect(), beyond.collect())
}

/// What the model as it was found leaves of the mean of each log that has a zero.
fn zero_of_logs(work: &Work) -> Vec<(usize, f64)> {
    let balance = &work.balance;
    if !balance.target.has_zero() {
        return Vec::new();
    }
    let mut left = balance.target_with_zero();
    let mut subtract = |value: f64, column: Vec<f64>| {
        for (l, c) in left.iter_mut().zip(column) {
            *l -= value * c;
        }
    };
    let fit = work.fit();
    let mut fitted = vec![false; balance.base.len()];
    for (t, term) in work.terms.iter().enumerate() {
        let coefficient = |j: usize| fit.solution.coefficients[work.offset(t) + j];
        match term.kind {
            Kind::Base(index) => {
                fitted[index] = true;
                subtract(coefficient(0), balance.base_column_with_zero(index));
            }
            Kind::Effect(effect, shape) => {
                let mut values: Vec<f64> = (0..effect.linear()).map(coefficient).collect();
                values.push(shape);
                subtract(1.0, balance.effect_with_zero(effect, &values));
            }
        }
    }
    let ripple = work.ripple.iter().flat_map(|r| r.effects());
    for fixed in work.fixed.iter().cloned().chain(ripple) {
        subtract(1.0, balance.effect_with_zero(fixed.effect, &fixed.values));
    }
    // What was held stays as declared.
    for (index, base) in balance.base.iter().enumerate().filter(|(i, _)| !fitted[*i]) {
        if let Some(value) = base.declared.filter(|v| v.is_finite()) {
            subtract(value, balance.base_column_with_zero(index));
        }
    }
    balance.rows.means(&left).into_iter().enumerate().filter(|(_, zero)| !zero.is_nan()).collect()
}

/// A gain for each log whose torque constant differs from the others' far beyond its error.
fn gains(balance: &Balance) -> Vec<f64> {
    let logs = balance.logs.len();
    let mut gains = vec![1.0; logs];
    if balance.target != Target::Torque {
        return gains;
    }
    let Some(declared) = balance.base.first().and_then(|b| b.declared) else { return gains };
    if balance.base_column(0).iter().all(|v| *v == 0.0) {
        return gains;
    }
    let columns = generous(balance);
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let target = balance.target_column();
    let blocks = Blocks::new(&balance.rows, &columns, &target);
    let slopes: Vec<Option<(f64, f64)>> = (0..logs)
        .map(|log| {
            let own = |b: usize| balance.rows.block_log[b] == log;
            let total = blocks.total(own);
            let solution = solve(&total);
            let slope = *solution.coefficients.get(0)?;
            // The error within the log: from the residual, with blocks as what is independent.
            let error = covariance(&blocks, &solution, own)[(0, 0)].sqrt();
            let plain = (squares(&total, &solution.coefficients) / blocks.count(own).max(1) as f64
                * solution.inverse[(0, 0)])
                .sqrt();
            let error = error.max(plain);
            (error.is_finite() && slope.abs() > 6.0 * error && total[(0, 0)] > 0.0).then_some((slope, error))
        })
        .collect();
    // What is usual is for the logs to fit to say: what is held out is compared with them, one at a time.
    let of_fit: Vec<usize> = (0..logs).filter(|l| slopes[*l].is_some() && balance.rows.fits(*l)).collect();
    let known: Vec<(f64, f64)> = of_fit.iter().filter_map(|l| slopes[*l]).collect();
    for (log, gain) in of_fit.iter().zip(usual_gains(&known, Some(declared))) {
        gains[*log] = gain;
    }
    for log in (0..logs).filter(|l| !balance.rows.fits(*l)) {
        let Some(slope) = slopes[log] else { continue };
        let with: Vec<(f64, f64)> = known.iter().copied().chain([slope]).collect();
        gains[log] = usual_gains(&with, Some(declared)).pop().unwrap_or(1.0);
    }
    gains
}

/// What each log's slope (with its standard error) is to be multiplied with to be the usual one: −1 for a wrong
/// sign, another factor where it is far from the others beyond its error and their spread, else 1. The usual slope
/// is the median; of two the one that is nearer to what is declared, and without that neither is.
pub fn usual_gains(slopes: &[(f64, f64)], declared: Option<f64>) -> Vec<f64> {
    // Signs: each log's own.
    let mut gains: Vec<f64> = slopes.iter().map(|s| if s.0 < 0.0 { -1.0 } else { 1.0 }).collect();
    let sizes: Vec<f64> = slopes.iter().map(|s| s.0.abs()).collect();
    if sizes.len() < 2 {
        return gains;
    }
    let usual = match (sizes.as_slice(), declared) {
        ([a, b], Some(declared)) => {
            let off = |s: f64| (s / declared).ln().abs();
            if off(*a) <= off(*b) { *a } else { *b }
        }
        (&[_, _], None) => return gains,
        _ => signals::median(sizes.clone()).unwrap_or(sizes[0]),
    };
    let spread = signals::median(sizes.iter().map(|s| (s / usual - 1.0).abs()).collect());
    let threshold = GAIN.max(SCATTER * spread.filter(|_| sizes.len() > 3).unwrap_or(0.0));
    for (gain, (slope, error)) in gains.iter_mut().zip(slopes) {
        let relative = slope.abs() / usual;
        if (relative - 1.0).abs() > threshold && (slope.abs() - usual).abs() > 6.0 * error {
            *gain /= relative;
        }
    }
    gains
}

/// The lags that lower the error most, one after the other, where they do so beyond chance.
fn lags(
    bench: &Bench,
    target: Target,
    start: Corrections,
    setting: &impl Fn(Corrections) -> Setting,
    errors: &dyn Fn(&Balance) -> Vec<f64>,
) -> Corrections {
    // A part of the rows is enough to find a lag.
    let coarse = |c: &Corrections| {
        let wanted = Setting { rows: 6000, samples: 12_000, ..setting(c.clone()) };
        Balance::new(bench, target, &wanted).map(|b| errors(&b))
    };
    let mut best = start;
    let Some(mut now) = coarse(&best) else { return best };
    let step = best_step(bench);
    let which: &[bool] = match target {
        Target::Torque => &[true, false],
        _ => &[false],
    };
    let mut ended = [false; 2];
    for round in 0..2 {
        for of_target in which.iter().filter(|t| !ended[usize::from(**t)]).collect::<Vec<_>>() {
            let with = |lag: f64| {
                let mut c = best.clone();
                if *of_target {
                    c.target_lag = lag
                } else {
                    c.motion_lag = lag
                }
                c
            };
            let sum = |lag: f64| coarse(&with(lag)).map_or(f64::INFINITY, |e| e.iter().sum::<f64>());
            let current = if *of_target { best.target_lag } else { best.motion_lag };
            let range = LARGEST_LAG.min(40.0 * step);
            // A coarse grid, then a golden section around its best.
            let grid: Vec<f64> = if round == 0 {
                (-8..=8).map(|k| current + range * (f64::from(k) / 8.0) * (f64::from(k) / 8.0).abs()).collect()
            } else {
                [-1.0, -0.5, 0.0, 0.5, 1.0].iter().map(|k| current + k * 0.1 * range).collect()
            };
            let values: Vec<f64> = grid.iter().map(|l| sum(*l)).collect();
            let at = (0..grid.len()).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
            let (low, high) = (grid[at.saturating_sub(1)], grid[(at + 1).min(grid.len() - 1)]);
            let lag = golden_section(&sum, low, high, 10);
            // What goes on to the end of the search is no lag.
            if lag.abs() > AT_THE_END * range {
                ended[usize::from(*of_target)] = true;
                continue;
            }
            let changed = with(lag);
            let Some(after) = coarse(&changed) else { continue };
            let (a, b) = (now.iter().sum::<f64>(), after.iter().sum::<f64>());
            if b < (1.0 - WORTH) * a && paired(&now, &after) > 2.5 {
                best = changed;
                now = after;
            }
        }
    }
    best
}

fn best_step(bench: &Bench) -> f64 {
    bench.logs.iter().map(|l| signals::median_step(&l.time)).fold(0.0, f64::max)
}

/// Lags again, with the effects that were found. `None` where they stay.
pub fn refine(
    bench: &Bench,
    work: &Work,
    corrections: &Corrections,
    setting: &impl Fn(Corrections) -> Setting,
) -> Option<Corrections> {
    let target = work.balance.target;
    if !shows_lags(bench, &work.balance) {
        return None;
    }
    let effects: Vec<_> = work.terms.iter().filter_map(|t| t.effect()).collect();
    let with_effects = move |balance: &Balance| {
        let mut columns: Vec<Vec<f64>> = (0..balance.base.len()).map(|i| balance.base_column(i)).collect();
        columns.extend(effects.iter().flat_map(|(e, s)| balance.effect_columns(*e, *s)));
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        robust::errors(&balance.rows, &columns, &balance.target_column())
    };
    let better = lags(bench, target, corrections.clone(), setting, &with_effects);
    let moved = (better.target_lag - corrections.target_lag).abs() + (better.motion_lag - corrections.motion_lag).abs();
    (moved > 0.05 * work.balance.step()).then_some(better)
}

#[cfg(test)]
mod tests;
