//! The noise of the instrument in the band, found without the model being right.
//!
//! The one idea: the error of the final model is no measure of noise, because whatever the model lacks is in it. The
//! instrument is looked at where the model has no say: where the motion repeats, while the machine stands, and above the band,
//! where the motion holds nothing. Each way has a condition under which it holds; where it does not hold, it does not count. Two that agree within
//! a factor of two are believed, and then the smaller one; anything less is not known.

use super::regression::{Blocks, Rows, solve, squares};
use crate::answer::noise::{Estimate, Method, Noise};
use crate::signals::{self, LowPass};

/// From here on, in bands, nothing of the filter's own edge is left.
const ABOVE: f64 = 1.3;
/// Share of the sampling rate up to which a spectrum is read.
const READABLE: f64 = 0.45;
/// A spectrum that is read must reach this many bands.
const WIDE: f64 = 1.8;
/// Fewest windows of a spectrum, and of standstill.
const WINDOWS: (usize, usize) = (12, 5);
/// A spectrum is flat where its power over frequency is less than this, either way, within its 95 % bounds.
const FLAT: f64 = 0.75;
/// A bin this many times the median is a line: in what is taken for noise, and in what is told.
const LINES: (f64, f64) = (5.0, 25.0);
/// A motion repeats where its columns differ by at most this share of their squares, after they have differed by that one.
const REPEATS: f64 = 0.01;
const AWAY: f64 = 0.5;
/// Shortest time after which it may repeat, in periods of the band's end.
const AFTER: f64 = 8.0;
/// Samples for each period of the band's end that are enough to see whether it does, and most of them.
const ENOUGH: (f64, usize) = (4.0, 6000);
/// Length of a window of standstill, in periods of the band's end.
const STILL: f64 = 20.0;

/// How a channel was read: its step of quantisation in the unit of the target, and the time between fresh values \[s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Smallest difference of two values.
    pub quantum: f64,
    /// Rows from one fresh value to the next: 1 unless the channel is held.
    pub rows: f64,
}

impl Reading {
    /// Of the values of a channel, a unit of which is `scale` of the target.
    pub fn new(values: &[f64], scale: f64) -> Reading {
        let known: Vec<(usize, f64)> = values.iter().copied().enumerate().filter(|(_, v)| v.is_finite()).collect();
        let steps: Vec<(usize, f64)> =
            known.windows(2).map(|w| (w[0].0, (w[1].1 - w[0].1).abs())).filter(|(_, d)| *d > 0.0).collect();
        let quantum = steps.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
        let between = signals::median(steps.windows(2).map(|w| (w[1].0 - w[0].0) as f64).collect()).unwrap_or(1.0);
        let usual = signals::median(steps.iter().map(|s| s.1).collect()).unwrap_or(0.0);
        // A slow signal of few bits repeats its value too, but then goes on by one step; a held one jumps.
        let is_held = between > 1.0 && usual > 1.5 * quantum;
        Reading {
            quantum: if quantum.is_finite() { quantum * scale.abs() } else { 0.0 },
            rows: if is_held { between } else { 1.0 },
        }
    }

    /// Of two channels that make one response.
    pub fn and(self, other: Reading) -> Reading {
        Reading { quantum: self.quantum.hypot(other.quantum), rows: self.rows.max(other.rows) }
    }
}

/// One stretch of what the model leaves, on its own samples and without the filter.
#[derive(Debug, Clone)]
pub struct Unfiltered {
    /// Time between samples \[s\].
    pub step: f64,
    /// What is left \[unit\].
    pub left: Vec<f64>,
    /// The columns of the declared model that the standing machine has, too.
    pub columns: Vec<Vec<f64>>,
    /// Whether the machine stands.
    pub stands: Vec<bool>,
    /// How the response was read.
    pub reading: Reading,
}

/// The noise of the response within the band, from what a model leaves of each stretch; without a band there is no time
/// axis.
pub fn noise(stretches: &[Unfiltered], band: Option<f64>) -> Noise {
    match band {
        Some(band) => of_stretches(stretches, band),
        None => {
            let why = "these are steady points, without a time axis";
            let none = |method| Estimate { method, value: Err(why) };
            let methods = [Method::Standstill, Method::AboveTheBand, Method::SecondDifferences, Method::Repeats];
            Noise { estimates: methods.map(none).to_vec(), line: None }
        }
    }
}

