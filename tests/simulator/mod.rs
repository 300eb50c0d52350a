//! The test suite's own bench: it writes bench folders whose truth is known.
//!
//! It shares no line with the library, so it can judge it. [`Bench`] is described, then written:
//! a bench file, a catalogue and logs, from a machine simulated in its physical form ([`world`])
//! and read by imperfect instruments ([`sense`]). The size of an effect is its rms contribution
//! to the target of the bench (torque, current times N K_T, voltage, force, position of a servo) over
//! the noise on that target. Where an effect that large would be no real machine's, the noise is
//! made smaller instead.
#![allow(dead_code, unused_imports, reason = "each test file uses its part")]

pub mod arm;
pub mod driven;
mod kind;
mod played;
pub mod profile;
pub mod random;
mod scenarios;
pub mod sense;
pub mod unfriendly;
pub mod world;
mod write;

pub use kind::Kind;
pub use played::Played;
use profile::{Profile, Shape};
use random::Random;
pub use scenarios::{clean, outside, pair, scenario, shuffled};
pub use sense::{Channel, Sensors, Velocity};
use std::path::{Path, PathBuf};
pub use unfriendly::{Colour, Stale, Unfriendly};
pub use world::{Drive, Effect, Machine, Nature, Servo, Trace};

/// How strong an effect is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Size {
    /// Its rms contribution over the noise's rms.
    Noise(f64),
    /// Its amplitude in SI (see [`Nature`]).
    Value(f64),
}

/// What the catalogue row says, relative to the truth.
#[derive(Debug, Clone, Copy)]
pub struct Declared {
    pub torque_constant: f64,
    pub inertia: f64,
    pub resistance: f64,
    /// Factors on b and c; `None` leaves the cell blank.
    pub viscous: Option<f64>,
    pub coulomb: Option<f64>,
    /// Whether the row says the largest speed.
    pub max_speed: bool,
}

/// How the bench is driven.
#[derive(Debug, Clone)]
pub struct Excitation {
    /// Largest speed relative to the machine's.
    pub speed: f64,
    /// Share of the time in slow motion, and how slow relative to the largest speed.
    pub slow: f64,
    pub slow_level: f64,
    /// Corner of the speed's lags \[Hz\]: how hard it accelerates.
    pub corner: f64,
    /// One speed, one direction, one current.
    pub poor: bool,
    /// One current, whatever the speed does.
    pub steady_current: bool,
    /// One speed in both directions.
    pub steady_speed: bool,
}

/// A bench to be written.
#[derive(Debug, Clone)]
pub struct Bench {
    pub kind: Kind,
    pub seed: u64,
    /// Number of logs; the last one is held out where there are several.
    pub logs: usize,
    /// Length of a log \[s\], and its rows per second.
    pub duration: f64,
    pub rate: f64,
    pub machine: Machine,
    pub effects: Vec<(Effect, Size)>,
    pub declared: Declared,
    pub sensors: Sensors,
    pub excitation: Excitation,
    /// Noise on the target relative to the target's rms.
    pub noise: f64,
    pub servo: Servo,
    /// All logs in one file, told apart by a column.
    pub one_file: bool,
    /// What is played in a log of its own.
    pub played: Option<Played>,
    /// Instead of the effects themselves the logs carry them in pieces in random order.
    pub shuffled: bool,
}

