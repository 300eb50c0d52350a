//! One stretch of a log, brought to the numbers of one equation.

use super::grid::{Gridded, Signs};
use super::model::{Model, Weight};
use super::motion::{Motion, motion};
use super::targets::{Balanced, Seen};
use crate::answer::Target;
use crate::bench::volts_per_duty;
use crate::identify::noise::Reading;
use crate::identify::origin::{Channels, Origins, Signal};
use crate::signals::LowPass;
use crate::{BenchKind, Channel, Declared, Use};
use gearwise_model::effects::Operating;

/// Corrections of the measurement that are applied before anything is compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Corrections {
    /// How late the target is \[s\].
    pub target_lag: f64,
    /// How late position and velocity are \[s\].
    pub motion_lag: f64,
    /// What each log's target is multiplied with.
    pub gains: Vec<f64>,
    /// Signs of each log's channels but the target.
    pub signs: Vec<Signs>,
    /// Load-dependent loss of the gear as far as it is known: what the transmitted torque follows with from
    /// the motor's.
    pub gear_loss: f64,
    /// A load that was fitted, where none is known: it is what the gear transmits.
    pub weight: Option<Weight>,
    /// Torque constant and inertia of the motor as they were fitted; `None` for the declared ones.
    pub shaft: Option<[f64; 2]>,
}

impl Corrections {
    /// None.
    pub fn none(logs: usize) -> Corrections {
        Corrections {
            target_lag: 0.0,
            motion_lag: 0.0,
            gains: vec![1.0; logs],
            signs: vec![Signs::DECLARED; logs],
            gear_loss: 0.0,
            weight: None,
            shaft: None,
        }
    }
}

/// One stretch of a log on an even grid, before the filter.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    pub log: usize,
    /// Whether its log is for fitting.
    pub fits: bool,
    /// When it begins, from the beginning of its log \[s\].
    pub start: f64,
    pub step: f64,
    /// Time between fresh values of the slowest channel \[s\].
    pub fresh: f64,
    /// The widest band that the log allows \[Hz\], where what was computed of it has one.
    pub widest: f64,
    pub target: Vec<f64>,
    pub base: Vec<Vec<f64>>,
    /// A part of the target that is known and has no parameter.
    pub known: Vec<f64>,
    pub points: Vec<Operating>,
    pub origins: Origins,
    pub reading: Reading,
    pub acceleration: Vec<f64>,
    /// Samples that are no data.
    pub excluded: Vec<bool>,
    pub filter: Option<LowPass>,
    pub keep: Vec<usize>,
}

