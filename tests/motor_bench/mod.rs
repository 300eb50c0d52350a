//! A motor bench in numbers, for the tests of `characterize`: it shares nothing with the library but the type of a
//! log. Random torque drives a first-order machine, discretised exactly at eight times the sampling rate; sensors
//! have noise, an encoder of finite resolution and a late channel.
#![allow(dead_code, reason = "each test file uses its part")]

#[path = "../simulator/random.rs"]
mod random;

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use gearwise::measured::bench::{BenchKind, Channel, KnownLoad, Log, Use};
pub use random::Random;

/// A log of a kind with these channels.
pub fn log(kind: BenchKind, time: Vec<f64>, channels: Vec<(Channel, Vec<f64>)>) -> Log {
    Log {
        name: format!("{}.csv", kind.name()),
        hash: "0".repeat(64),
        kind,
        usage: Use::Fit,
        load: KnownLoad::default(),
        controller: None,
        rotor: true,
        time,
        channels: channels.into_iter().collect::<BTreeMap<_, _>>(),
        remarks: Vec::new(),
    }
}

/// A random-torque test.
#[derive(Debug, Clone, Copy)]
pub struct RandomTest {
    /// Inertia \[kg·m²\].
    pub inertia: f64,
    /// Damping \[N·m·s/rad\].
    pub damping: f64,
    /// Power of the torque over that of its sensor's noise.
    pub snr: f64,
    /// How late the velocity is \[s\].
    pub lag: f64,
    /// How long \[s\].
    pub duration: f64,
    /// Whether the log has the command.
    pub command: bool,
    /// Counts of the encoder in a turn.
    pub counts: f64,
}

/// Samples per second.
pub const RATE: f64 = 1100.0;
const FINE: usize = 8;
const TORQUE: f64 = 0.3;
const CUT_OFF: f64 = 40.0;

impl RandomTest {
    /// Its log.
    pub fn log(&self, seed: u64) -> Log {
        let h = 1.0 / (RATE * FINE as f64);
        let settle = 2.0;
        let late = (0.06 / h) as usize;
        let n = (self.duration * RATE) as usize;
        let first = (settle / h) as usize + late;
        let total = first + (n + 40) * FINE + late;
        let (mut drive, mut noise) = (Random::new(seed, "drive"), Random::new(seed, "noise"));
        // White noise through a Butterworth low-pass of second order (bilinear), scaled to TORQUE rms.
        let k = (std::f64::consts::PI * CUT_OFF * h).tan();
        let norm = 1.0 / (1.0 + 2.0_f64.sqrt() * k + k * k);
        let (b0, a1, a2) = (k * k * norm, 2.0 * (k * k - 1.0) * norm, (1.0 - 2.0_f64.sqrt() * k + k * k) * norm);
        let (mut s1, mut s2) = (0.0, 0.0);
        let mut torque: Vec<f64> = (0..total)
            .map(|_| {
                let x = drive.normal();
                let y = b0 * x + s1;
                s1 = 2.0 * b0 * x - a1 * y + s2;
                s2 = b0 * x - a2 * y;
                y
            })
            .collect();
        let rms = (torque.iter().map(|t| t * t).sum::<f64>() / total as f64).sqrt();
        torque.iter_mut().for_each(|t| *t *= TORQUE / rms);
        // Torque held over a fine step: the exact solution of J ω̇ + B ω = T, and of its integral.
        let decay = (-self.damping * h / self.inertia).exp();
        let (mut speed, mut angle) = (0.0, 0.3);
        let mut angles = Vec::with_capacity(total);
        for t in &torque {
            angles.push(angle);
            let (steady, from) = (t / self.damping, speed);
            speed = steady + (from - steady) * decay;
            angle += steady * h + (from - steady) * (1.0 - decay) * self.inertia / self.damping;
        }
        let sensor = TORQUE / self.snr.sqrt();
        let count = TAU / self.counts;
        let quantised = |at: f64| {
            let (low, share) = (at.floor() as usize, at - at.floor());
            ((angles[low] + share * (angles[low + 1] - angles[low])) / count).floor() * count
        };
        let (mut time, mut measured, mut velocity, mut command) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for s in 0..n {
            let fine = first + s * FINE;
            time.push(s as f64 / RATE);
            // Held over the step before and after: the torque at this instant is their mean.
            measured.push(0.5 * (torque[fine - 1] + torque[fine]) + 0.02 + sensor * noise.normal());
            // Central difference over a quarter of a sample, as a drive does it: over a whole one, speed at the top of the
            // band is 1 % low, and the inertia as much too high.
            let at = fine as f64 - self.lag / h;
            velocity.push((quantised(at + 1.0) - quantised(at - 1.0)) / (2.0 * h));
            // The drive follows its command 2 ms later.
            command.push(3.0 * torque[fine + 18]);
        }
        let mut channels = vec![(Channel::Torque, measured), (Channel::OutputVelocity, velocity)];
        if self.command {
            channels.push((Channel::Command, command));
        }
        log(BenchKind::RandomTorque, time, channels)
    }
}
