//! Signals that know which channels they are made of.
//!
//! The one idea: a value and its origin travel together, from the log to the column of the regression, so that
//! nobody has to remember which regressor contains the response. What is computed of two signals is made of the
//! channels of both.

use std::ops::BitOr;

use crate::Channel;

/// A set of channels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Channels(u32);

impl Channels {
    /// None: a number that is declared, not measured.
    pub const NONE: Channels = Channels(0);

    /// Whether a channel is in both.
    pub fn meets(self, other: Channels) -> bool {
        self.0 & other.0 != 0
    }
}

impl From<Channel> for Channels {
    fn from(channel: Channel) -> Channels {
        Channels(1 << channel as u32)
    }
}

impl BitOr for Channels {
    type Output = Channels;

    fn bitor(self, other: Channels) -> Channels {
        Channels(self.0 | other.0)
    }
}

/// Values over the samples of a stretch, and the channels that they are made of.
#[derive(Debug, Clone)]
pub(crate) struct Signal {
    /// One number a sample.
    pub values: Vec<f64>,
    /// Where they come from.
    pub made_of: Channels,
}

impl Signal {
    /// Of a channel.
    pub fn of(channel: Channel, values: Vec<f64>) -> Signal {
        Signal { values, made_of: channel.into() }
    }

    /// Of a channel that was made of others, too.
    pub fn made_of(mut self, others: Channels) -> Signal {
        self.made_of = self.made_of | others;
        self
    }

    /// Of nothing measured.
    pub fn constant(value: f64, count: usize) -> Signal {
        Signal { values: vec![value; count], made_of: Channels::NONE }
    }

    /// Each value changed.
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Signal {
        Signal { values: self.values.iter().map(|v| f(*v)).collect(), made_of: self.made_of }
    }

    /// All values changed together: a filter, a derivative.
    pub fn through(&self, f: impl FnOnce(&[f64]) -> Vec<f64>) -> Signal {
        Signal { values: f(&self.values), made_of: self.made_of }
    }

    /// Each value with that of another signal.
    pub fn with(&self, other: &Signal, f: impl Fn(f64, f64) -> f64) -> Signal {
        let values = self.values.iter().zip(&other.values).map(|(a, b)| f(*a, *b)).collect();
        Signal { values, made_of: self.made_of | other.made_of }
    }
}

/// Channels of the response of a stretch, and of each variable of its operating points.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Origins {
    /// What the equation explains, as it is measured.
    pub response: Channels,
    /// The load that is taken for known: its noise is in what the equation explains, too.
    pub load: Channels,
    /// Speed and direction.
    pub speed: Channels,
    /// Angle of the motor.
    pub angle: Channels,
    /// Angle of the output.
    pub output_angle: Channels,
    /// Current.
    pub current: Channels,
    /// Transmitted torque.
    pub torque: Channels,
    /// What a spring in the gear multiplies with 1/k.
    pub curvature: Channels,
    /// Winding temperature.
    pub winding: Channels,
    /// Housing temperature.
    pub housing: Channels,
    /// Duty cycle.
    pub duty: Channels,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_made_of_two_signals_is_made_of_the_channels_of_both() {
        let current = Signal::of(Channel::Current, vec![1.0, 2.0]);
        let speed = Signal::of(Channel::MotorVelocity, vec![3.0, 5.0]);
        let both = current.with(&speed.map(|w| 2.0 * w), |i, w| i + w);
        assert_eq!(both.values, [7.0, 12.0]);
        assert!(both.made_of.meets(Channel::Current.into()) && both.made_of.meets(Channel::MotorVelocity.into()));
        assert!(!both.made_of.meets(Channel::Torque.into()) && !both.made_of.meets(Channel::Duty.into()));
        let slope = both.through(|v| vec![v[1] - v[0]; 2]);
        assert_eq!((slope.values.as_slice(), slope.made_of), ([5.0, 5.0].as_slice(), both.made_of));
        let known = Signal::constant(4.0, 2).with(&current, |a, b| a * b);
        assert_eq!((known.values.as_slice(), known.made_of), ([4.0, 8.0].as_slice(), Channel::Current.into()));
        assert_eq!(Signal::constant(1.0, 3).made_of, Channels::NONE);
    }

    #[test]
    fn every_channel_is_another() {
        use Channel::*;
        let all = [
            Current,
            Voltage,
            MotorPosition,
            MotorVelocity,
            OutputPosition,
            OutputVelocity,
            OutputAcceleration,
            Torque,
            Duty,
            Supply,
            BusCurrent,
            Goal,
            Command,
            WindingTemperature,
            HousingTemperature,
            LoadTorque,
        ];
        for a in all {
            for b in all {
                assert_eq!(Channels::from(a).meets(b.into()), a == b, "{a:?} {b:?}");
            }
        }
    }
}
