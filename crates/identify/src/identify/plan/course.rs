//! A run as the model expects it: from passages to set-points and to the log that it would leave.

use std::collections::{BTreeMap, BTreeSet};

use super::facts::SetPoint;
use super::passage::Passage;
use crate::bench::volts_per_duty;
use crate::{Bench, Channel, Log, Use, signals};
use gearwise_model::effects::{Equation, FittedEffect, Operating};

/// What moves, as far as the logs say.
#[derive(Debug, Clone)]
pub struct Expected {
    /// Torque constant \[N·m/A\] (force gain of a linear axis).
    pub constant: f64,
    /// Back-EMF constant \[V·s/rad\].
    pub back_emf: f64,
    /// Resistance \[Ω\].
    pub resistance: f64,
    /// Inertia of rotor and gear \[kg·m²\].
    pub inertia: f64,
    /// Ratio.
    pub ratio: f64,
    /// Effects of the torque equation, with their values.
    pub drag: Vec<FittedEffect>,
    /// Whether the drive moves a known load itself, so that its current follows from the motion.
    pub is_free: bool,
    /// Inertia and weight of that load.
    pub load: (f64, f64),
}

/// What a log of the bench is like: its channels, and temperatures that stay as they usually were.
#[derive(Debug, Clone)]
pub struct Like {
    empty: Log,
    usual: BTreeMap<Channel, f64>,
    /// Supply voltage \[V\], where it is known.
    supply: Option<f64>,
    /// Quadrature voltage per volt of duty times supply.
    per_volt: f64,
}

impl Like {
    /// As one of its logs.
    pub fn of(log: &Log, bench: &Bench) -> Like {
        let usual: BTreeMap<Channel, f64> =
            log.channels.iter().map(|(c, values)| (*c, signals::median(values.clone()).unwrap_or(0.0))).collect();
        let supply = usual.get(&Channel::Supply).copied().or(log.controller.and_then(|c| c.supply));
        let empty = Log {
            name: "plan".into(),
            file: String::new(),
            hash: String::new(),
            kind: log.kind,
            usage: Use::Fit,
            load: log.load,
            controller: log.controller,
            rotor: log.rotor,
            difference: None,
            gains: BTreeMap::new(),
            held: BTreeSet::new(),
            estimated: log.estimated.clone(),
            excluded: Vec::new(),
            fresh: BTreeMap::new(),
            from_motor: log.from_motor.clone(),
            band: None,
            time: Vec::new(),
            channels: BTreeMap::new(),
            remarks: Vec::new(),
        };
        Like { empty, usual, supply, per_volt: bench.declared.motor.as_ref().map_or(1.0, volts_per_duty) }
    }
}

/// A run.
#[derive(Debug, Clone)]
pub struct Course<'a> {
    /// Its passages.
    pub passages: &'a [Passage],
    /// How long each of them is \[s\].
    pub each: f64,
    /// What is expected of the machine.
    pub expected: &'a Expected,
    /// Where the output stands in the middle of its travel \[rad\].
    pub middle: f64,
}

impl Expected {
    /// Current and torque at the output at an operating point of the motor.
    fn answer(&self, speed: f64, angle: f64, acceleration: f64, commanded: f64) -> (f64, f64) {
        let output = angle / self.ratio;
        let load = self.load.0 * acceleration / self.ratio + self.load.1 * output.sin();
        let carried =
            if self.is_free { load / self.ratio } else { self.constant * commanded - self.inertia * acceleration };
        let at = Operating {
            speed,
            direction: if speed == 0.0 { 0.0 } else { speed.signum() },
            angle,
            output_angle: output,
            current: commanded,
            torque: carried,
            torque_curvature: 0.0,
            winding_rise: 0.0,
            housing_rise: 0.0,
            duty: 0.0,
        };
        let drag: f64 = self
            .drag
            .iter()
            .filter(|e| e.effect.acts_on() == Equation::Torque)
            .map(|e| e.effect.value(&e.values, &at))
            .filter(|v| v.is_finite())
            .sum();
        if self.is_free {
            ((self.inertia * acceleration + carried + drag) / self.constant, load)
        } else {
            (commanded, self.ratio * (carried - drag))
        }
    }
}

impl Course<'_> {
    /// How long it is \[s\].
    pub fn duration(&self) -> f64 {
        self.each * self.passages.len() as f64
    }

    /// Set-points at even times \[s\], with the acceleration of the motor \[rad/s²\] of each.
    pub fn points(&self, step: f64) -> Vec<(SetPoint, f64)> {
        let count = (self.duration() / step).round() as usize + 1;
        let travel = self.passages.iter().map(|p| p.travel(self.each)).fold(0.0, f64::max);
        let start = self.expected.ratio * self.middle - 0.5 * travel;
        let (mut angle, mut last, mut before) = (start, 0.0, usize::MAX);
        (0..count)
            .map(|k| {
                let time = k as f64 * step;
                let share = time / self.each;
                let at = (share.floor() as usize).min(self.passages.len().saturating_sub(1));
                let now = self.passages[at].at((share - at as f64).min(1.0), self.each);
                if at != before {
                    // Each passage begins where all of them do.
                    angle = start + 0.5 * now.speed * (time - at as f64 * self.each);
                    before = at;
                } else {
                    angle += 0.5 * step * (last + now.speed);
                }
                last = now.speed;
                let (current, torque) = self.expected.answer(now.speed, angle, now.acceleration, now.current);
                (SetPoint { time, speed: now.speed, angle, current, torque }, now.acceleration)
            })
            .collect()
    }

    /// The log that it would leave on a bench, at even times \[s\].
    pub fn log(&self, like: &Like, step: f64) -> Log {
        let points = self.points(step);
        let supply = like.supply.unwrap_or(1.0);
        let per_volt = supply * like.per_volt;
        let (e, ratio) = (self.expected, self.expected.ratio);
        let volts = |p: &SetPoint| e.resistance * p.current + e.back_emf * p.speed;
        let column = |channel: Channel, usual: f64| -> Vec<f64> {
            let of = |(p, acceleration): &(SetPoint, f64)| match channel {
                Channel::Current => p.current,
                Channel::Voltage => volts(p),
                Channel::MotorPosition => p.angle,
                Channel::MotorVelocity => p.speed,
                Channel::OutputPosition | Channel::Goal => p.angle / ratio,
                Channel::OutputVelocity => p.speed / ratio,
                Channel::OutputAcceleration => acceleration / ratio,
                Channel::Torque | Channel::Command => p.torque,
                Channel::Duty => volts(p) / per_volt,
                Channel::Supply => supply,
                Channel::BusCurrent
                | Channel::WindingTemperature
                | Channel::HousingTemperature
                | Channel::LoadTorque => usual,
            };
            points.iter().map(of).collect()
        };
        Log {
            time: points.iter().map(|(p, _)| p.time).collect(),
            channels: like.usual.iter().map(|(channel, usual)| (*channel, column(*channel, *usual))).collect(),
            ..like.empty.clone()
        }
    }
}
