//! A motor bench in numbers, for the tests of `characterize`: it shares nothing with the library but the type of a
//! log. Random torque drives a first-order machine, discretised exactly at eight times the sampling rate; sensors
//! have noise, an encoder of finite resolution and a late channel.
#![allow(dead_code, reason = "each test file uses its part")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use gearwise::measured::bench::{BenchKind, Channel, KnownLoad, Log, Use};
pub use random::Random;

use crate::simulator::random;

/// A log of a kind with these channels.
pub fn log(kind: BenchKind, time: Vec<f64>, channels: Vec<(Channel, Vec<f64>)>) -> Log {
    Log {
        name: format!("{}.csv", kind.name()),
        file: "log.csv".into(),
        hash: "0".repeat(64),
        kind,
        usage: Use::Fit,
        load: KnownLoad::default(),
        controller: None,
        rotor: true,
        difference: None,
        gains: BTreeMap::new(),
        held: std::collections::BTreeSet::new(),
        from_motor: std::collections::BTreeSet::new(),
        band: None,
        estimated: std::collections::BTreeSet::new(),
        excluded: Vec::new(),
        fresh: BTreeMap::new(),
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
    /// Over how many fine steps the velocity is a difference of counts: [`QUARTER`] of a sample as a drive does it, a
    /// whole [`SAMPLE`] as a lab does it afterwards.
    pub span: usize,
    /// Whether the log says so.
    pub declared: bool,
    /// Coulomb friction \[N·m\].
    pub coulomb: f64,
    /// Whether the torque is white and held from sample to sample, where it else is smooth.
    pub held: bool,
}

/// A quarter of a sample in fine steps.
pub const QUARTER: usize = FINE / 4;
/// A sample in fine steps.
pub const SAMPLE: usize = FINE;

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
        if self.held {
            torque = (0..total.div_ceil(FINE)).flat_map(|_| [drive.normal(); FINE]).take(total).collect();
        }
        let rms = (torque.iter().map(|t| t * t).sum::<f64>() / total as f64).sqrt();
        torque.iter_mut().for_each(|t| *t *= TORQUE / rms);
        // Torque held over a fine step: the exact solution of J ω̇ + B ω = T, and of its integral.
        let decay = (-self.damping * h / self.inertia).exp();
        let (mut speed, mut angle) = (0.0_f64, 0.3);
        let mut angles = Vec::with_capacity(total);
        for t in &torque {
            angles.push(angle);
            let friction =
                if speed == 0.0 { t.clamp(-self.coulomb, self.coulomb) } else { self.coulomb * speed.signum() };
            let (steady, from) = ((t - friction) / self.damping, speed);
            speed = steady + (from - steady) * decay;
            angle += steady * h + (from - steady) * (1.0 - decay) * self.inertia / self.damping;
            if self.coulomb > 0.0 && from * speed < 0.0 {
                // It stops within the step; the rest of it friction is against the other direction, or holds it.
                let rest = h * speed / (speed - from);
                speed = (t - t.clamp(-self.coulomb, self.coulomb)) * rest / self.inertia;
            }
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
            let before = if self.held { fine } else { fine - 1 };
            measured.push(0.5 * (torque[before] + torque[fine]) + 0.02 + sensor * noise.normal());
            let at = fine as f64 - self.lag / h;
            let half = 0.5 * self.span as f64;
            velocity.push((quantised(at + half) - quantised(at - half)) / (2.0 * half * h));
            // The drive follows its command 2 ms later.
            command.push(3.0 * torque[fine + 18]);
        }
        let mut channels = vec![(Channel::Torque, measured), (Channel::OutputVelocity, velocity)];
        if self.command {
            channels.push((Channel::Command, command));
        }
        let log = log(BenchKind::RandomTorque, time, channels);
        Log { difference: self.declared.then_some(self.span as f64 * h), ..log }
    }
}

