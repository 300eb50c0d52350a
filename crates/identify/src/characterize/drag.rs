//! Friction: drag torque on speed, by a torque sensor or by the current that keeps the motor turning.
//!
//! Coulomb and viscous are always fitted together: a viscous part that cannot be separated from zero is still no zero, and
//! left out it would pass for Coulomb friction. A drag that flattens at a knee (eddy currents) is taken only where it is
//! better beyond chance. A row has room for Coulomb and viscous; where the drag flattens, it gets their best line over
//! the speeds that were measured, and that is said.

use super::backdrive::motor_speed;
use super::estimate::{Estimate, Fit, least_squares};
use super::line::{BLOCKS, POINTS, mean, noise, steps, trimmed};
use super::{
    Chart, Curve, Finding, Outcome, PerLog, Quantity, Role, Test, Weight, calibrated, calibration, find, logs_of,
};
use crate::bench::{Bench, BenchKind, Channel, Log};
use gearwise_model::words::number;

/// The test.
pub struct Drag;

/// Shortest step of speed \[s\].
const SHORTEST: f64 = 0.8;
/// Up to this share of a log's largest speed is rest: the accuracy of a speed sensor.
const RESTS: f64 = 1e-3;
/// Standard errors of a mean speed, or standard deviations of a row's, that are no motion either.
const SURE: f64 = 4.0;
/// A form is better where the F test of its last parameter says so at this level.
const LEVEL: f64 = 0.01;

/// A steady point.
#[derive(Debug, Clone, Copy)]
struct Point {
    log: usize,
    speed: f64,
    torque: f64,
    /// 1 or −1; 0 at rest, which shows the torque sensor's zero alone.
    direction: f64,
}

/// A drag that flattens: `2 T_max/(ω/ω_k + ω_k/ω)` at T_max = 1.
fn eddy(speed: f64, knee: f64) -> f64 {
    if speed == 0.0 { 0.0 } else { 2.0 / (speed / knee + knee / speed) }
}

/// Direction of a speed; 0 of one that is no larger than `rest`.
fn direction(speed: f64, rest: f64) -> f64 {
    if speed.abs() <= rest { 0.0 } else { speed.signum() }
}

/// Standard error of the mean of a stretch, by the scatter of its fifths.
fn standard_error(values: &[f64]) -> f64 {
    let means: Vec<f64> = values.chunks(values.len().div_ceil(5).max(1)).filter_map(mean).collect();
    let count = means.len() as f64;
    let middle = means.iter().sum::<f64>() / count;
    (means.iter().map(|m| (m - middle).powi(2)).sum::<f64>() / (count * (count - 1.0)).max(1.0)).sqrt()
}

/// The rows of a short table as points, or blocks of a long log. No block has two directions, or motion and rest.
fn blocks(log: usize, speed: &[f64], torque: &[f64], rest: f64) -> Vec<Point> {
    let (speed, torque): (Vec<f64>, Vec<f64>) =
        speed.iter().zip(torque).filter(|(w, t)| w.is_finite() && t.is_finite()).unzip();
    let rows = speed.len();
    let rest = if rows <= POINTS { rest } else { rest.max(SURE * noise(&speed)) };
    let length = if rows <= POINTS { 1 } else { rows.div_ceil(BLOCKS) };
    let mut found = Vec::new();
    let mut start = 0;
    for run in speed.chunk_by(|a, b| direction(*a, rest) == direction(*b, rest)) {
        let parts = run.len().div_ceil(length);
        // A flicker between two directions is neither.
        if 2 * run.len() >= length {
            for part in 0..parts {
                let inner = start + part * run.len() / parts..start + (part + 1) * run.len() / parts;
                if let (Some(w), Some(t)) = (mean(&speed[inner.clone()]), mean(&torque[inner])) {
                    found.push(Point { log, speed: w, torque: t, direction: direction(run[0], rest) });
                }
            }
        }
        start += run.len();
    }
    found
}