/// An effect that was put in.
#[derive(Debug, Clone)]
pub struct EffectTruth {
    pub effect: Effect,
    pub name: &'static str,
    /// SI, motor side unless the name of the effect says otherwise.
    pub parameters: Vec<(&'static str, f64)>,
    /// Its contribution alone to the target, rms over all logs.
    pub rms: f64,
}

impl EffectTruth {
    /// A parameter by its name.
    pub fn parameter(&self, name: &str) -> f64 {
        self.parameters.iter().find(|(n, _)| *n == name).unwrap_or_else(|| panic!("{}: no {name}", self.name)).1
    }
}

/// One log as it was written.
#[derive(Debug, Clone)]
pub struct LogTruth {
    pub file: PathBuf,
    pub held_out: bool,
    /// Times of the rows \[s\].
    pub times: Vec<f64>,
    /// The noise that was added to the target's channel, in the target's unit.
    pub noise: Vec<f64>,
    /// What all effects together contribute to the target at each row.
    pub contribution: Vec<f64>,
    /// What each effect alone contributes, in their order.
    pub apart: Vec<Vec<f64>>,
    /// What quantising the target's channel added, in the target's unit.
    pub rounding: Vec<f64>,
    /// Constant added to the target's channel, in the target's unit.
    pub zero: f64,
    /// The noise-free world; empty for a steady table.
    pub trace: Trace,
}

/// What there is to find.
#[derive(Debug, Clone)]
pub struct Truth {
    pub kind: Kind,
    pub seed: u64,
    /// The bench file.
    pub bench: PathBuf,
    pub effects: Vec<EffectTruth>,
    /// Rms of the noise on the target, in its unit.
    pub noise_rms: f64,
    pub unit: &'static str,
    pub motor: String,
    /// The true machine, and everything that acts.
    pub machine: Machine,
    pub nature: Nature,
    pub declared: Declared,
    pub sensors: Sensors,
    pub logs: Vec<LogTruth>,
}

impl Truth {
    /// Names of the effects.
    pub fn names(&self) -> Vec<&'static str> {
        self.effects.iter().map(|e| e.name).collect()
    }
}

impl Bench {
    /// A good lab's bench of a kind, with nothing undeclared.
    pub fn new(kind: Kind, seed: u64) -> Self {
        let mut random = Random::new(seed, "bench");
        let machine = match kind {
            Kind::Servo => Machine::servo(&mut random),
            Kind::Linear => Machine::axis(&mut random),
            _ => Machine::actuator(&mut random),
        };
        let table = kind == Kind::SteadyTable;
        // A steady table is a point a second; nothing there is late.
        let late = if table { 0.0 } else { random.within(0.0, 0.003) };
        Bench {
            kind,
            seed,
            logs: 3,
            duration: match kind {
                Kind::Stall => 40.0,
                Kind::SteadyTable => 180.0,
                _ => 30.0,
            },
            rate: match kind {
                Kind::Servo => 200.0,
                Kind::SteadyTable => 1.0,
                _ => 500.0,
            },
            machine,
            effects: Vec::new(),
            declared: Declared {
                torque_constant: 1.0,
                inertia: 1.0,
                resistance: 1.0,
                viscous: Some(1.0),
                coulomb: Some(1.0),
                max_speed: false,
            },
            sensors: Sensors {
                velocity: Velocity::Estimate { late },
                // A linear axis reads micrometres.
                counts: if kind == Kind::Linear { std::f64::consts::TAU / 1e-6 } else { 16384.0 },
                output_counts: if kind == Kind::Servo { 4096.0 } else { 262_144.0 },
                torque_corner: if table { f64::INFINITY } else { random.within(150.0, 300.0) },
                lags: Vec::new(),
                zeros: if kind.has_zero() { 3.0 } else { 0.0 },
                gain_error: None,
                wrong_sign: None,
                reversed: None,
                colored: if table { 0.0 } else { 0.2 },
                jitter: 0.0,
                gaps: 0,
                dropouts: 0.0,
                hidden: vec![Channel::OutputPosition, Channel::OutputVelocity],
                phase_amplitude: false,
                unfriendly: Unfriendly::default(),
            },
            excitation: Excitation {
                speed: 1.0,
                slow: 0.3,
                slow_level: 0.05,
                corner: 8.0,
                poor: false,
                steady_current: false,
                steady_speed: false,
            },
            noise: 0.01,
            servo: Servo {
                gain: random.within(2.0, 5.0),
                mass: random.within(0.2, 0.4),
                length: random.within(0.09, 0.12),
            },
            one_file: false,
            played: None,
            shuffled: false,
        }
    }

