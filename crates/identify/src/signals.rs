//! Sampled signals: even grids, one zero-phase filter for everything, derivatives, shifts in time.
//!
//! The one idea: an equation stays true when every term of it goes through the same linear filter. So
//! nothing is differentiated or compared before it was filtered, and nothing non-linear is applied
//! after.

/// Stretches of time between gaps: index ranges of a time axis \[s\]. A gap is a step of more than six
/// median steps.
pub fn stretches(time: &[f64]) -> Vec<std::ops::Range<usize>> {
    let step = median_step(time);
    let mut found = Vec::new();
    let mut start = 0;
    for k in 1..time.len() {
        if time[k] - time[k - 1] > 6.0 * step {
            found.push(start..k);
            start = k;
        }
    }
    if start < time.len() {
        found.push(start..time.len());
    }
    found
}

/// The median step of a time axis \[s\]; zero for fewer than two samples.
pub(crate) fn median_step(time: &[f64]) -> f64 {
    let steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    median(steps).unwrap_or(0.0)
}

/// How many whole steps a time has, from their quotient: what is whole but for rounding is whole. Times of day, or a
/// log that begins at another second, must not give one sample less.
///
/// ```
/// use gearwise_identify::signals::whole;
/// assert_eq!((whole(0.3 / 0.1), whole(2.5), whole(-1.0)), (3, 2, 0));
/// ```
pub fn whole(steps: f64) -> usize {
    (steps + 1e-6).floor().max(0.0) as usize
}

/// How many steps cover a time, from their quotient, with the same care, and at least one.
///
/// ```
/// use gearwise_identify::signals::covering;
/// assert_eq!((covering(0.3 / 0.1), covering(2.5), covering(0.0)), (3, 3, 1));
/// ```
pub fn covering(steps: f64) -> usize {
    ((steps - 1e-6).ceil() as usize).max(1)
}

/// The median of the finite values; `None` where there is none.
pub fn median(values: Vec<f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// A quantile of the finite values.
pub(crate) fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.retain(|v| v.is_finite());
    if values.is_empty() {
        return None;
    }
    let index = ((values.len() - 1) as f64 * share).round() as usize;
    let (_, value, _) = values.select_nth_unstable_by(index, f64::total_cmp);
    Some(*value)
}

/// Values at the points `start + k·step`, linearly between samples; missing (NaN) samples are bridged.
/// `None` where fewer than two samples are there.
pub(crate) fn on_grid(time: &[f64], values: &[f64], start: f64, step: f64, count: usize) -> Option<Vec<f64>> {
    let known: Vec<usize> = (0..time.len()).filter(|k| values[*k].is_finite()).collect();
    if known.len() < 2 {
        return None;
    }
    let mut at = 0;
    let resampled = (0..count).map(|k| {
        let t = start + k as f64 * step;
        while at + 2 < known.len() && time[known[at + 1]] <= t {
            at += 1;
        }
        let (a, b) = (known[at], known[at + 1]);
        let share = ((t - time[a]) / (time[b] - time[a])).clamp(0.0, 1.0);
        values[a] + share * (values[b] - values[a])
    });
    Some(resampled.collect())
}

/// Opens wrapped angles: a jump of more than half a turn between samples is a wrap. An angle that goes beyond a turn is
/// not wrapped: there a jump is what was turned while nothing was logged.
///
/// ```
/// use gearwise_identify::signals::unwrapped;
/// assert_eq!(unwrapped(&[3.0, -3.0])[1], -3.0 + std::f64::consts::TAU);
/// assert_eq!(unwrapped(&[0.0, 3.0, 9.0, 20.0]), [0.0, 3.0, 9.0, 20.0]);
/// ```
pub fn unwrapped(values: &[f64]) -> Vec<f64> {
    let known = || values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = known().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if high - low > 1.02 * std::f64::consts::TAU {
        return values.to_vec();
    }
    let mut turns = 0.0;
    let mut last = f64::NAN;
    values
        .iter()
        .map(|v| {
            if v.is_finite() {
                if last.is_finite() {
                    turns -= ((v - last) / std::f64::consts::TAU).round();
                }
                last = *v;
            }
            v + turns * std::f64::consts::TAU
        })
        .collect()
}

