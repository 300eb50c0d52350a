//! The channels of a stretch of a log on an even grid.

use std::ops::Range;

use crate::identify::origin::Signal;
use crate::{Channel, Log, signals};

/// The channels of one stretch on its grid.
pub(super) struct Gridded<'a> {
    pub log: &'a Log,
    pub range: Range<usize>,
    pub start: f64,
    pub step: f64,
    pub count: usize,
    pub linear: bool,
    pub signs: Signs,
}

/// Signs of the channels of a log: −1 where they are counted the other way round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signs {
    /// Sign of the current.
    pub current: f64,
    /// Sign of all positions, velocities and accelerations.
    pub motion: f64,
}

impl Signs {
    /// Signs as declared.
    pub const DECLARED: Signs = Signs { current: 1.0, motion: 1.0 };

    fn of(self, channel: Channel) -> f64 {
        match channel {
            Channel::Current => self.current,
            Channel::MotorPosition
            | Channel::OutputPosition
            | Channel::MotorVelocity
            | Channel::OutputVelocity
            | Channel::OutputAcceleration => self.motion,
            _ => 1.0,
        }
    }
}

impl Gridded<'_> {
    /// A channel on the grid; `None` where the log does not have it.
    pub fn get(&self, channel: Channel) -> Option<Signal> {
        let values = self.log.channel(channel)?;
        let wraps = matches!(channel, Channel::MotorPosition | Channel::OutputPosition | Channel::Goal) && !self.linear;
        let opened;
        let values = if wraps {
            opened = signals::unwrapped(values);
            &opened
        } else {
            values
        };
        let values = &values[self.range.clone()];
        let on_grid = match self.step == 0.0 {
            true => values.to_vec(),
            false => signals::on_grid(&self.log.time[self.range.clone()], values, self.start, self.step, self.count)?,
        };
        let signal = Signal::of(channel, on_grid);
        Some(if self.signs.of(channel) < 0.0 { signal.map(|v| -v) } else { signal })
    }

    /// Which points lie in a stretch that is left out.
    pub fn excluded(&self) -> Vec<bool> {
        let time = |k: usize| match self.step > 0.0 {
            true => self.start + k as f64 * self.step,
            false => self.log.time[self.range.start + k],
        };
        // The first point that is not before a time.
        let first = |t: f64| {
            let (mut low, mut high) = (0, self.count);
            while low < high {
                let middle = (low + high) / 2;
                if time(middle) < t { low = middle + 1 } else { high = middle }
            }
            low
        };
        let mut out = vec![false; self.count];
        for stretch in &self.log.excluded {
            let (from, to) = (first(stretch.start), first(stretch.end));
            out[from..to.max(from)].fill(true);
        }
        out
    }

    /// A channel put right by its lag \[s\].
    pub fn shifted(&self, channel: Channel, lag: f64) -> Option<Signal> {
        self.get(channel).map(|signal| self.late(&signal, lag))
    }

    /// A signal put right by its lag \[s\].
    pub fn late(&self, signal: &Signal, lag: f64) -> Signal {
        if self.step > 0.0 { signal.through(|v| signals::shifted(v, lag / self.step)) } else { signal.clone() }
    }

    /// The derivative; zero where there is no time axis.
    pub fn derivative(&self, signal: &Signal) -> Signal {
        if self.step > 0.0 { signal.through(|v| signals::derivative(v, self.step)) } else { signal.map(|_| 0.0) }
    }

    /// The second derivative; zero where there is no time axis.
    pub fn second_derivative(&self, signal: &Signal) -> Signal {
        signal.through(|v| second_derivative(v, self.step))
    }
}

fn second_derivative(values: &[f64], step: f64) -> Vec<f64> {
    let n = values.len();
    if step <= 0.0 || n < 3 {
        return vec![0.0; n];
    }
    (0..n)
        .map(|k| {
            let k = k.clamp(1, n - 2);
            (values[k - 1] - 2.0 * values[k] + values[k + 1]) / (step * step)
        })
        .collect()
}
