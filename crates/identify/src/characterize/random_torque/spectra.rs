//! A log of torque and speed as spectra over windows of time.

use crate::bench::{Channel, Log};
use crate::signals::{self, LowPass};
use gearwise_model::numerics::least_squares::{Unknown, minimise};
use gearwise_model::words::number;

/// Complex numbers of the transform.
pub(crate) type Complex = realfft::num_complex::Complex<f64>;

/// Shortest and longest window \[s\].
const WINDOW: (f64, f64) = (0.5, 4.0);
/// A record has about so many windows end to end.
const WINDOWS: f64 = 20.0;

/// Torque, velocity (both at the output) and command on an even grid.
#[derive(Debug, Clone)]
pub struct Record {
    /// Step \[s\].
    pub step: f64,
    /// Torque \[N·m\].
    pub torque: Vec<f64>,
    /// Velocity \[rad/s\].
    pub velocity: Vec<f64>,
    /// Command, where the log has it.
    pub command: Option<Vec<f64>>,
    /// Direction of the velocity, 1 or −1: what Coulomb friction goes with. From [`Record::direct`] on, where it turns
    /// often enough.
    pub direction: Option<Vec<f64>>,
}

impl Record {
    /// The longest stretch without a gap, on an even grid.
    pub fn of(log: &Log, ratio: f64) -> Result<Record, String> {
        let torque = log.channel(Channel::Torque).ok_or("no torque")?;
        let velocity = super::super::backdrive::motor_speed(log, ratio).ok_or("no velocity")?;
        let step = signals::median_step(&log.time);
        let longest = signals::stretches(&log.time).into_iter().max_by_key(|r| r.len()).ok_or("it is empty")?;
        let time = &log.time[longest.clone()];
        if time.len() < 500 || step <= 0.0 {
            return Err(format!("{} samples without a gap are too few", time.len()));
        }
        let count = signals::whole((time[time.len() - 1] - time[0]) / step) + 1;
        let grid = |values: &[f64]| {
            signals::on_grid(time, &values[longest.clone()], time[0], step, count).ok_or("it has no numbers")
        };
        let centred = |mut values: Vec<f64>| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter_mut().for_each(|v| *v -= mean);
            values
        };
        let command = log.channel(Channel::Command).map(grid).transpose()?.map(centred);
        let command = command.filter(|c| c.iter().any(|v| *v != 0.0));
        let velocity = grid(&velocity)?.iter().map(|v| v / ratio).collect();
        Ok(Record { step, torque: centred(grid(torque)?), velocity, command, direction: None })
    }

    /// Turns a torque of the wrong sign and brings the command to the time of the torque; whether it was turned.
    pub fn align(&mut self) -> bool {
        if let Some(command) = &self.command {
            // The lag with the largest covariance, on whole samples: an instrument need not be exact.
            let most = (signals::whole(0.05 / self.step) as isize).min(self.torque.len() as isize / 8);
            let covariance = |lag: isize| {
                let n = self.torque.len() as isize;
                let (from, to) = (0.max(lag), n.min(n + lag));
                (from..to).map(|k| self.torque[k as usize] * command[(k - lag) as usize]).sum::<f64>().abs()
            };
            let best = (-most..=most).max_by(|a, b| covariance(*a).total_cmp(&covariance(*b))).unwrap_or(0);
            self.command = Some(signals::shifted(command, -(best as f64)));
        }
        // A passive machine takes power: work done is positive beyond its change of energy.
        let spectra = Spectra::new(self);
        let power: f64 = (0..spectra.count())
            .flat_map(|w| (2..spectra.frequencies.len()).map(move |k| (w, k)))
            .map(|(w, k)| (spectra.torque[w][k].conj() * spectra.derivative[w][k]).re)
            .sum();
        if power < 0.0 {
            self.torque.iter_mut().for_each(|t| *t = -*t);
            if let Some(command) = &mut self.command {
                command.iter_mut().for_each(|c| *c = -*c);
            }
        }
        power < 0.0
    }

    /// Finds the direction of the velocity, where it turns at least `turns` times. The noise above a frequency
    /// \[Hz\] would turn it where it is slow.
    pub fn direct(&mut self, above: f64, turns: usize) {
        let smooth = LowPass::new(above * self.step).apply(&self.velocity);
        let direction: Vec<f64> = smooth.iter().map(|v| v.signum()).collect();
        let turned = direction.windows(2).filter(|w| w[0] != w[1]).count();
        self.direction = (turned >= turns).then_some(direction);
    }

    /// With the velocity brought forward by a lag \[s\].
    pub fn with_lag(&self, lag: f64) -> Record {
        self.moved(lag / self.step)
    }

    /// With the velocity brought forward by samples.
    fn moved(&self, samples: f64) -> Record {
        Record {
            velocity: signals::shifted(&self.velocity, samples),
            direction: self.direction.as_ref().map(|d| signals::shifted(d, samples.round())),
            ..self.clone()
        }
    }

    /// Without the torque that Coulomb friction takes \[N·m\].
    pub fn without_friction(mut self, friction: f64) -> Record {
        if let Some(direction) = &self.direction {
            self.torque.iter_mut().zip(direction).for_each(|(t, d)| *t -= friction * d);
        }
        self
    }
}