/// Steady points of one log: steps of speed, or blocks where it has none.
fn steady(index: usize, log: &Log, ratio: f64, torque_constant: Option<f64>) -> Option<Vec<Point>> {
    let speed = motor_speed(log, ratio)?;
    let torque: Vec<f64> = match (log.channel(Channel::Torque), log.channel(Channel::Current), torque_constant) {
        (Some(torque), ..) => torque.iter().map(|t| t / ratio).collect(),
        (None, Some(current), Some(k)) => current.iter().map(|i| k * i).collect(),
        _ => return None,
    };
    let rest = RESTS * speed.iter().filter(|w| w.is_finite()).fold(0.0_f64, |m, w| m.max(w.abs()));
    let point = |inner: std::ops::Range<usize>| {
        let (w, t) = (mean(&speed[inner.clone()])?, mean(&torque[inner.clone()])?);
        let direction = direction(w, rest.max(SURE * standard_error(&speed[inner])));
        Some(Point { log: index, speed: w, torque: t, direction })
    };
    let found: Vec<Point> = steps(&log.time, log.channel(Channel::Command).unwrap_or(&speed), SHORTEST)
        .iter()
        .filter_map(|step| point(trimmed(&log.time, step)))
        .collect();
    Some(if found.len() >= 4 { found } else { blocks(index, &speed, &torque, rest) })
}

impl Test for Drag {
    fn name(&self) -> &'static str {
        "drag"
    }

    fn run(&self, bench: &Bench, before: &[Outcome]) -> Option<Outcome> {
        let logs = logs_of(bench, BenchKind::Drag);
        if logs.is_empty() {
            return None;
        }
        let mut outcome = Outcome::default();
        let constant = find(before, "torque_constant")
            .or_else(|| bench.declared.motor.as_ref().map(|m| Estimate::exact(m.torque_constant)));
        let by_current = logs.iter().all(|l| l.channel(Channel::Torque).is_none());
        outcome.method.push(format!(
            "means over each step of speed without its ends{}; Coulomb + viscous, against Coulomb + a drag with a knee by an \
             F test at {} %",
            if by_current { ", torque = K_T · current" } else { "" },
            number(100.0 * LEVEL)
        ));
        let mut all: Vec<Point> = Vec::new();
        for (index, log) in logs.iter().enumerate() {
            let found = steady(index, log, bench.declared.ratio, constant.map(|k| k.value)).unwrap_or_default();
            let mut remarks = vec![format!("{} steady points", found.len())];
            let used = found.len() >= 4;
            if !used {
                let text = format!(
                    "{}: left out: {} steady points{}",
                    log.name,
                    found.len(),
                    if constant.is_none() && by_current {
                        "; its current needs a torque constant (stall test, or a declared motor)"
                    } else {
                        ""
                    }
                );
                outcome.findings.push(Finding::new("points", Weight::Warning, text));
                remarks.push("left out".into());
            } else {
                all.extend(found);
            }
            outcome.logs.push(PerLog { log: log.name.clone(), used, values: Vec::new(), remarks });
        }
        fit(&mut outcome, all, logs.len(), by_current, constant);
        for quantity in &mut outcome.quantities {
            // A torque constant from the same current has its gain in it already, the other way round.
            quantity.estimate = calibrated(quantity.estimate, &logs, &[(&[Channel::Torque], 1.0)]);
        }
        outcome.findings.extend(calibration(&logs, &[Channel::Torque]));
        Some(outcome)
    }
}

/// Zeros that the log can show: it rests, or turns both ways.
fn zeros(all: &[Point], logs: usize) -> Vec<Vec<f64>> {
    (0..logs)
        .filter(|log| {
            let own = || all.iter().filter(|p| p.log == *log);
            let both = own().any(|p| p.direction > 0.0) && own().any(|p| p.direction < 0.0);
            own().count() > 0 && (both || own().any(|p| p.direction == 0.0))
        })
        .map(|log| all.iter().map(|p| f64::from(u8::from(p.log == log))).collect())
        .collect()
}

/// Whether the torque depends on speed but not on its direction.
fn even(all: &[Point], zeros: &[Vec<f64>]) -> bool {
    let way = |sign: f64| all.iter().filter(|p| p.direction == sign).count();
    if way(1.0) < 3 || way(-1.0) < 3 {
        return false;
    }
    let torque: Vec<f64> = all.iter().map(|p| p.torque).collect();
    let squares = |of: fn(f64) -> f64| {
        let mut columns: Vec<Vec<f64>> =
            vec![all.iter().map(|p| of(p.direction)).collect(), all.iter().map(|p| of(p.speed)).collect()];
        columns.extend(zeros.iter().cloned());
        least_squares(&columns, &torque).map_or(f64::INFINITY, |f| f.squares())
    };
    squares(f64::abs) < 0.25 * squares(|x| x)
}