/// One stretch of a log as an equation sees it; `None` where it lacks a channel.
pub(super) fn stretch(
    grid: &Gridded,
    index: usize,
    balanced: &dyn Balanced,
    declared: &Declared,
    model: &Model,
    corrections: &Corrections,
    gain: f64,
) -> Option<Stretch> {
    let target = balanced.target();
    let n = grid.count;
    let ratio = declared.ratio;
    let lag = corrections.motion_lag;
    let log = grid.log;
    let moved = motion(grid, ratio, lag);
    if moved.is_none() && log.kind != BenchKind::Stall {
        return None;
    }
    let moved = moved.unwrap_or_else(|| Motion::none(n));
    let (has_motor, has_output) = (
        log.channel(Channel::MotorVelocity).or(log.channel(Channel::MotorPosition)).is_some(),
        log.channel(Channel::OutputVelocity).or(log.channel(Channel::OutputPosition)).is_some(),
    );
    let motor_angle = grid.shifted(Channel::MotorPosition, lag);
    let output_angle = grid.shifted(Channel::OutputPosition, lag);
    let angle = motor_angle.clone().or_else(|| output_angle.as_ref().map(|o| o.map(|q| q * ratio)));
    let out_angle = output_angle.clone().or_else(|| motor_angle.as_ref().map(|m| m.map(|q| q / ratio)));
    let declared_supply = || log.controller.and_then(|c| c.supply).map(|v| Signal::constant(v, n));
    let supply = grid.get(Channel::Supply).or_else(declared_supply);
    let duty = grid.get(Channel::Duty);
    let per_volt = declared.motor.as_ref().map_or(1.0, volts_per_duty);
    let applied: Option<Signal> = grid.get(Channel::Voltage).or_else(|| {
        let (d, v) = (duty.as_ref()?, supply.as_ref()?);
        Some(d.with(v, |d, v| d * v * per_volt))
    });
    let measured_current = grid.get(Channel::Current);
    let of_voltage = || {
        let v = applied.as_ref()?;
        Some(v.with(&moved.motor, |v, w| (v - model.back_emf * w) / model.resistance))
    };
    let current: Option<Signal> = measured_current.clone().or_else(|| match (log.kind, target) {
        // Driven from outside with open terminals: what voltage and speed differ by is no current.
        (BenchKind::Backdrive, Target::Voltage) => Some(Signal::constant(0.0, n)),
        (BenchKind::Backdrive, _) => None,
        _ => of_voltage(),
    });
    let rise = |c| grid.get(c).map(|t| t.map(|t| t - model.reference));
    let winding = rise(Channel::WindingTemperature);
    let housing = rise(Channel::HousingTemperature).or_else(|| winding.clone());
    // The driver's estimate is made of its current.
    let estimate = if log.estimated.contains(&Channel::Torque) { Channel::Current.into() } else { Channels::NONE };
    let sensor = grid.shifted(Channel::Torque, corrections.target_lag).map(|s| s.made_of(estimate));
    let made_of = |s: &Option<Signal>| s.as_ref().map_or(Channels::NONE, |s| s.made_of);
    let seen = Seen {
        grid,
        declared,
        model,
        moved: &moved,
        gain,
        gear_loss: corrections.gear_loss,
        weight: corrections.weight,
        shaft: corrections.shaft,
        target_lag: corrections.target_lag,
        motion_lag: lag,
        has_motor,
        has_output,
        motor_angle: motor_angle.as_ref(),
        output_angle: output_angle.as_ref(),
        turned: out_angle.as_ref(),
        supply: supply.as_ref(),
        per_volt,
        applied: applied.as_ref(),
        measured_current: measured_current.as_ref(),
        current: current.as_ref(),
        sensor: sensor.as_ref(),
    };
    let reading = balanced.reading(&seen);
    let sides = balanced.sides(&seen)?;
    let origins = Origins {
        response: sides.response.made_of,
        load: sides.load,
        speed: moved.motor.made_of,
        angle: made_of(&angle),
        output_angle: made_of(&out_angle),
        current: made_of(&current),
        torque: made_of(&sides.transmitted),
        curvature: made_of(&sides.curvature),
        winding: made_of(&winding),
        housing: made_of(&housing),
        duty: made_of(&duty),
    };
    let pick = |s: Option<Signal>| s.map_or_else(|| vec![f64::NAN; n], |s| s.values);
    let (angle, out_angle, current) = (pick(angle), pick(out_angle), pick(current));
    let (transmitted, curvature) = (pick(sides.transmitted), pick(sides.curvature));
    let (winding, housing, duty) = (pick(winding), pick(housing), pick(duty));
    let points = (0..n)
        .map(|k| Operating {
            speed: moved.motor.values[k],
            direction: moved.direction[k],
            angle: angle[k],
            output_angle: out_angle[k],
            current: current[k],
            torque: transmitted[k],
            torque_curvature: curvature[k],
            winding_rise: winding[k],
            housing_rise: housing[k],
            duty: duty[k],
        })
        .collect();
    Some(Stretch {
        log: index,
        fits: log.usage == Use::Fit,
        start: if grid.step > 0.0 { grid.start - log.time[0] } else { 0.0 },
        step: grid.step,
        fresh: grid.step * log.fresh.values().copied().fold(1.0, f64::max),
        widest: log.band.unwrap_or(f64::INFINITY),
        target: sides.response.values,
        base: sides.base,
        known: sides.known,
        points,
        origins,
        reading,
        acceleration: moved.motor_acceleration.values,
        excluded: grid.excluded(),
        filter: None,
        keep: Vec::new(),
    })
}
