//! The equations that a bench can be balanced with, one file each.

mod drive;
mod known_load;
mod torque;
mod voltage;
mod wind_up;

use super::grid::Gridded;
use super::model::{Model, Weight};
use super::motion::Motion;
use crate::answer::{Base, Target};
use crate::identify::noise::Reading;
use crate::identify::origin::{Channels, Signal};
use crate::{Bench, Channel, Declared, Log, Use, signals};
use gearwise_model::effects::Variable;

/// A parameter of the declared model.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseTerm {
    /// Which.
    pub which: Base,
    /// Declared value; `None` where the model does not say.
    pub declared: Option<f64>,
}

/// An equation that logs can be balanced with: which log takes part, and what stands on either side.
pub(super) trait Balanced: Sync {
    /// Which.
    fn target(&self) -> Target;

    /// Whether a log takes part.
    fn serves(&self, log: &Log, bench: &Bench) -> bool;

    /// Unit of the target, of an actuator that turns or of a linear axis.
    fn unit(&self, linear: bool) -> &'static str;

    /// What torque at the motor, a voltage or an angle is multiplied with to be a term of it.
    fn factor(&self, _ratio: f64) -> f64 {
        1.0
    }

    /// Parameters of the declared model, from the first log that takes part: in the order of [`Sides::base`].
    fn parameters(&self, model: &Model, declared: &Declared, log: &Log) -> Vec<BaseTerm>;

    /// How its response was read.
    fn reading(&self, seen: &Seen) -> Reading;

    /// What stands on either side; `None` where a channel is lacking.
    fn sides(&self, seen: &Seen) -> Option<Sides>;

    /// What would have to be measured for a variable not to be made of the response.
    fn shown_by(&self, variable: Variable, linear: bool) -> &'static str;
}

/// The equations, the most telling first.
const ALL: [&dyn Balanced; 4] = [&torque::Torque, &drive::Drive, &voltage::Voltage, &wind_up::WindUp];

/// The equation of a target; `None` of one that is simulated.
pub(super) fn balanced(target: Target) -> Option<&'static dyn Balanced> {
    ALL.into_iter().find(|b| b.target() == target)
}

/// Which targets a bench has, the most telling first.
pub fn targets(bench: &Bench) -> Vec<Target> {
    ALL.into_iter()
        .filter(|b| bench.logs.iter().any(|log| b.serves(log, bench) && log.usage == Use::Fit))
        .map(|b| b.target())
        .collect()
}

/// What a stretch of a log shows, whatever the equation.
pub(super) struct Seen<'a> {
    pub grid: &'a Gridded<'a>,
    pub declared: &'a Declared,
    pub model: &'a Model,
    pub moved: &'a Motion,
    /// What the target is multiplied with.
    pub gain: f64,
    pub gear_loss: f64,
    pub weight: Option<Weight>,
    pub shaft: Option<[f64; 2]>,
    pub target_lag: f64,
    pub motion_lag: f64,
    pub has_motor: bool,
    pub has_output: bool,
    pub motor_angle: Option<&'a Signal>,
    pub output_angle: Option<&'a Signal>,
    /// Angle of the output from either side.
    pub turned: Option<&'a Signal>,
    pub supply: Option<&'a Signal>,
    pub per_volt: f64,
    pub applied: Option<&'a Signal>,
    pub measured_current: Option<&'a Signal>,
    pub current: Option<&'a Signal>,
    pub sensor: Option<&'a Signal>,
}

impl Seen<'_> {
    pub fn zeros(&self) -> Vec<f64> {
        vec![0.0; self.grid.count]
    }

    /// How a channel was read, a unit of which is `scale` of the target.
    pub fn read(&self, channel: Channel, scale: f64) -> Reading {
        let values = self.grid.log.channel(channel).map_or(&[] as &[f64], |v| &v[self.grid.range.clone()]);
        let reading = Reading::new(values, scale);
        // What a driver repeats was found before.
        match self.grid.log.fresh.get(&channel) {
            Some(rows) => Reading { rows: *rows, ..reading },
            None => reading,
        }
    }

    /// How the terminal voltage was read.
    pub fn read_volts(&self) -> Reading {
        if self.grid.log.channel(Channel::Voltage).is_some() {
            return self.read(Channel::Voltage, 1.0);
        }
        let volts = self.supply.and_then(|v| signals::median(v.values.clone())).unwrap_or(0.0);
        self.read(Channel::Duty, volts * self.per_volt)
    }

    /// Torque of the motor at its shaft, less what its own inertia takes.
    pub fn motor_torque(&self, current: &Signal) -> Signal {
        let [constant, inertia] = self.shaft.unwrap_or_else(|| [self.model.torque_constant, self.inertia()]);
        current.with(&self.moved.motor_acceleration, |i, a| constant * i - inertia * a)
    }

    /// Inertia of rotor and gear; zero where it is not known.
    pub fn inertia(&self) -> f64 {
        self.model.inertia.unwrap_or(0.0)
    }
}

/// What stands on either side of an equation.
pub(super) struct Sides {
    pub response: Signal,
    /// Of each parameter of the declared model.
    pub base: Vec<Vec<f64>>,
    /// A part of the response that is known and has no parameter.
    pub known: Vec<f64>,
    /// Channels of the known load.
    pub load: Channels,
    /// Torque that the gear transmits, at the motor.
    pub transmitted: Option<Signal>,
    /// What a spring in the gear multiplies with 1/k.
    pub curvature: Option<Signal>,
}

/// Whether a log says how a shaft moves.
fn moves(log: &Log) -> bool {
    let has = |c: Channel| log.channels.contains_key(&c);
    has(Channel::MotorVelocity)
        || has(Channel::OutputVelocity)
        || has(Channel::MotorPosition)
        || has(Channel::OutputPosition)
}

/// The inertia of the declared model, or the mass of an axis.
fn inertia_term(model: &Model, declared: &Declared) -> BaseTerm {
    let which = if declared.motor.is_none() { Base::Mass } else { Base::Inertia };
    BaseTerm { which, declared: model.inertia }
}
