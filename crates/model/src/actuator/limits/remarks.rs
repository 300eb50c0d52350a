//! What the limits of a candidate assume.

use super::heat::STANDSTILL;
use super::limit::{Asked, Depends, Remark};
use crate::actuator::candidate::{ASSUMED, Candidate, hottest};
use crate::catalog::estimate::Estimated;
use crate::catalog::module::Inside;
use crate::catalog::{Gear, GearKind};
use crate::requirement::MotorDrag;

/// Temperature at which sheets of gears state what they lose \[K\].
const SHEETS_AT: f64 = 293.15;
/// So much colder grease is stiffer by more than a word's worth \[K\].
const COLDER: f64 = 10.0;

/// What a factor of safety below one means.
pub const LOW_SAFETY: &str =
    "the requirement's factor is below 1: the limits that it multiplies allow less than the motion asks for";

impl Candidate<'_> {
    /// What the limits that are asked of this candidate assume at every ratio.
    pub fn assumptions(&self, asked: &[Asked]) -> Vec<Remark> {
        let mut assumed = Vec::new();
        if self.joint.limits.safety < 1.0 {
            assumed.push(("safety", LOW_SAFETY));
        }
        let stated = self.joint.limits.winding_temperature.is_some();
        let heat = |asked: &&Asked| super::heat::LIMITS.iter().any(|limit| limit.name == asked.limit.name);
        // Of a module that says ratings alone neither heat nor resistance is computed.
        let says_currents = self.motor.inside.as_deref().is_none_or(Inside::says_currents);
        let is_assumed = hottest(self.motor, self.joint).1 == ASSUMED;
        if is_assumed && says_currents {
            assumed.push((
                "winding_temperature",
                "neither motor nor requirement gives a highest winding temperature: 100 degC is assumed, for heat and for the resistance that voltage is checked with",
            ));
        } else if let (true, None, Some(of_heat), false) =
            (stated, self.motor.max_winding_temperature, asked.iter().find(heat), is_assumed)
        {
            assumed.push((
                of_heat.limit.name,
                "the motor's own highest temperature is not known: only that of the requirement counts",
            ));
        }
        for estimate in &self.motor.estimates {
            assumed.push(match estimate.of {
                Estimated::ThermalResistance => (
                    "winding_temperature",
                    "estimated: the thermal resistance is that of motors built alike and as heavy, the hot end of its 90 % interval",
                ),
                Estimated::RotorInertia => (
                    "rotor_inertia",
                    "estimated: it is that of motors built alike, as heavy and as wide, the large end of its 90 % interval",
                ),
                Estimated::Inductance => (
                    "voltage",
                    "estimated: the inductance is that of motors built alike and as heavy, the large end of its 90 % interval",
                ),
                Estimated::Drag if self.drag_is_off() => continue,
                Estimated::Drag => (
                    "motor_drag",
                    "estimated: no-load current of motors of like motor constant, from above; limits hold with it and without any",
                ),
            });
        }
        for asked in asked.iter().filter(|asked| super::size::is_on_parts(asked.limit.name)) {
            if self.assumes_ideal_gear() {
                assumed.push((
                    asked.limit.name,
                    "the requirement describes no gear: only the motor counts, as if the gear had no size and no price",
                ));
            }
            if !self.joint.motors.modules.is_empty() && !self.has_drive_inside() {
                assumed.push((
                    asked.limit.name,
                    "drive not inside: no drive counts here, and one that is built into a module counts there",
                ));
            }
        }
        if self.joint.motor_drag == MotorDrag::Counted && self.motor.lacks_speed_of_drag() {
            assumed.push((
                "motor_drag",
                "the row says no speed of its no-load current: all of its drag counts as Coulomb friction, and what grows with speed may be more",
            ));
        }
        if self.other.is_some() && asked.iter().any(|a| a.limit.depends == Depends::PowerBack) {
            assumed.push((
                "regeneration",
                "the motor's drag is known between two ends only, and power that comes back is computed at these: between them a little more may come back",
            ));
        }
        if self.robot.shared_resistance().is_some() {
            assumed.push((
                "voltage",
                "here the bus sags by the power of this joint alone: what all joints draw at the same instant is judged where the whole robot is",
            ));
        }
        if self.derating() < 1.0 && self.motor.thermal_resistance.is_none() {
            assumed.push((
                "continuous_current",
                "the surroundings are hotter than 40 degC: the continuous rating is reduced by the root of the temperature rise that is left",
            ));
        }
        if self.motor.wound.is_some() {
            assumed.push((
                "turns",
                "another number of turns than that of the row, in the same copper: its resistance is within 10 % of that, to be asked of the maker",
            ));
        }
        if self.motor.saturation_current().is_some() {
            assumed.push((
                "peak_torque",
                match self.motor.sheet.peak_torque_linearity {
                    Some(_) => {
                        "the iron saturates as T = K_T i_s tanh(i/i_s), through the peak torque at the linearity that the sheet prints; regenerative power is computed with T/K_T, which is more"
                    }
                    None => {
                        "the row's peak torque is less than K_T times the current there: the iron is taken to saturate as T = K_T i_s tanh(i/i_s), through that one point; regenerative power is computed with T/K_T, which is more"
                    }
                },
            ));
        }
        if self.is_rated() {
            assumed.push((
                "winding_temperature",
                match self.motor.max_winding_temperature {
                    Some(_) => {
                        "estimated: the thermal resistance is computed from the continuous rating, at the row's own highest temperature"
                    }
                    None => {
                        "estimated: the thermal resistance is computed from the continuous rating, as if the maker's highest temperature were 155 degC"
                    }
                },
            ));
        }
        let split = self.motor.sheet.thermal_resistance_winding_housing.is_some();
        if self.is_mounted() && !split && self.thermal_resistance().is_some() {
            assumed.push((
                "winding_temperature",
                "the row does not say what part of its thermal resistance is the winding's own: all of it is added to that of the mount",
            ));
        }
        if self.catalog_gear.is_some_and(Gear::loss_is_in_efficiency) {
            assumed.push((
                "gear_friction",
                "the gear's row does not say at which load its efficiency holds: the efficiency counts for all of the gear's loss, and its starting torque for backdriving alone",
            ));
        }
        let greased = |gear: &Gear| {
            let loses = gear.efficiency.is_some_and(|efficiency| efficiency < 1.0) || gear.friction_at_rest().is_some();
            loses && !matches!(gear.kind, GearKind::Direct | GearKind::Belt)
        };
        if self.catalog_gear.is_some_and(greased) && self.robot.ambient < SHEETS_AT - COLDER {
            assumed.push((
                "gear_friction",
                "the gear's efficiency and its torque without load are those of its sheet, at some 20 degC: colder grease is stiffer, and takes more (one maker prints 71 % at 20 degC and 54 % at 0 degC, at 1000 rpm)",
            ));
        }
        if asked.iter().any(|a| a.limit.name == STANDSTILL) && self.share_of_winding().is_none() {
            assumed.push((
                STANDSTILL,
                "which part of the thermal resistance is the winding's own is not known: all of it counts as the winding's",
            ));
        }
        assumed
    }
}
