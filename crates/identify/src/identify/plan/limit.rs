//! Within which limits a run is planned: of the declared motor where its row says them, of what the logs reached elsewhere.

use std::f64::consts::TAU;

use super::facts::{Limit, Quantity, Source, Wanted};
use super::passage::Bounds;
use crate::bench::volts_per_duty;
use crate::{Bench, Channel, Log, Use, signals};
use gearwise_model::actuator::thermal::resistance_factor;
use gearwise_model::catalog::REFERENCE_TEMPERATURE;

/// A speed this many times its noise is told from rest.
const TOLD: f64 = 6.0;
/// A driving machine reaches the largest speed in this time \[s\], if the logs do not show that it is quicker.
const GENTLE: f64 = 0.5;

/// What may be reached.
#[derive(Debug, Clone)]
pub struct Limits {
    /// Each limit; what the plan uses of it is filled in later.
    pub list: Vec<Limit>,
    /// Where the output stands in the middle of what the logs reached \[rad\].
    pub middle: f64,
    /// Slowest speed of the motor that is told from rest \[rad/s\].
    pub slowest: f64,
}

/// Largest finite value without the last half per cent.
fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    signals::quantile(values.map(f64::abs).collect(), 0.995)
}

/// Values of a channel that brings a motor's value by a factor.
fn at_motor(log: &Log, motor: Channel, output: Channel, ratio: f64) -> Option<Vec<f64>> {
    let own = log.channel(motor).map(<[f64]>::to_vec);
    own.or_else(|| log.channel(output).map(|v| v.iter().map(|v| v * ratio).collect()))
}

/// Speed of the motor in a log.
fn speed(log: &Log, ratio: f64) -> Option<Vec<f64>> {
    at_motor(log, Channel::MotorVelocity, Channel::OutputVelocity, ratio).or_else(|| {
        let angle = angle(log, ratio)?;
        let step = signals::median_step(&log.time);
        (step > 0.0).then(|| {
            // Over some samples, so that the encoder's steps are no speed.
            let over = signals::covering(0.02 / step);
            (0..angle.len().saturating_sub(over)).map(|k| (angle[k + over] - angle[k]) / (over as f64 * step)).collect()
        })
    })
}

/// Angle of the motor in a log.
fn angle(log: &Log, ratio: f64) -> Option<Vec<f64>> {
    at_motor(log, Channel::MotorPosition, Channel::OutputPosition, ratio).map(|v| signals::unwrapped(&v))
}

