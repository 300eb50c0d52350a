//! Back-EMF constant: voltage on speed, driven from outside with open terminals.
//!
//! An amplitude has no sign: where it never goes below zero the speed is taken without its sign too.

use super::estimate::{Estimate, pool};
use super::line::{Line, points};
use super::stall::{SMALL, between_logs, line_band};
use super::{Chart, Curve, Finding, Outcome, PerLog, Quantity, Role, Test, Weight, calibrated, calibration, logs_of};
use crate::bench::{Bench, BenchKind, Channel, Log};
use gearwise_model::words::{handy::with_error, number};

/// The test.
pub struct Backdrive;

/// Speed of the motor \[rad/s\] of a log, from whatever side it was measured on.
pub fn motor_speed(log: &Log, ratio: f64) -> Option<Vec<f64>> {
    if let Some(speed) = log.channel(Channel::MotorVelocity) {
        return Some(speed.to_vec());
    }
    log.channel(Channel::OutputVelocity).map(|v| v.iter().map(|w| ratio * w).collect())
}

/// The line of voltage (q axis) on speed of one log.
pub fn line(log: &Log, ratio: f64) -> Option<Line> {
    let voltage = log.channel(Channel::Voltage)?;
    let mut speed = motor_speed(log, ratio)?;
    if voltage.iter().all(|v| !v.is_finite() || *v >= 0.0) {
        speed.iter_mut().for_each(|w| *w = w.abs());
    }
    Line::through(points(&speed, voltage))
}

impl Test for Backdrive {
    fn name(&self) -> &'static str {
        "backdrive"
    }

    fn run(&self, bench: &Bench, _: &[Outcome]) -> Option<Outcome> {
        let logs = logs_of(bench, BenchKind::Backdrive);
        if logs.is_empty() {
            return None;
        }
        let mut outcome = Outcome {
            method: vec![
                "straight line of the voltage, brought from the column's convention to the q axis, on motor speed, with a \
                 zero for each log; rows of a table are the points, of a long log 40 blocks in time"
                    .into(),
            ],
            ..Outcome::default()
        };
        let mut used: Vec<(f64, Line)> = Vec::new();
        for log in logs.iter().copied() {
            let mut entry = PerLog { log: log.name.clone(), used: true, values: Vec::new(), remarks: Vec::new() };
            match line(log, bench.declared.ratio) {
                Some(line) => {
                    let sign = line.slope().value.signum();
                    entry.values.push(("back_emf_constant", line.slope().scaled(sign), "V*s/rad"));
                    entry.values.push(("zero", line.zero(), "V"));
                    entry.remarks.push(format!("{} points up to {} rad/s", line.points.len(), number(line.largest())));
                    if sign < 0.0 {
                        entry.remarks.push("voltage and speed have opposite signs: turned".into());
                    }
                    if line.bend.is_some_and(|b| b.abs() > SMALL) {
                        outcome.findings.push(Finding::new(
                            "linearity",
                            Weight::Warning,
                            format!(
                                "{}: the voltage is not straight in speed (bend {} %): a filter in the voltage probe, or \
                                 current that flows",
                                log.name,
                                number(100.0 * line.bend.unwrap_or(0.0))
                            ),
                        ));
                    }
                    let zero = line.zero();
                    if zero.value.abs() > zero.half_width()
                        && zero.value.abs() > 0.02 * line.slope().value.abs() * line.largest()
                    {
                        outcome.findings.push(Finding::new(
                            "zero",
                            Weight::Note,
                            format!(
                                "{}: {} V at standstill: the instrument's zero, taken off",
                                log.name,
                                number(zero.value)
                            ),
                        ));
                    }
                    used.push((sign, line));
                }
                None => {
                    entry.used = false;
                    entry.remarks.push("left out: it has fewer than 4 points, or one speed only".into());
                    let text = format!("{}: {}", log.name, entry.remarks[0]);
                    outcome.findings.push(Finding::new("points", Weight::Warning, text));
                }
            }
            outcome.logs.push(entry);
        }
        let estimates: Vec<Estimate> = used.iter().map(|(s, l)| l.slope().scaled(*s)).collect();
        let Some(pooled) = pool(&estimates) else { return Some(outcome) };
        let speed: &[Channel] = &[Channel::MotorVelocity, Channel::OutputVelocity];
        let k = calibrated(pooled.estimate, &logs, &[(&[Channel::Voltage], 1.0), (speed, 1.0)]);
        outcome.findings.extend(calibration(&logs, &[Channel::Voltage]));
        outcome.findings.push(between_logs(pooled.count, pooled.between, k.value));
        outcome.quantities.push(Quantity {
            name: "back_emf_constant",
            estimate: k,
            unit: "V*s/rad",
            remark: format!(
                "q axis (line-to-line rms); {} of line-to-line peak",
                with_error(k.value * 2.0_f64.sqrt(), None, "V*s/rad")
            ),
        });
        let largest = used.iter().map(|(_, l)| l.largest()).fold(0.0, f64::max);
        let lowest = if used.iter().all(|(_, l)| l.points.iter().all(|p| p.0 >= 0.0)) { 0.0 } else { -largest };
        let ends = [lowest, largest];
        outcome.charts.push(Chart {
            x: "motor speed [rad/s]".into(),
            y: "voltage, q axis [V]".into(),
            curves: vec![
                Curve::new(
                    Role::Measured,
                    "measured, zero taken off",
                    used.iter()
                        .flat_map(|(s, l)| l.points.iter().map(move |p| (p.0, s * (p.1 - l.zero().value))))
                        .collect(),
                ),
                Curve::new(
                    Role::Fit,
                    format!("K_B = {}", with_error(k.value, None, "V*s/rad")),
                    ends.iter().map(|w| (*w, w * k.value)).collect(),
                ),
            ],
            band: line_band(&k, lowest, largest),
            ..Chart::default()
        });
        Some(outcome)
    }
}