/// Whether one parameter more is worth it.
fn better(simple: &Fit, rich: &Fit) -> bool {
    let freedom = simple.freedom - 1.0;
    if freedom < 2.0 || rich.squares() <= 0.0 {
        return false;
    }
    let f = (simple.squares() - rich.squares()) / (rich.squares() / freedom);
    // F with one degree of freedom above is the square of Student's t.
    f > super::estimate::quantile(1.0 - 0.5 * LEVEL, freedom).powi(2)
}

fn fit(outcome: &mut Outcome, mut all: Vec<Point>, logs: usize, by_current: bool, constant: Option<Estimate>) {
    if all.is_empty() {
        return;
    }
    let zero_columns = zeros(&all, logs);
    if even(&all, &zero_columns) {
        outcome.findings.push(Finding::new(
            "direction",
            Weight::Warning,
            "the torque is the same in both directions, but drag brakes: a sensor without sign, or one machine drives one \
             way and the other the other way; take one direction (and standstill) with `select`. Nothing is fitted",
        ));
        return;
    }
    let zero_known = !zero_columns.is_empty();
    // Friction brakes: what the sensor calls negative is turned.
    let centre = if zero_known { all.iter().map(|p| p.torque).sum::<f64>() / all.len() as f64 } else { 0.0 };
    if all.iter().map(|p| p.direction * (p.torque - centre)).sum::<f64>() < 0.0 {
        all.iter_mut().for_each(|p| p.torque = -p.torque);
        outcome.findings.push(Finding::new(
            "sign",
            Weight::Note,
            "torque and speed have opposite signs: it is turned (drag always brakes)",
        ));
    }
    let torque: Vec<f64> = all.iter().map(|p| p.torque).collect();
    let columns = |more: &[Vec<f64>]| {
        let mut columns = vec![all.iter().map(|p| p.direction).collect::<Vec<f64>>()];
        columns.extend(more.iter().cloned());
        columns.extend(zero_columns.iter().cloned());
        columns
    };
    let speeds: Vec<f64> = all.iter().map(|p| p.speed).collect();
    let coulomb = least_squares(&columns(&[]), &torque);
    let viscous = least_squares(&columns(std::slice::from_ref(&speeds)), &torque);
    let Some(coulomb) = coulomb else {
        let text = "too few speeds, or none but standstill: nothing can be fitted";
        outcome.findings.push(Finding::new("points", Weight::Warning, text));
        return;
    };
    let fastest = speeds.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let knee = flattening(&columns, &speeds, &torque, fastest);
    let grows = viscous.as_ref().is_some_and(|v| better(&coulomb, v));
    let line = viscous;
    let flat = knee.filter(|(_, k)| grows && line.as_ref().is_some_and(|l| better(l, k)) && k.coefficients[1] > 0.0);
    let found = line.as_ref().unwrap_or(&coulomb);
    // K_T is behind every torque that was a current.
    let with_constant = |e: Estimate| match constant.filter(|_| by_current) {
        Some(k) => Estimate::combined(e.value, &[(1.0, e), (e.value / k.value, k)]),
        None => e,
    };
    let c = with_constant(found.estimate(0));
    if zero_known {
        outcome.findings.push(Finding::new(
            "zero",
            Weight::Good,
            "the torque zero of each log is fitted: it rests or turns both ways",
        ));
    } else {
        outcome.findings.push(Finding::new(
            "zero",
            Weight::Warning,
            "the logs turn one way and never rest: a zero of the sensor counts as Coulomb friction; turn both ways",
        ));
    }
    if c.value > 0.0 {
        let remark = if flat.is_some() { "of the best line over the measured speeds" } else { "" };
        outcome.quantities.push(Quantity { name: "coulomb_friction", estimate: c, unit: "N*m", remark: remark.into() });
    } else {
        let text = format!("Coulomb friction comes out as {} N*m: it is left out of the row", number(c.value));
        outcome.findings.push(Finding::new("friction_sign", Weight::Warning, text));
    }
    match &line {
        Some(line) => {
            let b = with_constant(line.estimate(1));
            if b.value > 0.0 {
                outcome.quantities.push(Quantity {
                    name: "viscous_friction",
                    estimate: b,
                    unit: "N*m*s/rad",
                    remark: if flat.is_some() { "of the best line over the measured speeds" } else { "" }.into(),
                });
            } else if grows {
                outcome.findings.push(Finding::new(
                    "friction_sign",
                    Weight::Warning,
                    "drag falls with speed: no viscous friction (Stribeck, or a warming bearing); left out of the row",
                ));
            }
            if !grows {
                outcome.findings.push(Finding::new(
                    "friction_form",
                    Weight::Note,
                    format!(
                        "drag does not change with speed beyond chance: a viscous part of {} ± {} N*m*s/rad cannot be separated \
                         from zero{}; more speeds, or longer steps, would show it",
                        number(b.value),
                        number(b.half_width()),
                        if b.value > 0.0 { "" } else { " and is left out of the row" }
                    ),
                ));
            }
        }
        None => outcome.findings.push(Finding::new(
            "friction_form",
            Weight::Note,
            "one speed does not separate Coulomb from viscous friction: all of it counts as Coulomb's",
        )),
    }
    let mut zeroed: Vec<(f64, f64)> = Vec::new();
    let offset = found.coefficients.len() - zero_columns.len();
    for (k, p) in all.iter().enumerate() {
        let zero: f64 =
            zero_columns.iter().enumerate().map(|(z, column)| column[k] * found.coefficients[offset + z]).sum();
        zeroed.push((p.speed, p.torque - zero));
    }
    let slowest = if all.iter().all(|p| p.direction >= 0.0) { 0.0 } else { -fastest };
    let grid = |f: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..=200).map(|k| slowest + (fastest - slowest) * f64::from(k) / 200.0).map(|w| (w, f(w))).collect()
    };
    let b = line.as_ref().map_or(0.0, |l| l.coefficients[1]);
    let straight = grid(&|w| found.coefficients[0] * w.signum() + b * w);
    let mut curves = vec![Curve::new(Role::Measured, "means over steps, zero taken off", zeroed)];
    match flat {
        Some((knee, fit)) => {
            let peak = with_constant(fit.estimate(1));
            let worst = grid(&|w| fit.coefficients[0] * w.signum() + fit.coefficients[1] * eddy(w, knee))
                .iter()
                .zip(&straight)
                .map(|(a, b)| (a.1 - b.1).abs())
                .fold(0.0, f64::max);
            outcome.findings.push(Finding::new(
                "friction_form",
                Weight::Note,
                format!(
                    "the drag flattens: Coulomb {} N*m with 2 T/(ω/ω_k + ω_k/ω), T = {} N*m, knee ω_k = {} rad/s (eddy \
                     currents) is better than a line, which is up to {} N*m off; do not use the row's line far beyond {} \
                     rad/s",
                    number(fit.coefficients[0]),
                    number(peak.value),
                    number(knee),
                    number(worst),
                    number(fastest)
                ),
            ));
            outcome.quantities.push(Quantity {
                name: "eddy_drag.torque",
                estimate: peak,
                unit: "N*m",
                remark: format!("at the knee, {} rad/s", number(knee)),
            });
            curves.push(Curve::new(Role::Stand, "Coulomb + viscous, as the row has it", straight));
            let bent = grid(&|w| fit.coefficients[0] * w.signum() + fit.coefficients[1] * eddy(w, knee));
            curves.push(Curve::new(Role::Fit, "Coulomb + drag with a knee", bent));
        }
        None => {
            curves.push(Curve::new(Role::Fit, if line.is_some() { "Coulomb + viscous" } else { "Coulomb" }, straight))
        }
    }
    outcome.charts.push(Chart {
        x: "motor speed [rad/s]".into(),
        y: "drag at the motor [N*m]".into(),
        curves,
        ..Chart::default()
    });
}

/// Direction, more columns, and zeros.
type Columns<'a> = dyn Fn(&[Vec<f64>]) -> Vec<Vec<f64>> + 'a;

/// The knee that fits best, and its fit.
fn flattening(columns: &Columns, speeds: &[f64], torque: &[f64], fastest: f64) -> Option<(f64, Fit)> {
    let with = |knee: f64| {
        let column: Vec<f64> = speeds.iter().map(|w| eddy(*w, knee)).collect();
        let mut fit = least_squares(&columns(&[column]), torque)?;
        // The knee was fitted too.
        fit.covariance *= fit.freedom / (fit.freedom - 1.0).max(1.0);
        fit.freedom -= 1.0;
        Some((knee, fit))
    };
    (0..=120)
        .map(|k| 0.1 * fastest * 100.0_f64.powf(f64::from(k) / 120.0))
        .filter_map(with)
        // Far above its knee the form falls: a negative one would pass for a rise.
        .filter(|(_, fit)| fit.coefficients[1] > 0.0)
        .min_by(|a, b| a.1.squares().total_cmp(&b.1.squares()))
}