/// A signal shifted in time: `values(t + shift)`, shift in samples, by a cubic through four points; held
/// at the ends.
pub fn shifted(values: &[f64], shift: f64) -> Vec<f64> {
    if shift == 0.0 || values.is_empty() {
        return values.to_vec();
    }
    let last = values.len() as isize - 1;
    let whole = shift.floor();
    let f = shift - whole;
    let weights = [
        -f * (f - 1.0) * (f - 2.0) / 6.0,
        (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0,
        -(f + 1.0) * f * (f - 2.0) / 2.0,
        (f + 1.0) * f * (f - 1.0) / 6.0,
    ];
    let whole = whole as isize;
    let at = |k: isize| values[k.clamp(0, last) as usize];
    (0..values.len() as isize)
        .map(|k| {
            let base = k + whole;
            (0..4).map(|j| weights[j as usize] * at(base + j - 1)).sum()
        })
        .collect()
}

/// Derivative by central differences \[1/s\], one-sided at the ends.
pub fn derivative(values: &[f64], step: f64) -> Vec<f64> {
    let n = values.len();
    if n < 2 {
        return vec![0.0; n];
    }
    (0..n)
        .map(|k| {
            let (a, b) = (k.saturating_sub(1), (k + 1).min(n - 1));
            (values[b] - values[a]) / ((b - a) as f64 * step)
        })
        .collect()
}

/// The integral by trapezoids, from zero.
pub fn integral(values: &[f64], step: f64) -> Vec<f64> {
    let mut sum = 0.0;
    let mut out = Vec::with_capacity(values.len());
    for k in 0..values.len() {
        if k > 0 {
            sum += 0.5 * step * (values[k] + values[k - 1]);
        }
        out.push(sum);
    }
    out
}

/// A zero-phase low-pass filter: a Butterworth filter of fourth order, forwards and backwards.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LowPass {
    sections: [[f64; 5]; 2],
    fraction: f64,
    padding: usize,
    guard: usize,
}

impl LowPass {
    /// With its cut-off (−6 dB) at a fraction of the sampling rate, below one half.
    pub fn new(fraction: f64) -> LowPass {
        let fraction = fraction.clamp(1e-5, 0.49);
        let k = (std::f64::consts::PI * fraction).tan();
        let section = |q: f64| {
            let norm = 1.0 / (1.0 + k / q + k * k);
            [k * k * norm, 2.0 * k * k * norm, k * k * norm, 2.0 * (k * k - 1.0) * norm, (1.0 - k / q + k * k) * norm]
        };
        let q = |angle: f64| 1.0 / (2.0 * angle.cos());
        let sections = [section(q(std::f64::consts::PI / 8.0)), section(q(3.0 * std::f64::consts::PI / 8.0))];
        let (padding, guard) = ((4.0 / fraction).ceil() as usize, (0.75 / fraction).ceil() as usize);
        LowPass { sections, fraction, padding, guard }
    }

    /// The share of the power of white noise that passes: the integral of `1/(1 + r⁸)²` over all frequencies, with
    /// `r = tan πν / tan πν_c`.
    pub fn noise_gain(&self) -> f64 {
        const STEPS: usize = 2000;
        let end = 0.5_f64.min(6.0 * self.fraction);
        let cut = (std::f64::consts::PI * self.fraction).tan();
        let power = |nu: f64| (1.0 + ((std::f64::consts::PI * nu).tan() / cut).powi(8)).powi(-2);
        // By the midpoints of equal steps.
        let middle = |k: usize| (k as f64 + 0.5) / STEPS as f64 * end;
        2.0 * (0..STEPS).map(|k| power(middle(k))).sum::<f64>() * end / STEPS as f64
    }

    /// Samples at either end that the ends have spoiled.
    pub fn guard(&self) -> usize {
        self.guard
    }

    /// The filtered signal. Ends are continued by reflection about their last value.
    pub fn apply(&self, values: &[f64]) -> Vec<f64> {
        let n = values.len();
        if n < 2 {
            return values.to_vec();
        }
        let pad = self.padding.min(n - 1);
        let mut x = Vec::with_capacity(n + 2 * pad);
        x.extend((1..=pad).rev().map(|k| 2.0 * values[0] - values[k]));
        x.extend_from_slice(values);
        x.extend((1..=pad).map(|k| 2.0 * values[n - 1] - values[n - 1 - k]));
        for _ in 0..2 {
            self.forward(&mut x);
            x.reverse();
        }
        x[pad..pad + n].to_vec()
    }

    fn forward(&self, x: &mut [f64]) {
        for [b0, b1, b2, a1, a2] in self.sections {
            // Starts settled at the first value.
            let first = x[0];
            let (mut s1, mut s2) = ((1.0 - b0) * first, (b2 - a2) * first);
            for value in x.iter_mut() {
                let input = *value;
                let output = b0 * input + s1;
                s1 = b1 * input - a1 * output + s2;
                s2 = b2 * input - a2 * output;
                *value = output;
            }
        }
    }
}

/// Power spectral density by Welch's method, Hann windows half overlapping: frequency \[Hz\] and density
/// \[unit²/Hz\]. Empty where the signal is shorter than 16 samples.
pub(crate) fn welch(values: &[f64], step: f64, window: usize) -> Vec<(f64, f64)> {
    let length = window.min(values.len());
    if length < 16 {
        return Vec::new();
    }
    let mut planner = realfft::RealFftPlanner::<f64>::new();
    let fft = planner.plan_fft_forward(length);
    let hann: Vec<f64> =
        (0..length).map(|k| 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / length as f64).cos()).collect();
    let power: f64 = hann.iter().map(|w| w * w).sum();
    let mut sum = vec![0.0; length / 2 + 1];
    let (mut count, mut start) = (0, 0);
    while start + length <= values.len() {
        let part = &values[start..start + length];
        let mean = part.iter().sum::<f64>() / length as f64;
        let mut input: Vec<f64> = part.iter().zip(&hann).map(|(v, w)| (v - mean) * w).collect();
        let mut spectrum = fft.make_output_vec();
        if fft.process(&mut input, &mut spectrum).is_ok() {
            for (s, c) in sum.iter_mut().zip(&spectrum) {
                *s += c.norm_sqr();
            }
            count += 1;
        }
        start += length / 2;
    }
    let scale = 2.0 * step / (power * f64::from(count.max(1)));
    sum.iter().enumerate().map(|(k, s)| (k as f64 / (length as f64 * step), s * scale)).collect()
}