/// The same of stretches and the end of the band \[Hz\].
pub(crate) fn of_stretches(stretches: &[Unfiltered], band: f64) -> Noise {
    let spectra: Vec<Spectrum> = stretches.iter().map(|s| Spectrum::new(s, band)).collect();
    let estimate = |method, value: Result<f64, &'static str>| {
        // Less than the last digit is not noise but a value that did not change.
        let least = pooled(stretches.iter().map(|s| (s.left.len(), s.quantum_in(band))));
        let value = value.and_then(|v| if v > least { Ok(v) } else { Err("it is less than the last digit") });
        Estimate { method, value }
    };
    Noise {
        estimates: vec![
            estimate(Method::Standstill, standstill(stretches, band)),
            estimate(Method::AboveTheBand, over(&spectra, |s| s.above_the_band(band))),
            estimate(Method::SecondDifferences, over(&spectra, |s| s.second_differences(band))),
            estimate(Method::Repeats, repeats(stretches, band)),
        ],
        line: spectra.iter().find_map(|s| s.line),
    }
}

/// Root mean square over parts with so many samples.
pub(super) fn pooled(parts: impl Iterator<Item = (usize, f64)>) -> f64 {
    let (sum, count) = parts.fold((0.0, 0.0), |(s, n), (k, v)| (s + k as f64 * v * v, n + k as f64));
    if count > 0.0 { (sum / count).sqrt() } else { f64::NAN }
}

/// An estimate over all stretches: those that hold must have most of the samples.
fn over<'a>(
    spectra: &'a [Spectrum<'a>],
    one: impl Fn(&Spectrum<'a>) -> Result<f64, &'static str>,
) -> Result<f64, &'static str> {
    let all: usize = spectra.iter().map(|s| s.of.left.len()).sum();
    let mut why = "the logs are too short";
    let mut parts = Vec::new();
    for spectrum in spectra {
        match one(spectrum) {
            Ok(value) => parts.push((spectrum.of.left.len(), value)),
            Err(reason) => why = reason,
        }
    }
    let held: usize = parts.iter().map(|p| p.0).sum();
    if 5 * held >= 4 * all && held > 0 { Ok(pooled(parts.into_iter())) } else { Err(why) }
}

impl Unfiltered {
    fn filter(&self, band: f64) -> LowPass {
        LowPass::new(band * self.step)
    }

    /// The noise of rounding that is left in the band.
    fn quantum_in(&self, band: f64) -> f64 {
        self.reading.quantum / 12.0_f64.sqrt() * self.filter(band).noise_gain().sqrt()
    }
}

/// The spectrum of what a stretch leaves, above the band.
struct Spectrum<'a> {
    of: &'a Unfiltered,
    /// Frequency \[Hz\] and density from just above the band up.
    bins: Vec<(f64, f64)>,
    windows: usize,
    line: Option<f64>,
}

impl Spectrum<'_> {
    fn new(of: &Unfiltered, band: f64) -> Spectrum<'_> {
        let length = signals::covering(16.0 / (band * of.step)).max(32);
        let windows = (2 * of.left.len() / length).saturating_sub(1);
        let (low, high) = (ABOVE * band, READABLE / of.step);
        let mut bins = if windows >= WINDOWS.0 { signals::welch(&of.left, of.step, length) } else { Vec::new() };
        bins.retain(|b| b.0 >= low && b.0 <= high);
        let line = line_in(&bins, LINES.1);
        Spectrum { of, bins, windows, line }
    }

    /// Flat density from the band to a frequency, or why there is none.
    fn flat_up_to(&self, band: f64, high: f64) -> Result<f64, &'static str> {
        let high = high.min(READABLE / self.of.step);
        if self.of.reading.rows > 1.0 && high > READABLE / (self.of.reading.rows * self.of.step) {
            return Err("the channel repeats its values: fresh ones come too slowly");
        }
        if high < WIDE * band {
            return Err("the band reaches too near to the end of the spectrum");
        }
        let bins: Vec<(f64, f64)> = self.bins.iter().copied().filter(|b| b.0 <= high).collect();
        if bins.len() < 6 {
            return Err("the logs are too short");
        }
        if line_in(&bins, LINES.0).is_some() {
            return Err("there is a line in the spectrum");
        }
        let (slope, error) = slope(&bins, self.windows);
        let rises_or_falls = slope.abs() + 1.645 * error > FLAT;
        if rises_or_falls || is_bent(&bins, self.windows) {
            return Err("the spectrum is not shown to be flat");
        }
        Ok(bins.iter().map(|b| b.1).sum::<f64>() / bins.len() as f64)
    }

    /// White noise of that density, filtered.
    fn above_the_band(&self, band: f64) -> Result<f64, &'static str> {
        let density = self.flat_up_to(band, 3.0 * band)?;
        Ok((density / (2.0 * self.of.step) * self.of.filter(band).noise_gain()).sqrt())
    }

    fn second_differences(&self, band: f64) -> Result<f64, &'static str> {
        self.flat_up_to(band, f64::INFINITY)?;
        Ok(signals::noise_level(&self.of.left) * self.of.filter(band).noise_gain().sqrt())
    }
}

