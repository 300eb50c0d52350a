//! Torque constant: torque on current, stalled, in steps of current.
//!
//! Each step without its ends is one point; the zero is the log's own and no property of the motor. A log whose
//! slope is of the wrong sign or far from the others' is named; the rest is pooled with the spread between logs.

use super::estimate::{Estimate, bracket, pool};
use super::line::{Line, TRIM, mean, steps, trimmed};
use super::{Chart, Curve, Finding, Outcome, PerLog, Quantity, Role, Test, Weight, calibrated, calibration, logs_of};
use crate::bench::{Bench, BenchKind, Channel, Log};
use crate::identify::artefacts::usual_gains;
use crate::signals;
use gearwise_model::words::{handy::with_error, number};

/// The test.
pub struct Stall;

/// Shortest step \[s\].
const SHORTEST: f64 = 0.8;
/// Faster than this \[rad/s\] (mean over a step) nothing is stalled.
const MOVES: f64 = 1.0;
/// A bend or drift smaller than this share is not spoken of.
pub const SMALL: f64 = 0.03;
/// A drift that is known no better than this share is not known.
const UNTOLD: f64 = 0.05;

/// The steps of one log as points of current (q axis) and torque at the motor, and how many steps moved.
pub fn points(log: &Log, ratio: f64) -> (Vec<(f64, f64)>, usize) {
    let (Some(current), Some(torque)) = (log.channel(Channel::Current), log.channel(Channel::Torque)) else {
        return (Vec::new(), 0);
    };
    let velocity = log.channel(Channel::MotorVelocity).or(log.channel(Channel::OutputVelocity));
    let mut moving = 0;
    let found = steps(&log.time, log.channel(Channel::Command).unwrap_or(current), SHORTEST)
        .iter()
        .map(|step| trimmed(&log.time, step))
        .filter(|inner| {
            let speed = velocity.and_then(|v| mean(&v[(*inner).clone()])).unwrap_or(0.0);
            moving += usize::from(speed.abs() > MOVES);
            speed.abs() <= MOVES
        })
        .filter_map(|inner| Some((mean(&current[inner.clone()])?, mean(&torque[inner])? / ratio)))
        .collect();
    (found, moving)
}

