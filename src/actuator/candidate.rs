//! A motor and a gear for a joint, and what they can give.

use super::fitted;
use super::load::Load;
use super::shaft::{Actuator, Flow};
use super::thermal;
use super::thermal_motion::TwoNode;
use crate::catalog::convention::{Commutation, CurrentConvention};
use crate::catalog::{Gear, Motor};
use crate::requirement::{GearModel, Joint, Robot};

/// A motor and a gear for a joint, before the ratio is chosen.
#[derive(Debug, Clone, Copy)]
pub struct Candidate<'a> {
    /// The robot, for bus and surroundings.
    pub robot: &'a Robot,
    /// The joint.
    pub joint: &'a Joint,
    /// The joint's demand, made ready.
    pub load: &'a Load,
    /// The motor.
    pub motor: &'a Motor,
    /// The gear of the catalogue, where the ratio is not continuous.
    pub catalog_gear: Option<&'a Gear>,
    /// The gear's numbers.
    pub gear: GearModel,
    /// The equations of motor and gear together.
    pub actuator: Actuator,
    /// Whether load and actuator are those of one ratio, with the evaluated effects in them.
    pub folded: bool,
}

impl Candidate<'_> {
    /// Mass of motor and gear at a ratio \[kg\]; `None` where either is unknown.
    pub fn mass_at(&self, ratio: f64) -> Option<f64> {
        Some(self.motor.mass? + self.gear.mass_at(ratio)?)
    }

    /// What is known of that mass \[kg\]: the actuator weighs at least this.
    pub fn known_mass_at(&self, ratio: f64) -> f64 {
        self.motor.mass.unwrap_or(0.0) + self.gear.mass_at(ratio).unwrap_or(0.0)
    }

    /// The smaller of the motor's and the drive's largest current, q axis \[A\], and whose it is.
    pub fn peak_current(&self) -> Option<(f64, &'static str)> {
        let amplitude = match self.motor.conventions.commutation {
            Commutation::Brushless => CurrentConvention::PhaseAmplitude,
            Commutation::Brushed => CurrentConvention::Dc,
        };
        let per_ampere = amplitude.torque_current(self.motor.conventions.commutation);
        let drive = self.joint.drive_current.or(self.robot.bus.drive_current).map(|i| (i * per_ampere, "drive"));
        let motor = self.motor.peak_current.map(|i| (i, "motor"));
        match (motor, drive) {
            (Some(m), Some(d)) => Some(if d.0 < m.0 { d } else { m }),
            (m, d) => m.or(d),
        }
    }

    /// Voltage that the drive can apply, radius of the q-axis circle \[V\].
    pub fn voltage(&self) -> f64 {
        let bus = &self.robot.bus;
        let circle = bus.voltage * bus.modulation.voltage(self.motor.conventions.commutation) * bus.modulation_limit;
        (circle - self.actuator.shortfall.voltage).max(0.0)
    }

    /// Whether some effect of the motor has to be evaluated at each ratio.
    pub fn is_evaluated(&self) -> bool {
        !self.folded && fitted::evaluated(self.motor).next().is_some()
    }

    /// The candidate at one ratio, with the effects that have to be evaluated there in its samples.
    pub fn at_ratio<T>(&self, ratio: f64, look: impl FnOnce(&Candidate) -> T) -> T {
        let form = self.actuator.torque_form(Flow::Driving);
        let load = self.load.folded(|velocity, towards, acceleration| {
            fitted::folded(self.motor, form, ratio, velocity, towards, acceleration)
        });
        look(&Candidate { load: &load, actuator: self.actuator.folded(), folded: true, ..*self })
    }

    /// What part of the thermal resistance to ambient lies between winding and housing; `None` where it is not known.
    pub(super) fn share_of_winding(&self) -> Option<f64> {
        let winding = self.motor.sheet.thermal_resistance_winding_housing?.value;
        let housing = self.motor.sheet.thermal_resistance_housing_ambient?.value;
        (winding + housing > 0.0).then(|| winding / (winding + housing))
    }

    /// How much of the heat at standstill counts once more: the phase that carries two thirds of it instead of one
    /// warms over its own way to the housing by twice as much, and the housing by no more. All of it where nobody
    /// knows what part of the resistance that way has; none of a brushed motor.
    pub fn standing_share(&self) -> f64 {
        match self.motor.conventions.commutation {
            Commutation::Brushed => 0.0,
            Commutation::Brushless => self.share_of_winding().unwrap_or(1.0),
        }
    }

    /// Highest winding temperature: the lower of the motor's and the requirement's \[K\], and whose.
    pub(super) fn winding_temperature(&self) -> Option<(f64, &'static str)> {
        hottest(self.motor, self.joint)
    }

    /// The two thermal nodes, where the sheet gives both resistances and both time constants.
    pub fn two_node(&self) -> Option<TwoNode> {
        let sheet = &self.motor.sheet;
        Some(TwoNode {
            resistance_winding_housing: sheet.thermal_resistance_winding_housing?.value,
            resistance_housing_ambient: sheet.thermal_resistance_housing_ambient?.value,
            time_constant_winding: sheet.thermal_time_constant_winding?.value,
            time_constant_housing: sheet.thermal_time_constant_housing?.value,
            ambient: self.robot.ambient,
            reference: self.motor.reference_temperature,
        })
    }

    /// Rms current that heats the winding to its limit in steady state \[A\]; zero where ambient is
    /// too hot already.
    pub fn thermal_current(&self) -> Option<(f64, &'static str)> {
        let (limit, owner) = self.winding_temperature()?;
        let motor = self.motor;
        let squared = thermal::allowed_current_squared(
            limit,
            motor.resistance,
            motor.reference_temperature,
            motor.thermal_resistance?,
            self.robot.ambient,
        );
        Some((squared.max(0.0).sqrt(), owner))
    }

    /// Largest root mean square current that may flow for ever \[A\], by whatever the row tells it from: its
    /// continuous current or torque, its thermal resistances with a highest temperature. `None` where nothing does.
    pub fn steady_current(&self) -> Option<f64> {
        let of_torque = |torque: f64| match self.actuator.shortfall.saturates() {
            true => self.actuator.shortfall.current_squared(torque * torque).0.sqrt(),
            false => torque * self.actuator.rms_current_per_torque(),
        };
        let Motor { continuous_current, continuous_torque, .. } = self.motor;
        let told = [*continuous_current, continuous_torque.map(of_torque), self.thermal_current().map(|(i, _)| i)];
        told.into_iter().flatten().reduce(f64::min)
    }
}

/// Highest winding temperature: the lower of the motor's and the requirement's \[K\], and whose.
pub fn hottest(motor: &Motor, joint: &Joint) -> Option<(f64, &'static str)> {
    let motor = motor.max_winding_temperature.map(|t| (t, "motor"));
    let asked = joint.limits.winding_temperature.map(|t| (t, "requirement"));
    match (motor, asked) {
        (Some(m), Some(a)) => Some(if a.0 < m.0 { a } else { m }),
        (m, a) => m.or(a),
    }
}

/// The temperature of the winding \[K\] that voltage and power taken are judged at: the highest that motor and
/// requirement allow; where none is known that which the continuous current leads to in steady state, as no design that
/// keeps its limits is hotter. `None` where neither is known.
pub fn hot_winding(motor: &Motor, joint: &Joint, ambient: f64) -> Option<f64> {
    let rated = || {
        let (current, r_th) = (motor.continuous_current?, motor.thermal_resistance?);
        let reference = motor.reference_temperature;
        thermal::winding_temperature(current * current, motor.resistance, reference, r_th, ambient)
    };
    hottest(motor, joint).map(|(kelvin, _)| kelvin).or_else(rated)
}
