//! Straight lines through steady stretches of a log.
//!
//! The one idea: samples of a log are not independent, steady stretches nearly are. So a log is first brought to
//! one point for each step (or block), and the line with its uncertainty goes through those.

use super::estimate::{Estimate, Fit, least_squares};
use crate::signals;

/// Cut off at either end of a step \[s\] (Urs et al., section IV).
pub(crate) const TRIM: f64 = 0.5;
/// Of a short step at most this share is cut off at either end.
const LARGEST_TRIM: f64 = 0.2;
/// Length of the blocks whose medians are compared \[s\].
const BLOCK: f64 = 0.1;
/// Blocks belong to one step while they differ by less than this share of the range.
const LEVEL: f64 = 0.02;

/// Steps of a signal: index ranges in which it stays level for at least `shortest` \[s\]. It may be noisy; what
/// lies between steps belongs to none.
pub fn steps(time: &[f64], signal: &[f64], shortest: f64) -> Vec<std::ops::Range<usize>> {
    let step = signals::median_step(time);
    if step <= 0.0 {
        return Vec::new();
    }
    let length = ((BLOCK / step).round() as usize).max(5);
    let quantile = |share| signals::quantile(signal.to_vec(), share).unwrap_or(0.0);
    let range = quantile(0.98) - quantile(0.02);
    // A median of n samples scatters by 1.25 σ/√n.
    let tolerance = (LEVEL * range).max(5.0 * 1.25 * noise(signal) / (length as f64).sqrt());
    let starts: Vec<usize> = (0..time.len() / length.max(1)).map(|b| b * length).collect();
    let level = |from: usize, to: usize| signals::median(signal[from..to].to_vec()).unwrap_or(f64::NAN);
    let mut found = Vec::new();
    let (mut first, mut sum, mut count) = (0_usize, 0.0, 0.0);
    let mut close = |from: usize, to: usize| {
        if to > from && time[to - 1] - time[from] >= shortest {
            found.push(from..to);
        }
    };
    for &start in &starts {
        let here = level(start, start + length);
        // A gap in time ends a step too.
        let gap = start > 0 && time[start] - time[start - 1] > 6.0 * step;
        if count > 0.0 && !gap && (here - sum / count).abs() <= tolerance {
            sum += here;
            count += 1.0;
            continue;
        }
        close(first, start);
        (first, sum, count) = (start, here, 1.0);
    }
    if let Some(last) = starts.last() {
        close(first, last + length);
    }
    found
}

/// Standard deviation of a signal's noise from sample to sample, by the median of its differences.
pub(crate) fn noise(signal: &[f64]) -> f64 {
    signals::median(signal.windows(2).map(|w| (w[1] - w[0]).abs()).collect()).unwrap_or(0.0) * 1.05
}

/// A step without its ends: half a second, or a fifth of a short step.
pub(crate) fn trimmed(time: &[f64], step: &std::ops::Range<usize>) -> std::ops::Range<usize> {
    let (from, to) = (time[step.start], time[step.end - 1]);
    let cut = TRIM.min(LARGEST_TRIM * (to - from));
    let start = step.start + time[step.clone()].partition_point(|t| *t < from + cut);
    let end = step.start + time[step.clone()].partition_point(|t| *t <= to - cut);
    start..end.max(start)
}

/// The mean of the finite values of a stretch.
pub fn mean(values: &[f64]) -> Option<f64> {
    let finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    (!finite.is_empty()).then(|| finite.iter().sum::<f64>() / finite.len() as f64)
}

/// At most this many rows are taken as points of their own; of a longer log blocks are.
pub(crate) const POINTS: usize = 60;
/// Blocks of a longer log.
pub(crate) const BLOCKS: usize = 40;