impl Test for Stall {
    fn name(&self) -> &'static str {
        "stall"
    }

    fn run(&self, bench: &Bench, _: &[Outcome]) -> Option<Outcome> {
        let logs = logs_of(bench, BenchKind::Stall);
        if logs.is_empty() {
            return None;
        }
        let mut outcome = Outcome::default();
        outcome.method.push(format!(
            "means over each step of current without its first and last {TRIM} s (a fifth of a short step), straight \
             line with a zero for each log; points are the steps, intervals Student's"
        ));
        let mut lines: Vec<(&Log, Line)> = Vec::new();
        for log in logs.iter().copied() {
            let (found, moving) = points(log, bench.declared.ratio);
            let mut remarks = Vec::new();
            if moving > 0 {
                remarks.push(format!("{moving} steps moved and were left out"));
            }
            let count = found.len();
            match Line::through(found) {
                Some(line) => {
                    outcome.logs.push(PerLog { log: log.name.clone(), used: true, values: Vec::new(), remarks });
                    lines.push((log, line));
                }
                None => {
                    remarks.push(format!("left out: {count} steps of current were found, at least 4 are needed"));
                    let text = format!("{}: {}", log.name, remarks.join("; "));
                    outcome.findings.push(Finding::new("steps", Weight::Warning, text));
                    outcome.logs.push(PerLog { log: log.name.clone(), used: false, values: Vec::new(), remarks });
                }
            }
        }
        let slopes: Vec<(f64, f64)> =
            lines.iter().map(|(_, l)| (l.slope().value, l.slope().standard_uncertainty)).collect();
        let declared = bench.declared.motor.as_ref().map(|m| m.torque_constant);
        let gains = usual_gains(&slopes, declared);
        let mut used: Vec<(f64, &Line)> = Vec::new();
        for ((log, line), gain) in lines.iter().zip(&gains) {
            let Some(entry) = outcome.logs.iter_mut().find(|l| l.log == log.name) else { continue };
            let sign = gain.signum();
            entry.values.push(("torque_constant", line.slope(), "N*m/A"));
            entry.values.push(("zero", line.zero(), "N*m"));
            entry.remarks.push(format!("{} steps up to {} A", line.points.len(), number(line.largest())));
            if sign < 0.0 {
                entry.remarks.push("torque and current have opposite signs: used with the sign turned".into());
                outcome.findings.push(Finding::new(
                    "sign",
                    Weight::Warning,
                    format!(
                        "{}: torque falls with current: sensor or current has the wrong sign; it is turned (sign = -1 in \
                         its column says so)",
                        log.name
                    ),
                ));
            }
            if (gain.abs() - 1.0).abs() > 1e-9 {
                entry.used = false;
                entry.remarks.push("left out: its gain is not the others'".into());
                outcome.findings.push(Finding::new(
                    "gain",
                    Weight::Warning,
                    format!(
                        "{}: its slope is {} of the usual one, far beyond its error and the others' spread: wrong gain of \
                         sensor or drive; it is left out",
                        log.name,
                        number(1.0 / gain.abs())
                    ),
                ));
                continue;
            }
            used.push((sign, line));
        }
        let estimates: Vec<Estimate> = used.iter().map(|(sign, l)| l.slope().scaled(*sign)).collect();
        let Some(pooled) = pool(&estimates) else { return Some(outcome) };
        let mut k = calibrated(pooled.estimate, &logs, &[(&[Channel::Torque], 1.0), (&[Channel::Current], 1.0)]);
        outcome.findings.extend(calibration(&logs, &[Channel::Torque, Channel::Current]));
        if straightness(&mut outcome, &used) {
            // What K_T is depends on the current: the ± is to hold it from the first ampere to the largest's line.
            let initial: Vec<Estimate> =
                used.iter().map(|(s, l)| l.initial.unwrap_or_else(|| l.slope()).scaled(*s)).collect();
            let initial = pool(&initial).map_or(k, |p| p.estimate);
            k = bracket(&[k, initial]);
        }
        zeros(&mut outcome, &used, k.value);
        warmth(&mut outcome, &lines);
        outcome.findings.push(between_logs(pooled.count, pooled.between, k.value));
        // A torque that was measured at the motor has no gear in it.
        let at_motor = |log: &&Log| log.from_motor.contains(&Channel::Torque);
        if bench.declared.ratio != 1.0 && !logs_of(bench, BenchKind::Stall).iter().all(at_motor) {
            outcome.findings.push(Finding::new(
                "gear",
                Weight::Warning,
                format!(
                    "measured behind a gear of {}: its friction is in the slope (low by up to 1 − η while it drives)",
                    number(bench.declared.ratio)
                ),
            ));
        }
        outcome.quantities.push(Quantity {
            name: "torque_constant",
            estimate: k,
            unit: "N*m/A",
            remark: format!(
                "q axis; {} per ampere of phase amplitude",
                with_error(k.value * 1.5_f64.sqrt(), None, "N*m/A")
            ),
        });
        let largest = used.iter().map(|(_, l)| l.largest()).fold(0.0, f64::max);
        let lowest =
            if used.iter().all(|(_, l)| l.points.iter().all(|p| p.0 > -0.1 * largest)) { 0.0 } else { -largest };
        let ends = [lowest, largest];
        outcome.charts.push(Chart {
            x: "current, q axis [A]".into(),
            y: "torque, zero taken off [N*m]".into(),
            curves: vec![
                Curve::new(
                    Role::Measured,
                    "means over steps",
                    used.iter()
                        .flat_map(|(s, l)| l.points.iter().map(move |p| (p.0, s * (p.1 - l.zero().value))))
                        .collect(),
                ),
                Curve::new(
                    Role::Fit,
                    format!("K_T = {}", with_error(k.value, None, "N*m/A")),
                    ends.iter().map(|i| (*i, i * k.value)).collect(),
                ),
            ],
            band: line_band(&k, lowest, largest),
            ..Chart::default()
        });
        Some(outcome)
    }
}

/// Interval of 95 % of a line through zero.
pub(crate) fn line_band(slope: &Estimate, from: f64, to: f64) -> Vec<(f64, f64, f64)> {
    let half = slope.half_width();
    (0..=40)
        .map(|k| from + (to - from) * f64::from(k) / 40.0)
        .map(|x| (x, x * slope.value - half * x.abs(), x * slope.value + half * x.abs()))
        .collect()
}

/// How much the logs differ.
pub(crate) fn between_logs(count: usize, between: f64, value: f64) -> Finding {
    let share = 100.0 * between / value.abs();
    match count {
        1 => Finding::new(
            "between_logs",
            Weight::Note,
            "one log: what differs from mounting to mounting and day to day is not in the ±; repeat it",
        ),
        2 => Finding::new(
            "between_logs",
            Weight::Note,
            format!(
                "two logs differ by {} % beyond their own errors (standard deviation); with two, the interval is wide: a \
                 third would narrow it",
                number(share)
            ),
        ),
        _ => Finding::new(
            "between_logs",
            if share > 10.0 { Weight::Warning } else { Weight::Good },
            format!(
                "{count} logs pooled with random effects (DerSimonian-Laird, interval of Hartung-Knapp): they differ by {} \
                 % beyond their own errors (standard deviation), which is in the ±",
                number(share)
            ),
        ),
    }
}

