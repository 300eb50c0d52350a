//! The first order in time: how much of the measured speed it accounts for.

use super::spectra::Record;
use crate::characterize::estimate::least_squares;
use gearwise_model::numerics::least_squares::{Unknown, minimise};

/// Speed of a first-order machine under a torque that runs straight between samples, exactly.
fn simulate(torque: &[f64], step: f64, j: f64, b: f64, zero: f64, start: f64) -> Vec<f64> {
    let x = b * step / j;
    // Integrals of the exponential over a step, with their series where it is short.
    let decay = (-x).exp();
    let (one, two) = if x.abs() < 1e-4 {
        (1.0 - x / 2.0 + x * x / 6.0, 0.5 - x / 6.0 + x * x / 24.0)
    } else {
        let one = (1.0 - decay) / x;
        (one, (1.0 - one) / x)
    };
    let gain = step / j;
    let mut speed = start;
    let mut out = Vec::with_capacity(torque.len());
    out.push(speed);
    for w in torque.windows(2) {
        speed = decay * speed + gain * ((one - two) * (w[0] - zero) + two * (w[1] - zero));
        out.push(speed);
    }
    out
}

/// Variance accounted for \[%\].
fn accounted(measured: &[f64], left: &[f64]) -> f64 {
    let variance = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
    };
    100.0 * (1.0 - variance(left) / variance(measured))
}

/// J and B with the largest variance accounted for, with a free zero of the torque and initial speed; and that
/// variance.
pub fn refine(record: &Record, start: (f64, f64)) -> ((f64, f64), f64) {
    let size = record.torque.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let speed = record.velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let (j, b) = start;
    let unknown = |start: f64, scale: f64, lower: f64, upper: f64| Unknown { start, scale, lower, upper };
    let unknowns = [
        unknown(j, j, 0.1 * j, 10.0 * j),
        unknown(b, b.max(1e-3 * j), 0.0, f64::INFINITY),
        unknown(0.0, 0.01 * size, -size, size),
        unknown(record.velocity[0], 0.1 * speed, -3.0 * speed, 3.0 * speed),
    ];
    let left = |_: usize, p: &[f64]| -> Vec<f64> {
        let model = simulate(&record.torque, record.step, p[0], p[1], p[2], p[3]);
        model.iter().zip(&record.velocity).map(|(a, b)| a - b).collect()
    };
    let fitted = minimise(1, &left, &unknowns, 25, 1e-8);
    let vaf = accounted(&record.velocity, &left(0, &fitted.values));
    ((fitted.values[0], fitted.values[1]), vaf)
}

/// Variance accounted for with J and B held, zero and initial speed free.
pub fn vaf(record: &Record, j: f64, b: f64) -> f64 {
    // Both enter linearly: three runs and a line.
    let zeros = vec![0.0; record.torque.len()];
    let forced = simulate(&record.torque, record.step, j, b, 0.0, 0.0);
    let by_zero = simulate(&zeros, record.step, j, b, -1.0, 0.0);
    let by_start = simulate(&zeros, record.step, j, b, 0.0, 1.0);
    let left: Vec<f64> = record.velocity.iter().zip(&forced).map(|(v, f)| v - f).collect();
    match least_squares(&[by_zero, by_start], &left) {
        Some(fit) => accounted(&record.velocity, &fit.residuals),
        None => accounted(&record.velocity, &left),
    }
}