    /// Torque sensor at the output, speed imposed, current commanded.
    pub fn dynamometer(seed: u64) -> Self {
        Bench::new(Kind::Dynamometer, seed)
    }

    /// A known inertia, no torque sensor.
    pub fn free(seed: u64) -> Self {
        Bench::new(Kind::Free, seed)
    }

    /// Voltage, current and speed.
    pub fn electrical(seed: u64) -> Self {
        Bench::new(Kind::Electrical, seed)
    }

    /// A servo with a pendulum: position, duty, goal.
    pub fn servo(seed: u64) -> Self {
        Bench::new(Kind::Servo, seed)
    }

    /// Another effect.
    pub fn with(mut self, effect: Effect, size: Size) -> Self {
        self.effects.push((effect, size));
        self
    }

    /// Another effect, sized in noise.
    pub fn with_noise(self, effect: Effect, size: f64) -> Self {
        self.with(effect, Size::Noise(size))
    }

    /// Changes what the catalogue row says.
    pub fn declared(mut self, change: impl FnOnce(&mut Declared)) -> Self {
        change(&mut self.declared);
        self
    }

    /// Changes the instruments.
    pub fn sensors(mut self, change: impl FnOnce(&mut Sensors)) -> Self {
        change(&mut self.sensors);
        self
    }

    /// Changes how it is driven.
    pub fn excitation(mut self, change: impl FnOnce(&mut Excitation)) -> Self {
        change(&mut self.excitation);
        self
    }

    /// So many logs.
    pub fn logs(mut self, logs: usize) -> Self {
        self.logs = logs;
        self
    }

    /// Length of a log \[s\] and its rows per second.
    pub fn sampled(mut self, duration: f64, rate: f64) -> Self {
        (self.duration, self.rate) = (duration, rate);
        self
    }

    /// One speed, one direction, one current.
    pub fn poor(mut self) -> Self {
        self.excitation.poor = true;
        self
    }

    /// The list of effects alone.
    fn list(&self) -> Vec<Effect> {
        self.effects.iter().map(|(effect, _)| *effect).collect()
    }

    /// Internal step \[s\]: a whole part of the sampling period.
    fn step(&self) -> f64 {
        if self.kind == Kind::SteadyTable {
            return 1.0 / self.rate;
        }
        let wanted = match self.list() {
            // Flanks ring at 180 Hz, a compliant gear at 40 Hz.
            list if list.contains(&Effect::Backlash) || self.kind == Kind::Servo => 8000.0,
            list if list.contains(&Effect::GearCompliance) => 4000.0,
            _ => 2000.0,
        };
        1.0 / (self.rate * (wanted / self.rate).ceil().max(2.0))
    }