/// Bins on either side of a line that it leaks into, and beyond them those that it has to stand out of.
const BESIDE: (usize, usize) = (2, 8);

/// The frequency of the highest bin, where it stands out of the median of all bins and of that of its neighbours: the top of a broad hump
/// is no line.
fn line_in(bins: &[(f64, f64)], times: f64) -> Option<f64> {
    let median = |bins: &mut dyn Iterator<Item = &(f64, f64)>| signals::median(bins.map(|b| b.1).collect());
    let (place, highest) = bins.iter().enumerate().max_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
    let near = bins.iter().enumerate().filter(|(k, _)| (BESIDE.0 + 1..=BESIDE.1).contains(&k.abs_diff(place)));
    let usual = median(&mut bins.iter())?.max(median(&mut near.map(|(_, bin)| bin)).unwrap_or(0.0));
    (highest.1 > times * usual).then_some(highest.0)
}

/// Relative scatter of a bin: windows overlap by half, and neighbours share a third of what they hold.
fn scatter(windows: usize) -> f64 {
    1.0 / (0.6 * windows as f64).sqrt() / 0.67_f64.sqrt()
}

/// Power of the frequency that a density follows, with its standard error.
fn slope(bins: &[(f64, f64)], windows: usize) -> (f64, f64) {
    let n = bins.len() as f64;
    let points: Vec<(f64, f64)> = bins.iter().map(|b| (b.0.ln(), b.1.max(f64::MIN_POSITIVE).ln())).collect();
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xx, xy) = points.iter().fold((0.0, 0.0), |(a, b), p| (a + (p.0 - x).powi(2), b + (p.0 - x) * (p.1 - y)));
    (xy / xx, scatter(windows) / xx.sqrt())
}

/// Whether the quarters of a density differ beyond their scatter and a factor.
fn is_bent(bins: &[(f64, f64)], windows: usize) -> bool {
    let quarter = bins.len().div_ceil(4);
    let means: Vec<f64> = bins.chunks(quarter).map(|c| c.iter().map(|b| b.1).sum::<f64>() / c.len() as f64).collect();
    let (low, high) = means.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), m| (l.min(*m), h.max(*m)));
    high > (1.4 + 4.0 * scatter(windows) / (quarter as f64).sqrt()) * low
}

/// What differs, in the band, between times at which the motion repeats: what a model lacks is the same at both. Where the
/// machine itself does not repeat it is more than the instrument's.
fn repeats(stretches: &[Unfiltered], band: f64) -> Result<f64, &'static str> {
    let mut parts = Vec::new();
    for s in stretches {
        let filter = s.filter(band);
        let motion: Vec<Vec<f64>> = s.columns.iter().map(|c| filter.apply(c)).filter(|c| varies(c)).collect();
        let Some(period) = period(&motion, band, s.step, filter.guard()) else { continue };
        let left = filter.apply(&s.left);
        let inside = filter.guard()..left.len().saturating_sub(filter.guard() + period);
        let squares: f64 = inside.clone().map(|k| (left[k + period] - left[k]).powi(2)).sum();
        parts.push((inside.len(), (squares / (2.0 * inside.len() as f64)).sqrt()));
    }
    if parts.is_empty() { Err("the motion does not repeat") } else { Ok(pooled(parts.into_iter())) }
}

fn varies(column: &[f64]) -> bool {
    column.windows(2).any(|w| w[0] != w[1])
}