/// Standard deviation of the noise of a signal: from the second differences, which take out what is slow.
pub(crate) fn noise_level(values: &[f64]) -> f64 {
    let second: Vec<f64> = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    let zero = second.iter().filter(|v| **v == 0.0).count();
    // Most are zero where a slow signal is quantised: then the mean says more than the median.
    if 2 * zero > second.len() {
        let sum: f64 = second.iter().map(|v| v * v).sum();
        return (sum / second.len().max(1) as f64 / 6.0).sqrt();
    }
    median(second).unwrap_or(0.0) / 0.6745 / 6.0_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_filter_keeps_what_is_slow_in_place_and_takes_what_is_fast() {
        let (step, n) = (1e-3, 4000);
        let filter = LowPass::new(20.0 * step);
        let wave =
            |f: f64| -> Vec<f64> { (0..n).map(|k| (std::f64::consts::TAU * f * k as f64 * step).sin()).collect() };
        let slow = filter.apply(&wave(2.0));
        for (k, (a, b)) in slow.iter().zip(wave(2.0)).enumerate().skip(200).take(3600) {
            assert!((a - b).abs() < 1e-3, "{k}: {a} {b}");
        }
        let fast = filter.apply(&wave(80.0));
        assert!(fast[200..3800].iter().all(|v| v.abs() < 1e-4));
        // −6 dB at the cut-off: forwards and backwards −3 dB each.
        let at_cut_off = filter.apply(&wave(20.0));
        let peak = at_cut_off[500..3500].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert_relative_eq!(peak, 0.5, max_relative = 5e-3);
        // A constant passes unchanged, ends included; a ramp, within the guard, is off by less than 1 % of a
        // step.
        assert!(filter.apply(&[3.0; 500]).iter().all(|v| (v - 3.0).abs() < 1e-12));
        let ramp: Vec<f64> = (0..n).map(|k| 3.0 + 0.01 * k as f64).collect();
        let guard = filter.guard();
        for (a, b) in filter.apply(&ramp).iter().zip(&ramp).take(n - guard).skip(guard) {
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
    }

    /// Parseval: the power of white noise that passes is the sum of squares of the answer to one sample of one.
    #[test]
    fn the_gain_of_noise_is_that_of_the_answer_to_an_impulse() {
        for fraction in [0.01, 0.04, 0.2, 0.4] {
            let mut impulse = vec![0.0; 4001];
            impulse[2000] = 1.0;
            let filter = LowPass::new(fraction);
            let energy: f64 = filter.apply(&impulse).iter().map(|v| v * v).sum();
            assert_relative_eq!(filter.noise_gain(), energy, max_relative = 1e-4);
        }
        // Far below the sampling rate: 2 f_c (1 − 1/8) (π/8)/sin(π/8).
        let octave = std::f64::consts::PI / 8.0;
        assert_relative_eq!(LowPass::new(1e-3).noise_gain(), 2e-3 * 0.875 * octave / octave.sin(), max_relative = 1e-4);
    }

    #[test]
    fn shifts_are_those_of_a_cubic() {
        let cubic = |t: f64| 1.0 + t - 0.3 * t * t + 0.02 * t.powi(3);
        let values: Vec<f64> = (0..30).map(|k| cubic(f64::from(k))).collect();
        for shift in [-3.4, -1.0, 0.25, 2.0, 4.7] {
            let moved = shifted(&values, shift);
            for (k, value) in moved.iter().enumerate().take(22).skip(8) {
                assert_relative_eq!(*value, cubic(k as f64 + shift), max_relative = 1e-10);
            }
        }
    }

    #[test]
    fn the_density_integrates_to_the_variance() {
        let mut state = 1_u64;
        let noise: Vec<f64> = (0..16_384)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) as f64 / f64::from(u32::MAX >> 1) - 1.0
            })
            .collect();
        let density = welch(&noise, 0.01, 512);
        let total: f64 = density.iter().map(|(_, d)| d).sum::<f64>() * density[1].0;
        // Uniform over an interval of length one.
        assert_relative_eq!(total, 1.0 / 12.0, max_relative = 0.03);
    }

    #[test]
    fn gaps_divide_a_log() {
        let time = [0.0, 0.1, 0.2, 0.3, 2.0, 2.1, 2.2];
        assert_eq!(stretches(&time), vec![0..4, 4..7]);
        let values = [0.0, 1.0, f64::NAN, 3.0];
        let grid = on_grid(&time[..4], &values, 0.0, 0.1, 4).unwrap();
        assert_relative_eq!(grid[2], 2.0, max_relative = 1e-12);
    }
}