    /// What the bench imposes in one log: the same whatever acts.
    fn drive(&self, log: usize) -> Drive {
        let m = &self.machine;
        let step = self.step();
        let mut random = Random::new(self.seed, &format!("log {log}"));
        let imposes_output = !matches!(self.kind, Kind::Free | Kind::Linear);
        let speed = m.peak_speed * self.excitation.speed / if imposes_output { m.ratio } else { 1.0 };
        let shape = Shape {
            peak: speed,
            slow: self.excitation.slow,
            slow_level: self.excitation.slow_level,
            hold: if imposes_output { (0.4, 1.6) } else { (0.2, 0.9) },
            band: (0.2, 6.0),
            sines: 0.15,
            corner: self.excitation.corner,
        };
        let load = Shape {
            peak: 0.8 * m.peak_current,
            slow: 0.2,
            slow_level: 0.05,
            hold: (0.25, 1.2),
            band: (0.3, 15.0),
            sines: 0.15,
            corner: 40.0,
        };
        if let Some(played) = self.played.as_ref().filter(|_| log == PLAYED) {
            let profile = |values: &[f64]| played.profile(values, step);
            let (motion, current) = (profile(&played.motion), profile(&played.current));
            let (winding, housing) = (world::REFERENCE, world::REFERENCE);
            return Drive { step, duration: self.duration, motion, current, winding, housing, seed: self.seed ^ 0x7a };
        }
        let steps = |speed: f64, random: &mut Random| {
            let holds = (0..(self.duration / 0.8) as usize).map(|k| 0.3 + 0.8 * k as f64).collect::<Vec<f64>>();
            let level = |k: usize| if k.is_multiple_of(2) { 0.5 * speed } else { -0.5 * speed };
            let start = random.within(0.0, 0.2);
            let segment = |(k, at): (usize, &f64)| profile::Segment { start: at - start, level: level(k), sines: 0.0 };
            Profile::new(step, self.excitation.corner, holds.iter().enumerate().map(segment).collect(), &[])
        };
        let (motion, current) = match self.kind {
            Kind::Dynamometer | Kind::Free | Kind::Drag if self.excitation.steady_speed => {
                let current = match self.kind {
                    Kind::Dynamometer if self.excitation.steady_current => {
                        Profile::constant(step, 0.4 * m.peak_current)
                    }
                    Kind::Drag => Profile::constant(step, 0.0),
                    _ => Profile::random(step, self.duration, &load, &mut random),
                };
                (steps(speed, &mut random), current)
            }
            Kind::Servo if self.excitation.poor => (Profile::constant(step, 0.5), Profile::constant(step, 0.0)),
            Kind::Drag if self.excitation.poor => (Profile::constant(step, 0.4 * speed), Profile::constant(step, 0.0)),
            _ if self.excitation.poor => {
                (Profile::constant(step, 0.4 * speed), Profile::constant(step, 0.4 * m.peak_current))
            }
            Kind::Dynamometer | Kind::Electrical if self.excitation.steady_current => (
                Profile::random(step, self.duration, &shape, &mut random),
                Profile::constant(step, 0.4 * m.peak_current),
            ),
            Kind::Stall => (Profile::constant(step, 0.0), staircase(step, self.duration, m.peak_current, &mut random)),
            Kind::Backdrive => (staircase(step, self.duration, speed, &mut random), Profile::constant(step, 0.0)),
            Kind::Drag => (Profile::random(step, self.duration, &shape, &mut random), Profile::constant(step, 0.0)),
            Kind::RandomTorque => {
                let push = Shape { peak: driven::Machine::of(m).torque_for(speed), corner: 40.0, ..shape };
                (Profile::constant(step, 0.0), Profile::random(step, self.duration, &push, &mut random))
            }
            Kind::Servo => {
                let goal = Shape {
                    peak: 1.4,
                    slow: 0.3,
                    slow_level: 0.3,
                    hold: (0.5, 2.0),
                    band: (0.1, 2.0),
                    sines: 0.2,
                    corner: 3.0,
                };
                (Profile::random(step, self.duration, &goal, &mut random), Profile::constant(step, 0.0))
            }
            _ => (
                Profile::random(step, self.duration, &shape, &mut random),
                Profile::random(step, self.duration, &load, &mut random),
            ),
        };
        // Cold, warm, hot: a lab that wants to see temperature does not always start cold.
        let warm = (log % 3) as f64;
        let rise = m.resistance * (0.45 * m.peak_current).powi(2);
        let housing = world::REFERENCE + 0.35 * warm * rise * m.thermal_resistance[1] * random.within(0.8, 1.2);
        let winding = housing + 0.3 * warm * rise * m.thermal_resistance[0] * random.within(0.8, 1.2);
        let seed = self.seed.wrapping_mul(1000).wrapping_add(log as u64);
        Drive { step, duration: self.duration, motion, current, winding, housing, seed }
    }

    /// A log's noise-free world with what acts in it.
    pub fn simulate(&self, nature: &Nature, log: usize) -> Trace {
        let drive = self.drive(log);
        match self.kind {
            Kind::Free | Kind::Linear => world::free(nature, drive),
            Kind::Servo => world::servo(nature, self.servo, drive),
            Kind::SteadyTable => world::steady_table(nature, &drive),
            Kind::RandomTorque => driven::random_torque(nature, drive),
            _ => world::dynamometer(nature, drive),
        }
    }