/// The shortest time, in samples, after which all columns of a motion are the same again over at least as long.
fn period(motion: &[Vec<f64>], band: f64, step: f64, guard: usize) -> Option<usize> {
    let every = ((1.0 / (ENOUGH.0 * band * step)) as usize).max(1);
    let thin: Vec<Vec<f64>> =
        motion.iter().map(|c| c.iter().copied().skip(guard).step_by(every).take(ENOUGH.1).collect()).collect();
    let count = thin.first()?.len();
    // Of what two times differ by, in shares of what any two would.
    let differs = |column: &[f64], after: usize| {
        let mean = column.iter().sum::<f64>() / count as f64;
        let all = column.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count as f64;
        let pairs = count - after;
        let squares = (0..pairs).map(|k| (column[k + after] - column[k]).powi(2)).sum::<f64>();
        squares / (2.0 * all * pairs as f64)
    };
    // It must have gone away before it comes back.
    let away = (1..count / 2).find(|after| thin.iter().any(|c| differs(c, *after) > AWAY))?;
    let first = away.max((AFTER * ENOUGH.0) as usize);
    let at = (first..count / 2).find(|after| thin.iter().all(|c| differs(c, *after) < REPEATS))?;
    // To the sample, about there.
    let near = (at.saturating_sub(1) * every).max(1)..(at + 2) * every;
    let whole = |after: usize| -> f64 {
        motion
            .iter()
            .map(|c| {
                let own = &c[guard..c.len() - guard];
                let size: f64 = own.iter().map(|v| v * v).sum();
                (0..own.len() - after).step_by(every).map(|k| (own[k + after] - own[k]).powi(2)).sum::<f64>() / size
            })
            .sum()
    };
    near.filter(|after| 2 * (after + guard) < motion[0].len()).min_by(|a, b| whole(*a).total_cmp(&whole(*b)))
}

/// What is left in the band while the machine stands, less a line over each window and whatever the columns of the
/// declared model make of it there: the median over windows.
fn standstill(stretches: &[Unfiltered], band: f64) -> Result<f64, &'static str> {
    let mut levels = Vec::new();
    for s in stretches {
        let (filter, length) = (s.filter(band), signals::covering(STILL / (band * s.step)));
        let left = filter.apply(&s.left);
        let columns: Vec<Vec<f64>> = s.columns.iter().map(|c| filter.apply(c)).collect();
        // Independent values in a window: two for each period of the bandwidth.
        let independent = length as f64 * filter.noise_gain();
        let mut start = None;
        for k in 0..=s.stands.len() {
            match (k < s.stands.len() && s.stands[k], start) {
                (true, None) => start = Some(k),
                (false, Some(first)) => {
                    let (from, to) = (first + filter.guard(), k.saturating_sub(filter.guard()));
                    let mut at = from;
                    while at + length <= to {
                        levels.extend(level(&left, &columns, at, length, independent));
                        at += length;
                    }
                    start = None;
                }
                _ => {}
            }
        }
    }
    if levels.len() < WINDOWS.1 {
        return Err("the machine is not at rest long enough");
    }
    Ok(signals::median(levels).unwrap_or(0.0).sqrt())
}

/// The mean square of a window, less a line and the columns; for so many as these took up of what is independent.
fn level(left: &[f64], columns: &[Vec<f64>], at: usize, length: usize, independent: f64) -> Option<f64> {
    let window = at..at + length;
    let mut own: Vec<Vec<f64>> = vec![vec![1.0; length], (0..length).map(|k| k as f64 / length as f64 - 0.5).collect()];
    let varies = |c: &&Vec<f64>| c[window.clone()].iter().any(|v| (v - c[at]).abs() > 0.0);
    own.extend(columns.iter().filter(varies).map(|c| c[window.clone()].to_vec()));
    let rows = Rows {
        log: vec![0; length],
        block: vec![0; length],
        time: vec![0.0; length],
        weight: Vec::new(),
        block_log: vec![0],
        block_fits: vec![true],
    };
    let references: Vec<&[f64]> = own.iter().map(Vec::as_slice).collect();
    let total = Blocks::new(&rows, &references, &left[window]).total(|_| true);
    let free = independent - own.len() as f64;
    let sum = squares(&total, &solve(&total).coefficients);
    // The median of a mean square lies below its mean.
    let median = (1.0 - 2.0 / (9.0 * free)).powi(3);
    (free > 3.0 && sum.is_finite()).then(|| sum / length as f64 * independent / free / median)
}

#[cfg(test)]
mod tests;