impl Limits {
    /// Of the logs for fitting and the declared motor. `moves` and `loads` say what the bench is told, `is_driven` whether another
    /// machine moves it, so that it takes no current.
    pub fn of(bench: &Bench, wanted: &Wanted, moves: bool, loads: bool, is_driven: bool) -> Option<Limits> {
        let declared = &bench.declared;
        let ratio = declared.ratio;
        let logs: Vec<&Log> = bench.logs.iter().filter(|l| l.usage == Use::Fit && !l.is_empty()).collect();
        let mut list = Vec::new();
        let (mut middle, mut slowest) = (0.0, 0.0_f64);
        let mut limit = |of, most: Option<f64>, source| {
            list.extend(most.filter(|m| m.is_finite() && *m > 0.0).map(|most| Limit { of, most, source, used: 0.0 }));
        };
        let motor = declared.motor.as_ref();
        if moves {
            let speeds: Vec<Vec<f64>> = logs.iter().filter_map(|l| speed(l, ratio)).collect();
            let reached = largest(speeds.iter().flatten().copied());
            let rated = motor.and_then(|m| m.max_speed);
            match rated {
                Some(most) => limit(Quantity::Speed, Some(most), Source::Declared("max_speed")),
                None => limit(Quantity::Speed, reached, Source::Reached),
            }
            slowest =
                speeds.iter().map(|w| TOLD * signals::noise_level(w)).filter(|v| v.is_finite()).fold(0.0, f64::max);
            let most = rated.or(reached)?;
            if is_driven {
                let steep = logs.iter().zip(&speeds).filter_map(|(l, w)| {
                    let step = signals::median_step(&l.time);
                    let over = signals::covering(0.05 / step.max(f64::MIN_POSITIVE)).max(1);
                    let slope = |k: usize| (w[k + over] - w[k]) / (over as f64 * step);
                    largest((0..w.len().saturating_sub(over)).map(slope)).filter(|a| a.is_finite())
                });
                match steep.fold(0.0, f64::max) {
                    reached if reached > most / GENTLE => limit(Quantity::Acceleration, Some(reached), Source::Reached),
                    _ => limit(Quantity::Acceleration, Some(most / GENTLE), Source::Assumed),
                }
            }
            let (travel, place) = travel(&logs, ratio);
            middle = place;
            match wanted.travel {
                Some(asked) => limit(Quantity::Angle, Some(asked), Source::Asked),
                None => limit(Quantity::Angle, travel, Source::Reached),
            }
        }
        if loads || (moves && !is_driven) {
            let constant = motor.map_or(declared.force_gain, |m| m.torque_constant);
            let currents = |log: &&Log| log.channel(Channel::Current).map(<[f64]>::to_vec);
            let reached = largest(logs.iter().filter_map(currents).flatten());
            let by_torque = motor.and_then(|m| m.peak_torque).map(|t| (t, "peak_torque"));
            let by_current = motor.and_then(|m| m.peak_current).map(|i| (constant * i, "peak_current"));
            let magnets =
                motor.and_then(|m| m.demagnetization_current).map(|i| (constant * i, "demagnetization_current"));
            match [by_current, by_torque, magnets].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((most, column)) => limit(Quantity::Torque, Some(most), Source::Declared(column)),
                None => limit(Quantity::Torque, reached.map(|i| constant * i), Source::Reached),
            }
            match rating(bench) {
                Some((most, column)) => limit(Quantity::Heat, Some(most), Source::Declared(column)),
                None => {
                    let mean_square = |log: &&Log| {
                        let values = log.channel(Channel::Current)?;
                        let finite = values.iter().filter(|v| v.is_finite());
                        let count = finite.clone().count();
                        (count > 0).then(|| (finite.map(|v| v * v).sum::<f64>() / count as f64).sqrt())
                    };
                    let most = logs.iter().filter_map(mean_square).fold(0.0, f64::max);
                    limit(Quantity::Heat, Some(most), Source::Reached);
                }
            }
        }
        let supply = logs.iter().filter_map(|l| {
            let measured = l.channel(Channel::Supply).and_then(|v| signals::median(v.to_vec()));
            measured.or(l.controller.and_then(|c| c.supply))
        });
        if let (Some(volts), Some(motor)) = (supply.reduce(f64::min), motor)
            && moves
            && !is_driven
        {
            limit(Quantity::Voltage, Some(volts * volts_per_duty(motor)), Source::Declared("supply"));
        }
        let limits = Limits { list, middle, slowest };
        let needed = |of: Quantity, is: bool| !is || limits.most(of).is_some();
        let has_all = needed(Quantity::Speed, moves)
            && needed(Quantity::Angle, moves)
            && needed(Quantity::Torque, loads)
            && needed(Quantity::Heat, loads);
        has_all.then_some(limits)
    }

    /// The most that is allowed of a quantity; `None` where it is no limit of this bench.
    pub fn most(&self, of: Quantity) -> Option<f64> {
        self.list.iter().find(|l| l.of == of).map(|l| l.most)
    }

    /// What passages may reach.
    pub fn bounds(&self, ratio: f64, constant: f64) -> Bounds {
        let most = |of: Quantity| self.most(of).unwrap_or(f64::INFINITY);
        Bounds {
            speed: most(Quantity::Speed),
            slowest: self.slowest,
            acceleration: most(Quantity::Acceleration),
            travel: ratio * most(Quantity::Angle),
            current: most(Quantity::Torque) / constant,
            heating: most(Quantity::Heat),
        }
    }
}

/// Current that can flow for ever \[A\], and the column that says so.
fn rating(bench: &Bench) -> Option<(f64, &'static str)> {
    let motor = bench.declared.motor.as_ref()?;
    let by_current = motor.continuous_current.map(|i| (i, "continuous_current"));
    let by_torque = motor.continuous_torque.map(|t| (t / motor.torque_constant, "continuous_torque"));
    let by_heat = || {
        let ambient = bench.readings.ambient.unwrap_or(REFERENCE_TEMPERATURE);
        let (resistance, hottest) = (motor.thermal_resistance?, motor.max_winding_temperature?);
        let hot = motor.resistance * resistance_factor(hottest, motor.reference_temperature);
        (hottest > ambient).then(|| (((hottest - ambient) / (resistance * hot)).sqrt(), "thermal_resistance"))
    };
    [by_current, by_torque].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0)).or_else(by_heat)
}

/// How far the output went in the log that went furthest, and the middle of that \[rad\]; a speed alone is integrated, and says
/// nothing of where.
fn travel(logs: &[&Log], ratio: f64) -> (Option<f64>, f64) {
    let mut most: Option<(f64, f64)> = None;
    for log in logs {
        let path = angle(log, ratio).map(|a| (a, true)).or_else(|| {
            let speed = speed(log, ratio)?;
            let step = signals::median_step(&log.time);
            Some((signals::integral(&speed, step), false))
        });
        let Some((path, has_place)) = path else { continue };
        let finite = || path.iter().copied().filter(|v| v.is_finite()).map(|v| v / ratio);
        let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        if high > low && most.is_none_or(|(length, _)| length < high - low) {
            // What turns has no middle.
            let has_place = has_place && high - low < TAU;
            most = Some((high - low, if has_place { 0.5 * (low + high) } else { 0.0 }));
        }
    }
    (most.map(|m| m.0), most.map_or(0.0, |m| m.1))
}