    /// What is left of the target when the declared machine (without friction) is taken off, at one
    /// sample of a trace: differences of it are contributions.
    pub fn balance(&self, trace: &Trace, k: usize) -> f64 {
        let m = &self.machine;
        let n = m.ratio;
        let inertia = (m.inertia + m.gear_inertia) * n;
        match self.kind {
            Kind::Free | Kind::Linear => {
                let acceleration = trace.motor_acceleration[k];
                n * m.torque_constant * trace.current[k] - (inertia + m.load_inertia / n) * acceleration
            }
            Kind::Electrical | Kind::Backdrive => {
                trace.voltage[k]
                    - m.resistance * trace.current[k]
                    - m.inductance * trace.current_rate[k]
                    - m.torque_constant * trace.motor_speed[k]
            }
            Kind::Servo => trace.output_angle[k],
            _ => n * m.torque_constant * trace.current[k] - trace.torque[k] - inertia * trace.motor_acceleration[k],
        }
    }

    /// The target's own signal, for the noise that is natural to it.
    fn signal(&self, trace: &Trace, k: usize) -> f64 {
        match self.kind {
            Kind::Free | Kind::Linear => self.machine.ratio * self.machine.torque_constant * trace.current[k],
            Kind::Electrical | Kind::Backdrive => trace.voltage[k],
            Kind::Servo => trace.output_angle[k],
            _ => trace.torque[k],
        }
    }

    /// Samples of a trace that the size of an effect is judged at: all that could be a row.
    fn rows(&self, trace: &Trace) -> impl Iterator<Item = usize> + use<> {
        let stride = (1.0 / (self.rate * trace.step)).round() as usize;
        (0..trace.motor_angle.len()).step_by(stride.max(1))
    }

    /// Rms contribution of one effect alone.
    fn contribution(&self, base: &Nature, bases: &[Trace], effect: Effect, amplitude: f64) -> f64 {
        let mut nature = base.clone();
        nature.set(effect, amplitude);
        let (mut sum, mut count) = (0.0, 0.0);
        for (log, plain) in bases.iter().enumerate() {
            let trace = self.simulate(&nature, log);
            let mut change: Vec<f64> =
                self.rows(&trace).map(|k| self.balance(&trace, k) - self.balance(plain, k)).collect();
            if effect == Effect::DirectionAsymmetry {
                // The constant half of it cannot be told from a zero, so it does not count.
                let mean = change.iter().sum::<f64>() / change.len() as f64;
                change.iter_mut().for_each(|c| *c -= mean);
            }
            sum += change.iter().map(|c| c * c).sum::<f64>();
            count += change.len() as f64;
        }
        (sum / count).sqrt()
    }