/// The points that a line goes through: the rows of a short table, blocks of a long log.
pub fn points(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    let known: Vec<(f64, f64)> =
        x.iter().zip(y).filter(|(x, y)| x.is_finite() && y.is_finite()).map(|(x, y)| (*x, *y)).collect();
    if known.len() <= POINTS {
        return known;
    }
    let n = known.len();
    (0..BLOCKS)
        .map(|b| {
            let part = &known[b * n / BLOCKS..(b + 1) * n / BLOCKS];
            let count = part.len() as f64;
            (part.iter().map(|p| p.0).sum::<f64>() / count, part.iter().map(|p| p.1).sum::<f64>() / count)
        })
        .collect()
}

/// `y = slope · x + zero` through points.
#[derive(Debug, Clone)]
pub struct Line {
    /// The points.
    pub points: Vec<(f64, f64)>,
    /// Slope and zero.
    pub fit: Fit,
    /// By which share the slope at the largest x differs from that at zero, where that is beyond chance (99 %).
    pub bend: Option<f64>,
    /// Change of the zero from the first to the last point, where that is beyond chance (99 %).
    pub drift: Option<f64>,
    /// Half-width (95 %) of that change; infinite where it cannot be told from the slope: x in rising order.
    pub drift_half: f64,
    /// Slope at zero, where the points bend beyond chance.
    pub initial: Option<Estimate>,
}

impl Line {
    /// Through at least four points; `None` where fewer, or where x is the same everywhere.
    pub fn through(points: Vec<(f64, f64)>) -> Option<Line> {
        if points.len() < 4 {
            return None;
        }
        let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        let ones = vec![1.0; x.len()];
        let fit = least_squares(&[x.clone(), ones.clone()], &y)?;
        let significant = |fit: &Fit, index: usize| {
            fit.freedom >= 3.0 && fit.ratio(index).abs() > super::estimate::quantile(0.995, fit.freedom)
        };
        let largest = x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let square: Vec<f64> = x.iter().map(|v| v * v.abs()).collect();
        let bent = least_squares(&[x.clone(), square, ones.clone()], &y).filter(|f| significant(f, 1));
        let bend = bent.as_ref().map(|f| 2.0 * f.coefficients[1] * largest / f.coefficients[0]);
        let initial = bent.map(|f| f.estimate(0));
        let order: Vec<f64> = (0..x.len()).map(|k| k as f64 / (x.len() - 1) as f64 - 0.5).collect();
        let drifting = least_squares(&[x, ones, order], &y);
        let drift_half = drifting.as_ref().map_or(f64::INFINITY, |f| f.estimate(2).half_width());
        let drift = drifting.filter(|f| significant(f, 2)).map(|f| f.coefficients[2]);
        Some(Line { points, fit, bend, drift, drift_half, initial })
    }

    /// Slope.
    pub fn slope(&self) -> Estimate {
        self.fit.estimate(0)
    }

    /// Where it crosses x = 0.
    pub fn zero(&self) -> Estimate {
        self.fit.estimate(1)
    }

    /// Largest abs(x).
    pub fn largest(&self) -> f64 {
        self.points.iter().fold(0.0, |m, p| m.max(p.0.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_found_in_noise_and_ends_are_cut() {
        let time: Vec<f64> = (0..3000).map(|k| f64::from(k) * 0.01).collect();
        let noise = |k: usize| 0.1 * ((k * 7919 % 1000) as f64 / 500.0 - 1.0);
        let signal: Vec<f64> = (0..3000).map(|k| (k / 500) as f64 - 2.0 + noise(k)).collect();
        let found = steps(&time, &signal, 1.5);
        assert_eq!(found.len(), 6, "{found:?}");
        for (k, step) in found.iter().enumerate() {
            assert!((step.start as f64 - 500.0 * k as f64).abs() <= 10.0, "{step:?}");
            let inner = trimmed(&time, step);
            assert!(time[inner.start] - time[step.start] >= TRIM - 1e-9);
            assert!(time[step.end - 1] - time[inner.end - 1] >= TRIM - 1e-9);
        }
    }
}
