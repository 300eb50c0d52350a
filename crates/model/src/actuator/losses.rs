//! Where the power goes that a joint draws and does not give to its load.
//!
//! The one idea: mean power from the bus is mean power at the output plus a sum of parts, each of them not negative at any
//! sample: copper, the motor's drag, the gear under load and without, the drive. All but the drive's efficiency are sums
//! of second moments of the motion, that is polynomials in the ratio; what the drive's efficiency takes depends on which
//! samples draw and which give back, and is looked at there.

use super::candidate::Candidate;
use super::load::Load;
use super::shaft::{Actuator, Feature, ShaftForm};
use crate::numerics::laurent::Laurent;

/// Mean losses over the motion \[W\], by where they are.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Losses {
    /// In the motor's copper, at the reference temperature: R mean(i²).
    pub copper: f64,
    /// Bearings, hysteresis and eddy currents of the motor: mean of its drag torque times its speed.
    pub motor_drag: f64,
    /// What the gear's efficiency takes of the power that goes through it.
    pub gear_load: f64,
    /// What the gear takes without load.
    pub gear_no_load: f64,
    /// In the drive: its resistance, its standby power, and what its efficiency takes of what is drawn and given back.
    pub drive: f64,
    /// Of what reaches the bus, what is not kept: in a braking resistor, or in the supply.
    pub braking: f64,
}

impl Losses {
    /// Nobody knows any of them.
    pub const UNKNOWN: Losses = Losses {
        copper: f64::NAN,
        motor_drag: f64::NAN,
        gear_load: f64::NAN,
        gear_no_load: f64::NAN,
        drive: f64::NAN,
        braking: f64::NAN,
    };

    /// Keys and values, in the order from the motor's copper to the drive.
    pub fn parts(&self) -> [(&'static str, f64); 6] {
        [
            ("copper", self.copper),
            ("motor_drag", self.motor_drag),
            ("gear_load", self.gear_load),
            ("gear_no_load", self.gear_no_load),
            ("drive", self.drive),
            ("braking", self.braking),
        ]
    }

    /// Their sum \[W\].
    pub fn total(&self) -> f64 {
        self.parts().iter().map(|(_, watts)| watts).sum()
    }
}

/// The parts that are polynomials in the ratio: all but the heat of the current, in copper, leads and drive.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LossTerms {
    /// [`Losses::motor_drag`].
    pub motor_drag: Laurent,
    /// [`Losses::gear_load`].
    pub gear_load: Laurent,
    /// [`Losses::gear_no_load`].
    pub gear_no_load: Laurent,
    /// The drive's standby power.
    pub standby: Laurent,
}

impl LossTerms {
    /// The terms of an actuator that carries a load, with the drive's standby power \[W\].
    pub fn new(load: &Load, actuator: &Actuator, standby: f64) -> LossTerms {
        let power = |form: &ShaftForm| load.mean_shaft_power(|_| *form);
        let through = |flow| ShaftForm::of(Feature::Load, actuator.torque_form(flow)[Feature::Load] - 1.0);
        LossTerms {
            motor_drag: power(actuator.drag_form()),
            gear_load: load.gear_loss().unwrap_or_else(|| load.mean_shaft_power(through)),
            gear_no_load: power(actuator.gear_drag_form()),
            standby: Laurent::constant(standby),
        }
    }

    /// Their sum.
    pub fn sum(&self) -> Laurent {
        self.motor_drag + self.gear_load + self.gear_no_load + self.standby
    }
}

/// A part of the loss of which nothing is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnknownLoss {
    /// The motor's drag: its row gives neither no-load current nor friction, and it is not estimated.
    MotorDrag,
    /// The motor's drag, because the requirement turned it off.
    MotorDragOff,
    /// The gear: the requirement says no efficiency.
    Gear,
    /// The drive: the requirement says neither efficiency nor resistance.
    Drive,
}

impl UnknownLoss {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            UnknownLoss::MotorDrag => "motor drag (no no-load current)",
            UnknownLoss::MotorDragOff => "motor drag (off)",
            UnknownLoss::Gear => "gear (no efficiency)",
            UnknownLoss::Drive => "drive",
        }
    }
}

impl Candidate<'_> {
    /// The parts of the loss of which nothing is known.
    pub fn unknown_losses(&self) -> Vec<UnknownLoss> {
        let mut unknown = Vec::new();
        if self.drag_is_off() {
            unknown.push(UnknownLoss::MotorDragOff);
        } else if self.drag_is_unknown() {
            unknown.push(UnknownLoss::MotorDrag);
        }
        let of_module =
            self.motor.inside.as_deref().is_some_and(|inside| inside.says_currents() && !inside.says_loss());
        if of_module || self.catalog_gear.is_none() && !self.joint.gear.says_loss {
            unknown.push(UnknownLoss::Gear);
        }
        if !self.robot.bus.says_drive_loss && self.joint.drive.says_nothing() {
            unknown.push(UnknownLoss::Drive);
        }
        unknown
    }
}