    /// Sizes every effect; gives nature, noise and each effect's rms.
    fn settle(&self) -> (Nature, f64, Vec<f64>, Vec<Trace>) {
        let effects = self.list();
        let base = Nature::new(self.machine.clone(), &effects, &mut Random::new(self.seed, "nature"));
        let bases: Vec<Trace> = (0..self.logs).map(|log| self.simulate(&base, log)).collect();
        let (mut sum, mut count) = (0.0, 0.0);
        for trace in &bases {
            for k in self.rows(trace) {
                sum += self.signal(trace, k).powi(2);
                count += 1.0;
            }
        }
        // At one speed and with a zero of its own a sensor shows nothing of what is constant there, but for rounding.
        let nothing = 1e-6 * (sum / count).sqrt();
        let mut noise = if self.kind == Kind::Servo { 6e-4 } else { self.noise * (sum / count).sqrt() };
        // First what nature fixes: there the noise follows.
        let mut largest = vec![(0.0, 0.0); effects.len()];
        for pass in [true, false] {
            for (k, (effect, size)) in self.effects.iter().enumerate() {
                let Size::Noise(size) = *size else { continue };
                let fixed = match effect {
                    Effect::WindingTemperature => Some(world::COPPER),
                    Effect::TorqueConstantTemperature => Some(Random::new(self.seed, "magnet").within(0.0006, 0.0018)),
                    _ => None,
                };
                if fixed.is_some() != pass {
                    continue;
                }
                let least = base.smallest(*effect);
                if least > 0.0 {
                    let rms = self.contribution(&base, &bases, *effect, least);
                    if rms >= noise * size {
                        noise = rms / size;
                        largest[k] = (least, rms);
                        continue;
                    }
                }
                let most = fixed.unwrap_or(base.largest(*effect));
                let amplitude = if most.is_finite() { most } else { noise };
                let rms = self.contribution(&base, &bases, *effect, amplitude);
                assert!(rms.is_finite(), "{} on a {} bench", effect.name(), self.kind.name());
                largest[k] = (amplitude, if rms > nothing { rms } else { 0.0 });
                if rms <= nothing {
                    continue;
                }
                if fixed.is_some() {
                    noise = rms / size;
                } else if most.is_finite() {
                    noise = noise.min(0.95 * rms / size);
                }
            }
        }
        let mut nature = base.clone();
        let mut sizes = Vec::new();
        for (k, (effect, size)) in self.effects.iter().enumerate() {
            let (amplitude, rms) = match *size {
                Size::Value(value) => (value, self.contribution(&base, &bases, *effect, value)),
                Size::Noise(size) => self.sized(&base, &bases, *effect, largest[k], size * noise),
            };
            nature.set(*effect, amplitude);
            sizes.push(rms);
        }
        (nature, noise, sizes, bases)
    }

    /// The amplitude at which an effect contributes `target`, from one at which it contributes more: the
    /// secant in the logarithms.
    fn sized(&self, base: &Nature, bases: &[Trace], effect: Effect, from: (f64, f64), target: f64) -> (f64, f64) {
        let (mut amplitude, mut rms) = from;
        if rms == 0.0 {
            return from;
        }
        let mut power = 1.0_f64;
        for _ in 0..12 {
            if (rms / target - 1.0).abs() < 0.02 {
                break;
            }
            let next = amplitude * (target / rms).powf(1.0 / power);
            let now = self.contribution(base, bases, effect, next);
            if !(now.is_finite() && now > 0.0) {
                return from;
            }
            let slope = (now / rms).ln() / (next / amplitude).ln();
            if slope.is_finite() {
                power = slope.clamp(0.4, 3.0);
            }
            (amplitude, rms) = (next, now);
        }
        (amplitude, rms)
    }

    /// Plays set-points on the bench as it was written, and adds the log to its file, for fitting.
    pub fn play(&self, truth: &Truth, played: Played, directory: &Path) {
        let duration = played.step * (played.motion.len() - 1) as f64;
        let bench = Bench { duration, played: Some(played), ..self.clone() };
        write::add(&bench, truth, PLAYED, directory);
    }

    /// Writes bench file, catalogue and logs into a directory that exists.
    pub fn write(&self, directory: &Path) -> Truth {
        write::write(self, directory)
    }
}

/// Number of the log that is played.
const PLAYED: usize = 99;

/// Levels in both directions, each held a few seconds.
fn staircase(step: f64, duration: f64, peak: f64, random: &mut Random) -> Profile {
    let levels = 10;
    let hold = duration / f64::from(2 * levels);
    let mut segments = vec![profile::Segment { start: 0.0, level: 0.0, sines: 0.0 }];
    for k in 0..2 * levels {
        let sign = if k < levels { 1.0 } else { -1.0 };
        let level = sign * peak * (f64::from(k % levels) + random.within(0.4, 0.6)) / f64::from(levels);
        segments.push(profile::Segment { start: (f64::from(k) + 0.3) * hold, level, sines: 0.0 });
    }
    Profile::new(step, 20.0, segments, &[])
}
