//! What the instruments make of a trace: late, quantised, filtered, noisy, with holes.

use super::random::Random;
use super::unfriendly::Unfriendly;
use super::world::Trace;
use std::f64::consts::TAU;

/// A channel of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    Position,
    Velocity,
    OutputPosition,
    OutputVelocity,
    Current,
    Torque,
    Voltage,
    WindingTemperature,
    HousingTemperature,
    Duty,
    Goal,
    Supply,
    Force,
    /// What the driving machine was told.
    Command,
}

/// How a log comes by its velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Velocity {
    /// Differences of the quantised position from row to row.
    Differences,
    /// The drive's estimate, late by so many seconds.
    Estimate { late: f64 },
}

/// The instruments of a bench.
#[derive(Debug, Clone)]
pub struct Sensors {
    pub velocity: Velocity,
    /// Counts per turn of the motor's encoder; of the output's.
    pub counts: f64,
    pub output_counts: f64,
    /// Corner of the torque sensor's two lags \[Hz\]; none at infinity.
    pub torque_corner: f64,
    /// How late a channel is \[s\].
    pub lags: Vec<(Channel, f64)>,
    /// Deviation of the target's zero from log to log, in rms of its noise.
    pub zeros: f64,
    /// The target's channel reads too high by this factor in one log.
    pub gain_error: Option<(usize, f64)>,
    /// This channel's sign is not what the bench file says.
    pub wrong_sign: Option<Channel>,
    /// This channel's sign is turned round, and the bench file says so.
    pub reversed: Option<Channel>,
    /// Share of the noise's power that is slow (correlated over 20 ms).
    pub colored: f64,
    /// Random part of the sampling period, of the period.
    pub jitter: f64,
    /// Gaps of 0.2 to 1 s in each log.
    pub gaps: usize,
    /// Probability that a cell is blank.
    pub dropouts: f64,
    /// Channels that the log doesn't have.
    pub hidden: Vec<Channel>,
    /// The log's current is the phase amplitude instead of the q-axis.
    pub phase_amplitude: bool,
    /// What a good lab's bench doesn't have.
    pub unfriendly: Unfriendly,
}

impl Sensors {
    /// How late a channel is \[s\], filters aside.
    pub fn lag(&self, channel: Channel) -> f64 {
        let estimate = match (channel, self.velocity) {
            (Channel::Velocity | Channel::OutputVelocity, Velocity::Estimate { late }) => late,
            _ => 0.0,
        };
        estimate + self.lags.iter().filter(|(c, _)| *c == channel).map(|(_, lag)| lag).sum::<f64>()
    }
}

/// The value of a finely sampled channel at a time, linear between samples and held at the ends.
pub fn at(values: &[f64], step: f64, time: f64) -> f64 {
    let place = (time / step).clamp(0.0, (values.len() - 1) as f64);
    let low = place.floor() as usize;
    let high = (low + 1).min(values.len() - 1);
    values[low] + (place - low as f64) * (values[high] - values[low])
}

/// Two equal lags in series.
pub fn low_pass(values: &[f64], step: f64, corner: f64) -> Vec<f64> {
    if !corner.is_finite() {
        return values.to_vec();
    }
    let keep = (-TAU * corner * step).exp();
    let (mut a, mut b) = (values[0], values[0]);
    values
        .iter()
        .map(|v| {
            a = v + (a - v) * keep;
            b = a + (b - a) * keep;
            b
        })
        .collect()
}

/// When the rows of a log were taken \[s\].
pub fn times(rate: f64, duration: f64, sensors: &Sensors, random: &mut Random) -> Vec<f64> {
    let count = (rate * duration).round() as usize;
    let mut times: Vec<f64> =
        (0..count).map(|k| (k as f64 + sensors.jitter * random.within(0.0, 1.0)) / rate).collect();
    for _ in 0..sensors.gaps {
        let length = random.within(0.2, 1.0);
        let start = random.within(0.05 * duration, 0.95 * duration - length);
        times.retain(|t| !(start..start + length).contains(t));
    }
    times
}

/// Noise of deviation 1, a share of its power slow.
pub fn noise(times: &[f64], colored: f64, random: &mut Random) -> Vec<f64> {
    let mut slow = random.normal();
    let mut last = times.first().copied().unwrap_or(0.0);
    times
        .iter()
        .map(|&t| {
            let keep = (-(t - last) / 0.02).exp();
            slow = keep * slow + (1.0 - keep * keep).sqrt() * random.normal();
            last = t;
            colored.sqrt() * slow + (1.0 - colored).sqrt() * random.normal()
        })
        .collect()
}

fn quantised(angle: f64, counts: f64) -> f64 {
    let quantum = TAU / counts;
    (angle / quantum).round() * quantum
}

/// A channel as its instrument reads it, without the target's noise and zero.
pub fn read(channel: Channel, trace: &Trace, times: &[f64], sensors: &Sensors, random: &mut Random) -> Vec<f64> {
    let lag = sensors.lag(channel);
    let plain = |values: &[f64]| times.iter().map(|t| at(values, trace.step, t - lag)).collect::<Vec<f64>>();
    let position = |values: &[f64], counts: f64| {
        times.iter().map(|t| quantised(at(values, trace.step, t - lag), counts)).collect::<Vec<f64>>()
    };
    let mut velocity = |angles: &[f64], speeds: &[f64], counts: f64| match sensors.velocity {
        Velocity::Differences => {
            let angles = position(angles, counts);
            let mut speeds: Vec<f64> =
                (1..angles.len()).map(|k| (angles[k] - angles[k - 1]) / (times[k] - times[k - 1])).collect();
            speeds.insert(0, speeds[0]);
            speeds
        }
        Velocity::Estimate { .. } => {
            // A tracking loop of some 10 Hz lets through this much of the encoder's quantum per second.
            let ripple = 40.0 * TAU / counts;
            plain(speeds).into_iter().map(|v| v + ripple * random.normal()).collect()
        }
    };
    match channel {
        Channel::Position => position(&trace.motor_angle, sensors.counts),
        Channel::Velocity => velocity(&trace.motor_angle, &trace.motor_speed, sensors.counts),
        Channel::OutputPosition => position(&trace.output_angle, sensors.output_counts),
        Channel::OutputVelocity => velocity(&trace.output_angle, &trace.output_speed, sensors.output_counts),
        Channel::Current => {
            let scale = if sensors.phase_amplitude { (2.0_f64 / 3.0).sqrt() } else { 1.0 };
            plain(&trace.current).into_iter().map(|i| i * scale).collect()
        }
        Channel::Force => plain(&trace.current),
        Channel::Torque => plain(&low_pass(&trace.torque, trace.step, sensors.torque_corner)),
        Channel::Voltage => plain(&trace.voltage),
        Channel::WindingTemperature => temperature(plain(&trace.winding), random),
        Channel::HousingTemperature => temperature(plain(&trace.housing), random),
        Channel::Duty => plain(&trace.duty),
        Channel::Goal => plain(&trace.goal),
        Channel::Supply => plain(&trace.supply),
        Channel::Command => plain(&trace.command),
    }
}

fn temperature(values: Vec<f64>, random: &mut Random) -> Vec<f64> {
    values.into_iter().map(|t| ((t + 0.1 * random.normal()) * 20.0).round() / 20.0).collect()
}
