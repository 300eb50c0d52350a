//! What a good lab's bench does not have: noise with a colour, filters before the sampling, values that are held, stale or
//! wrong.
//!
//! Everything is off by default and draws from streams of its own, so a bench without it keeps its bytes.

use super::random::Random;
use super::sense::{Channel, low_pass};

/// A colour of noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    /// Share of the noise's power that has it.
    pub share: f64,
    /// Time over which it is correlated \[s\].
    pub time: f64,
    /// Blue instead: differences from row to row, whatever the time.
    pub blue: bool,
}

/// A stretch in which a channel does not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stale {
    pub channel: Channel,
    /// In which log.
    pub log: usize,
    /// Where it begins, as a share of the log, and how long it is \[s\].
    pub from: f64,
    pub length: f64,
}

/// Everything that may be wrong with a bench.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Unfriendly {
    /// Colour of the noise on the target, in place of the slow share.
    pub colour: Option<Colour>,
    /// Corner of a filter on the target before it is sampled, its noise too \[Hz\].
    pub anti_alias: Option<f64>,
    /// Quantum of the target's channel, in rms of its noise.
    pub quantum: Option<f64>,
    /// All measured channels repeat so many rows; what commands is fresh.
    pub held_log: Option<usize>,
    /// One channel repeats so many rows.
    pub held_channel: Option<(Channel, usize)>,
    /// One stretch of one channel does not change.
    pub stale: Option<Stale>,
    /// The velocity is in another unit: this many times the true one.
    pub velocity_scale: Option<f64>,
    /// The current is in another convention: this many times the one that the bench file says.
    pub ampere: Option<f64>,
}

impl Unfriendly {
    /// Noise of deviation 1 at the rows; `None` where nothing is unfriendly about it.
    pub fn noise(&self, times: &[f64], step: f64, plain: f64, random: &mut Random) -> Option<Vec<f64>> {
        if self.colour.is_none() && self.anti_alias.is_none() {
            return None;
        }
        let colour = self.colour.unwrap_or(Colour { share: plain, time: 0.02, blue: false });
        let white = self.component(times, step, None, random);
        let tinted = self.component(times, step, Some(colour), random);
        let (a, b) = ((1.0 - colour.share).sqrt(), colour.share.sqrt());
        Some(white.iter().zip(&tinted).map(|(w, t)| a * w + b * t).collect())
    }

    /// One part of the noise, drawn finely where a filter comes before the sampling.
    fn component(&self, times: &[f64], step: f64, colour: Option<Colour>, random: &mut Random) -> Vec<f64> {
        let grid: Vec<f64> = match self.anti_alias {
            Some(_) => {
                let last = times.last().copied().unwrap_or(0.0);
                (0..=(last / step).ceil() as usize).map(|k| k as f64 * step).collect()
            }
            None => times.to_vec(),
        };
        let mut last = (grid.first().copied().unwrap_or(0.0), random.normal());
        let raw: Vec<f64> = grid
            .iter()
            .map(|&t| {
                let fresh = random.normal();
                let value = match colour {
                    None => fresh,
                    Some(Colour { blue: true, .. }) => fresh - last.1,
                    Some(Colour { time, .. }) => {
                        let keep = (-(t - last.0) / time).exp();
                        keep * last.1 + (1.0 - keep * keep).sqrt() * fresh
                    }
                };
                last = (t, if colour.is_some_and(|c| !c.blue) { value } else { fresh });
                value
            })
            .collect();
        let rows = match self.anti_alias {
            Some(corner) => {
                let filtered = low_pass(&raw, step, corner);
                times.iter().map(|t| filtered[((t / step).round() as usize).min(filtered.len() - 1)]).collect()
            }
            None => raw,
        };
        let size = (rows.iter().map(|v| v * v).sum::<f64>() / rows.len() as f64).sqrt();
        rows.into_iter().map(|v| v / size).collect()
    }

    /// What becomes of a channel's column after its instrument.
    pub fn spoil(&self, channel: Channel, log: usize, times: &[f64], values: &mut [f64]) {
        if let (Some(scale), Channel::Velocity | Channel::OutputVelocity) = (self.velocity_scale, channel) {
            values.iter_mut().for_each(|v| *v *= scale);
        }
        if let (Some(scale), Channel::Current) = (self.ampere, channel) {
            values.iter_mut().for_each(|v| *v *= scale);
        }
        self.freeze(channel, log, times, values);
        hold(values, self.rows_held(channel));
    }

    /// A stale stretch.
    fn freeze(&self, channel: Channel, log: usize, times: &[f64], values: &mut [f64]) {
        let Some(stale) = self.stale.filter(|s| s.channel == channel && s.log == log) else { return };
        let start = stale.from * times[times.len() - 1];
        let Some(first) = times.iter().position(|t| *t >= start) else { return };
        let kept = values[first];
        for (value, _) in values.iter_mut().zip(times).skip(first).take_while(|(_, t)| **t < start + stale.length) {
            *value = kept;
        }
    }

    /// How many rows a channel repeats.
    pub fn rows_held(&self, channel: Channel) -> usize {
        let commands = matches!(channel, Channel::Goal | Channel::Duty | Channel::Command);
        let own = self.held_channel.filter(|(c, _)| *c == channel).map(|(_, rows)| rows);
        own.or(self.held_log.filter(|_| !commands)).unwrap_or(1)
    }
}

/// Rounds to a quantum.
pub fn quantise(values: &mut [f64], quantum: f64) {
    values.iter_mut().for_each(|v| *v = (*v / quantum).round() * quantum);
}

/// Repeats every so many rows.
pub fn hold(values: &mut [f64], rows: usize) {
    for k in 0..values.len() {
        values[k] = values[k - k % rows.max(1)];
    }
}