/// A drag test in steps of speed: noise on samples, a scatter from step to step, a zero of the sensor.
#[derive(Debug, Clone, Copy)]
pub struct DragTest {
    /// Coulomb friction \[N·m\].
    pub coulomb: f64,
    /// Viscous friction \[N·m·s/rad\].
    pub viscous: f64,
    /// Standard deviation of a step \[N·m\].
    pub scatter: f64,
    /// Whether it turns both ways; else it rests between.
    pub both: bool,
}

impl DragTest {
    /// Its log.
    pub fn log(&self, r: &mut Random) -> Log {
        let speeds: Vec<f64> =
            [20.0, 40.0, 70.0, 100.0, 130.0].into_iter().flat_map(|w| [w, if self.both { -w } else { 0.0 }]).collect();
        let zero = 0.02 * r.normal();
        let (mut time, mut speed, mut torque) = (Vec::new(), Vec::new(), Vec::new());
        for (step, w) in speeds.iter().enumerate() {
            let off = self.scatter * r.normal();
            for k in 0..120 {
                time.push((step * 120 + k) as f64 * 0.025);
                let now = w * (1.0 - (-(k as f64) / 5.0).exp());
                speed.push(now + 0.05 * r.normal());
                let drag = if *w == 0.0 { 0.0 } else { self.coulomb * w.signum() + self.viscous * now };
                torque.push(drag + zero + off + 0.002 * r.normal());
            }
        }
        log(BenchKind::Drag, time, vec![(Channel::MotorVelocity, speed), (Channel::Torque, torque)])
    }
}

/// A step of current into a motor of two nodes, with the sensors' noise and a slow wander of theirs.
#[derive(Debug, Clone, Copy)]
pub struct HeatTest {
    /// Winding to housing, housing to ambient \[K/W\].
    pub resistances: (f64, f64),
    /// Time constants of winding and housing, R_wh C_w and R_ha C_h \[s\].
    pub constants: (f64, f64),
    /// Resistance of the copper at 25 degC \[Ω\].
    pub copper: f64,
    /// Current \[A\].
    pub current: f64,
    /// How long the current flows, and the log lasts \[s\].
    pub duration: (f64, f64),
    /// Standard deviation of the wander \[K\].
    pub wander: f64,
}

/// Ambient of [`HeatTest`] \[K\].
pub const AMBIENT: f64 = 295.15;

impl HeatTest {
    /// Its log.
    pub fn log(&self, r: &mut Random) -> Log {
        let ((r_wh, r_ha), (t_w, t_h)) = (self.resistances, self.constants);
        let h = 0.01;
        let (mut winding, mut housing) = (AMBIENT, AMBIENT);
        let mut wander = [self.wander * r.normal(), self.wander * r.normal()];
        let (mut time, mut current, mut hot, mut warm) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for second in 0..self.duration.1 as usize {
            let i = if (second as f64) < self.duration.0 { self.current } else { 0.0 };
            if second % 2 == 0 {
                time.push(second as f64);
                current.push(i);
                hot.push(winding + wander[0] + 0.1 * r.normal());
                warm.push(housing + wander[1] + 0.1 * r.normal());
            }
            // A wander that forgets itself in ten seconds.
            let keeps = (-0.1_f64).exp();
            for w in &mut wander {
                *w = keeps * *w + self.wander * (1.0 - keeps * keeps).sqrt() * r.normal();
            }
            for _ in 0..(1.0 / h) as usize {
                let heat = self.copper * (1.0 + 0.003_854 * (winding - 298.15)) * i * i;
                let through = (winding - housing) / r_wh;
                winding += h * (heat - through) * r_wh / t_w;
                housing += h * (through - (housing - AMBIENT) / r_ha) * r_ha / t_h;
            }
        }
        log(
            BenchKind::ThermalStep,
            time,
            vec![(Channel::Current, current), (Channel::WindingTemperature, hot), (Channel::HousingTemperature, warm)],
        )
    }
}