/// Judges whether torque is straight in current; whether it saturates.
fn straightness(outcome: &mut Outcome, used: &[(f64, &Line)]) -> bool {
    let bends: Vec<f64> = used.iter().filter_map(|(_, l)| l.bend).filter(|b| b.abs() > SMALL).collect();
    let largest = used.iter().map(|(_, l)| l.largest()).fold(0.0, f64::max);
    let falls = bends.iter().filter(|b| **b < 0.0).count();
    let saturates = !bends.is_empty() && 2 * falls > used.len();
    outcome.findings.push(if bends.is_empty() {
        let text = format!("torque is straight in current up to {} A (no bend beyond chance)", number(largest));
        Finding::new("linearity", Weight::Good, text)
    } else if saturates {
        let worst = bends.iter().copied().fold(0.0, f64::min);
        Finding::new(
            "linearity",
            Weight::Warning,
            format!(
                "torque is not straight in current: in {falls} of {} logs the slope falls, by up to {} % at {} A: iron \
                 saturation (or a sensor near its end, or a drift while the current goes in order); the ± reaches from \
                 the slope at zero to the straight line's, `identify` fits torque_constant_saturation",
                used.len(),
                number(-100.0 * worst),
                number(largest)
            ),
        )
    } else {
        Finding::new(
            "linearity",
            Weight::Note,
            format!(
                "{} of {} logs bend beyond chance, but not alike: drift or position rather than saturation",
                bends.len(),
                used.len()
            ),
        )
    });
    saturates
}

fn zeros(outcome: &mut Outcome, used: &[(f64, &Line)], slope: f64) {
    let values: Vec<f64> = used.iter().map(|(s, l)| s * l.zero().value).collect();
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    if values.len() > 1 {
        let text = format!(
            "the torque zeros of the logs lie between {} and {} N*m: a zero is the log's, not the motor's",
            number(low),
            number(high)
        );
        outcome.findings.push(Finding::new("zero", Weight::Note, text));
    } else {
        let text = format!("the torque zero, {} N*m, is taken for the sensor's and not the motor's", number(low));
        outcome.findings.push(Finding::new("zero", Weight::Note, text));
    }
    let worst = used
        .iter()
        .filter_map(|(_, l)| l.drift.map(|d| d / (slope * l.largest())))
        .filter(|d| d.abs() > SMALL)
        .fold(0.0_f64, |m, d| if d.abs() > m.abs() { d } else { m });
    let blind = used.iter().map(|(_, l)| l.drift_half / (slope * l.largest())).fold(0.0_f64, f64::max);
    outcome.findings.push(if worst == 0.0 && blind > UNTOLD {
        Finding::new(
            "zero_drift",
            Weight::Note,
            format!(
                "a drift of the zero cannot be separated from the slope ({}): the current \
                 goes in order, and a drift passes for slope or bend; steps in random order keep that out",
                if blind < 1.0 {
                    format!("to {} % of the largest torque only", number((100.0 * blind).round()))
                } else {
                    "not at all".into()
                }
            ),
        )
    } else if worst == 0.0 {
        Finding::new("zero_drift", Weight::Good, "no log's zero drifts beyond chance")
    } else {
        Finding::new(
            "zero_drift",
            Weight::Warning,
            format!(
                "a zero drifts by {} % of the largest torque from first to last step: a warming motor or sensor; steps in \
                 random order keep that out of the slope",
                number(100.0 * worst)
            ),
        )
    });
}

/// Magnets lose torque when they warm.
fn warmth(outcome: &mut Outcome, logs: &[(&Log, Line)]) {
    let warmed: Vec<(f64, f64)> = logs
        .iter()
        .filter_map(|(log, _)| {
            let winding = log.channel(Channel::WindingTemperature)?;
            let at = |share| signals::quantile(winding.to_vec(), share);
            let (low, high) = (at(0.01)?, at(0.99)?);
            Some((high - low, high))
        })
        .collect();
    let Some(rise) = warmed.iter().map(|w| w.0).reduce(f64::max) else {
        let text = "no winding temperature in the logs: whether the magnets warmed is not known";
        outcome.findings.push(Finding::new("temperature", Weight::Note, text));
        return;
    };
    let hottest = warmed.iter().map(|w| w.1).fold(0.0, f64::max);
    let weight = match rise {
        r if r > 40.0 => Weight::Warning,
        r if r > 15.0 => Weight::Note,
        _ => Weight::Good,
    };
    let mut text = format!(
        "the winding warmed by up to {} K within a log (to {} degC)",
        number(rise.round()),
        number((hottest - 273.15).round())
    );
    if weight != Weight::Good {
        text.push_str(
            "; magnets lose K_T when they warm, neodymium about 0.1 % per kelvin of their own: pause between steps",
        );
    }
    outcome.findings.push(Finding::new("temperature", weight, text));
}