/// Transforms of half-overlapping Hann windows.
#[derive(Debug)]
pub(crate) struct Spectra {
    /// Samples of a window.
    pub length: usize,
    /// Frequencies \[Hz\].
    pub frequencies: Vec<f64>,
    /// Of each window: torque.
    pub torque: Vec<Vec<Complex>>,
    /// Of each window: velocity.
    pub velocity: Vec<Vec<Complex>>,
    /// Of each window: the derivative of the velocity, exactly (by parts: what the window's ends would leak is in it).
    pub derivative: Vec<Vec<Complex>>,
    /// Of each window: command; empty where there is none.
    pub command: Vec<Vec<Complex>>,
    /// Direction of the velocity in each window; empty where it is unknown.
    pub direction: Vec<Vec<Complex>>,
}

impl Spectra {
    /// Of a record.
    pub fn new(record: &Record) -> Spectra {
        let n = record.torque.len();
        let duration = n as f64 * record.step;
        let seconds = (duration / WINDOWS).clamp(WINDOW.0, WINDOW.1);
        let length = (signals::whole(seconds / record.step) / 2 * 2).clamp(32, n.max(32) / 2 * 2);
        let turn = std::f64::consts::TAU / length as f64;
        let hann: Vec<f64> = (0..length).map(|k| 0.5 - 0.5 * (turn * k as f64).cos()).collect();
        let slope: Vec<f64> = (0..length).map(|k| 0.5 * turn / record.step * (turn * k as f64).sin()).collect();
        let frequencies: Vec<f64> = (0..=length / 2).map(|k| k as f64 / (length as f64 * record.step)).collect();
        let mut planner = realfft::RealFftPlanner::<f64>::new();
        let fft = planner.plan_fft_forward(length);
        let transform = |values: &[f64], window: &[f64]| {
            let mean = values.iter().sum::<f64>() / length as f64;
            let mut input: Vec<f64> = values.iter().zip(window).map(|(v, w)| (v - mean) * w).collect();
            let mut output = fft.make_output_vec();
            // Lengths are the plan's by construction.
            let _ = fft.process(&mut input, &mut output);
            output
        };
        let mut spectra = Spectra {
            length,
            frequencies,
            torque: Vec::new(),
            velocity: Vec::new(),
            derivative: Vec::new(),
            command: Vec::new(),
            direction: Vec::new(),
        };
        let mut start = 0;
        while start + length <= n {
            let part = start..start + length;
            let velocity = transform(&record.velocity[part.clone()], &hann);
            let edge = transform(&record.velocity[part.clone()], &slope);
            let derivative = velocity
                .iter()
                .zip(&edge)
                .zip(&spectra.frequencies)
                .map(|((v, e), f)| Complex::new(0.0, std::f64::consts::TAU * f) * v - e)
                .collect();
            spectra.torque.push(transform(&record.torque[part.clone()], &hann));
            spectra.velocity.push(velocity);
            spectra.derivative.push(derivative);
            let optional =
                |values: Option<&Vec<f64>>| values.map_or_else(Vec::new, |v| transform(&v[part.clone()], &hann));
            spectra.command.push(optional(record.command.as_ref()));
            spectra.direction.push(optional(record.direction.as_ref()));
            start += length / 2;
        }
        spectra
    }

    /// With the velocity brought forward by a lag \[s\], and as it would read had it not been averaged (a difference of
    /// positions over some time is a mean), by the square of that time \[s²\]; a negative square brings down a gain that
    /// rises. The part of a sample is taken as phase: between samples an interpolation would read low too.
    pub fn corrected(record: &Record, lag: f64, square: f64) -> Spectra {
        let whole = (lag / record.step).round();
        let rest = lag - whole * record.step;
        let mut spectra = Spectra::new(&record.moved(whole));
        for (k, frequency) in spectra.frequencies.iter().enumerate() {
            let phase = std::f64::consts::TAU * frequency * rest;
            let later = Complex::from_polar(1.0, phase);
            let factor = later / averaged_gain(*frequency, square);
            for values in [&mut spectra.velocity, &mut spectra.derivative] {
                values.iter_mut().for_each(|window| window[k] *= factor);
            }
            // A direction has no mean: it comes from a velocity that is known well where it turns.
            spectra.direction.iter_mut().filter_map(|window| window.get_mut(k)).for_each(|d| *d *= later);
        }
        spectra
    }

    /// Number of windows.
    pub fn count(&self) -> usize {
        self.torque.len()
    }
}

/// Gain of a mean over some time: sin(x)/x at x = π f T, from the square of T \[s²\].
fn averaged_gain(frequency: f64, square: f64) -> f64 {
    // Beyond a gain of about a quarter nothing can be brought back.
    let x = (std::f64::consts::PI * frequency * square.abs().sqrt()).min(2.4);
    match x {
        x if x < 1e-4 => 1.0,
        x if square > 0.0 => x.sin() / x,
        x => x.sinh() / x,
    }
}

/// Frequency \[Hz\], gain of H1 and coherence of velocity on torque.
pub fn response(s: &Spectra) -> Vec<(f64, f64, f64)> {
    (1..s.frequencies.len())
        .map(|k| {
            let (mut tt, mut vv, mut tv) = (0.0, 0.0, Complex::new(0.0, 0.0));
            for w in 0..s.count() {
                let (t, v) = (s.torque[w][k], s.velocity[w][k]);
                tt += t.norm_sqr();
                vv += v.norm_sqr();
                tv += t.conj() * v;
            }
            let coherence = if tt > 0.0 && vv > 0.0 { tv.norm_sqr() / (tt * vv) } else { 0.0 };
            (s.frequencies[k], tv.norm() / tt.max(f64::MIN_POSITIVE), coherence)
        })
        .collect()
}

/// The frequencies that are used, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// Lowest \[Hz\].
    pub low: f64,
    /// Highest \[Hz\].
    pub high: f64,
    /// Why.
    pub why: String,
}

impl Band {
    /// Whether a frequency is in it.
    pub fn holds(&self, frequency: f64) -> bool {
        frequency >= self.low && frequency <= self.high
    }
}

/// The longest band in which the coherence is high.
pub fn band(response: &[(f64, f64, f64)], command: bool) -> Result<Band, String> {
    // A median over five bins: single bins scatter.
    let smooth: Vec<f64> = (0..response.len())
        .map(|k| {
            let part = &response[k.saturating_sub(2)..(k + 3).min(response.len())];
            signals::median(part.iter().map(|p| p.2).collect()).unwrap_or(0.0)
        })
        .collect();
    // The window's first bin sees the mean. Above a quarter of the sampling rate what is folded back counts, and it
    // matters how torque is held and speed is made between samples: more than the gain of a mean makes good.
    let last = response.len() / 2;
    let levels: &[f64] = if command { &[0.8, 0.5, 0.25] } else { &[0.8, 0.5] };
    for level in levels {
        let (mut best, mut start) = (0..0, None);
        for k in 1..=last {
            let high = k < last && smooth.get(k).is_some_and(|c| c >= level);
            match (high, start) {
                (true, None) => start = Some(k),
                (false, Some(s)) => {
                    if k - s > best.len() {
                        best = s..k;
                    }
                    start = None;
                }
                _ => {}
            }
        }
        if best.len() >= 8 {
            let beyond = smooth
                .get(best.end + 3)
                .map_or_else(String::new, |c| format!(", above it falls to {}", number((c * 100.0).round() / 100.0)));
            let why = format!("there the coherence is at least {level}{beyond}");
            return Ok(Band { low: response[best.start].0, high: response[best.end - 1].0, why });
        }
    }
    let most = smooth.iter().copied().fold(0.0, f64::max);
    Err(format!(
        "the coherence of speed and torque is at most {}: nothing can be fitted",
        number((most * 100.0).round() / 100.0)
    ))
}

/// First order fitted to the logarithm of the gain, weighted by the coherence: J and B.
pub(crate) fn gain_fit(response: &[(f64, f64, f64)], band: &Band) -> (f64, f64) {
    let inside: Vec<(f64, f64, f64)> = response.iter().copied().filter(|p| band.holds(p.0)).collect();
    let tau = std::f64::consts::TAU;
    // Above the corner the gain is 1/(J ω): the median over the upper half starts it.
    let upper = &inside[inside.len() / 2..];
    let j = signals::median(upper.iter().map(|p| 1.0 / (p.1 * tau * p.0)).collect()).unwrap_or(1.0);
    let left = |_: usize, p: &[f64]| -> Vec<f64> {
        inside
            .iter()
            .map(|(f, gain, coherence)| {
                let weight = (coherence / (1.0 - coherence).max(1e-3)).sqrt();
                weight * (gain.ln() + (p[0] * tau * f).hypot(p[1]).ln())
            })
            .collect()
    };
    let low = tau * band.low;
    let unknowns = [
        Unknown { start: j, scale: j, lower: 1e-3 * j, upper: 1e3 * j },
        Unknown { start: j * low, scale: j * low, lower: 0.0, upper: f64::INFINITY },
    ];
    let fitted = minimise(1, &left, &unknowns, 50, 1e-10);
    (fitted.values[0], fitted.values[1])
}
